//! Palms: a bare stem and a head of drooping fronds.

use super::mesh_builder::MeshBuilder;
use super::trees::{BARK, LEAVES};
use glam::{DVec2, DVec3};
use satseed_scene::{Mesh, Rng, SeedPath};

/// Shape of a kind of palm. Lengths are of the mesh before an instance scales it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Palm {
    /// Height of the head's middle, m: least and greatest.
    pub stem_m: [f64; 2],
    /// Radius of the stem at its foot, m.
    pub trunk_m: f64,
    /// Length of a frond, m.
    pub frond_m: f64,
    /// Width of a frond, m.
    pub width_m: f64,
    /// Number of fronds.
    pub fronds: u32,
    /// Length of the skirt of dead leaves below the head, m.
    pub skirt_m: f64,
}

/// Mexican fan palm (tall, thin, small head), California fan palm (stout, skirted), Canary date palm (wide head), queen
/// palm (garden size).
pub const PALMS: [Palm; 4] = [
    Palm { stem_m: [11.0, 19.0], trunk_m: 0.26, frond_m: 1.7, width_m: 0.62, fronds: 34, skirt_m: 1.6 },
    Palm { stem_m: [8.0, 12.0], trunk_m: 0.45, frond_m: 2.1, width_m: 0.75, fronds: 36, skirt_m: 2.6 },
    Palm { stem_m: [5.0, 9.0], trunk_m: 0.5, frond_m: 3.9, width_m: 0.55, fronds: 54, skirt_m: 0.4 },
    Palm { stem_m: [5.0, 9.0], trunk_m: 0.2, frond_m: 3.0, width_m: 0.5, fronds: 26, skirt_m: 0.0 },
];

/// One individual: z = 0 is the ground, the stem begins below it.
pub fn palm(kind: &Palm, path: &SeedPath) -> Mesh {
    let mut rng = path.rng();
    let mut b = MeshBuilder::default();
    let height = rng.range(kind.stem_m[0], kind.stem_m[1]);
    let lean = DVec3::new(rng.signed(), rng.signed(), 0.0) * (0.025 * height);
    let middle = DVec3::new(0.0, 0.0, height * 0.5) + lean * 0.3;
    let head = DVec3::new(0.0, 0.0, height) + lean;
    let r = kind.trunk_m;
    b.limb(BARK, DVec3::new(0.0, 0.0, -0.7), middle, [r * 1.2, r * 0.85], 7);
    b.limb(BARK, middle - DVec3::Z * 0.1, head, [r * 0.85, r * 0.75], 7);
    if kind.skirt_m > 0.0 {
        let below = head - DVec3::Z * kind.skirt_m;
        b.limb(BARK, below, head + DVec3::Z * 0.1, [r * 1.5, r * 1.9 + 0.25], 8);
    }
    b.limb(LEAVES, head - DVec3::Z * 0.2, head + DVec3::Z * 0.35, [r * 1.4, r * 0.6], 7);
    for k in 0..kind.fronds {
        let turn = f64::from(k) * 2.399_963 + rng.signed() * 0.25;
        // From nearly upright in the middle to hanging at the rim.
        let share = (f64::from(k) + 0.5) / f64::from(kind.fronds);
        let rise = 1.25 - 1.75 * share + rng.signed() * 0.15;
        let length = kind.frond_m * rng.range(0.8, 1.1) * (0.75 + 0.25 * libm::sin(share * core::f64::consts::PI));
        frond(&mut b, head, turn, rise, length, kind.width_m * rng.range(0.8, 1.15), &mut rng);
    }
    b.finish()
}

/// A frond in three pieces, each a thin closed blade bent further down than the last.
fn frond(b: &mut MeshBuilder, head: DVec3, turn: f64, rise: f64, length: f64, width: f64, rng: &mut Rng) {
    let (s, c) = libm::sincos(turn);
    let outward = DVec3::new(c, s, 0.0);
    let side = DVec3::new(-s, c, 0.0);
    let tilt = rng.signed() * 0.3;
    let mut at = head;
    let mut angle = rise;
    let sections: Vec<(DVec3, DVec3, f64)> = (0..4)
        .map(|k| {
            let (sa, ca) = libm::sincos(angle);
            let forward = outward * ca + DVec3::Z * sa;
            let up = DVec3::Z * ca - outward * sa;
            let here = (at, (side + up * tilt).normalize(), [0.12, 1.0, 0.85, 0.12][k] * width * 0.5);
            at += forward * (length / 3.0);
            angle -= 0.5 + 0.12 * f64::from(k as u32);
            here
        })
        .collect();
    let thick = DVec3::Z * 0.03;
    for pair in sections.windows(2) {
        let ((p, u, w), (q, v, x)) = (pair[0], pair[1]);
        let ring = |centre: DVec3, across: DVec3, half: f64| {
            [centre - across * half, centre - thick, centre + across * half, centre + thick]
        };
        let (near, far) = (ring(p, u, w), ring(q, v, x));
        let uv = |p: DVec3| (p, DVec2::new(p.x, p.y));
        for k in 0..4 {
            let n = (k + 1) % 4;
            b.fan(LEAVES, &[uv(near[k]), uv(near[n]), uv(far[n])]);
            b.fan(LEAVES, &[uv(near[k]), uv(far[n]), uv(far[k])]);
        }
        b.fan(LEAVES, &[uv(near[3]), uv(near[2]), uv(near[1]), uv(near[0])]);
        b.fan(LEAVES, &[uv(far[0]), uv(far[1]), uv(far[2]), uv(far[3])]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::mesh_builder::open_edges;

    #[test]
    fn palms_are_closed_and_stand_in_the_ground() {
        for (k, kind) in PALMS.iter().enumerate() {
            for n in 0..4 {
                let m = palm(kind, &SeedPath::root("palm", k as u64).index(n));
                assert_eq!((m.validate(), open_edges(&m)), (Ok(()), 0), "{k}");
                let (low, high) = m.bounds_m().unwrap();
                assert!(
                    low.z <= -0.5 && high.z > kind.stem_m[0] && high.x - low.x < 2.6 * kind.frond_m,
                    "{low} {high}"
                );
                assert!((400..2600).contains(&m.triangles.len()), "{}", m.triangles.len());
            }
        }
    }
}
