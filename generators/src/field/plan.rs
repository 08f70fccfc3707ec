//! The plan: borders and parcels of the whole domain, the same for every radius.
//!
//! It is laid out with straight lines in a plane of its own; a gentle warp bends that plane into the world, so that
//! lanes and hedges of old farmland curve while its rows stay straight.

use super::crops::{Crop, Facts, Season, TABLE};
use super::{Params, Variant, mosaic, sections};
use crate::kit::polygon;
use crate::kit::terrain::noise::fractal;
use glam::DVec2;
use satseed_scene::SeedPath;

/// What divides two parcels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Edge {
    /// A paved lane with verges.
    Lane,
    /// An unpaved track of two ruts.
    Track,
    /// A hedge on a low bank.
    Hedge,
    /// A ditch between grass banks.
    Ditch,
    /// A strip of grass.
    Margin,
    /// Hardly anything.
    Furrow,
}

impl Edge {
    /// From the middle line to where a parcel begins, m.
    pub(super) fn half_m(self) -> f64 {
        match self {
            Self::Lane => 5.2,
            Self::Track => 2.6,
            Self::Hedge => 2.4,
            Self::Ditch => 2.7,
            Self::Margin => 1.1,
            Self::Furrow => 0.3,
        }
    }
}

/// A straight division of the plan.
#[derive(Clone, Copy, Debug)]
pub(super) struct Border {
    pub(super) ends: [DVec2; 2],
    pub(super) edge: Edge,
}

/// A parcel.
#[derive(Clone, Debug)]
pub(super) struct Parcel {
    /// Between the middle lines of its borders, plan, counter-clockwise.
    pub(super) whole: Vec<DVec2>,
    /// The border of each edge of `whole`.
    pub(super) borders: Vec<u32>,
    /// Within its borders' widths, plan.
    pub(super) outline: Vec<DVec2>,
    /// The same in the world, with points a few metres apart.
    pub(super) world: Vec<DVec2>,
    /// Direction of its rows, world.
    pub(super) axis: DVec2,
    pub(super) crop: Crop,
    /// Whether its outline is convex.
    pub(super) convex: bool,
    /// Key of its own randomness, and its name.
    pub(super) code: u64,
    /// Centre of a circle that a pivot sweeps, and its radius, plan.
    pub(super) pivot: Option<(DVec2, f64)>,
    /// Width of a combine's or rake's pass, m.
    pub(super) pass_m: f64,
}

/// A piece before it has a crop.
pub(super) struct Piece {
    pub(super) whole: Vec<DVec2>,
    pub(super) borders: Vec<u32>,
    pub(super) code: u64,
    pub(super) convex: bool,
    pub(super) crop: Option<Crop>,
    pub(super) pivot: Option<(DVec2, f64)>,
}

/// The bend of the plan into the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Warp {
    seed: u32,
    amplitude_m: f64,
}

impl Warp {
    fn shift(self, p: DVec2) -> DVec2 {
        if self.amplitude_m == 0.0 {
            return DVec2::ZERO;
        }
        let wide = |k: u32| fractal(p, self.seed ^ k, 680.0, 2, 0.4) * self.amplitude_m;
        let near = |k: u32| fractal(p, self.seed ^ k, 95.0, 2, 0.5) * (0.075 * self.amplitude_m);
        DVec2::new(wide(1) + near(3), wide(2) + near(4))
    }

    /// The plan's place of a place in the world.
    pub(super) fn plan(self, p: DVec2) -> DVec2 {
        p + self.shift(p)
    }

    /// The world's place of one in the plan: by iteration, for the shift's slope is far below 1.
    pub(super) fn world(self, q: DVec2) -> DVec2 {
        (0..14).fold(q, |p, _| q - self.shift(p))
    }
}

/// Everything of the domain.
pub(super) struct Plan {
    pub(super) warp: Warp,
    pub(super) season: Season,
    pub(super) borders: Vec<Border>,
    pub(super) parcels: Vec<Parcel>,
    /// The farmyard's parcel.
    pub(super) yard: Option<usize>,
    /// Centres and radii of pivots, plan.
    pub(super) pivots: Vec<(DVec2, f64)>,
    buckets: Buckets,
}

/// Half the side of the domain, m: it holds the largest scene however it is turned.
pub(super) const DOMAIN_HALF_M: f64 = 1900.0;

/// What lies nearest of the borders.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest {
    pub(super) border: u32,
    /// Distance from its middle line, positive on its left, m.
    pub(super) side_m: f64,
    /// Distance from the nearer of its ends, along it, m.
    pub(super) end_m: f64,
    /// Distance beyond its width, m; negative on it.
    pub(super) beyond_m: f64,
}

impl Plan {
    pub(super) fn new(params: &Params, path: &SeedPath) -> Self {
        let mut rng = path.child("season").rng();
        let season = if rng.chance(0.5) { Season::Early } else { Season::Late };
        let amplitude_m = match params.variant {
            Variant::European => 26.0,
            Variant::Pivot => 0.0,
        };
        let warp = Warp { seed: path.child("warp").hash_u32(), amplitude_m };
        let mut sheet = match params.variant {
            Variant::European => mosaic::lay(params, path),
            Variant::Pivot => sections::lay(params, path),
        };
        sheet.pieces.retain(|p| polygon::area(&p.whole) > 200.0);
        let mut parcels: Vec<Parcel> =
            sheet.pieces.into_iter().filter_map(|p| parcel(p, &sheet.borders, warp, path)).collect();
        assign(&mut parcels, &sheet.borders, season, params.variant, path);
        let yard = parcels.iter().position(|p| p.crop == Crop::Yard);
        let buckets = Buckets::new(&parcels, &sheet.borders);
        Self { warp, season, borders: sheet.borders, parcels, yard, pivots: sheet.pivots, buckets }
    }

    /// The parcel at a place of the plan, within its borders.
    pub(super) fn parcel_at(&self, q: DVec2) -> Option<usize> {
        let cell = self.buckets.cell(q);
        let found = cell.0.iter().find(|k| polygon::contains(&self.parcels[**k as usize].outline, q));
        found.map(|k| *k as usize)
    }

    /// Whether a place keeps clear of every border but one by a distance beyond its width.
    pub(super) fn is_clear(&self, q: DVec2, but: Option<u32>, distance_m: f64) -> bool {
        self.buckets.cell(q).1.iter().filter(|k| Some(**k) != but).all(|k| {
            let border = &self.borders[*k as usize];
            let reach = border.edge.half_m() + distance_m;
            border.edge == Edge::Furrow || polygon::segment_distance(border.ends[0], border.ends[1], q) > reach
        })
    }

    /// The border nearest to a place of the plan, measured from where its width ends, if one is near.
    pub(super) fn nearest(&self, q: DVec2) -> Option<Nearest> {
        let mut best: Option<Nearest> = None;
        for k in &self.buckets.cell(q).1 {
            let border = &self.borders[*k as usize];
            let [a, b] = border.ends;
            let along = b - a;
            let length = along.length();
            let t = ((q - a).dot(along) / (length * length)).clamp(0.0, 1.0);
            let away = q - a - along * t;
            let beyond_m = away.length() - border.edge.half_m();
            if best.is_none_or(|n| beyond_m < n.beyond_m) {
                let sign = if along.perp_dot(away) < 0.0 { -1.0 } else { 1.0 };
                let end_m = t.min(1.0 - t) * length;
                best = Some(Nearest { border: *k, side_m: sign * away.length(), end_m, beyond_m });
            }
        }
        best
    }
}

/// A piece within its borders.
fn parcel(piece: Piece, borders: &[Border], warp: Warp, path: &SeedPath) -> Option<Parcel> {
    let half = |k: usize| borders[piece.borders[k] as usize].edge.half_m();
    let outline = if piece.convex { polygon::inset_edges(&piece.whole, half)? } else { inset_each(&piece.whole, half) };
    // No corner may come twice, nor edges that rounding could turn.
    let outline = without_short(&outline);
    if outline.len() < 3 || polygon::area(&outline) < 150.0 {
        return None;
    }
    let world: Vec<DVec2> = polygon::subdivided(&outline, 5.0).iter().map(|q| warp.world(*q)).collect();
    let n = outline.len();
    let longest = (0..n).max_by(|i, j| {
        let l = |k: usize| outline[k].distance(outline[(k + 1) % n]);
        l(*i).total_cmp(&l(*j))
    })?;
    let along = warp.world(outline[(longest + 1) % n]) - warp.world(outline[longest]);
    let (s, c) = libm::sincos(path.child("row").index(piece.code).rng().signed() * 0.02);
    let axis = along.normalize().rotate(DVec2::new(c, s));
    let crop = piece.crop.unwrap_or(Crop::Pasture);
    let Piece { whole, borders, code, convex, pivot, .. } = piece;
    let pass_m = path.child("pass").index(code).rng().range(5.6, 9.2);
    Some(Parcel { whole, borders, outline, world, axis, crop, convex, code, pivot, pass_m })
}

fn without_short(outline: &[DVec2]) -> Vec<DVec2> {
    let mut out: Vec<DVec2> = Vec::with_capacity(outline.len());
    for p in outline {
        if out.last().is_none_or(|q| q.distance(*p) > 0.5) {
            out.push(*p);
        }
    }
    while out.len() > 1 && out[0].distance(out[out.len() - 1]) <= 0.5 {
        out.pop();
    }
    out
}

/// A simple polygon with every edge moved inward by its own distance; corners are where neighbours cross.
fn inset_each(whole: &[DVec2], half: impl Fn(usize) -> f64) -> Vec<DVec2> {
    let n = whole.len();
    (0..n)
        .map(|i| {
            let (a, p, b) = (whole[(i + n - 1) % n], whole[i], whole[(i + 1) % n]);
            let (m, k) = ((p - a).normalize().perp(), (b - p).normalize().perp());
            let (dm, dk) = (half((i + n - 1) % n), half(i));
            // Solve x . m = dm, x . k = dk for the shift of the corner.
            let det = m.perp_dot(k);
            if det.abs() < 0.05 {
                p + (m + k).normalize() * dm.max(dk)
            } else {
                p + DVec2::new(dm * k.y - dk * m.y, dk * m.x - dm * k.x) / det
            }
        })
        .collect()
}

/// Whether two pieces lie along a common border.
fn touch(a: &Parcel, b: &Parcel, borders: &[Border]) -> bool {
    let spans = |p: &Parcel, border: u32| -> Option<[f64; 2]> {
        let [from, to] = borders[border as usize].ends;
        let along = (to - from).normalize();
        let n = p.whole.len();
        let mut found: Option<[f64; 2]> = None;
        for k in (0..n).filter(|k| p.borders[*k] == border) {
            let (s, t) = ((p.whole[k] - from).dot(along), (p.whole[(k + 1) % n] - from).dot(along));
            let [low, high] = found.unwrap_or([f64::MAX, f64::MIN]);
            found = Some([low.min(s.min(t)), high.max(s.max(t))]);
        }
        found
    };
    a.borders.iter().filter(|k| b.borders.contains(k)).any(|k| match (spans(a, *k), spans(b, *k)) {
        (Some(s), Some(t)) => s[0] < t[1] + 1.0 && t[0] < s[1] + 1.0,
        _ => false,
    })
}

/// Draws crops from the pivot outward: no two neighbours get the same, and what is already there gets rarer.
fn assign(parcels: &mut [Parcel], borders: &[Border], season: Season, variant: Variant, path: &SeedPath) {
    let column = match (variant, season) {
        (Variant::European, Season::Early) => 0,
        (Variant::European, Season::Late) => 1,
        (Variant::Pivot, _) => 2,
    };
    let distance = |p: &Parcel| p.outline.iter().map(|q| q.length()).fold(f64::MAX, f64::min);
    let mut order: Vec<usize> = (0..parcels.len()).collect();
    order.sort_by(|a, b| distance(&parcels[*a]).total_cmp(&distance(&parcels[*b])).then(a.cmp(b)));
    let mut counts = vec![0.0_f64; TABLE.len()];
    let mut done = vec![false; parcels.len()];
    // Fixed ones first: they count for their neighbours.
    for k in 0..parcels.len() {
        done[k] = parcels[k].crop == Crop::Yard;
    }
    for (turn, k) in order.into_iter().enumerate() {
        if done[k] {
            continue;
        }
        let area_ha = polygon::area(&parcels[k].outline) / 1e4;
        let (low, high) = polygon::bounds(&parcels[k].outline);
        let narrow = (high - low).min_element() < 45.0 || area_ha < 0.5;
        let banned: Vec<Crop> = (0..parcels.len())
            .filter(|o| done[*o] && touch(&parcels[k], &parcels[*o], borders))
            .map(|o| parcels[o].crop)
            .collect();
        let weight = |f: &Facts| {
            let fits = match f.crop {
                Crop::Vines | Crop::Orchard => area_ha < 3.5 && parcels[k].pivot.is_none(),
                Crop::Copse => area_ha < 1.1,
                Crop::Pasture | Crop::Bales | Crop::Hay | Crop::Straw => parcels[k].pivot.is_none(),
                _ => !narrow,
            };
            let loose = parcels[k].convex || f.crop.is_loose();
            if !fits || !loose || banned.contains(&f.crop) {
                return 0.0;
            }
            let species: f64 = TABLE.iter().zip(&counts).filter(|(t, _)| t.species == f.species).map(|(_, c)| c).sum();
            // Old ones are forgotten, so that far parcels are as mixed as near ones.
            let often = 1.0 + 1.5 * species + 2.0 * counts[f.crop as usize];
            f.weights[column] / (often * often)
        };
        let weights: Vec<f64> = TABLE.iter().map(weight).collect();
        parcels[k].crop = if weights.iter().all(|w| *w == 0.0) {
            // Loose grass of a stage that no neighbour has.
            *[Crop::Pasture, Crop::Seedbed, Crop::Tilled, Crop::Stubble, Crop::Bales]
                .iter()
                .find(|c| !banned.contains(c))
                .unwrap_or(&Crop::Pasture)
        } else {
            TABLE[path.child("crop").index(parcels[k].code).rng().weighted(&weights)].crop
        };
        done[k] = true;
        counts[parcels[k].crop as usize] += 1.0;
        if turn % 16 == 15 {
            for count in &mut counts {
                *count *= 0.5;
            }
        }
    }
}

/// Side of a look-up cell, m.
const BUCKET_M: f64 = 32.0;
/// Borders farther than this beyond their width are not near, m.
pub(super) const REACH_M: f64 = 34.0;

/// Parcels and borders by place of the plan.
struct Buckets {
    across: usize,
    cells: Vec<(Vec<u32>, Vec<u32>)>,
}

/// The buckets hold the domain and what the warp brings in.
const BUCKETS_HALF_M: f64 = DOMAIN_HALF_M + 64.0;

impl Buckets {
    fn new(parcels: &[Parcel], borders: &[Border]) -> Self {
        let across = libm::ceil(2.0 * BUCKETS_HALF_M / BUCKET_M) as usize;
        let mut this = Self { across, cells: vec![(Vec::new(), Vec::new()); across * across] };
        for (k, p) in parcels.iter().enumerate() {
            let (low, high) = polygon::bounds(&p.outline);
            this.over(low, high, |cell, _| cell.0.push(k as u32));
        }
        for (k, b) in borders.iter().enumerate() {
            let reach = REACH_M + b.edge.half_m();
            let [low, high] = [b.ends[0].min(b.ends[1]) - reach, b.ends[0].max(b.ends[1]) + reach];
            this.over(low, high, |cell, middle| {
                if polygon::segment_distance(b.ends[0], b.ends[1], middle) < reach + 0.71 * BUCKET_M {
                    cell.1.push(k as u32);
                }
            });
        }
        this
    }

    fn index(&self, x: f64) -> usize {
        (((x + BUCKETS_HALF_M) / BUCKET_M).max(0.0) as usize).min(self.across - 1)
    }

    fn over(&mut self, low: DVec2, high: DVec2, mut add: impl FnMut(&mut (Vec<u32>, Vec<u32>), DVec2)) {
        let (i0, i1, j0, j1) = (self.index(low.x), self.index(high.x), self.index(low.y), self.index(high.y));
        for j in j0..=j1 {
            for i in i0..=i1 {
                let middle = DVec2::new(i as f64 + 0.5, j as f64 + 0.5) * BUCKET_M - BUCKETS_HALF_M;
                add(&mut self.cells[j * self.across + i], middle);
            }
        }
    }

    fn cell(&self, q: DVec2) -> &(Vec<u32>, Vec<u32>) {
        &self.cells[self.index(q.y) * self.across + self.index(q.x)]
    }
}
