//! Cities: a plan first, triangles last.

pub mod california;
pub mod toronto;
pub mod venice;
