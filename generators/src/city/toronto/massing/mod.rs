//! What stands on a site: towers on podiums, mid-rise blocks, brick houses, low shops.
//!
//! Sizes after the city's Tall Building Design Guidelines (2013): residential plates up to 750 m^2, 25 m between towers,
//! podiums of 10.5 to 24 m with the tower stepped back by 3 m. Everything is drawn in the site's own frame: x along the
//! street, y into the block.

mod low;
mod tower;

pub(in crate::city) use low::{mid_rise, shop};
pub(in crate::city) use tower::penthouse;
pub(super) use tower::{PENTHOUSE_M, condo, office, tower_height_m, tower_place};

use crate::kit::buildings::{Balcony, BuildingPlan, Mass, Roof, slot};
use crate::kit::parcels::Site;
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::Rng;
use serde::{Deserialize, Serialize};

/// What a building is; decides its materials.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(in crate::city) enum Kind {
    /// Residential tower.
    Condo,
    /// Office tower.
    Office,
    /// Mid-rise block of masonry.
    Block,
    /// House of a brick row.
    House,
    /// One or two storeys of shops and workshops.
    Shop,
    /// Garage or shed.
    Shed,
    /// Block of flats of the sixties and seventies.
    Flats,
}

/// A building with its kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(in crate::city) struct Building {
    /// What it is.
    pub kind: Kind,
    /// Its geometry as data.
    pub plan: BuildingPlan,
}

/// The relief as a function of place.
pub(in crate::city) type Relief<'a> = dyn Fn(DVec2) -> f64 + Sync + 'a;

/// A site's frame.
#[derive(Clone, Copy, Debug)]
pub(in crate::city) struct Frame {
    /// Origin, world.
    pub centre: DVec2,
    /// Direction of x, world.
    pub axis: DVec2,
}

impl Frame {
    /// Of a site.
    pub(in crate::city) fn of(site: &Site) -> Self {
        Self { centre: polygon::centroid(&site.outline), axis: site.axis() }
    }

    /// World to frame.
    pub(in crate::city) fn local(&self, p: DVec2) -> DVec2 {
        let d = p - self.centre;
        DVec2::new(d.dot(self.axis), self.axis.perp_dot(d))
    }

    /// Frame to world.
    pub(in crate::city) fn world(&self, p: DVec2) -> DVec2 {
        self.centre + self.axis * p.x + self.axis.perp() * p.y
    }
}

/// Distances that a building keeps from its site's borders, m.
#[derive(Clone, Copy, Debug)]
struct Setbacks {
    /// From streets.
    street: f64,
    /// From neighbours.
    side: f64,
    /// From the lane.
    back: f64,
}

/// The part of a site that may be built on, in its frame.
fn buildable(site: &Site, frame: &Frame, s: Setbacks) -> Option<Vec<DVec2>> {
    let outline = &site.outline;
    let inner = polygon::inset_edges(outline, |i| {
        let d = (outline[(i + 1) % outline.len()] - outline[i]).normalize();
        if site.on_street[i] {
            s.street
        } else if d.dot(frame.axis) < -0.7 {
            s.back
        } else {
            s.side
        }
    })?;
    Some(inner.into_iter().map(|p| frame.local(p)).collect())
}

/// Least and greatest distances that a building keeps from its site's borders, m.
struct SetbackRanges {
    street: [f64; 2],
    side: [f64; 2],
    back: [f64; 2],
}

/// A site's frame, and in it the part that a building of such setbacks may stand on.
fn plot(site: &Site, ranges: &SetbackRanges, rng: &mut Rng) -> Option<(Frame, Vec<DVec2>)> {
    let frame = Frame::of(site);
    let mut draw = |[least, most]: [f64; 2]| rng.range(least, most);
    let setbacks = Setbacks { street: draw(ranges.street), side: draw(ranges.side), back: draw(ranges.back) };
    let area = buildable(site, &frame, setbacks)?;
    Some((frame, area))
}

/// A shape of the unit square laid into a four-cornered area; other areas are taken whole.
fn laid_into(area: &[DVec2], shape: &[[f64; 2]]) -> Vec<DVec2> {
    if area.len() != 4 {
        return area.to_vec();
    }
    // Corner 0 shall be the one at the front left.
    let first = (0..4).min_by(|a, b| (area[*a].x + area[*a].y).total_cmp(&(area[*b].x + area[*b].y))).unwrap_or(0);
    let c = |k: usize| area[(first + k) % 4];
    shape.iter().map(|[s, t]| c(0).lerp(c(1), *s).lerp(c(3).lerp(c(2), *s), *t)).collect()
}

pub(super) const GROUNDED: f64 = -1.0;

/// Completes a plan: its foot in the ground and its frame in the world.
pub(super) fn grounded(frame: &Frame, relief: &Relief<'_>, mut masses: Vec<Mass>) -> BuildingPlan {
    let ground_m = relief(frame.centre);
    let feet = masses.iter().filter(|m| m.low_m < 0.0).flat_map(|m| m.outline.iter());
    let lowest = feet.map(|p| relief(frame.world(*p))).fold(ground_m, f64::min);
    let drop_m = ground_m - lowest;
    for m in masses.iter_mut().filter(|m| m.low_m < 0.0) {
        // Sites are convex and the relief gentle: half a metre more than asked for swallows what lies between corners.
        m.low_m = -drop_m - 1.0;
    }
    BuildingPlan { centre_m: frame.centre, axis: frame.axis, ground_m, drop_m, masses, items: Vec::new() }
}

pub(in crate::city) fn flat(parapet_m: f64) -> Roof {
    Roof::Flat { parapet_m, slot: slot::ROOF }
}

/// Rows of balconies around an outline.
pub(in crate::city) fn balconies(outline: &[DVec2], bay_m: f64, rng: &mut Rng) -> Vec<Balcony> {
    let mut out = Vec::new();
    let depth_m = rng.range(1.5, 1.8);
    let style = rng.below(4);
    for edge in 0..outline.len() {
        let side = outline[edge].distance(outline[(edge + 1) % outline.len()]);
        if side < 5.5 || rng.chance(0.2) {
            continue;
        }
        let mut add = |from: f64, to: f64| out.push(Balcony { edge, span_m: [from, to], depth_m, every: 1 });
        match style {
            0 => add(0.35, side - 0.35),
            1 => {
                let reach = (side * 0.36).min(7.0);
                add(0.3, reach);
                add(side - reach, side - 0.3);
            }
            _ => {
                let run = bay_m * if style == 2 { 1.0 } else { 2.0 };
                let n = libm::floor((side + 0.8) / (run + bay_m * 0.7)).max(1.0) as usize;
                let gap = (side - n as f64 * run) / (n as f64 + 1.0);
                for k in 0..n {
                    let from = gap + (run + gap) * k as f64;
                    if gap > 0.15 && run > 2.0 {
                        add(from, from + run);
                    }
                }
            }
        }
    }
    out
}
