//! Toronto's materials. Reflectances are class values of public spectral libraries (ECOSTRESS, USGS splib07, LBNL roofs).
//!
//! Each has texture at three scales (patches of metres, streaks and stains, grain) keyed by place in the world, so that
//! no two surfaces show the same spots, and a brightness and tint of its own from the instance.

use super::ground_slot;
use crate::kit::buildings::slot;
use crate::kit::mesh_builder::{NOMINAL_BAY_M, NOMINAL_FLOOR_M};
use crate::kit::{trees, vehicles};
use satseed_scene::{Bands, Brdf, Class, Coordinate, Field, Fractal, Layer, Material, Rng, SeedPath, Space};
use std::collections::BTreeMap;

use super::massing::Kind;

/// Kinds of streets.
pub(super) const STREET_KINDS: u16 = 4;
/// Ages of asphalt of each kind.
pub(super) const ROAD_AGES: u16 = 3;

/// A book of materials, and the sets drawn from it.
#[derive(Debug)]
pub(super) struct Materials {
    /// All materials.
    pub list: Vec<Material>,
    /// Material sets.
    pub sets: Vec<Vec<u32>>,
    known: BTreeMap<Vec<u32>, u32>,
    brick: Vec<u32>,
    windowed: Vec<u32>,
    precast: Vec<u32>,
    banded: Vec<u32>,
    condo_glass: Vec<u32>,
    office_glass: Vec<u32>,
    masonry_glass: Vec<u32>,
    flat_roofs: Vec<u32>,
    house_roofs: Vec<u32>,
    metal: Vec<u32>,
    guard: Vec<u32>,
    coping: Vec<u32>,
    strip: Vec<u32>,
    terrace: Vec<u32>,
    green: u32,
    shop: u32,
    panel: u32,
    dark: u32,
    leaves: Vec<u32>,
    bark: u32,
    paints: Vec<(f64, u32)>,
    car_glass: u32,
    tyre: u32,
    cargo: Vec<u32>,
    lamp: u32,
    steel: u32,
    crane: u32,
}

fn bgr(b: f32, g: f32, r: f32) -> Bands {
    // Near infrared of built surfaces follows red.
    Bands::new(b, g, r, r * 1.1)
}

fn noise(seed: u32, wavelength_m: f32, octaves: u8) -> Field {
    Field::world_noise(seed, wavelength_m, octaves)
}

fn brightness(amount: Field) -> Layer {
    Layer::Brightness { amount }
}

/// Patches, streaks and grain, and the instance's own shade.
fn aged(m: Material, seed: u32, patch: f32, grain: f32) -> Material {
    m.with(brightness(noise(seed, 14.0, 2).times(patch)))
        .with(brightness(noise(seed ^ 0x51, 2.6, 2).times(patch * 0.8)))
        .with(brightness(noise(seed ^ 0xa7, 0.62, 1).times(grain)))
        .with(brightness(Field::Variation(0).times(0.16)))
        .with(Layer::Tint { tint: Bands::new(-0.06, 0.0, 0.05, 0.05), amount: Field::Variation(1) })
}

fn stripe(across: Coordinate, at: f32, width_m: f32) -> Field {
    Field::Stripes { across, period_m: 4000.0, width_m, offset_m: at - width_m / 2.0 }
}

fn repeating(across: Coordinate, period_m: f32, width_m: f32, offset_m: f32) -> Field {
    Field::Stripes { across, period_m, width_m, offset_m }
}

/// Asphalt of an age 0..1.
fn asphalt(name: &str, age: f32, seed: u32) -> Material {
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
fn road(kind: u16, age: u16, seed: u32) -> Material {
    let l = lines(kind);
    let mut m = asphalt(&format!("road {kind} {age}"), [0.25, 0.65, 0.95][age as usize], seed);
    let oil: Vec<Field> = l.lanes.iter().map(|c| stripe(Coordinate::V, *c, 0.9)).collect();
    let oil = Field::Product(vec![Field::Sum(oil), noise(seed ^ 0xb, 17.0, 2).affine(0.5, 0.7)]);
    m = m.with(brightness(oil.times(-0.13)));
    let tracks: Vec<Field> =
        l.lanes.iter().flat_map(|c| [c - 0.85, c + 0.85]).map(|c| stripe(Coordinate::V, c, 0.6)).collect();
    m = m.with(brightness(Field::Sum(tracks).times(0.06)));
    let wear = noise(seed ^ 0xc, 6.0, 3).affine(0.7, 0.55).ramp(0.0, 1.0);
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
fn concrete(name: &str, class: Class, level: f32, joint_m: f32, seed: u32) -> Material {
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

fn lawn(name: &str, dryness: f32, seed: u32) -> Material {
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
fn wall(name: &str, base: Bands, seed: u32) -> Material {
    let m = Material::diffuse(name, Class::Facade, base).rough(0.35);
    // Rain leaves vertical streaks.
    let streaks = Field::Noise(Fractal::new(Space::Plan, seed ^ 0x1f, 0.9, 2));
    aged(m, seed, 0.1, 0.1).with(brightness(streaks.times(0.14)))
}

/// Windows in a wall as texture: one to a bay and floor, each with a shade of its own, some with blinds.
fn with_windows(m: Material, width_m: f32, height_m: f32, seed: u32) -> Material {
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
fn banded(m: Material, seed: u32) -> Material {
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
fn glass(name: &str, tint: Bands, mullion: Bands, panes: f32, blinds: f32, seed: u32) -> Material {
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

/// A flat roof's covering in strips, with ponding, stains and grain.
fn membrane(name: &str, base: Bands, strip_m: f32, stain: f32, seed: u32) -> Material {
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
    let pond = noise(seed ^ 0x29, 8.0, 3);
    m.with(brightness(pond.clone().ramp(0.05, 0.3).times(-stain)))
        // The rim that a pond leaves when it dries.
        .with(brightness(
            Field::Product(vec![pond.clone().ramp(0.0, 0.06), pond.ramp(0.13, 0.07)]).times(-0.28 * stain),
        ))
        .with(Layer::Mix { color: base * 0.45, amount: noise(seed ^ 0x2a, 2.3, 4).ramp(0.25, 0.6).times(stain * 0.9) })
}

fn metal(name: &str, level: f32, seed: u32) -> Material {
    let m = Material::diffuse(name, Class::Roof, bgr(0.95, 0.98, 1.0) * level).rough(0.2);
    aged(m, seed, 0.08, 0.08).with(brightness(noise(seed ^ 0x33, 1.1, 3).ramp(0.2, 0.6).times(-0.3)))
}

impl Materials {
    fn add(&mut self, m: Material) -> u32 {
        self.list.push(m);
        self.list.len() as u32 - 1
    }

    /// The book of one scene.
    pub(super) fn new(path: &SeedPath) -> Self {
        let mut this = Self {
            list: Vec::new(),
            sets: Vec::new(),
            known: BTreeMap::new(),
            brick: Vec::new(),
            windowed: Vec::new(),
            precast: Vec::new(),
            banded: Vec::new(),
            condo_glass: Vec::new(),
            office_glass: Vec::new(),
            masonry_glass: Vec::new(),
            flat_roofs: Vec::new(),
            house_roofs: Vec::new(),
            metal: Vec::new(),
            guard: Vec::new(),
            coping: Vec::new(),
            strip: Vec::new(),
            terrace: Vec::new(),
            green: 0,
            shop: 0,
            panel: 0,
            dark: 0,
            leaves: Vec::new(),
            bark: 0,
            paints: Vec::new(),
            car_glass: 0,
            tyre: 0,
            cargo: Vec::new(),
            lamp: 0,
            steel: 0,
            crane: 0,
        };
        let seed = |name: &str, k: u64| path.child(name).index(k).hash_u32();
        this.ground(&seed);
        this.walls(&seed);
        this.roofs(&seed);
        this.things(&seed);
        this
    }

    /// The ground's materials become set 0 in the order of their slots.
    fn ground(&mut self, seed: &impl Fn(&str, u64) -> u32) {
        let mut set = vec![0; ground_slot::COUNT];
        let mut put = |this: &mut Self, slot: u16, m: Material| set[slot as usize] = this.add(m);
        put(self, ground_slot::CARRIAGEWAY, asphalt("carriageway", 0.6, seed("carriageway", 0)));
        put(self, ground_slot::KERB, concrete("kerb", Class::Ground, 0.26, 0.0, seed("kerb", 0)));
        put(self, ground_slot::SIDEWALK, concrete("sidewalk", Class::Ground, 0.25, 1.6, seed("sidewalk", 0)));
        put(self, ground_slot::PAVING, concrete("paving", Class::Ground, 0.21, 2.1, seed("paving", 0)));
        put(self, ground_slot::PAVING_DARK, asphalt("yard asphalt", 0.8, seed("yard asphalt", 0)));
        put(self, ground_slot::PLAZA, concrete("plaza", Class::Ground, 0.2, 1.2, seed("plaza", 0)));
        put(self, ground_slot::LAWN, lawn("lawn", 0.2, seed("lawn", 0)));
        put(self, ground_slot::YARD, lawn("yard", 0.75, seed("yard", 0)));
        put(self, ground_slot::LANE, asphalt("lane", 1.0, seed("lane", 0)));
        put(self, ground_slot::PATH, concrete("path", Class::Ground, 0.23, 0.0, seed("path", 0)));
        let soil = Material::diffuse("soil", Class::Ground, bgr(0.11, 0.145, 0.185)).rough(0.5);
        let soil = aged(soil, seed("soil", 0), 0.2, 0.15).with(Layer::Mix {
            color: bgr(0.2, 0.22, 0.24),
            amount: noise(seed("soil", 1), 6.0, 4).ramp(0.1, 0.5).times(0.7),
        });
        put(self, ground_slot::SOIL, soil);
        let stalls = Field::Product(vec![
            repeating(Coordinate::U, 2.6, 0.11, -0.055),
            repeating(Coordinate::V, 17.5, 11.0, -5.5),
            noise(seed("stall", 1), 5.0, 3).affine(0.7, 0.6).ramp(0.0, 1.0),
        ]);
        let lot = asphalt("parking lot", 0.8, seed("stall", 0))
            .with(Layer::Mix { color: bgr(0.36, 0.38, 0.39), amount: stalls.times(0.75) });
        put(self, ground_slot::PARKING, lot);
        let wear = noise(seed("paint", 0), 3.0, 3).affine(0.8, 0.55).ramp(0.0, 1.0);
        let ladder = Field::Product(vec![repeating(Coordinate::V, 1.25, 0.55, 0.2), wear.clone()]);
        let crossing = asphalt("crossing", 0.55, seed("carriageway", 0))
            .with(Layer::Mix { color: bgr(0.4, 0.42, 0.43), amount: ladder.times(0.8) });
        put(self, ground_slot::CROSSING, crossing);
        let bar = asphalt("stop bar", 0.55, seed("carriageway", 0))
            .with(Layer::Mix { color: bgr(0.38, 0.4, 0.41), amount: wear.times(0.8) });
        put(self, ground_slot::STOP, bar);
        put(self, ground_slot::PATCH_NEW, asphalt("patch", 0.05, seed("patch", 0)));
        put(self, ground_slot::PATCH_OLD, concrete("trench", Class::Road, 0.2, 0.0, seed("patch", 1)));
        put(self, ground_slot::MANHOLE, asphalt("manhole", 0.0, seed("patch", 2)));
        for kind in 0..STREET_KINDS {
            for age in 0..ROAD_AGES {
                let index = kind * ROAD_AGES + age;
                put(self, ground_slot::ROAD + index, road(kind, age, seed("road", u64::from(index))));
            }
        }
        self.sets.push(set);
    }

    fn walls(&mut self, seed: &impl Fn(&str, u64) -> u32) {
        let bricks = [
            bgr(0.075, 0.095, 0.165),
            bgr(0.07, 0.085, 0.125),
            bgr(0.1, 0.125, 0.165),
            bgr(0.16, 0.2, 0.235),
            bgr(0.06, 0.065, 0.075),
            bgr(0.13, 0.14, 0.15),
            bgr(0.24, 0.26, 0.27),
        ];
        for (k, base) in bricks.iter().enumerate() {
            let s = seed("brick", k as u64);
            let plain = self.add(wall(&format!("brick {k}"), *base, s));
            self.brick.push(plain);
            let m = with_windows(wall(&format!("windowed brick {k}"), *base, s), [1.1, 1.5, 1.3][k % 3], 1.6, s);
            let m = self.add(m);
            self.windowed.push(m);
        }
        for (k, level) in [0.18, 0.26, 0.34, 0.44, 0.1, 0.055].iter().enumerate() {
            let tint = if k % 2 == 0 { bgr(0.9, 0.97, 1.0) } else { bgr(0.97, 1.0, 1.0) };
            let m = self.add(wall(&format!("precast {k}"), tint * *level, seed("precast", k as u64)));
            self.precast.push(m);
            // Blocks beyond the detailed circle have their floors as texture.
            let s = seed("banded", k as u64);
            let m = banded(wall(&format!("banded {k}"), tint * (*level + 0.05), s), s);
            let m = self.add(m);
            self.banded.push(m);
        }
        let frames = [bgr(0.09, 0.09, 0.09), bgr(0.3, 0.31, 0.32), bgr(0.16, 0.16, 0.16)];
        let tints =
            [bgr(0.055, 0.055, 0.045), bgr(0.045, 0.05, 0.05), bgr(0.07, 0.072, 0.062), bgr(0.035, 0.035, 0.035)];
        for k in 0..4_usize {
            let s = seed("glass", k as u64);
            let m = self.add(glass(&format!("condominium glass {k}"), tints[k], frames[k % 3], 2.0, 0.22, s));
            self.condo_glass.push(m);
            let m = self.add(glass(
                &format!("office glass {k}"),
                tints[(k + 1) % 4],
                frames[(k + 2) % 3],
                1.0,
                0.12,
                s ^ 0x7,
            ));
            self.office_glass.push(m);
            let m =
                self.add(glass(&format!("window {k}"), tints[(k + 2) % 4], frames[(k + 1) % 3], 2.0, 0.35, s ^ 0xd));
            self.masonry_glass.push(m);
        }
    }

    fn roofs(&mut self, seed: &impl Fn(&str, u64) -> u32) {
        let flat: [(Bands, f32, f32); 9] = [
            (bgr(0.3, 0.315, 0.32), 2.6, 0.3),
            (bgr(0.2, 0.215, 0.225), 2.2, 0.25),
            (bgr(0.11, 0.113, 0.116), 1.0, 0.3),
            (bgr(0.075, 0.077, 0.08), 1.0, 0.22),
            (bgr(0.19, 0.21, 0.225), 0.0, 0.2),
            (bgr(0.14, 0.165, 0.195), 0.0, 0.25),
            (bgr(0.5, 0.51, 0.51), 2.8, 0.3),
            (bgr(0.24, 0.26, 0.275), 0.0, 0.3),
            (bgr(0.085, 0.1, 0.122), 2.0, 0.3),
        ];
        for (k, (base, strip, stain)) in flat.into_iter().enumerate() {
            let m = self.add(membrane(&format!("roof {k}"), base, strip, stain, seed("roof", k as u64)));
            self.flat_roofs.push(m);
        }
        for (k, base) in
            [bgr(0.065, 0.066, 0.068), bgr(0.085, 0.095, 0.11), bgr(0.12, 0.123, 0.125), bgr(0.055, 0.058, 0.06)]
                .into_iter()
                .enumerate()
        {
            let s = seed("shingle", k as u64);
            let m = Material::diffuse(&format!("shingle {k}"), Class::Roof, base).rough(0.4);
            let courses = Field::Cells { space: Space::Uv, seed: s, size_m: [0.9, 0.3, 0.0], stagger: 0.5 };
            let m = aged(m, s, 0.14, 0.12).with(brightness(courses.times(0.12)));
            let m = self.add(m);
            self.house_roofs.push(m);
        }
        for (k, level) in [0.42, 0.3, 0.2, 0.12].into_iter().enumerate() {
            let m = self.add(metal(&format!("sheet metal {k}"), level, seed("metal", k as u64)));
            self.metal.push(m);
        }
        for (k, level) in [0.3, 0.2, 0.12, 0.4].into_iter().enumerate() {
            let m = self.add(concrete(&format!("coping {k}"), Class::Roof, level, 0.0, seed("coping", k as u64)));
            self.coping.push(m);
            let m = self.add(membrane(
                &format!("roof edge {k}"),
                bgr(0.9, 0.96, 1.0) * (level * 0.6),
                0.0,
                0.3,
                seed("edge", k as u64),
            ));
            self.strip.push(m);
        }
        for (k, level) in [0.22, 0.3, 0.16].into_iter().enumerate() {
            let m = self.add(concrete(&format!("terrace {k}"), Class::Roof, level, 0.9, seed("terrace", k as u64)));
            self.terrace.push(m);
        }
        let green = lawn("planted roof", 0.35, seed("green", 0));
        self.green = self.add(Material { class: Class::Roof, ..green });
        let mut panel = Material::diffuse("solar panel", Class::Roof, bgr(0.045, 0.035, 0.032))
            .with(Layer::Mix { color: bgr(0.25, 0.25, 0.25), amount: repeating(Coordinate::U, 1.05, 0.05, 0.0) });
        panel.brdf = Brdf::Coated { index: 1.5 };
        self.panel = self.add(panel);
        self.dark = self.add(Material::diffuse("opening", Class::Roof, bgr(0.03, 0.03, 0.03)));
        for (k, tint) in [bgr(0.1, 0.1, 0.09), bgr(0.16, 0.165, 0.16), bgr(0.07, 0.07, 0.065)].into_iter().enumerate() {
            let mut m = Material::diffuse(&format!("guard {k}"), Class::Facade, tint);
            m.brdf = Brdf::Coated { index: 1.5 };
            let m = self.add(m.with(brightness(Field::Variation(0).times(0.3))));
            self.guard.push(m);
        }
        let shop = glass("shop window", bgr(0.05, 0.05, 0.05), bgr(0.14, 0.14, 0.14), 1.0, 0.25, seed("shop", 0));
        self.shop = self.add(shop);
    }

    fn things(&mut self, seed: &impl Fn(&str, u64) -> u32) {
        let leaf = [
            Bands::new(0.03, 0.075, 0.042, 0.42),
            Bands::new(0.036, 0.088, 0.05, 0.44),
            Bands::new(0.033, 0.07, 0.048, 0.4),
            Bands::new(0.024, 0.05, 0.033, 0.3),
        ];
        for (k, base) in leaf.into_iter().enumerate() {
            let mut m = Material::diffuse(&format!("leaves {k}"), Class::Tree, base)
                .with(brightness(Field::object_noise(seed("leaf", k as u64), 1.3, 2).times(0.45)))
                .with(brightness(noise(seed("leaf", 9 + k as u64), 0.35, 2).times(0.35)))
                .with(brightness(Field::Variation(0).times(0.2)))
                .with(Layer::Tint { tint: Bands::new(-0.05, 0.0, 0.22, 0.0), amount: Field::Variation(1) });
            m.brdf = Brdf::Leaf { transmission: Bands::new(0.01, 0.035, 0.015, 0.3) };
            let m = self.add(m);
            self.leaves.push(m);
        }
        self.bark = self.add(Material::diffuse("bark", Class::Tree, bgr(0.07, 0.085, 0.1)));
        // Shares of colours on Canadian roads: about 30 % white, 25 % black, 30 % grey and silver, 15 % others.
        let paints = [
            (0.30, bgr(0.62, 0.63, 0.63)),
            (0.25, bgr(0.025, 0.025, 0.025)),
            (0.15, bgr(0.13, 0.135, 0.14)),
            (0.15, bgr(0.34, 0.35, 0.35)),
            (0.06, bgr(0.03, 0.03, 0.22)),
            (0.05, bgr(0.2, 0.08, 0.04)),
            (0.015, bgr(0.06, 0.1, 0.05)),
            (0.015, bgr(0.16, 0.22, 0.26)),
            (0.01, bgr(0.03, 0.16, 0.36)),
        ];
        for (k, (share, base)) in paints.into_iter().enumerate() {
            let mut m = Material::diffuse(&format!("paint {k}"), Class::Vehicle, base)
                .with(brightness(Field::Variation(0).times(0.2)));
            m.brdf = Brdf::Coated { index: 1.5 };
            let m = self.add(m);
            self.paints.push((share, m));
        }
        let mut car_glass = Material::diffuse("car glass", Class::Vehicle, Bands::grey(0.025));
        car_glass.brdf = Brdf::Coated { index: 1.52 };
        self.car_glass = self.add(car_glass);
        self.tyre = self.add(Material::diffuse("tyre", Class::Vehicle, Bands::grey(0.03)));
        for level in [0.6, 0.4, 0.25] {
            let m = self.add(Material::diffuse("cargo box", Class::Vehicle, Bands::grey(level)));
            self.cargo.push(m);
        }
        self.lamp = self.add(Material::diffuse("lamp", Class::Vehicle, Bands::grey(0.4)));
        self.steel = self.add(Material::diffuse("steel", Class::OtherStructure, Bands::grey(0.22)));
        self.crane = self.add(Material::diffuse("crane", Class::OtherStructure, bgr(0.07, 0.25, 0.42)));
    }

    fn set(&mut self, set: Vec<u32>) -> u32 {
        if let Some(k) = self.known.get(&set) {
            return *k;
        }
        let k = self.sets.len() as u32;
        self.known.insert(set.clone(), k);
        self.sets.push(set);
        k
    }

    /// A set for a building. `massing`: it is only blocks, whose walls carry windows as texture.
    pub(super) fn building_set(&mut self, kind: Kind, massing: bool, path: &SeedPath) -> u32 {
        let mut rng = path.child("materials").rng();
        let style = rng.below(1 << 20) as usize;
        let of = |list: &[u32], rng: &mut Rng| *rng.pick(list);
        let (wall, glass, slab, roof) = match kind {
            Kind::Condo => {
                let pale = rng.weighted(&[0.2, 0.3, 0.3, 0.12, 0.08]);
                let wall = if rng.chance(0.25) {
                    of(&self.brick, &mut rng)
                } else {
                    self.precast[rng.weighted(&[0.25, 0.2, 0.15, 0.1, 0.2, 0.1])]
                };
                (
                    wall,
                    of(&self.condo_glass, &mut rng),
                    self.precast[[0, 1, 2, 3, 4][pale]],
                    self.flat_roofs[rng.weighted(&[2.0, 2.0, 0.5, 0.3, 3.0, 2.0, 0.7, 2.0, 0.6])],
                )
            }
            Kind::Office => {
                let wall = of(&self.precast, &mut rng);
                let slab = if rng.chance(0.6) { self.precast[4 + (style & 1)] } else { wall };
                (
                    wall,
                    of(&self.office_glass, &mut rng),
                    slab,
                    self.flat_roofs[rng.weighted(&[2.0, 2.0, 0.7, 0.3, 3.0, 2.0, 1.0, 2.0, 0.6])],
                )
            }
            Kind::Block => {
                let wall = if rng.chance(0.7) { of(&self.brick, &mut rng) } else { of(&self.precast, &mut rng) };
                (
                    wall,
                    of(&self.masonry_glass, &mut rng),
                    of(&self.precast, &mut rng),
                    self.flat_roofs[rng.weighted(&[2.0, 2.0, 1.5, 1.0, 2.0, 2.0, 0.8, 2.0, 1.5])],
                )
            }
            Kind::House | Kind::Shop | Kind::Shed => {
                let wall = of(&self.windowed, &mut rng);
                (
                    wall,
                    of(&self.masonry_glass, &mut rng),
                    wall,
                    self.flat_roofs[rng.weighted(&[1.0, 2.0, 2.0, 2.0, 1.5, 1.5, 0.5, 1.5, 2.0])],
                )
            }
        };
        let wall = match kind {
            Kind::Condo | Kind::Office if massing => of(&self.banded, &mut rng),
            Kind::Block if massing => of(&self.windowed, &mut rng),
            Kind::Shed => of(&self.brick, &mut rng),
            _ => wall,
        };
        let roof = if matches!(kind, Kind::House | Kind::Shed) && rng.chance(0.55) {
            of(&self.house_roofs, &mut rng)
        } else {
            roof
        };
        let mut set = vec![0; slot::COUNT];
        set[slot::WALL as usize] = wall;
        set[slot::GLASS as usize] = glass;
        set[slot::SLAB as usize] = slab;
        set[slot::COPING as usize] = of(&self.coping, &mut rng);
        set[slot::STRIP as usize] = of(&self.strip, &mut rng);
        set[slot::ROOF as usize] = roof;
        set[slot::METAL as usize] = of(&self.metal, &mut rng);
        set[slot::SHOP as usize] = self.shop;
        set[slot::GUARD as usize] = of(&self.guard, &mut rng);
        set[slot::PANEL as usize] = self.panel;
        set[slot::GREEN as usize] = self.green;
        set[slot::DARK as usize] = self.dark;
        set[slot::TERRACE as usize] = of(&self.terrace, &mut rng);
        self.set(set)
    }

    /// A set for a tree of a species.
    pub(super) fn tree_set(&mut self, species: usize) -> u32 {
        let mut set = vec![0; 2];
        set[trees::BARK as usize] = self.bark;
        set[trees::LEAVES as usize] = self.leaves[species % self.leaves.len()];
        self.set(set)
    }

    /// A set for a vehicle.
    pub(super) fn vehicle_set(&mut self, body: vehicles::Body, rng: &mut Rng) -> u32 {
        let weights: Vec<f64> = self.paints.iter().map(|p| p.0).collect();
        let mut paint = self.paints[rng.weighted(&weights)].1;
        if body == vehicles::Body::Bus {
            // The city's buses are red and white.
            paint = self.paints[if rng.chance(0.7) { 4 } else { 0 }].1;
        }
        let mut set = vec![0; 5];
        set[vehicles::PAINT as usize] = paint;
        set[vehicles::GLASS as usize] = self.car_glass;
        set[vehicles::TYRE as usize] = self.tyre;
        set[vehicles::BOX as usize] = *rng.pick(&self.cargo);
        set[vehicles::LAMP as usize] = self.lamp;
        self.set(set)
    }

    /// Sets of one slot: street lights, cranes.
    pub(super) fn steel_set(&mut self, crane: bool) -> u32 {
        let m = if crane { self.crane } else { self.steel };
        self.set(vec![m])
    }
}
