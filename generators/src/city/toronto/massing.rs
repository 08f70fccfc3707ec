//! What stands on a site: towers on podiums, mid-rise blocks, brick houses, low shops.
//!
//! Sizes after the city's Tall Building Design Guidelines (2013): residential plates up to 750 m^2, 25 m between towers,
//! podiums of 10.5 to 24 m with the tower stepped back by 3 m. Everything is drawn in the site's own frame: x along the
//! street, y into the block.

use crate::kit::buildings::{Balcony, BuildingPlan, Facade, Furnishing, Mass, Roof, furnish, slot};
use crate::kit::parcels::Site;
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::{Rng, SeedPath};
use serde::{Deserialize, Serialize};

/// What a building is; decides its materials.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Kind {
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
}

/// A building with its kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Building {
    /// What it is.
    pub kind: Kind,
    /// Its geometry as data.
    pub plan: BuildingPlan,
}

/// The relief as a function of place.
pub(super) type Relief<'a> = dyn Fn(DVec2) -> f64 + Sync + 'a;

/// A site's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    /// Origin, world.
    pub centre: DVec2,
    /// Direction of x, world.
    pub axis: DVec2,
}

impl Frame {
    /// Of a site.
    pub(super) fn of(site: &Site) -> Self {
        Self { centre: polygon::centroid(&site.outline), axis: site.axis() }
    }

    /// World to frame.
    pub(super) fn local(&self, p: DVec2) -> DVec2 {
        let d = p - self.centre;
        DVec2::new(d.dot(self.axis), self.axis.perp_dot(d))
    }

    /// Frame to world.
    pub(super) fn world(&self, p: DVec2) -> DVec2 {
        self.centre + self.axis * p.x + self.axis.perp() * p.y
    }
}

/// Distances that a building keeps from its site's borders, m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Setbacks {
    /// From streets.
    pub street: f64,
    /// From neighbours.
    pub side: f64,
    /// From the lane.
    pub back: f64,
}

/// The part of a site that may be built on, in its frame.
pub(super) fn buildable(site: &Site, frame: &Frame, s: Setbacks) -> Option<Vec<DVec2>> {
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

/// Completes a plan: its foot in the ground and its frame in the world.
fn grounded(frame: &Frame, relief: &Relief<'_>, mut masses: Vec<Mass>) -> BuildingPlan {
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

const GROUNDED: f64 = -1.0;

fn flat(parapet_m: f64) -> Roof {
    Roof::Flat { parapet_m, slot: slot::ROOF }
}

/// Height of a tower for a quantile 0..1: lognormal, median 125 m, sigma 0.4, clipped to 60..298 m.
pub(super) fn tower_height_m(quantile: f64) -> f64 {
    (125.0 * libm::exp(0.4 * normal_quantile(quantile))).clamp(60.0, 298.0)
}

/// Mean height of a mechanical penthouse, m.
pub(super) const PENTHOUSE_M: f64 = 7.5;

/// Inverse of the normal distribution (Abramowitz and Stegun 1964, 26.2.23; error below 4.5e-4).
fn normal_quantile(u: f64) -> f64 {
    let p = u.min(1.0 - u).max(1e-9);
    let t = (-2.0 * libm::log(p)).sqrt();
    let x =
        t - (2.515_517 + t * (0.802_853 + t * 0.010_328)) / (1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308)));
    if u < 0.5 { -x } else { x }
}

/// Outline of a residential plate within `half`, m.
fn plate(half: DVec2, rng: &mut Rng) -> Vec<DVec2> {
    let r = polygon::rectangle(-half, half);
    match rng.weighted(&[3.0, 3.0, 1.5, 1.2, 1.0]) {
        0 => r,
        1 => {
            // Corners cut back in steps.
            let n = DVec2::new(rng.range(1.5, 4.0), rng.range(1.5, 4.0));
            [
                (-half.x + n.x, -half.y),
                (half.x - n.x, -half.y),
                (half.x - n.x, -half.y + n.y),
                (half.x, -half.y + n.y),
                (half.x, half.y - n.y),
                (half.x - n.x, half.y - n.y),
                (half.x - n.x, half.y),
                (-half.x + n.x, half.y),
                (-half.x + n.x, half.y - n.y),
                (-half.x, half.y - n.y),
                (-half.x, -half.y + n.y),
                (-half.x + n.x, -half.y + n.y),
            ]
            .map(|(x, y)| DVec2::new(x, y))
            .to_vec()
        }
        2 => polygon::rounded(&r, rng.range(2.0, 4.0), 1),
        3 => polygon::rounded(&r, rng.range(6.0, 10.0), 4),
        _ => {
            // A waist on the long sides.
            let (d, w) = (rng.range(1.5, 3.0), rng.range(0.2, 0.4));
            [
                (-half.x, -half.y),
                (-half.x * w, -half.y),
                (-half.x * w, -half.y + d),
                (half.x * w, -half.y + d),
                (half.x * w, -half.y),
                (half.x, -half.y),
                (half.x, half.y),
                (half.x * w, half.y),
                (half.x * w, half.y - d),
                (-half.x * w, half.y - d),
                (-half.x * w, half.y),
                (-half.x, half.y),
            ]
            .map(|(x, y)| DVec2::new(x, y))
            .to_vec()
        }
    }
}

/// Rows of balconies around an outline.
fn balconies(outline: &[DVec2], bay_m: f64, rng: &mut Rng) -> Vec<Balcony> {
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

/// Where a tower stands on its podium: centre in the site's frame and half sizes. `None` when the site is too small.
pub(super) fn tower_place(site: &Site, office: bool, path: &SeedPath) -> Option<(DVec2, DVec2)> {
    let frame = Frame::of(site);
    let podium = buildable(site, &frame, Setbacks { street: 5.5, side: 4.0, back: 4.5 })?;
    let (low, high) = polygon::bounds(&podium);
    let mut rng = path.child("plate").rng();
    let room = (high - low) / 2.0;
    let half = if office {
        DVec2::new(rng.range(21.0, 27.0).min(room.x - 0.5), rng.range(21.0, 27.0).min(room.y - 0.5))
    } else if rng.chance(0.2) {
        DVec2::new(rng.range(18.5, 21.0).min(room.x - 0.5), rng.range(8.0, 9.2))
    } else {
        let w = rng.range(11.0, 13.8);
        DVec2::new(w.min(room.x - 0.5), (rng.range(665.0, 749.0) / (4.0 * w)).min(16.0))
    };
    let least = if office { 16.5 } else { 8.0 };
    let slack = room - half;
    if half.x < least || half.y < least.min(8.0) || slack.y < 0.3 {
        return None;
    }
    let at = (low + high) / 2.0 + DVec2::new(rng.signed() * slack.x * 0.7, rng.signed() * slack.y * 0.85);
    // Skewed sites: the whole plate must stand on the podium.
    let corners = polygon::oriented_rectangle(at, DVec2::X, half + DVec2::splat(0.3));
    corners.iter().all(|p| polygon::contains(&podium, *p)).then_some((at, half))
}

/// A residential tower on a podium.
pub(super) fn condo(
    site: &Site,
    place: (DVec2, DVec2),
    height_m: f64,
    relief: &Relief<'_>,
    path: &SeedPath,
) -> Option<Building> {
    let frame = Frame::of(site);
    let mut rng = path.child("condo").rng();
    let setbacks = Setbacks { street: rng.range(0.6, 2.4), side: rng.range(0.15, 1.5), back: rng.range(1.0, 4.0) };
    let area = buildable(site, &frame, setbacks)?;
    let (centre, half) = place;
    let shop_m = rng.range(4.5, 6.0);
    let podium_floor = 3.3;
    let podium_m = shop_m + podium_floor * rng.range(1.6, 5.4).round();
    let podium_facade = if rng.chance(0.6) {
        Facade::Punched {
            recess_m: rng.range(0.12, 0.25),
            band_m: rng.range(0.9, 1.5),
            pier_m: rng.range(0.5, 1.2),
            proud_m: 0.02,
        }
    } else {
        Facade::Slabs { recess_m: 0.2, slab_m: 0.35, pier_every: 2 }
    };
    let podium = Mass {
        outline: area,
        low_m: GROUNDED,
        roof_m: podium_m,
        first_floor_m: shop_m,
        floor_m: podium_floor,
        bay_m: rng.range(3.0, 4.5),
        shop: true,
        facade: podium_facade,
        roof: Roof::Flat {
            parapet_m: rng.range(0.9, 1.2),
            slot: [slot::TERRACE, slot::GREEN, slot::ROOF][rng.weighted(&[0.4, 0.14, 0.46])],
        },
        balconies: Vec::new(),
    };
    let floor_m = rng.range(2.95, 3.1);
    // The uppermost floors may step back.
    let crown = if rng.chance(0.4) { 2.0 + rng.below(4) as f64 } else { 0.0 };
    let floors = libm::round((height_m - podium_m) / floor_m - crown).max(10.0);
    let roof_m = podium_m + floors * floor_m;
    let shape: Vec<DVec2> = plate(half, &mut rng).into_iter().map(|p| p + centre).collect();
    let bay_m = rng.range(2.8, 3.6);
    let facade = if rng.chance(0.78) {
        let every = [0, 2, 3, 4][rng.below(4) as usize];
        Facade::Slabs { recess_m: rng.range(0.12, 0.25), slab_m: rng.range(0.22, 0.6), pier_every: every }
    } else {
        Facade::Punched {
            recess_m: rng.range(0.15, 0.25),
            band_m: rng.range(0.9, 1.3),
            pier_m: rng.range(0.6, 1.3),
            proud_m: rng.range(-0.03, 0.12),
        }
    };
    let with_balconies = rng.chance(0.68);
    let rounded = shape.len() > 12;
    let tower = Mass {
        balconies: if with_balconies && !rounded { balconies(&shape, bay_m, &mut rng) } else { Vec::new() },
        outline: shape.clone(),
        low_m: podium_m - 0.4,
        roof_m,
        first_floor_m: podium_m + 0.25,
        floor_m: (roof_m - podium_m - 0.25) / floors,
        bay_m,
        shop: false,
        facade,
        roof: flat(rng.range(0.9, 1.2)),
    };
    let mut masses = vec![podium, tower];
    let mut top_m = roof_m;
    let mut top_half = half - DVec2::splat(1.8);
    if crown > 0.0 {
        let n = crown;
        top_half = half - DVec2::new(rng.range(2.5, 3.5), rng.range(2.0, 3.2));
        top_m = roof_m + n * 3.2;
        masses.push(Mass {
            outline: polygon::oriented_rectangle(centre, DVec2::X, top_half),
            low_m: roof_m - 0.35,
            roof_m: top_m,
            first_floor_m: roof_m + 0.2,
            floor_m: (top_m - roof_m - 0.2) / n,
            bay_m,
            shop: false,
            facade: Facade::Slabs { recess_m: 0.2, slab_m: 0.3, pier_every: 0 },
            roof: flat(0.9),
            balconies: Vec::new(),
        });
    }
    masses.push(penthouse(centre, top_half, top_m, &mut rng));
    let mut plan = grounded(&frame, relief, masses);
    let tower_foot = vec![polygon::oriented_rectangle(centre, DVec2::X, half + DVec2::splat(1.9))];
    let calm = Furnishing { base_m: podium_m, handlers: 0.12, panels: 0.05, beds: 0.75, bulkhead: 0.3 };
    plan.items = furnish(&plan.masses[0].outline.clone(), &tower_foot, calm, &path.child("podium roof"));
    furnish_tops(&mut plan, path);
    Some(Building { kind: Kind::Condo, plan })
}

/// The mechanical penthouse of a tower.
fn penthouse(centre: DVec2, under: DVec2, base_m: f64, rng: &mut Rng) -> Mass {
    let half = DVec2::new(under.x * rng.range(0.45, 0.8), under.y * rng.range(0.45, 0.8));
    let at = centre + DVec2::new(rng.signed() * (under.x - half.x) * 0.5, rng.signed() * (under.y - half.y) * 0.5);
    let roof_m = base_m + rng.range(6.0, 9.0);
    Mass {
        outline: polygon::oriented_rectangle(at, DVec2::X, half),
        low_m: base_m - 0.3,
        roof_m,
        first_floor_m: base_m,
        floor_m: roof_m - base_m,
        bay_m: 0.0,
        shop: false,
        facade: Facade::Plain,
        roof: flat(rng.range(0.5, 0.9)),
        balconies: Vec::new(),
    }
}

/// Furniture of all roofs above the podium: around what stands on them, and on top.
fn furnish_tops(plan: &mut BuildingPlan, path: &SeedPath) {
    for k in 1..plan.masses.len() {
        let outline = plan.masses[k].outline.clone();
        let above: Vec<Vec<DVec2>> = plan.masses.get(k + 1).map(|m| vec![m.outline.clone()]).unwrap_or_default();
        let last = k + 1 == plan.masses.len();
        let what = Furnishing {
            base_m: plan.masses[k].roof_m,
            handlers: if last { 1.2 } else { 0.5 },
            panels: 0.06,
            beds: if last { 0.0 } else { 0.12 },
            bulkhead: if last { 0.5 } else { 0.2 },
        };
        let hull = convex(&outline);
        let mut items =
            furnish(if hull { &outline } else { &outline[..] }, &above, what, &path.child("roof").index(k as u64));
        plan.items.append(&mut items);
    }
}

fn convex(p: &[DVec2]) -> bool {
    (0..p.len()).all(|i| (p[(i + 1) % p.len()] - p[i]).perp_dot(p[(i + 2) % p.len()] - p[(i + 1) % p.len()]) > 0.0)
}

/// An office tower on a low base.
pub(super) fn office(
    site: &Site,
    place: (DVec2, DVec2),
    height_m: f64,
    relief: &Relief<'_>,
    path: &SeedPath,
) -> Option<Building> {
    let frame = Frame::of(site);
    let mut rng = path.child("office").rng();
    let setbacks = Setbacks { street: rng.range(1.0, 4.5), side: rng.range(0.3, 2.5), back: rng.range(1.0, 3.5) };
    let area = buildable(site, &frame, setbacks)?;
    let (centre, half) = place;
    let shop_m = rng.range(5.5, 8.0);
    let base_m = shop_m + 4.2 * (1.0 + rng.below(3) as f64);
    let base = Mass {
        outline: area,
        low_m: GROUNDED,
        roof_m: base_m,
        first_floor_m: shop_m,
        floor_m: 4.2,
        bay_m: 4.5,
        shop: true,
        facade: Facade::Punched { recess_m: 0.25, band_m: 1.3, pier_m: 0.9, proud_m: 0.05 },
        roof: Roof::Flat { parapet_m: 1.1, slot: if rng.chance(0.4) { slot::TERRACE } else { slot::ROOF } },
        balconies: Vec::new(),
    };
    let floor_m = rng.range(3.9, 4.1);
    let curtain = rng.chance(0.65);
    let (facade, bay_m) = if curtain {
        (
            Facade::Curtain { fin_m: if rng.chance(0.6) { rng.range(0.08, 0.25) } else { 0.0 } },
            [1.5, 1.5, 3.0][rng.below(3) as usize],
        )
    } else {
        let proud_m = if rng.chance(0.5) { rng.range(0.08, 0.3) } else { 0.0 };
        (
            Facade::Punched { recess_m: 0.25, band_m: rng.range(1.2, 1.9), pier_m: rng.range(0.5, 1.1), proud_m },
            rng.range(3.0, 4.5),
        )
    };
    let mut masses = vec![base];
    let (mut low, mut h) = (base_m, half);
    let stages = 1 + rng.weighted(&[0.55, 0.3, 0.15]);
    for stage in 0..stages {
        let top =
            if stage + 1 == stages { height_m } else { base_m + (height_m - base_m) * (0.55 + 0.2 * stage as f64) };
        let floors = libm::round((top - low) / floor_m).max(3.0);
        let roof_m = low + floors * floor_m;
        masses.push(Mass {
            outline: polygon::oriented_rectangle(centre, DVec2::X, h),
            low_m: low - 0.5,
            roof_m,
            first_floor_m: low + 0.3,
            floor_m: (roof_m - low - 0.3) / floors,
            bay_m,
            shop: false,
            facade,
            roof: flat(rng.range(0.9, 1.2)),
            balconies: Vec::new(),
        });
        low = roof_m;
        h *= DVec2::new(rng.range(0.75, 0.9), rng.range(0.75, 0.9));
    }
    let under = h - DVec2::splat(1.0);
    masses.push(penthouse(centre, under, low, &mut rng));
    let mut plan = grounded(&frame, relief, masses);
    let foot = vec![polygon::oriented_rectangle(centre, DVec2::X, half + DVec2::splat(0.6))];
    let what = Furnishing { base_m, handlers: 0.3, panels: 0.1, beds: 0.35, bulkhead: 0.3 };
    plan.items = furnish(&plan.masses[0].outline.clone(), &foot, what, &path.child("podium roof"));
    furnish_tops(&mut plan, path);
    Some(Building { kind: Kind::Office, plan })
}

/// A mid-rise block, 18 to 36 m, of one of several shapes.
pub(super) fn mid_rise(site: &Site, relief: &Relief<'_>, path: &SeedPath) -> Option<Building> {
    let frame = Frame::of(site);
    let mut rng = path.child("mid").rng();
    let setbacks = Setbacks { street: rng.range(0.3, 2.5), side: rng.range(0.12, 0.5), back: rng.range(0.6, 4.5) };
    let area = buildable(site, &frame, setbacks)?;
    let (low, high) = polygon::bounds(&area);
    if (high - low).min_element() < 9.0 {
        return None;
    }
    let wide = high.x - low.x > 26.0 && high.y - low.y > 30.0;
    let (a, b) = (rng.range(0.45, 0.7), rng.range(0.32, 0.42));
    let shape: Vec<[f64; 2]> = match if wide { rng.below(5) } else { rng.below(2) } {
        0 => vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        1 => vec![[0.0, 0.0], [1.0, 0.0], [1.0, a], [b + 0.3, a], [b + 0.3, 1.0], [0.0, 1.0]],
        2 => vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [b + 0.2, 1.0], [b + 0.2, a], [0.0, a]],
        3 => vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0 - b, 1.0], [1.0 - b, a], [b, a], [b, 1.0], [0.0, 1.0]],
        _ => vec![
            [0.0, 0.0],
            [b, 0.0],
            [b, a * 0.7],
            [1.0 - b, a * 0.7],
            [1.0 - b, 0.0],
            [1.0, 0.0],
            [1.0, 1.0],
            [0.0, 1.0],
        ],
    };
    let outline = laid_into(&area, &shape);
    let shop = rng.chance(0.6);
    let first_floor_m = if shop { rng.range(4.2, 5.2) } else { 1.0 };
    let floor_m = rng.range(3.1, 3.6);
    let floors = rng.range(4.6, 10.4).round();
    let roof_m = first_floor_m + floors * floor_m;
    let bay_m = rng.range(2.8, 4.2);
    let facade = match rng.weighted(&[0.7, 0.3]) {
        0 => Facade::Punched {
            recess_m: rng.range(0.12, 0.25),
            band_m: rng.range(1.2, 1.8),
            pier_m: rng.range(0.8, 1.8),
            proud_m: rng.range(-0.03, 0.06),
        },
        _ => Facade::Slabs { recess_m: 0.2, slab_m: 0.4, pier_every: 2 },
    };
    let with_balconies = rng.chance(0.3);
    let mut masses = vec![Mass {
        balconies: if with_balconies {
            street_only(&outline, site, &frame, balconies(&outline, bay_m, &mut rng))
        } else {
            Vec::new()
        },
        outline,
        low_m: GROUNDED,
        roof_m,
        first_floor_m,
        floor_m,
        bay_m,
        shop,
        facade,
        roof: flat(rng.range(0.7, 1.2)),
    }];
    let mut above = Vec::new();
    if shape.len() == 4 && rng.chance(0.45) {
        // One or two floors stepped back.
        if let Some(inner) = polygon::inset(&masses[0].outline, rng.range(2.2, 4.0)) {
            let (l, h) = polygon::bounds(&inner);
            if (h - l).min_element() > 6.0 {
                let top = roof_m + 3.3 * (1.0 + rng.below(2) as f64);
                above.push(inner.clone());
                masses.push(Mass {
                    outline: inner,
                    low_m: roof_m - 0.3,
                    roof_m: top,
                    first_floor_m: roof_m + 0.2,
                    floor_m: 3.25,
                    bay_m,
                    shop: false,
                    facade: Facade::Slabs { recess_m: 0.2, slab_m: 0.35, pier_every: 2 },
                    roof: flat(0.6),
                    balconies: Vec::new(),
                });
            }
        }
    }
    if shape.len() == 4 && above.is_empty() && rng.chance(0.75) {
        // Machine room, off the middle.
        let half = DVec2::new(rng.range(2.5, 6.0), rng.range(2.2, 4.5));
        let at = polygon::centroid(&masses[0].outline) + DVec2::new(rng.signed() * 4.0, rng.signed() * 6.0);
        let room = polygon::oriented_rectangle(at, DVec2::X, half);
        if room.iter().all(|p| {
            polygon::contains(&masses[0].outline, *p) && polygon::border_distance(&masses[0].outline, *p) > 1.5
        }) {
            above.push(room.clone());
            masses.push(Mass {
                outline: room,
                low_m: roof_m - 0.3,
                roof_m: roof_m + rng.range(3.0, 5.0),
                first_floor_m: roof_m,
                floor_m: 4.0,
                bay_m: 0.0,
                shop: false,
                facade: Facade::Plain,
                roof: flat(rng.range(0.2, 0.6)),
                balconies: Vec::new(),
            });
        }
    }
    let mut plan = grounded(&frame, relief, masses);
    for k in 0..plan.masses.len() {
        let what =
            Furnishing { base_m: plan.masses[k].roof_m, handlers: 0.75, panels: 0.15, beds: 0.12, bulkhead: 0.9 };
        let over: &[Vec<DVec2>] = if k == 0 { &above } else { &[] };
        let items = furnish(&plan.masses[k].outline.clone(), over, what, &path.child("roof").index(k as u64));
        plan.items.extend(items);
    }
    Some(Building { kind: Kind::Block, plan })
}

/// Balconies on edges whose front is free: not towards a party wall.
fn street_only(outline: &[DVec2], site: &Site, frame: &Frame, all: Vec<Balcony>) -> Vec<Balcony> {
    let local: Vec<DVec2> = site.outline.iter().map(|p| frame.local(*p)).collect();
    all.into_iter()
        .filter(|b| {
            let (p, q) = (outline[b.edge], outline[(b.edge + 1) % outline.len()]);
            let outward = -(q - p).normalize().perp();
            polygon::contains(&local, (p + q) * 0.5 + outward * 2.2)
        })
        .collect()
}

/// One or two storeys over nearly the whole site.
pub(super) fn shop(site: &Site, relief: &Relief<'_>, path: &SeedPath) -> Option<Building> {
    let frame = Frame::of(site);
    let mut rng = path.child("shop").rng();
    let setbacks = Setbacks { street: rng.range(0.2, 1.2), side: rng.range(0.1, 0.3), back: rng.range(0.6, 5.0) };
    let area = buildable(site, &frame, setbacks)?;
    let a = rng.range(0.45, 0.75);
    let outline = if rng.chance(0.55) {
        laid_into(&area, &[[0.0, 0.0], [1.0, 0.0], [1.0, a], [0.55, a], [0.55, 1.0], [0.0, 1.0]])
    } else {
        area
    };
    let floors = 1.0 + rng.below(3) as f64;
    let floor_m = rng.range(3.6, 4.3);
    let roof_m = floors * floor_m + rng.range(0.5, 1.2);
    let mass = Mass {
        outline,
        low_m: GROUNDED,
        roof_m,
        first_floor_m: 0.0,
        floor_m,
        bay_m: rng.range(3.2, 5.0),
        shop: false,
        facade: Facade::Plain,
        roof: flat(rng.range(0.4, 1.0)),
        balconies: Vec::new(),
    };
    let mut plan = grounded(&frame, relief, vec![mass]);
    let what = Furnishing { base_m: roof_m, handlers: 0.9, panels: 0.1, beds: 0.03, bulkhead: 0.35 };
    plan.items = furnish(&plan.masses[0].outline.clone(), &[], what, &path.child("roof"));
    Some(Building { kind: Kind::Shop, plan })
}
