//! Materials of the canyon: beds, soil, scree, sand, water.

use super::relief::Relief;
use super::strata::Strata;
use super::valley::{FOLD_LIMIT_M, Fold};
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::sampling::smoothstep;
use glam::DVec2;
use rayon::prelude::*;
use satseed_scene::{
    Bands, Brdf, Class, Coordinate, Field, Fractal, Layer, Material, MaterialRaster, Raster, SeedPath, Space,
};

/// Slots of the terrain's material set.
pub(super) mod slot {
    /// Bedrock.
    pub(in super::super) const ROCK: u16 = 0;
    /// Soil and scree.
    pub(in super::super) const GROUND: u16 = 1;
    /// Sand and gravel of the valley floor and of washes.
    pub(in super::super) const SAND: u16 = 2;
    /// The river.
    pub(in super::super) const WATER: u16 = 3;
}

/// Rasters by their index in the scene.
mod raster {
    /// One channel: the fold.
    pub(super) const FOLD: u32 = 0;
    /// All of [`super::channel`].
    pub(super) const COVER: u32 = 1;
}

/// Channels of the cover. What varies over two metres or more is worked out once, here, and not for every ray: a look at
/// all of the raster costs as much as one octave of noise.
mod channel {
    /// How much scree covers the rock.
    pub(super) const SCREE: u8 = 0;
    /// 8 m2 to 8,000 m2 of drainage area in equal steps of the logarithm.
    pub(super) const FLOW: u8 = 1;
    /// How much sand of the river covers the ground.
    pub(super) const SAND: u8 = 2;
    /// Below one half silt, above it cobbles.
    pub(super) const BARS: u8 = 3;
    /// One half at the bank, 1 six metres into the river.
    pub(super) const WET: u8 = 4;
    /// Dust and soil on slopes around one half.
    pub(super) const DUST: u8 = 5;
    /// Pockets of pale sand on level rock.
    pub(super) const POCKETS: u8 = 6;
    /// Dark crust on level soil.
    pub(super) const CRUST: u8 = 7;
    /// Patches of brightness around one half.
    pub(super) const TONE: u8 = 8;
    /// Patches of hue around one half.
    pub(super) const HUE: u8 = 9;
    /// Wobble of the beds around one half.
    pub(super) const BEDDING: u8 = 10;
    /// Stains of two or three metres around one half.
    pub(super) const STAIN: u8 = 11;
    /// The river's own patches around one half.
    pub(super) const TURBID: u8 = 12;
    /// Where the river's bed shows through, around one half.
    pub(super) const SHALLOWS: u8 = 13;
}

/// Distance of the rasters' posts, m.
const CELL_M: f64 = 1.0;
/// Within this distance of the rasters' border all values go over into neutral ones: beyond it they are repeated.
const TAPER_M: f64 = 24.0;

/// The rasters that the materials read, in the order of their indices.
pub(super) fn rasters(fold: &Fold, relief: &Relief<'_>, scene_half_m: f64, path: &SeedPath) -> Vec<MaterialRaster> {
    let names = [
        "scree",
        "sand",
        "silt",
        "cobbles",
        "wash",
        "dust",
        "pockets",
        "crust",
        "crust patch",
        "tone",
        "hue",
        "bedding",
        "stain",
        "turbid",
        "shallows",
    ];
    let seeds = names.map(|name| path.child(name).hash_u32());
    let half_m = -relief.window.origin_m.x;
    let n = (2.0 * half_m / CELL_M) as usize + 1;
    let shape = Raster::filled(DVec2::splat(-half_m), CELL_M, n, n, ());
    let rows: Vec<Vec<Post>> = (0..n)
        .into_par_iter()
        .map(|j| (0..n).map(|i| bake(relief, &seeds, shape.position(i, j), half_m)).collect())
        .collect();
    let cover = Raster { origin_m: shape.origin_m, cell_m: CELL_M, width: n, height: n, data: rows.concat() };
    vec![MaterialRaster::new(folds(fold, scene_half_m)), MaterialRaster::new(cover)]
}

/// All channels of one post, in 255ths.
type Post = [u8; MaterialRaster::CHANNELS];

fn folds(fold: &Fold, scene_half_m: f64) -> Raster<Post> {
    const FOLD_CELL_M: f64 = 32.0;
    let n = (2.0 * scene_half_m / FOLD_CELL_M) as usize + 3;
    let mut folds = Raster::filled(DVec2::splat(-scene_half_m - FOLD_CELL_M), FOLD_CELL_M, n, n, Post::default());
    for j in 0..n {
        for i in 0..n {
            let value = fold.at(folds.position(i, j)) / (2.0 * FOLD_LIMIT_M) + 0.5;
            let mut post = Post::default();
            post[0] = (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
            folds.set(i, j, post);
        }
    }
    folds
}

/// The cover's channels at a place.
fn bake(relief: &Relief<'_>, seeds: &[u32; 15], p: DVec2, half_m: f64) -> Post {
    let cover = relief.cover(p);
    // Ragged outlines: octaves that hardly fade.
    let ragged = |k: usize, wavelength_m: f64| fractal(p, seeds[k], wavelength_m, 5, 0.72);
    let soft = |k: usize, wavelength_m: f64| fractal(p, seeds[k], wavelength_m, 3, 0.5);
    let hollow = relief.hollow(p);
    let scree =
        smoothstep(0.04, 0.5, cover.scree_m / 1.6 + ragged(0, 6.0) * 0.40 * smoothstep(0.0, 0.2, cover.scree_m));
    let flow = libm::log10((cover.area_m2 / 8.0).max(1.0)) / 3.0 + ragged(4, 7.0) * 0.10;
    let sand = smoothstep(0.45, 0.75, 1.0 - smoothstep(5.0, 45.0, cover.bank_m) + ragged(1, 14.0) * 0.35);
    let silt = smoothstep(0.0, 0.3, ragged(2, 12.0)) * smoothstep(0.2, 0.8, sand);
    let cobbles = smoothstep(0.05, 0.4, ragged(3, 15.0)) * smoothstep(9.0, 0.5, cover.bank_m);
    let dust = 0.5 + 0.30 * ragged(5, 11.0) + 0.75 * hollow;
    let pockets = smoothstep(-0.02, 0.35, ragged(6, 16.0) * 0.8 + hollow * 2.4);
    let crust = smoothstep(0.05, 0.40, ragged(7, 9.0)) * smoothstep(-0.2, 0.2, soft(8, 55.0));
    let tone = 0.5 + 0.5 * soft(9, 24.0);
    let hue = 0.5 + 0.5 * soft(10, 60.0);
    let around =
        |k: usize, wavelength_m: f64, octaves: u32| 0.5 + 0.5 * fractal(p, seeds[k], wavelength_m, octaves, 0.5);
    let inward = half_m - p.abs().max_element();
    let w = smoothstep(0.0, TAPER_M, inward - 1.0);
    let values = [
        (scree, 0.0),
        (flow, 0.0),
        (sand, 0.0),
        (0.5 + 0.5 * (cobbles - silt * (1.0 - cobbles)), 0.5),
        (0.5 - cover.bank_m / 12.0, 0.0),
        (dust, 0.5),
        (pockets, 0.4),
        (crust, 0.2),
        (tone, 0.5),
        (hue, 0.5),
        (around(11, 5.0, 2), 0.5),
        (around(12, 2.6, 1), 0.5),
        (around(13, 26.0, 4), 0.5),
        (around(14, 9.0, 3), 0.5),
    ];
    let mut post = Post::default();
    for (channel, (value, neutral)) in post.iter_mut().zip(values) {
        *channel = ((neutral + (value.clamp(0.0, 1.0) - neutral) * w) * 255.0 + 0.5) as u8;
    }
    post
}

/// The terrain's materials by slot.
pub(super) fn materials(strata: &Strata, is_dry: bool, contrast: f64, path: &SeedPath) -> Vec<Material> {
    let seed = |name: &str| path.child(name).hash_u32();
    let k = contrast as f32;
    let noise = |name: &str, wavelength_m: f32, octaves: u8| Field::world_noise(seed(name), wavelength_m, octaves);
    let product = |fields: Vec<Field>| Field::Product(fields);
    let raster = |channel: u8| Field::Raster { raster: raster::COVER, channel };
    let fold = Field::Raster { raster: raster::FOLD, channel: 0 };
    let bedding = Field::Sum(vec![
        Field::Along(Coordinate::HEIGHT),
        fold.affine(-2.0 * FOLD_LIMIT_M as f32, FOLD_LIMIT_M as f32),
        raster(channel::BEDDING).affine(1.5, -0.75),
    ]);
    let debris = Field::Sum(vec![
        bedding.clone(),
        raster(channel::TONE).affine(22.0, -4.0),
        raster(channel::STAIN).affine(5.0, -2.5),
    ]);
    let level = || Field::Upward.ramp(0.82, 0.95);
    // Streaks start at seeps and ledges and run some metres down: fields stretched along the height, each with ends of its
    // own, within patches of wetter wall.
    let streaks =
        Field::Noise(Fractal::new(Space::World, seed("streaks"), 1.2, 3).gain(0.7).stretched([1.0, 1.0, 7.0]));
    let seeps = Field::Noise(Fractal::new(Space::World, seed("seeps"), 9.0, 3).gain(0.7).stretched([1.0, 1.0, 0.7]));
    let cracks = Field::Noise(Fractal::new(Space::World, seed("cracks"), 0.9, 3).gain(0.8).stretched([1.0, 1.0, 2.6]));
    let stony = Field::Max(vec![raster(channel::SCREE), Field::Upward.ramp(0.97, 0.8).times(0.6)]);

    let soil = Bands::new(0.112, 0.150, 0.208, 0.29);
    let pale_soil = Bands::new(0.150, 0.192, 0.250, 0.32);
    let rubble = Bands::new(0.122, 0.152, 0.190, 0.26);
    let crust = Bands::new(0.080, 0.096, 0.122, 0.19);
    let varnished = Bands::new(0.065, 0.075, 0.095, 0.15);
    let sand = Bands::new(0.178, 0.226, 0.280, 0.35);
    let silt = Bands::new(0.135, 0.165, 0.200, 0.26);
    let cobbles = Bands::new(0.120, 0.140, 0.160, 0.21);

    // In products the cheap masks stand first: where they are zero nothing behind them is evaluated.
    let bare = Material::diffuse("rock", Class::Rock, strata.mean_color())
        .rough(0.4)
        .with(Layer::Strata { beds: strata.colors(), height: bedding, amount: Field::Constant(1.0) })
        // Debris of the beds above lies on slopes, in tongues that reach down unevenly.
        .with(Layer::Strata { beds: strata.colors(), height: debris, amount: Field::Upward.ramp(0.5, 0.72).times(0.5) })
        // Slopes are dusted over with what falls on them, and lose some of their beds' colour; hollows more than ribs.
        .with(Layer::Mix {
            color: soil,
            amount: product(vec![
                Field::Upward.ramp(0.5, 0.7),
                Field::Sum(vec![Field::Upward.ramp(0.60, 0.98).times(0.32), raster(channel::DUST).affine(1.2, -0.36)]),
            ]),
        })
        .with(Layer::Mix {
            color: varnished,
            amount: product(vec![Field::Upward.ramp(0.62, 0.3), seeps.ramp(-0.2, 0.25), streaks.ramp(-0.1, 0.28)])
                .times(0.60),
        })
        .with(Layer::Mix {
            color: rubble,
            amount: product(vec![Field::Upward.ramp(0.6, 0.75), raster(channel::SCREE)]).times(0.55),
        })
        // Stones: light and dark specks on scree and on stony slopes.
        .with(Layer::Brightness {
            amount: product(vec![
                stony,
                Field::Noise(Fractal::new(Space::World, seed("stones"), 1.8, 3).gain(0.85)).times(0.36 * k),
            ]),
        })
        // On level rock, pockets of pale sand in the hollows, dark crust around them, bare ribs between.
        .with(Layer::Mix { color: pale_soil, amount: product(vec![level(), raster(channel::POCKETS)]).times(0.7) })
        .with(Layer::Mix { color: crust, amount: product(vec![level(), raster(channel::CRUST)]).times(0.5) })
        // Rills are darker where they are damp, and sandy where they are large.
        .with(Layer::Brightness { amount: raster(channel::FLOW).ramp(0.25, 0.55).times(-0.16 * k) })
        .with(Layer::Mix { color: sand, amount: raster(channel::FLOW).ramp(0.74, 0.92).times(0.6) })
        .with(Layer::Mix {
            color: sand,
            amount: product(vec![Field::Upward.ramp(0.85, 0.95), raster(channel::SAND)]).times(0.85),
        })
        .with(Layer::Mix { color: silt, amount: raster(channel::BARS).ramp(0.5, 0.0).times(0.7) })
        .with(Layer::Mix { color: cobbles, amount: raster(channel::BARS).ramp(0.5, 1.0).times(0.75) })
        // Three scales: patches, stains, grain.
        .with(Layer::Brightness { amount: raster(channel::TONE).affine(0.24 * k, -0.12 * k) })
        .with(Layer::Brightness { amount: raster(channel::STAIN).affine(0.44 * k, -0.22 * k) })
        .with(Layer::Brightness {
            amount: Field::Noise(Fractal::new(Space::World, seed("grain"), 1.25, 2).gain(1.2)).times(0.22 * k),
        })
        // Cracks: dark specks on steep rock.
        .with(Layer::Brightness {
            amount: product(vec![Field::Upward.ramp(0.80, 0.55), cracks.ramp(0.10, 0.45)]).times(-0.30 * k),
        })
        .with(Layer::Tint {
            tint: Bands::new(-0.6, -0.1, 0.5, 0.5),
            amount: raster(channel::HUE).affine(0.2 * k, -0.1 * k),
        })
        .with(Layer::Brightness {
            amount: raster(channel::WET).ramp(0.2, 0.46).times(if is_dry { 0.14 } else { -0.36 }),
        })
        .bumpy(Field::Noise(Fractal::new(Space::World, seed("bump"), 1.7, 2).gain(0.8)), 0.09);
    let as_class = |name: &str, class: Class| Material { name: name.to_owned(), class, ..bare.clone() };
    let water = Material {
        brdf: Brdf::Coated { index: 1.33 },
        ..Material::diffuse("river", Class::Water, Bands::new(0.046, 0.068, 0.062, 0.028))
            .with(Layer::Mix {
                color: Bands::new(0.085, 0.112, 0.118, 0.06),
                amount: Field::Sum(vec![raster(channel::WET), raster(channel::SHALLOWS).affine(0.2, -0.1)])
                    .ramp(0.85, 0.5),
            })
            .with(Layer::Brightness { amount: raster(channel::TURBID).affine(0.44 * k, -0.22 * k) })
            .bumpy(noise("ripples", 0.8, 2), 0.012)
    };
    vec![bare.clone(), as_class("soil and scree", Class::Ground), as_class("wash sand", Class::Sand), water]
}
