//! What regions share: height fields, erosion, triangulation, streets, buildings, vegetation, vehicles.
