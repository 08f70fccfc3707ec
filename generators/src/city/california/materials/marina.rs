//! What only a harbour has: water over its depth, stones, sand, boats and docks.

use super::Materials;
use crate::city::california::marina::boats::slot as boat;
use crate::city::california::marina::docks::slot as dock;
use crate::city::california::marina::harbour::WATER_M;
use crate::city::toronto::materials::surfaces::{aged, bgr, brightness, concrete, noise, repeating};
use crate::coast;
use satseed_scene::{Bands, Brdf, Class, Coordinate, Field, Fractal, Layer, Material, SeedPath, Space};

/// The materials of boats and docks by what they are for.
#[derive(Debug, Default)]
pub(super) struct Book {
    hulls: Vec<(f64, u32)>,
    decks: Vec<u32>,
    soles: Vec<u32>,
    canvas: Vec<u32>,
    glass: u32,
    spar: u32,
    boards: Vec<u32>,
    float: u32,
    pile: u32,
    boxes: u32,
    metal: u32,
}

impl Materials {
    /// Adds a harbour's materials; those of its ground go to the end of the ground's set.
    pub(in super::super) fn add_marina(&mut self, path: &SeedPath) {
        let seed = |name: &str, k: u64| path.child(name).index(k).hash_u32();
        let mut clarity = path.child("clarity").rng();
        let ground = [water(clarity.range(0.25, 0.8), &seed), seawall(&seed), stones(&seed), sand(&seed)];
        for m in ground {
            let m = self.add(m);
            self.sets[0].push(m);
        }
        let gel = |name: String, class: Class, base: Bands| {
            let mut m = Material::diffuse(&name, class, base)
                .with(brightness(Field::Variation(0).times(0.08)))
                .with(brightness(noise(seed("gel", 0), 1.1, 2).times(0.06)));
            m.brdf = Brdf::Coated { index: 1.45 };
            m
        };
        // Most hulls are white, some cream or dark blue, a few dark red, green or black.
        let hulls = [
            (0.56, bgr(0.6, 0.61, 0.61)),
            (0.14, bgr(0.5, 0.54, 0.56)),
            (0.12, bgr(0.09, 0.035, 0.022)),
            (0.05, bgr(0.3, 0.31, 0.31)),
            (0.04, bgr(0.035, 0.04, 0.16)),
            (0.03, bgr(0.05, 0.07, 0.03)),
            (0.06, bgr(0.03, 0.03, 0.03)),
        ];
        for (k, (share, base)) in hulls.into_iter().enumerate() {
            let m = self.add(gel(format!("hull {k}"), Class::Vehicle, base));
            self.marina.hulls.push((share, m));
        }
        let matt = |name: String, base: Bands, s: u32| {
            aged(Material::diffuse(&name, Class::Vehicle, base).rough(0.3), s, 0.07, 0.06)
        };
        for (k, base) in [bgr(0.58, 0.6, 0.6), bgr(0.5, 0.52, 0.53), bgr(0.46, 0.51, 0.53), bgr(0.4, 0.42, 0.43)]
            .into_iter()
            .enumerate()
        {
            let m = self.add(matt(format!("boat deck {k}"), base, seed("boat deck", k as u64)));
            self.marina.decks.push(m);
        }
        for (k, base) in [bgr(0.38, 0.4, 0.41), bgr(0.1, 0.16, 0.24), bgr(0.14, 0.19, 0.25), bgr(0.24, 0.26, 0.27)]
            .into_iter()
            .enumerate()
        {
            let planks = repeating(Coordinate::V, 0.12, 0.02, 0.0).times(-0.2);
            let m = matt(format!("cockpit {k}"), base, seed("cockpit", k as u64)).with(brightness(planks));
            let m = self.add(m);
            self.marina.soles.push(m);
        }
        let canvas = [
            bgr(0.16, 0.06, 0.035),
            bgr(0.28, 0.12, 0.05),
            bgr(0.16, 0.25, 0.31),
            bgr(0.05, 0.055, 0.06),
            bgr(0.06, 0.1, 0.05),
            bgr(0.045, 0.045, 0.16),
            bgr(0.42, 0.45, 0.46),
            bgr(0.2, 0.21, 0.22),
        ];
        for (k, base) in canvas.into_iter().enumerate() {
            let m = matt(format!("canvas {k}"), base, seed("canvas", k as u64));
            let m = self.add(m.with(brightness(Field::Variation(1).times(0.2))));
            self.marina.canvas.push(m);
        }
        let mut glass = Material::diffuse("boat window", Class::Vehicle, Bands::grey(0.03));
        glass.brdf = Brdf::Coated { index: 1.5 };
        self.marina.glass = self.add(glass);
        self.marina.spar = self.add(Material::diffuse("spar", Class::Vehicle, Bands::grey(0.38)));
        let structure = Class::OtherStructure;
        for (k, base) in [bgr(0.24, 0.27, 0.29), bgr(0.19, 0.2, 0.205), bgr(0.27, 0.29, 0.3), bgr(0.13, 0.16, 0.19)]
            .into_iter()
            .enumerate()
        {
            let s = seed("dock", k as u64);
            let joints = repeating(Coordinate::U, 2.4, 0.07, 0.0).times(-0.3);
            let m = aged(Material::diffuse(&format!("dock boards {k}"), structure, base).rough(0.3), s, 0.16, 0.14);
            let m = self.add(m.with(brightness(joints)).with(brightness(Field::Variation(0).times(0.12))));
            self.marina.boards.push(m);
        }
        self.marina.float = self.add(concrete("dock float", structure, 0.2, 0.0, seed("float", 0)));
        let wet = Field::Along(Coordinate::HEIGHT).ramp(WATER + 0.9, WATER + 0.3).times(0.8);
        let pile = aged(Material::diffuse("pile", structure, bgr(0.19, 0.205, 0.21)), seed("pile", 0), 0.15, 0.1)
            .with(Layer::Mix { color: bgr(0.03, 0.04, 0.04), amount: wet });
        self.marina.pile = self.add(pile);
        self.marina.boxes = self.add(Material::diffuse("dock box", structure, bgr(0.5, 0.52, 0.52)));
        self.marina.metal = self.add(Material::diffuse("gangway", structure, Bands::grey(0.32)));
    }

    /// A set for a boat.
    pub(in super::super) fn boat_set(&mut self, path: &SeedPath) -> u32 {
        let mut rng = path.child("materials").rng();
        let m = &self.marina;
        let shares: Vec<f64> = m.hulls.iter().map(|h| h.0).collect();
        let mut set = vec![0; boat::COUNT];
        set[boat::HULL as usize] = m.hulls[rng.weighted(&shares)].1;
        set[boat::DECK as usize] = *rng.pick(&m.decks);
        set[boat::SOLE as usize] = *rng.pick(&m.soles);
        set[boat::CANVAS as usize] = m.canvas[rng.weighted(&[0.3, 0.14, 0.14, 0.12, 0.06, 0.05, 0.12, 0.07])];
        set[boat::GLASS as usize] = m.glass;
        set[boat::SPAR as usize] = m.spar;
        self.set(set)
    }

    /// A set for a dock or a pier.
    pub(in super::super) fn dock_set(&mut self, path: &SeedPath) -> u32 {
        let mut rng = path.child("materials").rng();
        let m = &self.marina;
        let mut set = vec![0; dock::COUNT];
        set[dock::DECK as usize] = *rng.pick(&m.boards);
        set[dock::FLOAT as usize] = m.float;
        set[dock::PILE as usize] = m.pile;
        set[dock::BOX as usize] = m.boxes;
        set[dock::METAL as usize] = m.metal;
        self.set(set)
    }
}

/// Sheltered water: its colour by depth as the coast's, mud and weed below, ripples of a light wind in patches.
fn water(clarity: f64, seed: &impl Fn(&str, u64) -> u32) -> Material {
    let depth = || Field::Raster { raster: 0, channel: 0 };
    let still = |name: &str, wavelength_m: f32, octaves: u8| {
        Field::Noise(Fractal::new(Space::Plan, seed(name, 0), wavelength_m, octaves).gain(0.7))
    };
    let full = Field::Constant(1.0);
    Material {
        brdf: Brdf::Water { slope_variance: 0.006 },
        ..Material::diffuse("harbour water", Class::Water, Bands::grey(0.05))
    }
    .with(Layer::Strata { beds: coast::over_depth(SAND * 0.7, clarity), height: depth(), amount: full })
    .with(Layer::Strata {
        beds: coast::over_depth(Bands::new(0.03, 0.04, 0.036, 0.1), clarity),
        height: depth(),
        amount: still("weed", 21.0, 4).ramp(0.05, 0.5).times(0.6),
    })
    .with(brightness(still("drift", 70.0, 3).times(0.16)))
    .with(brightness(still("wavelets", 2.6, 3).times(0.1)))
    .with(brightness(
        Field::Noise(Fractal::new(Space::Plan, seed("slicks", 0), 30.0, 4).stretched([2.4, 1.0, 1.0])).times(0.14),
    ))
    .bumpy(still("ripples", 1.4, 3), 0.018)
}

/// Height of the water as materials take it, m.
const WATER: f32 = WATER_M as f32;

const SAND: Bands = Bands::new(0.215, 0.275, 0.32, 0.39);

fn seawall(seed: &impl Fn(&str, u64) -> u32) -> Material {
    let wet = Field::Sum(vec![Field::Along(Coordinate::HEIGHT), noise(seed("wall", 1), 3.0, 3).times(0.4)]);
    concrete("sea wall", Class::OtherStructure, 0.24, 0.0, seed("wall", 0))
        .with(Layer::Mix { color: bgr(0.045, 0.055, 0.05), amount: wet.ramp(WATER + 1.0, WATER + 0.4).times(0.8) })
}

/// Tipped stones of half a metre to one and a half, dark where the tide wets them.
fn stones(seed: &impl Fn(&str, u64) -> u32) -> Material {
    let s = seed("stones", 0);
    let gaps = |cell_m: f32, width_m: f32, k: u32| Field::Cracks { space: Space::Plan, seed: s ^ k, cell_m, width_m };
    let wet = Field::Sum(vec![Field::Along(Coordinate::HEIGHT), noise(s ^ 5, 4.0, 3).times(0.5)]);
    Material::diffuse("riprap", Class::Rock, bgr(0.17, 0.19, 0.2))
        .rough(0.5)
        .with(brightness(noise(s ^ 1, 1.3, 3).times(0.55)))
        .with(Layer::Mix { color: bgr(0.028, 0.03, 0.032), amount: gaps(1.15, 0.3, 2).times(0.85) })
        .with(Layer::Mix { color: bgr(0.045, 0.05, 0.05), amount: gaps(0.55, 0.1, 3).times(0.5) })
        .with(Layer::Mix { color: bgr(0.035, 0.042, 0.04), amount: wet.ramp(WATER + 1.2, WATER + 0.4).times(0.75) })
        .bumpy(noise(s ^ 4, 1.2, 2), 0.22)
}

fn sand(seed: &impl Fn(&str, u64) -> u32) -> Material {
    let s = seed("sand", 0);
    let wet = Field::Sum(vec![Field::Along(Coordinate::HEIGHT), noise(s ^ 1, 17.0, 3).times(0.1)]);
    let wrack = Field::Product(vec![
        Field::Sum(vec![Field::Along(Coordinate::HEIGHT), noise(s ^ 2, 11.0, 3).times(0.16)])
            .ramp(WATER + 0.72, WATER + 0.62),
        Field::Sum(vec![Field::Along(Coordinate::HEIGHT), noise(s ^ 2, 11.0, 3).times(0.16)])
            .ramp(WATER + 0.5, WATER + 0.58),
        noise(s ^ 3, 1.2, 3).ramp(-0.1, 0.3),
    ]);
    aged(Material::diffuse("beach", Class::Sand, SAND).rough(0.35), s, 0.08, 0.06)
        .with(brightness(noise(s ^ 4, 1.5, 3).times(0.14)))
        .with(brightness(noise(s ^ 6, 9.0, 3).times(0.08)))
        .with(Layer::Mix { color: bgr(0.06, 0.065, 0.065), amount: wrack.times(0.6) })
        .with(brightness(wet.ramp(WATER + 0.55, WATER + 0.25).times(-0.45)))
}
