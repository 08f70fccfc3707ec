//! California's materials. Reflectances are class values of public spectral libraries (ECOSTRESS, USGS splib07, LBNL
//! roofs: red tile 0.18 to 0.33, dark shingle 0.08 to 0.19, light shingle 0.20).

mod ground;
mod marina;
mod urban;

use super::lot::Kind;
use crate::city::toronto::materials::surfaces::{
    aged, bgr, brightness, concrete, glass, membrane, metal, noise, repeating, wall, with_windows,
};
use crate::kit::buildings::slot;
use crate::kit::{shrub, trees, vehicles};
use satseed_scene::{Bands, Brdf, Class, Coordinate, Field, Fractal, Layer, Material, Rng, SeedPath, Space};
use std::collections::BTreeMap;

/// A book of materials, and the sets drawn from it.
#[derive(Debug, Default)]
pub(super) struct Materials {
    /// All materials.
    pub(super) list: Vec<Material>,
    /// Material sets.
    pub(super) sets: Vec<Vec<u32>>,
    known: BTreeMap<Vec<u32>, u32>,
    stucco: Vec<u32>,
    shop_walls: Vec<u32>,
    /// Roofs of houses with their shares.
    roofs: Vec<(f64, u32)>,
    flat_roofs: Vec<u32>,
    trim: Vec<u32>,
    covers: Vec<u32>,
    doors: Vec<u32>,
    metal: Vec<u32>,
    strip: u32,
    windows: u32,
    panel: u32,
    dark: u32,
    leaves: Vec<u32>,
    fronds: u32,
    palm_stem: u32,
    bark: u32,
    shrubs: Vec<u32>,
    boards: Vec<u32>,
    blocks: Vec<u32>,
    paints: Vec<(f64, u32)>,
    car_glass: u32,
    tyre: u32,
    cargo: Vec<u32>,
    lamp: u32,
    steel: u32,
    freeway: Vec<u32>,
    urban: urban::Book,
    marina: marina::Book,
}

impl Materials {
    fn add(&mut self, m: Material) -> u32 {
        self.list.push(m);
        self.list.len() as u32 - 1
    }

    /// The book of one scene. The ground's materials become set 0.
    pub(super) fn new(path: &SeedPath) -> Self {
        let mut this = Self::default();
        let seed = |name: &str, k: u64| path.child(name).index(k).hash_u32();
        this.freeway = ground::freeway(&seed).into_iter().map(|m| this.add(m)).collect();
        let set = ground::materials(&seed).into_iter().map(|m| this.add(m)).collect();
        this.sets.push(set);
        this.walls(&seed);
        this.roofs(&seed);
        this.plants(&seed);
        this.things(&seed);
        this
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

    fn walls(&mut self, seed: &impl Fn(&str, u64) -> u32) {
        // Stucco in whites, creams, beiges, greys and a few stronger colours.
        let stucco = [
            bgr(0.44, 0.49, 0.51),
            bgr(0.33, 0.42, 0.47),
            bgr(0.25, 0.34, 0.4),
            bgr(0.2, 0.28, 0.35),
            bgr(0.27, 0.3, 0.32),
            bgr(0.17, 0.19, 0.2),
            bgr(0.17, 0.23, 0.31),
            bgr(0.22, 0.27, 0.26),
        ];
        for (k, base) in stucco.into_iter().enumerate() {
            let s = seed("stucco", k as u64);
            let m = self.add(with_windows(wall(&format!("stucco {k}"), base, s), [1.2, 1.6, 0.9][k % 3], 1.25, s));
            self.stucco.push(m);
        }
        for (k, base) in [bgr(0.36, 0.42, 0.45), bgr(0.2, 0.27, 0.33), bgr(0.26, 0.28, 0.3), bgr(0.12, 0.15, 0.2)]
            .into_iter()
            .enumerate()
        {
            let s = seed("shop wall", k as u64);
            let m = self.add(with_windows(wall(&format!("shop wall {k}"), base, s), 2.2, 1.7, s));
            self.shop_walls.push(m);
        }
        for (k, level) in [0.5, 0.36, 0.2, 0.1].into_iter().enumerate() {
            let m = Material::diffuse(&format!("trim {k}"), Class::Roof, bgr(0.88, 0.96, 1.0) * level).rough(0.3);
            let m = self.add(aged(m, seed("trim", k as u64), 0.1, 0.08));
            self.trim.push(m);
        }
        for (k, base) in [bgr(0.46, 0.49, 0.5), bgr(0.1, 0.14, 0.19), bgr(0.22, 0.26, 0.29), bgr(0.06, 0.085, 0.12)]
            .into_iter()
            .enumerate()
        {
            let m = Material::diffuse(&format!("patio cover {k}"), Class::Roof, base).rough(0.3);
            let laths = repeating(Coordinate::U, 0.45, 0.14, 0.0);
            let m = self.add(aged(m, seed("cover", k as u64), 0.16, 0.1).with(brightness(laths.times(-0.4))));
            self.covers.push(m);
        }
        for (k, base) in [bgr(0.55, 0.58, 0.6), bgr(0.33, 0.38, 0.42), bgr(0.09, 0.13, 0.19)].into_iter().enumerate() {
            let m = Material::diffuse(&format!("garage door {k}"), Class::Facade, base).rough(0.3);
            let m = self.add(m.with(brightness(repeating(Coordinate::V, 0.53, 0.05, 0.0).times(-0.3))));
            self.doors.push(m);
        }
        self.windows =
            self.add(glass("shop window", bgr(0.05, 0.05, 0.05), bgr(0.14, 0.14, 0.14), 1.0, 0.25, seed("window", 0)));
        self.dark = self.add(Material::diffuse("opening", Class::Roof, bgr(0.03, 0.03, 0.03)));
    }

    fn roofs(&mut self, seed: &impl Fn(&str, u64) -> u32) {
        // Composition shingle in greys and browns; concrete and clay tile.
        let shingle = [
            (0.13, bgr(0.075, 0.077, 0.08)),
            (0.12, bgr(0.105, 0.11, 0.117)),
            (0.13, bgr(0.135, 0.147, 0.16)),
            (0.13, bgr(0.085, 0.102, 0.125)),
            (0.1, bgr(0.115, 0.14, 0.172)),
            (0.07, bgr(0.18, 0.19, 0.198)),
        ];
        for (k, (share, base)) in shingle.into_iter().enumerate() {
            let s = seed("shingle", k as u64);
            let courses = Field::Cells { space: Space::Uv, seed: s, size_m: [0.9, 0.29, 0.0], stagger: 0.5 };
            let m = pitched(&format!("shingle {k}"), base, s).with(brightness(courses.times(0.13)));
            let m = self.add(m);
            self.roofs.push((share, m));
        }
        let tile = [
            (0.09, bgr(0.085, 0.125, 0.2)),
            (0.08, bgr(0.115, 0.15, 0.19)),
            (0.07, bgr(0.09, 0.14, 0.25)),
            (0.06, bgr(0.14, 0.155, 0.17)),
            (0.04, bgr(0.155, 0.2, 0.25)),
        ];
        for (k, (share, base)) in tile.into_iter().enumerate() {
            let s = seed("tile", k as u64);
            let each = Field::Cells { space: Space::Uv, seed: s, size_m: [0.33, 0.4, 0.0], stagger: 0.0 };
            let lines = repeating(Coordinate::V, 0.4, 0.06, 0.0);
            let rolls = repeating(Coordinate::U, 0.33, 0.12, 0.0);
            let m = pitched(&format!("tile {k}"), base, s)
                .with(brightness(each.times(0.18)))
                .with(brightness(lines.times(-0.25)))
                .with(brightness(rolls.times(-0.16)));
            let m = self.add(m);
            self.roofs.push((share, m));
        }
        let flat: [(Bands, f32, f32); 6] = [
            (bgr(0.54, 0.57, 0.58), 2.6, 0.32),
            (bgr(0.36, 0.38, 0.385), 2.2, 0.3),
            (bgr(0.66, 0.68, 0.68), 2.8, 0.22),
            (bgr(0.2, 0.228, 0.25), 0.0, 0.3),
            (bgr(0.28, 0.32, 0.35), 1.0, 0.3),
            (bgr(0.14, 0.146, 0.15), 1.0, 0.3),
        ];
        for (k, (base, strip, stain)) in flat.into_iter().enumerate() {
            let m = self.add(membrane(&format!("flat roof {k}"), base, strip, stain, seed("flat", k as u64)));
            self.flat_roofs.push(m);
        }
        for (k, level) in [0.42, 0.3, 0.16].into_iter().enumerate() {
            let m = self.add(metal(&format!("sheet metal {k}"), level, seed("metal", k as u64)));
            self.metal.push(m);
        }
        self.strip = self.add(membrane("roof edge", bgr(0.17, 0.18, 0.19), 0.0, 0.3, seed("edge", 0)));
        let mut panel = Material::diffuse("solar panel", Class::Roof, bgr(0.05, 0.037, 0.033))
            .with(Layer::Mix { color: bgr(0.2, 0.2, 0.2), amount: repeating(Coordinate::U, 1.02, 0.05, -0.025) })
            .with(Layer::Mix { color: bgr(0.2, 0.2, 0.2), amount: repeating(Coordinate::V, 1.68, 0.05, -0.025) });
        panel.brdf = Brdf::Coated { index: 1.5 };
        self.panel = self.add(panel);
    }

    fn plants(&mut self, seed: &impl Fn(&str, u64) -> u32) {
        let leaf = |name: String, class: Class, base: Bands, s: u32| {
            let mut m = Material::diffuse(&name, class, base)
                .with(brightness(Field::object_noise(s, 1.3, 2).times(0.45)))
                .with(brightness(noise(s ^ 0x3, 0.35, 2).times(0.35)))
                .with(brightness(Field::Variation(0).times(0.25)))
                .with(Layer::Tint { tint: Bands::new(-0.05, 0.0, 0.22, 0.0), amount: Field::Variation(1) });
            m.brdf = Brdf::Leaf { transmission: Bands::new(0.01, 0.03, 0.014, 0.3) };
            m
        };
        let leaves = [
            Bands::new(0.03, 0.066, 0.042, 0.4),
            Bands::new(0.034, 0.078, 0.048, 0.42),
            Bands::new(0.04, 0.07, 0.052, 0.38),
            Bands::new(0.026, 0.054, 0.034, 0.36),
            Bands::new(0.044, 0.082, 0.06, 0.4),
            Bands::new(0.05, 0.074, 0.072, 0.36),
        ];
        for (k, base) in leaves.into_iter().enumerate() {
            let m = self.add(leaf(format!("leaves {k}"), Class::Tree, base, seed("leaf", k as u64)));
            self.leaves.push(m);
        }
        self.fronds =
            self.add(leaf("fronds".to_owned(), Class::Tree, Bands::new(0.04, 0.078, 0.052, 0.38), seed("frond", 0)));
        let shrubs = [
            Bands::new(0.034, 0.072, 0.044, 0.4),
            Bands::new(0.03, 0.06, 0.04, 0.36),
            Bands::new(0.052, 0.082, 0.07, 0.35),
            Bands::new(0.06, 0.075, 0.1, 0.34),
        ];
        for (k, base) in shrubs.into_iter().enumerate() {
            let m = self.add(leaf(format!("shrub {k}"), Class::LowVegetation, base, seed("shrub", k as u64)));
            self.shrubs.push(m);
        }
        self.bark = self.add(Material::diffuse("bark", Class::Tree, bgr(0.07, 0.085, 0.1)));
        self.palm_stem = self.add(Material::diffuse("palm stem", Class::Tree, bgr(0.1, 0.125, 0.15)));
    }

    fn things(&mut self, seed: &impl Fn(&str, u64) -> u32) {
        for (k, base) in [bgr(0.09, 0.12, 0.155), bgr(0.13, 0.15, 0.17), bgr(0.07, 0.095, 0.13), bgr(0.5, 0.52, 0.53)]
            .into_iter()
            .enumerate()
        {
            let m = Material::diffuse(&format!("boards {k}"), Class::OtherStructure, base).rough(0.3);
            let m = self.add(aged(m, seed("boards", k as u64), 0.16, 0.14));
            self.boards.push(m);
        }
        for (k, level) in [0.3, 0.24].into_iter().enumerate() {
            let m = self.add(concrete(
                &format!("block wall {k}"),
                Class::OtherStructure,
                level,
                0.0,
                seed("blocks", k as u64),
            ));
            self.blocks.push(m);
        }
        let paints = [
            (0.30, bgr(0.62, 0.63, 0.63)),
            (0.22, bgr(0.025, 0.025, 0.025)),
            (0.15, bgr(0.13, 0.135, 0.14)),
            (0.17, bgr(0.34, 0.35, 0.35)),
            (0.06, bgr(0.03, 0.03, 0.22)),
            (0.06, bgr(0.2, 0.08, 0.04)),
            (0.015, bgr(0.06, 0.1, 0.05)),
            (0.025, bgr(0.16, 0.22, 0.26)),
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
    }

    /// A set for a building. `massing`: it is only blocks, whose walls carry windows as texture.
    pub(super) fn building_set(&mut self, kind: Kind, massing: bool, path: &SeedPath) -> u32 {
        if let Kind::Urban(usage) = kind {
            return self.urban_set(usage, massing, path);
        }
        let mut rng = path.child("materials").rng();
        let of = |list: &[u32], rng: &mut Rng| *rng.pick(list);
        let house = matches!(kind, Kind::House | Kind::Shed);
        let shares: Vec<f64> = self.roofs.iter().map(|r| r.0).collect();
        let roof = if house { self.roofs[rng.weighted(&shares)].1 } else { of(&self.flat_roofs, &mut rng) };
        let wall =
            if house || kind == Kind::Apartments { of(&self.stucco, &mut rng) } else { of(&self.shop_walls, &mut rng) };
        let mut set = vec![0; slot::COUNT];
        set[slot::WALL as usize] = wall;
        set[slot::GLASS as usize] = self.windows;
        set[slot::SLAB as usize] = wall;
        set[slot::COPING as usize] = of(&self.trim, &mut rng);
        set[slot::STRIP as usize] = self.strip;
        set[slot::ROOF as usize] = roof;
        set[slot::METAL as usize] = of(&self.metal, &mut rng);
        set[slot::SHOP as usize] = self.windows;
        set[slot::GUARD as usize] = of(&self.doors, &mut rng);
        set[slot::PANEL as usize] = self.panel;
        set[slot::GREEN as usize] = self.shrubs[0];
        set[slot::DARK as usize] = self.dark;
        set[slot::TERRACE as usize] = if house { of(&self.covers, &mut rng) } else { of(&self.flat_roofs, &mut rng) };
        self.set(set)
    }

    /// A set for a broad-leaved tree.
    pub(super) fn tree_set(&mut self, kind: usize) -> u32 {
        let mut set = vec![0; 2];
        set[trees::BARK as usize] = self.bark;
        set[trees::LEAVES as usize] = self.leaves[kind % self.leaves.len()];
        self.set(set)
    }

    /// A set for a palm.
    pub(super) fn palm_set(&mut self) -> u32 {
        let mut set = vec![0; 2];
        set[trees::BARK as usize] = self.palm_stem;
        set[trees::LEAVES as usize] = self.fronds;
        self.set(set)
    }

    /// A set for a shrub.
    pub(super) fn shrub_set(&mut self, kind: usize) -> u32 {
        let mut set = vec![0; 2];
        set[shrub::LEAF_SLOT as usize] = self.shrubs[kind % self.shrubs.len()];
        set[shrub::STEM_SLOT as usize] = self.bark;
        self.set(set)
    }

    /// A set for the fences of a lot: boards and blocks.
    pub(super) fn fence_set(&mut self, path: &SeedPath) -> u32 {
        let mut rng = path.child("materials").rng();
        let boards = self.boards[rng.weighted(&[0.36, 0.3, 0.22, 0.12])];
        let blocks = *rng.pick(&self.blocks);
        self.set(vec![boards, blocks])
    }

    /// A set for a vehicle.
    pub(super) fn vehicle_set(&mut self, body: vehicles::Body, rng: &mut Rng) -> u32 {
        let weights: Vec<f64> = self.paints.iter().map(|p| p.0).collect();
        let mut paint = self.paints[rng.weighted(&weights)].1;
        if matches!(body, vehicles::Body::Bus | vehicles::Body::Truck) && rng.chance(0.6) {
            paint = self.paints[0].1;
        }
        let mut set = vec![0; 5];
        set[vehicles::PAINT as usize] = paint;
        set[vehicles::GLASS as usize] = self.car_glass;
        set[vehicles::TYRE as usize] = self.tyre;
        set[vehicles::BOX as usize] = *rng.pick(&self.cargo);
        set[vehicles::LAMP as usize] = self.lamp;
        self.set(set)
    }

    /// The set of freeways, embankments and piers.
    pub(super) fn freeway_set(&mut self) -> u32 {
        self.set(self.freeway.clone())
    }

    /// A set of one slot: street lights.
    pub(super) fn steel_set(&mut self) -> u32 {
        self.set(vec![self.steel])
    }
}

/// A pitched roof's covering: patches of age, streaks down the slope, dirt, a shade and tint of its own.
fn pitched(name: &str, base: Bands, seed: u32) -> Material {
    let m = Material::diffuse(name, Class::Roof, base).rough(0.4);
    let streaks = Fractal::new(Space::Uv, seed ^ 0x1f, 0.8, 2).stretched([1.0, 5.0, 1.0]);
    aged(m, seed, 0.13, 0.12)
        .with(brightness(Field::Noise(streaks).times(0.12)))
        .with(Layer::Mix { color: base * 0.6, amount: noise(seed ^ 0x2b, 4.0, 3).ramp(0.15, 0.6).times(0.45) })
        .with(brightness(Field::Variation(2).times(0.22)))
        .with(Layer::Tint { tint: Bands::new(-0.07, 0.0, 0.08, 0.08), amount: Field::Variation(3) })
}
