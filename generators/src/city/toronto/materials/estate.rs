//! What only estates have on their ground: courts, pools, playgrounds.

use super::Materials;
use super::surfaces::{aged, bgr, brightness, noise, stripe};
use satseed_scene::{Brdf, Class, Coordinate, Field, Layer, Material, SeedPath};

impl Materials {
    /// Adds them to the end of the ground's set, in the order of their slots.
    pub(in super::super) fn add_estate(&mut self, path: &SeedPath) {
        let seed = |name: &str| path.child(name).hash_u32();
        let mut rng = path.child("court colours").rng();
        let [edge, court] = *rng.pick(&[
            [bgr(0.06, 0.115, 0.075), bgr(0.05, 0.075, 0.17)],
            [bgr(0.055, 0.07, 0.14), bgr(0.065, 0.13, 0.085)],
            [bgr(0.07, 0.12, 0.08), bgr(0.15, 0.1, 0.06)],
        ]);
        let surface =
            |name: &str, base, s: u32| aged(Material::diffuse(name, Class::Ground, base).rough(0.3), s, 0.2, 0.1);
        // Sidelines of the doubles' and singles' court, baselines, service lines and the middle of these.
        let along: Vec<Field> = [-5.45, -4.1, 4.1, 5.45].map(|v| stripe(Coordinate::V, v, 0.06)).to_vec();
        let across: Vec<Field> = [-11.85, -6.4, 6.4, 11.85].map(|u| stripe(Coordinate::U, u, 0.07)).to_vec();
        let wear = noise(seed("line"), 2.0, 2).affine(0.6, 0.5).ramp(0.0, 1.0);
        let lines = Field::Product(vec![Field::Max([along, across].concat()), wear]);
        let pool = Material::diffuse("pool", Class::Water, bgr(0.3, 0.23, 0.085));
        let pool = pool
            .with(brightness(noise(seed("pool"), 3.0, 2).times(0.12)))
            .with(brightness(Field::Variation(0).times(0.1)));
        let sand = surface("playground", bgr(0.17, 0.215, 0.25), seed("playground"));
        for m in [
            surface("court edge", edge, seed("court edge")),
            surface("court", court, seed("court"))
                .with(Layer::Mix { color: bgr(0.36, 0.37, 0.37), amount: lines.times(0.8) }),
            Material { brdf: Brdf::Coated { index: 1.33 }, ..pool },
            sand,
        ] {
            let m = self.add(m);
            self.sets[0].push(m);
        }
    }
}
