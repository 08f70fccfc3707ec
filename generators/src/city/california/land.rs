//! Where things lie: the flat sheet on which the city is laid out, bent gently into the world.
//!
//! Streets and lots are laid out with straight lines and right angles on a flat sheet. The sheet is turned and warped, so
//! that in the world nearly every street bends; the layout never needs to know.

use super::hill::skeleton::Hills;
use super::marina::harbour::Harbour;
use crate::city::toronto::relief::Swells;
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::SeedPath;

/// Longest edge of what is bent, m: longer ones get corners between.
const CHORD_M: f64 = 7.0;

/// The sheet's place in the world and the relief under it.
#[derive(Clone, Debug)]
pub(super) struct Land {
    relief: Swells,
    turn: DVec2,
    /// Direction of the shift, wave vector, phase.
    waves: [(DVec2, DVec2, f64); 3],
    harbour: Option<Harbour>,
    hills: Option<Hills>,
}

impl Land {
    pub(super) fn new(city: &SeedPath) -> Self {
        let mut rng = city.child("land").rng();
        let (s, c) = libm::sincos(rng.range(-0.32, 0.32));
        let waves = [(9.0, 1000.0), (5.0, 620.0), (2.5, 370.0)].map(|(amplitude_m, wavelength_m)| {
            let (s, c) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
            let (along, across) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
            let k = core::f64::consts::TAU / wavelength_m * rng.range(0.9, 1.1);
            (DVec2::new(c, s) * amplitude_m, DVec2::new(along, across) * k, rng.range(0.0, core::f64::consts::TAU))
        });
        Self { relief: Swells::new(city), turn: DVec2::new(c, s), waves, harbour: None, hills: None }
    }

    /// Straight land around a harbour, turned any way.
    pub(super) fn around(harbour: Harbour, city: &SeedPath) -> Self {
        Self { harbour: Some(harbour), ..Self::straight(city) }
    }

    /// Hills, turned any way.
    pub(super) fn over(hills: Hills, city: &SeedPath) -> Self {
        Self { hills: Some(hills), ..Self::straight(city) }
    }

    fn straight(city: &SeedPath) -> Self {
        let (s, c) = libm::sincos(city.child("land").rng().range(0.0, core::f64::consts::TAU));
        let still = (DVec2::ZERO, DVec2::ZERO, 0.0);
        Self { relief: Swells::new(city), turn: DVec2::new(c, s), waves: [still; 3], harbour: None, hills: None }
    }

    /// Height of the ground at a place of the world, m.
    pub(super) fn height_m(&self, p: DVec2) -> f64 {
        if let Some(hills) = &self.hills {
            return hills.height_m(self.turned_back(p));
        }
        let relief_m = self.relief.height_m(p);
        self.harbour.as_ref().map_or(relief_m, |h| h.height_m(self.turned_back(p), relief_m))
    }

    /// The harbour, if there is one.
    pub(super) fn harbour(&self) -> Option<&Harbour> {
        self.harbour.as_ref()
    }

    /// The hills, if there are any.
    pub(super) fn hills(&self) -> Option<&Hills> {
        self.hills.as_ref()
    }

    /// A place of the world on the sheet, where that is straight.
    pub(super) fn turned_back(&self, p: DVec2) -> DVec2 {
        DVec2::new(self.turn.x, -self.turn.y).rotate(p)
    }

    /// A place of the sheet in the world.
    pub(super) fn world(&self, flat: DVec2) -> DVec2 {
        let bent = self.waves.iter().fold(flat, |p, (shift, k, phase)| p + *shift * libm::sin(k.dot(flat) + phase));
        self.turn.rotate(bent)
    }
}

/// A rectangle of the sheet with a frame of its own, inside which streets are bowed once more.
#[derive(Clone, Debug)]
pub(super) struct Sheet<'a> {
    pub(super) land: &'a Land,
    /// Its corner on the sheet.
    pub(super) origin: DVec2,
    /// Its first axis runs along the sheet's second.
    pub(super) swapped: bool,
    /// Its size along its own axes, m.
    pub(super) size: DVec2,
    /// Greatest bow of its first axis: as one hump, and as an S, m.
    pub(super) bow_m: [f64; 2],
}

impl Sheet<'_> {
    /// A place of the frame in the world. The bow dies out at the rectangle's border and is none outside.
    pub(super) fn world(&self, p: DVec2) -> DVec2 {
        let share = p / self.size;
        let inside = share.cmpgt(DVec2::ZERO).all() && share.cmplt(DVec2::ONE).all();
        let mut q = p;
        if inside {
            let pi = core::f64::consts::PI;
            let across = libm::sin(pi * share.y);
            q.y += (self.bow_m[0] * libm::sin(pi * share.x) + self.bow_m[1] * libm::sin(2.0 * pi * share.x)) * across;
        }
        let q = if self.swapped { DVec2::new(q.y, q.x) } else { q };
        self.land.world(self.origin + q)
    }

    /// A polygon of the frame in the world, counter-clockwise, its long edges bent.
    pub(super) fn polygon(&self, local: &[DVec2]) -> Vec<DVec2> {
        self.corners(&polygon::subdivided(local, CHORD_M))
    }

    /// The same with its own corners alone.
    pub(super) fn corners(&self, local: &[DVec2]) -> Vec<DVec2> {
        let mut out: Vec<DVec2> = local.iter().map(|p| self.world(*p)).collect();
        if polygon::area(&out) < 0.0 {
            out.reverse();
        }
        out
    }

    /// Direction of a frame's direction at a place, unit, world.
    pub(super) fn direction(&self, at: DVec2, along: DVec2) -> DVec2 {
        (self.world(at + along * 0.5) - self.world(at - along * 0.5)).normalize()
    }
}
