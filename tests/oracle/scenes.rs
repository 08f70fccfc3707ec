//! Random small scenes that are hard on a tracer.

use crate::support::solids::{cuboid, dented, grid, mesh, sphere, without_flat_triangles};
use crate::support::stage::{RigCase, Stage};
use glam::{DAffine3, DMat3, DQuat, DVec3};
use satseed::camera::{Datum, StereoRig};
use satseed_scene::{Class, Rng, Scene, SeedPath, gradient_noise_2d};

/// A family of scenes: every seed and altitude is another member.
pub(crate) struct Family {
    pub(crate) name: &'static str,
    pub(crate) build: fn(&mut Rng, f64) -> (Scene, StereoRig),
    /// Most pixels that may differ beside an edge, as a share: 0 but where rays are aimed at edges.
    pub(crate) most_in_band: f64,
}

pub(crate) const ALTITUDES_M: [f64; 2] = [1000.0, 617_000.0];

pub(crate) const FAMILIES: [Family; 12] = [
    Family { name: "soup", build: soup, most_in_band: 1e-4 },
    Family { name: "slivers", build: slivers, most_in_band: 1e-3 },
    Family { name: "fans", build: fans, most_in_band: 1e-4 },
    Family { name: "height fields", build: heights, most_in_band: 1e-4 },
    Family { name: "rays through vertices", build: exact_grid, most_in_band: 0.6 },
    Family { name: "grazing", build: grazing, most_in_band: 1e-2 },
    Family { name: "same surface twice", build: twice, most_in_band: 1e-3 },
    Family { name: "same plane cut otherwise", build: coplanar, most_in_band: 1e-3 },
    Family { name: "turned and scaled instances", build: instances, most_in_band: 1e-4 },
    Family { name: "closed solids", build: solids, most_in_band: 1e-4 },
    Family { name: "flush boxes", build: flush, most_in_band: 1e-3 },
    Family { name: "thin gaps", build: gaps, most_in_band: 1e-3 },
];

pub(crate) fn member(family: &Family, seed: u64, altitude_m: f64) -> (Scene, StereoRig) {
    let mut rng = SeedPath::root(family.name, seed).rng();
    (family.build)(&mut rng, altitude_m)
}

/// A rig that looks at the origin, from somewhere.
fn rig(rng: &mut Rng, altitude_m: f64, gsd_m: f64) -> StereoRig {
    let feet_m = {
        let baseline = altitude_m * rng.range(0.05, 0.35);
        let first = -baseline * rng.range(-0.3, 1.3);
        [first, first + baseline]
    };
    let shift = |x: f64| x / gsd_m;
    let middle = shift(f64::midpoint(feet_m[0], feet_m[1]));
    RigCase {
        altitude_m,
        gsd_m,
        size_px: [40, 40],
        feet_m,
        azimuth_rad: rng.range(-3.1, 3.1),
        datum: Datum::Height(0.0),
        shift_px: [middle, shift(altitude_m * 0.1 * rng.signed() * rng.unit())],
    }
    .rig()
    .looking_at_origin()
}

trait AtOrigin {
    fn looking_at_origin(self) -> Self;
}

impl AtOrigin for StereoRig {
    /// Moves both cameras across the rows so that a shifted frame sees the origin.
    fn looking_at_origin(mut self) -> Self {
        let middle = (f64::from(self.left.height_px) - 1.0) / 2.0;
        let across = (middle - self.left.cy_px) * self.spec.gsd_m;
        let down = self.left.world_from_camera.y_axis;
        self.left.position_m -= down * across;
        self.right.position_m -= down * across;
        self
    }
}

fn point(rng: &mut Rng, half: f64) -> DVec3 {
    DVec3::new(rng.signed(), rng.signed(), rng.signed()) * half
}

fn turn(rng: &mut Rng) -> DMat3 {
    let q = DQuat::from_xyzw(rng.normal(), rng.normal(), rng.normal(), rng.normal());
    DMat3::from_quat(q.normalize())
}

/// A floor under everything, of triangles of many sizes.
fn floor(stage: &mut Stage, z: f64, rng: &mut Rng) {
    let at = DVec3::new(rng.signed(), rng.signed(), z);
    let corners = [(-80.0, -90.0), (100.0, -75.0), (85.0, 95.0), (-95.0, 70.0)].map(|(x, y)| DVec3::new(x, y, z));
    let [a, b, c, d] = corners;
    stage.add(
        mesh(&[a, b, c, d, at], vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]),
        DAffine3::IDENTITY,
        Class::Ground,
    );
}

fn soup(rng: &mut Rng, altitude_m: f64) -> (Scene, StereoRig) {
    let mut stage = Stage::new();
    if rng.chance(0.7) {
        floor(&mut stage, -8.0, rng);
    }
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    for k in 0..150_u32 {
        let centre = point(rng, 8.0);
        let size = 8.0 * rng.unit() * rng.unit();
        points.extend((0..3).map(|_| centre + point(rng, size.max(0.05))));
        triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    stage.add(without_flat_triangles(mesh(&points, triangles)), DAffine3::IDENTITY, Class::Rock);
    (stage.finish(), rig(rng, altitude_m, 0.3))
}

fn slivers(rng: &mut Rng, altitude_m: f64) -> (Scene, StereoRig) {
    let mut stage = Stage::new();
    floor(&mut stage, -8.0, rng);
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    for k in 0..150_u32 {
        let (a, b) = (point(rng, 9.0), point(rng, 9.0));
        let width = rng.pick(&[0.001, 0.003, 0.02, 0.1]) * 1.0;
        points.extend([a, b, a.lerp(b, rng.unit()) + point(rng, width)]);
        triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    stage.add(without_flat_triangles(mesh(&points, triangles)), DAffine3::IDENTITY, Class::Rock);
    (stage.finish(), rig(rng, altitude_m, 0.3))
}

fn fans(rng: &mut Rng, altitude_m: f64) -> (Scene, StereoRig) {
    let mut stage = Stage::new();
    floor(&mut stage, -6.0, rng);
    for _ in 0..6 {
        let centre = point(rng, 5.0);
        let n = 3 + rng.below(40) as u32;
        let mut points = vec![centre];
        for k in 0..n {
            let (s, c) = libm::sincos(f64::from(k) * core::f64::consts::TAU / f64::from(n));
            points.push(centre + DVec3::new(c, s, 0.4 * rng.signed()) * rng.range(0.5, 6.0));
        }
        let triangles = (0..n).map(|k| [0, 1 + k, 1 + (k + 1) % n]).collect();
        stage.add(without_flat_triangles(mesh(&points, triangles)), DAffine3::IDENTITY, Class::Rock);
    }
    (stage.finish(), rig(rng, altitude_m, 0.3))
}

fn heights(rng: &mut Rng, altitude_m: f64) -> (Scene, StereoRig) {
    let mut stage = Stage::new();
    let relief = rng.range(0.1, 6.0);
    let m = grid(-12.0, -12.0, 1.5, 16, &mut |_, _| relief * rng.signed());
    stage.add(m, DAffine3::IDENTITY, Class::Ground);
    (stage.finish(), rig(rng, altitude_m, 0.3))
}

/// Pixel rays that run exactly through vertices and edges, as far as f64 goes: a camera over a grid of its own pixels.
fn exact_grid(rng: &mut Rng, altitude_m: f64) -> (Scene, StereoRig) {
    let mut stage = Stage::new();
    let step = *rng.pick(&[0.25, 0.5, 0.75]);
    let relief = *rng.pick(&[0.0, 0.5, 4.0]);
    let at = |k: u64| (k as f64 - 8.0) * step;
    let rise = rng.below(16);
    let m = grid(at(0), at(0), step, 16, &mut |x, y| if x > at(rise) { relief * (y / step).abs() } else { 0.0 });
    stage.add(m, DAffine3::IDENTITY, Class::Ground);
    // 2^n m high, so that every ray on the grid is a short binary fraction.
    let altitude_m = if altitude_m < 2000.0 { 1024.0 } else { 524_288.0 };
    let feet_m = [-altitude_m / 8.0, altitude_m / 16.0];
    let rig = RigCase {
        altitude_m,
        gsd_m: 0.25,
        size_px: [33, 33],
        feet_m,
        azimuth_rad: 0.0,
        datum: Datum::Height(0.0),
        shift_px: [f64::midpoint(feet_m[0], feet_m[1]) / 0.25, 0.0],
    };
    (stage.finish(), rig.rig())
}

/// Walls almost in line with rays: through a camera's centre but for a millimetre.
fn grazing(rng: &mut Rng, altitude_m: f64) -> (Scene, StereoRig) {
    let rig = rig(rng, altitude_m, 0.3);
    let mut stage = Stage::new();
    floor(&mut stage, -6.0, rng);
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    for k in 0..40_u32 {
        let eye = if rng.chance(0.5) { rig.left.position_m } else { rig.right.position_m };
        let foot = point(rng, 6.0).with_z(-5.0);
        let up = (eye - foot).normalize();
        let side = point(rng, 1.0).cross(up).normalize();
        let off = up.cross(side) * *rng.pick(&[0.0, 1e-3, 1e-2, 0.1]) * rng.signed();
        let (a, b) = (foot - side * rng.range(0.2, 4.0), foot + side * rng.range(0.2, 4.0));
        points.extend([a, b, b + up * rng.range(1.0, 9.0) + off, a + up * rng.range(1.0, 9.0) + off]);
        triangles.extend([[4 * k, 4 * k + 1, 4 * k + 2], [4 * k, 4 * k + 2, 4 * k + 3]]);
    }
    stage.add(without_flat_triangles(mesh(&points, triangles)), DAffine3::IDENTITY, Class::Facade);
    (stage.finish(), rig)
}

/// The same solids in two and three instances, one of them through a turn there and back.
pub(crate) fn twice(rng: &mut Rng, altitude_m: f64) -> (Scene, StereoRig) {
    let mut stage = Stage::new();
    floor(&mut stage, -6.0, rng);
    for _ in 0..3 {
        let m = dented(point(rng, 4.0), rng.range(1.0, 4.0), 2, 0.3, rng);
        let m = stage.mesh(without_flat_triangles(m));
        stage.place(m, DAffine3::IDENTITY, Class::Rock);
        stage.place(m, DAffine3::IDENTITY, Class::Sand);
        let there = DAffine3::from_mat3(turn(rng));
        stage.place(m, there * there.inverse(), Class::Crop);
    }
    (stage.finish(), rig(rng, altitude_m, 0.3))
}

/// Planes on planes: a tilted square, cut along the other diagonal and into smaller squares.
fn coplanar(rng: &mut Rng, altitude_m: f64) -> (Scene, StereoRig) {
    let mut stage = Stage::new();
    floor(&mut stage, -6.0, rng);
    let slope = *rng.pick(&[0.0, 0.5, 1.0, -2.0]);
    let height = move |x: f64, y: f64| slope * x * 0.5 + y * 0.25;
    for (cell, cells) in [(16.0, 1_u32), (4.0, 4), (1.0, 16)] {
        let m = grid(-8.0, -8.0, cell, cells, &mut |x, y| height(x, y));
        stage.add(m, DAffine3::IDENTITY, Class::Roof);
    }
    let corners = [(-6.0, -7.0), (7.0, -5.0), (1.0, 7.0)].map(|(x, y)| DVec3::new(x, y, height(x, y)));
    stage.add(mesh(&corners, vec![[0, 1, 2]]), DAffine3::IDENTITY, Class::Road);
    (stage.finish(), rig(rng, altitude_m, 0.3))
}

fn instances(rng: &mut Rng, altitude_m: f64) -> (Scene, StereoRig) {
    let mut stage = Stage::new();
    floor(&mut stage, -6.0, rng);
    let meshes = [
        stage.mesh(cuboid(DVec3::splat(-1.0), DVec3::new(1.0, 2.0, 3.0))),
        stage.mesh(sphere(DVec3::new(0.5, 0.0, 0.0), 1.5, 1)),
        stage.mesh(without_flat_triangles(dented(DVec3::ZERO, 1.0, 1, 0.6, rng))),
    ];
    for _ in 0..12 {
        let size = DVec3::new(rng.range(0.1, 2.0), rng.range(0.1, 2.0), rng.range(-2.0, 2.0));
        let place =
            DAffine3::from_translation(point(rng, 6.0)) * DAffine3::from_mat3(turn(rng)) * DAffine3::from_scale(size);
        stage.place(*rng.pick(&meshes), place, Class::Vehicle);
    }
    (stage.finish(), rig(rng, altitude_m, 0.3))
}

/// Convex and dented solids on and in the floor and each other.
fn solids(rng: &mut Rng, altitude_m: f64) -> (Scene, StereoRig) {
    let mut stage = Stage::new();
    floor(&mut stage, -2.0, rng);
    for _ in 0..4 {
        let depth = *rng.pick(&[0.0, 0.0, 0.4, 0.7]);
        let m = dented(point(rng, 5.0), rng.range(1.0, 4.0), 2, depth, rng);
        stage.add(without_flat_triangles(m), DAffine3::IDENTITY, Class::Rock);
    }
    (stage.finish(), rig(rng, altitude_m, 0.3))
}

/// Boxes wall to wall on a lattice of metres, some with common roofs, standing on a floor that their bases touch.
fn flush(rng: &mut Rng, altitude_m: f64) -> (Scene, StereoRig) {
    let mut stage = Stage::new();
    stage.add(grid(-12.0, -12.0, 3.0, 8, &mut |_, _| 0.0), DAffine3::IDENTITY, Class::Ground);
    for j in -3..3 {
        for i in -3..3 {
            if rng.chance(0.7) {
                let low = DVec3::new(f64::from(i) * 2.0, f64::from(j) * 2.0, 0.0);
                let high = low + DVec3::new(2.0, 2.0, *rng.pick(&[1.0, 2.0, 2.0, 5.0]));
                stage.add(cuboid(low, high), DAffine3::IDENTITY, Class::Facade);
            }
        }
    }
    (stage.finish(), rig(rng, altitude_m, 0.3))
}

/// Sheets of a few hundredths of a millimetre, 5e-5 m above a floor, seen with a pixel of two micrometres.
pub(crate) fn gaps(rng: &mut Rng, altitude_m: f64) -> (Scene, StereoRig) {
    let mut stage = Stage::new();
    stage.add(grid(-1.0, -1.0, 2.0, 1, &mut |_, _| 0.0), DAffine3::IDENTITY, Class::Ground);
    let m = stage.mesh(grid(-0.5, -0.5, 0.5, 2, &mut |_, _| 0.0));
    for _ in 0..8 {
        let at = point(rng, 4e-5).with_z(5e-5);
        let place = DAffine3::from_translation(at)
            * DAffine3::from_rotation_z(rng.range(0.0, 3.0))
            * DAffine3::from_scale(DVec3::new(rng.range(5e-6, 4e-5), rng.range(5e-6, 4e-5), 1.0));
        stage.place(m, place, Class::Roof);
    }
    (stage.finish(), rig(rng, altitude_m, 2e-6))
}

/// Tiles along a side of [`town`]'s terrain.
const TILES: u32 = 4;

/// A piece of country: tiled terrain with bit-equal borders, trees as instances of one mesh, turned boxes, about
/// `cells`^2 * 2 triangles of terrain around the origin.
pub(crate) fn town(seed: u64, cells: u32, cell_m: f64, things: u32) -> Scene {
    let path = SeedPath::root("town", seed);
    let mut stage = Stage::new();
    let half = f64::from(cells) * cell_m / 2.0;
    let noise = path.child("ground").hash_u32();
    let mut height = |x: f64, y: f64| {
        let at = |wave: f64| f64::from(gradient_noise_2d(x / wave, y / wave, noise));
        25.0 * at(90.0) + 6.0 * at(17.0) + 0.4 * at(2.3)
    };
    let side = f64::from(cells / TILES) * cell_m;
    for j in 0..TILES {
        for i in 0..TILES {
            let (x, y) = (f64::from(i) * side - half, f64::from(j) * side - half);
            stage.add(grid(x, y, cell_m, cells / TILES, &mut height), DAffine3::IDENTITY, Class::Ground);
        }
    }
    let mut rng = path.child("things").rng();
    let tree = stage.mesh(without_flat_triangles(dented(DVec3::new(0.0, 0.0, 6.0), 4.0, 3, 0.35, &mut rng)));
    let house = stage.mesh(cuboid(DVec3::new(-6.0, -4.0, -8.0), DVec3::new(6.0, 4.0, 9.0)));
    for k in 0..things {
        let (x, y) = (rng.signed() * half * 0.98, rng.signed() * half * 0.98);
        let foot = DAffine3::from_translation(DVec3::new(x, y, height(x, y)))
            * DAffine3::from_rotation_z(rng.range(0.0, 6.3))
            * DAffine3::from_scale(DVec3::new(rng.range(0.6, 1.5), rng.range(0.6, 1.5), rng.range(0.5, 2.5)));
        let (mesh, class) = if k % 3 == 0 { (house, Class::Facade) } else { (tree, Class::Tree) };
        stage.place(mesh, foot, class);
    }
    stage.finish()
}

/// A pair over the origin with the frames overlapping at height 0.
pub(crate) fn pair(altitude_m: f64, size_px: [u32; 2], azimuth_rad: f64) -> StereoRig {
    RigCase {
        altitude_m,
        gsd_m: 0.3,
        size_px,
        feet_m: [-0.08 * altitude_m, 0.12 * altitude_m],
        azimuth_rad,
        datum: Datum::Height(0.0),
        shift_px: [0.02 * altitude_m / 0.3, 0.0],
    }
    .rig()
}
