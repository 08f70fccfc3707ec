//! Roofs over convex outlines.
//!
//! Each side with eaves carries a plane that rises inward; the roof is the lowest of them. On a convex outline that is
//! what a straight skeleton gives (Aichholzer et al. 1995), and a face is the outline cut by the lines where two planes
//! meet. Sides without eaves are gables, or walls that the roof leans on.

use crate::kit::mesh_builder::MeshBuilder;
use glam::{DVec2, DVec3};
use satseed_scene::quantise_m;
use std::collections::BTreeMap;

/// A roof in a building's frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Roof {
    /// Outline of the eaves, convex, counter-clockwise.
    pub outline: Vec<DVec2>,
    /// Slope of the plane on each side; none for gables.
    pub slopes: Vec<Option<f64>>,
    /// Height of the eaves' upper edge, m.
    pub eaves_m: f64,
}

/// A part of a roof.
struct Face {
    corners: Vec<usize>,
    side: usize,
}

/// Slots that a roof is made in.
#[derive(Clone, Copy, Debug)]
pub(super) struct RoofSlots {
    /// Tiles.
    pub roof: u16,
    /// Edge and underside.
    pub edge: u16,
    /// Gables.
    pub gable: u16,
}

/// Thickness of a roof at its eaves, m.
const THICK_M: f64 = 0.2;

impl Roof {
    fn plane(&self, i: usize) -> Option<(DVec2, DVec2, f64)> {
        let (a, b) = (self.outline[i], self.outline[(i + 1) % self.outline.len()]);
        self.slopes[i].map(|slope| (a, (b - a).normalize().perp(), slope))
    }

    /// Height of the roof above its eaves at a place within the outline, m.
    pub(super) fn rise_m(&self, p: DVec2) -> f64 {
        let rise = |i: usize| self.plane(i).map(|(on, inward, slope)| (p - on).dot(inward) * slope);
        (0..self.outline.len()).filter_map(rise).fold(f64::INFINITY, f64::min).max(0.0)
    }

    /// Height of the tiles at a place, m.
    pub(super) fn height_m(&self, p: DVec2) -> f64 {
        self.eaves_m + self.rise_m(p)
    }

    /// The side whose plane is the roof at a place.
    pub(super) fn side_at(&self, p: DVec2) -> Option<usize> {
        let rise = |i: usize| self.plane(i).map(|(on, inward, slope)| ((p - on).dot(inward) * slope, i));
        (0..self.outline.len()).filter_map(rise).min_by(|a, b| a.0.total_cmp(&b.0)).map(|r| r.1)
    }

    /// Corners, quantised, and faces over them.
    fn faces(&self) -> (Vec<DVec2>, Vec<Face>) {
        let mut points: Vec<DVec2> =
            self.outline.iter().map(|p| DVec2::new(quantise_m(p.x).into(), quantise_m(p.y).into())).collect();
        let mut faces = Vec::new();
        for i in 0..self.outline.len() {
            let Some((on, inward, slope)) = self.plane(i) else { continue };
            let mut face = self.outline.clone();
            for j in 0..self.outline.len() {
                let Some((other_on, other_inward, other_slope)) = self.plane(j) else { continue };
                if i == j {
                    continue;
                }
                // Where plane j lies above plane i.
                let over = |p: DVec2| (p - other_on).dot(other_inward) * other_slope - (p - on).dot(inward) * slope;
                face = clip(&face, over);
                if face.len() < 3 {
                    break;
                }
            }
            let mut corners: Vec<usize> = Vec::new();
            for p in face {
                let known = points.iter().position(|q| q.distance(p) < 0.03).unwrap_or_else(|| {
                    points.push(DVec2::new(quantise_m(p.x).into(), quantise_m(p.y).into()));
                    points.len() - 1
                });
                if corners.last() != Some(&known) && corners.first() != Some(&known) {
                    corners.push(known);
                }
            }
            if corners.len() >= 3 {
                faces.push(Face { corners, side: i });
            }
        }
        (points, faces)
    }

    /// The roof as a closed solid. False, and nothing made, when its faces would not close.
    pub(super) fn mesh(&self, b: &mut MeshBuilder, slots: RoofSlots) -> bool {
        let n = self.outline.len();
        let (points, faces) = self.faces();
        let mut balance: BTreeMap<(usize, usize), i32> = BTreeMap::new();
        for face in &faces {
            for k in 0..face.corners.len() {
                let (a, c) = (face.corners[k], face.corners[(k + 1) % face.corners.len()]);
                *balance.entry((a, c)).or_default() += 1;
                *balance.entry((c, a)).or_default() -= 1;
            }
        }
        // The rim: from each corner of the outline along open edges to the next one.
        let next: BTreeMap<usize, usize> = balance.iter().filter(|(_, k)| **k == 1).map(|(e, _)| *e).collect();
        if balance.values().any(|k| k.abs() > 1) || next.len() != balance.values().filter(|k| **k == 1).count() {
            return false;
        }
        let mut rims = Vec::new();
        for i in 0..n {
            let mut rim = vec![i];
            let goal = (i + 1) % n;
            while rim[rim.len() - 1] != goal {
                match next.get(&rim[rim.len() - 1]) {
                    Some(to) if rim.len() <= points.len() => rim.push(*to),
                    _ => return false,
                }
            }
            rims.push(rim);
        }
        if rims.iter().map(|r| r.len() - 1).sum::<usize>() != next.len() {
            return false;
        }
        let z: Vec<f64> = points.iter().map(|p| self.height_m(*p)).collect();
        for face in &faces {
            let Some((on, inward, slope)) = self.plane(face.side) else { continue };
            let along = -inward.perp();
            let stretch = (1.0 + slope * slope).sqrt();
            let corners: Vec<(DVec3, DVec2)> = face
                .corners
                .iter()
                .map(|c| {
                    let d = points[*c] - on;
                    (points[*c].extend(z[*c]), DVec2::new(d.dot(along), d.dot(inward) * stretch))
                })
                .collect();
            b.fan(slots.roof, &corners);
        }
        let low = self.eaves_m - THICK_M;
        for (i, rim) in rims.iter().enumerate() {
            let (p, q) = (points[i], points[(i + 1) % n]);
            let along = (q - p).normalize();
            let uv = |c: DVec2, z: f64| (c.extend(z), DVec2::new((c - p).dot(along), z - low));
            let mut corners = vec![uv(p, low), uv(q, low)];
            corners.extend(rim.iter().rev().map(|c| uv(points[*c], z[*c])));
            b.fan(if self.slopes[i].is_some() { slots.edge } else { slots.gable }, &corners);
        }
        b.cap(slots.edge, &points[..n], low, false);
        true
    }

    /// The ridge and hips as segments with their heights, m: where the tiles of two sides meet.
    pub(super) fn ridges(&self) -> Vec<[DVec3; 2]> {
        let (points, faces) = self.faces();
        let mut seen: BTreeMap<(usize, usize), usize> = BTreeMap::new();
        for face in &faces {
            for k in 0..face.corners.len() {
                let (a, c) = (face.corners[k], face.corners[(k + 1) % face.corners.len()]);
                *seen.entry((a.min(c), a.max(c))).or_default() += 1;
            }
        }
        let up = |k: usize| points[k].extend(self.height_m(points[k]));
        seen.into_iter().filter(|(_, n)| *n == 2).map(|((a, c), _)| [up(a), up(c)]).collect()
    }
}

/// The part of a convex polygon where a linear function is not negative.
fn clip(polygon: &[DVec2], over: impl Fn(DVec2) -> f64) -> Vec<DVec2> {
    let mut out = Vec::with_capacity(polygon.len() + 1);
    for i in 0..polygon.len() {
        let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
        let (ha, hb) = (over(a), over(b));
        if ha >= 0.0 {
            out.push(a);
        }
        if (ha > 0.0 && hb < 0.0) || (ha < 0.0 && hb > 0.0) {
            out.push(a.lerp(b, ha / (ha - hb)));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::mesh_builder::open_edges;
    use satseed_scene::SeedPath;

    const SLOTS: RoofSlots = RoofSlots { roof: 0, edge: 1, gable: 2 };

    #[test]
    fn a_hipped_roof_has_its_ridge_along_the_long_axis() {
        let outline = [(0.0, 0.0), (12.0, 0.0), (12.0, 6.0), (0.0, 6.0)].map(|(x, y)| DVec2::new(x, y)).to_vec();
        let roof = Roof { outline, slopes: vec![Some(0.4); 4], eaves_m: 10.0 };
        assert!((roof.height_m(DVec2::new(6.0, 3.0)) - 11.2).abs() < 1e-9);
        let top = roof.ridges().into_iter().find(|r| r[0].z > 11.1 && r[1].z > 11.1).unwrap();
        assert!((top[0] - top[1]).length() > 5.9 && (top[0].y - 3.0).abs() < 0.01);
    }

    #[test]
    fn roofs_of_any_outline_close() {
        let mut open = 0;
        for k in 0..400 {
            let mut rng = SeedPath::root("roof", k).rng();
            let corners = 3 + rng.below(4) as usize;
            let (long, wide) = (rng.range(3.0, 11.0), rng.range(2.5, 7.0));
            let mut turn = rng.unit();
            let outline: Vec<DVec2> = (0..corners)
                .map(|_| {
                    turn += rng.range(0.7, 1.25) * 0.93 / corners as f64 * core::f64::consts::TAU;
                    let (s, c) = libm::sincos(turn);
                    DVec2::new(c * long, s * wide)
                })
                .collect();
            if crate::kit::polygon::area(&outline) < 10.0 {
                continue;
            }
            let mut slopes: Vec<Option<f64>> = vec![Some(0.38); corners];
            for s in slopes.iter_mut().skip(2) {
                if rng.chance(0.3) {
                    *s = None;
                }
            }
            let roof = Roof { outline, slopes, eaves_m: 9.0 };
            let mut b = MeshBuilder::default();
            if roof.mesh(&mut b, SLOTS) {
                let m = b.finish();
                assert_eq!((m.validate(), open_edges(&m)), (Ok(()), 0), "{k}: {roof:?}");
            } else {
                open += 1;
            }
        }
        assert!(open <= 4, "{open} of 400 do not close");
    }
}
