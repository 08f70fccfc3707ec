//! The command line of satseed.

fn main() {}
