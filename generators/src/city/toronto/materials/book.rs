//! The materials that a city is made of, in their variants.

use super::Materials;
use super::surfaces::{
    aged, asphalt, banded, bgr, brightness, concrete, glass, lawn, membrane, metal, noise, paint_left, repeating, road,
    wall, with_windows,
};
use super::{ROAD_AGES, STREET_KINDS};
use crate::city::toronto::ground_slot;
use satseed_scene::{Bands, Brdf, Class, Coordinate, Field, Layer, Material, Space};

impl Materials {
    /// The ground's materials become set 0 in the order of their slots.
    pub(super) fn ground(&mut self, seed: &impl Fn(&str, u64) -> u32) {
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
        let wear = paint_left(seed("paint", 0), 3.0, 0.65);
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

    /// Walls and glazing.
    pub(super) fn walls(&mut self, seed: &impl Fn(&str, u64) -> u32) {
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

    /// Roofs and what is on them.
    pub(super) fn roofs(&mut self, seed: &impl Fn(&str, u64) -> u32) {
        let flat: [(Bands, f32, f32); 9] = [
            // White membrane, aged and nearly new at the other end; grey membrane; mineral bitumen; black bitumen;
            // pale and brown gravel; aged concrete pavers; brown bitumen (totals of LBNL's roof tables).
            (bgr(0.54, 0.57, 0.58), 2.6, 0.32),
            (bgr(0.31, 0.33, 0.335), 2.2, 0.3),
            (bgr(0.14, 0.146, 0.15), 1.0, 0.3),
            (bgr(0.055, 0.058, 0.061), 1.0, 0.3),
            (bgr(0.2, 0.228, 0.25), 0.0, 0.25),
            (bgr(0.135, 0.168, 0.207), 0.0, 0.28),
            (bgr(0.67, 0.69, 0.69), 2.8, 0.2),
            (bgr(0.205, 0.24, 0.265), 1.2, 0.3),
            (bgr(0.08, 0.1, 0.128), 2.0, 0.3),
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

    /// Trees, vehicles, furniture.
    pub(super) fn things(&mut self, seed: &impl Fn(&str, u64) -> u32) {
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
}
