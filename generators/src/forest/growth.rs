//! The trees: one dart after another, the biggest first, over the same square for every scene, of which a small scene works
//! out no more than it needs.

use super::land::Land;
use super::stands::{Kind, Stands, sickness};
use super::{Params, REACH_M};
use crate::kit::terrain::noise::fractal;
use crate::kit::woods::Species;
use glam::DVec2;
use rayon::prelude::*;
use satseed_scene::{Raster, SeedPath, hash_cell, unit_from_hash};

/// Half the side of the square in which trees grow, m.
pub(super) const TREES_HALF_M: f64 = REACH_M;
/// Side of the cells in which candidates are drawn, m.
const CELL_M: f64 = 6.0;
/// Widest crown radius, m: no two trees hinder each other from farther than twice as far.
const WIDEST_M: f64 = 8.0;
/// How much farther than needed candidates are drawn at first, m: what is not known beyond them reaches so far only
/// through a chain of trees that each decide about the next.
const MARGIN_M: f64 = 48.0;
/// Share of the sum of two crowns' radii within which one keeps the other from growing; a low one under a high one a
/// little less.
const HINDERS: f64 = 0.57;
/// Distance of the canopy raster's posts, m.
const CANOPY_M: f64 = 2.0;

/// How a tree fares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Health {
    Green,
    /// Leaves or needles have turned brown.
    Brown,
    /// Bare.
    Dead,
}

/// A tree that found its place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tree {
    pub(super) at_m: DVec2,
    pub(super) species: Species,
    pub(super) height_m: f64,
    pub(super) crown_m: f64,
    pub(super) health: Health,
    /// Its cell and number there.
    pub(super) key: (i32, i32, i32),
}

/// The trees, and how closed their canopy is.
pub(super) struct Growth {
    pub(super) trees: Vec<Tree>,
    canopy: Raster<f32>,
}

impl Growth {
    /// The trees of the square that ends at `half_m` on all sides, and some beyond it; the same ones whatever its size.
    pub(super) fn new(land: &Land, stands: &Stands, params: &Params, half_m: f64, path: &SeedPath) -> Self {
        // Crowns from beyond reach in, and the canopy's posts are smoothed.
        let needed_m = half_m + WIDEST_M + 2.0 * CANOPY_M;
        let mut margin_m = MARGIN_M;
        let trees = loop {
            let darts = darts(land, stands, path.hash_u32(), needed_m + margin_m);
            if let Some(trees) = thrown(&darts, stands, params.density, needed_m) {
                break trees;
            }
            margin_m *= 2.0;
        };
        let canopy = canopy(&trees);
        Self { trees, canopy }
    }

    /// How much sky the ground sees, 0 under closed crowns to 1 in the open.
    pub(super) fn light(&self, p: DVec2) -> f64 {
        1.0 - self.canopy.bilinear(p)
    }
}

/// Candidates of a square of cells, the biggest first.
struct Darts {
    darts: Vec<Tree>,
    /// Half the square's side, m; none where there are no others beyond it.
    half_m: Option<f64>,
}

fn darts(land: &Land, stands: &Stands, seed: u32, half_m: f64) -> Darts {
    let all = libm::ceil(TREES_HALF_M / CELL_M) as i32;
    let half = all.min(libm::ceil(half_m / CELL_M) as i32);
    let mut darts: Vec<Tree> = (-half..half)
        .into_par_iter()
        .flat_map_iter(|j| (-half..half).flat_map(move |i| candidates(land, stands, seed, (i, j))))
        .collect();
    // The key decides between equals.
    darts.sort_by(|a, b| b.crown_m.total_cmp(&a.crown_m).then(a.key.cmp(&b.key)));
    Darts { darts, half_m: (half < all).then_some(f64::from(half) * CELL_M) }
}

/// Candidates of a cell.
fn candidates(land: &Land, stands: &Stands, seed: u32, cell: (i32, i32)) -> Vec<Tree> {
    let mut out = Vec::new();
    let mut k = 0;
    let mut most = 10;
    while k < most {
        let number = k;
        let draw = |n: i32| f64::from(unit_from_hash(hash_cell(cell.0, cell.1, 32 * number + n, seed)));
        let p = DVec2::new(f64::from(cell.0) + draw(0), f64::from(cell.1) + draw(1)) * CELL_M;
        // Neighbouring stands seed into each other.
        let scatter = DVec2::new(draw(2) + draw(3) - 1.0, draw(4) + draw(5) - 1.0) * 9.0;
        let stand = stands.at(p + scatter);
        most = if stand.kind == Kind::Young { 24 } else { 15 };
        k += 1;
        let normal =
            |n: i32| f64::sqrt(-2.0 * libm::log(1.0 - draw(n))) * libm::cos(core::f64::consts::TAU * draw(n + 1));
        let outside = stands.outside_m(p);
        // A few old trees stand on clear-cuts; young ones come up in gaps.
        let kind = match stand.kind {
            Kind::Cut if draw(6) < 0.0025 => Kind::Grown,
            Kind::Cut if draw(6) < 0.06 => Kind::Young,
            Kind::Cut => continue,
            Kind::Grown if outside < 0.0 => {
                if draw(6) < 0.16 {
                    Kind::Young
                } else {
                    continue;
                }
            }
            // Grass and brambles keep the rest.
            Kind::Young if patch(p, seed) < -0.3 && draw(6) < 0.75 => continue,
            kind => kind,
        };
        let species = Species::ALL[pick(&stand.mix, draw(7))];
        let conifer = species.is_conifer();
        let (height_m, crown_m) = if kind == Kind::Young {
            // Higher and lower by patches: no sowing comes up everywhere at once.
            let patch = (1.0 + 1.3 * patch(p, seed)).clamp(0.45, 1.5);
            let h = 2.0 + 6.5 * patch * (0.35 + 0.65 * draw(8)) * (0.5 + 0.5 * draw(9));
            (h, (0.55 + 0.15 * h) * if conifer { 0.85 } else { 1.1 } * libm::exp(0.15 * normal(10)))
        } else {
            // Weibull of stem diameters, cm; heights and crowns from them.
            let shape = if conifer { 2.5 } else { 2.1 };
            let stem = (stand.stem_cm * libm::pow(-libm::log(1.0 - draw(8)), 1.0 / shape)).clamp(7.0, 75.0);
            let grown = libm::pow(1.0 - libm::exp(-0.035 * stem), 1.1);
            let emergent = if draw(12) < 0.035 { 1.0 + 0.2 * draw(13) } else { 1.0 };
            // Neighbours draw each other up: thin stems of a closed stand are higher than alone.
            let alone = 1.3 + (stand.tallest_m - 1.3) * grown;
            let height = (0.42 * alone + 0.58 * 0.80 * stand.tallest_m) * libm::exp(0.07 * normal(14)) * emergent;
            let wide = match species {
                Species::Oak => (1.5 + 0.13 * stem) * 1.15,
                Species::Beech => 1.5 + 0.13 * stem,
                Species::Birch => (1.5 + 0.13 * stem) * 0.8,
                Species::Pine => (1.0 + 0.09 * stem) * 1.25,
                Species::Spruce | Species::Larch => (1.0 + 0.09 * stem) * 1.12,
            };
            (height, 0.5 * wide * libm::exp(if conifer { 0.25 } else { 0.17 } * normal(16)))
        };
        let crown_m = crown_m.clamp(0.5, WIDEST_M);
        let height_m = height_m.clamp(1.5, 44.0).max(1.6 * crown_m);
        // Stems keep off ways and water, wide crowns a little farther.
        let keep = |beyond: f64, from: f64, lean: f64| beyond > from + lean * crown_m;
        let open = keep(land.track.beyond_m(p), 1.9, 0.22)
            && keep(land.rides.beyond_m(p), 0.3, 0.2)
            && keep(land.streams.beyond_m(p), 0.4, 0.05)
            && (kind == Kind::Young || keep(outside, 0.2, 0.3));
        if !open {
            continue;
        }
        let sick = stand.sick * sickness(p, seed ^ 0x51c) * if conifer { 2.6 } else { 1.1 } + 0.035;
        let health = match draw(18) {
            d if d < 0.4 * sick => Health::Dead,
            d if d < sick + 0.012 => Health::Brown,
            _ => Health::Green,
        };
        out.push(Tree { at_m: p, species, height_m, crown_m, health, key: (cell.0, cell.1, number) });
    }
    out
}

/// How well a young stand came up, about -0.6 to 0.6.
fn patch(p: DVec2, seed: u32) -> f64 {
    fractal(p, seed ^ 0x9a7c, 27.0, 3, 0.55)
}

fn pick(weights: &[f64; 6], draw: f64) -> usize {
    let mut left = draw * weights.iter().sum::<f64>();
    weights
        .iter()
        .position(|w| {
            left -= w;
            left < 0.0
        })
        .unwrap_or(0)
}

/// What a tree's crown takes of the room, m: those of conifers are loose at their rim and reach into each other.
fn spread_m(tree: &Tree) -> f64 {
    tree.crown_m * if tree.species.is_conifer() { 0.84 } else { 1.0 }
}

/// A dart that stays, as later ones see it.
struct Stays {
    at_m: DVec2,
    spread_m: f64,
    height_m: f64,
    /// Whether it stays whatever lies beyond the candidates.
    sure: bool,
}

/// Variable-radius dart throwing: a dart stays where no earlier one is too near. Crowns interlock, and a low tree may
/// stand half under a high one. None where candidates that were not drawn may decide about a tree within `needed_m`.
fn thrown(darts: &Darts, stands: &Stands, density: f64, needed_m: f64) -> Option<Vec<Tree>> {
    let side_m = 4.0;
    let reach_m = darts.half_m.unwrap_or(TREES_HALF_M) + CELL_M;
    let across = libm::ceil(2.0 * reach_m / side_m) as usize;
    let cell = |x: f64| (((x + reach_m) / side_m).max(0.0) as usize).min(across - 1);
    let mut grid: Vec<Vec<Stays>> = (0..across * across).map(|_| Vec::new()).collect();
    let mut kept: Vec<Tree> = Vec::new();
    let closeness = 1.0 / density.sqrt();
    let widest = darts.darts.first().map_or(0.0, |dart| dart.crown_m);
    for dart in &darts.darts {
        let apart = stands.at(dart.at_m).apart * closeness;
        let spread = spread_m(dart);
        let reach = HINDERS * apart * (spread + widest);
        let (i0, i1) = (cell(dart.at_m.x - reach), cell(dart.at_m.x + reach));
        let (j0, j1) = (cell(dart.at_m.y - reach), cell(dart.at_m.y + reach));
        let outside_m = dart.at_m.abs().max_element();
        let mut sure = darts.half_m.is_none_or(|half| half - outside_m > HINDERS * apart * (spread + WIDEST_M));
        let hindered = (j0..=j1).any(|j| {
            (i0..=i1).any(|i| {
                grid[j * across + i].iter().any(|other| {
                    let under = dart.height_m < 0.62 * other.height_m;
                    let share = if under { 0.56 } else { HINDERS };
                    let least = share * apart * (spread + other.spread_m);
                    let near = other.at_m.distance_squared(dart.at_m) < least * least;
                    sure &= other.sure || !near;
                    near && other.sure
                })
            })
        });
        if hindered {
            continue;
        }
        if sure {
            kept.push(*dart);
        } else if outside_m < needed_m {
            return None;
        }
        let stays = Stays { at_m: dart.at_m, spread_m: spread, height_m: dart.height_m, sure };
        grid[cell(dart.at_m.y) * across + cell(dart.at_m.x)].push(stays);
    }
    Some(kept)
}

/// How much of the sky crowns cover, smoothed over a few metres.
fn canopy(trees: &[Tree]) -> Raster<f32> {
    let n = libm::round(2.0 * TREES_HALF_M / CANOPY_M) as usize + 1;
    let mut cover = Raster::filled(DVec2::splat(-TREES_HALF_M), CANOPY_M, n, n, 0.0_f32);
    for tree in trees.iter().filter(|t| t.health != Health::Dead && t.height_m > 4.0) {
        let r = tree.crown_m * 0.95;
        let low = cover.grid_from_world(tree.at_m - r).ceil().max(DVec2::ZERO);
        let high = cover.grid_from_world(tree.at_m + r).floor();
        for j in low.y as usize..=(high.y.max(0.0) as usize).min(n - 1) {
            for i in low.x as usize..=(high.x.max(0.0) as usize).min(n - 1) {
                if cover.position(i, j).distance(tree.at_m) < r {
                    cover.set(i, j, 1.0);
                }
            }
        }
    }
    let sharp = cover.clone();
    for j in 1..n - 1 {
        for i in 1..n - 1 {
            let mut sum = 0.0;
            for (dj, di) in [(-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 0), (0, 1), (1, -1), (1, 0), (1, 1)] {
                sum += sharp.get_clamped(i as i64 + di, j as i64 + dj);
            }
            cover.set(i, j, sum / 9.0);
        }
    }
    cover
}
