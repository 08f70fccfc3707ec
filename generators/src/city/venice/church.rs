//! A church on its ground beside the campo: nave, aisles, apse, facade, often a dome, and the campanile.

use super::house_mesh::slot;
use super::houses::{FOOT_M, bent};
use super::lie::{Lie, WATER_M};
use super::piece::{Piece, Side};
use super::roof::{Roof, RoofSlots};
use crate::kit::mesh_builder::{MeshBuilder, Wall};
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::{Mesh, SeedPath, quantise_m};

/// Height of the highest campanile's tip, m.
pub(super) const HIGHEST_M: f64 = 72.0;

/// A church. x of its frame points to the facade.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Church {
    /// Origin of its frame in the world, m.
    pub centre_m: DVec2,
    /// Direction of x.
    pub axis: DVec2,
    /// Half its length and half its width, m.
    pub half_m: DVec2,
    /// Height of the nave's eaves, m.
    pub nave_m: f64,
    /// Radius of the dome, m.
    pub dome_m: Option<f64>,
    /// Half the side of the campanile, and its height without the spire and with it, m.
    pub tower_m: [f64; 3],
    /// On which side of the nave the campanile stands: 1 or -1.
    pub tower_side: f64,
}

/// The church of a piece of ground; `chief` has a dome and a high campanile.
pub(super) fn plan(ground: &Piece, chief: bool, lie: &Lie, path: &SeedPath) -> Option<Church> {
    let (outline, sides) = bent(ground, lie)?;
    let mut rng = path.rng();
    let n = outline.len();
    let front = sides.iter().position(|s| *s == Side::Campo)?;
    let towards = -(outline[(front + 1) % n] - outline[front]).normalize().perp();
    let centre = polygon::centroid(&outline);
    let piece = Piece::new(outline.clone(), Side::Campo);
    let fits = |axis: DVec2, half: DVec2| {
        let rect = polygon::subdivided(&polygon::oriented_rectangle(centre, axis, half), 6.0);
        rect.iter().all(|p| polygon::contains(&outline, *p) && polygon::border_distance(&outline, *p) > 0.4)
    };
    // The largest of some shapes that fit, its front or its flank to the campo.
    let flank = if rng.chance(0.5) { towards.perp() } else { -towards.perp() };
    let mut best: Option<(DVec2, DVec2)> = None;
    for (axis, least) in [(towards, 1.0), (flank, 1.15)] {
        let reach = |d: DVec2| {
            let [low, high] = piece.extent(d);
            (high - low) / 2.0
        };
        let whole = DVec2::new(reach(axis).min(28.0), reach(axis.perp()).min(14.0));
        for k in 0..169 {
            let half = whole * DVec2::new(1.0 - 0.05 * f64::from(k / 13), 1.0 - 0.05 * f64::from(k % 13));
            let larger = best.is_none_or(|(_, b)| half.x * half.y > b.x * b.y * least);
            if half.x > 1.25 * half.y && larger && fits(axis, half) {
                best = Some((axis, half));
            }
        }
    }
    let (axis, half_m) = best?;
    if half_m.min_element() < 4.0 {
        return None;
    }
    let height_m = if chief { rng.range(46.0, 62.0) } else { rng.lognormal(33.0, 0.25).clamp(21.0, 50.0) };
    let tower = (height_m * 0.062).clamp(1.8, 3.8);
    Some(Church {
        centre_m: DVec2::new(quantise_m(centre.x).into(), quantise_m(centre.y).into()),
        axis,
        half_m,
        nave_m: rng.range(11.5, 15.0) + 0.14 * half_m.y,
        dome_m: (chief || rng.chance(0.35)).then(|| half_m.y * rng.range(0.36, 0.48)),
        tower_m: [tower, height_m, height_m + tower * rng.range(1.2, 2.4)],
        tower_side: if rng.chance(0.5) { 1.0 } else { -1.0 },
    })
}

const TILES: RoofSlots = RoofSlots { roof: slot::ROOF, edge: slot::EDGE, gable: slot::BLANK };

fn disc(centre: DVec2, radius_m: f64, corners: usize) -> Vec<DVec2> {
    (0..corners)
        .map(|k| {
            let (s, c) = libm::sincos(core::f64::consts::TAU * (k as f64 + 0.5) / corners as f64);
            centre + DVec2::new(c, s) * radius_m
        })
        .collect()
}

/// The mesh of a church in its frame; z is the world's height.
pub(super) fn mesh(church: &Church) -> Mesh {
    let mut b = MeshBuilder::default();
    let DVec2 { x: l, y: w } = church.half_m;
    let (low, h) = (WATER_M - FOOT_M, church.nave_m);
    let rect = |x0: f64, x1: f64, y0: f64, y1: f64| polygon::rectangle(DVec2::new(x0, y0), DVec2::new(x1, y1));
    let apse = (w * 0.5).min(l * 0.3);
    let nave_w = if w > 6.5 { w * 0.56 } else { w };
    // Nave: gables at both ends.
    let nave = rect(-l + apse, l - 0.5, -nave_w, nave_w);
    b.prism(slot::BLANK, slot::BLANK, &nave, low, h - 0.1, Wall::PLAIN);
    let over = rect(-l + apse - 0.1, l - 0.45, -nave_w - 0.35, nave_w + 0.35);
    let nave_roof = Roof { outline: over, slopes: vec![Some(0.42), None, Some(0.42), None], eaves_m: h };
    nave_roof.mesh(&mut b, TILES);
    let ridge = h + 0.42 * nave_w;
    if w > 6.5 {
        for s in [-1.0, 1.0] {
            let (y0, y1) = if s > 0.0 { (nave_w - 0.4, w) } else { (-w, 0.4 - nave_w) };
            let aisle = rect(-l + apse + 1.0, l - 1.0, y0, y1);
            let top = h * 0.56;
            b.prism(slot::BLANK, slot::BLANK, &aisle, low, top - 0.1, Wall::PLAIN);
            let slopes = if s > 0.0 { vec![None, None, Some(0.36), None] } else { vec![Some(0.36), None, None, None] };
            Roof { outline: polygon::mitred(&aisle, -0.12), slopes, eaves_m: top }.mesh(&mut b, TILES);
        }
        b.prism(slot::STONE, slot::STONE, &rect(l - 1.1, l - 0.15, -w, w), low, h * 0.66, Wall::PLAIN);
    }
    // Facade: a high middle with a stepped top, columns before it, a door.
    b.prism(slot::STONE, slot::STONE, &rect(l - 0.9, l, -nave_w - 0.3, nave_w + 0.3), low, h + 0.7, Wall::PLAIN);
    b.prism(slot::STONE, slot::STONE, &rect(l - 0.85, l - 0.05, -nave_w * 0.62, nave_w * 0.62), h, ridge, Wall::PLAIN);
    b.prism(
        slot::STONE,
        slot::STONE,
        &rect(l - 0.8, l - 0.1, -nave_w * 0.25, nave_w * 0.25),
        h,
        ridge + 1.3,
        Wall::PLAIN,
    );
    for k in [-0.85, -0.42, 0.42, 0.85] {
        b.block(slot::STONE, slot::STONE, DVec2::new(l, k * nave_w), DVec2::X, DVec2::new(0.22, 0.35), low, h - 0.4);
    }
    b.prism(slot::DARK, slot::DARK, &rect(l - 0.5, l + 0.06, -1.1, 1.1), low, 4.2, Wall::PLAIN);
    // Apse.
    let round: Vec<DVec2> = (0..=6)
        .map(|k| {
            let (s, c) = libm::sincos(core::f64::consts::PI * (0.5 + f64::from(k) / 6.0));
            DVec2::new(-l + apse + c * apse, s * nave_w * 0.72)
        })
        .collect();
    let apse_top = h * 0.8;
    let foot: Vec<DVec2> =
        [DVec2::new(-l + apse + 1.0, nave_w * 0.72)].into_iter().chain(round[1..6].iter().copied()).collect();
    let foot: Vec<DVec2> = foot.into_iter().chain([DVec2::new(-l + apse + 1.0, -nave_w * 0.72)]).collect();
    b.prism(slot::BLANK, slot::BLANK, &foot, low, apse_top - 0.1, Wall::PLAIN);
    let mut slopes = vec![Some(0.4); foot.len()];
    slopes[foot.len() - 1] = None;
    Roof { outline: polygon::mitred(&foot, -0.2), slopes, eaves_m: apse_top }.mesh(&mut b, TILES);
    if let Some(r) = church.dome_m {
        dome(&mut b, DVec2::new(-l + apse + r * 1.35, 0.0), r, [h - 1.0, ridge + 1.6]);
    }
    campanile(&mut b, church, low);
    b.finish()
}

/// A drum, a dome of lead and a lantern.
fn dome(b: &mut MeshBuilder, at: DVec2, r: f64, [low, high]: [f64; 2]) {
    b.prism(slot::BLANK, slot::STONE, &disc(at, r, 16), low, high, Wall::PLAIN);
    b.prism(slot::STONE, slot::STONE, &disc(at, r * 1.07, 16), high - 0.35, high + 0.1, Wall::PLAIN);
    for k in 0..8 {
        let (s, c) = libm::sincos(core::f64::consts::TAU * (f64::from(k) + 0.5) / 8.0);
        let d = DVec2::new(c, s);
        b.block(slot::DARK, slot::DARK, at + d * r, d, DVec2::new(0.12, 0.4), high - 2.2, high - 0.6);
    }
    let ring = |k: f64| {
        let (s, c) = libm::sincos(core::f64::consts::FRAC_PI_2 * k);
        (r * 1.02 * c, high + r * 1.12 * s)
    };
    let steps = [0.0, 0.2, 0.4, 0.58, 0.74, 0.88];
    for pair in steps.windows(2) {
        let ((r0, z0), (r1, z1)) = (ring(pair[0]), ring(pair[1]));
        b.frustum(slot::METAL, slot::METAL, &disc(at, r0, 16), &disc(at, r1, 16), z0, z1);
    }
    let (_, top) = ring(0.88);
    b.prism(slot::STONE, slot::STONE, &disc(at, r * 0.17, 8), top - 0.3, top + r * 0.38, Wall::PLAIN);
    b.frustum(
        slot::METAL,
        slot::METAL,
        &disc(at, r * 0.22, 8),
        &disc(at, 0.06, 8),
        top + r * 0.36,
        top + r * 0.36 + 0.25 * r + 0.5,
    );
}

/// A square tower of brick with a belfry of stone and a spire.
fn campanile(b: &mut MeshBuilder, church: &Church, low: f64) {
    let DVec2 { x: l, y: w } = church.half_m;
    let [half, height, tip] = church.tower_m;
    let at = DVec2::new(-l * 0.55, church.tower_side * (w - half * 0.35));
    let square = |r: f64| polygon::oriented_rectangle(at, DVec2::X, DVec2::splat(r));
    let belfry = height - half * 2.4;
    b.prism(slot::CHIMNEY, slot::CHIMNEY, &square(half), low, belfry, Wall::PLAIN);
    // Pilasters at the corners.
    for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
        let c = at + DVec2::new(x, y) * (half - 0.3);
        b.block(slot::CHIMNEY, slot::CHIMNEY, c, DVec2::X, DVec2::splat(0.38), low, belfry - 0.02);
        b.block(slot::STONE, slot::STONE, c, DVec2::X, DVec2::splat(0.37), belfry - 0.1, height - 0.2);
    }
    b.prism(slot::STONE, slot::STONE, &square(half + 0.25), belfry - 0.2, belfry + 0.35, Wall::PLAIN);
    b.prism(slot::DARK, slot::DARK, &square(half - 0.35), belfry, height - 0.2, Wall::PLAIN);
    for x in [-0.33, 0.33] {
        for d in [DVec2::X, DVec2::Y] {
            for s in [-1.0, 1.0] {
                let c = at + d * (s * (half - 0.25)) + d.perp() * (x * half);
                b.block(slot::STONE, slot::STONE, c, d, DVec2::new(0.2, 0.16), belfry, height - 0.1);
            }
        }
    }
    b.prism(slot::STONE, slot::STONE, &square(half + 0.35), height - 0.6, height, Wall::PLAIN);
    b.prism(slot::CHIMNEY, slot::STONE, &square(half * 0.82), height - 0.1, height + 0.8, Wall::PLAIN);
    b.frustum(slot::METAL, slot::METAL, &square(half * 0.8), &square(0.08), height + 0.7, tip);
}
