//! What broken waves leave: foam, and how far up the sand they ran.

use super::{Relief, Surface};
use crate::coast::shore::Place;
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::sampling::smoothstep;
use glam::DVec2;

impl Relief {
    /// How far up the last wave ran, m above the mean sea.
    pub(in super::super) fn runup_m(&self, p: DVec2, place: &Place) -> f64 {
        let lobes = fractal(DVec2::new(place.along_m, 0.0) + p * 0.15, self.seeds.cusps ^ 5, 42.0, 3, 0.5);
        (0.30 + 0.34 * self.swell_m) * (0.75 + 1.1 * lobes).clamp(0.15, 1.5)
    }

    /// Foam on the water: fresh and dense, and old and loose, 0 to 1 each.
    pub(in super::super) fn foam(&self, p: DVec2, s: &Surface) -> [f64; 2] {
        let Some(wave) = s.wave else { return [0.0; 2] };
        let depth = s.water_m - s.land_m;
        if depth <= 0.0 {
            return [0.0; 2];
        }
        let behind = 1.0 - wave.phase;
        // The crest's roller, its front, and what it leaves behind.
        let streaks = fractal(p, self.seeds.streaks, 5.0, 4, 0.65);
        let patches = fractal(p, self.seeds.patches, 26.0, 4, 0.6);
        let roller = smoothstep(0.10, 0.03, wave.phase).max(smoothstep(0.10, 0.02, behind));
        let trail = libm::exp(-behind / 0.20) * (0.75 + 1.3 * streaks);
        let mut fresh = wave.broken * roller.max(0.9 * trail);
        let mut loose =
            wave.broken * (0.25 + 0.55 * libm::exp(-behind / 0.5)) * smoothstep(-0.2, 0.3, patches + 0.3 * streaks);
        // Rock makes foam wherever it breaks the surface.
        let rocky = if self.cliffs { 1.0 - smoothstep(0.2, 0.8, s.place.sandy) } else { 0.0 };
        let washed = smoothstep(0.7, 0.05, depth) * rocky;
        fresh = fresh.max(washed * smoothstep(0.05, 0.45, 0.8 * streaks + 0.9 * patches + 0.12 * self.swell_m));
        loose = loose.max(smoothstep(3.2, 0.6, depth) * rocky * smoothstep(0.0, 0.4, patches) * 0.9);
        // The film that runs up the sand.
        fresh = fresh.max(smoothstep(0.12, 0.03, depth) * (1.0 - rocky) * smoothstep(-0.1, 0.3, streaks) * 0.8);
        [fresh.clamp(0.0, 1.0), loose.clamp(0.0, 1.0)]
    }
}
