//! What only the railway has: ballast, tracks, walls, platforms, bridges, trains.

use super::surfaces::{aged, asphalt, bgr, brightness, concrete, lawn, membrane, noise, repeating, stripe};
use super::{Materials, ROAD_AGES};
use crate::city::toronto::ground_slot;
use crate::city::toronto::rail::{Body, train, works_slot as works};
use satseed_scene::{Bands, Brdf, Class, Coordinate, Field, Layer, Material, Rng, SeedPath};

/// The railway's materials by what they are for.
#[derive(Debug, Default)]
pub(super) struct Book {
    track: Vec<u32>,
    works: Vec<u32>,
    walls: Vec<u32>,
    canopies: Vec<u32>,
    /// White, two greens, silver, yellow, grey; then freight: brown, black, grey, blue, green, rust.
    shells: Vec<u32>,
    window: u32,
    under: u32,
    roofs: Vec<u32>,
}

impl Materials {
    /// Adds the railway's materials; those of its ground go to the end of the ground's set, in the order of their slots.
    pub(in super::super) fn add_rail(&mut self, path: &SeedPath) {
        let seed = |name: &str, k: u64| path.child(name).index(k).hash_u32();
        // Crushed stone, grey where it is new, brown with dust of brakes and rust where trains run; weeds in patches.
        let stones = |name: &str, base: Bands, s: u32| {
            aged(Material::diffuse(name, Class::Ground, base).rough(0.55), s, 0.18, 0.26)
                .with(brightness(noise(s ^ 0x21, 0.4, 1).times(0.2)))
        };
        let weeds = |m: Material, s: u32, much: f32| {
            let amount = noise(s ^ 0x31, 7.0, 4).ramp(0.62 - much, 0.9 - much).times(0.8);
            m.with(Layer::Mix { color: Bands::new(0.055, 0.1, 0.085, 0.3), amount })
        };
        let s = seed("ballast", 0);
        let ballast = weeds(stones("ballast", bgr(0.128, 0.142, 0.155), s), s, 0.12).with(Layer::Mix {
            color: bgr(0.07, 0.08, 0.095),
            amount: noise(s ^ 3, 37.0, 3).ramp(-0.1, 0.5).times(0.7),
        });
        let s = seed("track", 0);
        let rust = Field::Product(vec![
            Field::Sum(vec![stripe(Coordinate::V, -0.754, 0.62), stripe(Coordinate::V, 0.754, 0.62)]),
            noise(s ^ 5, 21.0, 2).affine(0.5, 0.6).ramp(0.0, 1.0),
        ]);
        let oil = Field::Product(vec![stripe(Coordinate::V, 0.0, 0.8), noise(s ^ 6, 43.0, 2).ramp(-0.2, 0.5)]);
        let track = stones("track bed", bgr(0.1, 0.115, 0.13), s)
            .with(Layer::Mix { color: bgr(0.055, 0.075, 0.105), amount: rust.times(0.75) })
            .with(Layer::Mix { color: bgr(0.045, 0.047, 0.05), amount: oil.times(0.6) });
        let s = seed("gravel", 0);
        let gravel = weeds(stones("service road", bgr(0.165, 0.188, 0.208), s), s, 0.3);
        let verge = lawn("verge", 0.85, seed("verge", 0));
        for m in [ballast, track, gravel, verge] {
            let m = self.add(m);
            self.sets[0].push(m);
        }
        let structure = Class::OtherStructure;
        let plain = |name: String, class: Class, base: Bands, s: u32| {
            aged(Material::diffuse(&name, class, base).rough(0.3), s, 0.15, 0.12)
        };
        let rail = plain("rail".into(), structure, bgr(0.1, 0.115, 0.14), seed("rail", 0));
        let sleeper = plain("sleeper".into(), structure, bgr(0.145, 0.155, 0.165), seed("sleeper", 0))
            .with(brightness(
                Field::Cells {
                    space: satseed_scene::Space::World,
                    seed: seed("sleeper", 1),
                    size_m: [0.9, 0.9, 0.0],
                    stagger: 0.5,
                }
                .times(0.22),
            ))
            .with(Layer::Mix {
                color: bgr(0.065, 0.075, 0.09),
                amount: noise(seed("sleeper", 2), 60.0, 2).ramp(-0.15, 0.15).times(0.8),
            });
        self.rail.track = [rail, sleeper].map(|m| self.add(m)).to_vec();
        for (k, level) in [0.24, 0.18, 0.3].into_iter().enumerate() {
            let streaks = Field::Noise(satseed_scene::Fractal::new(
                satseed_scene::Space::Plan,
                seed("streaks", k as u64),
                0.8,
                2,
            ));
            let m = concrete(&format!("retaining wall {k}"), structure, level, 0.0, seed("wall", k as u64))
                .with(brightness(streaks.times(0.22)));
            let m = self.add(m);
            self.rail.walls.push(m);
        }
        for (k, (base, strip)) in [
            (bgr(0.3, 0.32, 0.33), 1.2),
            (bgr(0.13, 0.135, 0.14), 0.8),
            (bgr(0.19, 0.26, 0.24), 0.6),
            (bgr(0.46, 0.48, 0.48), 1.8),
        ]
        .into_iter()
        .enumerate()
        {
            let m = membrane(&format!("canopy {k}"), base, strip, 0.3, seed("canopy", k as u64));
            let m = self.add(Material { class: structure, ..m });
            self.rail.canopies.push(m);
        }
        let edge = Field::Sum(vec![stripe(Coordinate::V, -2.75, 0.55), stripe(Coordinate::V, 2.75, 0.55)]);
        let platform = concrete("platform", Class::Ground, 0.22, 1.5, seed("platform", 0))
            .with(Layer::Mix { color: bgr(0.07, 0.24, 0.36), amount: edge.times(0.75) });
        let mut glass = Material::diffuse("station glass", structure, bgr(0.07, 0.07, 0.06))
            .with(Layer::Mix { color: bgr(0.2, 0.2, 0.2), amount: repeating(Coordinate::U, 1.3, 0.1, 0.0) });
        glass.brdf = Brdf::Coated { index: 1.5 };
        let concrete_of = |name: &str, class, level, k| concrete(name, class, level, 0.0, seed("works", k));
        let list = [
            concrete_of("bridge concrete", Class::Bridge, 0.26, 0),
            plain("railway steel".into(), structure, bgr(0.1, 0.115, 0.115), seed("works", 1)),
            platform,
            membrane("shelter", bgr(0.17, 0.18, 0.185), 0.0, 0.3, seed("works", 2)),
            concrete("bridge sidewalk", Class::Bridge, 0.24, 1.6, seed("works", 3)),
            glass,
            Material::diffuse("louvre", structure, Bands::grey(0.035)),
            asphalt("bridge road", 0.6, seed("works", 4)),
        ];
        self.rail.works = list.map(|m| self.add(m)).to_vec();
        let shells = [
            bgr(0.5, 0.52, 0.52),
            bgr(0.055, 0.125, 0.03),
            bgr(0.035, 0.075, 0.02),
            bgr(0.36, 0.375, 0.38),
            bgr(0.05, 0.29, 0.4),
            bgr(0.12, 0.125, 0.13),
            bgr(0.045, 0.06, 0.12),
            bgr(0.03, 0.03, 0.032),
            bgr(0.27, 0.285, 0.29),
            bgr(0.13, 0.07, 0.04),
            bgr(0.05, 0.075, 0.045),
            bgr(0.055, 0.09, 0.19),
        ];
        for (k, base) in shells.into_iter().enumerate() {
            let s = seed("shell", k as u64);
            let dirt = noise(s ^ 0x3, 2.4, 3).ramp(0.0, 0.6).times(0.35);
            let m = plain(format!("train paint {k}"), Class::Vehicle, base, s)
                .with(Layer::Mix { color: bgr(0.09, 0.1, 0.11), amount: dirt });
            let m = self.add(m);
            self.rail.shells.push(m);
        }
        for (k, level) in [0.34, 0.23, 0.14, 0.46].into_iter().enumerate() {
            let s = seed("train roof", k as u64);
            let soot = noise(s ^ 0x5, 3.0, 3).ramp(-0.1, 0.6).times(0.5);
            let ribs =
                repeating(Coordinate { space: satseed_scene::Space::Object, axis: 0 }, 1.25, 0.1, 0.0).times(-0.2);
            let m = plain(format!("train roof {k}"), Class::Vehicle, Bands::grey(level), s)
                .with(brightness(ribs))
                .with(Layer::Mix { color: Bands::grey(0.06), amount: soot });
            let m = self.add(m);
            self.rail.roofs.push(m);
        }
        let mut window = Material::diffuse("train window", Class::Vehicle, Bands::grey(0.03));
        window.brdf = Brdf::Coated { index: 1.5 };
        self.rail.window = self.add(window);
        self.rail.under = self.add(Material::diffuse("bogie", Class::Vehicle, bgr(0.04, 0.045, 0.055)));
    }

    /// The set of tracks.
    pub(in super::super) fn track_set(&mut self) -> u32 {
        self.set(self.rail.track.clone())
    }

    /// A set for something built along the railway; `road` is the kind of the street that it carries.
    pub(in super::super) fn works_set(&mut self, road: u16, bridge: bool, rng: &mut Rng) -> u32 {
        let mut set = self.rail.works.clone();
        let wall = *rng.pick(&self.rail.walls);
        if !bridge {
            set[works::CONCRETE as usize] = wall;
        }
        set[works::ROOF as usize] = *rng.pick(&self.rail.canopies);
        let age = rng.below(u64::from(ROAD_AGES)) as u16;
        set[works::ROAD as usize] = self.sets[0][(ground_slot::ROAD + road * ROAD_AGES + age) as usize];
        self.set(set)
    }

    /// A set for a car of a train in its colours; freight cars have their own.
    pub(in super::super) fn car_set(&mut self, body: Body, livery: u64, rng: &mut Rng) -> u32 {
        let freight = matches!(body, Body::Boxcar | Body::Tank | Body::Hopper | Body::Flat);
        let (shell, stripe) = match livery {
            _ if freight => {
                let shell = match body {
                    Body::Tank => [7, 7, 0, 8][rng.below(4) as usize],
                    Body::Hopper => [8, 8, 5, 6, 3][rng.below(5) as usize],
                    _ => [6, 11, 9, 10, 8, 7, 11][rng.below(7) as usize],
                };
                (shell, [shell, shell, 8][rng.below(3) as usize])
            }
            0 => (0, 1),
            1 => (1, 2),
            _ => (3, 4),
        };
        let roofs: &[usize] = match (freight, livery) {
            (true, _) => &[1, 2, 0],
            (_, 0) => &[3, 0],
            (_, 1) => &[0, 1],
            _ => &[0],
        };
        let mut set = vec![0; train::COUNT];
        set[train::BODY as usize] = self.rail.shells[shell];
        set[train::STRIPE as usize] = self.rail.shells[stripe];
        set[train::WINDOW as usize] = self.rail.window;
        // Containers have roofs of their own paint.
        let painted = matches!(body, Body::Flat | Body::Hopper) && rng.chance(0.75);
        set[train::ROOF as usize] = if painted { self.rail.shells[shell] } else { self.rail.roofs[*rng.pick(roofs)] };
        set[train::UNDER as usize] = self.rail.under;
        self.set(set)
    }
}
