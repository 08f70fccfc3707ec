//! Blocks that are known, up to a bound.

use super::block::Block;
use super::lattice::BlockKey;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Maps, so that threads seldom wait for each other.
const SHELVES: usize = 64;

type Shelf = Mutex<BTreeMap<BlockKey, Arc<Block>>>;

/// A map from keys to blocks that many threads fill.
#[derive(Debug)]
pub(super) struct Store {
    shelves: Vec<Shelf>,
    most_on_a_shelf: usize,
}

impl Store {
    pub(super) fn new(most_bytes: usize) -> Self {
        let shelves = (0..SHELVES).map(|_| Mutex::default()).collect();
        Self { shelves, most_on_a_shelf: most_bytes / Block::MOST_BYTES / SHELVES }
    }

    /// The block of a key, made now where it is not known. Two threads may make the same one at once: they make the same.
    pub(super) fn get(&self, key: BlockKey, make: impl FnOnce() -> Block) -> Arc<Block> {
        let shelf = &self.shelves[key.spread() % SHELVES];
        let lock = || shelf.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(block) = lock().get(&key) {
            return Arc::clone(block);
        }
        let made = Arc::new(make());
        let mut known = lock();
        if known.len() < self.most_on_a_shelf {
            known.insert(key, Arc::clone(&made));
        }
        made
    }
}
