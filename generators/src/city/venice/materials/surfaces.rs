//! Single materials: what each surface of the city looks like. `k` is the contrast of texture.

use crate::kit::mesh_builder::{NOMINAL_BAY_M, NOMINAL_FLOOR_M};
use satseed_scene::{Bands, Brdf, Class, Coordinate, Field, Fractal, Layer, Material, Space};

/// A reflectance of blue, green and red; near infrared of built surfaces follows red.
pub(super) fn bgr(b: f32, g: f32, r: f32) -> Bands {
    Bands::new(b, g, r, r * 1.1)
}

pub(super) fn noise(seed: u32, wavelength_m: f32, octaves: u8) -> Field {
    Field::world_noise(seed, wavelength_m, octaves)
}

pub(super) fn brightness(amount: Field) -> Layer {
    Layer::Brightness { amount }
}

pub(super) fn mix(color: Bands, amount: Field) -> Layer {
    Layer::Mix { color, amount }
}

fn stripes(across: Coordinate, period_m: f32, width_m: f32, offset_m: f32) -> Field {
    Field::Stripes { across, period_m, width_m, offset_m }
}

/// Patches, stains and grain, and the instance's own shade and hue.
pub(super) fn aged(m: Material, seed: u32, patch: f32, grain: f32) -> Material {
    m.with(brightness(noise(seed, 14.0, 2).times(patch)))
        .with(brightness(noise(seed ^ 0x51, 2.6, 2).times(patch * 0.8)))
        .with(brightness(noise(seed ^ 0xa7, 0.62, 1).times(grain)))
        .with(brightness(Field::Variation(0).times(0.16)))
        .with(Layer::Tint { tint: Bands::new(-0.06, 0.0, 0.05, 0.05), amount: Field::Variation(1) })
}

/// Pan tiles: courses that run down the slope, tiles of several batches, repairs, lichen, streaks below ridges.
pub(super) fn tiles(name: &str, base: Bands, age: f32, k: f32, seed: u32) -> Material {
    let uv = |u: f32, v: f32, s: u32, stagger: f32| Field::Cells {
        space: Space::Uv,
        seed: seed ^ s,
        size_m: [u, v, 0.0],
        stagger,
    };
    let fresh = base.lerp(bgr(0.085, 0.145, 0.30), 0.6);
    let grey = bgr(0.105, 0.125, 0.15);
    let dark = bgr(0.05, 0.06, 0.075);
    let streaks = Field::Noise(Fractal::new(Space::Uv, seed ^ 0x11, 0.8, 3).stretched([1.0, 5.0, 1.0]));
    let age_here = || Field::Variation(2).affine(0.5, 0.5 * age + 0.25);
    Material::diffuse(name, Class::Roof, base)
        .rough(0.5)
        .with(brightness(Field::Variation(0).times(0.24)))
        .with(Layer::Tint { tint: Bands::new(-0.20, -0.02, 0.13, 0.1), amount: Field::Variation(1) })
        .with(brightness(noise(seed, 9.0, 2).times(0.14 * k)))
        .with(brightness(noise(seed ^ 0x51, 2.2, 3).times(0.20 * k)))
        .with(brightness(noise(seed ^ 0xa7, 0.55, 2).times(0.16 * k)))
        .with(brightness(streaks.times(0.20 * k)))
        // Parts laid anew, and tiles of other kilns among them.
        .with(mix(fresh, uv(4.7, 3.3, 0x21, 0.4).ramp(0.70, 0.74).times(0.55 * k.min(1.0))))
        .with(brightness(uv(7.9, 60.0, 0x22, 0.0).times(0.07 * k)))
        .with(brightness(uv(0.48, 0.40, 0x23, 0.5).times(0.17 * k)))
        // Lichen and soot: old tiles turn grey and brown in tongues.
        .with(mix(
            grey,
            Field::Product(vec![
                age_here(),
                Field::Warped {
                    of: Box::new(noise(seed ^ 0x31, 3.6, 4)),
                    seed: seed ^ 0x32,
                    wavelength_m: 3.0,
                    amplitude_m: 1.0,
                }
                .ramp(-0.05, 0.5),
            ])
            .times(0.75 * k.min(1.3)),
        ))
        .with(mix(
            dark,
            Field::Product(vec![age_here(), noise(seed ^ 0x33, 1.5, 3).ramp(0.15, 0.55)]).times(0.55 * k.min(1.3)),
        ))
        // The channels between rows of tiles, and the steps of the courses.
        .with(brightness(stripes(Coordinate::U, 0.24, 0.09, 0.0).times(-0.38)))
        .with(brightness(stripes(Coordinate::V, 0.36, 0.05, 0.0).times(-0.22)))
}

/// A wall's own surface: plaster or brick, damp and bare at its foot.
pub(super) fn wall(name: &str, base: Bands, k: f32, seed: u32) -> Material {
    let streaks = Field::Noise(Fractal::new(Space::Plan, seed ^ 0x1f, 0.9, 2));
    let height = || Field::Along(Coordinate::HEIGHT);
    let brick = bgr(0.075, 0.10, 0.17);
    aged(Material::diffuse(name, Class::Facade, base).rough(0.35), seed, 0.1 * k, 0.1 * k)
        .with(brightness(streaks.times(0.16 * k)))
        .with(mix(
            brick,
            Field::Product(vec![
                Field::Sum(vec![height().times(-0.05), noise(seed ^ 0x41, 2.6, 3)]).ramp(0.0, 0.16),
                height().ramp(9.0, 4.0),
            ])
            .times(0.8 * k.min(1.0)),
        ))
        // Salt and damp rise some 2 m; the tide leaves a dark green band.
        .with(brightness(Field::Sum(vec![height(), noise(seed ^ 0x42, 3.0, 2).times(1.2)]).ramp(2.2, 0.4).times(-0.28)))
        .with(mix(
            bgr(0.035, 0.05, 0.04),
            Field::Sum(vec![height(), noise(seed ^ 0x43, 2.0, 2).times(0.2)]).ramp(-0.15, -0.45).times(0.85),
        ))
}

/// Windows as texture: one to a bay and floor, framed in stone, with shutters open or closed.
pub(super) fn windowed(m: Material, shutters: Bands, seed: u32) -> Material {
    let (bay, floor) = (NOMINAL_BAY_M as f32, NOMINAL_FLOOR_M as f32);
    let rect = |w: f32, h: f32, sill: f32| {
        Field::Product(vec![stripes(Coordinate::U, bay, w, (bay - w) / 2.0), stripes(Coordinate::V, floor, h, sill)])
    };
    let cells = |s: u32| Field::Cells { space: Space::Uv, seed: seed ^ s, size_m: [bay, floor, 0.0], stagger: 0.0 };
    let and = |a: Field, b: Field| Field::Product(vec![a, b]);
    m.with(mix(shutters, and(rect(2.5, 1.62, 0.82), cells(1).ramp(-0.3, -0.25))))
        .with(mix(bgr(0.36, 0.4, 0.43), rect(1.42, 1.95, 0.68).times(0.85)))
        .with(mix(bgr(0.045, 0.047, 0.05), rect(1.12, 1.66, 0.8)))
        .with(mix(shutters, and(rect(1.12, 1.66, 0.8), cells(2).ramp(0.25, 0.3))))
}

/// Stone slabs in courses.
pub(super) fn slabs(name: &str, base: Bands, size_m: [f32; 2], k: f32, seed: u32) -> Material {
    let cells = Field::Cells { space: Space::Uv, seed, size_m: [size_m[0], size_m[1], 0.0], stagger: 0.43 };
    let joints = stripes(Coordinate::V, size_m[1], 0.05, 0.0);
    aged(Material::diffuse(name, Class::Ground, base).rough(0.35), seed, 0.13 * k, 0.1 * k)
        .with(brightness(cells.times(0.15 * k)))
        .with(brightness(joints.times(-0.25)))
        .with(mix(base * 0.45, noise(seed ^ 0x9, 2.4, 3).ramp(0.22, 0.6).times(0.5 * k.min(1.4))))
        .with(mix(base * 1.35, noise(seed ^ 0xd, 4.4, 3).ramp(0.2, 0.6).times(0.35 * k.min(1.4))))
}

/// Pale limestone of quays and church fronts, weathered black where rain does not wash it.
pub(super) fn stone(name: &str, class: Class, k: f32, seed: u32) -> Material {
    let m = aged(Material::diffuse(name, class, bgr(0.33, 0.375, 0.405)).rough(0.3), seed, 0.12 * k, 0.1 * k);
    m.with(mix(bgr(0.12, 0.13, 0.135), noise(seed ^ 0x3, 1.7, 3).ramp(0.1, 0.5).times(0.6 * k.min(1.4))))
}

/// The lagoon's water in the canals: green, turbid, in wind too weak for more than ripples.
pub(super) fn water(k: f32, seed: u32) -> Material {
    let mut m = Material::diffuse("canal", Class::Water, Bands::new(0.036, 0.054, 0.038, 0.008));
    m.brdf = Brdf::Water { slope_variance: 0.007 };
    // Where wind presses and where a film calms it; what wakes leave; waves shorter than a pixel.
    m.with(brightness(noise(seed, 45.0, 4).times(0.26 * k)))
        .with(brightness(
            Field::Warped {
                of: Box::new(noise(seed ^ 1, 7.0, 3)),
                seed: seed ^ 4,
                wavelength_m: 9.0,
                amplitude_m: 3.0,
            }
            .times(0.20 * k),
        ))
        .with(brightness(noise(seed ^ 5, 1.7, 2).times(0.16 * k)))
        .with(Layer::Tint { tint: Bands::new(0.2, 0.0, 0.3, 0.3), amount: noise(seed ^ 2, 90.0, 2).times(0.5 * k) })
        .bumpy(Field::Noise(Fractal::new(Space::Plan, seed ^ 3, 1.6, 3).gain(0.7)), 0.045)
}

/// Grass of gardens.
pub(super) fn lawn(k: f32, seed: u32) -> Material {
    let green = Bands::new(0.036, 0.072, 0.05, 0.33);
    aged(Material::diffuse("garden", Class::LowVegetation, green).rough(0.5), seed, 0.2 * k, 0.14 * k)
        .with(mix(Bands::new(0.075, 0.11, 0.12, 0.3), noise(seed ^ 0x15, 5.0, 4).ramp(0.0, 0.5).times(0.6)))
        .with(mix(bgr(0.09, 0.115, 0.14), noise(seed ^ 0x16, 3.0, 3).ramp(0.15, 0.45).times(0.8)))
}
