//! Streets as two families of lines, and the blocks and segments between them.
//!
//! Every street is a straight line with a cross-section. Two families give a grid whose lines need be neither evenly
//! spaced nor quite parallel. Positions are keyed by the line's index, so a part of a city can be planned by itself.

use super::polygon;
use glam::DVec2;
use satseed_scene::SeedPath;

/// Cross-section of a street, symmetric about its line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrossSection {
    /// Which of the region's kinds it is.
    pub kind: u16,
    /// From kerb to kerb, m.
    pub roadway_m: f64,
    /// Sidewalk on either side, m.
    pub sidewalk_m: f64,
}

impl CrossSection {
    /// From property line to property line, m.
    pub fn right_of_way_m(&self) -> f64 {
        self.roadway_m + 2.0 * self.sidewalk_m
    }
}

/// A straight street.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Street {
    /// A point of its centre line, world, m.
    pub through_m: DVec2,
    /// Its direction, unit.
    pub direction: DVec2,
    /// Its cross-section.
    pub section: CrossSection,
}

impl Street {
    /// A point at a signed distance to the left of the line's `through_m`, `along` metres on.
    pub fn at(&self, along_m: f64, left_m: f64) -> DVec2 {
        self.through_m + self.direction * along_m + self.direction.perp() * left_m
    }

    /// Where the lines parallel to two streets, `left` metres to their left, cross.
    pub fn crossing(&self, left_m: f64, other: &Self, other_left_m: f64) -> DVec2 {
        let (p, q) = (self.at(0.0, left_m), other.at(0.0, other_left_m));
        let t = (q - p).perp_dot(other.direction) / self.direction.perp_dot(other.direction);
        p + self.direction * t
    }

    /// Distance along the street of the foot of a point, m.
    pub fn along(&self, p: DVec2) -> f64 {
        (p - self.through_m).dot(self.direction)
    }
}

/// What decides one family of streets.
#[derive(Clone, Debug, PartialEq)]
pub struct Family {
    /// Direction of its streets, unit.
    pub direction: DVec2,
    /// Depth of the blocks between them (property line to property line), m: least and greatest.
    pub block_m: [f64; 2],
    /// Greatest turn of a street against the family, radians.
    pub turn_rad: f64,
    /// Cross-sections with their weights.
    pub sections: Vec<(f64, CrossSection)>,
}

/// The streets of one family out to a distance. Index `i` of the result is line `first + i`; line 0 is the first on the
/// left of the pivot.
pub fn family(family: &Family, path: &SeedPath, reach_m: f64) -> (i64, Vec<Street>) {
    let weights: Vec<f64> = family.sections.iter().map(|s| s.0).collect();
    let section = |i: i64| family.sections[path.child("section").index(i as u64).rng().weighted(&weights)].1;
    let gap = |i: i64| path.child("gap").index(i as u64).rng().range(family.block_m[0], family.block_m[1]);
    let street = |i: i64, left: f64| {
        let turn = path.child("turn").index(i as u64).rng().signed() * family.turn_rad;
        let (s, c) = libm::sincos(turn);
        let d = family.direction;
        Street {
            through_m: d.perp() * left,
            direction: DVec2::new(d.x * c - d.y * s, d.x * s + d.y * c),
            section: section(i),
        }
    };
    // Block `i` lies between lines `i - 1` and `i`; block 0 holds the pivot.
    let half = |i: i64| section(i).right_of_way_m() / 2.0;
    let pitch = |i: i64| half(i - 1) + gap(i) + half(i);
    let start = path.child("start").rng().range(0.3, 0.7) * gap(0) + half(0);
    let mut streets = Vec::new();
    let (mut i, mut left) = (0, start);
    while left < reach_m {
        streets.push(street(i, left));
        i += 1;
        left += pitch(i);
    }
    let (mut i, mut left) = (0, start);
    loop {
        left -= pitch(i);
        i -= 1;
        if left < -reach_m {
            break;
        }
        streets.insert(0, street(i, left));
    }
    (i + 1, streets)
}

/// Two crossing families.
#[derive(Clone, Debug, PartialEq)]
pub struct StreetPlan {
    /// First index of each family.
    pub first: [i64; 2],
    /// Streets of each family, from right to left of its direction.
    pub streets: [Vec<Street>; 2],
}

/// The land between four streets.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Indices that name it in both families.
    pub index: [i64; 2],
    /// Kerb line, four corners.
    pub kerb: Vec<DVec2>,
    /// Property line, four corners.
    pub property: Vec<DVec2>,
}

/// A street between two crossings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Family and indices that name it.
    pub index: [i64; 3],
    /// The street.
    pub street: Street,
    /// From kerb line to kerb line of the crossing streets, metres along it.
    pub span_m: [f64; 2],
}

impl StreetPlan {
    /// All blocks whose centre lies within a distance of the pivot.
    pub fn blocks(&self, reach_m: f64) -> Vec<Block> {
        let [a, b] = &self.streets;
        let mut out = Vec::new();
        for i in 1..a.len() {
            for j in 1..b.len() {
                let quad = |with_sidewalk: bool| {
                    let h =
                        |s: &Street| s.section.roadway_m / 2.0 + if with_sidewalk { s.section.sidewalk_m } else { 0.0 };
                    let (r, l, d, u) = (&a[i - 1], &a[i], &b[j - 1], &b[j]);
                    let mut q = vec![
                        r.crossing(h(r), d, h(d)),
                        r.crossing(h(r), u, -h(u)),
                        l.crossing(-h(l), u, -h(u)),
                        l.crossing(-h(l), d, h(d)),
                    ];
                    if polygon::area(&q) < 0.0 {
                        q.reverse();
                    }
                    q
                };
                let kerb = quad(false);
                if polygon::centroid(&kerb).length() <= reach_m {
                    let index = [self.first[0] + i as i64, self.first[1] + j as i64];
                    out.push(Block { index, kerb, property: quad(true) });
                }
            }
        }
        out
    }

    /// All segments whose middle lies within a distance of the pivot.
    pub fn segments(&self, reach_m: f64) -> Vec<Segment> {
        let mut out = Vec::new();
        for f in 0..2 {
            let (own, other) = (&self.streets[f], &self.streets[1 - f]);
            for (i, s) in own.iter().enumerate() {
                for j in 1..other.len() {
                    let ends = [&other[j - 1], &other[j]].map(|o| s.along(s.crossing(0.0, o, 0.0)));
                    let (low, high, before, after) = if ends[0] < ends[1] {
                        (ends[0], ends[1], &other[j - 1], &other[j])
                    } else {
                        (ends[1], ends[0], &other[j], &other[j - 1])
                    };
                    let span_m = [low + before.section.roadway_m / 2.0, high - after.section.roadway_m / 2.0];
                    if s.at(f64::midpoint(span_m[0], span_m[1]), 0.0).length() <= reach_m {
                        let index = [f as i64, self.first[f] + i as i64, self.first[1 - f] + j as i64];
                        out.push(Segment { index, street: *s, span_m });
                    }
                }
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(reach_m: f64) -> StreetPlan {
        let section = CrossSection { kind: 0, roadway_m: 10.4, sidewalk_m: 4.8 };
        let make = |direction: DVec2| Family {
            direction,
            block_m: [100.0, 140.0],
            turn_rad: 0.01,
            sections: vec![(1.0, section)],
        };
        let root = SeedPath::root("streets", 5);
        let (a, north) = family(&make(DVec2::Y), &root.child("a"), reach_m);
        let (b, east) = family(&make(DVec2::X), &root.child("b"), reach_m);
        StreetPlan { first: [a, b], streets: [north, east] }
    }

    #[test]
    fn a_crop_has_the_same_blocks() {
        let (small, large) = (plan(400.0).blocks(250.0), plan(1200.0).blocks(250.0));
        assert!(small.len() >= 8);
        assert_eq!(small, large);
    }

    #[test]
    fn blocks_keep_apart_by_their_streets() {
        for b in plan(800.0).blocks(500.0) {
            assert!(polygon::area(&b.property) > 9000.0 && polygon::area(&b.kerb) > polygon::area(&b.property));
            for p in &b.property {
                assert!((polygon::border_distance(&b.kerb, *p) - 4.8).abs() < 0.05);
            }
        }
    }
}
