//! Materials of downtown and of the low blocks: bleached asphalt, pale concrete, white and tan roofs, stucco, granite, glass.

use super::Materials;
use crate::city::california::urban::{Use, ground as slots, part};
use crate::city::toronto::ground_slot as street;
use crate::city::toronto::materials::surfaces::{
    aged, asphalt, banded, bgr, brightness, concrete, glass, lawn, membrane, metal, noise, paint_left, repeating, road,
    wall, with_windows,
};
use crate::city::toronto::materials::{ROAD_AGES, STREET_KINDS};
use crate::kit::buildings::slot;
use satseed_scene::{Bands, Brdf, Class, Coordinate, Field, Layer, Material, Rng, SeedPath};

/// What urban buildings draw from.
#[derive(Debug, Default)]
pub(super) struct Book {
    /// Stone, precast and stucco of tall buildings.
    walls: Vec<u32>,
    /// The same with their floors as texture, for what is only blocks.
    banded: Vec<u32>,
    /// Stucco with windows.
    homes: Vec<u32>,
    /// Shop walls without windows and with them.
    shops: Vec<u32>,
    /// Tilted-up concrete and sheet metal.
    halls: Vec<u32>,
    office_glass: Vec<u32>,
    home_glass: Vec<u32>,
    shop_glass: u32,
    guards: Vec<u32>,
    roofs: Vec<u32>,
    terraces: Vec<u32>,
    concrete: Vec<u32>,
    decks: Vec<u32>,
    water: u32,
    paint: u32,
    pads: Vec<u32>,
    canopies: Vec<u32>,
    steel: Vec<u32>,
    bridge: [u32; 3],
}

/// Asphalt that sun and dust have bleached.
fn bleached(m: Material, amount: f32, seed: u32) -> Material {
    let dust = noise(seed ^ 0x91, 21.0, 3).affine(0.35, amount).ramp(0.0, 1.0);
    m.with(Layer::Mix { color: bgr(0.185, 0.2, 0.213), amount: dust })
}

/// A parking lot of an age: stalls of 2.6 m in rows whose pattern repeats every 17.5 m, oil in the middle of stalls.
fn lot(name: &str, class: Class, age: f32, seed: u32) -> Material {
    let rows = repeating(Coordinate::V, 17.5, 11.0, -5.5);
    let wear = noise(seed ^ 0x11, 5.0, 3).affine(0.7, 0.95 - 0.5 * age).ramp(0.0, 1.0);
    let lines = Field::Product(vec![repeating(Coordinate::U, 2.6, 0.11, -0.055), rows.clone(), wear]);
    let oil =
        Field::Product(vec![repeating(Coordinate::U, 2.6, 0.8, 0.9), rows, noise(seed ^ 0x12, 1.7, 2).ramp(0.0, 0.5)]);
    let base = match class {
        Class::Roof => concrete(name, class, 0.27 - 0.05 * age, 9.1, seed),
        _ => bleached(asphalt(name, age, seed), 0.45 * age, seed),
    };
    base.with(Layer::Mix { color: bgr(0.06, 0.06, 0.06), amount: oil.times(0.4) })
        .with(Layer::Mix { color: bgr(0.42, 0.44, 0.45), amount: lines.times(0.75) })
}

/// Pavers of a square in fields of two shades.
fn pavers(name: &str, base: Bands, field_m: f32, seed: u32) -> Material {
    let fields =
        Field::Product(vec![repeating(Coordinate::U, field_m, 0.6, 0.0), noise(seed, 60.0, 1).ramp(-1.0, -0.9)]);
    let cross = repeating(Coordinate::V, field_m, 0.6, 0.0);
    aged(Material::diffuse(name, Class::Ground, base).rough(0.35), seed, 0.1, 0.08)
        .with(brightness(Field::Max(vec![fields, cross]).times(-0.22)))
        .with(Layer::Mix { color: base * 0.55, amount: noise(seed ^ 0x21, 3.0, 3).ramp(0.25, 0.6).times(0.4) })
}

/// The ground's materials beyond the suburb's, in the order of their slots.
fn ground(seed: &impl Fn(&str, u64) -> u32) -> Vec<Material> {
    let first = slots::of(0) as usize;
    let blank = Material::diffuse("blank", Class::Ground, Bands::grey(0.2));
    let mut out = vec![blank; slots::COUNT - first];
    let mut put = |slot: u16, m: Material| out[slots::of(slot) as usize - first] = m;
    let s = |name: &str| seed(name, 20);
    put(street::CARRIAGEWAY, bleached(asphalt("city carriageway", 0.75, s("carriageway")), 0.25, s("carriageway")));
    put(street::KERB, concrete("city kerb", Class::Ground, 0.3, 0.0, s("kerb")));
    put(street::SIDEWALK, concrete("city sidewalk", Class::Ground, 0.3, 1.5, s("sidewalk")));
    put(street::PAVING, concrete("city paving", Class::Ground, 0.26, 2.4, s("paving")));
    put(street::PAVING_DARK, bleached(asphalt("city yard", 0.9, s("yard asphalt")), 0.3, s("yard asphalt")));
    put(street::PLAZA, concrete("city plaza", Class::Ground, 0.27, 1.2, s("plaza")));
    put(street::LAWN, lawn("city lawn", 0.45, s("lawn")));
    put(street::YARD, lawn("dry yard", 1.0, s("yard")));
    put(street::LANE, bleached(asphalt("alley", 1.0, s("lane")), 0.35, s("lane")));
    let granite = Material::diffuse("decomposed granite", Class::Ground, bgr(0.16, 0.215, 0.265)).rough(0.5);
    put(street::PATH, aged(granite, s("path"), 0.12, 0.1));
    let dirt = Material::diffuse("city dirt", Class::Ground, bgr(0.135, 0.18, 0.225)).rough(0.5);
    put(street::SOIL, aged(dirt, s("soil"), 0.2, 0.15));
    let wear = paint_left(s("paint"), 3.0, 0.7);
    let ladder = Field::Product(vec![repeating(Coordinate::V, 1.25, 0.6, 0.2), wear.clone()]);
    let marked = |name: &str, amount: Field| {
        bleached(asphalt(name, 0.75, s("carriageway")), 0.25, s("carriageway"))
            .with(Layer::Mix { color: bgr(0.43, 0.45, 0.46), amount: amount.times(0.8) })
    };
    put(street::CROSSING, marked("city crossing", ladder));
    put(street::STOP, marked("city stop bar", wear));
    put(street::PATCH_NEW, asphalt("city patch", 0.25, s("patch")));
    put(street::PATCH_OLD, concrete("city trench", Class::Road, 0.24, 0.0, s("trench")));
    put(street::MANHOLE, asphalt("city manhole", 0.1, s("manhole")));
    for kind in 0..STREET_KINDS {
        for age in 0..ROAD_AGES {
            let index = kind * ROAD_AGES + age;
            let seed = seed("city road", u64::from(index));
            let m = bleached(road(kind, age, seed), [0.05, 0.2, 0.35][usize::from(age)], seed);
            put(street::ROAD + index, m);
        }
    }
    let last = street::COUNT as u16;
    put(street::PARKING, lot("city lot", Class::Road, 0.8, s("lot")));
    for (k, age) in [(0, 0.1), (1, 0.7), (2, 1.0)] {
        put(last + k, lot(&format!("lot {k}"), Class::Road, age, seed("lot", u64::from(k))));
    }
    put(last + 3, bleached(asphalt("yard asphalt, sealed", 0.4, s("yard 3")), 0.05, s("yard 3")));
    put(last + 4, bleached(asphalt("yard asphalt, bleached", 1.0, s("yard 4")), 0.5, s("yard 4")));
    put(last + 5, concrete("yard concrete", Class::Ground, 0.31, 4.0, s("yard 5")));
    let weeds =
        Field::Product(vec![noise(s("yard 6"), 6.0, 3).ramp(0.05, 0.4), noise(s("yard 7"), 1.3, 2).ramp(0.0, 0.4)]);
    let bare = Material::diffuse("yard dirt", Class::Ground, bgr(0.14, 0.185, 0.23)).rough(0.5);
    let bare = aged(bare, s("yard 8"), 0.2, 0.16)
        .with(Layer::Mix {
            color: bgr(0.19, 0.235, 0.27),
            amount: noise(s("yard 9"), 11.0, 4).ramp(0.0, 0.4).times(0.6),
        })
        .with(Layer::Mix { color: Bands::new(0.06, 0.095, 0.09, 0.3), amount: weeds.times(0.7) });
    put(last + 6, bare);
    put(last + 7, pavers("granite square", bgr(0.21, 0.235, 0.255), 7.2, s("square 0")));
    put(last + 8, pavers("brick square", bgr(0.125, 0.155, 0.21), 6.0, s("square 1")));
    put(last + 9, pavers("pale square", bgr(0.29, 0.325, 0.345), 9.6, s("square 2")));
    out
}

impl Materials {
    /// Adds what the urban variants need: slots of the ground and materials of buildings.
    pub(in crate::city::california) fn add_urban(&mut self, path: &SeedPath) {
        let seed = |name: &str, k: u64| path.child("urban").child(name).index(k).hash_u32();
        let more: Vec<u32> = ground(&seed).into_iter().map(|m| self.add(m)).collect();
        self.sets[0].extend(more);
        self.urban_walls(&seed);
        self.urban_roofs(&seed);
        self.urban_things(&seed);
    }

    fn urban_walls(&mut self, seed: &impl Fn(&str, u64) -> u32) {
        let stone = [
            bgr(0.38, 0.42, 0.44),
            bgr(0.3, 0.36, 0.4),
            bgr(0.22, 0.28, 0.33),
            bgr(0.16, 0.2, 0.27),
            bgr(0.26, 0.27, 0.275),
            bgr(0.5, 0.52, 0.53),
            bgr(0.1, 0.115, 0.14),
            bgr(0.12, 0.15, 0.22),
        ];
        for (k, base) in stone.into_iter().enumerate() {
            let s = seed("stone", k as u64);
            let m = self.add(wall(&format!("stone {k}"), base, s));
            self.urban.walls.push(m);
            let m = self.add(banded(wall(&format!("banded stone {k}"), base, s), s));
            self.urban.banded.push(m);
        }
        let stucco = [
            bgr(0.5, 0.53, 0.54),
            bgr(0.36, 0.44, 0.48),
            bgr(0.28, 0.36, 0.42),
            bgr(0.24, 0.34, 0.42),
            bgr(0.4, 0.41, 0.4),
            bgr(0.2, 0.22, 0.23),
            bgr(0.2, 0.29, 0.37),
            bgr(0.3, 0.36, 0.33),
        ];
        for (k, base) in stucco.into_iter().enumerate() {
            let s = seed("home", k as u64);
            let m = with_windows(wall(&format!("apartment stucco {k}"), base, s), [1.5, 1.1, 1.9][k % 3], 1.2, s);
            let m = self.add(m);
            self.urban.homes.push(m);
            let s = seed("shop", k as u64);
            let m = wall(&format!("shop stucco {k}"), base * 0.9, s);
            let m = if k % 2 == 0 { with_windows(m, 2.4, 1.9, s) } else { m };
            let m = self.add(m);
            self.urban.shops.push(m);
        }
        for (k, base) in [bgr(0.34, 0.36, 0.37), bgr(0.27, 0.31, 0.34), bgr(0.2, 0.24, 0.27), bgr(0.42, 0.44, 0.45)]
            .into_iter()
            .enumerate()
        {
            let joints = repeating(Coordinate::U, 7.3, 0.12, 0.0);
            let m = wall(&format!("hall {k}"), base, seed("hall", k as u64)).with(brightness(joints.times(-0.3)));
            let m = self.add(m);
            self.urban.halls.push(m);
        }
        // Bronze, blue, green, silver and black glass.
        let tints = [
            bgr(0.035, 0.045, 0.055),
            bgr(0.085, 0.07, 0.05),
            bgr(0.065, 0.075, 0.05),
            bgr(0.12, 0.12, 0.115),
            bgr(0.03, 0.03, 0.03),
            bgr(0.06, 0.06, 0.052),
        ];
        let frames = [bgr(0.08, 0.1, 0.12), bgr(0.34, 0.35, 0.36), bgr(0.16, 0.165, 0.17)];
        for (k, tint) in tints.into_iter().enumerate() {
            let s = seed("glass", k as u64);
            let m = self.add(glass(&format!("office glass {k}"), tint, frames[k % 3], 1.0, 0.1, s));
            self.urban.office_glass.push(m);
            let m = self.add(glass(&format!("home glass {k}"), tint, frames[(k + 1) % 3], 2.0, 0.3, s ^ 0x7));
            self.urban.home_glass.push(m);
        }
        let s = seed("shop glass", 0);
        self.urban.shop_glass =
            self.add(glass("city shop window", bgr(0.05, 0.05, 0.05), bgr(0.3, 0.31, 0.32), 1.0, 0.2, s));
        for (k, base) in [bgr(0.1, 0.11, 0.11), bgr(0.36, 0.38, 0.39), bgr(0.2, 0.21, 0.2)].into_iter().enumerate() {
            let m = self.add(aged(
                Material::diffuse(&format!("guard {k}"), Class::Facade, base),
                seed("guard", k as u64),
                0.06,
                0.04,
            ));
            self.urban.guards.push(m);
        }
    }

    fn urban_roofs(&mut self, seed: &impl Fn(&str, u64) -> u32) {
        // White membrane new and aged, tan cap sheet, tan gravel, pale grey, silver-coated bitumen, cream foam, brown gravel.
        let roofs: [(Bands, f32, f32); 9] = [
            (bgr(0.66, 0.69, 0.7), 2.8, 0.22),
            (bgr(0.5, 0.545, 0.565), 2.6, 0.34),
            (bgr(0.26, 0.315, 0.35), 1.0, 0.3),
            (bgr(0.215, 0.26, 0.295), 0.0, 0.28),
            (bgr(0.38, 0.4, 0.405), 2.2, 0.32),
            (bgr(0.3, 0.31, 0.315), 1.0, 0.4),
            (bgr(0.4, 0.465, 0.5), 0.0, 0.3),
            (bgr(0.135, 0.165, 0.2), 0.0, 0.3),
            (bgr(0.17, 0.18, 0.188), 1.0, 0.35),
        ];
        for (k, (base, strip, stain)) in roofs.into_iter().enumerate() {
            let m = self.add(membrane(&format!("city roof {k}"), base, strip, stain, seed("roof", k as u64)));
            self.urban.roofs.push(m);
        }
        for (k, (base, joint)) in [(0.34, 1.2), (0.27, 0.9), (0.22, 2.4)].into_iter().enumerate() {
            let m = self.add(concrete(&format!("terrace {k}"), Class::Roof, base, joint, seed("terrace", k as u64)));
            self.urban.terraces.push(m);
        }
        for (k, level) in [0.34, 0.28, 0.22].into_iter().enumerate() {
            let m = self.add(concrete(
                &format!("city concrete {k}"),
                Class::Facade,
                level,
                0.0,
                seed("concrete", k as u64),
            ));
            self.urban.concrete.push(m);
            let m = self.add(lot(&format!("deck {k}"), Class::Roof, k as f32 * 0.5, seed("deck", k as u64)));
            self.urban.decks.push(m);
        }
    }

    fn urban_things(&mut self, seed: &impl Fn(&str, u64) -> u32) {
        let mut water = Material::diffuse("roof pool", Class::Water, Bands::new(0.27, 0.285, 0.13, 0.02));
        water.brdf = Brdf::Coated { index: Brdf::WATER_INDEX };
        self.urban.water = self.add(water);
        let white = Material::diffuse("roof paint", Class::Roof, bgr(0.55, 0.57, 0.58));
        self.urban.paint = self.add(aged(white, seed("paint", 0), 0.1, 0.06));
        for (k, base) in [bgr(0.16, 0.17, 0.18), bgr(0.3, 0.31, 0.31), bgr(0.07, 0.085, 0.25), bgr(0.12, 0.17, 0.1)]
            .into_iter()
            .enumerate()
        {
            let m = Material::diffuse(&format!("landing pad {k}"), Class::Roof, base);
            let m = self.add(aged(m, seed("pad", k as u64), 0.12, 0.08));
            self.urban.pads.push(m);
        }
        let signs = [
            bgr(0.6, 0.62, 0.63),
            bgr(0.55, 0.58, 0.6),
            bgr(0.06, 0.07, 0.32),
            bgr(0.28, 0.14, 0.05),
            bgr(0.1, 0.24, 0.1),
            bgr(0.08, 0.3, 0.42),
            bgr(0.14, 0.15, 0.16),
        ];
        for (k, base) in signs.into_iter().enumerate() {
            let m = Material::diffuse(&format!("canopy {k}"), Class::Roof, base).rough(0.2);
            let m = self.add(aged(m, seed("canopy", k as u64), 0.1, 0.06));
            self.urban.canopies.push(m);
        }
        let boxes = [
            bgr(0.07, 0.09, 0.2),
            bgr(0.2, 0.11, 0.06),
            bgr(0.1, 0.15, 0.1),
            bgr(0.36, 0.37, 0.37),
            bgr(0.05, 0.12, 0.24),
        ];
        for (k, base) in boxes.into_iter().enumerate() {
            let m = Material::diffuse(&format!("container {k}"), Class::OtherStructure, base).rough(0.2);
            let ribs = repeating(Coordinate::V, 0.6, 0.3, 0.0);
            let m = self.add(aged(m, seed("container", k as u64), 0.16, 0.1).with(brightness(ribs.times(-0.1))));
            self.urban.steel.push(m);
        }
        let s = seed("bridge", 0);
        let mut pane = glass("bridge glass", bgr(0.06, 0.06, 0.05), bgr(0.3, 0.31, 0.32), 1.0, 0.05, s);
        pane.class = Class::Bridge;
        let deck = concrete("bridge concrete", Class::Bridge, 0.3, 0.0, s);
        let mut roof = metal("bridge roof", 0.4, s);
        roof.class = Class::Bridge;
        self.urban.bridge = [pane, deck, roof].map(|m| self.add(m));
    }

    /// A set for an urban building.
    pub(super) fn urban_set(&mut self, usage: Use, massing: bool, path: &SeedPath) -> u32 {
        let mut rng = path.child("materials").rng();
        let book = &self.urban;
        if usage == Use::Footbridge {
            let [pane, deck, roof] = book.bridge;
            let mut set = vec![deck; part::COUNT];
            set[slot::GLASS as usize] = pane;
            set[slot::ROOF as usize] = roof;
            return self.set(set);
        }
        let of = |list: &[u32], rng: &mut Rng| *rng.pick(list);
        let style = rng.below(book.walls.len() as u64) as usize;
        let (wall, glass) = match usage {
            Use::Office | Use::Residence | Use::Block => {
                let wall = if massing { book.banded[style] } else { book.walls[style] };
                let glass = if usage == Use::Office { &book.office_glass } else { &book.home_glass };
                (wall, of(glass, &mut rng))
            }
            Use::Garage => (of(&book.concrete, &mut rng), self.dark),
            Use::Store => (of(&book.shops, &mut rng), of(&book.home_glass, &mut rng)),
            Use::Works => (of(&book.halls, &mut rng), book.shop_glass),
            Use::Apartments | Use::Footbridge => (of(&book.homes, &mut rng), of(&book.home_glass, &mut rng)),
        };
        let slab = match usage {
            Use::Office if rng.chance(0.45) => book.walls[[4, 6, 6, 0][rng.below(4) as usize]],
            Use::Residence if rng.chance(0.6) => book.walls[[0, 5, 1][rng.below(3) as usize]],
            _ => wall,
        };
        let weights = match usage {
            Use::Office | Use::Residence => [0.16, 0.16, 0.12, 0.16, 0.16, 0.1, 0.06, 0.04, 0.04],
            Use::Works => [0.24, 0.24, 0.1, 0.02, 0.16, 0.12, 0.08, 0.0, 0.04],
            Use::Apartments => [0.14, 0.2, 0.17, 0.12, 0.1, 0.09, 0.1, 0.05, 0.03],
            _ => [0.2, 0.2, 0.14, 0.07, 0.14, 0.1, 0.07, 0.03, 0.05],
        };
        let roof = book.roofs[rng.weighted(&weights)];
        let mut set = vec![0; part::COUNT];
        let mut put = |slot: u16, m: u32| set[slot as usize] = m;
        put(slot::WALL, wall);
        put(slot::GLASS, glass);
        put(slot::SLAB, slab);
        put(slot::COPING, of(&self.trim[..3], &mut rng));
        put(slot::STRIP, self.strip);
        put(slot::ROOF, roof);
        put(slot::METAL, of(&self.metal, &mut rng));
        put(slot::SHOP, book.shop_glass);
        put(
            slot::GUARD,
            if matches!(usage, Use::Works | Use::Store) {
                of(&self.doors, &mut rng)
            } else {
                of(&book.guards, &mut rng)
            },
        );
        put(slot::PANEL, self.panel);
        put(slot::GREEN, of(&self.shrubs[..3], &mut rng));
        put(slot::DARK, self.dark);
        put(slot::TERRACE, of(&book.terraces, &mut rng));
        put(part::STALLS, of(&book.decks, &mut rng));
        put(part::WATER, book.water);
        put(part::PAINT, book.paint);
        put(part::PAD, book.pads[rng.weighted(&[0.5, 0.34, 0.1, 0.06])]);
        put(part::CANOPY, of(&book.canopies, &mut rng));
        put(part::CONCRETE, of(&book.concrete, &mut rng));
        put(part::STEEL, of(&book.steel, &mut rng));
        self.set(set)
    }
}
