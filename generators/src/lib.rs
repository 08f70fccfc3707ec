//! Seeded generators: parameters and a seed give a [`Scene`], the same bits everywhere.
//!
//! A region is a folder with a parameter struct, a version and a pure `build`. It composes what stands in [`kit`] and
//! brings data (meshes, materials, rasters); how they are traced and lit is none of its business. Adding a region is its
//! folder and one line in the registry below.

pub mod canyon;
pub mod city;
pub mod coast;
pub mod desert;
pub mod field;
pub mod forest;
pub mod kit;
mod parameters;

pub use parameters::{ParameterError, check_range};

use city::{california, toronto, venice};
use satseed_scene::{Scene, SeedPath};
use serde::{Deserialize, Serialize};

macro_rules! registry {
    ($($variant:ident, $module:ident, $name:literal;)*) => {
        /// A region with its parameters, as a recipe names it: `canyon = { relief_m = 160.0 }`.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
        #[serde(rename_all = "lowercase")]
        pub enum Region {
            $(
                #[doc = concat!("The region `", $name, "`.")]
                $variant($module::Params),
            )*
        }

        impl Region {
            /// The names of all regions, in the registry's order.
            pub const NAMES: &'static [&'static str] = &[$($name),*];

            /// A region by its name, with default parameters.
            pub fn by_name(name: &str) -> Option<Self> {
                match name {
                    $($name => Some(Self::$variant($module::Params::default())),)*
                    _ => None,
                }
            }

            /// Its name.
            pub fn name(&self) -> &'static str {
                match self {
                    $(Self::$variant(_) => $name,)*
                }
            }

            /// The variant's name; it stands in the scene's name.
            pub fn variant(&self) -> &'static str {
                match self {
                    $(Self::$variant(p) => p.variant(),)*
                }
            }

            /// The generator's version: raised whenever the same parameters and seed give other bytes.
            pub fn version(&self) -> u32 {
                match self {
                    $(Self::$variant(_) => $module::VERSION,)*
                }
            }

            /// Whether every parameter lies in its documented range.
            pub fn check(&self) -> Result<(), ParameterError> {
                match self {
                    $(Self::$variant(p) => p.check(),)*
                }
            }

            /// Lowest and highest height that any point of the scene can have, m, from the parameters alone.
            pub fn height_bounds_m(&self) -> [f64; 2] {
                match self {
                    $(Self::$variant(p) => p.height_bounds_m(),)*
                }
            }

            /// Within this distance from the pivot geometry stands in full detail, m.
            pub fn full_detail_radius_m(&self) -> f64 {
                match self {
                    $(Self::$variant(p) => p.radius_m,)*
                }
            }

            /// The same region with another radius of full detail, m; [`Region::check`] tells whether it is legal.
            #[must_use]
            pub fn with_radius_m(mut self, radius_m: f64) -> Self {
                match &mut self {
                    $(Self::$variant(p) => p.radius_m = radius_m,)*
                }
                self
            }

            /// Upper bound of what building and holding the scene takes, bytes, from the parameters alone.
            pub fn memory_bound_bytes(&self) -> u64 {
                match self {
                    $(Self::$variant(p) => p.memory_bound_bytes(),)*
                }
            }

            /// Builds the scene. Parameters must have passed [`Region::check`].
            pub fn build(&self, seed: u64) -> Scene {
                let path = SeedPath::root(self.name(), seed);
                match self {
                    $(Self::$variant(p) => $module::build(p, path),)*
                }
            }
        }
    };
}

// The registry: one line a region.
registry! {
    Canyon, canyon, "canyon";
    Toronto, toronto, "toronto";
    Desert, desert, "desert";
    Field, field, "field";
    Forest, forest, "forest";
    Coast, coast, "coast";
    California, california, "california";
    Venice, venice, "venice";
}
