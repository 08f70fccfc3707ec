//! Convex pieces of ground whose sides know what lies beyond them: what a city of parcels is cut out of.

use crate::kit::polygon;
use glam::DVec2;

/// What lies beyond a side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    /// A canal, right at the wall.
    Water,
    /// A quay along a canal.
    Quay,
    /// A street of a few metres.
    Calle,
    /// A square.
    Campo,
    /// A court.
    Court,
    /// The neighbour's wall.
    Party,
}

/// A convex polygon, counter-clockwise. Side `i` runs from corner `i` to the next.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Piece {
    /// Corners, m.
    pub corners: Vec<DVec2>,
    /// What lies beyond each side.
    pub sides: Vec<Side>,
}

/// Corners nearer than this fall together, m.
const SAME_M: f64 = 0.02;

impl Piece {
    /// A polygon with the same beyond all sides.
    pub(super) fn new(corners: Vec<DVec2>, side: Side) -> Self {
        let sides = vec![side; corners.len()];
        Self { corners, sides }
    }

    /// m^2.
    pub(super) fn area(&self) -> f64 {
        polygon::area(&self.corners)
    }

    /// Centre of area.
    pub(super) fn centre(&self) -> DVec2 {
        polygon::centroid(&self.corners)
    }

    /// The ends of side `i`.
    pub(super) fn ends(&self, i: usize) -> [DVec2; 2] {
        [self.corners[i], self.corners[(i + 1) % self.corners.len()]]
    }

    /// Least and greatest coordinate along a direction, m.
    pub(super) fn extent(&self, along: DVec2) -> [f64; 2] {
        self.corners.iter().map(|p| p.dot(along)).fold([f64::MAX, f64::MIN], |[a, b], x| [a.min(x), b.max(x)])
    }

    /// The direction of the side across which the piece is narrowest, and the lengths along it and across it, m.
    pub(super) fn long_axis(&self) -> (DVec2, f64, f64) {
        let mut best = (DVec2::X, 0.0, f64::MAX);
        for i in 0..self.corners.len() {
            let [a, b] = self.ends(i);
            let d = (b - a).normalize();
            let length = |v: DVec2| {
                let [low, high] = self.extent(v);
                high - low
            };
            let across = length(d.perp());
            if across < best.2 {
                best = (d, length(d), across);
            }
        }
        if best.1 < best.2 { (best.0.perp(), best.2, best.1) } else { best }
    }

    /// The part where `(p - on) . inward` is positive; the new side has `side` beyond it.
    pub(super) fn clipped(&self, on: DVec2, inward: DVec2, side: Side) -> Option<Self> {
        let n = self.corners.len();
        let height = |p: DVec2| (p - on).dot(inward);
        let (mut corners, mut sides) = (Vec::with_capacity(n + 1), Vec::with_capacity(n + 1));
        for i in 0..n {
            let [a, b] = self.ends(i);
            let (ha, hb) = (height(a), height(b));
            if ha >= 0.0 {
                corners.push(a);
                sides.push(self.sides[i]);
            }
            if (ha > 0.0 && hb < 0.0) || (ha < 0.0 && hb > 0.0) {
                corners.push(a + (b - a) * (ha / (ha - hb)));
                sides.push(if ha > 0.0 { side } else { self.sides[i] });
            }
        }
        // Of two corners that fall together the side between them goes.
        let mut out = Self { corners: Vec::new(), sides: Vec::new() };
        for i in 0..corners.len() {
            let next: DVec2 = corners[(i + 1) % corners.len()];
            if next.distance(corners[i]) > SAME_M {
                out.corners.push(corners[i]);
                out.sides.push(sides[i]);
            }
        }
        (out.corners.len() >= 3 && out.area() > 1.0).then_some(out)
    }

    /// Both parts of a cut along a line, `gap_m` apart: left of the line, and right of it.
    pub(super) fn cut(&self, on: DVec2, along: DVec2, gap_m: f64, side: Side) -> [Option<Self>; 2] {
        let left = along.perp();
        [self.clipped(on + left * (gap_m / 2.0), left, side), self.clipped(on - left * (gap_m / 2.0), -left, side)]
    }

    /// Every side moved inward by what `inset` gives for its index and renamed.
    pub(super) fn inset(&self, inset: impl Fn(usize) -> (f64, Side)) -> Option<Self> {
        let mut out = self.clone();
        for i in 0..self.corners.len() {
            let [a, b] = self.ends(i);
            let inward = (b - a).normalize().perp();
            let (distance_m, side) = inset(i);
            // The piece itself is cut, whatever its sides are called by now: of the old side only its line is needed.
            out = out.clipped(a + inward * distance_m, inward, side)?;
        }
        Some(out)
    }

    /// Without sides shorter than a length, m: the corner at their end goes.
    pub(super) fn without_short_sides(&self, shortest_m: f64) -> Self {
        let mut out = self.clone();
        while out.corners.len() > 3 {
            let n = out.corners.len();
            let short = (0..n).find(|i| out.corners[*i].distance(out.corners[(*i + 1) % n]) < shortest_m);
            let Some(i) = short else { break };
            out.corners.remove((i + 1) % n);
            out.sides.remove(i);
        }
        out
    }

    /// With every tip sharper than about 58 degrees cut off where it is `width_m` wide.
    pub(super) fn blunted(&self, width_m: f64, side: Side) -> Self {
        let mut out = self.clone();
        for _ in 0..self.corners.len() {
            let n = out.corners.len();
            let sharp = (0..n).find_map(|i| {
                let (a, p, b) = (out.corners[(i + n - 1) % n], out.corners[i], out.corners[(i + 1) % n]);
                let (u, v) = ((a - p).normalize(), (b - p).normalize());
                // Half the angle's tangent is the half-width over the distance from the tip.
                (u.dot(v) > 0.53).then(|| {
                    let inward = (u + v).normalize();
                    let tangent = u.perp_dot(v).abs() / (1.0 + u.dot(v));
                    (p + inward * (width_m / 2.0 / tangent.max(0.1)), inward)
                })
            });
            let Some((on, inward)) = sharp else { break };
            match out.clipped(on, inward, side) {
                Some(cut) if cut.area() > 0.6 * out.area() => out = cut,
                _ => break,
            }
        }
        out
    }

    /// Distance of a point to the border, m.
    pub(super) fn border_distance(&self, p: DVec2) -> f64 {
        polygon::border_distance(&self.corners, p)
    }

    /// Whether a point lies inside.
    pub(super) fn contains(&self, p: DVec2) -> bool {
        polygon::contains(&self.corners, p)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(side_m: f64) -> Piece {
        Piece::new(polygon::rectangle(DVec2::ZERO, DVec2::splat(side_m)), Side::Water)
    }

    #[test]
    fn a_cut_leaves_a_gap_and_names_its_sides() {
        let [left, right] = square(10.0).cut(DVec2::new(4.0, 5.0), DVec2::Y, 2.0, Side::Calle);
        let (left, right) = (left.unwrap(), right.unwrap());
        assert!((left.area() - 30.0).abs() < 1e-9 && (right.area() - 50.0).abs() < 1e-9);
        for p in [&left, &right] {
            assert_eq!(p.sides.iter().filter(|s| **s == Side::Calle).count(), 1);
            assert_eq!(p.sides.len(), 4);
            let k = p.sides.iter().position(|s| *s == Side::Calle).unwrap();
            let [a, b] = p.ends(k);
            assert!(a.x == b.x && (a.x == 3.0 || a.x == 5.0), "{a} {b}");
        }
        assert!(left.contains(DVec2::new(1.0, 5.0)) && right.contains(DVec2::new(9.0, 5.0)));
    }

    #[test]
    fn tips_are_cut_off_and_square_corners_stay() {
        assert_eq!(square(10.0).blunted(3.0, Side::Calle), square(10.0));
        let wedge = Piece::new(vec![DVec2::ZERO, DVec2::new(40.0, -6.0), DVec2::new(40.0, 6.0)], Side::Water);
        let blunt = wedge.blunted(4.0, Side::Calle);
        assert_eq!(blunt.corners.len(), 4);
        let k = blunt.sides.iter().position(|s| *s == Side::Calle).unwrap();
        let [a, b] = blunt.ends(k);
        assert!((a.distance(b) - 4.0).abs() < 1e-9, "{a} {b}");
    }

    #[test]
    fn an_inset_moves_each_side_by_its_own() {
        let p = square(10.0).inset(|i| (i as f64, Side::Quay)).unwrap();
        // Sides 0 to 3 are south, east, north, west.
        assert!((p.area() - (10.0 - 2.0) * (10.0 - 4.0)).abs() < 1e-9);
        assert_eq!(p.sides, [Side::Water, Side::Quay, Side::Quay, Side::Quay]);
    }
}
