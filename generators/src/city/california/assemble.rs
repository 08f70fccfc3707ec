//! From the plan to a scene.

use super::freeway::{self, Interchange};
use super::hill::{self, skeleton::Hills};
use super::house::add_extras;
use super::land::Land;
use super::layout::{self, Grid};
use super::lot::{self, Building, Content, Plant};
use super::marina::harbour::Harbour;
use super::marina::{self, Marina};
use super::materials::Materials;
use super::paving::{self, KERB_M, Layer};
use super::{DETAIL_MARGIN_M, Params, RING_M, Variant, ground_slot, slabs, streets, urban};
use crate::kit::buildings::{self, Detail};
use crate::kit::ground::{Ground, Patch};
use crate::kit::mesh_builder::{MeshBuilder, Wall};
use crate::kit::vehicles::Body;
use crate::kit::{furniture, palm, polygon, shrub, trees};
use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};
use rayon::prelude::*;
use satseed_scene::{Class, Instance, Mesh, Object, Scene, SeedPath};

/// Everything decided, nothing made. Parts are named and in the order of their names' numbers.
pub(super) struct CityPlan {
    pub(super) land: Land,
    pub(super) parts: Vec<(String, Content)>,
    pub(super) interchange: Interchange,
    pub(super) marina: Marina,
}

/// Individuals of each kind of plant.
const INDIVIDUALS: u64 = 8;

pub(super) fn plan(params: &Params, city: &SeedPath) -> CityPlan {
    if urban::is(params.variant) {
        let land = Land::new(city);
        let parts = urban::plan(params, &land, city);
        return CityPlan { land, parts, interchange: Interchange::default(), marina: Marina::default() };
    }
    let freeways = params.variant == Variant::Interchange;
    let (land, grid) = match params.variant {
        Variant::Hill => return on_hills(params, city),
        Variant::Waterfront => {
            let grid = Grid::around_harbour(city);
            (Land::around(Harbour::new(&grid, city), city), grid)
        }
        _ => (Land::new(city), Grid::new(city, freeways)),
    };
    let interchange = if freeways { freeway::plan(params, &grid, &land, city) } else { Interchange::default() };
    let roofed = Roofed::of(&interchange);
    let reach = params.radius_m + RING_M;
    let detail = params.radius_m + DETAIL_MARGIN_M;
    let modules = layout::modules(&grid, &land, city, reach + 40.0);
    let height = |p: DVec2| land.height_m(p);
    let mut parts = Vec::new();
    for module in &modules {
        let near = module_distance(module) < detail + 40.0;
        parts.push((format!("{}/streets", module.name), streets::local(module, params, near)));
        for slab in &module.slabs {
            let mut content = slabs::plan(params, slab, &height);
            content.plants.retain(|p| !roofed.near(p.at));
            parts.push((slab.name.clone(), content));
        }
        let wanted: Vec<&layout::Lot> =
            module.lots.iter().filter(|l| polygon::centroid(&l.outline).length() < reach).collect();
        let contents: Vec<Content> = wanted.par_iter().map(|l| lot::plan(params, l, &height)).collect();
        for (l, mut content) in wanted.into_iter().zip(contents) {
            let distance = polygon::centroid(&l.outline).length();
            if distance > detail + 30.0 {
                content.patches.truncate(1);
            }
            parts.push((l.name.clone(), content));
        }
    }
    for piece in layout::pieces(&grid, reach + 40.0) {
        let middle = land.world((piece.ends[0] + piece.ends[1]) * 0.5);
        let half = piece.ends[0].distance(piece.ends[1]) / 2.0;
        if middle.length() < reach + half {
            let name = format!("line/{}/{}/{}", piece.index[0], piece.index[1], piece.index[2]);
            let content = streets::piece(&piece, &land, params, city, middle.length() < detail + half + 60.0);
            parts.push((name, content));
        }
    }
    let plants = interchange.plants.iter().filter(|p| !roofed.near(p.at)).copied().collect();
    parts.push(("interchange".to_owned(), Content { plants, ..Content::default() }));
    let (harbour, marina) = marina::plan(params, &grid, &land, city);
    parts.extend(harbour);
    CityPlan { land, parts, interchange, marina }
}

/// A plan without lines and modules.
fn on_hills(params: &Params, city: &SeedPath) -> CityPlan {
    let land = Land::over(Hills::new(city), city);
    let parts = hill::plan(params, &land, city);
    CityPlan { land, parts, interchange: Interchange::default(), marina: Marina::default() }
}

/// Where the decks of an interchange are, for what must keep clear of their embankments.
struct Roofed {
    stretches: Vec<(Vec<DVec2>, (DVec2, DVec2))>,
}

impl Roofed {
    /// What stands nearer to a deck than this may stand in its embankment, m.
    const CLEAR_M: f64 = 15.0;

    fn of(interchange: &Interchange) -> Self {
        // In stretches, so that few need a close look.
        let stretches = interchange
            .decks
            .iter()
            .flat_map(|deck| {
                let n = deck.len() / 2;
                (0..n - 1).step_by(8).map(move |k| {
                    let end = (k + 8).min(n - 1);
                    let mut piece: Vec<DVec2> = deck[k..=end].to_vec();
                    piece.extend((k..=end).rev().map(|i| deck[2 * n - 1 - i]));
                    let bounds = polygon::bounds(&piece);
                    (piece, bounds)
                })
            })
            .collect();
        Self { stretches }
    }

    fn near(&self, p: DVec2) -> bool {
        self.stretches.iter().any(|(piece, (low, high))| {
            p.cmpge(*low - Self::CLEAR_M).all()
                && p.cmple(*high + Self::CLEAR_M).all()
                && (polygon::contains(piece, p) || polygon::border_distance(piece, p) < Self::CLEAR_M)
        })
    }
}

/// Distance of a module's nearest corner or edge from the pivot, m, about.
fn module_distance(module: &layout::Module<'_>) -> f64 {
    let size = module.sheet.size;
    let quad = module.sheet.corners(&polygon::rectangle(DVec2::ZERO, size));
    if polygon::contains(&quad, DVec2::ZERO) { 0.0 } else { polygon::border_distance(&quad, DVec2::ZERO) }
}

/// The ground of a plan.
pub(super) fn ground(params: &Params, plan: &CityPlan) -> Ground {
    let layers: Vec<(Layer, Patch)> = plan.parts.iter().flat_map(|(_, c)| c.patches.iter().cloned()).collect();
    let slots = (ground_slot::LAND, ground_slot::KERB);
    let post_m = if params.variant == Variant::Hill { hill::POST_M } else { paving::GENTLE_M };
    let mut ground = paving::ground(layers, slots, params.radius_m + 200.0, post_m, &|p| plan.land.height_m(p));
    hill::shade(&mut ground.mesh, &plan.land);
    ground
}

pub(super) struct Assembly<'a> {
    pub(super) scene: Scene,
    pub(super) materials: Materials,
    pub(super) city: &'a SeedPath,
    detail_m: f64,
}

fn placed(position: DVec3, axis: DVec2, scale: f64) -> DAffine3 {
    let columns = DMat3::from_cols(axis.extend(0.0), axis.perp().extend(0.0), DVec3::Z);
    DAffine3::from_mat3_translation(columns * scale, position)
}

impl Assembly<'_> {
    pub(super) fn mesh(&mut self, mesh: Mesh) -> u32 {
        self.scene.meshes.push(mesh);
        self.scene.meshes.len() as u32 - 1
    }

    fn object(&mut self, path: String, class: Class) -> u32 {
        self.scene.objects.push(Object { path, class });
        self.scene.objects.len() as u32 - 1
    }

    fn instance(&mut self, mesh: u32, world_from_object: DAffine3, object: u32, material_set: u32, key: &SeedPath) {
        let mut rng = key.child("variation").rng();
        let variation = core::array::from_fn(|_| rng.signed() as f32);
        self.scene.instances.push(Instance { mesh, world_from_object, object, material_set, variation });
    }

    /// An object of one instance, upright, its x along an axis of the plan.
    pub(super) fn put(&mut self, mesh: u32, (at, axis): (DVec3, DVec2), (name, class): (String, Class), set: u32) {
        let key = self.city.child(&name);
        let object = self.object(name, class);
        self.instance(mesh, placed(at, axis, 1.0), object, set, &key);
    }

    fn near(&self, p: DVec2) -> bool {
        p.length() < self.detail_m
    }
}

pub(super) fn assemble(params: &Params, plan: &CityPlan, city: &SeedPath) -> Scene {
    let mut materials = Materials::new(&city.child("materials"));
    if urban::is(params.variant) {
        materials.add_urban(&city.child("materials"));
    }
    if params.variant == Variant::Waterfront {
        materials.add_marina(&city.child("materials"));
    }
    let detail_m = params.radius_m + DETAIL_MARGIN_M;
    let mut a = Assembly { scene: Scene::default(), materials, city, detail_m };
    let terrain = a.mesh(ground(params, plan).mesh);
    let object = a.object("ground".to_owned(), Class::Ground);
    a.instance(terrain, DAffine3::IDENTITY, object, 0, &city.child("ground"));
    buildings_of(&mut a, plan);
    interchange(&mut a, plan);
    fences(&mut a, plan);
    vegetation(&mut a, plan);
    vehicles(&mut a, plan);
    lights(&mut a, plan);
    marina::assemble(&mut a, &plan.land, &plan.marina, params.radius_m + RING_M);
    a.scene.materials = a.materials.list;
    a.scene.material_sets = a.materials.sets;
    a.scene.pivot_height_m = plan.land.height_m(DVec2::ZERO);
    a.scene.full_detail_radius_m = params.radius_m;
    a.scene
}

/// The mesh of one building with what its plan holds beside masses and roof items.
pub(super) fn building_mesh(building: &Building, detail: Detail) -> Mesh {
    let mut mesh = buildings::mesh(&building.plan, detail);
    if detail == Detail::Full {
        add_extras(&mut mesh, &building.extras);
    }
    mesh
}

fn detail(b: &Building, near_m: f64) -> Detail {
    if b.plan.centre_m.length() < near_m { Detail::Full } else { Detail::Massing }
}

fn buildings_of(a: &mut Assembly<'_>, plan: &CityPlan) {
    let all: Vec<&(String, Building)> = plan.parts.iter().flat_map(|(_, c)| &c.buildings).collect();
    let near = a.detail_m;
    let meshes: Vec<Mesh> = all.par_iter().map(|(_, b)| building_mesh(b, detail(b, near))).collect();
    for ((name, building), mesh) in all.into_iter().zip(meshes) {
        let key = a.city.child(name);
        let set = a.materials.building_set(building.kind, detail(building, near) == Detail::Massing, &key);
        let mesh = a.mesh(mesh);
        let object = a.object(name.clone(), Class::Roof);
        let p = &building.plan;
        a.instance(mesh, placed(p.centre_m.extend(p.ground_m), p.axis, 1.0), object, set, &key);
    }
}

fn interchange(a: &mut Assembly<'_>, plan: &CityPlan) {
    if plan.interchange.pieces.is_empty() {
        return;
    }
    let set = a.materials.freeway_set();
    for (name, mesh) in &plan.interchange.pieces {
        let key = a.city.child(name);
        let mesh = a.mesh(mesh.clone());
        let object = a.object(name.clone(), Class::Bridge);
        a.instance(mesh, DAffine3::IDENTITY, object, set, &key);
    }
    let bodies: Vec<Mesh> = Body::ALL.iter().map(|b| b.mesh()).collect();
    let meshes: Vec<u32> = bodies.into_iter().map(|m| a.mesh(m)).collect();
    for (k, v) in plan.interchange.vehicles.iter().enumerate() {
        if !a.near(v.at.truncate()) {
            continue;
        }
        let name = format!("interchange/vehicle/{k}");
        let key = a.city.child(&name);
        let set = a.materials.vehicle_set(v.body, &mut key.rng());
        let across = DVec3::Z.cross(v.axis).normalize();
        let columns = DMat3::from_cols(v.axis, across, v.axis.cross(across));
        let index = Body::ALL.iter().position(|b| *b == v.body).unwrap_or(0);
        let object = a.object(name, Class::Vehicle);
        a.instance(meshes[index], DAffine3::from_mat3_translation(columns, v.at), object, set, &key);
    }
}

/// The fences of each lot are one thing.
fn fences(a: &mut Assembly<'_>, plan: &CityPlan) {
    for (name, content) in &plan.parts {
        let Some(first) = content.fences.first() else { continue };
        if !a.near(first.from) {
            continue;
        }
        let origin = first.from.extend(plan.land.height_m(first.from));
        let mut b = MeshBuilder::default();
        for f in &content.fences {
            let (along, length) = ((f.to - f.from).normalize(), f.from.distance(f.to));
            let half = if f.block { 0.1 } else { 0.045 };
            // Boards follow the ground in pieces.
            let pieces = libm::ceil(length / 12.0).max(1.0);
            for k in 0..pieces as u32 {
                let share = |x: f64| f.from + along * (length * x / pieces);
                let (p, q) = (share(f64::from(k)), share(f64::from(k + 1)));
                let ground = plan.land.height_m((p + q) * 0.5) - origin.z;
                let centre = (p + q) * 0.5 - origin.truncate();
                let half = DVec2::new(p.distance(q) / 2.0, half);
                let outline = polygon::oriented_rectangle(centre, along, half);
                b.prism(
                    u16::from(f.block),
                    u16::from(f.block),
                    &outline,
                    ground - 0.5,
                    ground + f.height_m,
                    Wall::PLAIN,
                );
                if f.block {
                    let cap = polygon::mitred(&outline, -0.03);
                    b.prism(1, 1, &cap, ground + f.height_m - 0.02, ground + f.height_m + 0.07, Wall::PLAIN);
                }
            }
        }
        let name = format!("{name}/fence");
        let key = a.city.child(&name);
        let set = a.materials.fence_set(&key);
        let mesh = a.mesh(b.finish());
        let object = a.object(name, Class::OtherStructure);
        a.instance(mesh, DAffine3::from_translation(origin), object, set, &key);
    }
}

fn vegetation(a: &mut Assembly<'_>, plan: &CityPlan) {
    let grow = |a: &mut Assembly<'_>, kind: &str, k: usize, make: &(dyn Fn(&SeedPath) -> Mesh + Sync)| -> Vec<u32> {
        let path = a.city.child(kind).index(k as u64);
        let grown: Vec<Mesh> = (0..INDIVIDUALS).into_par_iter().map(|n| make(&path.index(n))).collect();
        grown.into_iter().map(|m| a.mesh(m)).collect()
    };
    let broad: Vec<Vec<u32>> =
        trees::SPECIES.iter().enumerate().map(|(k, s)| grow(a, "tree kind", k, &|p| trees::tree(s, p))).collect();
    let palms: Vec<Vec<u32>> =
        palm::PALMS.iter().enumerate().map(|(k, s)| grow(a, "palm kind", k, &|p| palm::palm(s, p))).collect();
    let shrubs = grow(a, "shrub kind", 0, &shrub::shrub);
    for (part, content) in &plan.parts {
        for (k, planted) in content.plants.iter().enumerate() {
            let p = planted.at;
            if !a.near(p) {
                continue;
            }
            let name = format!("{part}/plant/{k}");
            let key = a.city.child(&name);
            let mut rng = key.rng();
            let n = rng.below(INDIVIDUALS) as usize;
            let yaw = DQuat::from_rotation_z(rng.range(0.0, core::f64::consts::TAU));
            let ground = plan.land.height_m(p);
            let (mesh, set, stretch, class) = match planted.plant {
                Plant::Broad | Plant::Upright => {
                    let upright = planted.plant == Plant::Upright;
                    let species = if upright { 3 } else { rng.weighted(&[0.42, 0.4, 0.18]) };
                    let s = planted.size * rng.range(0.75, 1.15) * if upright { 0.75 } else { 1.0 };
                    let flat = if upright { 1.0 } else { rng.range(0.72, 1.0) };
                    let set = a.materials.tree_set(rng.below(6) as usize);
                    (broad[species][n], set, DVec3::new(s, s, s * flat), Class::Tree)
                }
                Plant::Palm => {
                    let kind = rng.weighted(&[0.42, 0.18, 0.16, 0.24]);
                    let s = (planted.size * rng.range(0.85, 1.1)).clamp(0.7, 1.15);
                    (palms[kind][n], a.materials.palm_set(), DVec3::splat(s), Class::Tree)
                }
                Plant::Shrub | Plant::Chaparral => {
                    let low = planted.plant == Plant::Chaparral;
                    let (wide, high) = if low { ([1.1, 2.0], [0.5, 0.95]) } else { ([0.9, 1.4], [0.8, 1.3]) };
                    let w = planted.size * rng.range(wide[0], wide[1]);
                    let h = planted.size * rng.range(high[0], high[1]);
                    let set = a.materials.shrub_set(rng.below(4) as usize);
                    (shrubs[n], set, DVec3::new(w, w * rng.range(0.8, 1.0), h), Class::LowVegetation)
                }
            };
            let at = p.extend(ground - 0.03);
            let object = a.object(name, class);
            a.instance(mesh, DAffine3::from_scale_rotation_translation(stretch, yaw, at), object, set, &key);
        }
    }
}

fn vehicles(a: &mut Assembly<'_>, plan: &CityPlan) {
    let bodies: Vec<Mesh> = Body::ALL.iter().map(|b| b.mesh()).collect();
    let meshes: Vec<u32> = bodies.into_iter().map(|m| a.mesh(m)).collect();
    for (part, content) in &plan.parts {
        let on_ground = content.vehicles.iter().enumerate().map(|(k, v)| ("vehicle", k, v, None));
        let on_decks = content.raised.iter().enumerate().map(|(k, (v, deck_m))| ("raised", k, v, Some(*deck_m)));
        for (what, k, v, deck_m) in on_ground.chain(on_decks) {
            if !a.near(v.centre) {
                continue;
            }
            let name = format!("{part}/{what}/{k}");
            let key = a.city.child(&name);
            let mut rng = key.rng();
            let set = a.materials.vehicle_set(v.body, &mut rng);
            let (s, c) = libm::sincos(rng.signed() * 0.03);
            let axis = DVec2::new(v.axis.x * c - v.axis.y * s, v.axis.x * s + v.axis.y * c);
            let below_m = if v.lowered { KERB_M } else { 0.0 };
            let at = v.centre.extend(deck_m.unwrap_or_else(|| plan.land.height_m(v.centre) - below_m));
            let index = Body::ALL.iter().position(|b| *b == v.body).unwrap_or(0);
            let object = a.object(name, Class::Vehicle);
            a.instance(meshes[index], placed(at, axis, rng.range(0.95, 1.05)), object, set, &key);
        }
    }
}

fn lights(a: &mut Assembly<'_>, plan: &CityPlan) {
    let light = a.mesh(furniture::street_light(8.4));
    let set = a.materials.steel_set();
    for (part, content) in &plan.parts {
        for (k, (p, to_road)) in content.lights.iter().enumerate() {
            if !a.near(*p) {
                continue;
            }
            let name = format!("{part}/light/{k}");
            let key = a.city.child(&name);
            let object = a.object(name, Class::OtherStructure);
            a.instance(light, placed(p.extend(plan.land.height_m(*p)), *to_road, 1.0), object, set, &key);
        }
    }
}
