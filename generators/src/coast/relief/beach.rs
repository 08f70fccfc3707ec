//! Sand: bars, foreshore with its cusps, berm, dunes and the plain behind them.

use super::{Relief, offing_m, soft_min};
use crate::coast::shore::Place;
use crate::kit::terrain::noise::{fractal, ridged};
use crate::kit::terrain::sampling::smoothstep;
use glam::DVec2;

impl Relief {
    /// Ragged distance inland: the shore itself is smooth.
    fn inland_m(&self, p: DVec2, place: &Place, wavelength_m: f64, by_m: f64) -> f64 {
        place.inland_m + by_m * fractal(p, self.seeds.edge, wavelength_m, 4, 0.55)
    }

    /// The beach from the bars to the back of the berm.
    pub(super) fn beach_m(&self, p: DVec2, place: &Place) -> f64 {
        let f = &self.form;
        let d = self.inland_m(p, place, 90.0, 3.0);
        if d < 0.0 {
            let mut z = offing_m(f, false, &Place { inland_m: d, ..*place });
            let wander = 26.0 * fractal(p, self.seeds.bars, 240.0, 2, 0.5);
            for (k, [at_m, height_m]) in f.bars.iter().enumerate() {
                let gaps = smoothstep(-0.28, 0.05, fractal(p, self.seeds.rips ^ k as u32, 170.0, 2, 0.5));
                let t = (-d - at_m - wander * (0.5 + 0.7 * k as f64)) / (0.24 * at_m);
                z += height_m * gaps * libm::exp(-t * t);
            }
            return z + 0.06 * fractal(p, self.seeds.fine, 9.0, 3, 0.5) * smoothstep(0.0, 12.0, -d);
        }
        // Cusps: horns and bays on the upper foreshore.
        let turns = place.along_m / 24.0 + 1.2 * fractal(p, self.seeds.cusps, 130.0, 2, 0.5);
        let at_m = f.berm_m / f.foreshore;
        let cusps = 0.20
            * libm::cos(core::f64::consts::TAU * turns)
            * smoothstep(0.1, 0.55, d / at_m)
            * smoothstep(1.25, 0.8, d / at_m);
        let face = f.foreshore * d;
        let back = f.berm_m - 0.011 * (d - at_m);
        let rough = 0.05 * self.roughness * fractal(p, self.seeds.fine, 5.0, 3, 0.6) * smoothstep(0.6, 1.0, d / at_m);
        soft_min(face, back.max(0.6 * f.berm_m), 0.35) + cusps + rough
    }

    pub(super) fn sandy_m(&self, p: DVec2, place: &Place) -> f64 {
        let f = &self.form;
        let beach = self.beach_m(p, place);
        let d = self.inland_m(p, place, 60.0, 7.0) - self.dune_toe_m(p);
        if d < -6.0 {
            return beach;
        }
        let rough = self.roughness;
        // The foredune: a ridge of uneven height along the beach; behind it hummocks and hollows, then a plain that rises.
        let belt = f.belt_m;
        let up = smoothstep(-4.0, (6.0 + 0.2 * belt).clamp(10.0, 17.0), d);
        let ridge = 1.0 - 0.55 * smoothstep(0.25 * belt + 6.0, 0.8 * belt + 12.0, d);
        let uneven = 0.78 + 0.55 * fractal(p, self.seeds.dunes, 70.0, 3, 0.5);
        let hummocks = 0.24 * ridged(p, self.seeds.hummocks, 30.0, 3, 0.34);
        let fine = 0.10 * fractal(p, self.seeds.fine ^ 3, 9.0, 4, 0.55);
        let field = smoothstep(1.5 * belt + 16.0, 0.75 * belt + 6.0, d);
        let hollow = self.blowout(p) * smoothstep(1.0, 12.0, d);
        let mut dune = f.dune_m * up * (ridge * uneven + rough * (hummocks + fine));
        dune *= 1.0 - 0.5 * hollow;
        // Paths to the beach lie lower.
        dune *= 1.0 - 0.55 * self.path(p, place).1;
        let plain = 0.6
            + 0.10 * self.land_height_m * smoothstep(60.0, 420.0, d)
            + 0.16 * self.land_height_m * fractal(p, self.seeds.hills, 340.0, 4, 0.42) * smoothstep(90.0, 330.0, d)
            + 0.12 * rough * fractal(p, self.seeds.fine ^ 5, 11.0, 3, 0.5) * smoothstep(60.0, 120.0, d)
            - 0.5 * rough * self.damp(p) * smoothstep(40.0, 130.0, d - belt);
        let on_land = dune.max(-0.6) * field.max(0.04) + plain.max(-0.8) * smoothstep(0.0, 70.0, d);
        beach + on_land - 0.10 * self.track(p, place)
    }

    /// How much the wind has blown a place of the dunes out, 0 to 1: troughs about three times as long as wide, downwind.
    pub(in super::super) fn blowout(&self, p: DVec2) -> f64 {
        let q = DVec2::new(p.dot(self.wind) / 3.2, p.dot(self.wind.perp()));
        let least = 0.42 - 0.55 * self.form.bare;
        smoothstep(least, least + 0.30, fractal(q, self.seeds.blowouts, 24.0, 4, 0.55))
    }

    /// Width of the belt of dunes, m, and how bare it is, 0 to 1.
    pub(in super::super) fn belt(&self) -> (f64, f64) {
        (self.form.belt_m, self.form.bare)
    }

    /// Height of the berm, m, and the slope up to it.
    pub(in super::super) fn berm(&self) -> (f64, f64) {
        (self.form.berm_m, self.form.foreshore)
    }

    /// Where the dunes begin, m inland.
    pub(in super::super) fn dune_toe_m(&self, p: DVec2) -> f64 {
        self.form.toe_m + (0.22 * self.form.toe_m).min(14.0) * fractal(p, self.seeds.dunes ^ 9, 150.0, 2, 0.5)
    }
}
