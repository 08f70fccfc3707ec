//! From the plan to a scene.

use super::boats::Boat;
use super::bridges::{self, Span};
use super::canals::{self, Canals};
use super::church::{self, Church};
use super::fabric::{self, Open};
use super::houses::{self, House};
use super::lie::{Lie, WATER_M};
use super::materials::Materials;
use super::moorings::{Moored, Shore, Waters};
use super::piece::Piece;
use super::things::{self, Placed, Thing};
use super::{DETAIL_MARGIN_M, Params, RING_M, ground_slot, house_mesh};
use crate::kit::ground::{self, Ground, GroundPlan, Patch};
use crate::kit::{polygon, trees};
use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};
use rayon::prelude::*;
use satseed_scene::{Class, Instance, Mesh, Object, Scene, SeedPath, quantise_m};

/// What stands on an island.
#[derive(Clone, Debug)]
pub(super) struct IslePlan {
    pub(super) shore: Shore,
    pub(super) houses: Vec<House>,
    /// Open ground: outline in the world, what it is, its path.
    pub(super) opens: Vec<(Vec<DVec2>, Open, String)>,
    pub(super) church: Option<Church>,
    pub(super) key: u64,
}

/// Everything decided, nothing made.
pub(super) struct CityPlan {
    pub(super) lie: Lie,
    pub(super) isles: Vec<IslePlan>,
    /// Shores of all islands, planned or not.
    pub(super) shores: Vec<Shore>,
    pub(super) spans: Vec<Span>,
}

/// Half side of the ground, m.
const GROUND_HALF_M: f64 = 1700.0;
/// Longest edge of an outline in the plan, m: longer ones would not follow the bends.
const EDGE_M: f64 = 6.0;
/// Width of the stone along a quay, m.
const COPING_M: f64 = 0.42;
/// Individuals of each species of tree.
const INDIVIDUALS: u64 = 8;

fn shore_of(piece: &Piece, key: u64, lie: &Lie) -> Shore {
    let sides: Vec<Vec<DVec2>> = (0..piece.corners.len())
        .map(|i| {
            let [a, b] = piece.ends(i);
            let n = libm::ceil(a.distance(b) / EDGE_M).max(1.0) as usize;
            (0..=n).map(|k| lie.world(if k == n { b } else { a.lerp(b, k as f64 / n as f64) })).collect()
        })
        .collect();
    let outline: Vec<DVec2> = sides.iter().flat_map(|s| s[..s.len() - 1].iter().copied()).collect();
    let bounds = polygon::bounds(&outline);
    Shore { key, sides, outline, bounds }
}

pub(super) fn plan(params: &Params, city: &SeedPath) -> CityPlan {
    let lie = Lie::new(city);
    let Canals { isles, bridges } = canals::cut(params.variant, city);
    let shores: Vec<Shore> = isles.par_iter().map(|isle| shore_of(&isle.piece, isle.key, &lie)).collect();
    let reach_m = params.radius_m + RING_M;
    // The church of the campo nearest to the pivot has the high campanile.
    let chief = isles
        .iter()
        .filter(|i| i.campo)
        .min_by(|a, b| a.piece.centre().length().total_cmp(&b.piece.centre().length()))
        .map(|i| i.key);
    let plans: Vec<IslePlan> = isles
        .par_iter()
        .zip(&shores)
        .filter(|(_, shore)| {
            shore.outline.iter().any(|p| p.length() < reach_m) || polygon::contains(&shore.outline, DVec2::ZERO)
        })
        .map(|(isle, shore)| {
            let path = city.child("isle").index(isle.key);
            let fabric = fabric::fill(isle, params.density, &path);
            let houses = fabric.lots.iter().filter_map(|lot| houses::house(lot, &lie, city)).collect();
            let opens =
                fabric.opens.iter().filter_map(|(piece, open, name)| opened(piece, *open, name, &lie)).collect();
            let church = fabric
                .church
                .as_ref()
                .and_then(|g| church::plan(g, chief == Some(isle.key), &lie, &path.child("church")));
            IslePlan { shore: shore.clone(), houses, opens, church, key: isle.key }
        })
        .collect();
    let spans = bridges.iter().map(|b| Span::new(b, &lie, city)).collect();
    CityPlan { lie, isles: plans, shores, spans }
}

/// Open ground in the world, off the walls and quays around it.
fn opened(piece: &Piece, open: Open, name: &str, lie: &Lie) -> Option<(Vec<DVec2>, Open, String)> {
    let clear_m = if matches!(open, Open::Campo) { 1.1 } else { 0.8 };
    let inner = polygon::inset(&piece.corners, clear_m)?;
    if polygon::area(&inner) < 5.0 {
        return None;
    }
    let outline: Vec<DVec2> = polygon::subdivided(&inner, EDGE_M).into_iter().map(|p| lie.world(p)).collect();
    let quantised: Vec<DVec2> =
        outline.iter().map(|p| DVec2::new(quantise_m(p.x).into(), quantise_m(p.y).into())).collect();
    (polygon::area(&quantised) > 5.0).then(|| (quantised, open, name.to_owned()))
}

/// The ground of a plan: water, quays, paving.
pub(super) fn ground(params: &Params, plan: &CityPlan) -> Ground {
    let mut patches = Vec::new();
    let reach_m = params.radius_m + RING_M;
    let patch = |outline: Vec<DVec2>, slot: u16| {
        let axis = (outline[1] - outline[0]).normalize();
        Patch { origin_m: outline[0], axis, outline, slot, lowered: false }
    };
    for isle in &plan.isles {
        let inner = polygon::mitred(&isle.shore.outline, COPING_M);
        patches.push(patch(isle.shore.outline.clone(), ground_slot::COPING));
        patches.push(patch(inner, ground_slot::PAVING));
        for (k, (outline, open, _)) in isle.opens.iter().enumerate() {
            if polygon::centroid(outline).length() > reach_m {
                continue;
            }
            let slot = match open {
                Open::Campo if isle.key % 3 == 0 => ground_slot::CAMPO_LINED,
                Open::Campo | Open::Campiello => ground_slot::CAMPO,
                Open::Garden => ground_slot::GARDEN,
                Open::Court if k % 4 == 1 => ground_slot::BRICK,
                Open::Court => ground_slot::COURT,
            };
            patches.push(patch(outline.clone(), slot));
        }
    }
    let ground_plan = GroundPlan {
        patches,
        background_slot: ground_slot::WATER,
        background_lowered: true,
        kerb_slot: ground_slot::QUAY,
        kerb_m: -WATER_M,
        half_m: GROUND_HALF_M,
        fine_radius_m: params.radius_m + 100.0,
        fine_m: 20.0,
        coarse_m: 50.0,
    };
    let mut ground = ground::triangulate(&ground_plan, &|_| 0.0);
    // Water is level; the paving swells.
    for p in ground.mesh.positions_m.iter_mut().filter(|p| p[2] == 0.0) {
        p[2] = quantise_m(plan.lie.paving_m(DVec2::new(p[0].into(), p[1].into())));
    }
    ground
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

    /// One thing with its object and its own four numbers.
    fn add(&mut self, mesh: u32, world_from_object: DAffine3, (name, class): (String, Class), material_set: u32) {
        let mut rng = self.city.child(&name).child("variation").rng();
        let variation = core::array::from_fn(|_| rng.signed() as f32);
        self.scene.objects.push(Object { path: name, class });
        let object = self.scene.objects.len() as u32 - 1;
        self.scene.instances.push(Instance { mesh, world_from_object, object, material_set, variation });
    }
}

pub(super) fn assemble(params: &Params, plan: &CityPlan, city: &SeedPath) -> Scene {
    let materials = Materials::new(params.texture_contrast, &city.child("materials"));
    let mut a = Assembly { scene: Scene::default(), materials, city };
    let terrain = a.mesh(ground(params, plan).mesh);
    a.add(terrain, DAffine3::IDENTITY, ("ground".to_owned(), Class::Ground), 0);
    let full_m = params.radius_m + DETAIL_MARGIN_M;
    buildings(&mut a, full_m, plan);
    bridges_of(&mut a, params, plan);
    boats_of(&mut a, params, plan, full_m);
    open_ground(&mut a, params, plan, full_m);
    a.scene.materials = a.materials.list;
    a.scene.material_sets = a.materials.sets;
    a.scene.pivot_height_m = if plan.isles.iter().any(|i| polygon::contains(&i.shore.outline, DVec2::ZERO)) {
        plan.lie.paving_m(DVec2::ZERO)
    } else {
        WATER_M
    };
    a.scene.full_detail_radius_m = params.radius_m;
    a.scene
}

fn buildings(a: &mut Assembly<'_>, full_m: f64, plan: &CityPlan) {
    let all: Vec<&House> =
        plan.isles.iter().flat_map(|i| &i.houses).filter(|h| h.centre_m.length() < full_m + RING_M).collect();
    let meshes: Vec<Mesh> = all.par_iter().map(|h| house_mesh::mesh(h, h.centre_m.length() < full_m)).collect();
    for (house, mesh) in all.into_iter().zip(meshes) {
        let set = a.materials.house_set(&a.city.child(&house.name));
        let mesh = a.mesh(mesh);
        let at = DAffine3::from_translation(house.centre_m.extend(0.0));
        a.add(mesh, at, (house.name.clone(), Class::Roof), set);
    }
    for isle in &plan.isles {
        if let Some(church) = &isle.church {
            let name = format!("isle/{}/church", isle.key);
            let set = a.materials.church_set(&a.city.child(&name));
            let mesh = a.mesh(church::mesh(church));
            a.add(mesh, placed(church.centre_m.extend(0.0), church.axis, 1.0), (name, Class::Roof), set);
        }
    }
}

fn bridges_of(a: &mut Assembly<'_>, params: &Params, plan: &CityPlan) {
    let set = a.materials.bridge_set();
    for span in plan.spans.iter().filter(|s| s.centre_m.length() < params.radius_m + RING_M - 40.0) {
        let mesh = a.mesh(bridges::mesh(span));
        let ends =
            [-1.0, 1.0].map(|s| plan.lie.paving_m(span.centre_m + span.axis * (s * (span.length_m / 2.0 + 2.0))));
        let z = f64::from(quantise_m(ends[0].min(ends[1])));
        a.add(
            mesh,
            placed(span.centre_m.extend(z), span.axis, 1.0),
            (format!("bridge/{}", span.key), Class::Bridge),
            set,
        );
    }
}

fn boats_of(a: &mut Assembly<'_>, params: &Params, plan: &CityPlan, full_m: f64) {
    let meshes: Vec<u32> =
        Boat::ALL.iter().map(|b| b.mesh()).collect::<Vec<_>>().into_iter().map(|m| a.mesh(m)).collect();
    // Shores that boats near the detail can meet.
    let near: Vec<Shore> = plan
        .shores
        .iter()
        .filter(|s| {
            let nearest = DVec2::ZERO.clamp(s.bounds.0, s.bounds.1);
            nearest.length() < full_m + 160.0
        })
        .cloned()
        .collect();
    let waters = Waters { shores: &near, spans: &plan.spans };
    let along: Vec<(Vec<Moored>, Vec<Placed>)> =
        plan.isles.par_iter().map(|i| waters.moored(&i.shore, params.boats, a.city)).collect();
    let out = waters.under_way(full_m, params.boats, a.city);
    let mut piles = Vec::new();
    for (boats, more) in along.into_iter().chain([out]) {
        piles.extend(more);
        for moored in boats {
            if moored.at.length() > full_m {
                continue;
            }
            let mut rng = a.city.child(&moored.name).rng();
            let set = a.materials.boat_set(moored.boat, &mut rng);
            let index = Boat::ALL.iter().position(|b| *b == moored.boat).unwrap_or(0);
            let at = moored.at.extend(WATER_M - 0.04 * rng.unit());
            a.add(meshes[index], placed(at, moored.axis, rng.range(0.92, 1.06)), (moored.name, Class::Boat), set);
        }
    }
    stand(a, piles, full_m, &|_| WATER_M);
}

/// Things in their places.
fn stand(a: &mut Assembly<'_>, things: Vec<Placed>, full_m: f64, height_m: &dyn Fn(DVec2) -> f64) {
    let meshes: Vec<u32> =
        Thing::ALL.iter().map(|t| t.mesh()).collect::<Vec<_>>().into_iter().map(|m| a.mesh(m)).collect();
    for placed_thing in things {
        if placed_thing.at.length() > full_m {
            continue;
        }
        let index = Thing::ALL.iter().position(|t| *t == placed_thing.thing).unwrap_or(0);
        let set = match placed_thing.thing {
            Thing::Well | Thing::Bench => a.materials.stone_set(),
            _ => a.materials.cloth_set(placed_thing.cloth),
        };
        let at = placed_thing.at.extend(height_m(placed_thing.at));
        a.add(meshes[index], placed(at, placed_thing.axis, 1.0), (placed_thing.name, Class::OtherStructure), set);
    }
}

fn open_ground(a: &mut Assembly<'_>, params: &Params, plan: &CityPlan, full_m: f64) {
    let mut grown = Vec::new();
    for (k, species) in trees::SPECIES.iter().enumerate() {
        let path = a.city.child("tree kind").index(k as u64);
        let meshes: Vec<Mesh> =
            (0..INDIVIDUALS).into_par_iter().map(|n| trees::tree(species, &path.index(n))).collect();
        let indices: Vec<u32> = meshes.into_iter().map(|m| a.mesh(m)).collect();
        grown.push(indices);
    }
    let sets: Vec<u32> = (0..trees::SPECIES.len()).map(|k| a.materials.tree_set(k)).collect();
    let mut standing = Vec::new();
    for isle in &plan.isles {
        let church =
            isle.church.as_ref().map(|c| polygon::oriented_rectangle(c.centre_m, c.axis, c.half_m + DVec2::splat(2.0)));
        let free = |p: DVec2| church.as_ref().is_none_or(|c| !polygon::contains(c, p));
        for (outline, open, name) in &isle.opens {
            let (low, high) = polygon::bounds(outline);
            if DVec2::ZERO.clamp(low, high).length() > full_m {
                continue;
            }
            let (things, planted) = things::furnish(outline, *open, params.trees, name, a.city);
            standing.extend(things.into_iter().filter(|t| free(t.at)));
            for (at, size, name) in planted.into_iter().filter(|(p, _, _)| free(*p) && p.length() <= full_m) {
                let mut rng = a.city.child(&name).child("tree").rng();
                let species = rng.weighted(&[0.4, 0.2, 0.3, 0.1]);
                let mesh = grown[species][rng.below(INDIVIDUALS) as usize];
                let scale = size * rng.range(0.75, 1.25);
                let yaw = DQuat::from_rotation_z(rng.range(0.0, core::f64::consts::TAU));
                let stretch = DVec3::new(scale, scale, scale * rng.range(0.85, 1.2));
                let at = at.extend(plan.lie.paving_m(at));
                let transform = DAffine3::from_scale_rotation_translation(stretch, yaw, at);
                a.add(mesh, transform, (name, Class::Tree), sets[species]);
            }
        }
    }
    stand(a, standing, full_m, &|p| plan.lie.paving_m(p));
}
