//! Cars, vans, trucks and buses: closed bodies on wheels, with the gap below them that their shadow shows.
//!
//! x is forward, z = 0 the road.

use super::mesh_builder::{MeshBuilder, Wall};
use super::polygon;
use glam::{DVec2, DVec3};
use satseed_scene::Mesh;

/// Slot of paint.
pub const PAINT: u16 = 0;
/// Slot of windows.
pub const GLASS: u16 = 1;
/// Slot of tyres and underside.
pub const TYRE: u16 = 2;
/// Slot of cargo boxes.
pub const BOX: u16 = 3;
/// Slot of lamps.
pub const LAMP: u16 = 4;

/// Body types.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Body {
    /// Three-box car.
    Sedan,
    /// Two-box car.
    Hatchback,
    /// High two-box car.
    Suv,
    /// Open bed behind a cab.
    Pickup,
    /// One-box passenger van.
    Minivan,
    /// Panel van.
    Van,
    /// Box truck.
    Truck,
    /// City bus.
    Bus,
}

impl Body {
    /// All of them.
    pub const ALL: [Self; 8] =
        [Self::Sedan, Self::Hatchback, Self::Suv, Self::Pickup, Self::Minivan, Self::Van, Self::Truck, Self::Bus];

    /// Length, width and height, m.
    pub fn size_m(self) -> [f64; 3] {
        match self {
            Self::Sedan => [4.75, 1.84, 1.45],
            Self::Hatchback => [4.3, 1.8, 1.5],
            Self::Suv => [4.7, 1.9, 1.72],
            Self::Pickup => [5.6, 1.98, 1.85],
            Self::Minivan => [5.1, 1.97, 1.75],
            Self::Van => [5.9, 2.05, 2.55],
            Self::Truck => [8.6, 2.45, 3.4],
            Self::Bus => [12.3, 2.58, 3.15],
        }
    }

    /// Its mesh.
    pub fn mesh(self) -> Mesh {
        let [l, w, h] = self.size_m();
        let mut b = MeshBuilder::default();
        match self {
            // Cabin: rear foot, rear top, front top, front foot, as shares of the length from the rear; bonnet height.
            Self::Sedan => car(&mut b, [l, w, h], [0.12, 0.26, 0.56, 0.74], 0.93, 0.55),
            Self::Hatchback => car(&mut b, [l, w, h], [0.02, 0.1, 0.57, 0.77], 0.95, 0.55),
            Self::Suv => car(&mut b, [l, w, h], [0.02, 0.08, 0.6, 0.75], 1.08, 0.62),
            Self::Minivan => car(&mut b, [l, w, h], [0.01, 0.06, 0.64, 0.88], 1.02, 0.62),
            Self::Pickup => {
                car(&mut b, [l, w, h], [0.4, 0.44, 0.62, 0.74], 1.08, 0.62);
                // The bed's dark floor, framed by its rails.
                let (x0, x1) = (-l / 2.0 + 0.12, -l / 2.0 + 0.38 * l);
                let bed = polygon::rectangle(DVec2::new(x0, -w / 2.0 + 0.2), DVec2::new(x1, w / 2.0 - 0.2));
                b.prism(TYRE, TYRE, &bed, 0.9, 1.1, Wall::PLAIN);
            }
            Self::Van => {
                car(&mut b, [l, w, h], [0.005, 0.02, 0.72, 0.86], 1.2, 0.7);
                let side = polygon::rectangle(
                    DVec2::new(-l / 2.0 + 0.1, -w / 2.0 + 0.02),
                    DVec2::new(l * 0.18, w / 2.0 - 0.02),
                );
                b.prism(PAINT, PAINT, &side, 1.0, h - 0.08, Wall::PLAIN);
            }
            Self::Truck => {
                let cab = polygon::rectangle(DVec2::new(l / 2.0 - 2.0, -1.15), DVec2::new(l / 2.0, 1.15));
                b.frustum(PAINT, PAINT, &cab, &polygon::mitred(&cab, 0.05), 0.45, 1.5);
                let top = polygon::rectangle(DVec2::new(l / 2.0 - 1.95, -1.05), DVec2::new(l / 2.0 - 0.45, 1.05));
                b.frustum(GLASS, PAINT, &polygon::mitred(&cab, 0.07), &top, 1.4, 2.5);
                let hold = polygon::rectangle(DVec2::new(-l / 2.0, -w / 2.0), DVec2::new(l / 2.0 - 2.15, w / 2.0));
                b.prism(BOX, BOX, &hold, 0.95, h, Wall::PLAIN);
                let frame = polygon::rectangle(DVec2::new(-l / 2.0 + 0.2, -0.5), DVec2::new(l / 2.0 - 0.5, 0.5));
                b.prism(TYRE, TYRE, &frame, 0.5, 1.0, Wall::PLAIN);
                wheels(&mut b, w, 0.48, &[-l / 2.0 + 1.6, l / 2.0 - 1.2]);
            }
            Self::Bus => {
                let hull =
                    polygon::rounded(&polygon::rectangle(DVec2::new(-l, -w) / 2.0, DVec2::new(l, w) / 2.0), 0.35, 2);
                b.prism(PAINT, TYRE, &hull, 0.32, 1.2, Wall::PLAIN);
                b.prism(GLASS, GLASS, &polygon::mitred(&hull, 0.04), 1.1, 2.5, Wall::PLAIN);
                b.prism(PAINT, BOX, &hull, 2.4, 2.95, Wall::PLAIN);
                for (x, half) in [(-3.6, 1.3), (1.2, 1.0), (4.2, 0.7)] {
                    b.block(BOX, BOX, DVec2::new(x, 0.0), DVec2::X, DVec2::new(half, 0.75), 2.9, h);
                }
                wheels(&mut b, w, 0.5, &[-3.4, 3.6]);
            }
        }
        b.finish()
    }
}

/// A passenger car: sill, shoulder, bonnet and a glazed cabin under a painted roof.
fn car(b: &mut MeshBuilder, [l, w, h]: [f64; 3], cabin: [f64; 4], bonnet_m: f64, shoulder_m: f64) {
    let hull = polygon::rounded(&polygon::rectangle(DVec2::new(-l, -w) / 2.0, DVec2::new(l, w) / 2.0), 0.32, 1);
    b.frustum(PAINT, TYRE, &polygon::mitred(&hull, 0.06), &hull, 0.22, shoulder_m);
    b.frustum(PAINT, PAINT, &polygon::mitred(&hull, 0.01), &polygon::mitred(&hull, 0.13), shoulder_m - 0.05, bonnet_m);
    let x = |share: f64| -l / 2.0 + share * l;
    let (foot, top) = (w / 2.0 - 0.13, w / 2.0 - 0.3);
    let rect = |x0: f64, x1: f64, y: f64| polygon::rectangle(DVec2::new(x0, -y), DVec2::new(x1, y));
    let lower = rect(x(cabin[0]), x(cabin[3]), foot);
    let upper = rect(x(cabin[1]), x(cabin[2]), top);
    b.frustum(GLASS, GLASS, &lower, &upper, bonnet_m - 0.06, h - 0.04);
    // The roof panel stands a little over the glass on all sides.
    b.prism(PAINT, PAINT, &polygon::mitred(&upper, -0.03), h - 0.09, h, Wall::PLAIN);
    for y in [-1.0, 1.0] {
        let lamp = DVec2::new(l / 2.0 - 0.06, y * (w / 2.0 - 0.42));
        b.block(LAMP, LAMP, lamp, DVec2::X, DVec2::new(0.09, 0.2), shoulder_m, shoulder_m + 0.16);
    }
    wheels(b, w, 0.33, &[-l * 0.29, l * 0.31]);
}

fn wheels(b: &mut MeshBuilder, width_m: f64, radius_m: f64, axles_m: &[f64]) {
    for x in axles_m {
        for side in [-1.0, 1.0] {
            let y0 = side * (width_m / 2.0 - 0.24);
            let y1 = side * (width_m / 2.0 - 0.005);
            let z = radius_m - 0.015;
            b.limb(TYRE, DVec3::new(*x, y0, z), DVec3::new(*x, y1, z), [radius_m; 2], 8);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::mesh_builder::open_edges;

    #[test]
    fn vehicles_are_closed_of_their_size_and_stand_on_the_road() {
        for body in Body::ALL {
            let m = body.mesh();
            assert_eq!((m.validate(), open_edges(&m)), (Ok(()), 0), "{body:?}");
            let (low, high) = m.bounds_m().unwrap();
            let [l, w, h] = body.size_m();
            let size = high - low;
            assert!(
                (size.x - l).abs() < 0.1 && (size.y - w).abs() < 0.05 && (high.z - h).abs() < 0.02,
                "{body:?} {size}"
            );
            assert!(low.z < 0.0 && low.z > -0.05);
            assert!((100..420).contains(&m.triangles.len()), "{body:?} {}", m.triangles.len());
        }
    }
}
