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
        of(bank_m, &|b| 1.0 - smoothstep(0.0, 6.0, b)),
    ]
}

/// The terrain's materials by slot.
pub(super) fn materials(strata: &Strata, is_dry: bool, contrast: f64, path: &SeedPath) -> Vec<Material> {
    let seed = |name: &str| path.child(name).hash_u32();
    let k = contrast as f32;
    let noise = |name: &str, wavelength_m: f32, octaves: u8| Field::world_noise(seed(name), wavelength_m, octaves);
    // Three scales: patches, stains, grain.
    let patches = || noise("patch", 22.0, 3).times(0.13 * k);
    let stains = || noise("stain", 2.6, 3).times(0.10 * k);
    let grain = || noise("grain", 0.55, 2).times(0.14 * k);
    let speckle = || noise("speckle", 1.1, 3);

    let bedding = Field::Sum(vec![
        Field::Along(Coordinate::HEIGHT),
        Field::Raster(raster::FOLD).affine(-2.0 * FOLD_LIMIT_M as f32, FOLD_LIMIT_M as f32),
        noise("bedding", 14.0, 3).times(0.5),
    ]);
    let steep = || Field::Upward.ramp(0.80, 0.55);
    let flat = || Field::Upward.ramp(0.80, 0.95);
    let streaks = Field::Noise {
        space: Space::World,
        seed: seed("streaks"),
        wavelength_m: 1.6,
        octaves: 3,
        gain: 0.6,
        stretch: [1.0, 1.0, 14.0],
    };
    let varnish = Field::Product(vec![
        streaks.ramp(0.0, 0.35),
        noise("varnish", 30.0, 2).ramp(-0.2, 0.25),
        Field::Upward.ramp(0.62, 0.3),
    ]);
    let soil_color = Bands::new(0.125, 0.165, 0.225, 0.30);
    let pale_soil = Bands::new(0.17, 0.215, 0.275, 0.34);
    let rubble_color = Bands::new(0.135, 0.17, 0.215, 0.28);
    let dark_crust = Bands::new(0.085, 0.10, 0.125, 0.19);
    let varnish_color = Bands::new(0.065, 0.075, 0.095, 0.15);
    let sand_color = Bands::new(0.205, 0.26, 0.32, 0.38);
    let silt_color = Bands::new(0.15, 0.185, 0.225, 0.28);

    let scree = Field::Sum(vec![Field::Raster(raster::SCREE), noise("scree edge", 5.0, 4).times(0.45)]);
    let bare = Material::diffuse("rock", Class::Rock, strata.mean_color())
        .rough(0.4)
        .with(Layer::Strata { beds: strata.colors(), height: bedding, amount: Field::Constant(1.0) })
        // Slopes are dusted over with what falls on them, and lose some of their beds' colour.
        .with(Layer::Mix {
            color: soil_color,
            amount: Field::Product(vec![
                Field::Sum(vec![Field::Upward.ramp(0.55, 0.93).times(0.72), noise("dust", 9.0, 4).times(0.30)]),
                Field::Upward.ramp(0.5, 0.7),
            ]),
        })
        .with(Layer::Mix { color: varnish_color, amount: varnish.times(0.62) })
        .with(Layer::Mix {
            color: rubble_color,
            amount: Field::Product(vec![scree.ramp(0.05, 0.55), Field::Upward.ramp(0.6, 0.75)]).times(0.62),
        })
        // Pockets of pale sand and of dark crust on level rock.
        .with(Layer::Mix {
            color: pale_soil,
            amount: Field::Product(vec![flat(), noise("pockets", 13.0, 4).ramp(0.02, 0.22)]).times(0.75),
        })
        .with(Layer::Mix {
            color: dark_crust,
            amount: Field::Product(vec![flat(), noise("crust", 7.0, 5).ramp(0.12, 0.32)]).times(0.5),
        })
        // Washes carry sand.
        .with(Layer::Mix { color: sand_color, amount: Field::Raster(raster::FLOW).ramp(0.72, 0.86).times(0.7) })
        .with(Layer::Mix {
            color: sand_color,
            amount: Field::Product(vec![
                Field::Sum(vec![Field::Raster(raster::SAND), noise("sand edge", 12.0, 3).times(0.35)]).ramp(0.45, 0.75),
                Field::Upward.ramp(0.85, 0.95),
            ])
            .times(0.85),
        })
        .with(Layer::Mix {
            color: silt_color,
            amount: Field::Product(vec![
                noise("silt", 8.0, 4).ramp(0.0, 0.2),
                Field::Raster(raster::SAND).ramp(0.6, 0.9),
            ])
            .times(0.6),
        })
        .with(Layer::Brightness { amount: patches() })
        .with(Layer::Brightness { amount: stains() })
        .with(Layer::Brightness { amount: grain() })
        // Cracks and stones: dark specks on steep and stony ground.
        .with(Layer::Brightness { amount: Field::Product(vec![speckle().ramp(0.12, 0.4), steep()]).times(-0.35 * k) })
        .with(Layer::Tint { tint: Bands::new(-0.6, -0.1, 0.5, 0.5), amount: noise("hue", 60.0, 3).times(0.10 * k) })
        .with(Layer::Brightness {
            amount: Field::Raster(raster::WET).ramp(0.3, 1.0).times(if is_dry { -0.12 } else { -0.38 }),
        })
        .bumpy(noise("bump", 0.9, 3), 0.06);
    let as_class = |name: &str, class: Class| Material { name: name.to_owned(), class, ..bare.clone() };
    let water = Material {
        brdf: Brdf::Coated { index: 1.33 },
        ..Material::diffuse("river", Class::Water, Bands::new(0.05, 0.075, 0.07, 0.03))
            .with(Layer::Mix {
                color: Bands::new(0.09, 0.12, 0.13, 0.07),
                amount: Field::Raster(raster::WET).ramp(1.0, 0.6),
            })
            .with(Layer::Brightness { amount: noise("turbid", 18.0, 4).times(0.25 * k) })
            .bumpy(noise("ripples", 0.8, 2), 0.012)
    };
    vec![bare.clone(), as_class("soil and scree", Class::Ground), as_class("wash sand", Class::Sand), water]
}
