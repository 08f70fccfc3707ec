//! The ground of a city: one conforming triangulation of everything that lies flat.
//!
//! The plan is a list of patches, the later on top of the earlier. Their outlines become constraints of one Delaunay
//! triangulation, each triangle takes the topmost patch that holds its centre, and where raised ground (a block) meets
//! lowered ground (a carriageway) the edge gets a kerb. Outlines nest or stand apart by centimetres, so that no two
//! cross after quantising; every border is then crisp and every edge has exactly two triangles. Where two blocks touch in a
//! corner, the kerbs of one of them have a point more on their common upright, so that this holds there too.

use super::{arrange, polygon};
use glam::DVec2;
use satseed_scene::{Mesh, quantise_m};
use spade::handles::{DirectedEdgeHandle, FixedVertexHandle};
use spade::{CdtEdge, ConstrainedDelaunayTriangulation, Point2, Triangulation};
use std::collections::BTreeMap;

/// A flat piece of ground.
#[derive(Clone, Debug)]
pub struct Patch {
    /// Outline in the world's plane, counter-clockwise.
    pub outline: Vec<DVec2>,
    /// Material slot.
    pub slot: u16,
    /// Where its texture coordinates are (0, 0), world.
    pub origin_m: DVec2,
    /// Direction of its first texture coordinate, unit.
    pub axis: DVec2,
    /// Lowered by the kerb's height.
    pub lowered: bool,
}

/// A whole ground.
#[derive(Clone, Debug)]
pub struct GroundPlan {
    /// Pieces, the later on top.
    pub patches: Vec<Patch>,
    /// What lies where no patch does.
    pub background_slot: u16,
    /// Whether that is lowered by the kerb's height.
    pub background_lowered: bool,
    /// Slot of kerb faces.
    pub kerb_slot: u16,
    /// Height of a kerb, m.
    pub kerb_m: f64,
    /// Half side of the whole square, m.
    pub half_m: f64,
    /// Within this distance the relief is followed at `fine_m`, beyond at `coarse_m`.
    pub fine_radius_m: f64,
    /// Spacing of relief posts near the pivot, m.
    pub fine_m: f64,
    /// Spacing of relief posts far off, m.
    pub coarse_m: f64,
}

/// A ground and what went wrong with it.
#[derive(Clone, Debug)]
pub struct Ground {
    /// Triangles in the world's frame.
    pub mesh: Mesh,
    /// Outline edges that crossed another and had to be left out; 0 for a sound plan.
    pub crossings: usize,
}

type Cdt = ConstrainedDelaunayTriangulation<Point2<f64>>;

/// Side of a look-up cell for patches, m.
const CELL_M: f64 = 40.0;

struct Lookup<'a> {
    patches: &'a [Patch],
    half_m: f64,
    across: usize,
    cells: Vec<Vec<u32>>,
}

impl<'a> Lookup<'a> {
    fn new(patches: &'a [Patch], half_m: f64) -> Self {
        let across = libm::ceil(2.0 * half_m / CELL_M) as usize + 1;
        let mut this = Self { patches, half_m, across, cells: vec![Vec::new(); across * across] };
        for (index, patch) in patches.iter().enumerate() {
            let (low, high) = polygon::bounds(&patch.outline);
            let (i0, j0) = this.cell(low);
            let (i1, j1) = this.cell(high);
            for j in j0..=j1 {
                for i in i0..=i1 {
                    this.cells[j * across + i].push(index as u32);
                }
            }
        }
        this
    }

    fn cell(&self, p: DVec2) -> (usize, usize) {
        let index = |x: f64| (((x + self.half_m) / CELL_M).max(0.0) as usize).min(self.across - 1);
        (index(p.x), index(p.y))
    }

    /// The topmost patch that holds a point.
    fn top(&self, p: DVec2) -> Option<u32> {
        let (i, j) = self.cell(p);
        let candidates = &self.cells[j * self.across + i];
        candidates.iter().rev().copied().find(|k| polygon::contains(&self.patches[*k as usize].outline, p))
    }
}

fn quantised(p: DVec2) -> Point2<f64> {
    Point2::new(f64::from(quantise_m(p.x)), f64::from(quantise_m(p.y)))
}

/// Longest edge of an outline that was arranged, by the spacing of the ground's own posts: these stand further apart, so that
/// no edge is divided again. A divided edge would leave the lattice on which the outlines were made to meet.
const LONGEST: f64 = 0.9;

/// Patches whose outlines cross as they like, made to meet in corners only; for a ground whose `fine_m` is `post_m`.
pub fn arranged(patches: Vec<Patch>, post_m: f64) -> Vec<Patch> {
    let outlines: Vec<Vec<DVec2>> = patches.iter().map(|p| polygon::subdivided(&p.outline, LONGEST * post_m)).collect();
    patches
        .into_iter()
        .zip(arrange::arranged(&outlines))
        .filter(|(_, outline)| outline.len() > 2)
        .map(|(patch, outline)| Patch { outline, ..patch })
        .collect()
}

/// Triangulates a plan over a relief. `height_m` is the height of raised ground at a place in the world.
pub fn triangulate(plan: &GroundPlan, height_m: &dyn Fn(DVec2) -> f64) -> Ground {
    let mut cdt = Cdt::new();
    let mut crossings = 0;
    let border = polygon::rectangle(DVec2::splat(-plan.half_m), DVec2::splat(plan.half_m));
    insert_loop(&mut cdt, &polygon::subdivided(&border, 4.0 * plan.coarse_m), &mut crossings);
    for patch in &plan.patches {
        insert_loop(&mut cdt, &polygon::subdivided(&patch.outline, plan.fine_m), &mut crossings);
    }
    insert_posts(&mut cdt, plan);
    let mesh = faces(&cdt, plan, height_m);
    Ground { mesh, crossings }
}

fn insert_loop(cdt: &mut Cdt, outline: &[DVec2], crossings: &mut usize) {
    let mut handles: Vec<FixedVertexHandle> = outline.iter().filter_map(|p| cdt.insert(quantised(*p)).ok()).collect();
    handles.dedup();
    for i in 0..handles.len() {
        let (a, b) = (handles[i], handles[(i + 1) % handles.len()]);
        if a != b {
            if cdt.can_add_constraint(a, b) {
                cdt.add_constraint(a, b);
            } else {
                *crossings += 1;
            }
        }
    }
}

/// Posts on a grid so that large triangles follow the relief. None comes near an outline: thin triangles help nobody.
fn insert_posts(cdt: &mut Cdt, plan: &GroundPlan) {
    let clear = 0.15 * plan.fine_m;
    for (step, inside) in [(plan.fine_m, true), (plan.coarse_m, false)] {
        let n = libm::floor(plan.half_m / step) as i64 - 1;
        for j in -n..=n {
            for i in -n..=n {
                let p = DVec2::new(i as f64, j as f64) * step;
                if (p.length() < plan.fine_radius_m) != inside {
                    continue;
                }
                let q = quantised(p);
                let near = match cdt.locate(q) {
                    spade::PositionInTriangulation::OnFace(face) => {
                        let corners = cdt.face(face).positions().map(|c| DVec2::new(c.x, c.y));
                        (0..3).any(|k| polygon::segment_distance(corners[k], corners[(k + 1) % 3], p) < clear)
                    }
                    _ => true,
                };
                if !near {
                    cdt.insert(q).expect("a finite point within the square");
                }
            }
        }
    }
}

fn faces(cdt: &Cdt, plan: &GroundPlan, height_m: &dyn Fn(DVec2) -> f64) -> Mesh {
    let lookup = Lookup::new(&plan.patches, plan.half_m);
    let mut mesh = Mesh::default();
    let mut seen: BTreeMap<(usize, u32, bool), u32> = BTreeMap::new();
    // Patch of each inner face by its handle's index; u32::MAX is the background.
    let mut patch_of = vec![u32::MAX; cdt.num_all_faces()];
    for face in cdt.inner_faces() {
        let [a, b, c] = face.positions();
        let centre = DVec2::new((a.x + b.x + c.x) / 3.0, (a.y + b.y + c.y) / 3.0);
        patch_of[face.fix().index()] = lookup.top(centre).unwrap_or(u32::MAX);
    }
    let patch = |k: u32| plan.patches.get(k as usize);
    let lowered = |k: u32| patch(k).map_or(plan.background_lowered, |p| p.lowered);
    let mut vertex = |mesh: &mut Mesh, index: usize, p: Point2<f64>, k: u32, low: bool| -> u32 {
        *seen.entry((index, k, low)).or_insert_with(|| {
            let at = DVec2::new(p.x, p.y);
            let z = height_m(at) - if low { plan.kerb_m } else { 0.0 };
            let uv = patch(k).map_or(at, |q| {
                let d = at - q.origin_m;
                DVec2::new(d.dot(q.axis), q.axis.perp_dot(d))
            });
            mesh.positions_m.push([p.x as f32, p.y as f32, quantise_m(z)]);
            mesh.uvs_m.push([uv.x as f32, uv.y as f32]);
            mesh.positions_m.len() as u32 - 1
        })
    };
    for face in cdt.inner_faces() {
        let k = patch_of[face.fix().index()];
        let low = lowered(k);
        let corners = face.vertices().map(|v| vertex(&mut mesh, v.fix().index(), v.position(), k, low));
        mesh.triangles.push(corners);
        mesh.slots.push(patch(k).map_or(plan.background_slot, |p| p.slot));
    }
    for edge in cdt.directed_edges() {
        // The lowered face is on this edge's left and the raised one on its right: the kerb looks to the left.
        let (Some(left), Some(right)) = (edge.face().as_inner(), edge.rev().face().as_inner()) else { continue };
        let (l, r) = (patch_of[left.fix().index()], patch_of[right.fix().index()]);
        if !lowered(l) || lowered(r) {
            continue;
        }
        // Kerb faces have corners of their own: their texture runs along the kerb.
        let mut corner = |p: Point2<f64>, below: f64| {
            let at = DVec2::new(p.x, p.y);
            mesh.positions_m.push([p.x as f32, p.y as f32, quantise_m(height_m(at) - plan.kerb_m * below)]);
            mesh.uvs_m.push([p.x as f32, p.y as f32]);
            mesh.positions_m.len() as u32 - 1
        };
        let (from, to) = (edge.from().position(), edge.to().position());
        let (a0, b0, a1, b1) = (corner(from, 1.0), corner(to, 1.0), corner(from, 0.0), corner(to, 0.0));
        let between = |touching: u32| f64::from(touching) / f64::from(touching + 1);
        let raised = |face: Edge<'_>| face.face().as_inner().is_some_and(|f| !lowered(patch_of[f.fix().index()]));
        let [a, b] = [touching_before(edge, &raised), touching_before(edge.rev(), &raised)]
            .map(|touching| (touching > 0).then(|| between(touching)));
        let (a, b) = (a.map(|below| corner(from, below)), b.map(|below| corner(to, below)));
        // Seen from the left of from -> to, "to" lies on the right hand's far side: order (to, from) is counter-clockwise.
        mesh.triangles.extend(match (a, b) {
            (None, None) => vec![[b0, a0, a1], [b0, a1, b1]],
            (Some(a), None) => vec![[b0, a0, a], [b0, a, a1], [b0, a1, b1]],
            (None, Some(b)) => vec![[a0, a1, b1], [a0, b1, b], [a0, b, b0]],
            (Some(a), Some(b)) => vec![[b0, a0, a], [b0, a, b], [b, a, a1], [b, a1, b1]],
        });
        mesh.slots.resize(mesh.triangles.len(), plan.kerb_slot);
    }
    mesh
}

type Edge<'a> = DirectedEdgeHandle<'a, Point2<f64>, (), CdtEdge<()>, ()>;

/// Of the blocks that touch in an edge's begin, how many come before the one whose border the edge is. Around the begin, a
/// block is a run of raised faces; they are counted by where their first edge leads.
fn touching_before(edge: Edge<'_>, raised: &dyn Fn(Edge<'_>) -> bool) -> u32 {
    let around: Vec<Edge<'_>> = edge.from().out_edges().collect();
    let n = around.len();
    let starts: Vec<usize> = (0..n).filter(|k| raised(around[*k]) && !raised(around[(k + n - 1) % n])).collect();
    if starts.len() < 2 {
        return 0;
    }
    // The block's run holds the face on one side of the edge: go back to where it starts.
    let mut at = around.iter().position(|e| *e == edge).unwrap_or(0);
    if !raised(around[at]) {
        at = (at + n - 1) % n;
    }
    while !starts.contains(&at) {
        at = (at + n - 1) % n;
    }
    let leads = |k: usize| around[k].to().position();
    let before = |k: usize| {
        let (p, q) = (leads(k), leads(at));
        p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)).is_lt()
    };
    starts.iter().filter(|k| before(**k)).count() as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::checks::assert_whole;

    /// Squares touch in corners, raised in lowered ground, lowered in raised, and both: two triangles at every edge.
    #[test]
    fn blocks_that_touch_in_a_corner_leave_no_edge_with_four_triangles() {
        let square = |x: f64, y: f64, lowered: bool| Patch {
            outline: polygon::rectangle(DVec2::new(x, y), DVec2::new(x + 16.0, y + 16.0)),
            slot: 1,
            origin_m: DVec2::ZERO,
            axis: DVec2::X,
            lowered,
        };
        for (background_lowered, low) in [(true, [false; 4]), (true, [false, true, true, false]), (false, [true; 4])] {
            let places = [(-16.0, -16.0), (0.0, 0.0), (16.0, 16.0), (16.0, -16.0)];
            let plan = GroundPlan {
                patches: places.iter().zip(low).map(|((x, y), lowered)| square(*x, *y, lowered)).collect(),
                background_slot: 0,
                background_lowered,
                kerb_slot: 2,
                kerb_m: 0.15,
                half_m: 64.0,
                fine_radius_m: 60.0,
                fine_m: 20.0,
                coarse_m: 50.0,
            };
            assert_whole(&triangulate(&plan, &|p| 0.01 * p.x), 64.0);
        }
    }
}
