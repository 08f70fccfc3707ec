//! Canals first: a square of lagoon is cut again and again until islands are left, and bridges are set over the cuts.
//!
//! Everything here is in the plan's straight frame. The whole city is cut, whatever part of it is built, so that a small
//! scene is a part of the large one.

use super::Variant;
use super::piece::{Piece, Side};
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::SeedPath;

/// Half side of the square that is cut, m.
pub(super) const HALF_M: f64 = 1500.0;

/// Ground on which one square of the city's larger ones is found, m^2: seven to a frame of 614 m.
const PARISH_M2: f64 = 76_000.0;

/// An island between canals.
#[derive(Clone, Debug)]
pub(super) struct Isle {
    /// Its ground; all sides are water.
    pub piece: Piece,
    /// Its number in the tree of cuts.
    pub key: u64,
    /// Whether a campo lies on it.
    pub campo: bool,
    /// Where bridges land.
    pub landings: Vec<Landing>,
}

/// The foot of a bridge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Landing {
    /// On the shore, m.
    pub at: DVec2,
    /// Away from the water, unit.
    pub inward: DVec2,
}

/// A bridge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bridge {
    /// Its two ends on the shores, m.
    pub shores: [DVec2; 2],
    /// Width, m.
    pub width_m: f64,
    /// Its number.
    pub key: u64,
}

/// All islands and bridges of a city.
#[derive(Clone, Debug)]
pub(super) struct Canals {
    /// Islands.
    pub isles: Vec<Isle>,
    /// Bridges.
    pub bridges: Vec<Bridge>,
}

/// The Grand Canal: a snake through the city.
struct Grand {
    points: Vec<DVec2>,
    half_widths_m: Vec<f64>,
}

impl Grand {
    fn new(city: &SeedPath) -> Self {
        let mut rng = city.child("grand canal").rng();
        let (sin, cos) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
        let (along, wave_m) = (DVec2::new(cos, sin), rng.range(980.0, 1250.0));
        let (amplitude_m, phase) = (rng.range(110.0, 150.0), rng.range(-0.5, 0.5));
        let (wide_phase, wide_m) = (rng.range(0.0, 6.0), rng.range(300.0, 480.0));
        let (mut points, mut half_widths_m) = (Vec::new(), Vec::new());
        for k in -440..=440 {
            let s = f64::from(k) * 5.0;
            let t = amplitude_m * libm::sin(core::f64::consts::TAU * s / wave_m + phase)
                + 22.0 * libm::sin(s / 71.0 + 2.0 * phase);
            points.push(along * s + along.perp() * t);
            half_widths_m.push(20.5 + 5.0 * libm::sin(core::f64::consts::TAU * s / wide_m + wide_phase));
        }
        Self { points, half_widths_m }
    }

    /// Nearest place of the canal's middle, the direction to its left there, and half its width, m.
    fn nearest(&self, p: DVec2) -> (DVec2, DVec2, f64) {
        let mut best = (f64::MAX, 1);
        for (k, q) in self.points.iter().enumerate() {
            let d = q.distance_squared(p);
            if d < best.0 {
                best = (d, k);
            }
        }
        let k = best.1.clamp(1, self.points.len() - 2);
        let along = (self.points[k + 1] - self.points[k - 1]).normalize();
        (self.points[k], along.perp(), self.half_widths_m[k])
    }

    /// What the canal leaves of a piece on both sides of it.
    fn banks(&self, piece: &Piece) -> Vec<Piece> {
        let mut out = Vec::new();
        for side in [1.0, -1.0] {
            // The bank is nearly straight along an island: first where the whole is nearest, then where its part is.
            let mut part = Some(piece.clone());
            for _ in 0..3 {
                part = part.and_then(|part| {
                    let (on, left, half_m) = self.nearest(part.centre());
                    piece.clipped(on + left * (side * half_m), left * side, Side::Water)
                });
            }
            out.extend(part.filter(|p| p.area() > 500.0 && p.long_axis().2 > 13.0));
        }
        out
    }
}

/// Whether the campo of a piece's surroundings has its place yet.
#[derive(Clone, Copy)]
enum Parish {
    /// The piece is larger than a parish.
    Larger,
    /// The campo shall be here.
    Here(DVec2),
    /// The campo is elsewhere.
    Elsewhere,
}

struct Cutter<'a> {
    city: &'a SeedPath,
    grand: Option<Grand>,
    isles: Vec<Isle>,
    /// Line, width and number of every cut.
    cuts: Vec<([DVec2; 2], f64, u64)>,
}

/// Cuts a city.
pub(super) fn cut(variant: Variant, city: &SeedPath) -> Canals {
    let grand = (variant == Variant::Canal).then(|| Grand::new(city));
    let mut cutter = Cutter { city, grand, isles: Vec::new(), cuts: Vec::new() };
    let (sin, cos) = libm::sincos(city.child("turn").rng().range(0.0, core::f64::consts::TAU));
    let square = polygon::oriented_rectangle(DVec2::ZERO, DVec2::new(cos, sin), DVec2::splat(HALF_M));
    cutter.halve(&Piece::new(square, Side::Water), 1, Parish::Larger);
    let bridges = cutter.bridges();
    Canals { isles: cutter.isles, bridges }
}

impl Cutter<'_> {
    /// Halves a piece until it is an island.
    fn halve(&mut self, piece: &Piece, key: u64, parish: Parish) {
        let mut rng = self.city.child("cut").index(key).rng();
        let area = piece.area();
        let parish = match parish {
            Parish::Larger if area < PARISH_M2 => Parish::Here(piece.centre()),
            other => other,
        };
        let (axis, length_m, width_m) = piece.long_axis();
        let wanted = rng.lognormal(12_200.0, 0.38).clamp(6_000.0, 27_000.0);
        if area < wanted || length_m < 70.0 {
            self.leaf(piece, key, parish);
            return;
        }
        // Across the longer axis, seldom squarely; the largest pieces are cut by the longest canals.
        let skew = rng.signed() * if length_m > 1.5 * width_m { 0.36 } else { 0.22 };
        let (sin, cos) = libm::sincos(skew);
        let along = axis.perp() * cos + axis * sin;
        let [low, high] = piece.extent(axis);
        let share = rng.range(0.36, 0.64);
        let on = piece.centre() + axis * (low + (high - low) * share - piece.centre().dot(axis));
        let canal_m = match area {
            a if a > 260_000.0 => rng.range(8.5, 13.0),
            a if a > 60_000.0 => rng.range(6.0, 9.6),
            _ => rng.range(4.4, 7.4),
        };
        if let Some(line) = chord(piece, on, along) {
            self.cuts.push((line, canal_m, key));
        }
        let left = along.perp();
        for (k, part) in (0..).zip(piece.cut(on, along, canal_m, Side::Water)) {
            if let Some(part) = part {
                let parish = match parish {
                    // Left of the cut is the first part.
                    Parish::Here(at) if ((at - on).dot(left) > 0.0) != (k == 0) => Parish::Elsewhere,
                    other => other,
                };
                self.halve(&part, 2 * key + k, parish);
            }
        }
    }

    fn leaf(&mut self, piece: &Piece, key: u64, parish: Parish) {
        let parts = self.grand.as_ref().map_or_else(|| vec![piece.clone()], |grand| grand.banks(piece));
        let largest = parts.iter().map(Piece::area).fold(0.0, f64::max);
        for (k, piece) in (0..).zip(parts) {
            let campo = matches!(parish, Parish::Here(_)) && piece.area() == largest && largest > 4200.0;
            let piece = piece.blunted(11.0, Side::Water).without_short_sides(2.0);
            self.isles.push(Isle { piece, key: 2 * key + k, campo, landings: Vec::new() });
        }
    }

    /// Bridges over the cuts, where both shores are free of corners, and their landings.
    fn bridges(&mut self) -> Vec<Bridge> {
        let mut bridges = Vec::new();
        for (line, canal_m, key) in core::mem::take(&mut self.cuts) {
            let path = self.city.child("bridges").index(key);
            let along = (line[1] - line[0]).normalize();
            let length_m = line[0].distance(line[1]);
            let mut rng = path.rng();
            let count = libm::floor(length_m / 330.0 + rng.range(0.0, 0.85)) as u64;
            for k in 0..count {
                let mut rng = path.index(k).rng();
                for _ in 0..8 {
                    let at = line[0].lerp(line[1], (k as f64 + rng.range(0.12, 0.88)) / count as f64);
                    let across = along.perp() * (canal_m / 2.0);
                    let width_m = rng.range(2.3, 3.9);
                    if let Some(bridge) = self.landed([at - across, at + across], width_m, key * 64 + k) {
                        bridges.push(bridge);
                        break;
                    }
                }
            }
        }
        bridges
    }

    /// A bridge whose ends both stand on shores, well away from corners and from other bridges.
    fn landed(&mut self, shores: [DVec2; 2], width_m: f64, key: u64) -> Option<Bridge> {
        let across = (shores[1] - shores[0]).normalize();
        let mut ends = Vec::new();
        for (at, inward) in [(shores[0], -across), (shores[1], across)] {
            let index = self.isles.iter().position(|isle| {
                let piece = &isle.piece;
                // Its side, straight to both sides of the foot.
                let near = |p: DVec2| piece.border_distance(p) < 0.05;
                let span = across.perp() * (width_m / 2.0 + 3.0);
                (at - piece.corners[0]).length() < 600.0
                    && near(at + span)
                    && near(at - span)
                    && piece.contains(at + inward * 1.5)
                    && isle.landings.iter().all(|l| l.at.distance(at) > 24.0)
            })?;
            ends.push((index, Landing { at, inward }));
        }
        for (index, landing) in ends {
            self.isles[index].landings.push(landing);
        }
        Some(Bridge { shores, width_m, key })
    }
}

/// The part of a line inside a piece.
fn chord(piece: &Piece, on: DVec2, along: DVec2) -> Option<[DVec2; 2]> {
    let side = |p: DVec2| along.perp_dot(p - on);
    let ends: Vec<DVec2> = (0..piece.corners.len())
        .filter_map(|i| {
            let [a, b] = piece.ends(i);
            let (sa, sb) = (side(a), side(b));
            ((sa < 0.0) != (sb < 0.0)).then(|| a.lerp(b, sa / (sa - sb)))
        })
        .collect();
    (ends.len() == 2).then(|| [ends[0], ends[1]])
}
