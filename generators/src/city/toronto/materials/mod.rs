//! Toronto's materials. Reflectances are class values of public spectral libraries (ECOSTRESS, USGS splib07, LBNL roofs).
//!
//! Each has texture at three scales (patches of metres, streaks and stains, grain) keyed by place in the world, so that
//! no two surfaces show the same spots, and a brightness and tint of its own from the instance.

mod book;
mod estate;
mod rail;
pub(in crate::city) mod surfaces;

use super::massing::Kind;
use crate::kit::buildings::slot;
use crate::kit::{trees, vehicles};
use satseed_scene::{Material, Rng, SeedPath};
use std::collections::BTreeMap;

/// Kinds of streets.
pub(in crate::city) const STREET_KINDS: u16 = 4;
/// Ages of asphalt of each kind.
pub(in crate::city) const ROAD_AGES: u16 = 3;

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
    rail: rail::Book,
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
            rail: rail::Book::default(),
        };
        let seed = |name: &str, k: u64| path.child(name).index(k).hash_u32();
        this.ground(&seed);
        this.walls(&seed);
        this.roofs(&seed);
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
                    self.flat_roofs[rng.weighted(&[1.4, 2.0, 1.4, 1.0, 2.6, 1.9, 0.5, 1.6, 1.2])],
                )
            }
            Kind::Office => {
                let wall = of(&self.precast, &mut rng);
                let slab = if rng.chance(0.6) { self.precast[4 + (style & 1)] } else { wall };
                (
                    wall,
                    of(&self.office_glass, &mut rng),
                    slab,
                    self.flat_roofs[rng.weighted(&[1.5, 2.0, 1.4, 1.2, 2.4, 1.6, 0.7, 1.6, 1.0])],
                )
            }
            Kind::Block => {
                let wall = if rng.chance(0.7) { of(&self.brick, &mut rng) } else { of(&self.precast, &mut rng) };
                (
                    wall,
                    of(&self.masonry_glass, &mut rng),
                    of(&self.precast, &mut rng),
                    self.flat_roofs[rng.weighted(&[1.2, 1.8, 1.8, 1.8, 2.0, 1.8, 0.4, 1.6, 1.8])],
                )
            }
            Kind::Flats => {
                // Yellow, brown and white brick, bare or painted concrete; roofs of gravel and bitumen.
                let wall = if rng.chance(0.72) {
                    self.brick[rng.weighted(&[0.5, 0.7, 1.2, 1.6, 0.2, 0.7, 1.2])]
                } else {
                    self.precast[rng.weighted(&[0.3, 1.0, 1.0, 0.7, 0.1, 0.0])]
                };
                (
                    wall,
                    of(&self.masonry_glass, &mut rng),
                    self.precast[rng.weighted(&[0.8, 1.2, 1.2, 0.9, 0.2, 0.0])],
                    self.flat_roofs[rng.weighted(&[0.8, 1.4, 1.6, 1.4, 2.6, 1.8, 0.3, 1.6, 1.6])],
                )
            }
            Kind::House | Kind::Shop | Kind::Shed => {
                let wall = of(&self.windowed, &mut rng);
                (
                    wall,
                    of(&self.masonry_glass, &mut rng),
                    wall,
                    self.flat_roofs[rng.weighted(&[0.8, 1.8, 2.2, 2.4, 1.5, 1.5, 0.3, 1.2, 2.2])],
                )
            }
        };
        let wall = match kind {
            Kind::Condo | Kind::Office if massing => of(&self.banded, &mut rng),
            Kind::Block | Kind::Flats if massing => of(&self.windowed, &mut rng),
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
