//! What regions share: height fields, erosion, triangulation, streets, buildings, vegetation, vehicles.

pub mod rock;
pub mod shrub;
pub mod terrain;
