//! The skeleton of the hills: ridges that wind side by side, spurs that leave them, and the ground that hangs from both.
//!
//! A ridge is a line with a height. The land falls away from the nearest ridges by a profile, and where the slopes of two
//! of them meet there is a ravine. Streets and pads then cut into the land and fill it: where they lie the ground is
//! theirs, and around them it is kept within the slope of a bank. All of it is one function of place.

use super::lots::{self, Candidate};
use crate::kit::polygon;
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::sampling::smoothstep;
use glam::{DVec2, DVec3};
use satseed_scene::SeedPath;
use std::collections::BTreeMap;

/// Distance of ridges, m.
const PITCH_M: f64 = 296.0;
/// Along a ridge, from one place where spurs may leave it to the next, m.
const STATION_M: f64 = 192.0;
/// Distance of a ridge's points, m.
const STEP_M: f64 = 12.0;
/// Ridges go on as far as the ground's corners; spurs and what is built stand as far as any scene looks, m.
const REACH_M: f64 = 3500.0;
pub(super) const BUILT_M: f64 = 1500.0;
/// A ridge shapes the land out to this distance, m: more than half a pitch.
const FALLS_M: f64 = 235.0;
/// A bank changes the land out to this distance, m.
const BANK_REACH_M: f64 = 42.0;
/// Steepest cut or fill: height over width.
pub(super) const BANK: f64 = 0.6;
/// Half width of the level strip that a street lies on, m.
pub(super) const ROW_M: f64 = 7.2;
/// Radius of the level ground around a cul-de-sac, m.
pub(super) const BULB_ROW_M: f64 = 14.4;
/// Half width of a fire road's bench, m.
const TRACK_M: f64 = 2.6;
/// Side of a look-up cell, m.
const CELL_M: f64 = 48.0;
/// Two slopes that meet are rounded over this height, m.
const ROUND_M: f64 = 11.0;

/// What a ridge carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Crest {
    /// A street with houses on both sides.
    Street,
    /// The same, ending in a cul-de-sac.
    Spur,
    /// A fire road.
    Wild,
}

/// A line from which the land hangs: points of the sheet with the height of the ground there.
#[derive(Clone, Debug)]
pub(super) struct Ridge {
    pub(super) crest: Crest,
    /// Number of the ridge, of the place along it, and of the side to which a spur leaves it.
    pub(super) index: [i64; 3],
    pub(super) points: Vec<DVec3>,
}

/// The hills of one scene.
#[derive(Clone, Debug)]
pub(in super::super) struct Hills {
    pub(super) ridges: Vec<Ridge>,
    /// The lots with their pads.
    pub(super) lots: Vec<Candidate>,
    pub(super) cover_seed: u32,
    /// Pieces of ridges that shape the land of a cell, and those whose banks do.
    falls: BTreeMap<[i32; 2], Vec<[u32; 2]>>,
    banks: BTreeMap<[i32; 2], Vec<[u32; 2]>>,
    pads_at: BTreeMap<[i32; 2], Vec<u32>>,
    seed: u32,
}

fn cell(p: DVec2) -> [i32; 2] {
    [libm::floor(p.x / CELL_M) as i32, libm::floor(p.y / CELL_M) as i32]
}

fn cells(low: DVec2, high: DVec2) -> impl Iterator<Item = [i32; 2]> {
    let ([i0, j0], [i1, j1]) = (cell(low), cell(high));
    (j0..=j1).flat_map(move |j| (i0..=i1).map(move |i| [i, j]))
}

/// Nearest point of a piece of a ridge: distance and height there.
fn nearest(a: DVec3, b: DVec3, p: DVec2) -> (f64, f64) {
    let d = b.truncate() - a.truncate();
    let t = ((p - a.truncate()).dot(d) / d.length_squared()).clamp(0.0, 1.0);
    ((p - a.truncate() - d * t).length(), a.z + (b.z - a.z) * t)
}

impl Crest {
    /// How far the land lies below a ridge at a distance from it, m.
    fn fall_m(self, d: f64) -> f64 {
        let (flat, gentle, steep_to) = match self {
            Self::Street => (36.0, 0.035, 92.0),
            Self::Spur => (31.0, 0.03, 84.0),
            Self::Wild => (7.0, 0.05, 76.0),
        };
        let over = (d - flat).max(0.0);
        // The crest's edge is rounded; below the steep part lies the foot of the slope.
        let round = 14.0;
        let steep = if over < round { over * over / (2.0 * round) } else { over - round / 2.0 };
        let foot = (d - steep_to).max(0.0);
        gentle * d + 0.56 * steep - 0.3 * foot
    }
}

impl Hills {
    pub(in super::super) fn new(city: &SeedPath) -> Self {
        let path = city.child("hills");
        let mut this = Self {
            ridges: ridges(&path),
            lots: Vec::new(),
            cover_seed: path.child("cover").hash_u32(),
            falls: BTreeMap::new(),
            banks: BTreeMap::new(),
            pads_at: BTreeMap::new(),
            seed: path.child("gullies").hash_u32(),
        };
        for (r, ridge) in this.ridges.iter().enumerate() {
            for (k, s) in ridge.points.windows(2).enumerate() {
                let (a, b) = (s[0].truncate(), s[1].truncate());
                for (map, reach) in [(&mut this.falls, FALLS_M), (&mut this.banks, BANK_REACH_M + BULB_ROW_M)] {
                    for c in cells(a.min(b) - reach, a.max(b) + reach) {
                        map.entry(c).or_default().push([r as u32, k as u32]);
                    }
                }
            }
        }
        this.pads(&path);
        this
    }

    fn piece(&self, [r, k]: [u32; 2]) -> (Crest, DVec3, DVec3) {
        let ridge = &self.ridges[r as usize];
        (ridge.crest, ridge.points[k as usize], ridge.points[k as usize + 1])
    }

    /// The land before anything was built, m.
    pub(super) fn natural_m(&self, p: DVec2) -> f64 {
        let Some(near) = self.falls.get(&cell(p)) else { return -60.0 };
        // The highest slope and the highest of another ridge's.
        let (mut first, mut second) = (f64::MIN, f64::MIN);
        // Gullies and knolls are on slopes, none on a crest.
        let mut on_slope: f64 = 1.0;
        for chunk in near.chunk_by(|a, b| a[0] == b[0]) {
            let mut best = f64::MIN;
            for id in chunk {
                let (crest, a, b) = self.piece(*id);
                let (d, z) = nearest(a, b, p);
                best = best.max(z - crest.fall_m(d));
                let [from, to] = if crest == Crest::Wild { [6.0, 40.0] } else { [40.0, 75.0] };
                on_slope = on_slope.min(smoothstep(from, to, d));
            }
            second = second.max(best.min(first));
            first = first.max(best);
        }
        let apart = ((first - second) / ROUND_M).min(1.0);
        let rounded = first + 0.25 * ROUND_M * (1.0 - apart) * (1.0 - apart);
        rounded
            + on_slope * (3.2 * fractal(p, self.seed, 78.0, 3, 0.45) + 1.1 * fractal(p, self.seed ^ 9, 23.0, 2, 0.4))
    }

    /// The ground, m.
    pub(in super::super) fn height_m(&self, p: DVec2) -> f64 {
        let mut h = self.natural_m(p);
        for k in self.pads_at.get(&cell(p)).into_iter().flatten() {
            let pad = &self.lots[*k as usize];
            let d = if polygon::contains(&pad.outline, p) { 0.0 } else { polygon::border_distance(&pad.outline, p) };
            h = kept(h, pad.height_m, d);
        }
        self.with_streets(p, h)
    }

    fn with_streets(&self, p: DVec2, natural_m: f64) -> f64 {
        let mut h = natural_m;
        let near = self.banks.get(&cell(p)).map_or(&[][..], Vec::as_slice);
        // Where a spur leaves a ridge the ridge's street keeps its grade.
        for spurs in [true, false] {
            for chunk in near.chunk_by(|a, b| a[0] == b[0]) {
                let ridge = &self.ridges[chunk[0][0] as usize];
                if (ridge.index[2] != 0) == spurs {
                    h = self.with_street(ridge, chunk, p, h);
                }
            }
        }
        h
    }

    /// The ground with the strip of one street and the banks beside it.
    fn with_street(&self, ridge: &Ridge, pieces: &[[u32; 2]], p: DVec2, natural_m: f64) -> f64 {
        let at = |id: &[u32; 2]| {
            let (_, a, b) = self.piece(*id);
            nearest(a, b, p)
        };
        let (d, z) = pieces.iter().map(at).fold((f64::MAX, 0.0), |best, at| if at.0 < best.0 { at } else { best });
        let half = if ridge.crest == Crest::Wild { TRACK_M } else { ROW_M };
        let h = kept(natural_m, z, (d - half).max(0.0));
        if ridge.crest != Crest::Spur {
            return h;
        }
        let end = ridge.points[ridge.points.len() - 1];
        kept(h, end.z, (p.distance(end.truncate()) - BULB_ROW_M).max(0.0))
    }

    /// Distance of the nearest street's middle or, less the difference of their widths, of a cul-de-sac's, m, and its
    /// height there.
    pub(super) fn street(&self, p: DVec2) -> (f64, f64) {
        let mut best = (f64::MAX, 0.0);
        for id in self.banks.get(&cell(p)).into_iter().flatten() {
            let (crest, a, b) = self.piece(*id);
            let half = if crest == Crest::Wild { ROW_M - TRACK_M } else { 0.0 };
            let mut at = nearest(a, b, p);
            at.0 += half;
            let ridge = &self.ridges[id[0] as usize];
            if crest == Crest::Spur && id[1] as usize + 2 == ridge.points.len() {
                at.0 = at.0.min((p.distance(b.truncate()) - (BULB_ROW_M - ROW_M)).max(0.0));
            }
            if at.0 < best.0 {
                best = at;
            }
        }
        best
    }

    /// Whether a place is nearer than a distance to any pad.
    pub(super) fn near_pad(&self, p: DVec2, by_m: f64) -> bool {
        self.pads_at.get(&cell(p)).into_iter().flatten().any(|k| {
            let o = &self.lots[*k as usize].outline;
            polygon::contains(o, p) || polygon::border_distance(o, p) < by_m
        })
    }

    /// Height of the highest ridge that shapes the land at a place, where the place hangs from it, m.
    pub(super) fn crest_m(&self, p: DVec2) -> f64 {
        let pieces = self.falls.get(&cell(p)).into_iter().flatten();
        let of = |id: &[u32; 2]| {
            let (crest, a, b) = self.piece(*id);
            let (d, z) = nearest(a, b, p);
            (z - crest.fall_m(d), z)
        };
        pieces.map(of).fold((f64::MIN, 0.0), |best, at| if at.0 > best.0 { at } else { best }).1
    }

    /// Adds a lot where its pad it fits: clear of other pads, within a bank's slope of every street, and not too far from the land.
    fn add(&mut self, lot: Candidate) {
        let (outline, height_m) = (&lot.outline, lot.height_m);
        let apart = polygon::mitred(outline, -1.7);
        let (low, high) = polygon::bounds(outline);
        let (low, high) = (low - BANK_REACH_M, high + BANK_REACH_M);
        for k in cells(low, high).filter_map(|c| self.pads_at.get(&c)).flatten() {
            let other = &self.lots[*k as usize];
            if polygon::convex_overlap(&apart, &polygon::mitred(&other.outline, -1.7)) {
                return;
            }
            // What lies between two pads must not be steeper than a bank.
            let step = (other.height_m - height_m).abs();
            let gap = outline
                .iter()
                .map(|p| polygon::border_distance(&other.outline, *p))
                .chain(other.outline.iter().map(|p| polygon::border_distance(outline, *p)))
                .fold(f64::MAX, f64::min);
            if step > BANK * gap {
                return;
            }
        }
        for p in polygon::subdivided(outline, 5.0) {
            let (d, z) = self.street(p);
            if d < ROW_M + 1.2
                || (z - height_m).abs() > BANK * (d - ROW_M)
                || (self.natural_m(p) - height_m).abs() > 8.0
            {
                return;
            }
        }
        let k = self.lots.len() as u32;
        for c in cells(low, high) {
            self.pads_at.entry(c).or_default().push(k);
        }
        self.lots.push(lot);
    }

    /// Pads along both sides of every street, in the order of its lots.
    fn pads(&mut self, path: &SeedPath) {
        let order = [Crest::Street, Crest::Spur];
        for crest in order {
            for r in 0..self.ridges.len() {
                if self.ridges[r].crest == crest {
                    let ridge = self.ridges[r].clone();
                    for lot in lots::candidates(&ridge, path) {
                        self.add(lot);
                    }
                }
            }
        }
    }
}

/// Ground that is a level's own within it and no further from it than a bank's slope around it.
fn kept(natural_m: f64, level_m: f64, distance_m: f64) -> f64 {
    natural_m.clamp(level_m - BANK * distance_m, level_m + BANK * distance_m)
}

/// All ridges, streets first and spurs after the ridge that they leave.
fn ridges(path: &SeedPath) -> Vec<Ridge> {
    let mut rng = path.rng();
    let tau = core::f64::consts::TAU;
    let (shift, phase) = (DVec2::new(rng.range(0.0, STATION_M), rng.range(-75.0, 75.0)), rng.range(0.0, tau));
    let (turning, second) = (rng.range(0.3, 0.7), rng.range(0.0, tau));
    let count = libm::ceil(REACH_M / PITCH_M) as i64;
    let mut out = Vec::new();
    for j in -count..=count {
        let mut rng = path.child("ridge").index(j as u64).rng();
        let own = [rng.range(0.0, tau), rng.range(0.0, tau), rng.range(0.0, tau)];
        let base_m = rng.signed() * 10.0;
        // Neighbours wind nearly together, so that no ravine is too narrow.
        let y = |x: f64| {
            j as f64 * PITCH_M
                + shift.y
                + 42.0 * libm::sin(tau * x / 640.0 + phase + turning * j as f64)
                + 12.0 * libm::sin(tau * x / 410.0 + second + own[0] * 0.15)
        };
        let z =
            |x: f64| base_m + 10.5 * libm::sin(tau * x / 880.0 + own[1]) + 2.6 * libm::sin(tau * x / 530.0 + own[2]);
        let crest = if j.rem_euclid(3) == 2 { Crest::Wild } else { Crest::Street };
        let n = libm::ceil(REACH_M / STEP_M) as i64;
        let points = (-n..=n).map(|k| k as f64 * STEP_M).map(|x| DVec3::new(x, y(x), z(x))).collect();
        out.push(Ridge { crest, index: [j, 0, 0], points });
        let stations = libm::ceil(BUILT_M / STATION_M) as i64;
        for i in -stations..=stations {
            for side in [-1_i64, 1] {
                let mut rng = path.child("spur").index(j as u64).index(i as u64).index((side + 1) as u64).rng();
                // Those of neighbours stand between each other.
                let between = if j.rem_euclid(2) == 0 { 0.25 } else { 0.75 };
                let x = (i as f64 + between + 0.13 * rng.signed()) * STATION_M + shift.x;
                let foot = DVec3::new(x, y(x), z(x));
                if foot.truncate().length() > BUILT_M || !rng.chance(0.8) {
                    continue;
                }
                let along = DVec2::new(1.0, (y(x + 0.5) - y(x - 0.5)).clamp(-1.0, 1.0)).normalize();
                let (s, c) = libm::sincos(rng.signed() * 0.3);
                let way = DVec2::new(c, s).rotate(along.perp() * side as f64);
                let length_m = rng.range(78.0, 104.0);
                let grade = rng.range(0.03, 0.095);
                let n = libm::round(length_m / STEP_M) as i64;
                // Level where it leaves the street and around its end.
                let points = (0..=n)
                    .map(|k| {
                        let t = length_m * k as f64 / n as f64;
                        let down = (t - 14.0).clamp(0.0, length_m - 14.0 - 16.0);
                        (foot.truncate() + way * t).extend(foot.z - grade * down)
                    })
                    .collect();
                let crest = if crest == Crest::Wild { Crest::Wild } else { Crest::Spur };
                out.push(Ridge { crest, index: [j, i, side], points });
            }
        }
    }
    out
}
