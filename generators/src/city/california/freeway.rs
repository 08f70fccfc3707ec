//! A stack interchange: two freeways on embankments and viaducts, one over the other, and ramps over both.
//!
//! Everything is a closed sweep along a line: decks with their barriers, embankments that reach into the ground, piers down
//! through them. Under a deck there is air.

use super::Params;
use super::land::Land;
use super::layout::{Grid, Line};
use super::lot::{Plant, Planted};
use crate::city::toronto::traffic::draw_body;
use crate::kit::mesh_builder::{MeshBuilder, Wall};
use crate::kit::polygon;
use crate::kit::sweep;
use crate::kit::vehicles::Body;
use glam::{DVec2, DVec3};
use satseed_scene::{Mesh, SeedPath};

/// Slots of a freeway's mesh.
pub(super) mod slot {
    /// Carriageway of a freeway, V from its middle.
    pub(in super::super) const LANES: u16 = 0;
    /// Carriageway of a ramp.
    pub(in super::super) const RAMP: u16 = 1;
    /// Barriers, sides, undersides, piers.
    pub(in super::super) const CONCRETE: u16 = 2;
    /// Slopes of embankments.
    pub(in super::super) const SLOPE: u16 = 3;
    pub(in super::super) const COUNT: usize = 4;
}

/// Half width of a freeway's deck: four lanes of 3.6 m, shoulders of 3 and 1.5 m, half the median barrier.
const HALF_M: f64 = 19.4;
/// Half width of a ramp's deck: a lane of 3.6 m, shoulders of 1.2 and 3 m, barriers.
const RAMP_HALF_M: f64 = 4.2;
/// Thickness of a deck, m.
const DECK_M: f64 = 1.8;
/// Height of a barrier, m.
const BARRIER_M: f64 = 0.82;
/// Heights of the four decks above the ground, m: 7.4 m apart.
pub(super) const LEVELS_M: [f64; 4] = [6.8, 14.2, 21.6, 29.0];
/// Ramps leave and join at this distance from the freeway's middle, m.
const BESIDE_M: f64 = HALF_M + RAMP_HALF_M + 0.15;
/// The freeways end this far from the crossing, m.
const REACH_M: f64 = 2280.0;
/// Points along a line stand this far apart, m.
const STEP_M: f64 = 6.0;

/// A vehicle on a deck.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Driving {
    pub(super) at: DVec3,
    /// Direction, unit, with its rise.
    pub(super) axis: DVec3,
    pub(super) body: Body,
}

/// Everything of an interchange.
#[derive(Clone, Debug, Default)]
pub(super) struct Interchange {
    /// Named pieces of structure in the world's frame.
    pub(super) pieces: Vec<(String, Mesh)>,
    pub(super) vehicles: Vec<Driving>,
    pub(super) plants: Vec<Planted>,
    /// Outlines of what is open below, world.
    pub(super) spans: Vec<Vec<DVec2>>,
    /// Outlines of all decks.
    pub(super) decks: Vec<Vec<DVec2>>,
}

/// A point of a line: place on the sheet, height above the ground, height of the barrier.
#[derive(Clone, Copy)]
struct Post {
    flat: DVec2,
    above_m: f64,
    barrier_m: f64,
}

fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Height of the lower and of the upper freeway's deck at a distance from the crossing, m.
fn freeway_m(upper: bool, s: f64) -> f64 {
    let rise = LEVELS_M[1] - LEVELS_M[0];
    LEVELS_M[0] + if upper { rise * (1.0 - smooth((s.abs() - 75.0) / 230.0)) } else { 0.0 }
}

/// A place by its distance along and to the left of freeway `upper`, sheet; the crossing is at `centre`.
fn place(centre: DVec2, upper: bool, s: f64, left: f64) -> DVec2 {
    // The lower one runs north, the upper one west.
    let along = if upper { -DVec2::X } else { DVec2::Y };
    centre + along * s + along.perp() * left
}

struct Sweep<'a> {
    land: &'a Land,
    /// World place, direction, height of the surface (world), height above the ground.
    stations: Vec<(DVec2, DVec2, f64, f64)>,
    posts: Vec<Post>,
}

impl<'a> Sweep<'a> {
    fn new(land: &'a Land, posts: Vec<Post>) -> Self {
        let world: Vec<DVec2> = posts.iter().map(|p| land.world(p.flat)).collect();
        let stations = (0..posts.len())
            .map(|k| {
                let (a, b) = (world[k.saturating_sub(1)], world[(k + 1).min(world.len() - 1)]);
                (world[k], (b - a).normalize(), land.height_m(world[k]) + posts[k].above_m, posts[k].above_m)
            })
            .collect();
        Self { land, stations, posts }
    }

    /// A solid between two stations.
    fn solid(&self, b: &mut MeshBuilder, from: usize, to: usize, section: &dyn Fn(usize) -> Vec<DVec2>, slots: &[u16]) {
        let station = |k: usize| {
            let (at, direction, height_m, _) = self.stations[k];
            sweep::Station { at, direction, height_m }
        };
        sweep::solid(b, &station, from..=to, section, slots);
    }

    /// A deck with its barriers from one station to another.
    fn deck(&self, b: &mut MeshBuilder, from: usize, to: usize, half: f64, surface: u16) {
        let section = |k: usize| {
            let h = self.posts[k].barrier_m;
            let w = 0.3;
            [
                (-half + 0.7, -DECK_M),
                (half - 0.7, -DECK_M),
                (half, -0.5),
                (half, h),
                (half - w, h),
                (half - w, 0.0),
                (-half + w, 0.0),
                (-half + w, h),
                (-half, h),
                (-half, -0.5),
            ]
            .map(|(x, y)| DVec2::new(x, y))
            .to_vec()
        };
        let c = slot::CONCRETE;
        self.solid(b, from, to, &section, &[c, c, c, c, c, surface, c, c, c, c]);
    }

    /// An embankment under a deck, its top hidden inside the deck.
    fn embankment(&self, b: &mut MeshBuilder, from: usize, to: usize, half: f64) {
        let section = |k: usize| {
            let h = self.stations[k].3;
            let foot = half + 2.0 * (h + 0.6);
            [(-foot, -h - 0.6), (foot, -h - 0.6), (half, -0.9), (-half, -0.9)].map(|(x, y)| DVec2::new(x, y)).to_vec()
        };
        self.solid(b, from, to, &section, &[slot::SLOPE; 4]);
    }

    /// Outline of a stretch, world.
    fn outline(&self, from: usize, to: usize, half: f64) -> Vec<DVec2> {
        let side = |k: usize, w: f64| self.stations[k].0 + self.stations[k].1.perp() * w;
        let mut out: Vec<DVec2> = (from..=to).map(|k| side(k, -half)).collect();
        out.extend((from..=to).rev().map(|k| side(k, half)));
        out
    }

    /// A pier with its cap under station `k`, `offset` to the left.
    fn pier(&self, b: &mut MeshBuilder, k: usize, offset: f64, half: f64) {
        let (p, d, z, above) = self.stations[k];
        let foot = p + d.perp() * offset;
        let low = self.land.height_m(foot) - 1.5;
        if above < 4.0 {
            return;
        }
        let top = z - DECK_M;
        let column = if above > 16.0 { 1.25 } else { 1.0 };
        let shaft = polygon::oriented_rectangle(foot, d, DVec2::new(column, column * 1.25));
        b.prism(slot::CONCRETE, slot::CONCRETE, &polygon::rounded(&shaft, 0.6, 2), low, top - 0.7, Wall::PLAIN);
        let cap = polygon::oriented_rectangle(foot, d, DVec2::new(column + 0.15, half));
        let crown = polygon::oriented_rectangle(foot, d, DVec2::new(column * 0.8, column * 1.3));
        // The cap widens upward and ends inside the deck.
        b.frustum(slot::CONCRETE, slot::CONCRETE, &crown, &cap, top - 1.7, top + 0.25);
    }

    fn length(&self) -> f64 {
        self.stations.windows(2).map(|w| w[0].0.distance(w[1].0)).sum()
    }

    /// Place and direction at a distance along, `left` of the middle.
    fn at(&self, mut s: f64, left: f64) -> Option<(DVec3, DVec3)> {
        for w in self.stations.windows(2) {
            let length = w[0].0.distance(w[1].0);
            if s <= length {
                let t = s / length;
                let d = w[0].1.lerp(w[1].1, t).normalize();
                let p = w[0].0.lerp(w[1].0, t) + d.perp() * left;
                let z = w[0].2 + (w[1].2 - w[0].2) * t;
                let axis = d.extend((w[1].2 - w[0].2) / length).normalize();
                return Some((p.extend(z), axis));
            }
            s -= length;
        }
        None
    }
}

/// The interchange at the crossing of the two freeways.
pub(super) fn plan(params: &Params, grid: &Grid, land: &Land, city: &SeedPath) -> Interchange {
    let mut out = Interchange::default();
    let centre = DVec2::new(grid.position(0, 0), grid.position(1, 0));
    let key = city.child("interchange");
    for upper in [false, true] {
        freeway(params, grid, land, centre, upper, &key, &mut out);
    }
    for quarter in 0..4_u32 {
        left_ramp(params, land, centre, quarter, &key, &mut out);
        right_ramp(params, land, centre, quarter, &key, &mut out);
    }
    out
}

/// Half of the open stretch around the crossing, m.
const VIADUCT_M: [f64; 2] = [70.0, 105.0];

fn freeway(
    params: &Params,
    grid: &Grid,
    land: &Land,
    centre: DVec2,
    upper: bool,
    key: &SeedPath,
    out: &mut Interchange,
) {
    let name = if upper { "upper" } else { "lower" };
    let key = key.child(name);
    let count = (2.0 * REACH_M / STEP_M) as i64;
    let s_of = |k: i64| -REACH_M + k as f64 * STEP_M;
    let posts = (0..=count)
        .map(|k| Post {
            flat: place(centre, upper, s_of(k), 0.0),
            above_m: freeway_m(upper, s_of(k)),
            barrier_m: BARRIER_M,
        })
        .collect();
    let sweep = Sweep::new(land, posts);
    let mut b = MeshBuilder::default();
    let n = count as usize;
    sweep.deck(&mut b, 0, n, HALF_M, slot::LANES);
    let median =
        |_: usize| [(-0.3, -0.2), (0.3, -0.2), (0.12, 0.9), (-0.12, 0.9)].map(|(x, y)| DVec2::new(x, y)).to_vec();
    sweep.solid(&mut b, 0, n, &median, &[slot::CONCRETE; 4]);
    out.decks.push(sweep.outline(0, n, HALF_M));
    // Lines that cross under it, and the crossing itself.
    let axis = usize::from(!upper);
    let sign = if upper { -1.0 } else { 1.0 };
    let mut gaps = vec![[-VIADUCT_M[usize::from(upper)], VIADUCT_M[usize::from(upper)]]];
    for k in grid.numbers(axis, REACH_M) {
        if grid.kind(axis, k) != Line::Freeway {
            let s = sign * (grid.position(axis, k) - centre[axis]);
            let half = grid.kind(axis, k).half_row_m() + 5.0;
            gaps.push([s - half, s + half]);
        }
    }
    gaps.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let index = |s: f64| (((s + REACH_M) / STEP_M).round().max(0.0) as usize).min(n);
    let mut from = 0;
    for [low, high] in gaps {
        let (a, z) = (index(low), index(high));
        if a > from {
            sweep.embankment(&mut b, from, a, HALF_M - 0.9);
        }
        if z > a {
            out.spans.push(sweep.outline(a, z, HALF_M));
        }
        if z > a + 10 {
            let bents = (((z - a) as f64 * STEP_M) / 36.0).round() as usize;
            for k in 1..bents {
                let station = a + (z - a) * k / bents;
                // None in the way of what crosses below.
                if !upper || (s_of(station as i64)).abs() > 26.0 {
                    for offset in [-11.5, 0.0, 11.5] {
                        sweep.pier(&mut b, station, offset, 6.2);
                    }
                }
            }
        }
        from = from.max(z);
    }
    if from < n {
        sweep.embankment(&mut b, from, n, HALF_M - 0.9);
    }
    out.pieces.push((format!("freeway/{name}"), b.finish()));
    for (l, left) in [-14.6, -11.0, -7.4, -3.8].into_iter().enumerate() {
        for way in [1.0, -1.0] {
            // Who keeps right drives forward on the negative side.
            traffic(
                params,
                &sweep,
                way * left,
                way,
                &key.child("lane").index(l as u64).child(if way > 0.0 { "on" } else { "back" }),
                [15.0, 35.0],
                out,
            );
        }
    }
    verge(params, land, centre, upper, &key, out);
}

/// Shrubs and a few trees along the foot of the embankments.
fn verge(params: &Params, land: &Land, centre: DVec2, upper: bool, key: &SeedPath, out: &mut Interchange) {
    let mut rng = key.child("verge").rng();
    let mut s = -REACH_M;
    while s < REACH_M {
        for side in [1.0, -1.0] {
            if s.abs() > 60.0 && rng.chance((0.75 * params.trees).min(1.0)) {
                let tree = rng.chance(0.3);
                let left = side * rng.range(39.0, 44.5);
                let plant = if tree { Plant::Broad } else { Plant::Shrub };
                let flat = place(centre, upper, s + rng.signed() * 2.0, left);
                let size = if tree { rng.range(0.6, 1.2) } else { rng.range(0.9, 2.2) };
                out.plants.push(Planted { at: land.world(flat), plant, size });
            }
        }
        s += 5.0;
    }
}

fn traffic(
    params: &Params,
    sweep: &Sweep<'_>,
    left: f64,
    way: f64,
    key: &SeedPath,
    per_km: [f64; 2],
    out: &mut Interchange,
) {
    let mut rng = key.rng();
    let per_m = rng.range(per_km[0], per_km[1]) / 1000.0 * params.vehicles;
    if per_m <= 0.0 {
        return;
    }
    let length = sweep.length();
    let mut s = rng.range(0.0, 60.0);
    while s < length - 8.0 {
        let body = draw_body(&mut rng, true);
        let size = body.size_m()[0];
        let middle = s + size / 2.0;
        let at = if way > 0.0 { middle } else { length - middle };
        if let Some((p, axis)) = sweep.at(at, left + rng.signed() * 0.25) {
            out.vehicles.push(Driving { at: p, axis: axis * way, body });
        }
        s += size + 5.0 - libm::log(1.0 - rng.unit()) / per_m;
    }
}

/// A ramp as posts along a path of the quarter that turns the crossing's frame; x to the right of, y along the freeway
/// that it leaves.
#[allow(clippy::too_many_arguments)]
fn ramp(
    params: &Params,
    land: &Land,
    centre: DVec2,
    quarter: u32,
    path: &[DVec2],
    above: &dyn Fn(f64) -> f64,
    name: &str,
    key: &SeedPath,
    out: &mut Interchange,
) {
    let turn = (0..quarter).fold(DVec2::X, |d, _| d.perp());
    let total: f64 = path.windows(2).map(|w| w[0].distance(w[1])).sum();
    let mut posts = Vec::with_capacity(path.len());
    let mut s = 0.0;
    for (k, p) in path.iter().enumerate() {
        if k > 0 {
            s += p.distance(path[k - 1]);
        }
        // At its ends it lies under the freeway's surface and has no barriers of its own.
        let end = s.min(total - s);
        let free = smooth((end - 62.0) / 14.0);
        posts.push(Post {
            flat: centre + turn.rotate(*p),
            above_m: above(s) - 0.14 * (1.0 - free),
            barrier_m: 0.02 + (BARRIER_M - 0.02) * free,
        });
    }
    let sweep = Sweep::new(land, posts);
    let mut b = MeshBuilder::default();
    let n = path.len() - 1;
    sweep.deck(&mut b, 0, n, RAMP_HALF_M, slot::RAMP);
    out.decks.push(sweep.outline(0, n, RAMP_HALF_M));
    // Low parts stand on earth, high ones on piers.
    let earthen = |k: usize| sweep.stations[k].3 < 8.6;
    let mut from = 0;
    while from < n {
        let kind = earthen(from);
        let mut to = from + 1;
        while to < n && earthen(to) == kind {
            to += 1;
        }
        if kind {
            sweep.embankment(&mut b, from, to, RAMP_HALF_M - 0.9);
        } else {
            out.spans.push(sweep.outline(from, to, RAMP_HALF_M));
            let bents = ((to - from) as f64 * STEP_M / 36.0).round().max(1.0) as usize;
            for k in 1..bents {
                let station = from + (to - from) * k / bents;
                let p = path[station];
                // Not through the freeways below.
                let near = |x: f64| x.abs() < HALF_M + 2.5;
                if !near(p.x) && !near(p.y) {
                    sweep.pier(&mut b, station, 0.0, RAMP_HALF_M - 0.6);
                }
            }
        }
        from = to;
    }
    let name = format!("ramp/{name}/{quarter}");
    let key = key.child(&name);
    out.pieces.push((name, b.finish()));
    for (l, left) in [0.8].into_iter().enumerate() {
        traffic(params, &sweep, left, 1.0, &key.child("lane").index(l as u64), [6.0, 18.0], out);
    }
}

/// A polyline divided into pieces of about [`STEP_M`].
fn divided(points: &[DVec2]) -> Vec<DVec2> {
    let mut out = Vec::new();
    for w in points.windows(2) {
        let n = libm::ceil(w[0].distance(w[1]) / STEP_M).max(1.0) as usize;
        out.extend((0..n).map(|k| w[0].lerp(w[1], k as f64 / n as f64)));
    }
    out.extend(points.last());
    out
}

fn arc(centre: DVec2, radius: f64, from_rad: f64, to_rad: f64) -> Vec<DVec2> {
    let n = libm::ceil((to_rad - from_rad).abs() * radius / STEP_M) as usize;
    (0..=n)
        .map(|k| {
            let (s, c) = libm::sincos(from_rad + (to_rad - from_rad) * k as f64 / n as f64);
            centre + DVec2::new(c, s) * radius
        })
        .collect()
}

/// From one freeway over both to the left of it.
fn left_ramp(params: &Params, land: &Land, centre: DVec2, quarter: u32, key: &SeedPath, out: &mut Interchange) {
    let top = LEVELS_M[2 + (quarter % 2) as usize];
    let run = if quarter.is_multiple_of(2) { 400.0 } else { 480.0 };
    let r = 135.0;
    let x = BESIDE_M;
    let mut path =
        divided(&[DVec2::new(HALF_M - RAMP_HALF_M - 0.4, -run - 70.0), DVec2::new(x, -run), DVec2::new(x, x - r)]);
    path.pop();
    path.extend(arc(DVec2::new(x - r, x - r), r, 0.0, core::f64::consts::FRAC_PI_2));
    path.pop();
    path.extend(divided(&[
        DVec2::new(x - r, x),
        DVec2::new(-run, x),
        DVec2::new(-run - 70.0, HALF_M - RAMP_HALF_M - 0.4),
    ]));
    let total: f64 = path.windows(2).map(|w| w[0].distance(w[1])).sum();
    // Quarters 0 and 2 leave the lower freeway for the upper one, the others the other way.
    let leaves_upper = quarter % 2 == 1;
    let distance = |s: f64| run + 70.0 - s;
    let above = |s: f64| {
        let climb = run + x - r;
        let end = s.min(total - s);
        let t = smooth((end - 75.0) / (climb - 5.0));
        let upper = if s < total / 2.0 { leaves_upper } else { !leaves_upper };
        let base = freeway_m(upper, distance(end));
        base + (top - base) * t
    };
    ramp(params, land, centre, quarter, &path, &above, "left", key, out);
}

/// From one freeway to the right of it, low and outside of all.
fn right_ramp(params: &Params, land: &Land, centre: DVec2, quarter: u32, key: &SeedPath, out: &mut Interchange) {
    let x = BESIDE_M + 2.0 * RAMP_HALF_M + 1.2;
    let r = 150.0;
    let run = 330.0;
    let mut path = divided(&[DVec2::new(BESIDE_M, -run - 80.0), DVec2::new(x, -run), DVec2::new(x, -x - r)]);
    path.pop();
    path.extend(arc(DVec2::new(x + r, -x - r), r, core::f64::consts::PI, core::f64::consts::FRAC_PI_2));
    path.pop();
    path.extend(divided(&[DVec2::new(x + r, -x), DVec2::new(run, -x), DVec2::new(run + 80.0, -BESIDE_M)]));
    let total: f64 = path.windows(2).map(|w| w[0].distance(w[1])).sum();
    let leaves_upper = quarter % 2 == 1;
    let above = |s: f64| {
        let end = s.min(total - s);
        let upper = if s < total / 2.0 { leaves_upper } else { !leaves_upper };
        let base = freeway_m(upper, run + 80.0 - end);
        base + (3.4 - base) * smooth((end - 90.0) / 220.0)
    };
    ramp(params, land, centre, quarter, &path, &above, "right", key, out);
}
