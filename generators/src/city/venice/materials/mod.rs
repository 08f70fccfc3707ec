//! Venice's materials. Reflectances are class values of public spectral libraries (ECOSTRESS, USGS splib07, LBNL roofs).
//!
//! Each has texture at three scales (patches of metres, stains, grain) keyed by place, and a shade and hue from the instance.

mod surfaces;

use super::boats::{self, Boat};
use super::house_mesh::slot;
use super::{bridges, ground_slot};
use crate::kit::trees;
use satseed_scene::{Bands, Brdf, Class, Field, Layer, Material, Rng, SeedPath};
use std::collections::BTreeMap;
use surfaces::{aged, bgr, brightness, lawn, mix, noise, slabs, stone, tiles, wall, water, windowed};

/// A book of materials, and the sets drawn from it. Set 0 is the ground's.
#[derive(Debug)]
pub(super) struct Materials {
    /// All materials.
    pub list: Vec<Material>,
    /// Material sets.
    pub sets: Vec<Vec<u32>>,
    known: BTreeMap<Vec<u32>, u32>,
    walls: Vec<u32>,
    blanks: Vec<u32>,
    bricks: Vec<u32>,
    roofs: Vec<u32>,
    ridges: Vec<u32>,
    edges: Vec<u32>,
    woods: Vec<u32>,
    terraces: Vec<u32>,
    stone: u32,
    lead: u32,
    metal: u32,
    dark: u32,
    glass: u32,
    leaves: Vec<u32>,
    bark: u32,
    hulls: Vec<u32>,
    trims: Vec<u32>,
    covers: Vec<u32>,
    boat_glass: u32,
    boat_dark: u32,
    deck: u32,
    arch: u32,
    rail: u32,
    cloths: Vec<u32>,
    pole: u32,
}

/// Colours of plaster: ochre, cream, pink, Venetian red, grey, white, salmon, pale yellow, brown.
const PLASTERS: [[f32; 3]; 11] = [
    [0.15, 0.23, 0.33],
    [0.26, 0.33, 0.39],
    [0.17, 0.20, 0.31],
    [0.08, 0.11, 0.24],
    [0.21, 0.24, 0.26],
    [0.36, 0.40, 0.42],
    [0.14, 0.19, 0.32],
    [0.20, 0.29, 0.37],
    [0.11, 0.15, 0.21],
    [0.10, 0.14, 0.27],
    [0.19, 0.25, 0.31],
];

/// Colours of tiles: from pale and orange to brown and grey.
const TILES: [[f32; 3]; 9] = [
    [0.074, 0.120, 0.236],
    [0.080, 0.118, 0.208],
    [0.094, 0.132, 0.212],
    [0.068, 0.100, 0.180],
    [0.098, 0.128, 0.178],
    [0.078, 0.104, 0.152],
    [0.064, 0.110, 0.226],
    [0.112, 0.148, 0.206],
    [0.060, 0.084, 0.136],
];

impl Materials {
    fn add(&mut self, m: Material) -> u32 {
        self.list.push(m);
        self.list.len() as u32 - 1
    }

    /// The book of one scene; `contrast` is that of texture.
    pub(super) fn new(contrast: f64, path: &SeedPath) -> Self {
        let mut this = Self {
            list: Vec::new(),
            sets: Vec::new(),
            known: BTreeMap::new(),
            walls: Vec::new(),
            blanks: Vec::new(),
            bricks: Vec::new(),
            roofs: Vec::new(),
            ridges: Vec::new(),
            edges: Vec::new(),
            woods: Vec::new(),
            terraces: Vec::new(),
            stone: 0,
            lead: 0,
            metal: 0,
            dark: 0,
            glass: 0,
            leaves: Vec::new(),
            bark: 0,
            hulls: Vec::new(),
            trims: Vec::new(),
            covers: Vec::new(),
            boat_glass: 0,
            boat_dark: 0,
            deck: 0,
            arch: 0,
            rail: 0,
            cloths: Vec::new(),
            pole: 0,
        };
        let seed = |name: &str, k: usize| path.child(name).index(k as u64).hash_u32();
        let k = contrast as f32;
        this.ground(k, &seed);
        this.houses(k, &seed);
        this.boats(k, &seed);
        this.things(k, &seed);
        this
    }

    fn ground(&mut self, k: f32, seed: &impl Fn(&str, usize) -> u32) {
        let mut set = vec![0; ground_slot::COUNT];
        let mut put = |this: &mut Self, slot: u16, m: Material| set[slot as usize] = this.add(m);
        let trachyte = bgr(0.135, 0.152, 0.168);
        put(self, ground_slot::WATER, water(k, seed("water", 0)));
        let quay = stone("quay", Class::OtherStructure, k, seed("quay", 0))
            .with(mix(bgr(0.09, 0.11, 0.15), noise(seed("quay", 1), 1.2, 3).ramp(-0.1, 0.3).times(0.7)))
            .with(mix(
                bgr(0.035, 0.05, 0.04),
                Field::Along(satseed_scene::Coordinate::HEIGHT).ramp(-0.2, -0.55).times(0.9),
            ));
        put(self, ground_slot::QUAY, quay);
        put(self, ground_slot::COPING, stone("coping", Class::Ground, k, seed("coping", 0)));
        put(self, ground_slot::PAVING, slabs("paving", trachyte, [0.95, 0.42], k, seed("paving", 0)));
        let lines = Field::Max(vec![
            Field::Stripes { across: satseed_scene::Coordinate::U, period_m: 9.5, width_m: 0.45, offset_m: 0.0 },
            Field::Stripes { across: satseed_scene::Coordinate::V, period_m: 9.5, width_m: 0.45, offset_m: 0.0 },
        ]);
        let campo = slabs("campo", bgr(0.148, 0.166, 0.182), [0.95, 0.42], k, seed("campo", 0));
        put(self, ground_slot::CAMPO, campo.clone());
        put(self, ground_slot::CAMPO_LINED, campo.with(mix(bgr(0.31, 0.35, 0.38), lines.times(0.55))));
        let court = slabs("court", bgr(0.16, 0.175, 0.19), [0.6, 0.6], k, seed("court", 0));
        put(self, ground_slot::COURT, court);
        let brick = slabs("brick court", bgr(0.085, 0.115, 0.175), [0.25, 0.12], k, seed("court", 1));
        put(self, ground_slot::BRICK, brick);
        put(self, ground_slot::GARDEN, lawn(k, seed("garden", 0)));
        self.sets.push(set);
    }

    fn houses(&mut self, k: f32, seed: &impl Fn(&str, usize) -> u32) {
        let shutters = [
            bgr(0.03, 0.055, 0.03),
            bgr(0.04, 0.06, 0.09),
            bgr(0.05, 0.085, 0.06),
            bgr(0.24, 0.26, 0.27),
            bgr(0.03, 0.04, 0.06),
        ];
        for (n, [b, g, r]) in PLASTERS.into_iter().enumerate() {
            for half in 0..2 {
                let s = seed("plaster", 2 * n + half);
                let m = wall(&format!("plaster {n}"), bgr(b, g, r) * [0.92, 0.78][half], k, s);
                let m = self.add(windowed(m, shutters[(n + 2 * half) % 5], s));
                self.walls.push(m);
            }
            if n % 2 == 0 {
                let m = wall(&format!("blank plaster {n}"), bgr(b, g, r) * 0.75, k, seed("blank", n));
                let m = self.add(m);
                self.blanks.push(m);
            }
        }
        for (n, base) in
            [bgr(0.085, 0.11, 0.175), bgr(0.10, 0.125, 0.165), bgr(0.075, 0.09, 0.14)].into_iter().enumerate()
        {
            let s = seed("brick", n);
            let m = self.add(wall(&format!("brick {n}"), base, k, s));
            self.bricks.push(m);
            self.blanks.push(m);
            let m = self.add(windowed(wall(&format!("brick front {n}"), base, k, s ^ 1), shutters[n], s));
            self.walls.push(m);
        }
        for (n, [b, g, r]) in TILES.into_iter().enumerate() {
            let s = seed("tiles", n);
            let age = [0.3, 0.6, 1.0][n % 3];
            let m = self.add(tiles(&format!("tiles {n}"), bgr(b, g, r), age, k, s));
            self.roofs.push(m);
            let m =
                Material::diffuse(&format!("ridge {n}"), Class::Roof, bgr(b, g, r).lerp(bgr(0.2, 0.22, 0.25), 0.18));
            let m = self.add(aged(m, s ^ 5, 0.15 * k, 0.15 * k));
            self.ridges.push(m);
        }
        for (n, base) in [bgr(0.25, 0.28, 0.3), bgr(0.1, 0.11, 0.13), bgr(0.09, 0.12, 0.18)].into_iter().enumerate() {
            let m =
                aged(Material::diffuse(&format!("eaves {n}"), Class::Roof, base), seed("eaves", n), 0.1 * k, 0.1 * k);
            let m = self.add(m);
            self.edges.push(m);
        }
        for (n, base) in [bgr(0.08, 0.105, 0.135), bgr(0.13, 0.145, 0.155)].into_iter().enumerate() {
            let m = aged(
                Material::diffuse(&format!("boards {n}"), Class::Roof, base),
                seed("boards", n),
                0.15 * k,
                0.15 * k,
            );
            let m = self.add(m);
            self.woods.push(m);
        }
        for (n, base) in [bgr(0.1, 0.14, 0.21), bgr(0.16, 0.18, 0.195), bgr(0.12, 0.13, 0.135)].into_iter().enumerate()
        {
            let m = aged(
                Material::diffuse(&format!("terrace {n}"), Class::Roof, base).rough(0.3),
                seed("terrace", n),
                0.15 * k,
                0.12 * k,
            )
            .with(mix(base * 0.5, noise(seed("terrace", n) ^ 3, 1.8, 3).ramp(0.1, 0.5).times(0.5)));
            let m = self.add(m);
            self.terraces.push(m);
        }
        self.stone = self.add(stone("stone", Class::Facade, k, seed("stone", 0)));
        let lead = Material::diffuse("lead", Class::Roof, bgr(0.205, 0.215, 0.205)).rough(0.2);
        let lead = aged(lead, seed("lead", 0), 0.1 * k, 0.1 * k)
            .with(mix(bgr(0.09, 0.095, 0.09), noise(seed("lead", 1), 1.4, 3).ramp(0.1, 0.5).times(0.5)));
        self.lead = self.add(lead);
        self.metal = self.add(Material::diffuse("sheet metal", Class::Roof, Bands::grey(0.2)));
        self.dark = self.add(Material::diffuse("opening", Class::Roof, Bands::grey(0.03)));
        let mut glass = Material::diffuse("panes", Class::Roof, bgr(0.05, 0.05, 0.05));
        glass.brdf = Brdf::Coated { index: 1.52 };
        self.glass = self.add(glass);
        let steps =
            Field::Stripes { across: satseed_scene::Coordinate::U, period_m: 0.42, width_m: 0.12, offset_m: 0.0 };
        let deck = slabs("bridge steps", bgr(0.15, 0.17, 0.185), [0.9, 0.6], k, seed("deck", 0))
            .with(mix(bgr(0.33, 0.37, 0.4), steps.times(0.8)));
        self.deck = self.add(Material { class: Class::Bridge, ..deck });
        let arch = wall("arch", bgr(0.085, 0.11, 0.17), k, seed("arch", 0));
        self.arch = self.add(Material { class: Class::Bridge, ..arch });
        self.rail = self.add(stone("parapet", Class::Bridge, k, seed("parapet", 0)));
    }

    fn boats(&mut self, k: f32, seed: &impl Fn(&str, usize) -> u32) {
        let paint = |this: &mut Self, name: &str, base: Bands, coat: bool, n: usize| {
            let mut m = Material::diffuse(&format!("{name} {n}"), Class::Boat, base)
                .with(brightness(Field::Variation(0).times(0.22)))
                .with(brightness(Field::object_noise(seed(name, n), 0.7, 2).times(0.2 * k)));
            if coat {
                m.brdf = Brdf::Coated { index: 1.5 };
            }
            this.add(m)
        };
        let hulls = [
            bgr(0.5, 0.52, 0.52),
            bgr(0.2, 0.08, 0.04),
            bgr(0.06, 0.1, 0.05),
            bgr(0.05, 0.1, 0.18),
            bgr(0.3, 0.31, 0.31),
            bgr(0.02, 0.02, 0.02),
            bgr(0.05, 0.06, 0.22),
        ];
        for (n, base) in hulls.into_iter().enumerate() {
            let m = paint(self, "hull", base, true, n);
            self.hulls.push(m);
        }
        for (n, base) in [bgr(0.07, 0.12, 0.2), bgr(0.4, 0.42, 0.42), bgr(0.12, 0.16, 0.2)].into_iter().enumerate() {
            let m = paint(self, "gunwale", base, false, n);
            self.trims.push(m);
        }
        let covers = [
            bgr(0.22, 0.09, 0.04),
            bgr(0.09, 0.1, 0.05),
            bgr(0.22, 0.23, 0.23),
            bgr(0.4, 0.41, 0.4),
            bgr(0.05, 0.05, 0.2),
            bgr(0.1, 0.17, 0.23),
        ];
        for (n, base) in covers.into_iter().enumerate() {
            let m = paint(self, "cover", base, false, n);
            self.covers.push(m);
        }
        let mut glass = Material::diffuse("boat window", Class::Boat, Bands::grey(0.03));
        glass.brdf = Brdf::Coated { index: 1.52 };
        self.boat_glass = self.add(glass);
        self.boat_dark = self.add(Material::diffuse("boat motor", Class::Boat, Bands::grey(0.04)));
    }

    fn things(&mut self, _k: f32, seed: &impl Fn(&str, usize) -> u32) {
        let leaf = [
            Bands::new(0.03, 0.073, 0.042, 0.42),
            Bands::new(0.036, 0.085, 0.05, 0.44),
            Bands::new(0.03, 0.066, 0.045, 0.4),
            Bands::new(0.022, 0.046, 0.031, 0.3),
        ];
        for (k, base) in leaf.into_iter().enumerate() {
            let mut m = Material::diffuse(&format!("leaves {k}"), Class::Tree, base)
                .with(brightness(Field::object_noise(seed("leaf", k), 1.3, 2).times(0.45)))
                .with(brightness(noise(seed("leaf", 9 + k), 0.35, 2).times(0.35)))
                .with(brightness(Field::Variation(0).times(0.2)))
                .with(Layer::Tint { tint: Bands::new(-0.05, 0.0, 0.22, 0.0), amount: Field::Variation(1) });
            m.brdf = Brdf::Leaf { transmission: Bands::new(0.01, 0.035, 0.015, 0.3) };
            let m = self.add(m);
            self.leaves.push(m);
        }
        self.bark = self.add(Material::diffuse("bark", Class::Tree, bgr(0.07, 0.085, 0.1)));
        let cloths = [
            bgr(0.5, 0.52, 0.52),
            bgr(0.28, 0.36, 0.42),
            bgr(0.06, 0.09, 0.3),
            bgr(0.16, 0.1, 0.06),
            bgr(0.04, 0.04, 0.05),
            bgr(0.1, 0.12, 0.1),
        ];
        for (n, base) in cloths.into_iter().enumerate() {
            let m = Material::diffuse(&format!("cloth {n}"), Class::OtherStructure, base)
                .with(brightness(Field::Variation(0).times(0.25)));
            let m = self.add(m);
            self.cloths.push(m);
        }
        self.pole = self.add(
            Material::diffuse("pile", Class::OtherStructure, bgr(0.07, 0.085, 0.1))
                .with(brightness(Field::Variation(0).times(0.25))),
        );
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

    /// A set for a house.
    pub(super) fn house_set(&mut self, path: &SeedPath) -> u32 {
        let mut rng = path.child("materials").rng();
        let tile = rng.weighted(&[1.2, 1.7, 1.6, 1.2, 1.4, 1.2, 0.8, 1.2, 0.8]);
        let blank = *rng.pick(&self.blanks);
        let mut set = vec![blank; slot::COUNT];
        set[slot::WALL as usize] = *rng.pick(&self.walls);
        set[slot::ROOF as usize] = self.roofs[tile];
        set[slot::RIDGE as usize] = self.ridges[tile];
        set[slot::EDGE as usize] = *rng.pick(&self.edges);
        set[slot::CHIMNEY as usize] = *rng.pick(&self.blanks);
        set[slot::WOOD as usize] = *rng.pick(&self.woods);
        set[slot::DARK as usize] = self.dark;
        set[slot::STONE as usize] = self.stone;
        set[slot::GLASS as usize] = self.glass;
        set[slot::METAL as usize] = self.metal;
        set[slot::TERRACE as usize] = *rng.pick(&self.terraces);
        self.set(set)
    }

    /// A set for a church.
    pub(super) fn church_set(&mut self, path: &SeedPath) -> u32 {
        let mut rng = path.child("materials").rng();
        let brick = *rng.pick(&self.bricks);
        let mut set = vec![brick; slot::COUNT];
        let tile = rng.below(self.roofs.len() as u64) as usize;
        set[slot::ROOF as usize] = self.roofs[tile];
        set[slot::RIDGE as usize] = self.ridges[tile];
        set[slot::EDGE as usize] = self.edges[0];
        set[slot::DARK as usize] = self.dark;
        set[slot::STONE as usize] = self.stone;
        set[slot::GLASS as usize] = self.glass;
        set[slot::METAL as usize] = self.lead;
        self.set(set)
    }

    /// A set for a bridge.
    pub(super) fn bridge_set(&mut self) -> u32 {
        let mut set = vec![0; bridges::slot::COUNT];
        set[bridges::slot::DECK as usize] = self.deck;
        set[bridges::slot::SIDE as usize] = self.arch;
        set[bridges::slot::RAIL as usize] = self.rail;
        self.set(set)
    }

    /// A set for a boat.
    pub(super) fn boat_set(&mut self, boat: Boat, rng: &mut Rng) -> u32 {
        let mut set = vec![0; boats::slot::COUNT];
        let hull = match boat {
            Boat::Gondola => 5,
            Boat::Vaporetto => 0,
            Boat::Taxi => 3,
            _ => rng.weighted(&[0.36, 0.16, 0.12, 0.14, 0.12, 0.05, 0.05]),
        };
        set[boats::slot::HULL as usize] = self.hulls[hull];
        set[boats::slot::TRIM as usize] = match boat {
            Boat::Gondola => self.boat_dark,
            Boat::Taxi => self.trims[0],
            _ => *rng.pick(&self.trims),
        };
        set[boats::slot::FLOOR as usize] = self.trims[if rng.chance(0.5) { 0 } else { 2 }];
        set[boats::slot::COVER as usize] = if boat == Boat::Gondola {
            self.covers[4]
        } else {
            self.covers[rng.weighted(&[0.34, 0.2, 0.18, 0.12, 0.05, 0.11])]
        };
        if boat == Boat::Gondola {
            set[boats::slot::FLOOR as usize] = self.boat_dark;
            if rng.chance(0.6) {
                set[boats::slot::COVER as usize] = self.boat_dark;
            }
        }
        set[boats::slot::CABIN as usize] = if rng.chance(0.8) { self.hulls[0] } else { self.hulls[4] };
        set[boats::slot::GLASS as usize] = self.boat_glass;
        set[boats::slot::DARK as usize] = self.boat_dark;
        self.set(set)
    }

    /// A set for a tree of a species.
    pub(super) fn tree_set(&mut self, species: usize) -> u32 {
        let mut set = vec![0; 2];
        set[trees::BARK as usize] = self.bark;
        set[trees::LEAVES as usize] = self.leaves[species % self.leaves.len()];
        self.set(set)
    }

    /// A set of two slots: piles and stone, then cloth of a colour.
    pub(super) fn cloth_set(&mut self, pick: usize) -> u32 {
        let set = vec![self.pole, self.cloths[pick % self.cloths.len()]];
        self.set(set)
    }

    /// A set of two slots: stone, and what is dark.
    pub(super) fn stone_set(&mut self) -> u32 {
        let set = vec![self.rail, self.boat_dark];
        self.set(set)
    }
}
