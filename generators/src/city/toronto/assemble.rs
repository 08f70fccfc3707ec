//! From the plan to a scene.

use super::blocks::{self, BlockPlan};
use super::materials::Materials;
use super::rail::{self, Corridor};
use super::relief::Swells;
use super::traffic::{self, Parked, SegmentPlan, draw_body};
use super::{DETAIL_MARGIN_M, Params, RING_M, Variant, ground_slot, streets};
use crate::kit::buildings::{self, Detail};
use crate::kit::ground::{self, Ground, GroundPlan, Patch};
use crate::kit::streets::{Block, Segment};
use crate::kit::vehicles::Body;
use crate::kit::{furniture, polygon, trees};
use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};
use rayon::prelude::*;
use satseed_scene::{Class, Instance, Mesh, Object, Scene, SeedPath};

/// Everything decided, nothing made.
pub(super) struct CityPlan {
    pub(super) relief: Swells,
    pub(super) corridor: Option<Corridor>,
    pub(super) blocks: Vec<(Block, BlockPlan)>,
    pub(super) segments: Vec<(Segment, SegmentPlan)>,
}

impl CityPlan {
    /// Height of the ground, m.
    pub(super) fn ground_m(&self, p: DVec2) -> f64 {
        self.relief.height_m(p) - self.corridor.as_ref().map_or(0.0, |c| c.depth_m(p))
    }
}

/// Individuals of each species of tree.
const INDIVIDUALS: u64 = 8;

/// Height of a kerb, m.
const KERB_M: f64 = 0.15;

/// Spacing of the ground's posts near the pivot, m.
const FINE_M: f64 = 20.0;

/// Half side of the ground, m.
const GROUND_HALF_M: f64 = 2400.0;

pub(super) fn plan(params: &Params, city: &SeedPath) -> CityPlan {
    let relief = Swells::new(city);
    let reach = params.radius_m + RING_M;
    let mut streets = streets(params.variant, city, reach + 400.0);
    let corridor = (params.variant == Variant::Rail).then(|| Corridor::insert(&mut streets, city));
    let height = |p: DVec2| relief.height_m(p);
    let blocks: Vec<(Block, BlockPlan)> = streets
        .blocks(reach)
        .into_par_iter()
        .map(|b| {
            let plan = blocks::plan(params, &b, &height, city);
            (b, plan)
        })
        .collect();
    let segments: Vec<(Segment, SegmentPlan)> = match &corridor {
        Some(corridor) => rail::segments(corridor, &streets, reach - 100.0, params, city),
        None => streets
            .segments(reach - 100.0)
            .into_par_iter()
            .map(|s| {
                let plan = traffic::plan(params, &s, city);
                (s, plan)
            })
            .collect(),
    };
    CityPlan { relief, corridor, blocks, segments }
}

/// The ground of a plan.
pub(super) fn ground(params: &Params, plan: &CityPlan) -> Ground {
    let mut patches = Vec::new();
    let near = |p: DVec2| p.length() < params.radius_m + 2.0 * DETAIL_MARGIN_M + 60.0;
    for (block, content) in &plan.blocks {
        let axis = (block.kerb[1] - block.kerb[0]).normalize();
        patches.push(Patch {
            outline: polygon::rounded(&block.kerb, 6.5, 5),
            slot: ground_slot::SIDEWALK,
            origin_m: block.kerb[0],
            axis,
            lowered: false,
        });
        let detailed = near(polygon::centroid(&block.kerb));
        patches.extend(content.patches.iter().take(if detailed { usize::MAX } else { 1 }).cloned());
    }
    for (segment, content) in &plan.segments {
        let middle = segment.street.at(f64::midpoint(segment.span_m[0], segment.span_m[1]), 0.0);
        patches.extend(content.patches.iter().take(if near(middle) { usize::MAX } else { 1 }).cloned());
    }
    if let Some(corridor) = &plan.corridor {
        patches.extend(rail::patches(corridor, params.radius_m + RING_M));
    }
    // Drives run into lots and tracks over gravel: these outlines cross.
    if matches!(params.variant, Variant::Slabs | Variant::Rail) {
        patches = ground::arranged(patches, FINE_M);
    }
    let ground_plan = GroundPlan {
        patches,
        background_slot: ground_slot::CARRIAGEWAY,
        background_lowered: true,
        kerb_slot: ground_slot::KERB,
        kerb_m: KERB_M,
        half_m: GROUND_HALF_M,
        fine_radius_m: params.radius_m + 200.0,
        fine_m: FINE_M,
        coarse_m: 50.0,
    };
    ground::triangulate(&ground_plan, &|p| plan.ground_m(p))
}

struct Assembly<'a> {
    scene: Scene,
    materials: Materials,
    city: &'a SeedPath,
}

fn placed(position: DVec3, axis: DVec2, scale: f64) -> DAffine3 {
    let columns = DMat3::from_cols(axis.extend(0.0), axis.perp().extend(0.0), DVec3::Z);
    DAffine3::from_mat3_translation(columns * scale, position)
}

impl Assembly<'_> {
    fn mesh(&mut self, mesh: Mesh) -> u32 {
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
}

pub(super) fn assemble(params: &Params, plan: &CityPlan, city: &SeedPath) -> Scene {
    let mut a = Assembly { scene: Scene::default(), materials: Materials::new(&city.child("materials")), city };
    match params.variant {
        Variant::Slabs => a.materials.add_estate(&city.child("materials")),
        Variant::Rail => a.materials.add_rail(&city.child("materials")),
        Variant::Core | Variant::Midtown => {}
    }
    let terrain = a.mesh(ground(params, plan).mesh);
    let object = a.object("ground".to_owned(), Class::Ground);
    a.instance(terrain, DAffine3::IDENTITY, object, 0, &city.child("ground"));
    buildings_of(&mut a, params, plan);
    vegetation(&mut a, params, plan);
    vehicles(&mut a, params, plan);
    street_things(&mut a, params, plan);
    if let Some(corridor) = &plan.corridor {
        railway(&mut a, params, plan, corridor);
    }
    a.scene.materials = a.materials.list;
    a.scene.material_sets = a.materials.sets;
    a.scene.pivot_height_m = plan.ground_m(DVec2::ZERO);
    a.scene.full_detail_radius_m = params.radius_m;
    a.scene
}

fn buildings_of(a: &mut Assembly<'_>, params: &Params, plan: &CityPlan) {
    let all: Vec<(&String, &super::massing::Building)> =
        plan.blocks.iter().flat_map(|(_, b)| b.buildings.iter().map(|(name, b)| (name, b))).collect();
    let detail = |b: &buildings::BuildingPlan| {
        if b.centre_m.length() < params.radius_m + DETAIL_MARGIN_M { Detail::Full } else { Detail::Massing }
    };
    let meshes: Vec<Mesh> = all.par_iter().map(|(_, b)| buildings::mesh(&b.plan, detail(&b.plan))).collect();
    for ((name, building), mesh) in all.into_iter().zip(meshes) {
        let key = a.city.child(name);
        let set = a.materials.building_set(building.kind, detail(&building.plan) == Detail::Massing, &key);
        let mesh = a.mesh(mesh);
        let object = a.object(name.clone(), Class::Roof);
        let p = &building.plan;
        a.instance(mesh, placed(p.centre_m.extend(p.ground_m), p.axis, 1.0), object, set, &key);
    }
}

/// Trees may overhang what is lower than this, m: fences.
const FENCE_M: f64 = 2.2;

/// World outlines of what stands on the ground, in bins, so that nothing grows through a building.
struct Occupied {
    outlines: Vec<Vec<DVec2>>,
    bounds: Vec<(DVec2, DVec2)>,
}

impl Occupied {
    fn of(block: &BlockPlan) -> Self {
        let outlines: Vec<Vec<DVec2>> = block
            .buildings
            .iter()
            .flat_map(|(_, b)| {
                b.plan
                    .masses
                    .iter()
                    .filter(|m| m.low_m < 0.0 && m.roof_m > FENCE_M)
                    .map(|m| b.plan.world_outline(m))
                    .collect::<Vec<_>>()
            })
            .collect();
        let bounds = outlines.iter().map(|o| polygon::bounds(o)).collect();
        Self { outlines, bounds }
    }

    fn free(&self, p: DVec2, clear_m: f64) -> bool {
        self.outlines.iter().zip(&self.bounds).all(|(o, (low, high))| {
            let out = DVec2::splat(clear_m);
            let near = p.cmpge(*low - out).all() && p.cmple(*high + out).all();
            !near || (!polygon::contains(o, p) && polygon::border_distance(o, p) > clear_m)
        })
    }
}

fn vegetation(a: &mut Assembly<'_>, params: &Params, plan: &CityPlan) {
    let mut meshes = Vec::new();
    for (k, species) in trees::SPECIES.iter().enumerate() {
        let path = a.city.child("tree kind").index(k as u64);
        let grown: Vec<Mesh> = (0..INDIVIDUALS).into_par_iter().map(|n| trees::tree(species, &path.index(n))).collect();
        let first: Vec<u32> = grown.into_iter().map(|m| a.mesh(m)).collect();
        meshes.push(first);
    }
    let sets: Vec<u32> = (0..trees::SPECIES.len()).map(|k| a.materials.tree_set(k)).collect();
    let mut places: Vec<(DVec2, String, [f64; 4], f64)> = Vec::new();
    for (block, content) in &plan.blocks {
        let occupied = Occupied::of(content);
        let weights = match content.character {
            blocks::Character::Park => [0.5, 0.3, 0.05, 0.15],
            blocks::Character::Rows => [0.5, 0.2, 0.2, 0.1],
            blocks::Character::Estate => [0.5, 0.26, 0.09, 0.15],
            _ => [0.25, 0.35, 0.35, 0.05],
        };
        for (k, p) in content.trees.iter().enumerate() {
            let room = if occupied.free(*p, 3.4) { 1.15 } else { 0.6 };
            if occupied.free(*p, 1.4) {
                places.push((*p, format!("block/{}/{}/tree/{k}", block.index[0], block.index[1]), weights, room));
            }
        }
    }
    for (segment, content) in &plan.segments {
        let [f, i, j] = segment.index;
        for (k, p) in content.trees.iter().enumerate() {
            places.push((*p, format!("street/{f}/{i}/{j}/tree/{k}"), [0.34, 0.42, 0.24, 0.0], 1.0));
        }
    }
    for (p, name, weights, room) in places {
        if p.length() > params.radius_m + DETAIL_MARGIN_M {
            continue;
        }
        let key = a.city.child(&name);
        let mut rng = key.rng();
        if params.trees < 1.0 && name.starts_with("block") && !rng.chance(params.trees) {
            continue;
        }
        let species = rng.weighted(&weights);
        let mesh = meshes[species][rng.below(INDIVIDUALS) as usize];
        let scale = room * rng.range(0.75, 1.3);
        let yaw = DQuat::from_rotation_z(rng.range(0.0, core::f64::consts::TAU));
        let lean = DQuat::from_axis_angle(DVec3::X, rng.signed() * 0.05);
        let at = p.extend(plan.relief.height_m(p));
        let stretch = DVec3::new(scale, scale, scale * rng.range(0.85, 1.15));
        let transform = DAffine3::from_scale_rotation_translation(stretch, yaw * lean, at);
        let object = a.object(name, Class::Tree);
        a.instance(mesh, transform, object, sets[species], &key);
    }
}

fn vehicles(a: &mut Assembly<'_>, params: &Params, plan: &CityPlan) {
    let meshes: Vec<u32> =
        Body::ALL.iter().map(|b| b.mesh()).collect::<Vec<_>>().into_iter().map(|m| a.mesh(m)).collect();
    let mut all: Vec<(Parked, String, f64)> = Vec::new();
    for (segment, content) in &plan.segments {
        let [f, i, j] = segment.index;
        for (k, v) in content.vehicles.iter().enumerate() {
            all.push((*v, format!("street/{f}/{i}/{j}/vehicle/{k}"), KERB_M));
        }
    }
    for (block, content) in &plan.blocks {
        for (k, s) in content.stalls.iter().enumerate() {
            let name = format!("block/{}/{}/vehicle/{k}", block.index[0], block.index[1]);
            let body = draw_body(&mut a.city.child(&name).child("body").rng(), false);
            all.push((Parked { centre: s.centre, axis: s.axis, body }, name, 0.0));
        }
    }
    for (v, name, below_m) in all {
        if v.centre.length() > params.radius_m + DETAIL_MARGIN_M {
            continue;
        }
        let key = a.city.child(&name);
        let mut rng = key.rng();
        let set = a.materials.vehicle_set(v.body, &mut rng);
        let (s, c) = libm::sincos(rng.signed() * 0.025);
        let axis = DVec2::new(v.axis.x * c - v.axis.y * s, v.axis.x * s + v.axis.y * c);
        let at = v.centre.extend(plan.relief.height_m(v.centre) - below_m);
        let index = Body::ALL.iter().position(|b| *b == v.body).unwrap_or(0);
        let object = a.object(name, Class::Vehicle);
        a.instance(meshes[index], placed(at, axis, rng.range(0.95, 1.05)), object, set, &key);
    }
}

fn street_things(a: &mut Assembly<'_>, params: &Params, plan: &CityPlan) {
    let light = a.mesh(furniture::street_light(8.8));
    let steel = a.materials.steel_set(false);
    for (segment, content) in &plan.segments {
        let [f, i, j] = segment.index;
        for (k, (p, to_road)) in content.lights.iter().enumerate() {
            if p.length() > params.radius_m + DETAIL_MARGIN_M {
                continue;
            }
            let name = format!("street/{f}/{i}/{j}/light/{k}");
            let key = a.city.child(&name);
            let object = a.object(name, Class::OtherStructure);
            a.instance(light, placed(p.extend(plan.relief.height_m(*p)), *to_road, 1.0), object, steel, &key);
        }
    }
    let paint = a.materials.steel_set(true);
    for (block, content) in &plan.blocks {
        for (k, p) in content.cleared.iter().enumerate() {
            let name = format!("block/{}/{}/crane/{k}", block.index[0], block.index[1]);
            let key = a.city.child(&name);
            let mut rng = key.rng();
            if p.length() > params.radius_m + DETAIL_MARGIN_M || !rng.chance(0.6) {
                continue;
            }
            let crane = a.mesh(furniture::tower_crane(rng.range(45.0, 110.0), rng.range(38.0, 58.0)));
            let (s, c) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
            let object = a.object(name, Class::OtherStructure);
            a.instance(crane, placed(p.extend(plan.relief.height_m(*p)), DVec2::new(c, s), 1.0), object, paint, &key);
        }
    }
}

fn railway(a: &mut Assembly<'_>, params: &Params, plan: &CityPlan, corridor: &Corridor) {
    let reach = params.radius_m + DETAIL_MARGIN_M;
    for part in rail::parts(corridor, &plan.relief, reach) {
        let key = a.city.child(&part.name);
        let bridge = part.class == Class::Bridge;
        // What is cut into pieces is of one kind all along.
        let of = if bridge { key } else { a.city.child("rail") };
        let set = if part.track {
            a.materials.track_set()
        } else {
            a.materials.works_set(part.street_kind, bridge, &mut of.child("materials").rng())
        };
        let mesh = a.mesh(part.mesh);
        let object = a.object(part.name, part.class);
        a.instance(mesh, placed(part.origin, part.axis, 1.0), object, set, &of);
    }
    let meshes: Vec<u32> =
        rail::Body::ALL.iter().map(|b| b.mesh()).collect::<Vec<_>>().into_iter().map(|m| a.mesh(m)).collect();
    for car in rail::consists(corridor, &plan.relief, params.vehicles, reach) {
        let key = a.city.child(&car.name);
        let set = a.materials.car_set(car.body, car.livery, &mut key.child("materials").rng());
        let index = rail::Body::ALL.iter().position(|b| *b == car.body).unwrap_or(0);
        let object = a.object(car.name, Class::Vehicle);
        a.instance(meshes[index], car.world_from_object, object, set, &key);
    }
}
