//! Where feet, hooves and wheels go: the track, paths to the beach, sheep's trails, marks on the sand.

use super::Relief;
use crate::coast::shore::Place;
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::sampling::smoothstep;
use glam::DVec2;

/// How much of a strand of a half width covers a place beside its middle: 0.5 on its border, and so soft that posts 1 m apart
/// hold it.
fn strand(off_m: f64, half_m: f64) -> f64 {
    (0.5 + (half_m - off_m.abs()) / 2.4).clamp(0.0, 1.0)
}

impl Relief {
    /// Where the track runs, m inland.
    fn track_at_m(&self, p: DVec2) -> f64 {
        self.form.track_m + 16.0 * fractal(p, self.seeds.track, 260.0, 2, 0.5)
    }

    /// The track behind the shore, 0 to 1.
    pub(in super::super) fn track(&self, p: DVec2, place: &Place) -> f64 {
        smoothstep(2.3, 1.4, (place.inland_m - self.track_at_m(p)).abs())
    }

    /// How much a path to the beach covers a place (0.5 on its border) and how much it cuts into the dune, 0 to 1.
    pub(in super::super) fn path(&self, p: DVec2, place: &Place) -> (f64, f64) {
        let d = place.inland_m;
        let before_track_m = self.track_at_m(p) - d;
        // It ends in the middle of the track, where the track hides its end.
        if self.cliffs || d < 0.5 * self.form.toe_m || before_track_m < 0.0 {
            return (0.0, 0.0);
        }
        let along_m = p.dot(self.shore.out.perp());
        let mut least = (1e3, 0.0);
        for spur in &self.spurs {
            let off_m = spur.off_m(along_m, d);
            if f64::abs(off_m) < f64::abs(least.0) {
                least = (off_m, spur.half_m);
            }
        }
        let (off_m, half_m) = least;
        if off_m.abs() > 12.0 {
            return (0.0, 0.0);
        }
        let begins = smoothstep(0.7 * self.form.toe_m, 1.05 * self.form.toe_m, d);
        let n = |salt: u32, wavelength_m: f64| fractal(p, self.seeds.paths ^ salt, wavelength_m, 2, 0.5);
        // Feet round the corner into the track and spread on the sand.
        let half_m = half_m * (1.0 + 1.2 * n(0, 16.0)) + 0.9 * smoothstep(5.0, 0.5, before_track_m);
        let half_m = half_m.clamp(0.3, 2.2);
        // In places a second strand leaves and comes back.
        let second = smoothstep(0.0, 0.2, n(3, 60.0)) * strand(off_m - 9.0 * n(5, 38.0), 0.4);
        let cover = strand(off_m + 1.2 * n(7, 11.0), half_m).max(second) * begins;
        (cover, smoothstep(7.0, 0.5, off_m.abs()) * begins)
    }

    /// How far ways of all kinds wear the ground: 0.5 on their borders.
    pub(in super::super) fn worn(&self, p: DVec2, place: &Place) -> f64 {
        self.path(p, place).0.max(self.ruts(p, place)).max(self.wheels(p, place)).max(self.trail(p, place))
    }

    /// The track's two ruts, and where they run together.
    fn ruts(&self, p: DVec2, place: &Place) -> f64 {
        let off = place.inland_m - self.track_at_m(p);
        if off.abs() > 5.0 {
            return 0.0;
        }
        let n = |salt: u32, wavelength_m: f64| fractal(p, self.seeds.track ^ salt, wavelength_m, 3, 0.6);
        let off = off + 0.5 * n(1, 9.0);
        let ruts = strand(off - 0.9, 0.45 + 0.4 * n(2, 15.0)).max(strand(off + 0.9, 0.45 + 0.4 * n(3, 15.0)));
        let whole = strand(off, 1.45 + 0.8 * n(5, 7.0)) * smoothstep(-0.25, 0.2, n(4, 34.0));
        ruts.max(whole)
    }

    /// Marks of wheels along the upper beach.
    fn wheels(&self, p: DVec2, place: &Place) -> f64 {
        let f = &self.form;
        if self.cliffs || place.inland_m > f.toe_m || place.inland_m < 0.5 * f.toe_m {
            return 0.0;
        }
        let n = |salt: u32, wavelength_m: f64| fractal(p, self.seeds.track ^ salt, wavelength_m, 2, 0.5);
        let shown = smoothstep(-0.25, 0.1, n(0x31, 120.0));
        let off = place.inland_m - f.toe_m * (0.78 + 0.12 * n(0x32, 170.0));
        shown * strand(off - 1.0, 0.3).max(strand(off + 1.0, 0.3))
    }

    /// Trails of sheep over the land behind: they keep to one distance from the shore for a while, part and meet.
    fn trail(&self, p: DVec2, place: &Place) -> f64 {
        let begins_m = if self.cliffs { 14.0 + 0.4 * self.land_height_m } else { self.form.track_m + 25.0 };
        if place.inland_m < begins_m {
            return 0.0;
        }
        let seed = self.seeds.track;
        let kept = smoothstep(0.02, 0.2, fractal(p, seed ^ 0x41, 190.0, 2, 0.5));
        if kept == 0.0 {
            return 0.0;
        }
        let turns = |q: DVec2, inland_m: f64| inland_m / 58.0 + 2.2 * fractal(q, seed ^ 0x42, 150.0, 3, 0.4);
        let here = turns(p, place.inland_m);
        let off = here - libm::floor(here + 0.5);
        if off.abs() > 0.12 {
            return 0.0;
        }
        let beside = |side: DVec2| (turns(p + side, self.shore.at(p + side).inland_m) - here) / 0.5;
        let steep = DVec2::new(beside(DVec2::X * 0.5), beside(DVec2::Y * 0.5)).length();
        0.86 * kept * strand(off / steep.max(0.004), 0.35)
    }
}
