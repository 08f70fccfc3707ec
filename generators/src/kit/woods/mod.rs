//! Forest trees: species with crowns of opaque, closed leaf clusters or fans, and dead wood.
//!
//! A species has individuals of four sizes, so that leaf clusters have about the same size on all trees and an instance
//! needs to be scaled little.

mod broadleaf;
mod conifer;
mod dead;
mod solid;

pub use dead::{brush, bush, far, fern, log, snag, stump};

use satseed_scene::{Mesh, SeedPath};

/// Slot of bark and wood.
pub const BARK: u16 = 0;
/// Slot of leaves and needles.
pub const LEAVES: u16 = 1;

/// Species of a temperate forest, by how they look from above.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Species {
    /// Wide crowns of few, large, uneven lobes.
    Oak,
    /// Dense domes of many small lobes.
    Beech,
    /// Narrow, loose crowns: birch and aspen.
    Birch,
    /// Pointed stars of drooping fans.
    Spruce,
    /// Flat, open crowns of separate pads high on a bare stem.
    Pine,
    /// Airy cones.
    Larch,
}

impl Species {
    /// All of them.
    pub const ALL: [Self; 6] = [Self::Oak, Self::Beech, Self::Birch, Self::Spruce, Self::Pine, Self::Larch];

    /// Whether it is a conifer.
    pub fn is_conifer(self) -> bool {
        matches!(self, Self::Spruce | Self::Pine | Self::Larch)
    }

    /// Height and crown radius of the individuals of each size, m: what [`tree`] makes.
    pub fn sizes(self) -> [[f64; 2]; SIZES] {
        match self {
            Self::Oak => [[5.5, 1.5], [15.0, 2.5], [21.0, 3.9], [26.0, 5.9]],
            Self::Beech => [[5.5, 1.4], [16.0, 2.2], [22.0, 3.4], [27.0, 5.0]],
            Self::Birch => [[6.0, 1.1], [15.0, 1.7], [20.0, 2.5], [25.0, 3.4]],
            Self::Spruce => [[4.5, 1.1], [15.0, 1.6], [22.0, 2.2], [28.0, 3.0]],
            Self::Pine => [[4.5, 1.0], [14.0, 1.6], [20.0, 2.2], [25.0, 3.1]],
            Self::Larch => [[5.0, 1.1], [15.0, 1.6], [22.0, 2.2], [28.0, 2.9]],
        }
    }
}

/// Sizes of a species.
pub const SIZES: usize = 4;
/// Individuals of each size of a species.
pub const INDIVIDUALS: usize = 6;

/// One individual: z = 0 is the ground, the stem begins 1.2 m below it. `size` counts from the smallest.
pub fn tree(species: Species, size: usize, path: &SeedPath) -> Mesh {
    let mut rng = path.child("proportions").rng();
    let [height, crown] = species.sizes()[size];
    let (height, crown) = (height * rng.range(0.93, 1.07), crown * rng.range(0.93, 1.07));
    let detail = size as f64 / (SIZES - 1) as f64;
    // Young trees carry leaves down to the ground.
    let young = size == 0;
    let lobed = |f: broadleaf::Form| {
        let depth = if young { 0.85 } else { f.depth * rng_free(path, 0.85, 1.15) };
        broadleaf::tree(&broadleaf::Form { depth, ..f }, height, crown, detail, path)
    };
    let whorled = |f: conifer::Form| {
        let base = if young { 0.04 } else { f.base * rng_free(path, 0.7, 1.25) };
        conifer::tree(&conifer::Form { base, ..f }, height, crown, detail, path)
    };
    match species {
        Species::Oak => lobed(broadleaf::Form {
            depth: 0.46,
            lobes: 11,
            lobe: 0.45,
            flat: 0.85,
            fall: 0.42,
            clusters: 12,
            cluster: 0.38,
            gaps: 0.15,
            jag: 0.24,
            dense: true,
            sprays: (4, 0.34),
        }),
        Species::Beech => lobed(broadleaf::Form {
            depth: 0.52,
            lobes: 11,
            lobe: 0.41,
            flat: 0.9,
            fall: 0.5,
            clusters: 10,
            cluster: 0.38,
            gaps: 0.1,
            jag: 0.22,
            dense: true,
            sprays: (4, 0.32),
        }),
        Species::Birch => lobed(broadleaf::Form {
            depth: 0.55,
            lobes: 9,
            lobe: 0.48,
            flat: 1.15,
            fall: 0.75,
            clusters: 10,
            cluster: 0.36,
            gaps: 0.2,
            jag: 0.3,
            dense: false,
            sprays: (6, 0.45),
        }),
        Species::Pine => lobed(broadleaf::Form {
            depth: 0.36,
            lobes: 13,
            lobe: 0.37,
            flat: 0.5,
            fall: 0.55,
            clusters: 7,
            cluster: 0.48,
            gaps: 0.14,
            jag: 0.34,
            dense: false,
            sprays: (7, 0.5),
        }),
        Species::Spruce => whorled(conifer::Form {
            base: 0.46,
            whorls: 19,
            branches: 9,
            twigs: 3,
            width: 0.52,
            droop: 0.34,
            taper: 0.58,
            gaps: 0.08,
            dense: true,
        }),
        Species::Larch => whorled(conifer::Form {
            base: 0.5,
            whorls: 16,
            branches: 8,
            twigs: 3,
            width: 0.36,
            droop: 0.12,
            taper: 0.55,
            gaps: 0.18,
            dense: false,
        }),
    }
}

/// A draw that no other one of the same tree moves.
fn rng_free(path: &SeedPath, from: f64, to: f64) -> f64 {
    path.child("crown").rng().range(from, to)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::mesh_builder::open_edges;

    #[test]
    fn trees_are_closed_rooted_and_as_large_as_stated() {
        let root = SeedPath::root("woods", 1);
        for species in Species::ALL {
            for (size, [height, crown]) in species.sizes().into_iter().enumerate() {
                for k in 0..INDIVIDUALS as u64 {
                    let m = tree(species, size, &root.index(size as u64).index(k));
                    assert_eq!((m.validate(), open_edges(&m)), (Ok(()), 0), "{species:?} {size} {k}");
                    let (low, high) = m.bounds_m().unwrap();
                    assert!(low.z < -1.0 && low.z > -1.3, "{low}");
                    assert!((0.85..1.2).contains(&(high.z / height)), "{species:?} {size} {k}: {} of {height}", high.z);
                    let reach = low.truncate().abs().max(high.truncate().abs()).max_element() / crown;
                    assert!((0.7..1.75).contains(&reach), "{species:?} {size} {k}: {reach} crown radii");
                    let n = m.triangles.len();
                    let limit = if size == 0 { 250..3500 } else { 600..10_500 };
                    assert!(limit.contains(&n), "{species:?} {size} {k}: {n} triangles");
                }
            }
        }
    }

    #[test]
    fn dead_wood_and_ferns_are_closed_and_differ() {
        let root = SeedPath::root("woods", 2);
        let makers: [fn(&SeedPath) -> Mesh; 8] = [
            |p| snag(18.0, 3.0, p),
            |p| far(20.0, 4.0, false, p),
            |p| far(20.0, 3.0, true, p),
            log,
            stump,
            brush,
            fern,
            bush,
        ];
        for make in makers {
            let all: Vec<Mesh> = (0..6).map(|k| make(&root.index(k))).collect();
            for m in &all {
                assert_eq!((m.validate(), open_edges(m)), (Ok(()), 0));
                assert!((40..1800).contains(&m.triangles.len()), "{}", m.triangles.len());
            }
            assert_ne!(all[0], all[1]);
        }
    }
}
