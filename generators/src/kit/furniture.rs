//! Street furniture: thin things that labels must still find.

use super::mesh_builder::MeshBuilder;
use glam::{DVec2, DVec3};
use satseed_scene::Mesh;

/// A street light: x points over the road, z = 0 is the sidewalk. One slot.
pub fn street_light(height_m: f64) -> Mesh {
    let mut b = MeshBuilder::default();
    b.limb(0, DVec3::new(0.0, 0.0, -0.6), DVec3::new(0.0, 0.0, height_m), [0.11, 0.07], 6);
    b.limb(0, DVec3::new(-0.05, 0.0, height_m - 0.15), DVec3::new(2.0, 0.0, height_m + 0.25), [0.06, 0.045], 5);
    b.block(0, 0, DVec2::new(2.2, 0.0), DVec2::X, DVec2::new(0.35, 0.16), height_m + 0.15, height_m + 0.32);
    b.finish()
}

/// A tower crane with its jib along x: mast of `mast_m`, jib of `jib_m`. One slot.
pub fn tower_crane(mast_m: f64, jib_m: f64) -> Mesh {
    let mut b = MeshBuilder::default();
    let half = 0.9;
    for (x, y) in [(-half, -half), (half, -half), (half, half), (-half, half)] {
        b.limb(0, DVec3::new(x, y, -1.0), DVec3::new(x, y, mast_m), [0.14, 0.14], 4);
    }
    let mut z = 0.0;
    let mut turn = 0;
    while z + 2.4 < mast_m {
        let (sx, sy) = if turn % 2 == 0 { (1.0, 1.0) } else { (-1.0, 1.0) };
        for k in [-half, half] {
            b.limb(0, DVec3::new(-half * sx, k, z), DVec3::new(half * sx, k, z + 2.4), [0.08, 0.08], 4);
            b.limb(0, DVec3::new(k, -half * sy, z), DVec3::new(k, half * sy, z + 2.4), [0.08, 0.08], 4);
        }
        z += 2.4;
        turn += 1;
    }
    let counter = jib_m * 0.3;
    for y in [-0.8, 0.8] {
        b.limb(0, DVec3::new(-counter, y, mast_m + 0.3), DVec3::new(jib_m, y, mast_m + 0.3), [0.14, 0.1], 4);
        b.limb(0, DVec3::new(-counter, y, mast_m + 0.2), DVec3::new(0.0, 0.0, mast_m + 7.5), [0.06, 0.06], 4);
    }
    b.limb(0, DVec3::new(0.0, 0.0, mast_m + 1.9), DVec3::new(jib_m, 0.0, mast_m + 1.5), [0.12, 0.09], 4);
    b.limb(0, DVec3::new(0.0, 0.0, mast_m), DVec3::new(0.0, 0.0, mast_m + 7.6), [0.3, 0.2], 4);
    b.limb(0, DVec3::new(0.0, 0.0, mast_m + 7.4), DVec3::new(jib_m * 0.7, 0.0, mast_m + 1.7), [0.06, 0.06], 4);
    let mut x = 1.5;
    while x + 2.0 < jib_m {
        for y in [-0.8, 0.8] {
            b.limb(0, DVec3::new(x, y, mast_m + 0.3), DVec3::new(x + 1.0, 0.0, mast_m + 1.75), [0.06, 0.06], 4);
            b.limb(0, DVec3::new(x + 1.0, 0.0, mast_m + 1.75), DVec3::new(x + 2.0, y, mast_m + 0.3), [0.06, 0.06], 4);
        }
        x += 2.0;
    }
    b.block(0, 0, DVec2::new(-counter + 1.6, 0.0), DVec2::X, DVec2::new(1.5, 1.1), mast_m - 1.4, mast_m + 0.6);
    b.block(0, 0, DVec2::new(1.3, -1.3), DVec2::X, DVec2::new(0.9, 0.7), mast_m - 1.9, mast_m + 0.1);
    b.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::mesh_builder::open_edges;

    #[test]
    fn furniture_is_closed_and_rooted() {
        for m in [street_light(9.0), tower_crane(60.0, 45.0)] {
            assert_eq!((m.validate(), open_edges(&m)), (Ok(()), 0));
            assert!(m.bounds_m().unwrap().0.z <= -0.5);
        }
    }
}
