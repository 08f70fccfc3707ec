//! What covers the coast, post by post: the raster that its materials read, and the slot of a place.

use super::dress::coded_depth;
use super::relief::{Hinterland, Relief, Surface};
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::sampling::smoothstep;
use glam::DVec2;
use rayon::prelude::*;
use satseed_scene::{MaterialRaster, Raster};

/// Slots of the terrain's material set.
pub(super) mod slot {
    /// The sea.
    pub(in super::super) const WATER: u16 = 0;
    /// Beach and bare dunes.
    pub(in super::super) const SAND: u16 = 1;
    /// Marram, turf and heath.
    pub(in super::super) const TURF: u16 = 2;
    /// Rock.
    pub(in super::super) const ROCK: u16 = 3;
}

/// The only raster.
pub(super) const COVER: u32 = 0;

/// Channels of the cover.
pub(super) mod channel {
    /// Depth of the water: 0 on the surface to 1 at 14 m, as its square root.
    pub(in super::super) const DEPTH: u8 = 0;
    /// Fresh foam.
    pub(in super::super) const FOAM: u8 = 1;
    /// Old foam, in cells.
    pub(in super::super) const LACE: u8 = 2;
    /// Wet sand and rock; under turf, ground that lies wet.
    pub(in super::super) const WET: u8 = 3;
    /// Weed and rock on the bottom.
    pub(in super::super) const WEED: u8 = 4;
    /// Stirred sand in the water, around one half.
    pub(in super::super) const TURBID: u8 = 5;
    /// Plants that cover the sand.
    pub(in super::super) const MARRAM: u8 = 6;
    /// Turf.
    pub(in super::super) const TURF: u8 = 7;
    /// Heath and scrub among the turf.
    pub(in super::super) const HEATH: u8 = 8;
    /// Ways of feet and wheels: one half on their borders.
    pub(in super::super) const WORN: u8 = 9;
    /// What the tide left.
    pub(in super::super) const WRACK: u8 = 10;
    /// Patches of brightness around one half.
    pub(in super::super) const TONE: u8 = 11;
    /// Patches of hue around one half.
    pub(in super::super) const HUE: u8 = 12;
    /// Stains of a few metres around one half.
    pub(in super::super) const STAIN: u8 = 13;
    /// Sand rather than rock.
    pub(in super::super) const SANDY: u8 = 15;
    /// Shells and pebbles.
    pub(in super::super) const SHINGLE: u8 = 14;
}

/// Distance of the raster's posts, m.
const CELL_M: f64 = 1.0;

type Post = [u8; MaterialRaster::CHANNELS];

/// Names of the cover's noises.
pub(super) const NOISES: [&str; 12] =
    ["weed", "turbid", "marram", "turf", "heath", "tone", "hue", "stain", "shingle", "wrack", "wet", "clumps"];

/// The slot of dry ground whose unit normal rises by `up`.
pub(super) fn slot_of(relief: &Relief, p: DVec2, s: &Surface, up: f64) -> u16 {
    let [marram, turf] = plants(relief, p, s);
    if relief.is_rock(s, up) {
        slot::ROCK
    } else if marram.max(turf) > 0.5 {
        slot::TURF
    } else {
        slot::SAND
    }
}

/// How much marram and how much turf cover a place, 0 to 1.
pub(super) fn plants(relief: &Relief, p: DVec2, s: &Surface) -> [f64; 2] {
    let (z_m, inland_m, sandy) = (s.land_m, s.place.inland_m, s.place.sandy);
    let ragged = |k: usize, wavelength_m: f64| fractal(p, relief.cover_seeds[k], wavelength_m, 4, 0.65);
    if relief.cliffs {
        let beach = smoothstep(0.2, 0.8, sandy);
        let begin = 7.0 + 26.0 * beach;
        return [0.0, smoothstep(begin, begin + 5.0, inland_m + 6.0 * ragged(3, 16.0)) * smoothstep(1.6, 3.0, z_m)];
    }
    let (belt_m, bare) = relief.belt();
    let on = inland_m - relief.dune_toe_m(p) + 5.0 * ragged(11, 24.0);
    if on < -1.0 {
        return [0.0; 2];
    }
    // Sparse towards the sea, dense inland, gone where the wind has dug.
    let dense = smoothstep(-3.0, (0.9 * belt_m).clamp(20.0, 70.0), on);
    let thick = 0.24 + 0.9 * dense + 0.5 * ragged(2, 13.0) - 0.3 * bare * (1.0 - dense);
    let blown = relief.blowout(p) * smoothstep(1.5 * belt_m + 20.0, 0.7 * belt_m + 5.0, on);
    let marram = smoothstep(-1.0, 5.0, on) * thick.clamp(0.0, 1.0) * (1.0 - 0.95 * blown);
    let turf = smoothstep(0.45 * belt_m + 8.0, 1.1 * belt_m + 20.0, on + 0.3 * belt_m * ragged(3, 60.0))
        * smoothstep(-0.38, -0.10, ragged(3, 21.0) + 0.0016 * on)
        * (1.0 - 0.9 * blown);
    [marram, turf]
}

impl Relief {
    /// How much scrub or heath covers a place of the land behind, 0 to 1: masses of 10 to 60 m with uneven borders.
    pub(super) fn scrub(&self, p: DVec2) -> f64 {
        let least = match self.hinterland() {
            Hinterland::Turf => 0.30,
            Hinterland::Heath => -0.02,
            Hinterland::Rough => 0.42,
        };
        let seed = self.cover_seeds[4];
        let n = fractal(p, seed, 58.0, 5, 0.62) + 0.55 * fractal(p, seed ^ 1, 250.0, 2, 0.5);
        // Scrub likes hollows.
        smoothstep(least - 0.03, least + 0.09, n + 0.15 * self.damp(p))
    }
}

/// The raster that all materials read, over the whole scene.
pub(super) fn cover(relief: &Relief, half_m: f64) -> MaterialRaster {
    let n = (2.0 * half_m / CELL_M) as usize + 1;
    let shape = Raster::filled(DVec2::splat(-half_m), CELL_M, n, n, ());
    let rows: Vec<Vec<Post>> = (0..n)
        .into_par_iter()
        .map(|j| (0..n).map(|i| bake(relief, &relief.cover_seeds, shape.position(i, j))).collect())
        .collect();
    MaterialRaster::new(Raster { origin_m: shape.origin_m, cell_m: CELL_M, width: n, height: n, data: rows.concat() })
}

fn bake(relief: &Relief, seeds: &[u32; NOISES.len()], p: DVec2) -> Post {
    let s = relief.surface(p);
    let place = &s.place;
    let ragged = |k: usize, wavelength_m: f64| fractal(p, seeds[k], wavelength_m, 4, 0.65);
    let depth = (s.water_m - s.land_m).max(0.0);
    // Colour follows the mean depth: the swell's crests are no deeper than its troughs to the light that comes back.
    let still = (-s.land_m).max(depth.min(0.3));
    let [fresh, loose] = relief.foam(p, &s);
    let sandy = if relief.cliffs { smoothstep(0.2, 0.8, place.sandy) } else { 1.0 };
    let runup = relief.runup_m(p, place);
    let wet_to = runup + 0.30 + 0.25 * ragged(10, 30.0);
    let wet =
        smoothstep(wet_to + 0.10, wet_to - 0.04, s.land_m).max(0.75 * smoothstep(wet_to + 0.75, wet_to, s.land_m));
    // The edge of the last film of water: a thin line of foam, which lasts in places.
    let mut edge = smoothstep(0.10, 0.015, (s.land_m - runup).abs()) * sandy * f64::from(depth == 0.0);
    if edge > 0.0 {
        edge *= smoothstep(-0.30, 0.25, ragged(10, 24.0));
    }
    let [marram, turf] = plants(relief, p, &s);
    let rocky_bottom = smoothstep(
        0.1,
        0.45,
        fractal(p, seeds[0], 90.0, 4, 0.6)
            + 0.1 * ragged(0, 9.0)
            + if relief.cliffs { 0.45 * (1.0 - sandy) } else { -0.18 },
    );
    // Each tide leaves its line: unbroken curves, along the foreshore's cusps, thick and thin.
    let (berm_m, slope) = relief.berm();
    let [line, old_line] = [wet_to + 0.25, (wet_to + 0.75).min(0.93 * berm_m)].map(|z| {
        let off_m = (s.land_m - z - 0.06 * ragged(9, 14.0)).abs() / slope;
        smoothstep(1.5, 0.1, off_m) * (0.62 + 0.9 * ragged(9, 11.0)).clamp(0.12, 1.0) * f64::from(s.land_m < 6.0)
    });
    let berm_at_m = berm_m / slope;
    let on_berm = smoothstep(0.86, 1.04, place.inland_m / berm_at_m + 0.12 * ragged(10, 40.0)) - 0.5;
    let worn = relief.worn(p, place);
    let kept = 1.0 - smoothstep(0.42, 0.62, worn);
    let damp = if turf > 0.0 { turf * relief.damp(p) } else { 0.0 };
    let values = [
        coded_depth(still),
        fresh.max(edge),
        loose,
        (wet * f64::from(s.land_m < 6.0)).max(damp),
        rocky_bottom,
        0.5 + 0.5 * fractal(p, seeds[1], 75.0, 4, 0.6) + 0.35 * s.wave.map_or(0.0, |w| w.broken),
        marram * kept,
        turf * if relief.cliffs { 1.0 } else { kept },
        if turf > 0.0 { relief.scrub(p) } else { 0.0 },
        worn,
        line.max(0.7 * old_line) * sandy,
        0.5 + 0.5 * fractal(p, seeds[5], 24.0, 3, 0.5) + 0.55 * on_berm * sandy * (1.0 - turf),
        0.5 + 0.5 * fractal(p, seeds[6], 70.0, 3, 0.5),
        0.5 + 0.5 * fractal(p, seeds[7], 4.2, 2, 0.5),
        smoothstep(0.12, 0.5, ragged(8, 30.0) + 0.25 * smoothstep(4.0, 1.0, (s.land_m - 2.0).abs())),
        if relief.cliffs { place.sandy } else { 1.0 },
    ];
    let mut post = Post::default();
    for (channel, value) in post.iter_mut().zip(values) {
        *channel = (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    }
    post
}
