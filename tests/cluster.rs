//! Beyond one machine, without one: how shards balance over machines of different speed, and what joining a hundred
//! million samples takes, in simulation.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

mod cluster {
    mod balance;
    mod join;
}
