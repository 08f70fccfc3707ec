//! Arched bridges of brick and stone with open water beneath.

use super::canals::Bridge;
use super::lie::{Lie, WATER_M};
use crate::kit::mesh_builder::MeshBuilder;
use glam::{DVec2, DVec3};
use satseed_scene::{Mesh, SeedPath, quantise_m};

/// Slots of a bridge's material set.
pub(super) mod slot {
    /// Steps.
    pub(in super::super) const DECK: u16 = 0;
    /// Sides and arch.
    pub(in super::super) const SIDE: u16 = 1;
    /// Parapets.
    pub(in super::super) const RAIL: u16 = 2;
    /// How many.
    pub(in super::super) const COUNT: usize = 3;
}

/// A bridge in the world. x of its frame runs from shore to shore, z = 0 is the paving.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    /// Its middle in the world, m.
    pub centre_m: DVec2,
    /// Direction of x.
    pub axis: DVec2,
    /// Distance of the shores, m.
    pub length_m: f64,
    /// Width, m.
    pub width_m: f64,
    /// Height of the deck's crown over the paving, m.
    pub crown_m: f64,
    /// Its number.
    pub key: u64,
}

/// Length of the steps on land, m.
const LANDING_M: f64 = 2.6;

impl Span {
    /// Of a planned bridge.
    pub(super) fn new(bridge: &Bridge, lie: &Lie, city: &SeedPath) -> Self {
        let [a, b] = bridge.shores.map(|p| lie.world(p));
        let centre = a.midpoint(b);
        let mut rng = city.child("bridge").index(bridge.key).rng();
        // Boats with a standing rower pass below: 2.1 to 2.9 m of air.
        let clear_m = rng.range(2.1, 2.9);
        Self {
            centre_m: DVec2::new(quantise_m(centre.x).into(), quantise_m(centre.y).into()),
            axis: (b - a).normalize(),
            length_m: a.distance(b),
            width_m: bridge.width_m,
            crown_m: WATER_M + clear_m + 0.42,
            key: bridge.key,
        }
    }

    fn deck_m(&self, x: f64) -> f64 {
        let t = (x.abs() / (self.length_m / 2.0 + LANDING_M)).min(1.0);
        // Steep steps up to a short level crown.
        let s = ((t - 0.12) / 0.88).max(0.0);
        self.crown_m * (1.0 - s * s * (1.6 - 0.6 * s)) - 0.12 * t
    }

    fn arch_m(&self, x: f64) -> f64 {
        let half = self.length_m / 2.0 - 0.1;
        if x.abs() >= half {
            return WATER_M - 0.7;
        }
        let t = x / half;
        let springing = WATER_M - 0.15;
        springing + (self.crown_m - 0.42 - springing) * (1.0 - t * t).sqrt()
    }
}

/// The mesh of a bridge.
pub(super) fn mesh(s: &Span) -> Mesh {
    let mut b = MeshBuilder::default();
    let (half, end) = (s.length_m / 2.0, s.length_m / 2.0 + LANDING_M);
    let mut xs = vec![-end, -half - 1.2, -half - 0.02];
    for k in 0..=16 {
        // Closer where the arch is steep.
        let angle = core::f64::consts::PI * f64::from(k) / 16.0;
        xs.push(-(half - 0.11) * libm::cos(angle));
    }
    xs.extend([half + 0.02, half + 1.2, end]);
    let w = s.width_m / 2.0;
    strip(&mut b, &xs, [-w, w], &|x| s.arch_m(x), &|x| s.deck_m(x), [slot::DECK, slot::SIDE]);
    for side in [-1.0, 1.0] {
        let (y0, y1) = if side > 0.0 { (w - 0.24, w + 0.04) } else { (-w - 0.04, 0.24 - w) };
        let rail = |x: f64| s.deck_m(x) + 0.92;
        strip(&mut b, &xs, [y0, y1], &|x| s.deck_m(x) - 0.25, &rail, [slot::RAIL, slot::RAIL]);
    }
    b.finish()
}

/// A closed solid between two heights over a strip of the plane.
fn strip(
    b: &mut MeshBuilder,
    xs: &[f64],
    [y0, y1]: [f64; 2],
    low: &dyn Fn(f64) -> f64,
    high: &dyn Fn(f64) -> f64,
    [top, side]: [u16; 2],
) {
    let uv = |p: DVec3, u: f64, v: f64| (p, DVec2::new(u, v));
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    for pair in xs.windows(2) {
        let (x0, x1) = (pair[0], pair[1]);
        let (l0, l1, h0, h1) = (low(x0), low(x1), high(x0), high(x1));
        b.fan(
            top,
            &[
                uv(at(x0, y0, h0), x0, y0),
                uv(at(x1, y0, h1), x1, y0),
                uv(at(x1, y1, h1), x1, y1),
                uv(at(x0, y1, h0), x0, y1),
            ],
        );
        b.fan(
            side,
            &[
                uv(at(x0, y1, l0), x0, y1),
                uv(at(x1, y1, l1), x1, y1),
                uv(at(x1, y0, l1), x1, y0),
                uv(at(x0, y0, l0), x0, y0),
            ],
        );
        b.fan(
            side,
            &[
                uv(at(x0, y0, l0), x0, l0),
                uv(at(x1, y0, l1), x1, l1),
                uv(at(x1, y0, h1), x1, h1),
                uv(at(x0, y0, h0), x0, h0),
            ],
        );
        b.fan(
            side,
            &[
                uv(at(x1, y1, l1), x1, l1),
                uv(at(x0, y1, l0), x0, l0),
                uv(at(x0, y1, h0), x0, h0),
                uv(at(x1, y1, h1), x1, h1),
            ],
        );
    }
    let (x0, x1) = (xs[0], xs[xs.len() - 1]);
    for (x, ya, yb) in [(x0, y1, y0), (x1, y0, y1)] {
        let (l, h) = (low(x), high(x));
        b.fan(
            side,
            &[uv(at(x, ya, l), ya, l), uv(at(x, yb, l), yb, l), uv(at(x, yb, h), yb, h), uv(at(x, ya, h), ya, h)],
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::mesh_builder::open_edges;

    #[test]
    fn bridges_are_closed_and_leave_air() {
        for (length_m, crown_m) in [(4.2, 1.8), (7.5, 2.4), (13.0, 2.5)] {
            let span = Span { centre_m: DVec2::ZERO, axis: DVec2::X, length_m, width_m: 2.8, crown_m, key: 0 };
            let m = mesh(&span);
            assert_eq!((m.validate(), open_edges(&m)), (Ok(()), 0));
            let air = span.arch_m(0.0) - WATER_M;
            assert!((1.9..3.0).contains(&air), "{air}");
            assert!(span.deck_m(0.0) - span.arch_m(0.0) > 0.3);
            assert!(span.deck_m(length_m / 2.0 + LANDING_M) < 0.0);
        }
    }
}
