//! satseed
pub mod dataset;
