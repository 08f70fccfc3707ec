//! The tracer: two levels of trees and the queries over them.

use crate::bvh8::Bvh8;
use crate::slab::SlabRay;
use crate::surface::{Hit, Origin, tie_tolerance_m};
use crate::triangle::{Crossing, ShearedRay};
use glam::{DAffine3, DVec3};
use rayon::prelude::*;
use satseed_scene::{Mesh, Ray, Scene};

/// A scene ready for rays.
pub struct Tracer<'s> {
    scene: &'s Scene,
    meshes: Vec<MeshTree>,
    placements: Vec<Placement>,
    instances: Bvh8,
}

struct MeshTree {
    tree: Bvh8,
    /// In leaf order, so that a leaf's triangles lie side by side.
    triangles: Vec<LeafTriangle>,
}

struct LeafTriangle {
    corners: [[f32; 3]; 3],
    index: u32,
}

struct Placement {
    mesh: u32,
    /// The instance's frame is the world's: nothing to transform.
    identity: bool,
    world_from_object: DAffine3,
    object_from_world: DAffine3,
}

/// A query over crossings: what it still wants, and what it makes of one.
trait Query {
    /// Crossings beyond this distance are of no interest.
    fn limit(&self) -> f64;
    /// Takes a crossing with `t` in (0, limit]; true ends the search.
    fn offer(&mut self, instance: u32, triangle: u32, corners: &[DVec3; 3], crossing: &Crossing) -> bool;
}

impl<'s> Tracer<'s> {
    /// Builds the trees. The scene must pass [`Scene::validate`].
    pub fn new(scene: &'s Scene) -> Self {
        let meshes: Vec<MeshTree> = scene.meshes.par_iter().map(mesh_tree).collect();
        let placements: Vec<Placement> = scene
            .instances
            .iter()
            .map(|i| Placement {
                mesh: i.mesh,
                identity: i.world_from_object == DAffine3::IDENTITY,
                world_from_object: i.world_from_object,
                object_from_world: i.world_from_object.inverse(),
            })
            .collect();
        let boxes: Vec<_> = placements.iter().map(|p| world_box(p, &meshes[p.mesh as usize])).collect();
        Self { scene, meshes, placements, instances: Bvh8::build(&boxes) }
    }

    /// The scene it was built for.
    pub fn scene(&self) -> &'s Scene {
        self.scene
    }

    /// Lower and upper corner of everything, m.
    pub fn bounds_m(&self) -> [DVec3; 2] {
        [self.instances.bounds.low, self.instances.bounds.high]
    }

    /// A length that takes a ray from a point beyond the far side of everything, m.
    pub fn reach_m(&self, from: DVec3) -> f64 {
        let [low, high] = self.bounds_m();
        let far = (low - from).abs().max((high - from).abs());
        far.length() + 1.0
    }

    /// Bytes held by the trees and their copies of the triangles.
    pub fn bytes(&self) -> usize {
        let meshes: usize =
            self.meshes.iter().map(|m| m.tree.bytes() + m.triangles.len() * size_of::<LeafTriangle>()).sum();
        meshes + self.instances.bytes() + self.placements.len() * size_of::<Placement>()
    }

    /// The closest hit at a distance in (0, `t_max`]. Hits within [`tie_tolerance_m`] of the closest are one place; the
    /// lowest (instance, triangle) of them answers.
    pub fn closest(&self, ray: &Ray, t_max: f64) -> Option<Hit> {
        let mut query = Closest { t_max, nearest: t_max, found: None, ties: Vec::new(), own: None, ray: *ray };
        self.search(ray, t_max, &mut query);
        query.answer(ray)
    }

    /// What a straight line from a surface point to `target` meets first, if anything.
    pub fn occluder(&self, from: &Origin, target: DVec3) -> Option<Hit> {
        let (ray, t_max) = segment(from, target);
        let mut query = Closest { t_max, nearest: t_max, found: None, ties: Vec::new(), own: Some(*from), ray };
        self.search(&ray, t_max, &mut query);
        query.answer(&ray)
    }

    /// Whether anything stands between a surface point and `target`.
    pub fn occluded(&self, from: &Origin, target: DVec3) -> bool {
        let (ray, t_max) = segment(from, target);
        self.any(from, &ray, t_max)
    }

    /// Whether anything stands in a direction (unit) from a surface point within `t_max` metres.
    pub fn blocked(&self, from: &Origin, direction: DVec3, t_max: f64) -> bool {
        self.any(from, &Ray { origin: from.point(), direction }, t_max)
    }

    /// The closest hit in a direction (unit) from a surface point.
    pub fn closest_from(&self, from: &Origin, direction: DVec3, t_max: f64) -> Option<Hit> {
        let ray = Ray { origin: from.point(), direction };
        let mut query = Closest { t_max, nearest: t_max, found: None, ties: Vec::new(), own: Some(*from), ray };
        self.search(&ray, t_max, &mut query);
        query.answer(&ray)
    }

    fn any(&self, from: &Origin, ray: &Ray, t_max: f64) -> bool {
        let mut query = Any { t_max, own: *from, ray: *ray, found: false };
        self.search(ray, t_max, &mut query);
        query.found
    }

    fn search(&self, ray: &Ray, t_max: f64, query: &mut impl Query) {
        let sheared = ShearedRay::new(ray);
        let top = &self.instances;
        // One stack for both levels: the inner walk works above what the outer one left.
        let mut stack = Vec::with_capacity(128);
        walk(top, ray.origin, ray.direction, t_max, query, &mut stack, &mut |place, query, stack| {
            let instance = top.order[place];
            let placement = &self.placements[instance as usize];
            let mesh = &self.meshes[placement.mesh as usize];
            let (origin, direction) = if placement.identity {
                (ray.origin, ray.direction)
            } else {
                let m = &placement.object_from_world;
                (m.transform_point3(ray.origin), m.transform_vector3(ray.direction))
            };
            walk(&mesh.tree, origin, direction, t_max, query, stack, &mut |place, query, _| {
                let triangle = &mesh.triangles[place];
                let corners = triangle.corners.map(|c| {
                    let p = DVec3::new(f64::from(c[0]), f64::from(c[1]), f64::from(c[2]));
                    if placement.identity { p } else { placement.world_from_object.transform_point3(p) }
                });
                match sheared.cross(&corners) {
                    Some(crossing) if crossing.t > 0.0 && crossing.t <= query.limit() => {
                        query.offer(instance, triangle.index, &corners, &crossing)
                    }
                    _ => false,
                }
            })
        });
    }
}

/// Visits the leaves of a tree that the ray meets, nearer ones first, until `leaf` says true; gives whether it did.
fn walk<Q: Query>(
    tree: &Bvh8,
    origin: DVec3,
    direction: DVec3,
    t_max: f64,
    query: &mut Q,
    stack: &mut Vec<(u32, f32)>,
    leaf: &mut impl FnMut(usize, &mut Q, &mut Vec<(u32, f32)>) -> bool,
) -> bool {
    let slack = tree.bounds.slack();
    let limit = t_max.min(query.limit());
    if tree.nodes.is_empty() {
        return false;
    }
    let Some((near, _)) = tree.bounds.clip(origin, direction, 0.0, limit, slack) else { return false };
    let ray = SlabRay::new(origin, direction, near, slack);
    let bottom = stack.len();
    stack.push((0, 0.0));
    while stack.len() > bottom {
        let Some((index, entry)) = stack.pop() else { break };
        let limit = ray.limit(query.limit());
        if entry > limit {
            continue;
        }
        let node = &tree.nodes[index as usize];
        let (nears, met) = ray.meet(&node.boxes, limit);
        let mut order = [(0.0_f32, 0_u8); 8];
        let mut count = 0;
        let mut bits = met;
        while bits != 0 {
            let lane = bits.trailing_zeros() as u8;
            bits &= bits - 1;
            let key = nears[lane as usize];
            let mut k = count;
            while k > 0 && order[k - 1].0 > key {
                order[k] = order[k - 1];
                k -= 1;
            }
            order[k] = (key, lane);
            count += 1;
        }
        // Leaves at once, nearest first; nodes to the stack, farthest first.
        for &(key, lane) in &order[..count] {
            let child = node.children[lane as usize];
            if child.count > 0 && key <= ray.limit(query.limit()) {
                for place in child.first..child.first + child.count {
                    if leaf(place as usize, query, stack) {
                        stack.truncate(bottom);
                        return true;
                    }
                }
            }
        }
        for &(key, lane) in order[..count].iter().rev() {
            let child = node.children[lane as usize];
            if child.count == 0 {
                stack.push((child.first, key));
            }
        }
    }
    false
}

fn segment(from: &Origin, target: DVec3) -> (Ray, f64) {
    let way = target - from.point();
    let length = way.length();
    (Ray { origin: from.point(), direction: way / length }, length)
}

struct Found {
    t: f64,
    instance: u32,
    triangle: u32,
    weights: [f64; 3],
    corners: [DVec3; 3],
}

struct Closest {
    t_max: f64,
    nearest: f64,
    found: Option<Found>,
    /// Other hits that are, or once were, within the tolerance of the nearest.
    ties: Vec<Found>,
    own: Option<Origin>,
    ray: Ray,
}

impl Query for Closest {
    #[inline]
    fn limit(&self) -> f64 {
        (self.nearest + tie_tolerance_m(self.nearest)).min(self.t_max)
    }

    fn offer(&mut self, instance: u32, triangle: u32, corners: &[DVec3; 3], crossing: &Crossing) -> bool {
        let t = crossing.t;
        if let Some(own) = &self.own
            && own.is_own_surface(instance, triangle, corners, t, self.ray.origin + self.ray.direction * t)
        {
            return false;
        }
        let new = Found { t, instance, triangle, weights: crossing.weights, corners: *corners };
        if let Some(old) = self.found.take() {
            let (nearer, farther) = if (new.t, new.instance, new.triangle) < (old.t, old.instance, old.triangle) {
                (new, old)
            } else {
                (old, new)
            };
            if farther.t <= nearer.t + tie_tolerance_m(nearer.t) {
                self.ties.push(farther);
            }
            self.nearest = nearer.t;
            self.found = Some(nearer);
        } else {
            self.nearest = t;
            self.found = Some(new);
        }
        false
    }
}

impl Closest {
    fn answer(self, ray: &Ray) -> Option<Hit> {
        let nearest = self.found?;
        let last = nearest.t + tie_tolerance_m(nearest.t);
        let winner = self
            .ties
            .into_iter()
            .filter(|tie| tie.t <= last)
            .fold(nearest, |a, b| if (b.instance, b.triangle) < (a.instance, a.triangle) { b } else { a });
        let [a, b, c] = winner.corners;
        let normal = (b - a).cross(c - a).normalize();
        let w = winner.weights;
        Some(Hit {
            t: winner.t,
            instance: winner.instance,
            triangle: winner.triangle,
            weights: w,
            point: a * w[0] + b * w[1] + c * w[2],
            normal: if normal.dot(ray.direction) > 0.0 { -normal } else { normal },
            corners: winner.corners,
        })
    }
}

struct Any {
    t_max: f64,
    own: Origin,
    ray: Ray,
    found: bool,
}

impl Query for Any {
    #[inline]
    fn limit(&self) -> f64 {
        self.t_max
    }

    fn offer(&mut self, instance: u32, triangle: u32, corners: &[DVec3; 3], crossing: &Crossing) -> bool {
        let t = crossing.t;
        self.found = !self.own.is_own_surface(instance, triangle, corners, t, self.ray.origin + self.ray.direction * t);
        self.found
    }
}

fn mesh_tree(mesh: &Mesh) -> MeshTree {
    let corners = |t: &[u32; 3]| t.map(|v| mesh.positions_m[v as usize]);
    let boxes: Vec<_> = mesh
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = corners(t);
            let low = core::array::from_fn(|i| a[i].min(b[i]).min(c[i]));
            let high = core::array::from_fn(|i| a[i].max(b[i]).max(c[i]));
            (low, high)
        })
        .collect();
    let tree = Bvh8::build(&boxes);
    let triangles =
        tree.order.iter().map(|i| LeafTriangle { corners: corners(&mesh.triangles[*i as usize]), index: *i }).collect();
    MeshTree { tree, triangles }
}

/// A box in f32 that holds the placed mesh.
fn world_box(placement: &Placement, mesh: &MeshTree) -> ([f32; 3], [f32; 3]) {
    let b = mesh.tree.bounds;
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for k in 0..8 {
        let pick = |bit: u32, axis: usize| if k >> bit & 1 == 0 { b.low[axis] } else { b.high[axis] };
        let p = placement.world_from_object.transform_point3(DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2)));
        low = low.min(p);
        high = high.max(p);
    }
    let down = |x: f64| (x as f32).next_down();
    let up = |x: f64| (x as f32).next_up();
    (low.to_array().map(down), high.to_array().map(up))
}
