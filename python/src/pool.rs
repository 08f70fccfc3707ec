//! Threads that outlive the scenes they work for.
//!
//! The system's allocator gives threads heaps of their own and keeps what was once in them: a pool for each scene would
//! leave its memory in ever other heaps, so that a long stream holds more than any of its scenes needs.

use rayon::ThreadPool;
use satseed::pipeline::{PipelineError, thread_pool};
use std::sync::{Arc, Mutex, PoisonError};

/// What pools are asked for by: their process, since a forked child has none of its parent's threads, and their size.
type Key = (u32, usize);

/// Pools that no scene holds. Touched under the interpreter's lock alone, under which processes fork too: no child finds it
/// locked.
static IDLE: Mutex<Vec<(Key, Arc<ThreadPool>)>> = Mutex::new(Vec::new());

/// A pool of one scene's own until it is dropped.
pub(crate) struct Lease {
    key: Key,
    pub(crate) pool: Arc<ThreadPool>,
}

impl Lease {
    /// A pool of `threads` threads: an idle one, or a new one where there is none.
    pub(crate) fn new(threads: usize) -> Result<Self, PipelineError> {
        let key = (std::process::id(), threads);
        let mut idle = IDLE.lock().unwrap_or_else(PoisonError::into_inner);
        let known = idle.iter().position(|(k, _)| *k == key).map(|at| idle.swap_remove(at).1);
        drop(idle);
        let pool = known.map_or_else(|| thread_pool(threads).map(Arc::new), Ok)?;
        Ok(Self { key, pool })
    }
}

impl Drop for Lease {
    fn drop(&mut self) {
        // Work that Ctrl-C left behind goes on: its pool is nobody's any more.
        if Arc::strong_count(&self.pool) == 1 {
            IDLE.lock().unwrap_or_else(PoisonError::into_inner).push((self.key, Arc::clone(&self.pool)));
        }
    }
}
