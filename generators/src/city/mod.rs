//! Cities: a plan first, triangles last.

pub mod toronto;
pub mod venice;
