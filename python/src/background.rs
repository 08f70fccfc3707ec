//! Long work beside the interpreter.

use pyo3::prelude::*;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// Runs work on a thread of its own, without the interpreter's lock, until it is done or Ctrl-C comes. Work cannot be broken off:
/// after Ctrl-C it runs on unheard, and what it makes is dropped.
pub(crate) fn run<T: Send + 'static>(py: Python<'_>, work: impl FnOnce() -> T + Send + 'static) -> PyResult<T> {
    const LOOK_UP: Duration = Duration::from_millis(50);
    let (done, result) = channel();
    let thread = std::thread::Builder::new().name("satseed".into()).spawn(move || {
        // An error means that nobody waits any more.
        let _ = done.send(work());
    });
    thread.map_err(|e| crate::GenerateError::new_err(format!("cannot start a thread: {e}")))?;
    let result = std::sync::Mutex::new(result);
    loop {
        // Nobody else locks it: it is there since a receiver may not be shared, which the lock's release asks for.
        let received = py.detach(|| result.lock().ok().map(|r| r.recv_timeout(LOOK_UP)));
        match received {
            Some(Ok(made)) => return Ok(made),
            Some(Err(RecvTimeoutError::Timeout)) => py.check_signals()?,
            Some(Err(RecvTimeoutError::Disconnected)) | None => {
                return Err(crate::GenerateError::new_err("the work panicked: this is a bug in satseed"));
            }
        }
    }
}
