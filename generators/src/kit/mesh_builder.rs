//! Building meshes out of closed solids.
//!
//! Every face has vertices of its own (texture coordinates break at edges), but neighbours share positions bit by bit, so
//! a solid is closed: each directed edge has its opposite. Solids may run into each other; none shares a plane with
//! another where it could be seen.

use super::polygon;
use glam::{DVec2, DVec3};
use satseed_scene::{Mesh, quantise_point};

/// A mesh in the making, in an object's frame.
#[derive(Clone, Debug, Default)]
pub struct MeshBuilder {
    mesh: Mesh,
}

/// Size of a bay in texture coordinates, m: walls are laid out in whole bays and floors of this nominal size, whatever
/// the true sizes are, so that one window pattern fits every wall.
pub const NOMINAL_BAY_M: f64 = 3.0;

/// Height of a floor in texture coordinates, m.
pub const NOMINAL_FLOOR_M: f64 = 3.0;

/// How the sides of a prism are laid out in texture coordinates: u counts bays of [`NOMINAL_BAY_M`], v floors of
/// [`NOMINAL_FLOOR_M`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// True width of a bay, m, about; 0 for plain metres.
    pub bay_m: f64,
    /// True height of a floor, m.
    pub floor_m: f64,
    /// Height where v is 0, m.
    pub datum_m: f64,
}

impl Wall {
    /// Texture coordinates in plain metres.
    pub const PLAIN: Self = Self { bay_m: 0.0, floor_m: NOMINAL_FLOOR_M, datum_m: 0.0 };

    /// Number of bays of a side, at least one.
    pub fn bays(&self, side_m: f64) -> f64 {
        if self.bay_m > 0.0 { libm::round(side_m / self.bay_m).max(1.0) } else { 1.0 }
    }

    fn width(&self, side_m: f64) -> f64 {
        if self.bay_m > 0.0 { self.bays(side_m) * NOMINAL_BAY_M } else { side_m }
    }

    fn v(&self, z_m: f64) -> f64 {
        (z_m - self.datum_m) / self.floor_m * NOMINAL_FLOOR_M
    }
}

impl MeshBuilder {
    /// The finished mesh.
    pub fn finish(self) -> Mesh {
        self.mesh
    }

    /// Triangles so far.
    pub fn triangles(&self) -> usize {
        self.mesh.triangles.len()
    }

    /// A flat polygon of at most a few corners, counter-clockwise seen from outside, as a fan.
    pub fn fan(&mut self, slot: u16, corners: &[(DVec3, DVec2)]) {
        let first = self.mesh.positions_m.len() as u32;
        for (p, uv) in corners {
            self.mesh.positions_m.push(quantise_point(*p));
            self.mesh.uvs_m.push([uv.x as f32, uv.y as f32]);
        }
        for i in 1..corners.len() as u32 - 1 {
            self.triangle([first, first + i, first + i + 1], slot);
        }
    }

    /// A triangle over vertices that stand already; dropped when quantising took its area.
    fn triangle(&mut self, t: [u32; 3], slot: u16) {
        let [a, b, c] = t.map(|v| {
            let p = self.mesh.positions_m[v as usize];
            DVec3::new(p[0].into(), p[1].into(), p[2].into())
        });
        if (b - a).cross(c - a) != DVec3::ZERO {
            self.mesh.triangles.push(t);
            self.mesh.slots.push(slot);
        }
    }

    /// A horizontal polygon at a height; texture coordinates are the plan's.
    pub fn cap(&mut self, slot: u16, outline: &[DVec2], z_m: f64, upward: bool) {
        let first = self.mesh.positions_m.len() as u32;
        for p in outline {
            self.mesh.positions_m.push(quantise_point(p.extend(z_m)));
            self.mesh.uvs_m.push([p.x as f32, p.y as f32]);
        }
        for t in polygon::triangulate(outline) {
            let [a, b, c] = t.map(|i| first + i as u32);
            self.triangle(if upward { [a, b, c] } else { [a, c, b] }, slot);
        }
    }

    /// The vertical band along an outline between two heights, looking outward (`inward`: looking to the inside).
    pub fn band(&mut self, slot: u16, outline: &[DVec2], low_m: f64, high_m: f64, wall: Wall, inward: bool) {
        debug_assert!(polygon::area(outline) > 0.0 && low_m < high_m, "a solid turned inside out");
        let mut u = 0.0;
        for i in 0..outline.len() {
            let (a, b) = (outline[i], outline[(i + 1) % outline.len()]);
            let w = wall.width(a.distance(b));
            let (v0, v1) = (wall.v(low_m), wall.v(high_m));
            let quad = [
                (a.extend(low_m), DVec2::new(u, v0)),
                (b.extend(low_m), DVec2::new(u + w, v0)),
                (b.extend(high_m), DVec2::new(u + w, v1)),
                (a.extend(high_m), DVec2::new(u, v1)),
            ];
            if inward {
                self.fan(slot, &[quad[0], quad[3], quad[2], quad[1]]);
            } else {
                self.fan(slot, &quad);
            }
            u += w;
        }
    }

    /// The horizontal ring between an outline and another with as many corners inside it.
    pub fn ring(&mut self, slot: u16, outer: &[DVec2], inner: &[DVec2], z_m: f64) {
        for i in 0..outer.len() {
            let j = (i + 1) % outer.len();
            let corner = |p: DVec2| (p.extend(z_m), p);
            self.fan(slot, &[corner(outer[i]), corner(outer[j]), corner(inner[j]), corner(inner[i])]);
        }
    }

    /// A closed prism: sides in one slot, top and underside in another.
    pub fn prism(&mut self, side: u16, cap: u16, outline: &[DVec2], low_m: f64, high_m: f64, wall: Wall) {
        self.band(side, outline, low_m, high_m, wall, false);
        self.cap(cap, outline, high_m, true);
        self.cap(cap, outline, low_m, false);
    }

    /// A closed block with a flat roof behind a parapet. Along the parapet's foot runs a strip of its own slot
    /// (flashing, dirt).
    pub fn parapet_block(
        &mut self,
        slots: BlockSlots,
        outline: &[DVec2],
        low_m: f64,
        roof_m: f64,
        shape: Parapet,
        wall: Wall,
    ) {
        let top = roof_m + shape.height_m;
        let inner = polygon::mitred(outline, shape.width_m);
        self.band(slots.side, outline, low_m, top, wall, false);
        self.cap(slots.side, outline, low_m, false);
        self.ring(slots.coping, outline, &inner, top);
        self.band(slots.coping, &inner, roof_m, top, Wall::PLAIN, true);
        if shape.strip_m > 0.0 {
            let strip = polygon::mitred(&inner, shape.strip_m);
            self.ring(slots.strip, &inner, &strip, roof_m);
            self.cap(slots.roof, &strip, roof_m, true);
        } else {
            self.cap(slots.roof, &inner, roof_m, true);
        }
    }

    /// A closed box by its centre (plan), axis, half sizes and heights.
    #[allow(clippy::too_many_arguments)]
    pub fn block(&mut self, side: u16, top: u16, centre: DVec2, axis: DVec2, half: DVec2, low_m: f64, high_m: f64) {
        self.prism(side, top, &polygon::oriented_rectangle(centre, axis, half), low_m, high_m, Wall::PLAIN);
    }

    /// A closed frustum between two outlines with as many corners each, at two heights.
    pub fn frustum(&mut self, side: u16, cap: u16, lower: &[DVec2], upper: &[DVec2], low_m: f64, high_m: f64) {
        debug_assert!(polygon::area(lower) > 0.0 && low_m < high_m, "a solid turned inside out");
        let mut u = 0.0;
        for i in 0..lower.len() {
            let j = (i + 1) % lower.len();
            debug_assert!(
                (lower[j] - lower[i]).dot(upper[j] - upper[i]) >= 0.0,
                "an edge that turns around on its way up"
            );
            let w = lower[i].distance(lower[j]);
            let h = high_m - low_m;
            self.fan(
                side,
                &[
                    (lower[i].extend(low_m), DVec2::new(u, 0.0)),
                    (lower[j].extend(low_m), DVec2::new(u + w, 0.0)),
                    (upper[j].extend(high_m), DVec2::new(u + w, h)),
                    (upper[i].extend(high_m), DVec2::new(u, h)),
                ],
            );
            u += w;
        }
        self.cap(cap, upper, high_m, true);
        self.cap(cap, lower, low_m, false);
    }

    /// A closed tube of `sides` corners along a straight line, its radius changing from one end to the other.
    pub fn limb(&mut self, slot: u16, from: DVec3, to: DVec3, radii_m: [f64; 2], sides: usize) {
        let axis = (to - from).normalize();
        let (t, b) = axis.any_orthonormal_pair();
        let circle = |centre: DVec3, r: f64| -> Vec<DVec3> {
            (0..sides)
                .map(|k| {
                    let (s, c) = libm::sincos(core::f64::consts::TAU * k as f64 / sides as f64);
                    centre + (t * c + b * s) * r
                })
                .collect()
        };
        let (low, high) = (circle(from, radii_m[0]), circle(to, radii_m[1]));
        let uv = |p: DVec3| (p, DVec2::new(p.x, p.z));
        for k in 0..sides {
            let n = (k + 1) % sides;
            self.fan(slot, &[uv(low[k]), uv(low[n]), uv(high[n]), uv(high[k])]);
        }
        self.fan(slot, &high.iter().map(|p| uv(*p)).collect::<Vec<_>>());
        self.fan(slot, &low.iter().rev().map(|p| uv(*p)).collect::<Vec<_>>());
    }
}

/// Slots of the parts of a [`MeshBuilder::parapet_block`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlockSlots {
    /// Outer walls.
    pub side: u16,
    /// Top and inside of the parapet.
    pub coping: u16,
    /// Strip along the parapet's foot.
    pub strip: u16,
    /// Roof.
    pub roof: u16,
}

/// The edge of a flat roof.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parapet {
    /// Height above the roof, m.
    pub height_m: f64,
    /// Width, m.
    pub width_m: f64,
    /// Width of the strip at its foot, m; 0 for none.
    pub strip_m: f64,
}

/// Directed edges without their opposite: empty for closed solids. For tests.
#[cfg(test)]
pub(crate) fn open_edges(mesh: &Mesh) -> usize {
    use std::collections::BTreeMap;
    let mut balance: BTreeMap<([u32; 3], [u32; 3]), i64> = BTreeMap::new();
    let bits = |v: u32| mesh.positions_m[v as usize].map(|x| (x + 0.0).to_bits());
    for t in &mesh.triangles {
        for k in 0..3 {
            let (a, b) = (bits(t[k]), bits(t[(k + 1) % 3]));
            *balance.entry((a, b)).or_default() += 1;
            *balance.entry((b, a)).or_default() -= 1;
        }
    }
    balance.values().filter(|n| **n > 0).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn u_shape() -> Vec<DVec2> {
        [(0.0, 0.0), (30.0, 0.0), (30.0, 20.0), (20.0, 20.0), (20.0, 8.0), (9.0, 8.0), (9.0, 17.0), (0.0, 17.0)]
            .map(|(x, y)| DVec2::new(x, y))
            .to_vec()
    }

    /// Volume by the divergence theorem: right only when closed and wound outward.
    fn volume(m: &Mesh) -> f64 {
        (0..m.triangles.len())
            .map(|t| {
                let [a, b, c] = m.corners(t);
                a.dot(b.cross(c)) / 6.0
            })
            .sum()
    }

    #[test]
    fn solids_are_closed_and_wound_outward() {
        let u = u_shape();
        let mut b = MeshBuilder::default();
        b.prism(0, 1, &u, -1.0, 9.0, Wall::PLAIN);
        let m = b.finish();
        assert_eq!((m.validate(), open_edges(&m)), (Ok(()), 0));
        assert!((volume(&m) - polygon::area(&u) * 10.0).abs() < 1e-6);

        let mut b = MeshBuilder::default();
        let slots = BlockSlots { side: 0, coping: 1, strip: 2, roof: 3 };
        b.parapet_block(slots, &u, 0.0, 10.0, Parapet { height_m: 1.0, width_m: 0.25, strip_m: 0.5 }, Wall::PLAIN);
        let m = b.finish();
        assert_eq!((m.validate(), open_edges(&m)), (Ok(()), 0));
        let rim = polygon::area(&u) - polygon::area(&polygon::mitred(&u, 0.25));
        assert!((volume(&m) - polygon::area(&u) * 10.0 - rim).abs() < 1e-6);

        let mut b = MeshBuilder::default();
        b.limb(0, DVec3::new(0.3, 0.2, -0.5), DVec3::new(1.0, 2.0, 4.0), [0.3, 0.1], 6);
        let m = b.finish();
        assert_eq!((m.validate(), open_edges(&m)), (Ok(()), 0));
        assert!(volume(&m) > 0.0);
    }
}
