//! What regions share: height fields, erosion, triangulation, streets, buildings, vegetation, vehicles.

pub mod arrange;
pub mod buildings;
#[cfg(test)]
pub(crate) mod checks;
pub mod furniture;
pub mod ground;
pub mod mesh_builder;
pub mod palm;
pub mod parcels;
pub mod polygon;
pub mod rock;
pub mod scatter;
pub mod shrub;
pub mod streets;
pub mod sweep;
pub mod terrain;
pub mod trees;
pub mod vehicles;
pub mod woods;
