//! Materials of the desert: dune sand, slip faces, gravel flats, playa, tracks.

use super::relief::{GROUND_M, Relief};
use super::tracks::{MOST, REACH_M, Tracks};
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::sampling::smoothstep;
use glam::DVec2;
use rayon::prelude::*;
use satseed_scene::{Bands, Class, Field, Fractal, Layer, Material, MaterialRaster, Raster, Rng, SeedPath, Space};

/// Slots of the terrain's material set.
pub(super) mod slot {
    /// Sand that the wind shapes.
    pub(in super::super) const SAND: u16 = 0;
    /// Sand that slid.
    pub(in super::super) const SLIP: u16 = 1;
    /// Gravel flats and playa, thinly sanded over.
    pub(in super::super) const FLAT: u16 = 2;
}

/// Thicker sand than this is sand, thinner sand on the flats is ground, m.
pub(super) const SAND_FROM_M: f64 = 0.2;

/// The only raster.
const COVER: u32 = 0;

/// Factor on the contrast of all that is wider than a few metres.
const WIDE: f32 = 0.36;

/// Channels of the cover.
mod channel {
    /// How much sand covers the flats.
    pub(super) const SAND: u8 = 0;
    /// Playa among the flats.
    pub(super) const PLAYA: u8 = 1;
    /// Dark pavement among the flats.
    pub(super) const PAVEMENT: u8 = 2;
    /// Patches of brightness around one half.
    pub(super) const TONE: u8 = 3;
    /// Patches of hue around one half.
    pub(super) const HUE: u8 = 4;
    /// Stains of a few metres around one half.
    pub(super) const STAIN: u8 = 5;
    /// Streaks of dark grains along the wind.
    pub(super) const MINERAL: u8 = 6;
    /// Megaripples' coarse grains.
    pub(super) const RIPPLES: u8 = 7;
    /// Fresh sand of a slip face.
    pub(super) const FRESH: u8 = 8;
    /// Whether a track is near.
    pub(super) const TRACK: u8 = 9;
    /// Signed distance of the first track; the others follow.
    pub(super) const TRACKS: u8 = 10;
}

/// Distance of the raster's posts, m.
const CELL_M: f64 = 1.0;

type Post = [u8; MaterialRaster::CHANNELS];

/// The raster that all materials read, over the whole scene.
pub(super) fn cover(relief: &Relief, tracks: &Tracks, half_m: f64, dune_m: f64, path: &SeedPath) -> MaterialRaster {
    let names = ["sand", "playa", "pavement", "tone", "hue", "stain", "mineral", "streamers"];
    let seeds = names.map(|name| path.child(name).hash_u32());
    let n = (2.0 * half_m / CELL_M) as usize + 1;
    let shape = Raster::filled(DVec2::splat(-half_m), CELL_M, n, n, ());
    let rows: Vec<Vec<Post>> = (0..n)
        .into_par_iter()
        .map(|j| (0..n).map(|i| bake(relief, &seeds, dune_m, shape.position(i, j))).collect())
        .collect();
    let mut cover = Raster { origin_m: shape.origin_m, cell_m: CELL_M, width: n, height: n, data: rows.concat() };
    for (k, line) in tracks.lines.iter().enumerate() {
        let mut nearest = vec![REACH_M as f32; n * n];
        Tracks::distances(line, cover.origin_m, CELL_M, n, |i, j, distance| {
            let (p, d) = (j * n + i, distance as f32);
            if d.abs() < nearest[p].abs() {
                nearest[p] = d;
                cover.data[p][channel::TRACKS as usize + k] = in_255ths(0.5 + 0.5 * distance / REACH_M);
                let near = in_255ths(smoothstep(0.85 * REACH_M, 0.5 * REACH_M, distance.abs()));
                let all = &mut cover.data[p][channel::TRACK as usize];
                *all = near.max(*all);
            }
        });
    }
    MaterialRaster::new(cover)
}

fn in_255ths(value: f64) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

/// The cover's channels at a place.
fn bake(relief: &Relief, seeds: &[u32; 8], dune_m: f64, p: DVec2) -> Post {
    let sand = relief.dunes.sand(p);
    let q = relief.dunes.in_wind(p);
    let ragged = |k: usize, wavelength_m: f64| fractal(p, seeds[k], wavelength_m, 4, 0.7);
    let soft = |k: usize, wavelength_m: f64| fractal(p, seeds[k], wavelength_m, 3, 0.5);
    // Streamers of sand over the flats, long with the wind.
    let streamers = fractal(DVec2::new(q.x * 0.14, q.y), seeds[7], 7.0, 4, 0.62);
    let thick = sand.thick_m / dune_m;
    let covered = smoothstep(0.004, 0.105, thick + 0.05 * streamers + 0.035 * ragged(0, 9.0));
    let bare = 1.0 - covered;
    // Water stood in the hollows of the ground: what it left ends along a contour line, feathered.
    let hollow = -relief.ground_m(p) / GROUND_M;
    let flooded = 0.75 * hollow + 0.3 * soft(1, 150.0) + 0.10 * ragged(1, 23.0) - 2.0 * thick;
    let playa = smoothstep(0.02, 0.24, flooded) * smoothstep(0.15, 0.75, bare);
    let pavement = smoothstep(-0.15, 0.35, ragged(2, 34.0));
    // Dark minerals stay where the wind takes the light grains: along the lower windward side.
    let mineral = smoothstep(0.05, 0.45, fractal(DVec2::new(q.x * 0.3, q.y), seeds[6], 11.0, 4, 0.6))
        * smoothstep(0.7, 0.2, thick)
        * smoothstep(0.03, 0.12, thick);
    let ripples = relief.ripple_field(p, &sand);
    let values = [
        covered,
        playa,
        pavement,
        0.5 + 0.5 * soft(3, 28.0),
        0.5 + 0.5 * soft(4, 110.0),
        0.5 + 0.5 * fractal(p, seeds[5], 4.6, 2, 0.5),
        // Most of them where coarse grains gather anyway.
        mineral * (0.35 + 0.65 * ripples),
        ripples,
        relief.fresh(p, &sand),
        0.0,
    ];
    let mut post = Post::default();
    for (channel, value) in post.iter_mut().zip(values) {
        *channel = in_255ths(value);
    }
    // No track near: as far on its left as is told.
    for k in 0..MOST {
        post[channel::TRACKS as usize + k] = 255;
    }
    post
}

/// Colours of one desert.
struct Palette {
    sand: Bands,
    gravel: Bands,
    pavement: Bands,
    playa: Bands,
}

/// From the pale tan of coasts to the orange of old inland sand. What lies between the dunes is greyer, but its dust is the
/// sand's: no band may differ much more than another, or the sensor's stretch of each makes it garish.
fn palette(rng: &mut Rng) -> Palette {
    let pale = Bands::new(0.200, 0.286, 0.350, 0.42);
    let tan = Bands::new(0.148, 0.240, 0.335, 0.43);
    let orange = Bands::new(0.118, 0.204, 0.325, 0.42);
    let t = rng.unit() as f32 * 2.0;
    let sand = if t < 1.0 { pale.lerp(tan, t) } else { tan.lerp(orange, t - 1.0) };
    let bright = rng.range(0.92, 1.08) as f32;
    // A colour of the sand's hue that is as bright as a grey, mixed with the grey.
    let dusty = |grey: Bands, dust: f64| grey.lerp(sand * (grey.0[1] / sand.0[1]), dust as f32);
    let gravel = dusty(Bands::new(0.180, 0.208, 0.234, 0.28), rng.range(0.72, 0.9));
    Palette {
        sand: sand * bright,
        gravel: gravel * rng.range(0.9, 1.1) as f32,
        pavement: dusty(Bands::new(0.142, 0.162, 0.180, 0.22), rng.range(0.6, 0.8)),
        playa: dusty(Bands::new(0.262, 0.302, 0.335, 0.39), rng.range(0.62, 0.85)),
    }
}

/// The terrain's materials by slot.
pub(super) fn materials(relief: &Relief, contrast: f64, path: &SeedPath) -> Vec<Material> {
    let seed = |name: &str| path.child(name).hash_u32();
    let k = contrast as f32;
    // What is wider than a few metres differs less: deserts are of one tone, and their form makes the rest.
    let wide = WIDE * k;
    let colors = palette(&mut path.child("palette").rng());
    // Every colour stands as far from the sand's as the contrast says.
    let apart = |c: Bands| colors.sand.lerp(c, wide).map(|v| v.max(0.03));
    let raster = |channel: u8| Field::Raster { raster: COVER, channel };
    let product = Field::Product;
    let along = |d: DVec2| [d.x, d.y];
    let turned = |of: Field, d: DVec2| Field::Turned { of: Box::new(of), along: along(d) };
    // Ripples: crests across the wind that bend by some 25 degrees over a dune, in patches with bare sand between.
    let wind = relief.dunes.along;
    let crests = |name: &str, wavelength_m: f32, octaves: u8| {
        let straight = turned(
            Field::Noise(
                Fractal::new(Space::Plan, seed(name), wavelength_m, octaves).stretched([1.0, 3.5, 1.0]).gain(0.6),
            ),
            wind,
        );
        let bent =
            Field::Warped { of: Box::new(straight), seed: seed("crests bend"), wavelength_m: 36.0, amplitude_m: 4.0 };
        let patches = Field::Noise(Fractal::new(Space::Plan, seed("ripple patches"), 31.0, 2)).ramp(-0.15, 0.35);
        product(vec![bent, patches])
    };
    // Fresh sand from a slip face lies over all.
    let bare = || product(vec![raster(channel::SAND).affine(-1.0, 1.0), raster(channel::FRESH).affine(-1.0, 1.0)]);
    // Both ruts of every track, at 0.8 m on each side.
    let rut = |track: usize, side: f32| {
        let d = raster(channel::TRACKS + track as u8).affine(2.0 * REACH_M as f32 * side, -REACH_M as f32 * side);
        product(vec![d.clone().ramp(0.55, 0.72), d.ramp(1.08, 0.91)])
    };
    let ruts = Field::Max((0..MOST).flat_map(|t| [rut(t, 1.0), rut(t, -1.0)]).collect());

    let common = |m: Material| {
        m
            // Three scales: patches, stains, grain.
            .with(Layer::Brightness { amount: raster(channel::TONE).affine(0.20 * wide, -0.10 * wide) })
            .with(Layer::Brightness { amount: raster(channel::STAIN).affine(0.16 * wide, -0.08 * wide) })
            .with(Layer::Tint {
                tint: Bands::new(-0.7, -0.15, 0.45, 0.4),
                amount: raster(channel::HUE).affine(0.14 * wide, -0.07 * wide),
            })
            .with(Layer::Brightness { amount: product(vec![raster(channel::TRACK), ruts.clone()]).times(-0.12 * k) })
    };
    let covers = |m: Material| {
        m.with(Layer::Mix { color: apart(colors.gravel), amount: bare() })
            .with(Layer::Mix {
                color: apart(colors.pavement),
                amount: product(vec![bare(), raster(channel::PAVEMENT)]).times(0.6),
            })
            .with(Layer::Mix { color: apart(colors.playa), amount: product(vec![bare(), raster(channel::PLAYA)]) })
            .with(Layer::Mix { color: apart(colors.sand * 0.82), amount: raster(channel::MINERAL).times(0.5) })
            .with(Layer::Mix {
                color: apart(colors.sand.lerp(colors.gravel, 0.5) * 0.9),
                amount: raster(channel::RIPPLES).times(0.45),
            })
    };
    // Stones: darker and lighter specks, none on the playa. The sand's edge has them too: where a triangle ends does not
    // show.
    let stones = || {
        product(vec![
            bare(),
            raster(channel::PLAYA).affine(-0.85, 1.0),
            Field::Noise(Fractal::new(Space::Plan, seed("stones"), 1.4, 3).gain(0.85)).times(0.15 * k),
        ])
    };
    let grain = || Field::Noise(Fractal::new(Space::Plan, seed("grain"), 1.1, 2).gain(1.0)).times(0.10 * k);
    let sand = common(covers(Material::diffuse("dune sand", Class::Sand, colors.sand).rough(0.35)))
        .with(Layer::Brightness { amount: crests("ripple tone", 2.1, 2).times(0.04 * k) })
        .with(Layer::Brightness { amount: stones() })
        .with(Layer::Brightness { amount: grain() })
        .bumpy(crests("ripples", 1.5, 2), 0.022 * k);
    let fresh = || raster(channel::FRESH);
    let slip = common(covers(Material::diffuse("slip face", Class::Sand, colors.sand).rough(0.35)))
        // Fresh sand, sorted: a little lighter, streaked downward, in tongues that end on the ground before it.
        .with(Layer::Brightness { amount: fresh().times(0.03 * k) })
        .with(Layer::Brightness {
            amount: product(vec![
                fresh(),
                turned(
                    Field::Noise(
                        Fractal::new(Space::Plan, seed("slides"), 1.7, 2).stretched([7.0, 1.0, 1.0]).gain(0.8),
                    ),
                    relief.dunes.last_wind,
                )
                .times(0.06 * k),
            ]),
        })
        .with(Layer::Brightness { amount: stones() })
        .with(Layer::Brightness { amount: grain().times(0.7) });
    let cracks = |cell_m: f32, width_m: f32| Field::Warped {
        of: Box::new(Field::Cracks { space: Space::Plan, seed: seed("cracks"), cell_m, width_m }),
        seed: seed("bend"),
        wavelength_m: 2.2,
        amplitude_m: 0.35,
    };
    let cracked = |cell_m: f32, width_m: f32, darker: f32| Layer::Brightness {
        amount: product(vec![bare(), raster(channel::PLAYA).ramp(0.5, 0.9), cracks(cell_m, width_m)])
            .times(-darker * k),
    };
    let flat = common(covers(Material::diffuse("gravel and playa", Class::Ground, colors.sand).rough(0.4)))
        // Polygons within polygons, and silt where the water's edge stood.
        .with(cracked(1.7, 0.07, 0.12))
        .with(cracked(6.5, 0.16, 0.10))
        .with(Layer::Brightness {
            amount: product(vec![
                bare(),
                raster(channel::PLAYA).ramp(0.05, 0.3),
                raster(channel::PLAYA).ramp(0.75, 0.4),
            ])
            .times(0.05 * k),
        })
        .with(Layer::Brightness { amount: stones() })
        .with(Layer::Brightness { amount: grain() })
        .bumpy(Field::Noise(Fractal::new(Space::Plan, seed("gravel"), 1.3, 2).gain(0.8)), 0.03 * k);
    vec![sand, slip, flat]
}
