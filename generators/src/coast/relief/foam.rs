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
        let streaks = fractal(p, self.seeds.streaks, 5.0, 4, 0.65);
        let patches = fractal(p, self.seeds.patches, 26.0, 4, 0.6);
        // The roller: as wide as its wave is high over the shallows, and nothing where the crest does not break.
        let strong = smoothstep(0.92, 1.9, wave.over);
        let lobes = (0.9 + 1.5 * fractal(p, self.seeds.patches ^ 1, 17.0, 3, 0.6)).clamp(0.25, 1.8);
        let wide_m = (strong * lobes * (0.5 + 6.0 * wave.height_m)).clamp(0.02, 8.0);
        let behind_m = (1.0 - wave.phase) * wave.length_m;
        let ahead_m = wave.phase * wave.length_m;
        let off = (behind_m / (0.65 * wide_m)).min(ahead_m / (0.35 * wide_m));
        let mut fresh = smoothstep(1.25, 0.55, off + 0.6 * streaks) * (wide_m / 1.5).min(1.0);
        // What it leaves fades within 10 to 25 m and tears into cells; some drifts on between the waves.
        let fades_m = 4.0 + 5.0 * lobes;
        let left = libm::exp(-behind_m / fades_m).max(libm::exp(-ahead_m / (0.15 * fades_m)));
        let torn = smoothstep(-0.40, 0.30, patches + 0.45 * streaks);
        let mut loose = smoothstep(0.75, 1.6, wave.over) * (0.18 + 0.82 * left) * torn;
        // Rock makes foam wherever it breaks the surface.
        let rocky = if self.cliffs { 1.0 - smoothstep(0.2, 0.8, s.place.sandy) } else { 0.0 };
        let washed = smoothstep(0.7, 0.05, depth) * rocky;
        fresh = fresh.max(washed * smoothstep(0.05, 0.45, 0.8 * streaks + 0.9 * patches + 0.12 * self.swell_m));
        loose = loose.max(smoothstep(3.2, 0.6, depth) * rocky * smoothstep(-0.1, 0.4, patches) * 0.9);
        // The film that runs up the sand.
        fresh = fresh.max(smoothstep(0.12, 0.03, depth) * (1.0 - rocky) * smoothstep(-0.1, 0.3, streaks) * 0.6);
        [fresh.clamp(0.0, 1.0), loose.clamp(0.0, 1.0)]
    }
}
