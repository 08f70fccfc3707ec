//! What the proofs share: small scenes, solids, rigs, and a search for cracks in meshes.
#![allow(dead_code, reason = "each test binary uses its own part")]

pub(crate) mod cracks;
pub(crate) mod mutate;
pub(crate) mod small;
pub(crate) mod solids;
pub(crate) mod stage;
