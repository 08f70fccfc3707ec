//! The farmstead: barns, silos, a tank, a house, machines; and the machines of centre pivots.

use super::dress::TOWER_M;
use super::plan::{Parcel, Plan};
use super::relief::Relief;
use crate::kit::buildings::{self, BuildingPlan, Detail, Facade, Mass, Roof, RoofItem, RoofItemKind, slot};
use crate::kit::mesh_builder::{MeshBuilder, Wall};
use crate::kit::polygon;
use crate::kit::scatter::{Kind, Placed, variation};
use crate::kit::terrain::tin::Ground;
use crate::kit::vehicles::Body;
use glam::{DAffine3, DVec2, DVec3};
use satseed_scene::{
    Bands, Brdf, Class, Coordinate, Field, Fractal, Layer, Material, Mesh, Rng, SeedPath, Space, quantise_m,
};

/// Something of one mesh with its materials by slot.
pub(super) struct Thing {
    pub(super) kind: Kind,
    pub(super) placed: Placed,
}

/// Everything of the farmyard.
pub(super) fn farmstead(relief: &Relief, parcel: &Parcel, path: &SeedPath) -> Vec<Thing> {
    let mut rng = path.rng();
    let mut yard = Site { relief, parcel, middle: centre(&parcel.world), taken: Vec::new(), things: Vec::new() };
    let turn = if rng.chance(0.5) { DVec2::X } else { -DVec2::X };
    let axis = parcel.axis.rotate(turn);
    // One farm is the mirror image of another's order at most: what it keeps differs, too.
    let hand = if rng.chance(0.5) { 1.0 } else { -1.0 };
    let silos = rng.below(4);
    let at = |x: f64, y: f64| axis * x + axis.perp() * (hand * y);
    // The great barn first; what does not fit any more is left out.
    let big = [rng.range(34.0, 42.0), rng.range(14.0, 18.0)];
    yard.barn(at(-6.0, 19.0), axis, big, rng.range(5.0, 6.4), &path.child("barn"));
    for (k, place) in [at(22.0, 20.0), at(22.0, 12.5), at(28.5, 16.0)].into_iter().take(silos as usize).enumerate() {
        let key = path.child("silo").index(k as u64);
        let mut rng = key.rng();
        yard.round(place, rng.range(2.0, 3.2), rng.range(6.5, 14.0), true, &key);
    }
    let second = [rng.range(22.0, 28.0), rng.range(10.0, 13.0)];
    yard.barn(at(19.0, -9.0), axis.perp(), second, rng.range(4.0, 5.2), &path.child("shed"));
    yard.house(at(-20.0, -18.0), axis, &path.child("house"));
    yard.barn(at(-24.0, 1.0), axis, [rng.range(12.0, 17.0), 8.0], 3.6, &path.child("garage"));
    // Where no slurry is kept, another shed stands in its place.
    if rng.chance(0.4) {
        yard.round(at(-2.0, -21.0), rng.range(5.0, 8.5), 2.6, false, &path.child("tank"));
    } else if rng.chance(0.7) {
        let size = [rng.range(13.0, 19.0), rng.range(7.0, 10.0)];
        yard.barn(at(-1.0, -21.0), axis, size, rng.range(3.2, 4.4), &path.child("open shed"));
    }
    for k in 0..14_u64 {
        let key = path.child("machine").index(k);
        let mut rng = key.rng();
        let place = at(rng.range(-26.0, 26.0), rng.range(-24.0, 24.0));
        let (s, c) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
        match k {
            0..=2 | 9 => yard.machine(place, DVec2::new(c, s), tractor(), "tractor", &key),
            3 | 4 | 10 | 11 => yard.machine(place, DVec2::new(c, s), trailer(), "trailer", &key),
            5 | 6 | 12 => yard.machine(place, DVec2::new(c, s), Body::Hatchback.mesh(), "car", &key),
            7 => yard.machine(place, DVec2::new(c, s), Body::Pickup.mesh(), "pickup", &key),
            _ => yard.machine(place, DVec2::new(c, s), Body::Truck.mesh(), "lorry", &key),
        }
    }
    yard.things
}

fn centre(outline: &[DVec2]) -> DVec2 {
    let (low, high) = polygon::bounds(outline);
    if polygon::area(outline) > 1.0 { polygon::centroid(outline) } else { (low + high) / 2.0 }
}

/// A farmyard that fills.
struct Site<'a> {
    relief: &'a Relief,
    parcel: &'a Parcel,
    middle: DVec2,
    taken: Vec<Vec<DVec2>>,
    things: Vec<Thing>,
}

impl Site<'_> {
    /// Takes a rectangle about a place relative to the middle, if it lies within the yard and free.
    fn take(&mut self, at: DVec2, axis: DVec2, half: DVec2, clear_m: f64) -> Option<DVec2> {
        let p = Relief::on_lattice(self.middle + at);
        let outline = polygon::oriented_rectangle(p, axis, half + clear_m);
        let fits = outline.iter().all(|q| polygon::contains(&self.parcel.world, *q))
            && self.taken.iter().all(|t| !polygon::convex_overlap(t, &outline));
        if fits {
            self.taken.push(outline);
        }
        // What lies beyond the full detail takes its place all the same, so that a crop's yard is the whole's.
        (fits && self.relief.is_detailed(p)).then_some(p)
    }

    /// Highest and lowest ground under a rectangle, m.
    fn ground(&self, p: DVec2, axis: DVec2, half: DVec2) -> [f64; 2] {
        let mut found = [f64::MIN, f64::MAX];
        for j in -2..=2 {
            for i in -2..=2 {
                let d = axis * (half.x * f64::from(i) / 2.0) + axis.perp() * (half.y * f64::from(j) / 2.0);
                let z = f64::from(quantise_m(self.relief.height_m(Relief::on_lattice(p + d))));
                found = [found[0].max(z), found[1].min(z)];
            }
        }
        found
    }

    #[allow(clippy::too_many_arguments)]
    fn add(
        &mut self,
        mesh: Mesh,
        materials: Vec<Material>,
        class: Class,
        at: DVec3,
        axis: DVec2,
        path: String,
        rng: &mut Rng,
    ) {
        let placed = Placed {
            at_m: at.truncate(),
            world_from_object: DAffine3::from_cols(axis.extend(0.0), axis.perp().extend(0.0), DVec3::Z, at),
            variation: variation(rng),
            mesh: 0,
            path,
        };
        self.things.push(Thing { kind: Kind { meshes: vec![mesh], materials, class }, placed });
    }

    #[allow(clippy::too_many_arguments)]
    fn building(
        &mut self,
        p: DVec2,
        axis: DVec2,
        masses: Vec<Mass>,
        items: Vec<RoofItem>,
        look: Vec<Material>,
        name: &str,
        rng: &mut Rng,
    ) {
        let half = masses.iter().flat_map(|m| &m.outline).fold(DVec2::ZERO, |h, q| h.max(q.abs()));
        let [high, low] = self.ground(p, axis, half);
        let mut plan = BuildingPlan { centre_m: p, axis, ground_m: high + 0.1, drop_m: high - low, masses, items };
        for mass in &mut plan.masses {
            mass.low_m = -(high - low) - 0.8;
        }
        let mesh = buildings::mesh(&plan, Detail::Full);
        self.add(mesh, look, Class::Roof, p.extend(plan.ground_m), axis, format!("farm/{name}"), rng);
    }

    fn barn(&mut self, at: DVec2, axis: DVec2, [length, width]: [f64; 2], eaves_m: f64, path: &SeedPath) {
        let half = DVec2::new(length, width) / 2.0;
        let Some(p) = self.take(at, axis, half, 1.2) else { return };
        let rng = &mut path.child("own").rng();
        let roof = Roof::Gable { along_first: true, rise_m: width * rng.range(0.15, 0.24), eaves_m: 0.5, hip: 0.0 };
        let mass = mass(polygon::rectangle(-half, half), eaves_m, roof);
        let sheets = [
            Bands::new(0.205, 0.215, 0.220, 0.23),
            Bands::new(0.150, 0.168, 0.185, 0.21),
            Bands::new(0.075, 0.095, 0.150, 0.20),
            Bands::new(0.310, 0.330, 0.340, 0.35),
        ];
        let look = building_look(path, sheets[rng.below(4) as usize], Bands::new(0.17, 0.19, 0.20, 0.22), 1.05);
        // Rows of translucent sheets along the roof.
        self.building(p, axis, vec![mass], Vec::new(), look, &format!("barn/{}", self.taken.len()), rng);
    }

    fn house(&mut self, at: DVec2, axis: DVec2, path: &SeedPath) {
        let rng = &mut path.child("own").rng();
        let half = DVec2::new(rng.range(6.0, 7.5), rng.range(4.2, 5.2));
        let Some(p) = self.take(at, axis, half + DVec2::new(0.0, 1.5), 1.0) else { return };
        let hip = if rng.chance(0.4) { 0.35 } else { 0.0 };
        let roof = Roof::Gable { along_first: true, rise_m: rng.range(3.0, 4.2), eaves_m: 0.45, hip };
        let body = mass(polygon::rectangle(-half, half), rng.range(4.6, 5.8), roof);
        let chimney = RoofItem {
            kind: RoofItemKind::Chimney,
            centre_m: DVec2::new(half.x * 0.5, 0.2),
            axis: DVec2::X,
            half_m: DVec2::new(0.4, 0.3),
            base_m: body.roof_m + 2.4,
            height_m: 2.2,
        };
        let tiles = [
            Bands::new(0.070, 0.105, 0.200, 0.26),
            Bands::new(0.080, 0.092, 0.105, 0.12),
            Bands::new(0.085, 0.110, 0.160, 0.22),
        ];
        let look = building_look(path, tiles[rng.below(3) as usize], Bands::new(0.30, 0.35, 0.38, 0.40), 0.33);
        self.building(p, axis, vec![body], vec![chimney], look, "house", rng);
    }

    /// A silo under a cone, or a round tank with a rim.
    fn round(&mut self, at: DVec2, radius_m: f64, height_m: f64, silo: bool, path: &SeedPath) {
        let half = DVec2::splat(radius_m);
        let Some(p) = self.take(at, DVec2::X, half, 0.4) else { return };
        let [_, low] = self.ground(p, DVec2::X, half);
        let mut rng = path.rng();
        let mut b = MeshBuilder::default();
        let disc = |r: f64| -> Vec<DVec2> {
            (0..20)
                .map(|k| {
                    let (s, c) = libm::sincos(core::f64::consts::TAU * f64::from(k) / 20.0);
                    DVec2::new(c, s) * r
                })
                .collect()
        };
        if silo {
            b.prism(0, 0, &disc(radius_m), -0.5, height_m, Wall::PLAIN);
            b.frustum(1, 1, &disc(radius_m + 0.12), &disc(0.3), height_m - 0.05, height_m + 0.55 * radius_m);
            b.prism(1, 1, &disc(0.4), height_m + 0.5 * radius_m, height_m + 0.55 * radius_m + 0.35, Wall::PLAIN);
        } else {
            b.prism(0, 1, &disc(radius_m), -0.5, height_m - 0.5, Wall::PLAIN);
            let (outer, inner) = (disc(radius_m + 0.2), disc(radius_m - 0.2));
            b.ring(0, &outer, &inner, height_m);
            b.band(0, &outer, -0.5, height_m, Wall::PLAIN, false);
            b.band(0, &inner, height_m - 0.55, height_m, Wall::PLAIN, true);
            b.cap(0, &outer, -0.5, false);
        }
        let seed = path.hash_u32();
        let steel = sheet("silo", Class::OtherStructure, Bands::new(0.27, 0.29, 0.30, 0.31), seed);
        let top = if silo {
            sheet("silo top", Class::Roof, Bands::new(0.33, 0.35, 0.36, 0.37), seed ^ 1)
        } else {
            sheet("slurry", Class::OtherStructure, Bands::new(0.060, 0.075, 0.090, 0.11), seed ^ 1)
        };
        let name = format!("farm/{}/{}", if silo { "silo" } else { "tank" }, self.taken.len());
        self.add(b.finish(), vec![steel, top], Class::OtherStructure, p.extend(low), DVec2::X, name, &mut rng);
    }

    fn machine(&mut self, at: DVec2, axis: DVec2, mesh: Mesh, name: &str, path: &SeedPath) {
        let (low, high) = mesh.bounds_m().unwrap_or_default();
        let half = (high - low).truncate() / 2.0;
        let Some(p) = self.take(at, axis, half, 0.5) else { return };
        let [top, bottom] = self.ground(p, axis, half);
        let mut rng = path.rng();
        let name = format!("farm/{name}/{}", self.taken.len());
        self.add(mesh, machine_look(path), Class::Vehicle, p.extend(0.5 * (top + bottom) - 0.05), axis, name, &mut rng);
    }
}

fn mass(outline: Vec<DVec2>, roof_m: f64, roof: Roof) -> Mass {
    Mass {
        outline,
        low_m: -1.0,
        roof_m,
        first_floor_m: 0.4,
        floor_m: 3.0,
        bay_m: 3.0,
        shop: false,
        facade: Facade::Plain,
        roof,
        balconies: Vec::new(),
    }
}

/// A weathered surface.
fn sheet(name: &str, class: Class, color: Bands, seed: u32) -> Material {
    let noise = |salt: u32, wavelength_m: f32, octaves: u8| {
        Field::Noise(Fractal::new(Space::Object, seed ^ salt, wavelength_m, octaves).gain(0.7))
    };
    Material::diffuse(name, class, color)
        .rough(0.3)
        .with(Layer::Mix {
            color: Bands::new(0.085, 0.105, 0.130, 0.17),
            amount: noise(1, 5.0, 4).ramp(0.0, 0.7).times(0.45),
        })
        .with(Layer::Brightness { amount: noise(2, 1.3, 3).times(0.14) })
}

/// Materials of a building by slot: sheets of a width on the roof.
fn building_look(path: &SeedPath, roof: Bands, wall: Bands, sheet_m: f32) -> Vec<Material> {
    let seed = path.hash_u32();
    let seams = Field::Stripes { across: Coordinate::U, period_m: sheet_m, width_m: 0.1 * sheet_m, offset_m: 0.0 };
    let single = Field::Cells { space: Space::Uv, seed, size_m: [sheet_m, 0.0, 0.0], stagger: 0.0 };
    let roof = sheet("roof", Class::Roof, roof, seed)
        .with(Layer::Brightness { amount: seams.times(-0.18) })
        .with(Layer::Brightness { amount: single.times(0.07) });
    let wall = sheet("wall", Class::Facade, wall, seed ^ 2);
    (0..slot::COUNT as u16)
        .map(|s| match s {
            slot::ROOF => roof.clone(),
            slot::DARK | slot::GLASS | slot::SHOP => Material::diffuse("opening", Class::Facade, Bands::grey(0.04)),
            _ => wall.clone(),
        })
        .collect()
}

/// Paint, glass, tyre, box, lamp.
fn machine_look(path: &SeedPath) -> Vec<Material> {
    let paints = [
        Bands::new(0.040, 0.110, 0.035, 0.18),
        Bands::new(0.045, 0.050, 0.230, 0.26),
        Bands::new(0.160, 0.070, 0.050, 0.12),
        Bands::new(0.420, 0.420, 0.420, 0.42),
        Bands::new(0.130, 0.135, 0.140, 0.15),
    ];
    let mut rng = path.child("paint").rng();
    let paint = paints[rng.below(5) as usize];
    let coated = |name: &str, color: Bands| Material {
        brdf: Brdf::Coated { index: 1.5 },
        ..Material::diffuse(name, Class::Vehicle, color)
    };
    vec![
        coated("paint", paint),
        coated("glass", Bands::grey(0.03)),
        Material::diffuse("tyre", Class::Vehicle, Bands::grey(0.035)),
        Material::diffuse("box", Class::Vehicle, paints[rng.below(5) as usize] * 0.8),
        Material::diffuse("lamp", Class::Vehicle, Bands::grey(0.4)),
    ]
}

/// A tractor: x is forward, z = 0 the ground; slots as the kit's vehicles.
fn tractor() -> Mesh {
    let mut b = MeshBuilder::default();
    let rect = |x0: f64, x1: f64, y: f64| polygon::rectangle(DVec2::new(x0, -y), DVec2::new(x1, y));
    b.prism(0, 0, &rect(0.2, 2.35, 0.42), 0.75, 1.65, Wall::PLAIN);
    b.prism(2, 2, &rect(-1.5, 2.2, 0.3), 0.45, 0.9, Wall::PLAIN);
    let cab = rect(-1.25, 0.3, 0.78);
    b.frustum(1, 1, &cab, &polygon::mitred(&cab, 0.12), 1.05, 2.7);
    b.prism(0, 0, &polygon::mitred(&cab, 0.05), 2.62, 2.85, Wall::PLAIN);
    for (x, r, w, out) in [(-0.85, 0.92, 0.5, 0.95), (1.65, 0.62, 0.4, 0.88)] {
        for side in [-1.0, 1.0] {
            b.limb(
                2,
                DVec3::new(x, side * (out - 0.5 * w), r - 0.04),
                DVec3::new(x, side * (out + 0.5 * w), r - 0.04),
                [r, r],
                12,
            );
        }
        // Mudguards.
        if r > 0.8 {
            for side in [-1.0, 1.0] {
                b.block(0, 0, DVec2::new(x, side * out), DVec2::X, DVec2::new(0.7, 0.24), 1.72, 1.86);
            }
        }
    }
    b.finish()
}

/// A tipping trailer.
fn trailer() -> Mesh {
    let mut b = MeshBuilder::default();
    let outer = polygon::rectangle(DVec2::new(-2.8, -1.2), DVec2::new(2.8, 1.2));
    let inner = polygon::mitred(&outer, 0.1);
    b.band(3, &outer, 1.0, 2.2, Wall::PLAIN, false);
    b.cap(3, &outer, 1.0, false);
    b.ring(3, &outer, &inner, 2.2);
    b.band(3, &inner, 1.35, 2.2, Wall::PLAIN, true);
    b.cap(2, &inner, 1.35, true);
    b.limb(2, DVec3::new(2.7, 0.0, 0.95), DVec3::new(4.1, 0.0, 0.7), [0.09, 0.07], 5);
    for x in [-1.5, 1.2] {
        for side in [-1.0, 1.0] {
            b.limb(2, DVec3::new(x, side * 0.78, 0.5), DVec3::new(x, side * 1.12, 0.5), [0.55, 0.55], 10);
        }
    }
    b.finish()
}

/// A span of a pivot's lateral: x from one tower to the next, a wheeled tower at its far end.
fn span() -> Mesh {
    let mut b = MeshBuilder::default();
    let (l, h) = (TOWER_M, 3.7);
    let arch = |x: f64| h + 0.55 * (1.0 - (2.0 * x / l - 1.0) * (2.0 * x / l - 1.0));
    let n = 8_u32;
    let x = |k: u32| l * f64::from(k) / f64::from(n);
    for k in 0..n {
        let (a, c) = (DVec3::new(x(k), 0.0, arch(x(k))), DVec3::new(x(k + 1), 0.0, arch(x(k + 1))));
        b.limb(0, a, c, [0.11, 0.11], 6);
        let m = (a + c) / 2.0 - DVec3::Z * 1.0;
        for side in [-0.75, 0.75] {
            let low = m + DVec3::Y * side;
            b.limb(0, a, low, [0.05, 0.05], 4);
            b.limb(0, low, c, [0.05, 0.05], 4);
            if k + 1 < n {
                let next = (c + DVec3::new(x(k + 2), 0.0, arch(x(k + 2)))) / 2.0 - DVec3::Z + DVec3::Y * side;
                b.limb(0, low, next, [0.04, 0.04], 4);
            }
        }
    }
    // The tower: two legs on a beam with a wheel at each end.
    for side in [-1.0, 1.0] {
        let foot = DVec3::new(l, side * 2.0, 0.75);
        b.limb(0, DVec3::new(l, 0.0, h), foot, [0.09, 0.09], 5);
        b.limb(1, foot - DVec3::X * 0.16 - DVec3::Z * 0.18, foot + DVec3::X * 0.16 - DVec3::Z * 0.18, [0.62, 0.62], 12);
    }
    b.limb(0, DVec3::new(l, -2.0, 0.75), DVec3::new(l, 2.0, 0.75), [0.08, 0.08], 5);
    b.finish()
}

/// The lateral of each pivot: its spans from the middle outward.
pub(super) fn laterals(relief: &Relief, plan: &Plan, path: &SeedPath) -> Vec<Thing> {
    let mut things = Vec::new();
    let steel = sheet("galvanised pipe", Class::OtherStructure, Bands::new(0.26, 0.27, 0.28, 0.28), path.hash_u32());
    let tyre = Material::diffuse("tyre", Class::OtherStructure, Bands::grey(0.045));
    for (k, (middle, radius)) in plan.pivots.iter().enumerate() {
        let mut rng = path.index(k as u64).rng();
        let (s, c) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
        let axis = DVec2::new(c, s);
        // Towers stand where their wheel tracks are: at eighths of the radius.
        let length = radius / 8.0;
        for span_index in 0..8_u32 {
            let at = |t: f64| Relief::on_lattice(*middle + axis * (length * (f64::from(span_index) + t)));
            if !relief.is_detailed(at(0.5)) {
                continue;
            }
            let [z0, z1] = [at(0.0), at(1.0)].map(|p| f64::from(quantise_m(relief.height_m(p))));
            let rise = (z1 - z0) / length;
            let stretch = length / TOWER_M;
            let world = DAffine3::from_cols(
                (axis * stretch).extend(rise * stretch),
                axis.perp().extend(0.0),
                DVec3::Z,
                at(0.0).extend(z0 - 0.1),
            );
            let placed = Placed {
                at_m: at(0.0),
                world_from_object: world,
                variation: [0.0; 4],
                mesh: 0,
                path: format!("pivot/{k}/span/{span_index}"),
            };
            let kind = Kind {
                meshes: vec![span()],
                materials: vec![steel.clone(), tyre.clone()],
                class: Class::OtherStructure,
            };
            things.push(Thing { kind, placed });
        }
    }
    things
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::mesh_builder::open_edges;

    #[test]
    fn machines_are_closed_and_touch_the_ground() {
        for (name, m) in [("tractor", tractor()), ("trailer", trailer()), ("span", span())] {
            assert_eq!((m.validate(), open_edges(&m)), (Ok(()), 0), "{name}");
            let low = m.bounds_m().unwrap().0.z;
            assert!((-0.1..0.02).contains(&low), "{name}: {low}");
        }
    }
}
