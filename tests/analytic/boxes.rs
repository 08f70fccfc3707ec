//! Plane, box in its three cases, street canyon, bridge over water, overhang: on every rig and placement.

use crate::analytic::bodies::{Bodies, Boxes, Wedge};
use crate::analytic::closed_form::{Tally, check};
use crate::support::solids::{cuboid, mesh};
use crate::support::stage::{RigCase, Stage, world_from_baseline};
use glam::{DAffine3, DMat3, DVec3};
use satseed::camera::Datum;
use satseed_scene::{Class, Mesh, Scene, quantise_point};

/// How a scene that is given along the baseline comes to stand in the world.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Placement {
    /// The baseline runs east.
    Axis,
    /// Vertices turned by a 3-4-5 angle: they stay on the lattice.
    Vertices,
    /// An instance turned by any angle, moved and halved in size.
    Instance,
}

pub(crate) const PLACEMENTS: [Placement; 3] = [Placement::Axis, Placement::Vertices, Placement::Instance];

impl Placement {
    pub(crate) fn azimuth_rad(self) -> f64 {
        match self {
            Self::Axis => core::f64::consts::FRAC_PI_2,
            Self::Vertices => libm::atan2(3.0, 4.0),
            Self::Instance => 0.649,
        }
    }

    /// Adds a mesh that is given along the baseline.
    pub(crate) fn add(self, stage: &mut Stage, mut m: Mesh, class: Class) {
        let turn = world_from_baseline(self.azimuth_rad());
        let each = |m: &mut Mesh, f: &dyn Fn(DVec3) -> DVec3| {
            for p in &mut m.positions_m {
                *p = quantise_point(f(DVec3::from(p.map(f64::from))));
            }
        };
        let world_from_object = match self {
            Self::Axis => DAffine3::IDENTITY,
            Self::Vertices => {
                let exact = DMat3::from_cols(DVec3::new(0.6, 0.8, 0.0), DVec3::new(-0.8, 0.6, 0.0), DVec3::Z);
                each(&mut m, &|p| exact * p);
                DAffine3::IDENTITY
            }
            Self::Instance => {
                let offset = DVec3::new(8.5, -3.25, 1.5);
                each(&mut m, &|p| (p - offset) * 2.0);
                DAffine3::from_mat3(turn) * DAffine3::from_translation(offset) * DAffine3::from_scale(DVec3::splat(0.5))
            }
        };
        stage.add(m, world_from_object, class);
    }
}

const GROUND_HALF_M: f64 = 3200.0;

pub(crate) fn ground(z: f64, half: f64) -> Mesh {
    let corner = |x: f64, y: f64| DVec3::new(x * half, y * half, z);
    mesh(&[corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)], vec![[0, 1, 2], [0, 2, 3]])
}

pub(crate) fn boxes_scene(bodies: &Boxes, placement: Placement, classes: &[Class]) -> Scene {
    let mut stage = Stage::new();
    placement.add(&mut stage, ground(bodies.ground_z, bodies.ground_half), classes[0]);
    for (k, b) in bodies.solids.iter().enumerate() {
        placement.add(&mut stage, cuboid(b[0], b[1]), classes[(k + 1).min(classes.len() - 1)]);
    }
    stage.finish()
}

/// Places are chosen so that no ray runs exactly through an edge: the formulas would leave such a pixel open.
/// 1 km without and with a datum, rows near the principal point and far from it, and 617 km with a datum.
pub(crate) fn rigs(placement: Placement, near_feet_m: [f64; 2], far_feet_m: [f64; 2]) -> Vec<RigCase> {
    let azimuth_rad = placement.azimuth_rad();
    let datum_m = 7.3125;
    // Brings the middle of both frames to the origin at the datum's height.
    let centred =
        |altitude_m: f64, feet: [f64; 2]| f64::midpoint(feet[0], feet[1]) * (altitude_m / 0.3) / (altitude_m - datum_m);
    let near = RigCase {
        altitude_m: 1000.0,
        gsd_m: 0.3,
        size_px: [2048, 3],
        feet_m: near_feet_m,
        azimuth_rad,
        datum: Datum::None,
        shift_px: [0.0; 2],
    };
    let with_datum = RigCase {
        datum: Datum::Height(datum_m),
        size_px: [1024, 3],
        shift_px: [centred(1000.0, near_feet_m), 0.0],
        ..near
    };
    let far = RigCase {
        altitude_m: 617_000.0,
        feet_m: far_feet_m,
        shift_px: [centred(617_000.0, far_feet_m), 0.0],
        ..with_datum
    };
    vec![
        near,
        RigCase { shift_px: [3.25, 811.3], ..near },
        with_datum,
        RigCase { shift_px: [with_datum.shift_px[0], -611.7], size_px: [1024, 2], ..with_datum },
        far,
        RigCase { shift_px: [far.shift_px[0], 702.6], size_px: [1024, 2], ..far },
    ]
}

/// Without a datum an orbit's frames do not overlap: one camera looks at the scene, the other past its end.
fn orbit_without_datum(placement: Placement) -> [RigCase; 2] {
    let over_left = RigCase {
        datum: Datum::None,
        feet_m: [11.0, 123_411.0],
        shift_px: [0.0; 2],
        ..rigs(placement, [0.0, 1.0], [0.0, 1.0])[4]
    };
    [over_left, RigCase { feet_m: [-123_389.0, 11.0], ..over_left }]
}

const Y: f64 = 520.0;

fn block(x0: f64, x1: f64, z0: f64, z1: f64) -> [DVec3; 2] {
    [DVec3::new(x0, -Y, z0), DVec3::new(x1, Y, z1)]
}

fn prove(what: &str, bodies: &Boxes, classes: &[Class], near_feet_m: [f64; 2], far_feet_m: [f64; 2]) -> Tally {
    let mut tally = Tally::default();
    for placement in PLACEMENTS {
        let scene = boxes_scene(bodies, placement, classes);
        let mut cases = rigs(placement, near_feet_m, far_feet_m);
        cases.extend(orbit_without_datum(placement));
        for case in cases {
            tally.add(&check(&format!("{what} {placement:?}"), &scene, &case, bodies as &dyn Bodies));
        }
    }
    report(what, &tally);
    tally
}

#[allow(clippy::print_stderr, reason = "the counts are part of the proof")]
pub(crate) fn report(what: &str, t: &Tally) {
    let [miss, valid, occluded, out] = t.pixels;
    eprintln!(
        "{what}: {valid} valid, {occluded} occluded, {out} out of frame, {miss} miss; worst {:.1e} px",
        t.worst_px
    );
}

#[test]
fn plane() {
    for z in [0.0, 31.25, -117.5] {
        let bodies = Boxes { ground_z: z, ground_half: GROUND_HALF_M, solids: vec![] };
        let t = prove(&format!("plane at {z} m"), &bodies, &[Class::Ground], [-100.0, 100.0], [-61_700.0, 61_700.0]);
        assert!([0, 1, 3].iter().all(|k| t.pixels[*k] > 0), "every case but occlusion occurs: {t:?}");
        assert_eq!(t.pixels[2], 0, "nothing occludes a plane");
    }
}

/// The box's left and right edges left of both feet, between them, right of both: all pairs that exist.
#[test]
fn box_in_its_cases() {
    for (name, x, near, far) in [
        ("left of both", [-118.75, -57.5], [-50.0, 50.0], [61.25, 123_461.25]),
        ("between", [-31.25, 28.75], [-100.0, 100.0], [-61_700.0, 61_700.0]),
        ("right of both", [58.75, 117.5], [-50.0, 50.0], [-123_461.25, -61.25]),
        ("left edge left, right edge between", [-81.25, 13.75], [-25.0, 75.0], [0.0, 123_400.0]),
        ("left edge between, right edge right", [-13.75, 81.25], [-75.0, 25.0], [-123_400.0, 0.0]),
        ("over both", [-81.25, 82.5], [-40.0, 60.0], [-70.0, 123_330.0]),
    ] {
        let bodies = Boxes { ground_z: 0.0, ground_half: GROUND_HALF_M, solids: vec![block(x[0], x[1], -1.25, 60.0)] };
        let t = prove(&format!("box {name}"), &bodies, &[Class::Ground, Class::Facade], near, far);
        assert!(t.pixels.iter().all(|n| *n > 0), "every case occurs: {t:?}");
    }
}

/// A box with ends inside the frame: all of its sides, and rows that pass it.
#[test]
fn box_with_ends() {
    let bodies = Boxes {
        ground_z: 0.0,
        ground_half: GROUND_HALF_M,
        solids: vec![
            [DVec3::new(-13.75, -11.25, -1.25), DVec3::new(7.5, 16.25, 23.75)],
            [DVec3::new(16.25, -20.0, 5.0), DVec3::new(18.75, -5.0, 6.25)],
        ],
    };
    let mut tally = Tally::default();
    for placement in PLACEMENTS {
        let scene = boxes_scene(&bodies, placement, &[Class::Ground, Class::Roof, Class::Bridge]);
        for case in rigs(placement, [-90.0, 110.0], [-50_000.0, 73_400.0]).into_iter().skip(2) {
            let case = RigCase { size_px: [160, 150], shift_px: [case.shift_px[0], 31.7], ..case };
            tally.add(&check(&format!("{placement:?}"), &scene, &case, &bodies));
        }
    }
    report("box with ends", &tally);
    assert!(tally.pixels[2] > 0);
}

#[test]
fn street_canyon() {
    let bodies = Boxes {
        ground_z: 0.0,
        ground_half: GROUND_HALF_M,
        solids: vec![block(-60.0, -8.75, -1.25, 75.0), block(11.25, 47.5, -1.25, 31.25)],
    };
    for (near, far) in [([-100.0, 100.0], [-61_700.0, 61_700.0]), ([-180.0, -5.0], [-123_400.0, 0.0])] {
        let t = prove("street canyon", &bodies, &[Class::Road, Class::Facade], near, far);
        assert!(t.pixels.iter().all(|n| *n > 0), "every case occurs: {t:?}");
    }
}

#[test]
fn bridge_over_water() {
    let bodies = Boxes {
        ground_z: -6.25,
        ground_half: GROUND_HALF_M,
        solids: vec![
            block(-401.210_937_5, -41.210_937_5, -7.5, 0.0),
            block(38.769_531_25, 402.5, -7.5, 0.0),
            // The deck runs along the image's columns and stands free.
            block(-3.75, 5.0, 11.25, 12.5),
        ],
    };
    let classes = [Class::Water, Class::Ground, Class::Ground, Class::Bridge];
    for (near, far) in [([-100.0, 100.0], [-61_700.0, 61_700.0]), ([-210.0, -110.0], [-150_000.0, -26_600.0])] {
        let t = prove("bridge over water", &bodies, &classes, near, far);
        assert!(t.pixels.iter().all(|n| *n > 0), "every case occurs: {t:?}");
    }
}

#[test]
fn overhang() {
    let bodies = Boxes {
        ground_z: 0.0,
        ground_half: GROUND_HALF_M,
        solids: vec![block(-15.0, 16.25, -1.25, 60.0), block(-21.25, 22.5, 60.0, 63.75)],
    };
    // Seen from far to a side, the wall shows below the overhang.
    for (near, far) in [([-240.0, -60.0], [-180_000.0, -56_600.0]), ([80.0, 250.0], [56_600.0, 180_000.0])] {
        let t = prove("overhang", &bodies, &[Class::Ground, Class::Facade, Class::Roof], near, far);
        assert!(t.pixels.iter().all(|n| *n > 0), "every case occurs: {t:?}");
    }
}

/// What [`Wedge`] is made of when it stands in a scene.
pub(crate) fn wedge_scene(wedge: &Wedge, placement: Placement) -> Scene {
    let foot = -1.25;
    // The slope goes on below the ground, so that the ground cuts it at x0.
    let start = wedge.x0 + foot * (wedge.x1 - wedge.x0) / wedge.height;
    let mut profile = vec![[start, foot], [wedge.x1, foot], [wedge.x1, wedge.height]];
    if wedge.x1 < wedge.x0 {
        profile.reverse();
    }
    let mut stage = Stage::new();
    placement.add(&mut stage, ground(0.0, wedge.ground_half), Class::Ground);
    placement.add(&mut stage, crate::support::solids::prism(&profile, Y), Class::Roof);
    stage.finish()
}
