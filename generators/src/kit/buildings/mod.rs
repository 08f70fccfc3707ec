//! Buildings: a plan as plain data, and the mesher that turns it into closed solids.

mod facade;
mod mesher;
mod plan;
mod rooftop;

pub use mesher::{Detail, mesh};
pub use plan::{Balcony, BuildingPlan, Facade, Mass, Roof, RoofItem, RoofItemKind, slot};
pub use rooftop::{Furnishing, furnish};
