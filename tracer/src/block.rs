//! Triangles as a leaf holds them.
#![allow(clippy::needless_range_loop)] // Axes are numbers here, across several arrays at once.

use crate::simd::Wide;
use satseed_scene::QUANTUM_M;

/// Rows of an affine transform: three columns and the translation.
pub(crate) type Rows = [[f32; 4]; 3];

/// Eight triangles of a leaf, a lane each, in the mesh's frame. Vertices stand on a lattice ([`QUANTUM_M`]), and those of a
/// leaf close together: so 16 bits hold a coordinate exactly. Three cache lines.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Block {
    /// Corner, axis, lane; quanta from `base_m`. Lanes that hold no triangle repeat the last one.
    quanta: [[[u16; 8]; 3]; 3],
    /// Lowest coordinates, m.
    base_m: [f32; 3],
    /// Where the corners stand in [`Leaf::wide`] if they do not fit into 16 bits, else [`FITS`].
    wide: u32,
    /// Index of each lane's triangle in its mesh.
    pub(crate) index: [u32; 8],
}

/// See [`Block::wide`].
const FITS: u32 = u32::MAX;

/// Corner, axis, lane; m.
pub(crate) type Corners = [[[f32; 8]; 3]; 3];

/// A block with the corners that may stand elsewhere.
#[derive(Clone, Copy)]
pub(crate) struct Leaf<'t> {
    pub(crate) block: &'t Block,
    pub(crate) wide: &'t [Corners],
}

impl Leaf<'_> {
    /// Coordinates of all corners (first index) along some axes (second), m; of another frame where there are rows to it.
    #[inline(always)]
    pub(crate) fn along<X: Wide<8>>(&self, axes: [usize; 3], rows: Option<&Rows>) -> [[X; 3]; 3] {
        let mut out = [[X::splat(0.0); 3]; 3];
        for (corner, out) in out.iter_mut().enumerate() {
            let Some(rows) = rows else {
                for k in 0..3 {
                    out[k] = self.coordinates(corner, axes[k]);
                }
                continue;
            };
            let own: [X; 3] = [self.coordinates(corner, 0), self.coordinates(corner, 1), self.coordinates(corner, 2)];
            for k in 0..3 {
                let [a, b, c, d] = rows[axes[k]];
                let turned = own[0].mul(X::splat(a)).add(own[1].mul(X::splat(b))).add(own[2].mul(X::splat(c)));
                out[k] = turned.add(X::splat(d));
            }
        }
        out
    }

    /// One coordinate (m) of one corner of all triangles.
    #[inline(always)]
    pub(crate) fn coordinates<X: Wide<8>>(&self, corner: usize, axis: usize) -> X {
        let block = self.block;
        if block.wide == FITS {
            // Every step is exact: the sum is the vertex's own coordinate.
            let quanta = X::load_u16(&block.quanta[corner][axis]);
            quanta.mul(X::splat(QUANTUM_M as f32)).add(X::splat(block.base_m[axis]))
        } else {
            X::load(&self.wide[block.wide as usize][corner][axis])
        }
    }

    /// The corners of one lane's triangle, m.
    #[inline(always)]
    pub(crate) fn triangle(&self, lane: usize) -> [[f32; 3]; 3] {
        let block = self.block;
        let mut corners = [[0.0; 3]; 3];
        if block.wide == FITS {
            for (corner, quanta) in corners.iter_mut().zip(&block.quanta) {
                for axis in 0..3 {
                    corner[axis] = f32::from(quanta[axis][lane]) * QUANTUM_M as f32 + block.base_m[axis];
                }
            }
        } else {
            for (corner, wide) in corners.iter_mut().zip(&self.wide[block.wide as usize]) {
                for axis in 0..3 {
                    corner[axis] = wide[axis][lane];
                }
            }
        }
        corners
    }
}

impl Block {
    /// A block of up to eight triangles.
    pub(crate) fn new(triangles: &[[[f32; 3]; 3]], indices: &[u32], wide: &mut Vec<Corners>) -> Self {
        let of = |lane: usize| lane.min(triangles.len() - 1);
        let corners: Corners = core::array::from_fn(|corner| {
            core::array::from_fn(|axis| core::array::from_fn(|lane| triangles[of(lane)][corner][axis]))
        });
        let mut base_m = [f32::INFINITY; 3];
        for corner in triangles.as_flattened() {
            base_m = core::array::from_fn(|axis| base_m[axis].min(corner[axis]));
        }
        let mut fits = true;
        let quanta = core::array::from_fn(|corner| {
            core::array::from_fn(|axis: usize| {
                corners[corner][axis].map(|x: f32| {
                    let quanta = (f64::from(x) - f64::from(base_m[axis])) / QUANTUM_M;
                    fits &= quanta == f64::from(quanta as u16)
                        && (f32::from(quanta as u16) * QUANTUM_M as f32 + base_m[axis]).to_bits() == x.to_bits();
                    quanta as u16
                })
            })
        });
        let place = if fits { FITS } else { wide.len() as u32 };
        if !fits {
            wide.push(corners);
        }
        Self { quanta, base_m, wide: place, index: core::array::from_fn(|lane| indices[of(lane)]) }
    }
}

/// Number of a lane of a block.
#[inline]
pub(crate) fn slot(block: u32, lane: usize) -> u32 {
    block * 8 + lane as u32
}
