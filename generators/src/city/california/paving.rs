//! What lies on the ground, layer over layer, and the arrangement of it all.

use crate::kit::ground::{self, Ground, GroundPlan, Patch};
use glam::DVec2;

/// From the lowest to the topmost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Layer {
    /// Slabs of land, rear yards.
    Yard,
    /// Front yards, lawns on slabs.
    Front,
    /// Strips of walk along streets, with what lies between walk and kerb.
    Walk,
    /// Between the walk and the kerb.
    Parkway,
    /// Planted beds.
    Bed,
    /// Drives, walks and patios.
    Drive,
    /// Around pools.
    Deck,
    /// Rims of pools.
    Coping,
    /// Water of pools.
    Water,
    /// Concrete gutters.
    Gutter,
    /// Local asphalt.
    Local,
    /// Arterials and collectors.
    Major,
    /// Markings and patches of their own outline.
    Mark,
    /// Raised medians and islands.
    Island,
}

/// Spacing of posts on gentle land, m.
pub(super) const GENTLE_M: f64 = 20.0;

/// Height of a kerb, m.
pub(super) const KERB_M: f64 = 0.15;

/// Half side of the ground, m.
pub(super) const HALF_M: f64 = 2400.0;

/// Triangulates layers of patches over a relief followed at `post_m`; what no patch covers is open land.
pub(super) fn ground(
    mut layers: Vec<(Layer, Patch)>,
    slots: (u16, u16),
    fine_radius_m: f64,
    post_m: f64,
    height_m: &dyn Fn(DVec2) -> f64,
) -> Ground {
    layers.sort_by_key(|(layer, _)| *layer);
    let patches = ground::arranged(layers.into_iter().map(|(_, patch)| patch).collect(), post_m);
    let plan = GroundPlan {
        patches,
        background_slot: slots.0,
        background_lowered: false,
        kerb_slot: slots.1,
        kerb_m: KERB_M,
        half_m: HALF_M,
        fine_radius_m,
        fine_m: post_m,
        coarse_m: 50.0,
    };
    ground::triangulate(&plan, height_m)
}
