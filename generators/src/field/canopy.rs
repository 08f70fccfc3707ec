//! Closed canopies: sheets at the crop's height with sides down to the ground, and tramlines as gaps between them.

use super::crops::{Crop, Form};
use super::plan::Parcel;
use super::relief::Relief;
use crate::kit::polygon;
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::sampling::smoothstep;
use crate::kit::terrain::tin::Ground;
use glam::{DVec2, DVec3};
use satseed_scene::{Mesh, quantise_m};
use std::collections::BTreeSet;

/// Slot of a canopy's top.
pub(super) const TOP: u16 = 0;
/// Slot of its sides.
pub(super) const SIDE: u16 = 1;

/// Distance of a sheet's vertices, m.
const STEP_M: f64 = 2.4;
/// From the middle of a tramline to that of a wheel's track, and half the track's width, m.
const WHEEL_M: [f64; 2] = [1.0, 0.26];
/// How tightly a sprayer turns, m, and the chords of the turn.
const TURN_M: f64 = 6.5;
const ARC: usize = 4;
/// How far a parcel's rim recedes at most where sowing was uneven, and how far a wheel's track wanders, m.
const RAGGED_M: f64 = 0.55;
const WANDER_M: f64 = 0.22;
/// Share of a wheel's track that plants at its sides close at most.
const CLOSED: f64 = 0.72;
/// Height of plants beside a wheel's track, and at a parcel's rim, as shares of those within.
const BESIDE: f64 = 0.8;
const AT_RIM: f64 = 0.42;
/// How far the sides go below the ground, m.
const ROOT_M: f64 = 0.35;
/// From a parcel's outline to its crop, m.
pub(super) const RIM_M: f64 = 0.35;

/// The sheets of a parcel that reach tiles of full detail.
pub(super) fn sheets(relief: &Relief, parcel: &Parcel) -> Vec<Mesh> {
    let Form::Slab { height_m, boom_m, .. } = parcel.crop.facts().form else { return Vec::new() };
    let cereal = matches!(parcel.crop, Crop::WheatGreen | Crop::WheatRipe | Crop::Barley);
    let canopy = Canopy { relief, height_m, cereal };
    let mut meshes = Vec::new();
    let mut keep = |points: &[Vec<DVec2>], sides: Sides| {
        if points.iter().flatten().any(|p| relief.is_detailed(*p)) {
            meshes.push(canopy.sheet(points, sides));
        }
    };
    let (mut rim_m, mut turn_m) = (RIM_M, 0.0);
    let [wheel, half] = WHEEL_M;
    if boom_m > 0.0 {
        // The headland's own tramline runs round the parcel at half a boom.
        let c = boom_m / 2.0;
        let inner = c + wheel + half;
        if [RIM_M, inner].iter().all(|d| inset(&parcel.outline, *d).is_some()) {
            for [from, to] in [[RIM_M, c - wheel - half], [c - wheel + half, c + wheel - half]] {
                let sides = if from > RIM_M { Sides::Band } else { Sides::Outermost };
                for ring in ring(relief, parcel, from, to, c + TURN_M) {
                    keep(&ring, sides);
                }
            }
            rim_m = inner;
            turn_m = c + TURN_M - inner;
        }
    }
    let Some(area) = Area::new(relief, parcel, rim_m, turn_m) else { return meshes };
    let [low, high] = area.span();
    let mut cuts: Vec<[f64; 2]> = Vec::new();
    if boom_m > 0.0 {
        let mut from = low;
        // The headland's turn sprays one boom along the rim; passes lie one boom apart from one side on, and the last
        // one leaves no room for another.
        let first = low + boom_m - wheel - half;
        let last = libm::floor((high - 0.5 * boom_m - first) / boom_m) as i64;
        for k in 0..=last {
            let middle = first + k as f64 * boom_m;
            for side in [-wheel, wheel] {
                let at = middle + side;
                if at - half > low && at + half < high {
                    cuts.push([from, at - half]);
                    from = at + half;
                }
            }
        }
        cuts.push([from, high]);
    } else {
        let wide = 16.0;
        let first = libm::floor(low / wide) as i64;
        for k in first..=libm::floor(high / wide) as i64 {
            cuts.push([(k as f64 * wide).max(low), ((k + 1) as f64 * wide).min(high)]);
        }
    }
    for [from, to] in cuts.into_iter().filter(|[a, b]| b - a > 0.3) {
        for strip in area.strip(from, to) {
            keep(&strip, if boom_m > 0.0 { Sides::Strip } else { Sides::Meeting });
        }
    }
    meshes
}

/// A convex outline moved inward by a distance, with all its corners; none if an edge would vanish.
pub(super) fn inset(outline: &[DVec2], distance_m: f64) -> Option<Vec<DVec2>> {
    let moved = polygon::mitred(outline, distance_m);
    let n = outline.len();
    let kept = (0..n).all(|k| {
        let (before, after) = (outline[(k + 1) % n] - outline[k], moved[(k + 1) % n] - moved[k]);
        before.dot(after) > 0.0 && after.length() > 1.0
    });
    kept.then_some(moved)
}

/// Which corners turn by more than some 14 degrees.
fn sharp_corners(outline: &[DVec2]) -> Vec<bool> {
    let n = outline.len();
    (0..n)
        .map(|i| {
            let (a, p, b) = (outline[(i + n - 1) % n], outline[i], outline[(i + 1) % n]);
            (p - a).normalize().dot((b - p).normalize()) < 0.97
        })
        .collect()
}

/// A convex outline with arcs of [`ARC`] chords at its sharp corners; as many points whatever the radius.
fn rounded(outline: &[DVec2], sharp: &[bool], radius_m: f64) -> Vec<DVec2> {
    let n = outline.len();
    let mut out = Vec::with_capacity(n + ARC * sharp.len());
    for i in 0..n {
        let (a, p, b) = (outline[(i + n - 1) % n], outline[i], outline[(i + 1) % n]);
        if !sharp[i] {
            out.push(p);
            continue;
        }
        let (u, v) = ((a - p).normalize(), (b - p).normalize());
        let cos = u.dot(v).clamp(-1.0, 1.0);
        // Half the corner's angle by the half-angle formulas.
        let tan_half = ((1.0 - cos) / (1.0 + cos)).sqrt().max(0.2);
        let reach = (radius_m / tan_half).min(0.4 * a.distance(p)).min(0.4 * p.distance(b));
        let (from, to) = (p + u * reach, p + v * reach);
        for s in 0..=ARC {
            let t = s as f64 / ARC as f64;
            out.push(from * ((1.0 - t) * (1.0 - t)) + p * (2.0 * t * (1.0 - t)) + to * (t * t));
        }
    }
    out
}

/// Grids of points over the band between two distances from the outline: one for each edge.
/// Corners are rounded so that the radius would be 0 at `turn_m` from the outline; at its rim they stay sharp.
fn ring(relief: &Relief, parcel: &Parcel, from_m: f64, to_m: f64, turn_m: f64) -> Vec<Vec<Vec<DVec2>>> {
    let (Some(outer), Some(inner)) = (inset(&parcel.outline, from_m), inset(&parcel.outline, to_m)) else {
        return Vec::new();
    };
    let radius = |d: f64| if d > RIM_M { turn_m - d } else { 0.0 };
    let sharp = sharp_corners(&parcel.outline);
    let (outer, inner) = (rounded(&outer, &sharp, radius(from_m)), rounded(&inner, &sharp, radius(to_m)));
    let n = outer.len();
    let rows = libm::ceil((to_m - from_m) / STEP_M).max(1.0) as usize;
    (0..n)
        .map(|k| {
            let m = (k + 1) % n;
            let longer = outer[k].distance(outer[m]).max(inner[k].distance(inner[m]));
            let columns = libm::ceil(longer / STEP_M).max(1.0) as usize;
            (0..=rows)
                .map(|j| {
                    let t = j as f64 / rows as f64;
                    let (a, b) = (outer[k].lerp(inner[k], t), outer[m].lerp(inner[m], t));
                    (0..=columns).map(|i| relief.plan.warp.world(a.lerp(b, i as f64 / columns as f64))).collect()
                })
                .collect()
        })
        .collect()
}

/// The part of a parcel that lies farther than a distance from its outline, in the frame of its rows.
pub(super) struct Area {
    axis: DVec2,
    /// Its border, (along, across).
    local: Vec<DVec2>,
}

impl Area {
    /// None where nothing is left. Corners are rounded with a radius `turn_m`.
    pub(super) fn new(relief: &Relief, parcel: &Parcel, distance_m: f64, turn_m: f64) -> Option<Self> {
        let inner = match inset(&parcel.outline, distance_m) {
            Some(inner) => inner,
            None => polygon::inset(&parcel.outline, distance_m)?,
        };
        let inner = if turn_m > 0.0 { rounded(&inner, &sharp_corners(&inner), turn_m) } else { inner };
        let axis = parcel.axis;
        let local = polygon::subdivided(&inner, 5.0)
            .iter()
            .map(|q| relief.plan.warp.world(*q))
            .map(|p| DVec2::new(p.dot(axis), axis.perp_dot(p)))
            .collect();
        Some(Self { axis, local })
    }

    /// Least and greatest place across the rows, m.
    pub(super) fn span(&self) -> [f64; 2] {
        let (low, high) = polygon::bounds(&self.local);
        [low.y, high.y]
    }

    /// Where a line along the rows at a place across them lies within: the longest stretch.
    pub(super) fn stretch(&self, v: f64) -> Option<[f64; 2]> {
        let n = self.local.len();
        let mut found: Vec<f64> = (0..n)
            .filter_map(|k| {
                let (a, b) = (self.local[k], self.local[(k + 1) % n]);
                ((a.y > v) != (b.y > v)).then(|| a.x + (v - a.y) / (b.y - a.y) * (b.x - a.x))
            })
            .collect();
        found.sort_by(f64::total_cmp);
        let pairs = found.chunks_exact(2).map(|c| [c[0], c[1]]);
        pairs.max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))
    }

    /// World place of one in the rows' frame.
    pub(super) fn world(&self, u: f64, v: f64) -> DVec2 {
        self.axis * u + self.axis.perp() * v
    }

    /// Grids of points over the strip between two places across the rows.
    fn strip(&self, from: f64, to: f64) -> Vec<Vec<Vec<DVec2>>> {
        let rows = libm::ceil((to - from) / STEP_M).max(1.0) as usize;
        let [low, high] = self.span();
        let at = |v: f64| self.stretch(v.clamp(low + 0.02, high - 0.02)).filter(|[a, b]| b - a > 0.4);
        let mut lines: Vec<(f64, Option<[f64; 2]>)> = Vec::new();
        for j in 0..=rows {
            let v = from + (to - from) * j as f64 / rows as f64;
            let line = (v, at(v));
            if let Some(before) = lines.last().copied() {
                between(before, line, &at, &mut lines);
            }
            lines.push(line);
        }
        let mut grids = Vec::new();
        let mut run: Vec<(f64, [f64; 2])> = Vec::new();
        let mut finish = |run: &mut Vec<(f64, [f64; 2])>| {
            if run.len() > 1 {
                // Columns stand on one grid for all strips; a row's ends cut it short.
                let (low, high) = run.iter().fold((f64::MAX, f64::MIN), |(l, h), (_, [a, b])| (l.min(*a), h.max(*b)));
                let (first, last) = (libm::floor(low / STEP_M) as i64, libm::ceil(high / STEP_M) as i64);
                let row = |(v, [a, b]): &(f64, [f64; 2])| -> Vec<DVec2> {
                    (first..=last).map(|k| self.world((k as f64 * STEP_M).clamp(*a, *b), *v)).collect()
                };
                grids.push(run.iter().map(row).collect());
            }
            run.clear();
        };
        for (v, stretch) in lines {
            match stretch {
                Some(stretch) => run.push((v, stretch)),
                None => finish(&mut run),
            }
        }
        finish(&mut run);
        grids
    }
}

/// Adds lines between two whose ends lie far apart: else long triangles would all meet in one point, their boxes one
/// within the other, of which a tree of boxes makes a chain.
fn between(
    first: (f64, Option<[f64; 2]>),
    last: (f64, Option<[f64; 2]>),
    at: &impl Fn(f64) -> Option<[f64; 2]>,
    lines: &mut Vec<(f64, Option<[f64; 2]>)>,
) {
    let (Some(s), Some(t)) = (first.1, last.1) else { return };
    let shift = (s[0] - t[0]).abs().max((s[1] - t[1]).abs());
    if shift < 5.0 * STEP_M || last.0 - first.0 < 0.02 {
        return;
    }
    let v = 0.5 * (first.0 + last.0);
    let middle = (v, at(v));
    between(first, middle, at, lines);
    lines.push(middle);
    between(middle, last, at, lines);
}

/// What lies beside a sheet: before its first and after its last row, and at its rows' ends.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Sides {
    /// The next sheet everywhere.
    Meeting,
    /// Wheels' tracks all round.
    Strip,
    /// Wheels' tracks before the first and after the last row; the same band goes on at its ends.
    Band,
    /// As for a band, but the first row is the parcel's rim.
    Outermost,
}

/// A canopy over the ground.
struct Canopy<'a> {
    relief: &'a Relief,
    height_m: f64,
    cereal: bool,
}

impl Canopy<'_> {
    /// Height of the plants at a place, m.
    fn plants_m(&self, p: DVec2) -> f64 {
        let r = self.relief;
        let uneven = fractal(p, 0x5eed, 3.1, 2, 0.6) * 0.14 * r.roughness();
        let growth = 1.0 + 0.11 * r.vigour(p).clamp(-1.0, 1.0) + uneven;
        let standing = if self.cereal { 1.0 - 0.62 * r.lodged(p) } else { 1.0 };
        (self.height_m * growth * standing * (1.0 - 0.35 * r.thin(p))).max(0.12)
    }

    fn top_m(&self, p: DVec2) -> f64 {
        self.relief.height_m(p) + self.plants_m(p)
    }

    /// Where a sheet's point comes to stand, and the height of its plants as a share. Tracks wander a little, and plants
    /// lean over them more or less; a parcel's rim is low and ragged.
    fn settled(points: &[Vec<DVec2>], j: usize, i: usize, sides: Sides) -> (DVec2, f64) {
        let p = points[j][i];
        let (rows, columns) = (points.len(), points[0].len());
        if sides == Sides::Meeting {
            return (p, 1.0);
        }
        let noise = |salt: u32, wavelength_m: f64| fractal(p, 0x7a3c ^ salt, wavelength_m, 2, 0.6);
        let outward = |inner: DVec2| (p - inner).normalize_or_zero();
        if sides == Sides::Outermost && j == 0 {
            let recedes_m = RAGGED_M * (0.5 + 0.9 * noise(1, 5.5)).clamp(0.0, 1.0);
            return (p - outward(points[1][i]) * recedes_m, AT_RIM + 0.35 * noise(2, 3.7).abs());
        }
        let mut away = DVec2::ZERO;
        if j == 0 || j + 1 == rows {
            away += outward(points[if j == 0 { 1 } else { j - 1 }][i]);
        }
        if sides == Sides::Strip && (i == 0 || i + 1 == columns) {
            away += outward(points[j][if i == 0 { 1 } else { i - 1 }]);
        }
        if away == DVec2::ZERO {
            return (p, 1.0);
        }
        let wander = DVec2::new(noise(3, 26.0), noise(4, 26.0)) * WANDER_M;
        let closes_m = WHEEL_M[1] * CLOSED * smoothstep(-0.1, 0.32, noise(5, 37.0));
        (p + wander + away * closes_m, BESIDE)
    }

    /// A closed-sided sheet over a grid of points: rows from right to left, points along each row onward.
    fn sheet(&self, points: &[Vec<DVec2>], sides: Sides) -> Mesh {
        let mut mesh = Mesh::default();
        let columns = points[0].len();
        let rows = points.len();
        let e = 0.7;
        for (j, row) in points.iter().enumerate() {
            for i in 0..row.len() {
                let (p, share) = Self::settled(points, j, i, sides);
                let p = Relief::on_lattice(p);
                let d = |x: f64, y: f64| self.top_m(p + DVec2::new(x, y)) - self.top_m(p - DVec2::new(x, y));
                let normal = DVec3::new(-d(e, 0.0), -d(0.0, e), 2.0 * e).normalize();
                let plants_m = (self.plants_m(p) * share).max(0.1);
                mesh.positions_m.push([p.x as f32, p.y as f32, quantise_m(self.relief.height_m(p) + plants_m)]);
                mesh.normals.push(normal.as_vec3().to_array());
            }
        }
        let at = |i: usize, j: usize| (j * columns + i) as u32;
        for j in 0..rows - 1 {
            for i in 0..columns - 1 {
                let q = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                push(&mut mesh, [q[0], q[1], q[2]], TOP);
                push(&mut mesh, [q[0], q[2], q[3]], TOP);
            }
        }
        // A side below every edge that only one triangle has: also where the lattice turned triangles, which are left out.
        // Edges are told by their places, since the lattice may put two vertices into one.
        let place = |v: u32| mesh.positions_m[v as usize].map(f32::to_bits);
        let edges: Vec<[u32; 2]> =
            mesh.triangles.iter().flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]).collect();
        let known: BTreeSet<_> = edges.iter().map(|[a, b]| [place(*a), place(*b)]).collect();
        let open: Vec<_> = edges.iter().filter(|[a, b]| !known.contains(&[place(*b), place(*a)])).copied().collect();
        for [a, b] in open {
            self.side(&mut mesh, a, b);
        }
        mesh
    }

    /// A side below the edge from one vertex of the rim to the next, looking to the right.
    fn side(&self, mesh: &mut Mesh, a: u32, b: u32) {
        let [pa, pb] = [a, b].map(|v| mesh.positions_m[v as usize]);
        if pa[0] == pb[0] && pa[1] == pb[1] {
            return;
        }
        let along = DVec2::new(f64::from(pb[0] - pa[0]), f64::from(pb[1] - pa[1])).normalize();
        let normal = DVec3::new(along.y, -along.x, 0.25).normalize().as_vec3().to_array();
        let first = mesh.positions_m.len() as u32;
        let low = |p: [f32; 3]| {
            let z = self.relief.height_m(DVec2::new(p[0].into(), p[1].into())) - ROOT_M;
            [p[0], p[1], quantise_m(z)]
        };
        mesh.positions_m.extend([low(pa), low(pb), pb, pa]);
        mesh.normals.extend([normal; 4]);
        push(mesh, [first, first + 1, first + 2], SIDE);
        push(mesh, [first, first + 2, first + 3], SIDE);
    }
}

/// A triangle unless the lattice took its area, or turned it.
fn push(mesh: &mut Mesh, t: [u32; 3], slot: u16) {
    let [a, b, c] = t.map(|v| DVec3::from_array(mesh.positions_m[v as usize].map(f64::from)));
    let normal = (b - a).cross(c - a);
    if normal != DVec3::ZERO && (slot == SIDE || normal.z > 0.0) {
        mesh.triangles.push(t);
        mesh.slots.push(slot);
    }
}
