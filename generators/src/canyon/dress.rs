//! Materials of the canyon: beds, soil, scree, sand, water.

use super::relief::{Relief, Worn};
use super::strata::Strata;
use super::valley::{FOLD_LIMIT_M, Fold};
use crate::kit::terrain::sampling::smoothstep;
use glam::DVec2;
use satseed_scene::{Bands, Brdf, Class, Coordinate, Field, Layer, Material, MaterialRaster, Raster, SeedPath, Space};

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
    pub(super) const FOLD: u32 = 0;
    pub(super) const SCREE: u32 = 1;
    pub(super) const FLOW: u32 = 2;
    pub(super) const SAND: u32 = 3;
    pub(super) const WET: u32 = 4;
    pub(super) const HOLLOW: u32 = 5;
}

/// Thickness of scree that the raster's 1 stands for, m.
const SCREE_SCALE_M: f64 = 1.6;

/// The rasters that the materials read, in the order of their indices.
pub(super) fn rasters(fold: &Fold, relief: &Relief<'_>, scene_half_m: f64) -> Vec<MaterialRaster> {
    const FOLD_CELL_M: f64 = 32.0;
    let n = (2.0 * scene_half_m / FOLD_CELL_M) as usize + 3;
    let mut folds = Raster::filled(DVec2::splat(-scene_half_m - FOLD_CELL_M), FOLD_CELL_M, n, n, 0.0_f32);
    for j in 0..n {
        for i in 0..n {
            let value = fold.at(folds.position(i, j)) / (2.0 * FOLD_LIMIT_M) + 0.5;
            folds.set(i, j, value as f32);
        }
    }
    let Worn { scree_m, area_m2, bank_m, .. } = &relief.worn;
    let of = |source: &Raster<f32>, f: &dyn Fn(f64) -> f64| {
        let data = source.data.iter().map(|v| f(f64::from(*v)) as f32).collect();
        MaterialRaster::new(&Raster { data, ..source.clone() })
    };
    vec![
        MaterialRaster::new(&folds),
        of(scree_m, &|t| t / SCREE_SCALE_M),
        // 8 m2 to 8,000 m2 in equal steps of the logarithm.
        of(area_m2, &|a| libm::log10(a / 8.0) / 3.0),
        of(bank_m, &|b| 1.0 - smoothstep(5.0, 45.0, b)),
        // One half at the bank, 1 six metres into the river.
        of(bank_m, &|b| 0.5 - b / 12.0),
        MaterialRaster::new(&relief.hollows()),
    ]
}

/// The terrain's materials by slot.
pub(super) fn materials(strata: &Strata, is_dry: bool, contrast: f64, path: &SeedPath) -> Vec<Material> {
    let seed = |name: &str| path.child(name).hash_u32();
    let k = contrast as f32;
    let noise = |name: &str, wavelength_m: f32, octaves: u8| Field::world_noise(seed(name), wavelength_m, octaves);
    // Ragged outlines: octaves that hardly fade.
    let ragged = |name: &str, wavelength_m: f32| Field::Noise {
        space: Space::World,
        seed: seed(name),
        wavelength_m,
        octaves: 6,
        gain: 0.72,
        stretch: [1.0; 3],
    };
    let product = |fields: Vec<Field>| Field::Product(fields);

    let bedding = Field::Sum(vec![
        Field::Along(Coordinate::HEIGHT),
        Field::Raster(raster::FOLD).affine(-2.0 * FOLD_LIMIT_M as f32, FOLD_LIMIT_M as f32),
        noise("bedding", 16.0, 4).times(0.45),
    ]);
    let steep = || Field::Upward.ramp(0.80, 0.55);
    let flat = || Field::Upward.ramp(0.82, 0.95);
    let hollow = || Field::Raster(raster::HOLLOW);
    let streaks = Field::Noise {
        space: Space::World,
        seed: seed("streaks"),
        wavelength_m: 1.6,
        octaves: 3,
        gain: 0.6,
        stretch: [1.0, 1.0, 14.0],
    };
    let varnish = product(vec![
        streaks.ramp(0.0, 0.35),
        noise("varnish", 30.0, 2).ramp(-0.2, 0.25),
        Field::Upward.ramp(0.62, 0.3),
    ]);
    let scree = || Field::Sum(vec![Field::Raster(raster::SCREE), ragged("scree edge", 6.0).times(0.40)]);
    let sandy = || Field::Sum(vec![Field::Raster(raster::SAND), ragged("sand edge", 14.0).times(0.35)]);

    let soil = Bands::new(0.112, 0.150, 0.208, 0.29);
    let pale_soil = Bands::new(0.150, 0.192, 0.250, 0.32);
    let rubble = Bands::new(0.122, 0.152, 0.190, 0.26);
    let crust = Bands::new(0.080, 0.096, 0.122, 0.19);
    let varnished = Bands::new(0.065, 0.075, 0.095, 0.15);
    let sand = Bands::new(0.178, 0.226, 0.280, 0.35);
    let silt = Bands::new(0.135, 0.165, 0.200, 0.26);
    let cobbles = Bands::new(0.120, 0.140, 0.160, 0.21);

    let bare = Material::diffuse("rock", Class::Rock, strata.mean_color())
        .rough(0.4)
        .with(Layer::Strata { beds: strata.colors(), height: bedding, amount: Field::Constant(1.0) })
        // Slopes are dusted over with what falls on them, and lose some of their beds' colour; hollows more than ribs.
        .with(Layer::Mix {
            color: soil,
            amount: product(vec![
                Field::Sum(vec![
                    Field::Upward.ramp(0.60, 0.98).times(0.50),
                    ragged("dust", 11.0).times(0.30),
                    hollow().affine(0.9, -0.45),
                ]),
                Field::Upward.ramp(0.5, 0.7),
            ]),
        })
        .with(Layer::Mix { color: varnished, amount: varnish.times(0.62) })
        .with(Layer::Mix {
            color: rubble,
            amount: product(vec![scree().ramp(0.05, 0.6), Field::Upward.ramp(0.6, 0.75)]).times(0.55),
        })
        // Stones: light and dark specks on scree and on stony slopes.
        .with(Layer::Brightness {
            amount: product(vec![
                Field::Sum(vec![scree().ramp(0.0, 0.5).times(0.8), Field::Upward.ramp(0.97, 0.8).times(0.5)]),
                ragged("stones", 1.5).times(0.30 * k),
            ]),
        })
        // On level rock, pockets of pale sand in the hollows, dark crust around them, bare ribs between.
        .with(Layer::Mix {
            color: pale_soil,
            amount: product(vec![
                flat(),
                Field::Sum(vec![ragged("pockets", 16.0).times(0.8), hollow().affine(2.4, -1.2)]).ramp(-0.02, 0.35),
            ])
            .times(0.7),
        })
        .with(Layer::Mix {
            color: crust,
            amount: product(vec![
                flat(),
                ragged("crust", 9.0).ramp(0.05, 0.40),
                noise("crust patch", 55.0, 2).ramp(-0.2, 0.2),
            ])
            .times(0.5),
        })
        .with(Layer::Brightness {
            amount: product(vec![
                flat(),
                Field::Warped {
                    of: Box::new(Field::Cracks {
                        space: Space::World,
                        seed: seed("joints"),
                        cell_m: 17.0,
                        width_m: 0.5,
                    }),
                    seed: seed("joint warp"),
                    wavelength_m: 9.0,
                    amplitude_m: 1.6,
                },
                noise("joint fade", 40.0, 2).ramp(-0.1, 0.2),
            ])
            .times(-0.28 * k),
        })
        // Rills are darker where they are damp, and sandy where they are large.
        .with(Layer::Brightness { amount: Field::Raster(raster::FLOW).ramp(0.25, 0.55).times(-0.10 * k) })
        .with(Layer::Mix {
            color: sand,
            amount: Field::Sum(vec![Field::Raster(raster::FLOW), ragged("wash edge", 7.0).times(0.12)])
                .ramp(0.74, 0.92)
                .times(0.6),
        })
        .with(Layer::Mix {
            color: sand,
            amount: product(vec![sandy().ramp(0.45, 0.75), Field::Upward.ramp(0.85, 0.95)]).times(0.85),
        })
        .with(Layer::Mix {
            color: silt,
            amount: product(vec![ragged("silt", 12.0).ramp(0.0, 0.3), sandy().ramp(0.5, 0.9)]).times(0.7),
        })
        .with(Layer::Mix {
            color: cobbles,
            amount: product(vec![ragged("cobbles", 15.0).ramp(0.05, 0.4), Field::Raster(raster::WET).ramp(0.0, 0.45)])
                .times(0.75),
        })
        // Three scales: patches, stains, grain.
        .with(Layer::Brightness { amount: noise("patch", 24.0, 3).times(0.12 * k) })
        .with(Layer::Brightness { amount: noise("stain", 2.6, 3).times(0.10 * k) })
        .with(Layer::Brightness { amount: noise("grain", 0.55, 2).times(0.16 * k) })
        // Cracks: dark specks on steep rock.
        .with(Layer::Brightness {
            amount: product(vec![noise("cracks", 1.1, 3).ramp(0.12, 0.4), steep()]).times(-0.35 * k),
        })
        .with(Layer::Tint { tint: Bands::new(-0.6, -0.1, 0.5, 0.5), amount: noise("hue", 60.0, 3).times(0.10 * k) })
        .with(Layer::Brightness {
            amount: Field::Raster(raster::WET).ramp(0.38, 0.5).times(if is_dry { -0.10 } else { -0.36 }),
        })
        .bumpy(noise("bump", 0.9, 3), 0.06);
    let as_class = |name: &str, class: Class| Material { name: name.to_owned(), class, ..bare.clone() };
    let shallows = Field::Sum(vec![Field::Raster(raster::WET), ragged("shallows", 14.0).times(0.10)]);
    let water = Material {
        brdf: Brdf::Coated { index: 1.33 },
        ..Material::diffuse("river", Class::Water, Bands::new(0.046, 0.068, 0.062, 0.028))
            .with(Layer::Mix { color: Bands::new(0.085, 0.112, 0.118, 0.06), amount: shallows.ramp(0.85, 0.5) })
            .with(Layer::Brightness { amount: noise("turbid", 26.0, 5).times(0.22 * k) })
            .bumpy(noise("ripples", 0.8, 2), 0.012)
    };
    vec![bare.clone(), as_class("soil and scree", Class::Ground), as_class("wash sand", Class::Sand), water]
}
