//! Materials of the forest floor: litter, needles, grass, track, felled ground, water.

use super::growth::Growth;
use super::land::Land;
use super::stands::{Kind, Stands};
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::sampling::smoothstep;
use glam::DVec2;
use rayon::prelude::*;
use satseed_scene::{Bands, Brdf, Class, Field, Fractal, Layer, Material, MaterialRaster, Raster, SeedPath, Space};

/// Slots of the terrain's material set.
mod slot {
    /// Litter and soil.
    pub(super) const FLOOR: u16 = 0;
    /// Grass and herbs.
    pub(super) const GRASS: u16 = 1;
    /// The track's carriageway.
    pub(super) const TRACK: u16 = 2;
    /// Streams.
    pub(super) const WATER: u16 = 3;
}

/// The only raster.
const COVER: u32 = 0;

/// Channels of the cover.
mod channel {
    /// Needles among the litter.
    pub(super) const NEEDLES: u8 = 0;
    /// Grass and herbs.
    pub(super) const GRASS: u8 = 1;
    /// Whether the track is near.
    pub(super) const TRACK: u8 = 2;
    /// Distance from the track's middle, signed, 0 to 1 over [`super::TRACK_REACH_M`] on both sides.
    pub(super) const ACROSS: u8 = 3;
    /// Wet soil and moss.
    pub(super) const WET: u8 = 4;
    /// Bare and felled ground.
    pub(super) const CUT: u8 = 5;
    /// Patches of brightness around one half.
    pub(super) const TONE: u8 = 6;
    /// Patches of hue around one half.
    pub(super) const HUE: u8 = 7;
    /// Stains of a few metres around one half.
    pub(super) const STAIN: u8 = 8;
    /// Bare soil in patches.
    pub(super) const BARE: u8 = 9;
    /// Dry grass among the grass.
    pub(super) const DRY: u8 = 10;
    /// Bracken and brambles.
    pub(super) const HERBS: u8 = 11;
}

/// Distance of the raster's posts, m.
const CELL_M: f64 = 1.0;
/// How far the raster tells the distance from the track, m.
const TRACK_REACH_M: f64 = 5.0;

type Post = [u8; MaterialRaster::CHANNELS];

/// The slot of the ground at a place.
pub(super) fn slot_at(land: &Land, stands: &Stands, p: DVec2) -> u16 {
    if land.track.beyond_m(p) < -0.25 {
        slot::TRACK
    } else if land.streams.beyond_m(p) < 0.0 {
        slot::WATER
    } else if land.rides.beyond_m(p) < 0.0 || stands.outside_m(p) < -1.5 {
        slot::GRASS
    } else {
        slot::FLOOR
    }
}

/// The raster that all materials read, over the whole scene.
pub(super) fn cover(land: &Land, stands: &Stands, growth: &Growth, half_m: f64, path: &SeedPath) -> MaterialRaster {
    let names = ["tone", "hue", "stain", "bare", "dry", "herbs", "grass"];
    let seeds = names.map(|name| path.child(name).hash_u32());
    let n = (2.0 * half_m / CELL_M) as usize + 1;
    let shape = Raster::filled(DVec2::splat(-half_m), CELL_M, n, n, ());
    let rows: Vec<Vec<Post>> = (0..n)
        .into_par_iter()
        .map(|j| (0..n).map(|i| bake(land, stands, growth, &seeds, shape.position(i, j))).collect())
        .collect();
    MaterialRaster::new(Raster { origin_m: shape.origin_m, cell_m: CELL_M, width: n, height: n, data: rows.concat() })
}

fn bake(land: &Land, stands: &Stands, growth: &Growth, seeds: &[u32; 7], p: DVec2) -> Post {
    let stand = stands.at(p);
    let ragged = |k: usize, wavelength_m: f64| fractal(p, seeds[k], wavelength_m, 4, 0.65);
    let light = growth.light(p);
    let cut = f64::from(u8::from(stand.kind == Kind::Cut));
    let track = land.track.near(p);
    let ride = smoothstep(1.2, -0.3, land.rides.beyond_m(p));
    let verge = track.map_or(0.0, |t| smoothstep(7.0, 3.0, t.offset_m.abs()));
    let open = smoothstep(0.5, -2.5, stands.outside_m(p));
    let wet = land.wetness(p);
    let grass = (open * (0.7 + 0.3 * light)).max(ride).max(0.75 * verge).max(cut * 0.55).max(0.6 * (light - 0.35))
        + 0.35 * ragged(6, 6.0) * smoothstep(0.05, 0.3, light);
    let values = [
        stand.conifers(),
        grass,
        track.map_or(0.0, |t| smoothstep(TRACK_REACH_M, 3.0, t.offset_m.abs())),
        track.map_or(1.0, |t| 0.5 + 0.5 * t.offset_m / TRACK_REACH_M),
        smoothstep(0.45, 0.95, wet + 0.25 * ragged(2, 8.0)),
        cut * smoothstep(-0.3, 0.3, ragged(3, 5.0) + 0.1),
        0.5 + 0.5 * fractal(p, seeds[0], 22.0, 3, 0.5),
        0.5 + 0.5 * fractal(p, seeds[1], 48.0, 3, 0.5),
        0.5 + 0.5 * fractal(p, seeds[2], 3.6, 2, 0.5),
        smoothstep(0.25, 0.55, ragged(3, 4.5)),
        smoothstep(-0.2, 0.4, ragged(4, 9.0) - 0.3 * (wet - 0.4)),
        smoothstep(0.0, 0.4, ragged(5, 7.0)) * smoothstep(0.05, 0.4, light),
    ];
    let mut post = Post::default();
    for (channel, value) in post.iter_mut().zip(values) {
        *channel = (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    }
    post
}

/// The terrain's materials by slot.
pub(super) fn materials(contrast: f64, path: &SeedPath) -> Vec<Material> {
    let seed = |name: &str| path.child(name).hash_u32();
    let k = contrast as f32;
    let mut rng = path.child("palette").rng();
    let mut vary = |c: Bands| c * rng.range(0.88, 1.12) as f32;
    let litter = vary(Bands::new(0.043, 0.060, 0.072, 0.17));
    let needles = vary(Bands::new(0.035, 0.046, 0.055, 0.13));
    let grass = vary(Bands::new(0.040, 0.078, 0.060, 0.34));
    let dry = vary(Bands::new(0.052, 0.090, 0.090, 0.30));
    let herbs = vary(Bands::new(0.032, 0.070, 0.044, 0.36));
    let soil = vary(Bands::new(0.060, 0.082, 0.106, 0.17));
    let gravel = vary(Bands::new(0.080, 0.100, 0.106, 0.19));
    let slash = vary(Bands::new(0.096, 0.118, 0.124, 0.22));
    let moss = Bands::new(0.030, 0.062, 0.044, 0.26);
    // Every colour stands as far from the litter's as the contrast says.
    let apart = |c: Bands| litter.lerp(c, k.min(1.0));
    let raster = |channel: u8| Field::Raster { raster: COVER, channel };
    let product = Field::Product;
    let noise = |name: &str, wavelength_m: f32, octaves: u8, gain: f32| {
        Field::Noise(Fractal::new(Space::Plan, seed(name), wavelength_m, octaves).gain(gain))
    };
    let ground = |name: &str, class: Class| {
        Material::diffuse(name, class, litter)
            .rough(0.4)
            .with(Layer::Mix { color: apart(needles), amount: raster(channel::NEEDLES) })
            .with(Layer::Mix { color: apart(soil), amount: raster(channel::BARE).times(0.5) })
            .with(Layer::Mix { color: apart(moss), amount: raster(channel::WET).times(0.6) })
            .with(Layer::Mix { color: apart(slash), amount: raster(channel::CUT).times(0.7) })
            .with(Layer::Mix {
                color: apart(grass),
                amount: product(vec![
                    raster(channel::GRASS),
                    Field::Sum(vec![Field::Constant(0.85), noise("tufts", 1.4, 3, 0.8).times(0.6)]),
                ]),
            })
            .with(Layer::Mix {
                color: apart(dry),
                amount: product(vec![raster(channel::GRASS), raster(channel::DRY)]).times(0.6),
            })
            .with(Layer::Mix { color: apart(herbs), amount: raster(channel::HERBS).times(0.55) })
            .with(Layer::Brightness { amount: raster(channel::TONE).affine(0.28 * k, -0.14 * k) })
            .with(Layer::Brightness { amount: raster(channel::STAIN).affine(0.30 * k, -0.15 * k) })
            .with(Layer::Tint {
                tint: Bands::new(-0.5, 0.0, 0.6, 0.2),
                amount: raster(channel::HUE).affine(0.3 * k, -0.15 * k),
            })
            .with(Layer::Brightness { amount: noise("grain", 1.3, 3, 0.95).times(0.30 * k) })
            .bumpy(noise("bumps", 1.2, 2, 0.8), 0.07 * k)
    };
    // Ruts at 0.82 m on both sides of the middle; grass between and beside them.
    let across = |from: f32, to: f32| {
        let reach = TRACK_REACH_M as f32;
        let side = |s: f32| raster(channel::ACROSS).affine(2.0 * reach * s, -reach * s).ramp(from, to);
        Field::Max(vec![side(1.0), side(-1.0)])
    };
    let worn = product(vec![
        raster(channel::TRACK),
        across(0.25, 0.5),
        Field::Sum(vec![Field::Constant(1.0), across(1.15, 1.9).times(-0.8)]),
        Field::Sum(vec![Field::Constant(0.55), noise("wear", 5.0, 4, 0.75).times(1.3)]),
    ]);
    let track =
        ground("forest track", Class::Road).with(Layer::Mix { color: apart(gravel), amount: worn }).with(Layer::Mix {
            color: apart(soil * 0.75),
            amount: product(vec![raster(channel::TRACK), noise("puddles", 3.0, 2, 0.6).ramp(0.25, 0.5)]).times(0.5),
        });
    let water = Material {
        brdf: Brdf::Coated { index: 1.33 },
        ..Material::diffuse("stream", Class::Water, Bands::new(0.028, 0.038, 0.038, 0.02))
            .with(Layer::Brightness { amount: noise("bed", 1.6, 3, 0.8).times(0.5 * k) })
            .bumpy(noise("ripples", 0.7, 2, 0.6), 0.012 * k)
    };
    vec![ground("litter", Class::Ground), ground("grass", Class::LowVegetation), track, water]
}
