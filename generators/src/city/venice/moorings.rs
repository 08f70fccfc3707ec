//! Where boats lie and go: along walls, at gondola stations, and under way on wide water.

use super::boats::Boat;
use super::bridges::Span;
use super::things::{Placed, Thing};
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::{Rng, SeedPath};

/// The shore of an island in the world.
#[derive(Clone, Debug)]
pub(super) struct Shore {
    /// The island's number.
    pub key: u64,
    /// Its sides: points along each, the last one being the next side's first.
    pub sides: Vec<Vec<DVec2>>,
    /// Its whole outline.
    pub outline: Vec<DVec2>,
    /// Bounds of it.
    pub bounds: (DVec2, DVec2),
}

/// A boat in its place.
#[derive(Clone, Debug)]
pub(super) struct Moored {
    /// What.
    pub boat: Boat,
    /// Where in the world, m.
    pub at: DVec2,
    /// Where its bow points.
    pub axis: DVec2,
    /// Its path below the city's.
    pub name: String,
}

/// Water and land as boats see them.
pub(super) struct Waters<'a> {
    /// All islands.
    pub shores: &'a [Shore],
    /// All bridges.
    pub spans: &'a [Span],
}

/// Farthest that the opposite shore is looked for, m.
const FAR_M: f64 = 60.0;

impl Waters<'_> {
    /// The island on which a place lies.
    fn isle_at(&self, p: DVec2) -> Option<&Shore> {
        self.shores
            .iter()
            .find(|s| p.cmpge(s.bounds.0).all() && p.cmple(s.bounds.1).all() && polygon::contains(&s.outline, p))
    }

    /// Distance to the opposite shore, m, and that island's number.
    fn across(&self, from: DVec2, outward: DVec2) -> (f64, Option<u64>) {
        let mut d = 1.0;
        while d < FAR_M {
            if let Some(isle) = self.isle_at(from + outward * d) {
                return (d, Some(isle.key));
            }
            d += if d < 12.0 { 0.5 } else { 2.0 };
        }
        (FAR_M, None)
    }

    /// Whether a boat has water all around it and no bridge above.
    fn is_free(&self, at: DVec2, axis: DVec2, [l, w]: [f64; 2]) -> bool {
        let rect = polygon::oriented_rectangle(at, axis, DVec2::new(l / 2.0 + 0.2, w / 2.0 + 0.1));
        rect.iter().all(|p| self.isle_at(*p).is_none())
            && self.spans.iter().all(|s| {
                let d = at - s.centre_m;
                d.length_squared() > 900.0
                    || d.dot(s.axis).abs() > s.length_m / 2.0 + l / 2.0 + 3.0
                    || d.dot(s.axis.perp()).abs() > s.width_m / 2.0 + l / 2.0 + 0.8
            })
    }

    /// Boats along an island's shore, and the piles that hold them. `boats` is a factor on their number.
    pub(super) fn moored(&self, shore: &Shore, boats: f64, city: &SeedPath) -> (Vec<Moored>, Vec<Placed>) {
        let (mut moored, mut piles) = (Vec::new(), Vec::new());
        for (side, points) in shore.sides.iter().enumerate() {
            let path = city.child("mooring").index(shore.key).index(side as u64);
            let mut rng = path.rng();
            let share = rng.range(0.36, 0.72) * boats;
            let length: f64 = points.windows(2).map(|p| p[0].distance(p[1])).sum();
            let mut s = rng.range(2.0, 6.0);
            let mut k = 0;
            while s < length - 4.0 {
                k += 1;
                let mut rng = path.index(k).rng();
                let (place, along) = at_length(points, s + 3.0);
                let outward = -along.perp();
                let (wide_m, other) = self.across(place + outward * 0.6, outward);
                // In a narrow canal boats lie on one side only.
                let ours = wide_m > 8.5 || other.is_none_or(|o| ((o ^ shore.key) & 2 == 0) == (shore.key < o));
                let boat = draw(wide_m, &mut rng);
                let [l, w] = boat.size_m();
                let station = wide_m > 26.0 && rng.chance(0.12);
                if station {
                    let count = 3 + rng.below(5);
                    for g in 0..count {
                        let (p, along) = at_length(points, s + 1.9 * g as f64);
                        let out = -along.perp();
                        let name = format!("boat/{}/{side}/{k}/{g}", shore.key);
                        let at = p + out * 7.0;
                        if self.is_free(at, out, Boat::Gondola.size_m()) && rng.chance(0.85 * boats) {
                            moored.push(Moored { boat: Boat::Gondola, at, axis: out, name: name.clone() });
                            for d in [2.4, 11.5] {
                                let at = p + out * d + along * 0.95;
                                if self.isle_at(at).is_none() {
                                    let name = format!("{name}/pile/{d}");
                                    piles.push(Placed { thing: Thing::Pile, at, axis: along, cloth: 0, name });
                                }
                            }
                        }
                    }
                    s += 1.9 * count as f64 + 4.0;
                    continue;
                }
                let (place, along) = at_length(points, s + l / 2.0);
                let outward = -along.perp();
                let axis = if rng.chance(0.8) == (shore.key & 1 == 0) { along } else { -along };
                let at = place + outward * (w / 2.0 + rng.range(0.25, 0.55));
                let (sin, cos) = libm::sincos(rng.signed() * 0.04);
                let axis = axis * cos + axis.perp() * sin;
                if ours && w + 2.0 < wide_m && rng.chance(share) && self.is_free(at, axis, [l, w]) {
                    let name = format!("boat/{}/{side}/{k}", shore.key);
                    if wide_m > 14.0 && rng.chance(0.5) {
                        let at = at + outward * (w / 2.0 + 0.35) + along * (l * 0.4);
                        let name = format!("{name}/pile");
                        if self.isle_at(at).is_none() {
                            piles.push(Placed { thing: Thing::Pile, at, axis: along, cloth: 0, name });
                        }
                    }
                    moored.push(Moored { boat, at, axis, name });
                    s += l + rng.range(0.5, 1.8);
                } else {
                    s += rng.range(4.0, 7.0);
                }
            }
        }
        (moored, piles)
    }

    /// Boats under way and piles out on wide water, from a grid over the plane out to a distance.
    pub(super) fn under_way(&self, reach_m: f64, boats: f64, city: &SeedPath) -> (Vec<Moored>, Vec<Placed>) {
        let (mut under_way, mut piles) = (Vec::new(), Vec::new());
        let step = 30.0;
        let n = libm::ceil(reach_m / step) as i64;
        for j in -n..=n {
            for i in -n..=n {
                let path = city.child("under way").index((i + 4096) as u64).index((j + 4096) as u64);
                let mut rng = path.rng();
                let at = (DVec2::new(i as f64, j as f64) + DVec2::new(rng.signed(), rng.signed()) * 0.35) * step;
                // Wide enough in the eight directions, and the way the water goes.
                let clear = |d: f64| {
                    (0..8).all(|k| {
                        let (s, c) = libm::sincos(core::f64::consts::TAU * f64::from(k) / 8.0);
                        self.isle_at(at + DVec2::new(c, s) * d).is_none()
                    })
                };
                if at.length() > reach_m || self.isle_at(at).is_some() || !clear(6.5) {
                    continue;
                }
                let free = |k: i32| {
                    let (s, c) = libm::sincos(core::f64::consts::PI * f64::from(k) / 12.0);
                    let d = DVec2::new(c, s);
                    self.across(at, d).0 + self.across(at, -d).0
                };
                let best = (0..12).max_by(|a, b| free(*a).total_cmp(&free(*b))).unwrap_or(0);
                let (s, c) = libm::sincos(core::f64::consts::PI * f64::from(best) / 12.0 + rng.signed() * 0.12);
                let axis = DVec2::new(c, s) * if rng.chance(0.5) { 1.0 } else { -1.0 };
                let name = format!("boat/under-way/{i}/{j}");
                if rng.chance(0.62 * boats) {
                    let boat = match rng.weighted(&[0.24, 0.3, 0.2, 0.14, 0.12]) {
                        0 => Boat::Taxi,
                        1 => Boat::Cofano,
                        2 => Boat::Barge,
                        3 => Boat::Gondola,
                        _ => Boat::Vaporetto,
                    };
                    if self.is_free(at, axis, boat.size_m()) {
                        under_way.push(Moored { boat, at, axis, name });
                        continue;
                    }
                }
                if rng.chance(0.16) {
                    let name = format!("briccola/{i}/{j}");
                    piles.push(Placed { thing: Thing::Briccola, at, axis, cloth: 0, name });
                }
            }
        }
        (under_way, piles)
    }
}

/// What lies along a canal of a width.
fn draw(wide_m: f64, rng: &mut Rng) -> Boat {
    let weights = match wide_m {
        w if w < 5.5 => [0.55, 0.0, 0.45, 0.0, 0.0, 0.12],
        w if w < 9.0 => [0.24, 0.28, 0.34, 0.05, 0.02, 0.07],
        w if w < 20.0 => [0.18, 0.28, 0.24, 0.16, 0.08, 0.06],
        _ => [0.06, 0.22, 0.12, 0.22, 0.28, 0.1],
    };
    [Boat::Sandolo, Boat::Cofano, Boat::Covered, Boat::Barge, Boat::Taxi, Boat::Gondola][rng.weighted(&weights)]
}

/// The place at a length along a polyline, and the direction there.
fn at_length(points: &[DVec2], length_m: f64) -> (DVec2, DVec2) {
    let mut left = length_m;
    for p in points.windows(2) {
        let d = p[0].distance(p[1]);
        if left <= d {
            return (p[0].lerp(p[1], left / d), (p[1] - p[0]) / d);
        }
        left -= d;
    }
    let (a, b) = (points[points.len() - 2], points[points.len() - 1]);
    (b, (b - a).normalize())
}
