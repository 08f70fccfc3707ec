//! Hedges, trees along them, copses, and orchards.

use super::canopy::Area;
use super::crops::{Crop, Form};
use super::plan::{Edge, Parcel};
use super::relief::Relief;
use crate::kit::mesh_builder::MeshBuilder;
use crate::kit::polygon;
use crate::kit::scatter::{Kind, Placed, lowest, variation};
use crate::kit::terrain::noise::fractal;
use crate::kit::trees::{SPECIES, cluster, tree};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use rayon::prelude::*;
use satseed_scene::{Bands, Brdf, Class, Field, Layer, Material, Mesh, Rng, SeedPath, quantise_m};

/// Different hedge pieces, and trees of each species.
const VARIANTS: usize = 12;
/// Distance of hedge pieces along a hedge, m.
const PIECE_M: f64 = 1.7;

/// A piece of hedge 2.4 m long, 2 m wide and 2 m high about the origin: lumps of leaves around a dense core.
fn piece(path: &SeedPath) -> Mesh {
    let mut rng = path.rng();
    let mut b = MeshBuilder::default();
    for k in 0..5 {
        let x = (f64::from(k) - 2.0) * 0.48;
        cluster(&mut b, DVec3::new(x, 0.15 * rng.signed(), 0.42 + 0.1 * rng.signed()), 0.75, &mut rng);
    }
    for _ in 0..17 {
        let x = 1.15 * rng.signed();
        let (s, c) = libm::sincos(rng.range(-0.2, core::f64::consts::PI + 0.2));
        let out = rng.range(0.62, 1.0);
        let at = DVec3::new(x, 0.72 * c * out, 0.85 + 0.8 * s * out);
        cluster(&mut b, at, rng.range(0.24, 0.42), &mut rng);
    }
    b.finish()
}

/// Meshes and materials of hedges.
pub(super) fn hedge_kind(path: &SeedPath) -> Kind {
    let meshes = (0..VARIANTS).map(|k| piece(&path.child("piece").index(k as u64))).collect();
    let leaves = foliage("hedge leaves", Class::LowVegetation, path);
    Kind { meshes, materials: vec![leaves.clone(), leaves], class: Class::LowVegetation }
}

/// Meshes and materials of trees: [`VARIANTS`] of each of the kit's species in turn.
pub(super) fn tree_kind(path: &SeedPath) -> Kind {
    let meshes = (0..SPECIES.len() * VARIANTS)
        .into_par_iter()
        .map(|k| tree(&SPECIES[k / VARIANTS], &path.child("tree").index(k as u64)))
        .collect();
    let bark = Material::diffuse("bark", Class::Tree, Bands::new(0.07, 0.08, 0.095, 0.16));
    Kind { meshes, materials: vec![bark, foliage("tree leaves", Class::Tree, path)], class: Class::Tree }
}

fn foliage(name: &str, class: Class, path: &SeedPath) -> Material {
    let seed = path.child("leaves").hash_u32();
    Material {
        brdf: Brdf::Leaf { transmission: Bands::new(0.008, 0.024, 0.014, 0.20) },
        ..Material::diffuse(name, class, Bands::new(0.034, 0.068, 0.049, 0.32))
            .with(Layer::Mix {
                color: Bands::new(0.044, 0.084, 0.066, 0.34),
                amount: Field::Variation(0).ramp(-0.3, 0.9),
            })
            .with(Layer::Mix {
                color: Bands::new(0.056, 0.084, 0.080, 0.29),
                amount: Field::Variation(2).ramp(0.35, 1.0).times(0.8),
            })
            .with(Layer::Brightness { amount: Field::Variation(1).times(0.18) })
            .with(Layer::Brightness { amount: Field::world_noise(seed, 0.7, 2).times(0.2) })
    }
}

/// How one hedge is kept.
struct Style {
    width: f64,
    height: f64,
    gaps: f64,
    wild: f64,
    tree_m: f64,
}

/// Pieces and trees along every hedge, and trees along other borders.
pub(super) fn along_borders(relief: &Relief, factor: f64, path: &SeedPath) -> (Vec<Placed>, Vec<Placed>) {
    let plan = &relief.plan;
    let all: Vec<(Vec<Placed>, Vec<Placed>)> = (0..plan.borders.len())
        .into_par_iter()
        .map(|k| along(relief, k as u32, factor, &path.index(k as u64)))
        .collect();
    let mut out = (Vec::new(), Vec::new());
    for (pieces, trees) in all {
        out.0.extend(pieces);
        out.1.extend(trees);
    }
    out
}

fn along(relief: &Relief, index: u32, factor: f64, path: &SeedPath) -> (Vec<Placed>, Vec<Placed>) {
    let (mut pieces, mut trees) = (Vec::new(), Vec::new());
    let plan = &relief.plan;
    let border = plan.borders[index as usize];
    let [a, b] = border.ends;
    let length = a.distance(b);
    let mut rng = path.rng();
    let wild = rng.unit();
    let style = Style {
        width: rng.range(0.95, 1.6),
        height: if wild < 0.55 { rng.range(0.75, 1.0) } else { rng.range(1.0, 1.7) },
        gaps: if rng.chance(0.3) { rng.range(0.05, 0.22) } else { 0.015 },
        wild,
        tree_m: rng.range(17.0, 36.0),
    };
    // How many trees in how many metres, and how far from the middle line they stand.
    let (tree_m, away_m) = match border.edge {
        Edge::Hedge => (style.tree_m, 0.3),
        Edge::Lane if rng.chance(0.65) => (rng.range(24.0, 60.0), 4.6),
        Edge::Ditch if rng.chance(0.7) => (rng.range(22.0, 70.0), 2.2),
        Edge::Track if rng.chance(0.4) => (rng.range(35.0, 110.0), 2.3),
        Edge::Margin if rng.chance(0.12) => (rng.range(30.0, 80.0), 0.5),
        _ => (0.0, 0.0),
    };
    // Old lanes and tracks have a hedge on one side; those of section land have none.
    let old = plan.pivots.is_empty();
    let side = if rng.chance(0.5) { 1.0 } else { -1.0 };
    let hedge_m = match border.edge {
        Edge::Hedge => Some(0.0),
        Edge::Lane if old && rng.chance((0.65 * factor).min(0.9)) => Some(4.7 * side),
        Edge::Track if old && rng.chance((0.6 * factor).min(0.9)) => Some(2.5 * side),
        _ => None,
    };
    if hedge_m.is_none() && tree_m == 0.0 || factor == 0.0 {
        return (pieces, trees);
    }
    let along = (b - a) / length;
    let gate = rng.range(0.15, 0.85) * length;
    if let Some(hedge_m) = hedge_m {
        for k in 0..(length / PIECE_M) as u32 {
            let mut rng = path.child("piece").index(k.into()).rng();
            let s = (f64::from(k) + 0.5) * PIECE_M;
            let q = a + along * s + along.perp() * (hedge_m + 0.25 * rng.signed());
            let p = plan.warp.world(q);
            if rng.chance(style.gaps)
                || (s - gate).abs() < 3.2
                || !relief.is_detailed(p)
                || !plan.is_clear(q, Some(index), 0.4)
            {
                continue;
            }
            let ahead = (plan.warp.world(q + along) - p).normalize();
            let axis = if rng.chance(0.5) { ahead } else { -ahead };
            let uneven = 0.10 + 0.28 * style.wild;
            let scale = DVec3::new(
                rng.range(0.95, 1.15),
                style.width * (1.0 + uneven * rng.signed() + 0.7 * fractal(p, 0x4ed9e, 24.0, 2, 0.5)),
                style.height * (1.0 + uneven * rng.signed()),
            );
            pieces.push(planted(relief, p, axis, scale, 0.45, VARIANTS, 0, &mut rng, format!("hedge/{index}/{k}")));
        }
    }
    let tree_m = tree_m / factor;
    let mut s = tree_m * rng.range(0.2, 1.0);
    let mut k = 0;
    while tree_m > 0.0 && s < length - 4.0 {
        let mut rng = path.child("tree").index(k).rng();
        // Some stand close together, others far apart.
        let step_m = tree_m * (0.3 - 0.92 * libm::log(1.0 - 0.97 * rng.unit()));
        let side = if rng.chance(0.5) { 1.0 } else { -1.0 };
        let q = a + along * s + along.perp() * (away_m * side + 0.3 * rng.signed());
        let p = plan.warp.world(q);
        if relief.is_detailed(p) && plan.is_clear(q, Some(index), 0.5) && (s - gate).abs() > 4.0 {
            trees.push(a_tree(relief, p, &[0.5, 0.22, 0.2, 0.08], [0.75, 1.5], &mut rng, format!("tree/{index}/{k}")));
        }
        k += 1;
        s += step_m;
    }
    (pieces, trees)
}

fn a_tree(relief: &Relief, p: DVec2, species: &[f64; 4], sizes: [f64; 2], rng: &mut Rng, path: String) -> Placed {
    let kind = rng.weighted(species);
    let size = rng.range(sizes[0], sizes[1]);
    let (s, c) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
    let scale = DVec3::new(size * rng.range(0.88, 1.12), size * rng.range(0.88, 1.12), size * rng.range(0.85, 1.15));
    planted(relief, p, DVec2::new(c, s), scale, 0.3, VARIANTS, kind * VARIANTS, rng, path)
}

#[allow(clippy::too_many_arguments)]
fn planted(
    relief: &Relief,
    p: DVec2,
    axis: DVec2,
    scale: DVec3,
    radius_m: f64,
    variants: usize,
    first: usize,
    rng: &mut Rng,
    path: String,
) -> Placed {
    let p = Relief::on_lattice(p);
    let z = f64::from(quantise_m(lowest(relief, p, radius_m))) - 0.0625;
    let turn = DMat3::from_cols(axis.extend(0.0), axis.perp().extend(0.0), DVec3::Z);
    Placed {
        at_m: p,
        world_from_object: DAffine3::from_mat3_translation(turn * DMat3::from_diagonal(scale), p.extend(z)),
        variation: variation(rng),
        mesh: (first + rng.below(variants as u64) as usize) as u32,
        path,
    }
}

/// Trees within parcels: orchards in rows, copses without order, a few in pastures, and those of the farmyard.
pub(super) fn within(relief: &Relief, parcel: &Parcel, factor: f64, path: &SeedPath) -> Vec<Placed> {
    let key = path.index(parcel.code);
    match (parcel.crop, parcel.crop.facts().form) {
        (_, Form::Orchard { row_m, tree_m }) => orchard(relief, parcel, row_m, tree_m, &key),
        (Crop::Copse, _) => scattered(relief, parcel, 5.2, 0.9, [0.6, 1.25], 1.5, &key),
        (Crop::Pasture, _) => scattered(relief, parcel, 34.0, 0.13 * factor, [0.8, 1.5], 6.0, &key),
        (Crop::Yard, _) => scattered(relief, parcel, 9.0, 0.5 * factor.min(1.5), [0.6, 1.2], 2.5, &key)
            .into_iter()
            // Around the yard, not in its middle.
            .filter(|t| polygon::border_distance(&parcel.world, t.at_m) < 6.0)
            .collect(),
        _ => Vec::new(),
    }
}

fn orchard(relief: &Relief, parcel: &Parcel, row_m: f64, tree_m: f64, path: &SeedPath) -> Vec<Placed> {
    let Some(area) = Area::new(relief, parcel, 5.0, 0.0) else { return Vec::new() };
    let [low, high] = area.span();
    let mut rng = path.rng();
    let [wide, tall] = [rng.range(0.66, 0.92), rng.range(0.41, 0.53)];
    let mut out = Vec::new();
    for k in libm::ceil(low / row_m - 0.5) as i64..=libm::floor(high / row_m - 0.5) as i64 {
        let v = (k as f64 + 0.5) * row_m;
        let Some([a, b]) = area.stretch(v) else { continue };
        for i in 0..((b - a) / tree_m) as u32 {
            let mut rng = path.index(k as u64).index(i.into()).rng();
            let p = area.world(a + (f64::from(i) + 0.5) * tree_m + 0.15 * rng.signed(), v + 0.12 * rng.signed());
            if rng.chance(0.035) || relief.thin(p) > rng.range(0.5, 1.4) || !relief.is_detailed(p) {
                continue;
            }
            let (s, c) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
            let size = if rng.chance(0.04) { 0.5 } else { rng.range(0.85, 1.15) };
            let scale = DVec3::new(wide, wide, tall * rng.range(0.92, 1.1)) * size;
            let name = format!("parcel/{}/tree/{k}_{i}", parcel.code);
            out.push(planted(relief, p, DVec2::new(c, s), scale, 0.2, VARIANTS, 2 * VARIANTS, &mut rng, name));
        }
    }
    out
}

/// Trees in cells of a side, each with a probability, at a distance from the rim.
fn scattered(
    relief: &Relief,
    parcel: &Parcel,
    side_m: f64,
    chance: f64,
    sizes: [f64; 2],
    rim_m: f64,
    path: &SeedPath,
) -> Vec<Placed> {
    let (low, high) = polygon::bounds(&parcel.world);
    let cell = |v: f64| libm::floor(v / side_m) as i64;
    let mut out = Vec::new();
    for j in cell(low.y)..=cell(high.y) {
        for i in cell(low.x)..=cell(high.x) {
            let mut rng = path.child("tree").index(i as u64).index(j as u64).rng();
            let p = DVec2::new(i as f64 + rng.unit(), j as f64 + rng.unit()) * side_m;
            let stands = rng.chance(chance)
                && polygon::contains(&parcel.world, p)
                && polygon::border_distance(&parcel.world, p) > rim_m
                && relief.is_detailed(p);
            if stands {
                let name = format!("parcel/{}/tree/{i}_{j}", parcel.code);
                out.push(a_tree(relief, p, &[0.45, 0.25, 0.2, 0.1], sizes, &mut rng, name));
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::mesh_builder::open_edges;

    #[test]
    fn hedge_pieces_are_closed_and_rooted() {
        for k in 0..4 {
            let m = piece(&SeedPath::root("hedge", k));
            assert_eq!((m.validate(), open_edges(&m)), (Ok(()), 0));
            let (low, high) = m.bounds_m().unwrap();
            assert!(low.z < -0.02 && high.z > 1.5 && high.z < 2.4, "{low} {high}");
        }
    }
}
