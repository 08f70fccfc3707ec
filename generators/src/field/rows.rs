//! Crops in rows, swaths and bales: blocks of plants as instances that follow the ground.

use super::canopy::{Area, RIM_M, inset};
use super::crops::{Crop, Form};
use super::plan::Parcel;
use super::relief::Relief;
use crate::kit::mesh_builder::MeshBuilder;
use crate::kit::scatter::{Placed, variation};
use crate::kit::terrain::tin::Ground;
use glam::{DAffine3, DVec2, DVec3};
use satseed_scene::{Mesh, Rng, SeedPath, quantise_m, quantise_point};

/// How plants of a row stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stand {
    /// Distance of the rows, m.
    pub(super) row_m: f64,
    height_m: f64,
    /// Half the width where it is widest, and at the ground, m.
    half_m: f64,
    foot_m: f64,
    /// Where it is widest, of the height.
    belly: f64,
    /// Rows of one pass.
    pass: u32,
    /// Distance of the stations along a row, m.
    station_m: f64,
    /// Share of stations without a plant.
    gaps: f64,
    /// Blades that stand out of a row, for each station.
    blades: u32,
    /// Passes round the parcel's rim.
    headland: u32,
    /// Bare rim where there is no such pass, m.
    bare_m: f64,
}

impl Stand {
    /// The stand of a crop, if it has rows.
    pub(super) fn of(parcel: &Parcel) -> Option<Self> {
        let swath = |height_m: f64, half_m: f64| Self {
            row_m: parcel.pass_m,
            height_m,
            half_m,
            foot_m: 1.1 * half_m,
            belly: 0.45,
            pass: 1,
            station_m: 0.45,
            gaps: 0.015,
            blades: 0,
            headland: 1,
            bare_m: 1.0,
        };
        match (parcel.crop, parcel.crop.facts().form) {
            (Crop::Straw, _) => Some(swath(0.42, 0.72)),
            (Crop::Hay, _) => Some(swath(0.24, 0.62)),
            (crop, Form::Rows { row_m, height_m, half_m, pass }) => Some(Self {
                row_m,
                height_m,
                half_m,
                foot_m: if crop == Crop::Vines { 0.05 } else { 0.55 * half_m },
                belly: match crop {
                    Crop::Vines => 0.62,
                    Crop::MaizeTall => 0.76,
                    _ => 0.5,
                },
                pass,
                station_m: if crop == Crop::MaizeTall { 0.27 } else { 0.3 },
                gaps: if crop == Crop::Vines { 0.02 } else { 0.035 },
                blades: match crop {
                    Crop::MaizeTall => 3,
                    Crop::MaizeYoung | Crop::Vines => 2,
                    _ => 1,
                },
                headland: match crop {
                    Crop::Vines => 0,
                    _ if pass >= 8 => 1,
                    _ => 2,
                },
                bare_m: 5.0,
            }),
            _ => None,
        }
    }

    fn pass_m(&self) -> f64 {
        self.row_m * f64::from(self.pass)
    }
}

/// Lengths of the pieces that rows are made of, m: a whole pass at once, the same for headlands, single rows.
const BLOCK_M: [f64; 4] = [12.0, 6.0, 3.0, 1.5];
/// Different meshes of each length.
const VARIANTS: usize = 7;
/// How far rows go below the ground, m.
const ROOT_M: f64 = 0.3;

/// Meshes of a stand: [`VARIANTS`] of each length of [`BLOCK_M`], the first two of all rows of a pass.
pub(super) fn meshes(stand: &Stand, path: &SeedPath) -> Vec<Mesh> {
    let mut all = Vec::new();
    for (k, length_m) in BLOCK_M.iter().enumerate() {
        for variant in 0..VARIANTS {
            let mut rng = path.index(k as u64).index(variant as u64).rng();
            let rows = if k < 2 { stand.pass } else { 1 };
            let mut mesh = Mesh::default();
            for row in 0..rows {
                let y = (f64::from(row) - 0.5 * f64::from(rows - 1)) * stand.row_m;
                add_row(&mut mesh, stand, *length_m, y, &mut rng);
            }
            all.push(mesh);
        }
    }
    all
}

/// A row along x from 0 at a place across: a closed ribbon with blades.
fn add_row(mesh: &mut Mesh, stand: &Stand, length_m: f64, y: f64, rng: &mut Rng) {
    let stations = libm::round(length_m / stand.station_m).max(2.0) as usize;
    let first = mesh.positions_m.len() as u32;
    let mut gap = 0;
    for i in 0..=stations {
        let x = length_m * i as f64 / stations as f64;
        if gap == 0 && rng.chance(0.5 * stand.gaps) {
            gap = 2;
        }
        let missing = gap > 0;
        gap = if gap > 0 { gap - 1 } else { 0 };
        let size = if missing { 0.12 } else { 1.0 };
        let h = stand.height_m * rng.range(0.80, 1.10) * size;
        let w = stand.half_m * rng.range(0.72, 1.22) * size.max(0.4);
        let c = y + stand.half_m * 0.22 * rng.signed();
        let ridge = c + 0.35 * w * rng.signed();
        let belly = stand.belly * h * rng.range(0.85, 1.15);
        for (dy, z) in
            [(c - stand.foot_m, -ROOT_M), (c - w, belly), (ridge, h), (c + w, belly), (c + stand.foot_m, -ROOT_M)]
        {
            mesh.positions_m.push(quantise_point(DVec3::new(x, dy, z)));
        }
        if !missing {
            for _ in 0..stand.blades {
                blade(mesh, stand, DVec3::new(x + 0.12 * rng.signed(), c, h), w, rng);
            }
        }
    }
    // Stations are not contiguous where blades came between.
    let at = ring_indices(mesh, first, stations, stand);
    for i in 0..stations {
        for k in 0..4 {
            let (a, b, c, d) = (at[i] + k, at[i + 1] + k, at[i + 1] + k + 1, at[i] + k + 1);
            // The left half of the ribbon looks to -y, the right one to +y.
            push(mesh, [a, b, c]);
            push(mesh, [a, c, d]);
        }
    }
    for k in 1..4 {
        push(mesh, [at[0], at[0] + k, at[0] + k + 1]);
        let e = at[stations];
        push(mesh, [e, e + k + 1, e + k]);
    }
}

/// First vertices of the stations: what is not a ribbon's vertex belongs to a blade of three.
fn ring_indices(mesh: &Mesh, first: u32, stations: usize, stand: &Stand) -> Vec<u32> {
    let root = quantise_m(-ROOT_M);
    let mut at = Vec::with_capacity(stations + 1);
    let mut k = first;
    while (k as usize) < mesh.positions_m.len() {
        if mesh.positions_m[k as usize][2] == root {
            at.push(k);
            k += 5;
        } else {
            k += 3;
        }
    }
    debug_assert_eq!(at.len(), stations + 1, "{stand:?}");
    at
}

/// A leaf that bends out of the row.
fn blade(mesh: &mut Mesh, stand: &Stand, top: DVec3, w: f64, rng: &mut Rng) {
    let (s, c) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
    let out = DVec3::new(c, s, 0.0);
    let reach = (0.9 * w + 0.10) * rng.range(0.7, 1.3);
    let base = top - DVec3::Z * (stand.height_m * rng.range(0.05, 0.3));
    let wide = out.cross(DVec3::Z) * rng.range(0.04, 0.075);
    let tip = base + out * reach + DVec3::Z * (rng.range(-0.15, 0.2) * stand.height_m.min(0.8));
    let first = mesh.positions_m.len() as u32;
    mesh.positions_m.extend([base - wide, base + wide, tip].map(quantise_point));
    push(mesh, [first, first + 1, first + 2]);
}

fn push(mesh: &mut Mesh, t: [u32; 3]) {
    let [a, b, c] = t.map(|v| DVec3::from_array(mesh.positions_m[v as usize].map(f64::from)));
    if (b - a).cross(c - a) != DVec3::ZERO {
        mesh.triangles.push(t);
        mesh.slots.push(0);
    }
}

/// Where a mesh of a length begins in the list.
fn first_mesh(length: usize, rng: &mut Rng) -> u32 {
    (length * VARIANTS) as u32 + rng.below(VARIANTS as u64) as u32
}

/// A frame on the ground: x along a direction from a place, sheared so that both axes follow the ground.
fn on_slope(relief: &Relief, at: DVec2, axis: DVec2, length_m: f64, width_m: f64, tall: f64) -> DAffine3 {
    let at = Relief::on_lattice(at);
    let z = |u: f64, v: f64| relief.height_m(Relief::on_lattice(at + axis * u + axis.perp() * v));
    let (begin, end) = (z(0.0, 0.0), z(length_m, 0.0));
    let half = (0.5 * width_m).max(0.3);
    let across = (z(0.5 * length_m, half) - z(0.5 * length_m, -half)) / (2.0 * half);
    DAffine3::from_cols(
        axis.extend((end - begin) / length_m),
        axis.perp().extend(across),
        DVec3::Z * tall,
        at.extend(f64::from(quantise_m(begin - 0.02))),
    )
}

/// All pieces of a parcel's rows that reach tiles of full detail.
pub(super) fn place(relief: &Relief, parcel: &Parcel, stand: &Stand, path: &SeedPath) -> Vec<Placed> {
    let mut out = Vec::new();
    let key = path.index(parcel.code);
    let pass_m = stand.pass_m();
    let around = if parcel.convex { stand.headland } else { 0 };
    let fits = |d: f64| inset(&parcel.outline, d).is_some();
    let rim_m = if around > 0 && fits(RIM_M + f64::from(around) * pass_m) {
        for k in 0..around {
            headland(
                relief,
                parcel,
                stand,
                RIM_M + (f64::from(k) + 0.5) * pass_m,
                &key.child("rim").index(k.into()),
                &mut out,
            );
        }
        RIM_M + f64::from(around) * pass_m + 0.35
    } else {
        stand.bare_m
    };
    let Some(area) = Area::new(relief, parcel, rim_m, 0.0) else { return out };
    let [low, high] = area.span();
    let at = |k: i64| (k as f64 + 0.5) * stand.row_m;
    let (first, last) = (libm::ceil(low / stand.row_m - 0.5) as i64, libm::floor(high / stand.row_m - 0.5) as i64);
    let mut pass = first;
    while pass <= last {
        let next = (pass + i64::from(stand.pass)).min(last + 1);
        let stretches: Vec<Option<[f64; 2]>> = (pass..next).map(|k| area.stretch(at(k))).collect();
        let whole = (next - pass == i64::from(stand.pass) && stretches.iter().all(Option::is_some))
            .then(|| stretches.iter().flatten().fold([f64::MIN, f64::MAX], |[a, b], s| [a.max(s[0]), b.min(s[1])]));
        // Blocks of the whole pass as far as all its rows reach, single rows for the rest.
        let mut blocks = [0.0, 0.0];
        if let Some([a, b]) = whole.filter(|[a, b]| b - a > BLOCK_M[0]) {
            let count = libm::floor((b - a) / BLOCK_M[0]);
            blocks = [a, a + count * BLOCK_M[0]];
            let middle = 0.5 * (at(pass) + at(next - 1));
            for k in 0..count as u32 {
                let place = area.world(a + f64::from(k) * BLOCK_M[0], middle);
                block(relief, stand, place, parcel.axis, 0, &key, &mut out);
            }
        }
        for (k, stretch) in (pass..next).zip(&stretches) {
            let Some([a, b]) = *stretch else { continue };
            let parts = if blocks[1] > blocks[0] { vec![[a, blocks[0]], [blocks[1], b]] } else { vec![[a, b]] };
            for [from, to] in parts {
                single(relief, parcel, stand, &area, at(k), from, to, &key, &mut out);
            }
        }
        pass = next;
    }
    out
}

/// One row from one place to another in pieces of 3 and 1.5 m.
#[allow(clippy::too_many_arguments)]
fn single(
    relief: &Relief,
    parcel: &Parcel,
    stand: &Stand,
    area: &Area,
    v: f64,
    from: f64,
    to: f64,
    path: &SeedPath,
    out: &mut Vec<Placed>,
) {
    let rng = &mut path.child("row").index((v * 1024.0) as i64 as u64).rng();
    let mut u = from;
    while to - u > 0.8 {
        let length = if to - u >= BLOCK_M[2] { 2 } else { 3 };
        let place = area.world(u, v);
        if relief.thin(place) < rng.range(0.3, 2.0) {
            block(relief, stand, place, parcel.axis, length, path, out);
        }
        u += BLOCK_M[length];
    }
}

/// A piece, unless it lies beyond the full detail. A block of a whole pass on poor ground is made of single rows with
/// gaps.
#[allow(clippy::too_many_arguments)]
fn block(
    relief: &Relief,
    stand: &Stand,
    at: DVec2,
    axis: DVec2,
    length: usize,
    path: &SeedPath,
    out: &mut Vec<Placed>,
) {
    if !relief.is_detailed(at) {
        return;
    }
    // Keyed by its place: which of its neighbours lie within the full detail must not show.
    let place = Relief::on_lattice(at) * 1024.0;
    let rng = &mut path.index(place.x as i64 as u64).index(place.y as i64 as u64).rng();
    let long = BLOCK_M[length];
    let middle = at + axis * (0.5 * long);
    if length < 2 && stand.pass > 1 && relief.thin(middle) > 0.12 {
        for row in 0..stand.pass {
            let y = (f64::from(row) - 0.5 * f64::from(stand.pass - 1)) * stand.row_m;
            for k in 0..(long / BLOCK_M[3]) as u32 {
                let place = at + axis.perp() * y + axis * (f64::from(k) * BLOCK_M[3]);
                if relief.thin(place) < rng.range(0.1, 1.3) {
                    block(relief, stand, place, axis, 3, path, out);
                }
            }
        }
        return;
    }
    let growth = 1.0 + 0.16 * relief.vigour(middle).clamp(-1.2, 1.2) - 0.5 * relief.thin(middle);
    let width_m = if length < 2 { stand.pass_m() } else { 0.6 };
    out.push(Placed {
        at_m: at,
        world_from_object: on_slope(relief, at, axis, long, width_m, growth * rng.range(0.96, 1.04)),
        variation: variation(rng),
        mesh: first_mesh(length, rng),
        path: String::new(),
    });
}

/// A pass round a parcel, its middle at a distance from the outline.
fn headland(relief: &Relief, parcel: &Parcel, stand: &Stand, distance_m: f64, path: &SeedPath, out: &mut Vec<Placed>) {
    let Some(line) = inset(&parcel.outline, distance_m) else { return };
    let n = line.len();
    let warp = relief.plan.warp;
    for k in 0..n {
        let (a, b) = (line[k], line[(k + 1) % n]);
        let along = (b - a).normalize();
        let half = 0.5 * stand.pass_m();
        // Each edge takes the corner where it begins; what does not divide stays bare at its end.
        let start = -half;
        let count = libm::floor((a.distance(b) - half - start) / BLOCK_M[1]).max(0.0) as u32;
        for i in 0..count {
            let s = start + f64::from(i) * BLOCK_M[1];
            let (p, q) = (warp.world(a + along * s), warp.world(a + along * (s + BLOCK_M[1])));
            // The bend of the plan into the world stretches some pieces: their ends meet all the same.
            block(relief, stand, p, (q - p) / BLOCK_M[1], 1, path, out);
        }
    }
}

/// A round bale lying on its side, x across its axis: 1.35 m in diameter, 1.2 m wide.
pub(super) fn bale() -> Mesh {
    let mut b = MeshBuilder::default();
    let (r, h) = (0.68, 0.6);
    b.limb(0, DVec3::new(0.0, -h, r - 0.1), DVec3::new(0.0, h, r - 0.1), [r, r], 14);
    b.finish()
}

/// Bales where the baler dropped them: along every second or third pass.
pub(super) fn bales(relief: &Relief, parcel: &Parcel, path: &SeedPath) -> Vec<Placed> {
    let key = path.index(parcel.code);
    let Some(area) = Area::new(relief, parcel, 7.0, 0.0) else { return Vec::new() };
    let mut rng = key.rng();
    let spacing = rng.range(26.0, 44.0);
    let [low, high] = area.span();
    let mut out = Vec::new();
    let first = libm::ceil(low / parcel.pass_m - 0.5) as i64;
    let last = libm::floor(high / parcel.pass_m - 0.5) as i64;
    for k in (first..=last).filter(|k| k.rem_euclid(2) == 0) {
        let v = (k as f64 + 0.5) * parcel.pass_m;
        let key = key.index(k as u64);
        let Some([a, b]) = area.stretch(v) else { continue };
        let mut u = a + spacing * key.rng().unit();
        let mut number = 0;
        while u < b {
            let mut rng = key.index(number).rng();
            let step_m = spacing * rng.range(0.75, 1.3);
            let p = area.world(u, v + 0.5 * rng.signed());
            let (s, c) = libm::sincos(0.25 * rng.signed() + if rng.chance(0.2) { 1.4 } else { 0.0 });
            let axis = parcel.axis.rotate(DVec2::new(c, s));
            if relief.is_detailed(p) {
                let z = crate::kit::scatter::lowest(relief, Relief::on_lattice(p), 0.6);
                let world = DAffine3::from_cols(
                    axis.extend(0.0),
                    axis.perp().extend(0.0),
                    DVec3::Z,
                    Relief::on_lattice(p).extend(f64::from(quantise_m(z)) - 0.02),
                );
                out.push(Placed {
                    at_m: p,
                    world_from_object: world,
                    variation: variation(&mut rng),
                    mesh: 0,
                    path: format!("parcel/{}/bale/{k}/{number}", parcel.code),
                });
            }
            u += step_m;
            number += 1;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::mesh_builder::open_edges;

    #[test]
    fn straw_is_closed_and_lies_in_the_ground() {
        let m = bale();
        assert_eq!((m.validate(), open_edges(&m)), (Ok(()), 0));
        assert!(m.bounds_m().unwrap().0.z < -0.05);
    }
}
