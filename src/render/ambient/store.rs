//! Blocks that are known, up to a bound.

use super::block::{Block, Node, Places};
use super::lattice::BlockKey;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

/// Parts with a lock each, so that threads seldom wait for each other.
const SHELVES: usize = 64;

/// A map from keys to blocks that many threads fill.
#[derive(Debug)]
pub(super) struct Store {
    shelves: Vec<Mutex<Shelf>>,
    most_nodes_on_a_shelf: usize,
}

/// Blocks one after the other: blocks of their own, made between the short-lived lists of rays, would leave the heap in
/// shreds.
#[derive(Debug, Default)]
struct Shelf {
    blocks: BTreeMap<BlockKey, (usize, usize, Places)>,
    nodes: Vec<Node>,
}

impl Store {
    /// Bytes of a node, with room for a list that doubles, and of a block: there are no more blocks than nodes may be.
    pub(super) const BYTES_OF_A_NODE: usize = 2 * size_of::<Node>() + 96;

    pub(super) fn new(most_bytes: usize) -> Self {
        let shelves = (0..SHELVES).map(|_| Mutex::default()).collect();
        Self { shelves, most_nodes_on_a_shelf: most_bytes / Self::BYTES_OF_A_NODE / SHELVES }
    }

    /// The block of a key, made now where it is not known. Two threads may make the same one at once: they make the same.
    pub(super) fn get(&self, key: BlockKey, make: impl FnOnce() -> Block) -> Block {
        let shelf = &self.shelves[key.spread() % SHELVES];
        let lock = || shelf.lock().unwrap_or_else(PoisonError::into_inner);
        {
            let known = lock();
            if let Some((from, to, places)) = known.blocks.get(&key) {
                return Block { nodes: known.nodes[*from..*to].to_vec(), places: *places };
            }
        }
        let made = make();
        let mut known = lock();
        let from = known.nodes.len();
        let to = from + made.nodes.len();
        // Blocks without a node take room too.
        let is_full = to > self.most_nodes_on_a_shelf || known.blocks.len() >= self.most_nodes_on_a_shelf;
        if !is_full && !known.blocks.contains_key(&key) {
            known.nodes.extend_from_slice(&made.nodes);
            known.blocks.insert(key, (from, to, made.places));
        }
        made
    }
}
