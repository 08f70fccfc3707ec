//! Which nodes surround a point.

use glam::DVec3;

/// How close a lattice is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Scale {
    /// For surfaces: lines 1 m apart, slabs of 2 m.
    Surface,
    /// For leaves, whose own directions scatter more than their light does: lines 2 m apart, slabs of 4 m.
    Foliage,
}

impl Scale {
    /// Distance between lattice lines, m.
    pub(super) fn spacing_m(self) -> f64 {
        match self {
            Self::Surface => 1.0,
            Self::Foliage => 2.0,
        }
    }

    /// Thickness of a slab along the lines, m.
    pub(super) fn slab_m(self) -> f64 {
        2.0 * self.spacing_m()
    }
}

/// Lattice lines along a block's side; a power of two.
pub(super) const SIDE: i32 = 4;

/// One of the six directions along the world's axes: x, y, z, each positive and negative.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Face(u8);

impl Face {
    /// The one that a normal leans to most.
    pub(super) fn towards(normal: DVec3) -> Self {
        let a = normal.abs();
        let axis = if a.z >= a.x && a.z >= a.y { 2 } else { u8::from(a.y > a.x) };
        Self(2 * axis + u8::from(normal[axis as usize] < 0.0))
    }

    fn axis(self) -> usize {
        usize::from(self.0 / 2)
    }

    fn is_negative(self) -> bool {
        self.0 % 2 == 1
    }

    /// Unit vector.
    pub(super) fn direction(self) -> DVec3 {
        let mut d = DVec3::ZERO;
        d[self.axis()] = if self.is_negative() { -1.0 } else { 1.0 };
        d
    }

    /// The other two axes.
    fn across(self) -> [usize; 2] {
        [(self.axis() + 1) % 3, (self.axis() + 2) % 3]
    }

    /// The four nodes about a point, with the weights of bilinear interpolation.
    pub(super) fn corners(self, scale: Scale, point_m: DVec3) -> [Corner; 4] {
        let [u, v] = self.across().map(|axis| point_m[axis] / scale.spacing_m());
        let (low_u, low_v) = (libm::floor(u), libm::floor(v));
        let (fu, fv) = (u - low_u, v - low_v);
        let slab = libm::floor(point_m[self.axis()] / scale.slab_m()) as i32;
        let corner = |i: i32, j: i32| {
            let (i, j) = (low_u as i32 + i, low_v as i32 + j);
            Corner {
                block: BlockKey { scale, face: self, slab, u: i.div_euclid(SIDE), v: j.div_euclid(SIDE) },
                node: (i.rem_euclid(SIDE) + j.rem_euclid(SIDE) * SIDE) as usize,
                weight: 0.0,
            }
        };
        [
            Corner { weight: (1.0 - fu) * (1.0 - fv), ..corner(0, 0) },
            Corner { weight: fu * (1.0 - fv), ..corner(1, 0) },
            Corner { weight: (1.0 - fu) * fv, ..corner(0, 1) },
            Corner { weight: fu * fv, ..corner(1, 1) },
        ]
    }
}

/// A place in the lattice: 4 x 4 lines through one slab.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct BlockKey {
    /// Which lattice.
    pub scale: Scale,
    /// The way that its surfaces face.
    pub face: Face,
    slab: i32,
    u: i32,
    v: i32,
}

impl BlockKey {
    /// Where the line of a node enters the slab on the side that its surfaces face, m.
    pub(super) fn entry_m(self, node: usize) -> DVec3 {
        let [u, v] = self.face.across();
        let mut p = DVec3::ZERO;
        p[u] = f64::from(self.u * SIDE + node as i32 % SIDE) * self.scale.spacing_m();
        p[v] = f64::from(self.v * SIDE + node as i32 / SIDE) * self.scale.spacing_m();
        p[self.face.axis()] = f64::from(self.slab + i32::from(!self.face.is_negative())) * self.scale.slab_m();
        p
    }

    /// A number that spreads keys evenly.
    pub(super) fn spread(self) -> usize {
        let mixed = satseed_scene::hash_cell(self.u, self.v, self.slab, u32::from(self.face.0));
        mixed as usize
    }
}

/// One of the nodes about a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    /// Its block.
    pub block: BlockKey,
    /// Its number in the block.
    pub node: usize,
    /// Its share.
    pub weight: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_lies_between_its_corners_and_inside_their_slab() {
        for (normal, point) in [
            (DVec3::new(0.1, 0.2, 0.9), DVec3::new(-3.25, 7.5, -0.5)),
            (DVec3::new(-0.9, 0.2, 0.1), DVec3::new(4.0, -7.75, 3.0)),
            (DVec3::new(0.3, -0.8, -0.1), DVec3::new(-0.1, 0.0, 12.3)),
        ] {
            let face = Face::towards(normal);
            assert!(face.direction().dot(normal) > 0.5);
            let corners = face.corners(Scale::Surface, point);
            let middle = corners.iter().fold(DVec3::ZERO, |sum, c| sum + c.block.entry_m(c.node) * c.weight);
            let away = middle - point;
            let along = away.dot(face.direction());
            assert!((0.0..=Scale::Surface.slab_m()).contains(&along), "{along}");
            assert!((away - face.direction() * along).length() < 1e-12);
            assert!((corners.iter().map(|c| c.weight).sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }
}
