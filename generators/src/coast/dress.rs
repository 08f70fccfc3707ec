//! Materials of the coast: water by its depth, foam, sand dry and wet, marram and turf, rock.

use super::relief::{Relief, Surface};
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::sampling::smoothstep;
use glam::DVec2;
use rayon::prelude::*;
use satseed_scene::{
    Bands, Beds, Brdf, Class, Coordinate, Field, Fractal, Layer, Material, MaterialRaster, Raster, Rng, SeedPath, Space,
};

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
const COVER: u32 = 0;

/// Channels of the cover.
mod channel {
    /// Depth of the water: 0 on the surface to 1 at [`super::DEEP_M`], as its square root.
    pub(super) const DEPTH: u8 = 0;
    /// Fresh foam.
    pub(super) const FOAM: u8 = 1;
    /// Old foam, in strands.
    pub(super) const LACE: u8 = 2;
    /// Wet sand and rock.
    pub(super) const WET: u8 = 3;
    /// Weed and rock on the bottom.
    pub(super) const WEED: u8 = 4;
    /// Stirred sand in the water, around one half.
    pub(super) const TURBID: u8 = 5;
    /// Plants that cover the sand.
    pub(super) const MARRAM: u8 = 6;
    /// Turf.
    pub(super) const TURF: u8 = 7;
    /// Heath and scrub among the turf.
    pub(super) const HEATH: u8 = 8;
    /// Trodden paths and the track.
    pub(super) const WORN: u8 = 9;
    /// What the tide left.
    pub(super) const WRACK: u8 = 10;
    /// Patches of brightness around one half.
    pub(super) const TONE: u8 = 11;
    /// Patches of hue around one half.
    pub(super) const HUE: u8 = 12;
    /// Stains of a few metres around one half.
    pub(super) const STAIN: u8 = 13;
    /// Sand rather than rock.
    pub(super) const SANDY: u8 = 15;
    /// Shells and pebbles.
    pub(super) const SHINGLE: u8 = 14;
}

/// Distance of the raster's posts, m.
const CELL_M: f64 = 1.0;
/// Deeper water looks like this deep, m.
const DEEP_M: f64 = 14.0;

type Post = [u8; MaterialRaster::CHANNELS];

/// Names of the cover's noises.
pub(super) const NOISES: [&str; 12] =
    ["weed", "turbid", "marram", "turf", "heath", "tone", "hue", "stain", "shingle", "wrack", "wet", "clumps"];

/// The slot of dry ground whose unit normal rises by `up`.
pub(super) fn slot_of(relief: &Relief, p: DVec2, s: &Surface, up: f64) -> u16 {
    let [marram, turf] = plants(relief, p, s, &relief.cover_seeds);
    if relief.is_rock(s, up) {
        slot::ROCK
    } else if marram.max(turf) > 0.5 {
        slot::TURF
    } else {
        slot::SAND
    }
}

/// How much marram and how much turf cover a place, 0 to 1.
pub(super) fn plants(relief: &Relief, p: DVec2, s: &Surface, seeds: &[u32; NOISES.len()]) -> [f64; 2] {
    let (z_m, inland_m, sandy) = (s.land_m, s.place.inland_m, s.place.sandy);
    let ragged = |k: usize, wavelength_m: f64| fractal(p, seeds[k], wavelength_m, 4, 0.65);
    if relief.cliffs {
        let beach = smoothstep(0.2, 0.8, sandy);
        let begin = 7.0 + 26.0 * beach;
        return [0.0, smoothstep(begin, begin + 5.0, inland_m + 6.0 * ragged(3, 16.0)) * smoothstep(1.6, 3.0, z_m)];
    }
    let toe = relief.dune_toe_m();
    let on = inland_m - toe + 9.0 * ragged(11, 24.0);
    let marram = smoothstep(1.0, 9.0, on) * smoothstep(-0.22, 0.12, ragged(2, 13.0) + 0.004 * on);
    let turf =
        smoothstep(34.0, 95.0, on + 30.0 * ragged(3, 60.0)) * smoothstep(-0.30, -0.02, ragged(3, 21.0) + 0.0016 * on);
    [marram, turf]
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
    let [marram, turf] = plants(relief, p, &s, seeds);
    let rocky_bottom = smoothstep(
        0.1,
        0.45,
        fractal(p, seeds[0], 90.0, 4, 0.6)
            + 0.1 * ragged(0, 9.0)
            + if relief.cliffs { 0.45 * (1.0 - sandy) } else { -0.18 },
    );
    let [line, old_line] = [wet_to + 0.30, wet_to + 0.95].map(|z| {
        smoothstep(0.10, 0.02, (s.land_m - z - 0.12 * ragged(9, 14.0)).abs()) * smoothstep(-0.15, 0.25, ragged(9, 5.0))
    });
    // Ruts are narrower than the raster's posts stand apart: what shows is the worn band of both.
    let mut worn = relief.track(p, place);
    if worn > 0.0 {
        worn *= 0.72 + 0.35 * ragged(4, 6.0);
    }
    let (path, _) = relief.path(p, place);
    let values = [
        coded_depth(still),
        fresh.max(edge),
        loose,
        wet * f64::from(s.land_m < 6.0),
        rocky_bottom,
        0.5 + 0.5 * fractal(p, seeds[1], 75.0, 4, 0.6) + 0.35 * s.wave.map_or(0.0, |w| w.broken),
        marram,
        turf,
        smoothstep(0.0, 0.3, ragged(4, 42.0) + 0.12 * ragged(4, 7.0)),
        path.max(worn),
        line.max(0.7 * old_line) * sandy,
        0.5 + 0.5 * fractal(p, seeds[5], 24.0, 3, 0.5),
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

/// Colours of one coast.
struct Palette {
    sand: Bands,
    rock: Bands,
    turf: Bands,
}

fn palette(rng: &mut Rng) -> Palette {
    // From shell sand to quartz to dark volcanic grains; from chalk and limestone to slate.
    let sands = [
        Bands::new(0.262, 0.319, 0.352, 0.42),
        Bands::new(0.212, 0.272, 0.317, 0.39),
        Bands::new(0.168, 0.208, 0.238, 0.30),
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
    let sand = between(&sands, rng.range(0.0, 1.8));
    let rock = between(&rocks, rng.range(0.3, 2.0));
    Palette { sand, rock, turf: Bands::new(0.040, 0.072, 0.060, 0.30) * rng.range(0.9, 1.15) as f32 }
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
    let colors = palette(&mut rng);
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

    // Where a noise is near zero: lines that wind, meet and part.
    let veins = |name: &str, wavelength_m: f32, width: f32| {
        let n = || Field::Warped {
            of: Box::new(noise(name, wavelength_m, 2, 0.6)),
            seed: seed("curl"),
            wavelength_m: 0.7 * wavelength_m,
            amplitude_m: 0.3 * wavelength_m,
        };
        product(vec![n().ramp(-width, 0.0), n().ramp(width, 0.0)])
    };
    let swell = relief.swell.towards;
    let turned = |of: Fractal| Field::Turned { of: Box::new(Field::Noise(of)), along: [swell.x, swell.y] };
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
    // Old foam: veins where two currents of it meet, finer ones between them, flecks.
    .with(Layer::Mix {
        color: foam * 0.72,
        amount: product(vec![
            Field::Sum(vec![raster(channel::LACE), noise("torn", 7.0, 4, 0.75).times(0.9)]).ramp(0.05, 0.85),
            raster(channel::LACE).ramp(0.02, 0.25),
            Field::Max(vec![
                veins("veins", 5.5, 0.085),
                veins("fine veins", 2.6, 0.12).times(0.85),
                noise("flecks", 1.6, 3, 0.8).ramp(0.12, 0.5).times(0.9),
            ]),
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
        ]),
    })
    .bumpy(turned(Fractal::new(Space::Plan, seed("ripples"), 1.3, 3).gain(0.7).stretched([1.0, 2.2, 1.0])), 0.030);

    // Sand and rock meet in a ragged line, whatever triangles say.
    let sandy = || Field::Sum(vec![raster(channel::SANDY), noise("border", 9.0, 5, 0.7).times(0.3)]).ramp(0.44, 0.56);
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
            amount: product(vec![raster(channel::WRACK), noise("wrack", 1.1, 3, 0.9).ramp(-0.15, 0.25)]).times(0.8),
        })
        // Water between grains takes half of the light (Lekner and Dorf 1988).
        .with(Layer::Brightness { amount: raster(channel::WET).times(-0.46) })
        .with(Layer::Mix {
            color: apart(Bands::new(0.060, 0.086, 0.080, 0.24)),
            amount: product(vec![raster(channel::MARRAM), noise("tufts", 1.7, 3, 0.8).ramp(-0.35, 0.35)]).times(0.72),
        })
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

    let straw = Bands::new(0.085, 0.118, 0.120, 0.27);
    let heath = Bands::new(0.036, 0.052, 0.050, 0.20);
    let turf = three_scales(Material::diffuse("turf", Class::LowVegetation, apart(colors.turf)).rough(0.4), 1.0)
        .with(Layer::Mix {
            color: apart(straw),
            amount: Field::Sum(vec![noise("dry", 12.0, 4, 0.6).affine(0.9, 0.30), raster(channel::MARRAM).times(0.35)]),
        })
        .with(Layer::Mix {
            color: apart(heath),
            amount: product(vec![
                raster(channel::HEATH),
                raster(channel::TURF),
                noise("bushes", 2.6, 4, 0.75).ramp(-0.25, 0.2),
            ])
            .times(0.85),
        })
        // Bare sand shows where plants thin out.
        .with(Layer::Mix {
            color: colors.sand,
            amount: Field::Sum(vec![
                Field::Constant(1.0),
                raster(channel::MARRAM).times(-1.0),
                raster(channel::TURF).times(-1.0),
                noise("thin", 1.9, 3, 0.8).times(0.3),
            ])
            .ramp(0.1, 0.6),
        })
        .with(Layer::Mix {
            color: apart(if relief.cliffs { Bands::new(0.110, 0.138, 0.158, 0.22) } else { colors.sand }),
            amount: Field::Sum(vec![raster(channel::WORN), noise("trodden", 1.3, 2, 0.7).times(0.35)])
                .ramp(0.25, 0.7)
                .times(0.85),
        })
        .with(Layer::Brightness { amount: noise("blades", 1.2, 3, 0.95).times(0.28 * k) })
        .bumpy(noise("tussocks", 1.6, 2, 0.8), 0.10 * k);

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
