//! Triangle meshes.

use glam::DVec3;

/// Triangles in an object's frame. Positions are multiples of 1/1024 m ([`crate::quantise_m`]).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertices, m.
    pub positions_m: Vec<[f32; 3]>,
    /// Counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Material slot of each triangle; the instance says which material stands in a slot.
    pub slots: Vec<u16>,
    /// Shading normals of the vertices, unit length, or empty: then the triangle's own normal shades it.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates of the vertices, m along the surface, or empty.
    pub uvs_m: Vec<[f32; 2]>,
}

/// What is wrong with a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MeshError {
    /// A list has another length than the list it belongs to.
    Length {
        /// Which list.
        list: &'static str,
        /// Its length.
        found: usize,
        /// What it should be.
        expected: usize,
    },
    /// A triangle names a vertex that does not exist.
    Index {
        /// The triangle.
        triangle: usize,
    },
    /// A triangle without area.
    Degenerate {
        /// The triangle.
        triangle: usize,
    },
    /// A vertex that is not a multiple of 1/1024 m, or not finite.
    OffLattice {
        /// The vertex.
        vertex: usize,
    },
}

impl core::fmt::Display for MeshError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Length { list, found, expected } => {
                write!(f, "list `{list}` has {found} entries where {expected} are needed")
            }
            Self::Index { triangle } => write!(f, "triangle {triangle} names a vertex that does not exist"),
            Self::Degenerate { triangle } => write!(f, "triangle {triangle} has no area"),
            Self::OffLattice { vertex } => write!(f, "vertex {vertex} is not on the lattice of 1/1024 m"),
        }
    }
}

impl core::error::Error for MeshError {}

impl Mesh {
    /// The three corners of a triangle, m.
    #[inline]
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|v| {
            let p = self.positions_m[v as usize];
            DVec3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]))
        })
    }

    /// Adds another mesh, whose lists must be those that this one has.
    pub fn append(&mut self, other: Self) {
        let first = self.positions_m.len() as u32;
        self.triangles.extend(other.triangles.into_iter().map(|t| t.map(|v| first + v)));
        self.positions_m.extend(other.positions_m);
        self.slots.extend(other.slots);
        self.normals.extend(other.normals);
        self.uvs_m.extend(other.uvs_m);
    }

    /// Checks lengths, indices, the lattice, and that every triangle has area.
    pub fn validate(&self) -> Result<(), MeshError> {
        let length = |list, found, expected| {
            if found == expected { Ok(()) } else { Err(MeshError::Length { list, found, expected }) }
        };
        length("slots", self.slots.len(), self.triangles.len())?;
        if !self.normals.is_empty() {
            length("normals", self.normals.len(), self.positions_m.len())?;
        }
        if !self.uvs_m.is_empty() {
            length("uvs_m", self.uvs_m.len(), self.positions_m.len())?;
        }
        for (vertex, p) in self.positions_m.iter().enumerate() {
            let on_lattice = |x: f32| x.is_finite() && x * 1024.0 == (x * 1024.0).round() && x.abs() <= 16_384.0;
            if !p.iter().all(|x| on_lattice(*x)) {
                return Err(MeshError::OffLattice { vertex });
            }
        }
        for (triangle, corners) in self.triangles.iter().enumerate() {
            if corners.iter().any(|v| *v as usize >= self.positions_m.len()) {
                return Err(MeshError::Index { triangle });
            }
            let [a, b, c] = self.corners(triangle);
            if (b - a).cross(c - a) == DVec3::ZERO {
                return Err(MeshError::Degenerate { triangle });
            }
        }
        Ok(())
    }

    /// Smallest and largest coordinates, m; `None` for an empty mesh.
    pub fn bounds_m(&self) -> Option<(DVec3, DVec3)> {
        let mut vertices = self.positions_m.iter().map(|p| DVec3::new(p[0].into(), p[1].into(), p[2].into()));
        let first = vertices.next()?;
        Some(vertices.fold((first, first), |(low, high), p| (low.min(p), high.max(p))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> Mesh {
        Mesh {
            positions_m: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            slots: vec![0],
            ..Mesh::default()
        }
    }

    #[test]
    fn faults_are_named() {
        assert_eq!(triangle().validate(), Ok(()));
        let mut m = triangle();
        m.positions_m[2] = [2.0, 0.0, 0.0];
        assert_eq!(m.validate(), Err(MeshError::Degenerate { triangle: 0 }));
        m = triangle();
        m.positions_m[1][0] = 0.3;
        assert_eq!(m.validate(), Err(MeshError::OffLattice { vertex: 1 }));
        m = triangle();
        m.triangles[0][1] = 9;
        assert_eq!(m.validate(), Err(MeshError::Index { triangle: 0 }));
        m = triangle();
        m.slots.clear();
        assert!(matches!(m.validate(), Err(MeshError::Length { list: "slots", .. })));
    }
}
