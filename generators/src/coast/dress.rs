//! Materials of the coast: water by its depth, foam, sand dry and wet, marram and turf, rock.

use super::cover::{COVER, channel};
use super::relief::{Hinterland, Relief};
use satseed_scene::{Bands, Beds, Brdf, Class, Coordinate, Field, Fractal, Layer, Material, Rng, SeedPath, Space};

/// Deeper water looks like this deep, m.
const DEEP_M: f64 = 14.0;

/// Colours of one coast.
struct Palette {
    sand: Bands,
    rock: Bands,
    turf: Bands,
    straw: Bands,
    /// How much of the turf is dry.
    dry: f32,
    scrub: Bands,
}

fn palette(hinterland: Hinterland, rng: &mut Rng) -> Palette {
    // Pale shell sand, tan quartz, grey grains of slate and lava; from chalk and limestone to slate.
    let sands = [
        Bands::new(0.272, 0.322, 0.348, 0.42),
        Bands::new(0.190, 0.246, 0.284, 0.36),
        Bands::new(0.172, 0.196, 0.212, 0.27),
    ];
    let rocks = [
        Bands::new(0.235, 0.275, 0.300, 0.34),
        Bands::new(0.138, 0.168, 0.196, 0.24),
        Bands::new(0.098, 0.112, 0.122, 0.16),
    ];
    let between = |of: &[Bands; 3], t: f64| {
        let k = (t as usize).min(1);
        of[k].lerp(of[k + 1], (t - k as f64) as f32)
    };
    let kind = rng.below(3) as usize;
    let sand = sands[kind].lerp(sands[(kind + 1) % 3], rng.range(0.0, 0.3) as f32);
    let rock = between(&rocks, rng.range(0.3, 2.0));
    let shade = rng.range(0.9, 1.15) as f32;
    let (turf, straw, dry, scrub) = match hinterland {
        Hinterland::Turf => (
            Bands::new(0.038, 0.071, 0.055, 0.31),
            Bands::new(0.080, 0.116, 0.106, 0.28),
            0.12,
            [0.023, 0.040, 0.031, 0.20],
        ),
        Hinterland::Heath => (
            Bands::new(0.046, 0.070, 0.060, 0.26),
            Bands::new(0.090, 0.112, 0.108, 0.25),
            0.20,
            [0.040, 0.047, 0.050, 0.17],
        ),
        Hinterland::Rough => (
            Bands::new(0.052, 0.084, 0.070, 0.29),
            Bands::new(0.100, 0.134, 0.128, 0.29),
            0.42,
            [0.026, 0.043, 0.034, 0.20],
        ),
    };
    let [blue, green, red, infrared] = scrub;
    Palette { sand, rock, turf: turf * shade, straw, dry, scrub: Bands::new(blue, green, red, infrared) * shade }
}

/// Diffuse attenuation of the water, 1/m: clear, coastal, turbid (blue, green, red, near infrared).
const WATERS: [[f64; 4]; 3] = [[0.055, 0.075, 0.36, 2.2], [0.12, 0.12, 0.42, 2.4], [0.30, 0.25, 0.55, 2.6]];
/// Reflectance of endless depth of the same waters.
const DEEPS: [[f32; 4]; 3] = [[0.034, 0.024, 0.006, 0.001], [0.034, 0.036, 0.010, 0.002], [0.046, 0.062, 0.036, 0.008]];

/// How the cover codes a depth, 0 to 1: finest where colour changes most.
pub(crate) fn coded_depth(depth_m: f64) -> f64 {
    f64::sqrt((depth_m / DEEP_M).clamp(0.0, 1.0))
}

/// Colour over depth, as the cover codes it (Maritorena et al. 1994): the bottom seen through the water, and the water's own.
pub(crate) fn over_depth(bottom: Bands, clarity: f64) -> Beds {
    let k = (clarity as usize).min(1);
    let t = clarity - k as f64;
    let steps = 96;
    let beds: Vec<(f32, Bands)> = (1..=steps)
        .map(|step| {
            let coded = (f64::from(step) - 0.5) / f64::from(steps);
            let depth = coded * coded * DEEP_M;
            let color = Bands(core::array::from_fn(|b| {
                let lost = WATERS[k][b] + (WATERS[k + 1][b] - WATERS[k][b]) * t;
                let deep = DEEPS[k][b] + (DEEPS[k + 1][b] - DEEPS[k][b]) * t as f32;
                let through = libm::exp(-2.0 * lost * depth) as f32;
                // Light that leaves the water is spread and partly thrown back below the surface: a half comes out.
                deep + (0.54 * bottom.0[b] - deep) * through
            }));
            ((f64::from(step) / f64::from(steps)) as f32, color)
        })
        .collect();
    Beds::new(&beds)
}

/// The terrain's materials by slot.
pub(super) fn materials(relief: &Relief, contrast: f64, path: &SeedPath) -> Vec<Material> {
    let seed = |name: &str| path.child(name).hash_u32();
    let k = contrast as f32;
    let mut rng = path.child("palette").rng();
    let colors = palette(relief.hinterland(), &mut rng);
    let clarity = rng.range(0.0, 1.7);
    // Every colour stands as far from the sand's as the contrast says.
    let apart = |c: Bands| colors.sand.lerp(c, k).map(|v| v.max(0.01));
    let raster = |channel: u8| Field::Raster { raster: COVER, channel };
    let product = Field::Product;
    let noise = |name: &str, wavelength_m: f32, octaves: u8, gain: f32| {
        Field::Noise(Fractal::new(Space::Plan, seed(name), wavelength_m, octaves).gain(gain))
    };
    let foam = Bands::new(0.60, 0.60, 0.58, 0.46);
    let three_scales = |m: Material, by: f32| {
        m.with(Layer::Brightness { amount: raster(channel::TONE).affine(0.26 * k * by, -0.13 * k * by) })
            .with(Layer::Brightness { amount: raster(channel::STAIN).affine(0.20 * k * by, -0.10 * k * by) })
            .with(Layer::Tint {
                tint: Bands::new(-0.6, -0.05, 0.5, 0.3),
                amount: raster(channel::HUE).affine(0.22 * k * by, -0.11 * k * by),
            })
    };

    // The walls between cells of foam, bent.
    let cells = |name: &str, cell_m: f32, width_m: f32| Field::Warped {
        of: Box::new(Field::Cracks { space: Space::Plan, seed: seed(name), cell_m, width_m }),
        seed: seed("curl"),
        wavelength_m: 1.6 * cell_m,
        amplitude_m: 0.35 * cell_m,
    };
    let swell = relief.swell.towards;
    let turned = |of: Fractal| Field::Turned { of: Box::new(Field::Noise(of)), along: [swell.x, swell.y] };
    let blown = |of: Fractal| Field::Turned { of: Box::new(Field::Noise(of)), along: [relief.wind.x, relief.wind.y] };
    let weed = Bands::new(0.030, 0.040, 0.036, 0.10);
    let water = Material {
        brdf: Brdf::Water { slope_variance: relief.slope_variance() as f32 },
        ..Material::diffuse("sea", Class::Water, Bands::grey(0.05))
    }
    .with(Layer::Strata {
        beds: over_depth(colors.sand * 0.85, clarity),
        height: Field::Sum(vec![raster(channel::DEPTH), noise("lens", 2.4, 2, 0.6).times(0.012 * k)]),
        amount: Field::Constant(1.0),
    })
    .with(Layer::Strata {
        beds: over_depth(weed, clarity),
        height: raster(channel::DEPTH),
        amount: product(vec![
            raster(channel::WEED),
            Field::Sum(vec![Field::Constant(0.75), noise("fronds", 3.0, 4, 0.7).times(0.9)]),
        ])
        .times(0.85 * k.min(1.0)),
    })
    .with(Layer::Mix {
        color: colors.sand * 0.42,
        amount: product(vec![raster(channel::TURBID).ramp(0.45, 1.0), raster(channel::DEPTH).ramp(0.62, 0.25)])
            .times(0.40 * k.min(1.0)),
    })
    .with(Layer::Brightness { amount: raster(channel::TURBID).affine(0.16 * k, -0.08 * k) })
    // Old foam: a grey veil, denser in the walls of cells, which widen as it thins.
    .with(Layer::Mix {
        color: foam * 0.85,
        amount: product(vec![
            raster(channel::LACE),
            Field::Sum(vec![
                Field::Constant(0.20),
                raster(channel::LACE).times(0.30),
                cells("cells", 2.3, 0.45).times(0.22),
                cells("fine cells", 0.95, 0.25).times(0.20),
                noise("torn", 5.0, 5, 0.8).times(0.80),
            ])
            .ramp(0.0, 0.9),
        ]),
    })
    .with(Layer::Mix {
        color: foam,
        amount: Field::Sum(vec![
            raster(channel::FOAM),
            product(vec![raster(channel::FOAM).ramp(0.0, 0.3), noise("froth", 2.2, 4, 0.75)]).times(0.75),
        ])
        .ramp(0.22, 1.05),
    })
    // What waves shorter than the mesh's do to a pixel, and where the wind presses and where a film calms them.
    .with(Layer::Brightness {
        amount: Field::Sum(vec![
            turned(Fractal::new(Space::Plan, seed("wavelets"), 2.6, 3).gain(0.85).stretched([1.0, 2.0, 1.0]))
                .times(0.15 * k),
            turned(Fractal::new(Space::Plan, seed("slicks"), 46.0, 4).gain(0.6).stretched([2.6, 1.0, 1.0]))
                .times(0.13 * k),
            // The wind's waves across it, and streaks along it.
            blown(Fractal::new(Space::Plan, seed("waves"), 5.2, 3).gain(0.6).stretched([1.0, 3.2, 1.0]))
                .times(0.17 * k),
            blown(Fractal::new(Space::Plan, seed("rows"), 11.0, 2).gain(0.7).stretched([9.0, 1.0, 1.0]))
                .times(0.09 * k),
        ]),
    })
    .bumpy(turned(Fractal::new(Space::Plan, seed("ripples"), 1.3, 3).gain(0.7).stretched([1.0, 2.2, 1.0])), 0.030);

    // Sand and rock meet in a ragged line, whatever triangles say.
    let sandy = || Field::Sum(vec![raster(channel::SANDY), noise("border", 9.0, 5, 0.7).times(0.3)]).ramp(0.44, 0.56);
    // Tufts close as marram grows denser; the same on both sides of a border of slots.
    let marram = Bands::new(0.056, 0.086, 0.076, 0.25);
    let grown = || {
        Field::Sum(vec![
            Field::Max(vec![raster(channel::MARRAM), raster(channel::TURF)]).times(1.2),
            noise("tufts", 1.3, 3, 0.85).times(0.65),
        ])
        .ramp(0.34, 0.78)
    };
    let sand = three_scales(Material::diffuse("sand", Class::Sand, colors.sand).rough(0.35), 0.7)
        .with(Layer::Mix { color: apart(colors.rock), amount: sandy().affine(-1.0, 1.0) })
        .with(Layer::Mix {
            color: apart(colors.sand.lerp(Bands::new(0.15, 0.165, 0.172, 0.22), 0.7)),
            amount: product(vec![raster(channel::SHINGLE), noise("pebbles", 1.5, 3, 0.9).ramp(-0.3, 0.4)]).times(0.5),
        })
        // Feet and wind leave the dry sand uneven.
        .with(Layer::Brightness {
            amount: product(vec![raster(channel::WET).affine(-0.9, 1.0), noise("feet", 1.4, 3, 0.9)]).times(0.17 * k),
        })
        .with(Layer::Mix {
            color: apart(Bands::new(0.055, 0.062, 0.062, 0.11)),
            amount: product(vec![raster(channel::WRACK), noise("wrack", 1.1, 3, 0.9).ramp(-0.45, 0.15)]).times(0.72),
        })
        // Water between grains takes half of the light (Lekner and Dorf 1988).
        .with(Layer::Brightness { amount: raster(channel::WET).times(-0.46) })
        // Ways over sand: churned and damp.
        .with(Layer::Brightness {
            amount: product(vec![
                raster(channel::WORN).ramp(0.32, 0.66),
                Field::Sum(vec![Field::Constant(-0.13), noise("churned", 0.9, 2, 0.8).times(0.3)]),
            ])
            .times(k),
        })
        .with(Layer::Mix { color: apart(marram), amount: grown().times(0.9) })
        .with(Layer::Mix {
            color: foam,
            amount: Field::Sum(vec![
                raster(channel::FOAM),
                product(vec![raster(channel::FOAM).ramp(0.0, 0.3), noise("swash", 1.6, 3, 0.8)]).times(0.6),
            ])
            .ramp(0.3, 0.75)
            .times(0.7),
        })
        .bumpy(noise("hummocks", 1.5, 2, 0.8), 0.05 * k);

    let base = if relief.cliffs { colors.turf } else { colors.turf.lerp(marram, 0.25) };
    let turf = three_scales(Material::diffuse("turf", Class::LowVegetation, apart(base)).rough(0.4), 0.8)
        // Dry grass: on slopes and knolls rather than in hollows.
        .with(Layer::Mix {
            color: apart(colors.straw),
            amount: Field::Sum(vec![
                Field::Constant(colors.dry),
                noise("dry", 34.0, 5, 0.7).times(0.75),
                Field::Upward.ramp(0.985, 0.90).times(0.35),
                raster(channel::WET).times(-0.5),
                product(vec![raster(channel::MARRAM), raster(channel::TURF).affine(-1.0, 1.0)]).times(0.30),
            ]),
        })
        // Wet ground is darker and greener.
        .with(Layer::Mix {
            color: apart(Bands::new(0.026, 0.054, 0.036, 0.27)),
            amount: Field::Sum(vec![raster(channel::WET), noise("rushes", 4.0, 4, 0.8).times(0.5)])
                .ramp(0.25, 1.1)
                .times(0.75),
        })
        // Tussocks, where grass is not grazed short, and the shadows between them.
        .with(Layer::Mix {
            color: apart(colors.straw * 1.12),
            amount: product(vec![
                noise("grazed", 19.0, 3, 0.6).ramp(-0.15, 0.30),
                noise("tussocks", 0.85, 2, 0.8).ramp(0.04, 0.40),
            ])
            .times(0.55),
        })
        .with(Layer::Mix {
            color: apart(colors.scrub),
            amount: product(vec![
                Field::Sum(vec![raster(channel::HEATH), noise("bushes", 2.8, 4, 0.75).times(0.8)]).ramp(0.30, 0.72),
                raster(channel::TURF).ramp(0.1, 0.6),
            ])
            .times(0.9),
        })
        // Crowns and heather within the masses.
        .with(Layer::Brightness {
            amount: product(vec![raster(channel::HEATH), noise("crowns", 2.1, 3, 0.8)]).times(0.55 * k),
        })
        // Bare sand shows where plants thin out.
        .with(Layer::Mix {
            color: colors.sand,
            amount: if relief.cliffs { Field::Constant(0.0) } else { grown().affine(-1.0, 1.0) },
        })
        .with(Layer::Mix {
            color: apart(if relief.cliffs { Bands::new(0.110, 0.138, 0.158, 0.22) } else { colors.sand }),
            amount: Field::Sum(vec![raster(channel::WORN), noise("trodden", 1.3, 2, 0.7).times(0.22)])
                .ramp(0.38, 0.66)
                .times(0.82),
        })
        .with(Layer::Brightness { amount: noise("blades", 0.9, 2, 0.9).times(0.26 * k) })
        .bumpy(noise("tussocks", 0.85, 2, 0.8), 0.075 * k);

    let lichen = Bands::new(0.150, 0.178, 0.150, 0.26);
    let rock = three_scales(Material::diffuse("rock", Class::Rock, apart(colors.rock)).rough(0.4), 1.0)
        .with(Layer::Brightness {
            amount: Field::Noise(
                Fractal::new(Space::World, seed("beds"), 5.0, 4).stretched([9.0, 9.0, 0.35]).gain(0.7),
            )
            .times(0.34 * k),
        })
        .with(Layer::Mix {
            color: apart(colors.turf),
            amount: product(vec![
                Field::Upward.ramp(0.62, 0.85),
                Field::Along(Coordinate::HEIGHT).ramp(4.0, 8.0),
                noise("ledge turf", 3.0, 4, 0.75).ramp(-0.2, 0.3),
            ])
            .times(0.8),
        })
        .with(Layer::Mix { color: apart(lichen), amount: noise("lichen", 2.0, 3, 0.8).ramp(0.18, 0.5).times(0.4) })
        .with(Layer::Mix {
            color: colors.sand,
            amount: product(vec![
                Field::Upward.ramp(0.78, 0.90),
                Field::Along(Coordinate::HEIGHT).ramp(7.0, 4.0),
                sandy(),
            ]),
        })
        // Dark below the tide: wet and grown over.
        .with(Layer::Mix {
            color: apart(Bands::new(0.038, 0.044, 0.042, 0.09)),
            amount: product(vec![
                Field::Sum(vec![Field::Along(Coordinate::HEIGHT), noise("tide", 6.0, 3, 0.6).times(0.8)])
                    .ramp(2.0, 0.7),
                Field::Sum(vec![Field::Constant(0.72), noise("algae", 1.8, 3, 0.8).times(0.6)]),
            ]),
        })
        .with(Layer::Mix {
            color: foam,
            amount: Field::Sum(vec![raster(channel::FOAM), noise("spray", 1.5, 3, 0.8).times(0.5)])
                .ramp(0.4, 0.8)
                .times(0.8),
        })
        .with(Layer::Brightness { amount: noise("grain", 1.25, 3, 0.95).times(0.26 * k) })
        .bumpy(Field::Noise(Fractal::new(Space::World, seed("bump"), 1.7, 2).gain(0.8)), 0.10 * k);
    vec![water, sand, turf, rock]
}
