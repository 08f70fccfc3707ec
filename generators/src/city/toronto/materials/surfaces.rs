//! Single materials: what each surface of the city looks like.

use crate::kit::mesh_builder::{NOMINAL_BAY_M, NOMINAL_FLOOR_M};
use satseed_scene::{Bands, Brdf, Class, Coordinate, Field, Fractal, Layer, Material, Space};

/// A reflectance of red, green and blue.
pub(in crate::city) fn bgr(b: f32, g: f32, r: f32) -> Bands {
    // Near infrared of built surfaces follows red.
    Bands::new(b, g, r, r * 1.1)
}

/// Noise of the world's places.
pub(in crate::city) fn noise(seed: u32, wavelength_m: f32, octaves: u8) -> Field {
    Field::world_noise(seed, wavelength_m, octaves)
}

/// How much is left of paint: it wears off in flakes, and streets are painted years apart. `left` is the mean of the flakes.
pub(in crate::city) fn paint_left(seed: u32, flakes_m: f32, left: f32) -> Field {
    let flakes = noise(seed, flakes_m, 3).affine(0.8, left).ramp(0.0, 1.0);
    let painted = noise(seed ^ 0x51a7, 110.0, 2).affine(1.5, 0.75).ramp(-0.15, 1.0);
    Field::Product(vec![flakes, painted])
}

/// A layer that lightens and darkens.
pub(in crate::city) fn brightness(amount: Field) -> Layer {
    Layer::Brightness { amount }
}

/// Patches, streaks and grain, and the instance's own shade.
pub(in crate::city) fn aged(m: Material, seed: u32, patch: f32, grain: f32) -> Material {
    m.with(brightness(noise(seed, 14.0, 2).times(patch)))
        .with(brightness(noise(seed ^ 0x51, 2.6, 2).times(patch * 0.8)))
        .with(brightness(noise(seed ^ 0xa7, 0.62, 1).times(grain)))
        .with(brightness(Field::Variation(0).times(0.16)))
        .with(Layer::Tint { tint: Bands::new(-0.06, 0.0, 0.05, 0.05), amount: Field::Variation(1) })
}

/// A single stripe.
pub(super) fn stripe(across: Coordinate, at: f32, width_m: f32) -> Field {
    Field::Stripes { across, period_m: 4000.0, width_m, offset_m: at - width_m / 2.0 }
}

/// Stripes every `period_m`.
pub(in crate::city) fn repeating(across: Coordinate, period_m: f32, width_m: f32, offset_m: f32) -> Field {
    Field::Stripes { across, period_m, width_m, offset_m }
}

/// Asphalt of an age 0..1.
pub(in crate::city) fn asphalt(name: &str, age: f32, seed: u32) -> Material {
    let base = bgr(0.055, 0.057, 0.06).lerp(bgr(0.125, 0.135, 0.145), age);
    let m = Material::diffuse(name, Class::Road, base).rough(0.4);
    // In products the cheap masks stand first: where they are zero nothing behind them is evaluated.
    let cracks = Field::Product(vec![
        noise(seed ^ 0x5, 23.0, 2).ramp(-0.1, 0.3),
        Field::Warped {
            of: Box::new(Field::Cracks { space: Space::World, seed: seed ^ 0x3, cell_m: 7.0, width_m: 0.07 }),
            seed: seed ^ 0x4,
            wavelength_m: 5.0,
            amplitude_m: 1.2,
        },
    ]);
    aged(m, seed, 0.13, 0.12)
        .with(Layer::Mix { color: bgr(0.035, 0.036, 0.038), amount: cracks.times(0.25 + 0.45 * age) })
        .with(Layer::Mix {
            color: bgr(0.04, 0.041, 0.043),
            amount: noise(seed ^ 0x6, 3.1, 2).ramp(0.32, 0.6).times(0.35),
        })
}

/// Where lanes and lines of a street kind are, m left of its middle: lane centres, dashed lines, solid lines, and
/// whether the middle is yellow.
struct Lines {
    lanes: &'static [f32],
    dashed: &'static [f32],
    solid: &'static [f32],
    yellow: bool,
}

fn lines(kind: u16) -> Lines {
    match kind {
        0 => Lines { lanes: &[-1.5, 1.5], dashed: &[0.0], solid: &[-3.05, 3.05], yellow: false },
        1 => Lines { lanes: &[-1.6, 1.6], dashed: &[], solid: &[-3.25, 3.25], yellow: true },
        2 => Lines { lanes: &[-4.95, -1.7, 1.7, 4.95], dashed: &[-3.3, 3.3], solid: &[-6.6, 6.6], yellow: true },
        _ => Lines {
            lanes: &[-8.6, -5.3, -2.2, 2.2, 5.3, 8.6],
            dashed: &[-6.95, -3.75, 3.75, 6.95],
            solid: &[],
            yellow: true,
        },
    }
}

/// The part of a carriageway between two stop lines, with worn markings and the dark bands that traffic leaves.
pub(in crate::city) fn road(kind: u16, age: u16, seed: u32) -> Material {
    let l = lines(kind);
    let mut m = asphalt(&format!("road {kind} {age}"), [0.25, 0.65, 0.95][age as usize], seed);
    let oil: Vec<Field> = l.lanes.iter().map(|c| stripe(Coordinate::V, *c, 0.9)).collect();
    let oil = Field::Product(vec![Field::Sum(oil), noise(seed ^ 0xb, 17.0, 2).affine(0.5, 0.7)]);
    m = m.with(brightness(oil.times(-0.13)));
    let tracks: Vec<Field> =
        l.lanes.iter().flat_map(|c| [c - 0.85, c + 0.85]).map(|c| stripe(Coordinate::V, c, 0.6)).collect();
    m = m.with(brightness(Field::Sum(tracks).times(0.06)));
    let wear = paint_left(seed ^ 0xc, 6.0, 0.75);
    let dashes = Field::Product(vec![
        repeating(Coordinate::U, 12.0, 3.0, 0.0),
        Field::Sum(l.dashed.iter().map(|c| stripe(Coordinate::V, *c, 0.13)).collect()),
    ]);
    let solid = Field::Sum(l.solid.iter().map(|c| stripe(Coordinate::V, *c, 0.11)).collect());
    let white = Field::Product(vec![Field::Sum(vec![dashes, solid]), wear.clone()]);
    m = m.with(Layer::Mix { color: bgr(0.38, 0.4, 0.41), amount: white.times(0.75) });
    if l.yellow {
        let pair = Field::Sum(vec![stripe(Coordinate::V, -0.16, 0.11), stripe(Coordinate::V, 0.16, 0.11)]);
        m = m.with(Layer::Mix { color: bgr(0.09, 0.26, 0.36), amount: Field::Product(vec![pair, wear]).times(0.75) });
    }
    m
}

/// Concrete slabs with joints every `joint_m` of their texture coordinates.
pub(in crate::city) fn concrete(name: &str, class: Class, level: f32, joint_m: f32, seed: u32) -> Material {
    let m = Material::diffuse(name, class, bgr(0.8, 0.92, 1.0) * level).rough(0.3);
    let mut m = aged(m, seed, 0.12, 0.09);
    if joint_m > 0.0 {
        let joints = Field::Max(vec![
            repeating(Coordinate::U, joint_m, 0.06, 0.0),
            repeating(Coordinate::V, joint_m, 0.06, 0.0),
        ]);
        m = m.with(brightness(joints.times(-0.3))).with(brightness(
            Field::Cells { space: Space::Uv, seed, size_m: [joint_m, joint_m, 0.0], stagger: 0.0 }.times(0.09),
        ));
    }
    m.with(Layer::Mix { color: bgr(0.06, 0.06, 0.06), amount: noise(seed ^ 0x9, 2.6, 3).ramp(0.3, 0.65).times(0.3) })
}

/// Grass, more or less dry.
pub(in crate::city) fn lawn(name: &str, dryness: f32, seed: u32) -> Material {
    let green = Bands::new(0.035, 0.075, 0.05, 0.35);
    let dry = Bands::new(0.075, 0.115, 0.12, 0.3);
    aged(Material::diffuse(name, Class::LowVegetation, green.lerp(dry, dryness)).rough(0.5), seed, 0.2, 0.14)
        .with(Layer::Mix { color: dry, amount: noise(seed ^ 0x15, 9.0, 4).ramp(0.0, 0.5).times(0.6) })
        .with(Layer::Mix {
            color: bgr(0.08, 0.105, 0.135),
            amount: noise(seed ^ 0x16, 5.0, 3).ramp(0.3, 0.55).times(0.7),
        })
}

/// A wall's own surface, without windows.
pub(in crate::city) fn wall(name: &str, base: Bands, seed: u32) -> Material {
    let m = Material::diffuse(name, Class::Facade, base).rough(0.35);
    // Rain leaves vertical streaks.
    let streaks = Field::Noise(Fractal::new(Space::Plan, seed ^ 0x1f, 0.9, 2));
    aged(m, seed, 0.1, 0.1).with(brightness(streaks.times(0.14)))
}

/// Windows in a wall as texture: one to a bay and floor, each with a shade of its own, some with blinds.
pub(in crate::city) fn with_windows(m: Material, width_m: f32, height_m: f32, seed: u32) -> Material {
    let (bay, floor) = (NOMINAL_BAY_M as f32, NOMINAL_FLOOR_M as f32);
    let mask = || {
        Field::Product(vec![
            repeating(Coordinate::U, bay, width_m, (bay - width_m) / 2.0),
            repeating(Coordinate::V, floor, height_m, 0.85),
        ])
    };
    let cells = |s: u32| Field::Cells { space: Space::Uv, seed: seed ^ s, size_m: [bay, floor, 0.0], stagger: 0.0 };
    m.with(Layer::Mix { color: bgr(0.06, 0.065, 0.07), amount: mask() }).with(Layer::Mix {
        color: bgr(0.3, 0.31, 0.32),
        amount: Field::Product(vec![mask(), cells(1).ramp(0.3, 0.9).times(0.5)]),
    })
}

/// Rows of windows between bands, floor by floor.
pub(in crate::city) fn banded(m: Material, seed: u32) -> Material {
    let (bay, floor) = (NOMINAL_BAY_M as f32, NOMINAL_FLOOR_M as f32);
    let row = || {
        let panes = repeating(Coordinate::U, bay / 2.0, bay / 2.0 - 0.2, 0.1);
        Field::Product(vec![panes, repeating(Coordinate::V, floor, 2.2, 0.3)])
    };
    let cells = Field::Cells { space: Space::Uv, seed, size_m: [bay / 2.0, floor, 0.0], stagger: 0.0 };
    m.with(Layer::Mix { color: bgr(0.075, 0.072, 0.066), amount: row().times(0.92) })
        .with(Layer::Mix { color: bgr(0.25, 0.25, 0.25), amount: Field::Product(vec![row(), cells.ramp(0.5, 1.1)]) })
}

/// Glazing of a facade: dark under a smooth coat, with mullions, blinds and a shade for every pane.
pub(in crate::city) fn glass(name: &str, tint: Bands, mullion: Bands, panes: f32, blinds: f32, seed: u32) -> Material {
    let (bay, floor) = (NOMINAL_BAY_M as f32, NOMINAL_FLOOR_M as f32);
    let pane = bay / panes;
    let cells =
        |s: u32, n: f32| Field::Cells { space: Space::Uv, seed: seed ^ s, size_m: [n, floor, 0.0], stagger: 0.0 };
    let mut m = Material::diffuse(name, Class::Facade, tint);
    m.brdf = Brdf::Coated { index: 1.52 };
    m.with(brightness(cells(1, pane).times(0.3)))
        .with(brightness(Field::Variation(0).times(0.25)))
        .with(Layer::Mix {
            color: bgr(0.33, 0.34, 0.35),
            amount: cells(2, pane).ramp(1.0 - 2.0 * blinds, 1.5 - 2.0 * blinds).times(0.42),
        })
        .with(Layer::Mix { color: mullion, amount: repeating(Coordinate::U, pane, 0.14, -0.07) })
        .with(Layer::Mix { color: mullion, amount: repeating(Coordinate::V, floor, 0.12, 0.95).times(0.7) })
}

/// A flat roof's covering in strips, renewed part by part, with repairs, ponding, stains and grain.
pub(in crate::city) fn membrane(name: &str, base: Bands, strip_m: f32, stain: f32, seed: u32) -> Material {
    let m = Material::diffuse(name, Class::Roof, base).rough(0.35);
    let mut m = aged(m, seed, 0.1, 0.09);
    let along = Coordinate { space: Space::Object, axis: (seed & 1) as u8 };
    if strip_m > 0.0 {
        let mut size_m = [0.0; 3];
        size_m[along.axis as usize] = strip_m;
        m = m
            .with(brightness(Field::Cells { space: Space::Object, seed, size_m, stagger: 0.0 }.times(0.05)))
            .with(brightness(repeating(along, strip_m, 0.12, 0.0).times(-0.16)));
    }
    let cells = |s: u32, u: f32, v: f32, stagger: f32| Field::Cells {
        space: Space::Object,
        seed: seed ^ s,
        size_m: [u, v, 0.0],
        stagger,
    };
    // Parts of a roof are of different years. Repairs are squares, where the roof is bad, darker than what they mend or
    // paler than it.
    m = m.with(brightness(cells(0x61, 19.0, 14.0, 0.37).times(0.6 * stain)));
    let bad = |s: u32| noise(seed ^ s, 31.0, 2).ramp(-0.05, 0.25);
    let darker = Field::Product(vec![bad(0x62), cells(0x63, 3.3, 2.1, 0.4).ramp(0.72, 0.76)]);
    let paler = Field::Product(vec![bad(0x64), cells(0x65, 5.1, 2.4, 0.3).ramp(0.84, 0.88)]);
    m = m
        .with(Layer::Mix { color: base.lerp(bgr(0.055, 0.058, 0.062), 0.6), amount: darker.times(0.8) })
        .with(Layer::Mix { color: base.lerp(bgr(0.36, 0.38, 0.39), 0.4), amount: paler.times(0.8) });
    // Dust and algae in broad tongues.
    let dirt = Field::Warped {
        of: Box::new(noise(seed ^ 0x66, 11.0, 4)),
        seed: seed ^ 0x67,
        wavelength_m: 6.0,
        amplitude_m: 2.5,
    };
    m = m
        .with(Layer::Mix { color: base.lerp(bgr(0.075, 0.09, 0.105), 0.7), amount: dirt.ramp(0.0, 0.55).times(stain) });
    let pond = noise(seed ^ 0x29, 8.0, 3);
    m.with(brightness(pond.clone().ramp(0.05, 0.3).times(-stain)))
        // The rim that a pond leaves when it dries.
        .with(brightness(
            Field::Product(vec![pond.clone().ramp(0.0, 0.06), pond.ramp(0.13, 0.07)]).times(-0.28 * stain),
        ))
        .with(Layer::Mix { color: base * 0.45, amount: noise(seed ^ 0x2a, 2.3, 4).ramp(0.25, 0.6).times(stain * 0.9) })
}

/// Sheet metal with rust and stains.
pub(in crate::city) fn metal(name: &str, level: f32, seed: u32) -> Material {
    let m = Material::diffuse(name, Class::Roof, bgr(0.95, 0.98, 1.0) * level).rough(0.2);
    aged(m, seed, 0.08, 0.08).with(brightness(noise(seed ^ 0x33, 1.1, 3).ramp(0.2, 0.6).times(-0.3)))
}
