//! Land that is not lots: strip malls with their parking, schools with fields, parks; an interchange's land: `junction.rs`.

use super::Params;
use super::ground_slot as slot;
use super::house::{self, wall_mass};
use super::layout::{Slab, SlabUse};
use super::lot::{Building, Content, Kind, Parked, Plant, Planted};
use super::paving::Layer;
use crate::city::toronto::traffic::draw_body;
use crate::kit::buildings::{Furnishing, Roof, furnish, slot as part};
use crate::kit::ground::Patch;
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::{Rng, SeedPath};

/// A slab at work: u along the street, v from it into the land.
pub(super) struct Site<'a> {
    pub(super) slab: &'a Slab<'a>,
    pub(super) params: &'a Params,
    pub(super) height_m: &'a dyn Fn(DVec2) -> f64,
    pub(super) out: Content,
    /// World outlines of what trees and cars must keep off.
    pub(super) taken: Vec<Vec<DVec2>>,
}

/// Decides a slab.
pub(super) fn plan(params: &Params, slab: &Slab<'_>, height_m: &dyn Fn(DVec2) -> f64) -> Content {
    let mut site = Site::new(slab, params, height_m);
    match slab.usage {
        SlabUse::Commercial => site.mall(),
        SlabUse::School => site.school(),
        SlabUse::Park => site.park(),
        SlabUse::Junction => site.junction(),
    }
    site.out
}

/// A tree as they stand in parks and on open land.
pub(super) fn any_tree(rng: &mut Rng) -> Plant {
    match rng.weighted(&[0.78, 0.12, 0.1]) {
        0 => Plant::Broad,
        1 => Plant::Upright,
        _ => Plant::Palm,
    }
}

impl<'a> Site<'a> {
    pub(super) fn new(slab: &'a Slab<'a>, params: &'a Params, height_m: &'a dyn Fn(DVec2) -> f64) -> Self {
        Self { slab, params, height_m, out: Content::default(), taken: Vec::new() }
    }
    pub(super) fn size(&self) -> DVec2 {
        self.slab.sheet.size
    }

    pub(super) fn at(&self, u: f64, v: f64) -> DVec2 {
        let y = if self.slab.street_far { self.size().y - v } else { v };
        self.slab.sheet.world(DVec2::new(u, y))
    }

    /// Direction of u at a place, world.
    pub(super) fn along(&self, u: f64, v: f64) -> DVec2 {
        (self.at(u + 0.5, v) - self.at(u - 0.5, v)).normalize()
    }

    pub(super) fn outline(&self, local: &[DVec2]) -> Vec<DVec2> {
        let mut out: Vec<DVec2> = polygon::subdivided(local, 12.0).iter().map(|p| self.at(p.x, p.y)).collect();
        if polygon::area(&out) < 0.0 {
            out.reverse();
        }
        out
    }

    /// Lays a polygon whose texture coordinates begin at its first corner.
    pub(super) fn lay(&mut self, layer: Layer, local: &[DVec2], slot: u16) {
        let outline = self.outline(local);
        let patch = Patch {
            outline,
            slot,
            origin_m: self.at(local[0].x, local[0].y),
            axis: self.along(local[0].x, local[0].y),
            lowered: false,
        };
        self.out.patches.push((layer, patch));
    }

    pub(super) fn rect(u0: f64, u1: f64, v0: f64, v1: f64) -> Vec<DVec2> {
        polygon::rectangle(DVec2::new(u0, v0), DVec2::new(u1, v1))
    }

    /// A flat-roofed building over a rectangle.
    pub(super) fn flat(&mut self, name: &str, kind: Kind, [u0, u1, v0, v1]: [f64; 4], roof_m: f64, key: &SeedPath) {
        let mut rng = key.rng();
        let middle = (f64::midpoint(u0, u1), f64::midpoint(v0, v1));
        let axis = self.along(middle.0, middle.1);
        let outline = polygon::oriented_rectangle(DVec2::ZERO, DVec2::X, DVec2::new((u1 - u0) / 2.0, (v1 - v0) / 2.0));
        let parapet_m = rng.range(0.5, 1.2);
        let mut mass = wall_mass(outline.clone(), roof_m, Roof::Flat { parapet_m, slot: part::ROOF });
        mass.bay_m = 4.5;
        mass.floor_m = 3.6;
        let mut masses = vec![mass];
        let mut over = Vec::new();
        if kind == Kind::Shop && u1 - u0 > 24.0 && rng.chance(0.6) {
            // A raised part of the front over an entrance.
            let w = rng.range(8.0, 14.0);
            let x = rng.signed() * ((u1 - u0) / 2.0 - w / 2.0 - 1.0);
            let front = if self.slab.street_far { (v1 - v0) / 2.0 - 2.2 } else { -(v1 - v0) / 2.0 + 2.2 };
            let block = polygon::oriented_rectangle(DVec2::new(x, front), DVec2::X, DVec2::new(w / 2.0, 2.4));
            over.push(polygon::mitred(&block, -0.5));
            masses.push(wall_mass(
                block,
                roof_m + rng.range(1.2, 2.4),
                Roof::Flat { parapet_m: 0.3, slot: part::TERRACE },
            ));
        }
        let what = Furnishing { base_m: roof_m, machines: 0.42, panels: 0.12, beds: 0.0, bulkhead: 0.12 };
        let inner = polygon::mitred(&outline, 1.0);
        let items = furnish(&inner, &over, what, &key.child("roof"));
        let ridge_m = masses.iter().map(|m| m.roof_m).fold(0.0, f64::max) + parapet_m;
        let at = self.at(middle.0, middle.1);
        self.taken.push(polygon::oriented_rectangle(at, axis, DVec2::new((u1 - u0) / 2.0, (v1 - v0) / 2.0) + 1.5));
        let plan = house::grounded(at, axis, masses, items, &mut [], self.height_m);
        let name = format!("{}/{name}", self.slab.name);
        self.out.buildings.push((name, Building { kind, plan, extras: Vec::new(), ridge_m }));
    }

    pub(super) fn tree(&mut self, u: f64, v: f64, plant: Plant, size: f64) {
        let at = self.at(u, v);
        if self.taken.iter().all(|o| !polygon::contains(o, at)) {
            self.out.plants.push(Planted { at, plant, size });
        }
    }

    /// Stalls in double rows between two heights, cars in them, islands at their ends.
    pub(super) fn parking(&mut self, [u0, u1, v0, v1]: [f64; 4], occupancy: f64, key: &SeedPath) {
        let mut rng = key.rng();
        let outline = self.outline(&Self::rect(u0, u1, v0, v1));
        // v = 0 of the texture is the middle of a double row.
        let first = v0 + 6.2 + 5.5;
        let across = (self.at(u0, first + 1.0) - self.at(u0, first)).normalize();
        let origin_m = self.at(u0, first);
        let axis = self.along(u0, first);
        self.out.patches.push((Layer::Drive, Patch { outline, slot: slot::PARKING, origin_m, axis, lowered: false }));
        let mut v = first;
        while v + 5.5 < v1 {
            let mut u = u0 + 6.5 + 1.3;
            for end in [u0 + 3.2, u1 - 3.2] {
                self.lay(Layer::Bed, &Self::rect(end - 1.4, end + 1.4, v - 4.6, v + 4.6), slot::MULCH);
                let (size, at) = (rng.range(0.6, 1.0), v + rng.signed() * 2.5);
                if rng.unit() < 0.85 * self.params.trees {
                    self.tree(end, at, Plant::Broad, size);
                }
            }
            while u < u1 - 7.0 {
                for side in [-1.0, 1.0] {
                    if rng.chance(occupancy * self.params.vehicles.min(1.6)) {
                        let body = draw_body(&mut rng, false);
                        let at = self.at(u + rng.signed() * 0.15, v + side * 2.75 + rng.signed() * 0.3);
                        let way = if rng.chance(0.8) { -side } else { side };
                        self.out.vehicles.push(Parked { centre: at, axis: across * way, body, lowered: false });
                    }
                }
                u += 2.6;
            }
            v += 17.5;
        }
    }

    fn mall(&mut self) {
        let size = self.size();
        let key = self.slab.key;
        let mut rng = key.rng();
        self.lay(Layer::Yard, &Self::rect(0.1, size.x - 0.1, 0.1, size.y - 0.1), slot::YARD_ASPHALT);
        self.lay(Layer::Front, &Self::rect(0.6, size.x - 0.6, 0.4, 5.0), slot::PARKWAY);
        let mut u = 6.0;
        while u < size.x - 5.0 {
            let plant = if rng.chance(0.3) { Plant::Palm } else { Plant::Broad };
            let (size, v) = (rng.range(0.6, 1.0), rng.range(2.0, 3.5));
            if rng.unit() < 0.75 * self.params.trees {
                self.tree(u, v, plant, size);
            }
            u += rng.range(8.0, 13.0);
        }
        // Shops along the rear, a large one among them.
        let rear = size.y - rng.range(7.0, 10.0);
        let mut u = rng.range(8.0, 14.0);
        let anchor = rng.below(3);
        let mut k = 0;
        while u < size.x - 24.0 {
            let large = k == anchor;
            let width = if large { rng.range(38.0, 56.0) } else { rng.range(22.0, 48.0) }.min(size.x - 8.0 - u);
            let depth = if large { rng.range(28.0, 36.0) } else { rng.range(17.0, 22.0) };
            let roof = if large { rng.range(7.0, 9.0) } else { rng.range(4.8, 6.4) };
            self.flat(
                &format!("shop/{k}"),
                Kind::Shop,
                [u, u + width, rear - depth, rear],
                roof,
                &key.child("shop").index(k),
            );
            self.lay(Layer::Front, &Self::rect(u, u + width, rear - depth - 3.2, rear - depth + 0.5), slot::PLAZA);
            u += width + if rng.chance(0.7) { 0.4 } else { rng.range(7.0, 12.0) };
            k += 1;
        }
        let near = rear - 42.0;
        // A pad or two with its own small building at the street.
        let pads = 1 + rng.below(2);
        let mut lot_from = 6.0;
        for n in 0..pads {
            let w = rng.range(15.0, 22.0);
            let u = if n == 0 { rng.range(14.0, 30.0) } else { size.x - rng.range(34.0, 44.0) };
            let d = rng.range(11.0, 15.0).min(near - 14.0);
            if d > 8.0 {
                self.flat(
                    &format!("pad/{n}"),
                    Kind::Shop,
                    [u, u + w, 9.0, 9.0 + d],
                    rng.range(4.6, 5.8),
                    &key.child("pad").index(n),
                );
                self.lay(Layer::Front, &Self::rect(u - 3.0, u + w + 3.0, 6.6, 9.0 + d + 2.5), slot::PLAZA);
                lot_from = 9.0 + d + 4.0;
            }
        }
        if near - lot_from > 18.0 {
            self.parking([6.0, size.x - 6.0, lot_from, near + 2.0], rng.range(0.3, 0.7), &key.child("parking"));
        } else {
            self.parking([58.0, size.x - 58.0, 6.4, near + 2.0], rng.range(0.3, 0.7), &key.child("parking"));
        }
    }

    /// A baseball field: clay, with grass inside it.
    fn diamond(&mut self, home: DVec2, turn: f64) {
        let (s, c) = libm::sincos(turn);
        let axis = DVec2::new(c, s);
        let sector = |from: DVec2, r: f64| -> Vec<DVec2> {
            let mut out = vec![from];
            out.extend((0..=10).map(|k| {
                let (s, c) = libm::sincos(core::f64::consts::FRAC_PI_2 * (f64::from(k) / 10.0 - 0.5));
                from + (axis * c + axis.perp() * s) * r
            }));
            out
        };
        self.lay(Layer::Bed, &sector(home - axis * 3.0, 31.0), slot::INFIELD);
        let inner =
            polygon::oriented_rectangle(home + axis * 14.0, (axis + axis.perp()).normalize(), DVec2::splat(8.2));
        self.lay(Layer::Drive, &inner, slot::TURF);
    }

    pub(super) fn woods(&mut self, count: u32, rng: &mut Rng, [u0, u1, v0, v1]: [f64; 4]) {
        for _ in 0..libm::floor(f64::from(count) * self.params.trees) as u32 {
            let (u, v) = (rng.range(u0, u1), rng.range(v0, v1));
            let plant = any_tree(rng);
            let size = rng.range(0.8, 1.5);
            self.tree(u, v, plant, size);
        }
    }

    fn school(&mut self) {
        let size = self.size();
        let key = self.slab.key;
        let mut rng = key.rng();
        self.lay(Layer::Yard, &Self::rect(0.1, size.x - 0.1, 0.1, size.y - 0.1), slot::TURF);
        let half = size.x * rng.range(0.46, 0.56);
        self.lay(Layer::Front, &Self::rect(4.0, half - 2.0, 30.0, size.y - 4.0), slot::PLAZA);
        // Two columns of class rooms.
        let rows = libm::floor((size.y - 62.0) / 19.0).max(1.0) as u32;
        for k in 0..rows {
            let v = 60.0 + 19.0 * f64::from(k);
            for c in 0..2 {
                let u = 8.0 + f64::from(c) * (half * 0.48) + rng.range(0.0, 3.0);
                let end = u + half * rng.range(0.36, 0.42);
                let roof = rng.range(4.2, 5.2);
                let key = key.child("bar").index(u64::from(2 * k + c));
                self.flat(&format!("bar/{k}/{c}"), Kind::School, [u, end, v, v + 10.5], roof, &key);
                self.lay(Layer::Bed, &Self::rect(u, end - 2.0, v + 11.5, v + 17.0), slot::FRONT[1]);
            }
        }
        self.flat("hall", Kind::School, [half - 40.0, half - 8.0, 32.0, 54.0], rng.range(7.5, 9.5), &key.child("hall"));
        self.parking([6.0, half - 4.0, 5.0, 29.0], 0.55, &key.child("parking"));
        self.lay(Layer::Front, &Self::rect(half + 1.0, half + 44.0, size.y - 58.0, size.y - 6.0), slot::YARD_ASPHALT);
        for k in 0..3 {
            let u = half + 5.0 + 13.0 * f64::from(k);
            self.lay(Layer::Bed, &Self::rect(u, u + 11.0, size.y - 30.0, size.y - 9.0), slot::COURT);
        }
        let home = DVec2::new(size.x - 22.0, size.y - 20.0);
        self.diamond(home, core::f64::consts::PI * 1.25);
        self.woods(26, &mut rng, [4.0, half, 30.0, size.y - 4.0]);
        let mut u = half + 6.0;
        while u < size.x - 4.0 {
            let size = rng.range(0.8, 1.2);
            if rng.unit() < self.params.trees {
                self.tree(u, 3.0, Plant::Broad, size);
            }
            u += rng.range(8.0, 14.0);
        }
    }

    fn park(&mut self) {
        let size = self.size();
        let key = self.slab.key;
        let mut rng = key.rng();
        self.lay(Layer::Yard, &Self::rect(0.1, size.x - 0.1, 0.1, size.y - 0.1), slot::TURF);
        let courts = size.x * rng.range(0.2, 0.3);
        self.parking([courts + 30.0, courts + 78.0, 4.0, 27.0], 0.4, &key.child("parking"));
        for k in 0..2 {
            let u = 8.0 + 19.0 * f64::from(k);
            self.lay(Layer::Bed, &Self::rect(u, u + 17.0, 10.0, 46.0), slot::COURT);
        }
        let home = DVec2::new(size.x - 24.0, size.y - 20.0);
        self.diamond(home, core::f64::consts::PI * 1.25);
        // A loop path.
        let loop_of = |r: f64| -> Vec<DVec2> {
            let middle = DVec2::new(size.x * 0.45, size.y * 0.6);
            (0..40)
                .map(|k| {
                    let (s, c) = libm::sincos(core::f64::consts::TAU * f64::from(k) / 40.0);
                    middle + DVec2::new(c * (size.x * 0.3 + r), s * (size.y * 0.28 + r)) * (1.0 + 0.06 * s * c)
                })
                .collect()
        };
        self.lay(Layer::Drive, &loop_of(1.2), slot::DRIVE[0]);
        self.lay(Layer::Deck, &loop_of(-1.2), slot::TURF);
        let play = DVec2::new(size.x * 0.36, size.y * 0.62);
        let sand: Vec<DVec2> = (0..18)
            .map(|k| {
                let (s, c) = libm::sincos(core::f64::consts::TAU * f64::from(k) / 18.0);
                play + DVec2::new(c * 13.0, s * 9.0)
            })
            .collect();
        self.lay(Layer::Coping, &sand, slot::TRACK);
        self.flat("house", Kind::School, [courts + 32.0, courts + 46.0, 32.0, 40.0], 4.0, &key.child("house"));
        self.woods(75, &mut rng, [3.0, size.x - 60.0, 30.0, size.y - 3.0]);
    }
}
