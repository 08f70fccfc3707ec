//! Nothing is lost: kills, full disks, signals, second processes, faults, shards, through the program itself.
//!
//! The short versions run always; `cargo test -- --ignored` runs the long ones.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

mod reliability {
    pub(crate) mod bench;
    mod equal_trees;
    mod interruptions;
    mod limits;
    mod merge;
    mod refusals;
    mod truth;
}
mod support;
