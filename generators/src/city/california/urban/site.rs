//! A block at work: what its sites put into the plan.

use super::{Use, ground};
use crate::city::california::Params;
use crate::city::california::house::{self, Extra};
use crate::city::california::lot::{Building, Content, Kind, Parked, Plant, Planted};
use crate::city::california::paving::Layer;
use crate::city::toronto::massing::{self, Frame, Relief};
use crate::city::toronto::traffic::draw_body;
use crate::kit::buildings::{BuildingPlan, Facade, Furnishing, Mass, Roof, RoofItem, furnish, slot};
use crate::kit::ground::Patch;
use crate::kit::parcels::Site;
use crate::kit::polygon;
use crate::kit::vehicles::Body;
use glam::DVec2;
use satseed_scene::{Rng, SeedPath};

/// A rectangle of a frame: least and greatest x, least and greatest y.
pub(super) type Rect = [f64; 4];

/// How far below the ground walls begin before the terrain is known, m.
pub(super) const GROUNDED: f64 = -1.0;

/// A block in the making.
pub(super) struct Work<'a> {
    pub(super) params: &'a Params,
    pub(super) relief: &'a Relief<'a>,
    pub(super) out: Content,
    /// World outlines of what plants must keep off.
    pub(super) taken: Vec<Vec<DVec2>>,
}

/// A site with its frame: x along its front, y into the block.
pub(super) struct Place<'a> {
    pub(super) site: &'a Site,
    pub(super) frame: Frame,
    pub(super) name: String,
    pub(super) key: SeedPath,
}

impl<'a> Place<'a> {
    pub(super) fn new(site: &'a Site, block_name: &str, block_key: &SeedPath) -> Self {
        let name = format!("{block_name}/site/{}", site.index);
        Self { site, frame: Frame::of(site), name, key: block_key.child("site").index(site.index) }
    }

    /// The largest rectangle about the middle that keeps these distances from streets, neighbours and what lies behind.
    pub(super) fn rect(&self, street_m: f64, side_m: f64, back_m: f64) -> Option<Rect> {
        let outline = &self.site.outline;
        let inner = polygon::inset_edges(outline, |i| {
            let d = (outline[(i + 1) % outline.len()] - outline[i]).normalize();
            if self.site.on_street[i] {
                street_m
            } else if d.dot(self.frame.axis) < -0.7 {
                back_m
            } else {
                side_m
            }
        })?;
        let local: Vec<DVec2> = inner.iter().map(|p| self.frame.local(*p)).collect();
        inscribed(&local)
    }
}

/// An upright rectangle within a convex outline: its bounds, pushed in where a corner lies outside.
pub(super) fn inscribed(outline: &[DVec2]) -> Option<Rect> {
    let (low, high) = polygon::bounds(outline);
    let mut r = [low.x, high.x, low.y, high.y];
    let inside = |x: f64, y: f64| {
        (0..outline.len()).all(|i| {
            let (a, b) = (outline[i], outline[(i + 1) % outline.len()]);
            (b - a).perp_dot(DVec2::new(x, y) - a) >= -1e-6
        })
    };
    for step in 0..240 {
        let corners = [(0, 2), (1, 2), (1, 3), (0, 3)].map(|(i, j): (usize, usize)| (i, j, !inside(r[i], r[j])));
        if corners.iter().all(|c| !c.2) {
            return (r[1] - r[0] > 4.0 && r[3] - r[2] > 4.0).then_some(r);
        }
        // In turn along and across, so that slanting sides take from both.
        let pushed = usize::from(step % 3 == 2);
        for (i, j, out) in corners {
            if out {
                let k = if pushed == 0 { i } else { j };
                r[k] += if k % 2 == 0 { 0.25 } else { -0.25 };
            }
        }
        if r[0] >= r[1] || r[2] >= r[3] {
            return None;
        }
    }
    None
}

pub(super) fn corners([x0, x1, y0, y1]: Rect) -> Vec<DVec2> {
    polygon::rectangle(DVec2::new(x0, y0), DVec2::new(x1, y1))
}

/// A rectangle made smaller on all sides.
pub(super) fn shrunk([x0, x1, y0, y1]: Rect, by: f64) -> Rect {
    [x0 + by, x1 - by, y0 + by, y1 - by]
}

/// A mass of plain walls whose windows, if any, are texture.
pub(super) fn plain(outline: Vec<DVec2>, low_m: f64, roof_m: f64, parapet_m: f64) -> Mass {
    Mass {
        outline,
        low_m,
        roof_m,
        first_floor_m: 0.0,
        floor_m: 3.3,
        bay_m: 4.2,
        shop: false,
        facade: Facade::Plain,
        roof: Roof::Flat { parapet_m, slot: slot::ROOF },
        balconies: Vec::new(),
    }
}

/// Whether a mass has room for its parapets and its walls go up.
pub(super) fn sound(m: &Mass) -> bool {
    let (low, high) = polygon::bounds(&m.outline);
    (high - low).min_element() > 0.9 && polygon::area(&m.outline) > 0.8 && m.roof_m > m.low_m
}

/// A plan of Toronto's for a site that may be narrower than sites are there.
pub(super) fn wide_enough(building: massing::Building) -> Option<BuildingPlan> {
    let wide = |m: &Mass| {
        let (low, high) = polygon::bounds(&m.outline);
        polygon::area(&m.outline) > 30.0 && (high - low).min_element() > 4.0
    };
    let plan = building.plan;
    plan.masses.iter().filter(|m| m.low_m < 0.0).all(wide).then_some(plan)
}

/// A building in the making, in a site's frame.
pub(super) struct Draft {
    pub(super) usage: Use,
    pub(super) masses: Vec<Mass>,
    pub(super) items: Vec<RoofItem>,
    pub(super) extras: Vec<Extra>,
}

impl Draft {
    pub(super) fn new(usage: Use, masses: Vec<Mass>) -> Self {
        Self { usage, masses, items: Vec::new(), extras: Vec::new() }
    }

    /// Furniture on the roof of a mass, around the masses that stand on it and whatever `over` names.
    pub(super) fn furnish(&mut self, mass: usize, what: Furnishing, over: &[Vec<DVec2>], key: &SeedPath) {
        let m = &self.masses[mass];
        let what = Furnishing { base_m: m.roof_m, ..what };
        let mut obstacles = over.to_vec();
        for (k, n) in self.masses.iter().enumerate() {
            if k != mass && n.roof_m > m.roof_m && n.low_m < m.roof_m + 0.5 {
                // A bounding box is convex, whatever the outline is.
                let (low, high) = polygon::bounds(&n.outline);
                let out = DVec2::splat(if n.balconies.is_empty() { 0.5 } else { 2.1 });
                obstacles.push(polygon::rectangle(low - out, high + out));
            }
        }
        let items = furnish(&polygon::mitred(&m.outline, 0.6), &obstacles, what, &key.child("roof").index(mass as u64));
        self.items.extend(items);
    }
}

impl Work<'_> {
    /// Covers an outline of the world.
    pub(super) fn cover(&mut self, layer: Layer, outline: Vec<DVec2>, slot: u16, axis: DVec2) {
        self.out.patches.push((layer, Patch { origin_m: outline[0], outline, slot, axis, lowered: false }));
    }

    /// Covers a site but for a seam at its borders.
    pub(super) fn floor(&mut self, place: &Place<'_>, slot: u16) {
        if let Some(outline) = polygon::inset(&place.site.outline, 0.1) {
            self.cover(Layer::Front, outline, slot, place.frame.axis);
        }
    }

    /// Covers a polygon of a frame.
    pub(super) fn lay(&mut self, layer: Layer, frame: &Frame, local: &[DVec2], slot: u16) {
        let outline: Vec<DVec2> = local.iter().map(|p| frame.world(*p)).collect();
        self.cover(layer, outline, slot, frame.axis);
    }

    /// Puts a building into the plan. Its plan tells where it stands.
    pub(super) fn build(&mut self, place: &Place<'_>, what: &str, mut draft: Draft) -> BuildingPlan {
        let relief = self.relief;
        let frame = &place.frame;
        debug_assert!(draft.masses.iter().all(sound), "{}/{what} has a mass turned inside out", place.name);
        for m in draft.masses.iter().filter(|m| m.low_m < 3.0) {
            let outline = polygon::mitred(&m.outline, -1.0);
            self.taken.push(outline.iter().map(|p| frame.world(*p)).collect());
        }
        let plan =
            house::grounded(frame.centre, frame.axis, draft.masses, draft.items, &mut draft.extras, &|p| relief(p));
        let ridge_m = plan.roof_m();
        let building = Building { kind: Kind::Urban(draft.usage), plan: plan.clone(), extras: draft.extras, ridge_m };
        self.out.buildings.push((format!("{}/{what}", place.name), building));
        plan
    }

    /// The same for a plan of Toronto's.
    pub(super) fn adopt(&mut self, place: &Place<'_>, usage: Use, plan: BuildingPlan) {
        for m in plan.masses.iter().filter(|m| m.low_m < 0.0) {
            self.taken.push(polygon::mitred(&plan.world_outline(m), -1.0));
        }
        let ridge_m = plan.roof_m();
        let building = Building { kind: Kind::Urban(usage), plan, extras: Vec::new(), ridge_m };
        self.out.buildings.push((format!("{}/building", place.name), building));
    }

    /// A plant, unless something stands there.
    pub(super) fn plant(&mut self, at: DVec2, plant: Plant, size: f64) {
        if self.taken.iter().all(|o| !polygon::contains(o, at)) {
            self.out.plants.push(Planted { at, plant, size });
        }
    }

    /// Plants strewn over a rectangle, about `per_100_m2` of them at the nominal number of trees.
    pub(super) fn strew(&mut self, frame: &Frame, r: Rect, per_100_m2: f64, weights: [f64; 3], rng: &mut Rng) {
        let area = (r[1] - r[0]) * (r[3] - r[2]);
        let wanted = libm::floor(area / 100.0 * per_100_m2 * self.params.trees + rng.unit()) as u32;
        for _ in 0..wanted {
            let p = DVec2::new(rng.range(r[0], r[1]), rng.range(r[2], r[3]));
            let (plant, size) = match rng.weighted(&weights) {
                0 => (Plant::Broad, rng.range(0.5, 1.05)),
                1 => (Plant::Palm, rng.range(0.7, 1.1)),
                _ => (Plant::Shrub, rng.range(0.6, 1.5)),
            };
            self.plant(frame.world(p), plant, size);
        }
    }

    /// A car, unless something stands there.
    pub(super) fn car(&mut self, frame: &Frame, at: DVec2, axis: DVec2, body: Body) {
        let centre = frame.world(at);
        let axis = frame.axis * axis.x + frame.axis.perp() * axis.y;
        let [length, width, _] = body.size_m();
        let foot = polygon::oriented_rectangle(centre, axis, DVec2::new(length / 2.0, width / 2.0));
        if self.taken.iter().all(|o| foot.iter().all(|p| !polygon::contains(o, *p))) {
            self.out.vehicles.push(Parked { centre, axis, body, lowered: false });
        }
    }

    /// A parking lot over a rectangle of a frame: rows of stalls along x, the first along y0, aisles between, islands with
    /// trees at the ends of long rows, lamps. Returns where its last row ends.
    pub(super) fn parking(&mut self, frame: &Frame, r: Rect, occupancy: f64, key: &SeedPath) -> f64 {
        let [x0, x1, y0, y1] = r;
        let mut rng = key.child("parking").rng();
        let slot = *rng.pick(&ground::LOTS);
        let islands = x1 - x0 > 26.0 && rng.chance(0.6);
        let rows = stall_rows(y1 - y0);
        let Some(last) = rows.last() else { return y0 };
        let end = y0 + last.0 + ROW_M / 2.0;
        self.lay(Layer::Walk, frame, &corners([x0, x1, y0, end]), slot);
        for (n, (middle, way)) in rows.iter().enumerate() {
            let y = y0 + middle;
            if islands {
                for x in [x0 + 1.3, x1 - 1.3] {
                    self.lay(Layer::Bed, frame, &corners([x - 1.2, x + 1.2, y - 2.4, y + 2.4]), island_slot(n));
                    if rng.chance((0.7 * self.params.trees).min(1.0)) {
                        let plant = if rng.chance(0.3) { Plant::Palm } else { Plant::Broad };
                        let size = rng.range(0.4, 0.8);
                        self.plant(frame.world(DVec2::new(x, y)), plant, size);
                    }
                }
            }
            let inset = if islands { 2.6 } else { 0.0 };
            let mut x = x0 + inset + STALL_M / 2.0;
            while x + STALL_M / 2.0 <= x1 - inset {
                if rng.chance((occupancy * self.params.vehicles).min(1.0)) {
                    let body = draw_body(&mut rng, false);
                    let way = if rng.chance(0.82) { *way } else { -way };
                    let at = DVec2::new(x + rng.signed() * 0.15, y + rng.signed() * 0.3);
                    self.car(frame, at, DVec2::new(0.0, way), body);
                }
                x += STALL_M;
            }
            if n % 2 == 1 {
                let mut x = x0 + 9.0;
                while x < x1 - 5.0 {
                    let at = frame.world(DVec2::new(x, y0 + middle + way * ROW_M / 2.0));
                    self.out.lights.push((at, frame.axis.perp()));
                    x += 31.2;
                }
            }
        }
        end
    }
}

fn island_slot(row: usize) -> u16 {
    use crate::city::california::ground_slot as suburb;
    if row.is_multiple_of(3) { suburb::PARKWAY } else { suburb::MULCH }
}

/// Width of a stall and depth of a row of them, m.
pub(super) const STALL_M: f64 = 2.6;
pub(super) const ROW_M: f64 = 5.5;

/// Rows of a parking lot of a depth: middle, and the way that cars point who drove in forward. The pattern repeats every
/// 17.5 m: a row, an aisle of 6.5 m, a row.
pub(super) fn stall_rows(depth_m: f64) -> Vec<(f64, f64)> {
    let mut out = Vec::new();
    let mut start = 0.0;
    loop {
        // A row that looks up needs its aisle above it.
        if start + ROW_M + 6.0 > depth_m {
            break;
        }
        out.push((start + ROW_M / 2.0, -1.0));
        if start + 17.5 > depth_m {
            break;
        }
        out.push((start + 12.0 + ROW_M / 2.0, 1.0));
        start += 17.5;
    }
    out
}
