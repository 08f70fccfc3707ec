//! Many rays that go nearly the same way, taken through the scene together.
//!
//! Rays are kept as lines over depth along the axis that they share most of: `x(w) = x + slope_x w`. Between two planes
//! of depth the rays of a bundle stay between the straight lines through their outermost points, its shaft; one test of
//! the shaft stands for all rays. Sixteen rays make a packet with a shaft of its own; sixteen packets a bundle. What the
//! shafts leave is sieved ray by ray in f32 with a bound, and what that leaves is decided in f64, in the same words as
//! for single rays. So the answers are those of single rays, bit for bit.

mod frame;
mod meet;
mod order;
mod outline;
mod shaft;

use crate::query::Query;
use crate::simd::{Lanes, dispatch};
use crate::single;
use crate::tree::Trees;
use crate::triangle::ShearedPacket;
use frame::{Frame, Rays};
pub(crate) use order::narrower;
use outline::{Entry, View};

const LANES: usize = 16;
/// Rays of a bundle at most.
pub(crate) const MOST: usize = LANES * LANES;
/// About the size of what stands behind a leaf, m. Rays that lie farther apart than some of them meet more triangles
/// together than alone.
const GRAIN_M: f32 = 1.5;
/// Grains that a packet may be wide, and packets and grains that a bundle may be.
const WIDEST_PACKET: f32 = 2.5;
const WIDEST_BUNDLE: f32 = 8.0;
/// Rays whose slope against the shared axis is larger go alone.
const STEEPEST: f64 = 1.6;

/// Side of a square of neighbouring rays that fill a bundle.
pub const TILE_SIDE: u32 = 16;

/// The cells (column, row) of a tile in the order in which their rays make the narrowest packets and bundles, however many
/// rays a cell has: Morton's, in which every run of 4, 16 or 64 is a square.
pub fn tile_order(width: u32, height: u32) -> impl Iterator<Item = (u32, u32)> {
    let side = width.max(height).next_power_of_two();
    let every_other = |n: u32| (0..16).fold(0, |sum, bit| sum | (n >> (2 * bit) & 1) << bit);
    (0..side * side).map(move |n| (every_other(n), every_other(n >> 1))).filter(move |(x, y)| *x < width && *y < height)
}

dispatch! {
    /// Takes up to [`MOST`] rays through the scene.
    fn trace<Q: Query>(trees: &Trees, queries: &mut [Q]) = whole
}

#[inline(always)]
fn whole<L: Lanes, Q: Query>(lanes: L, trees: &Trees, queries: &mut [Q]) {
    let mut stacks = Stacks { outer: Vec::with_capacity(64), inner: Vec::with_capacity(64), alone: Vec::new() };
    let mut rays = Vec::with_capacity(LANES);
    let mut parts = vec![queries];
    while let Some(queries) = parts.pop() {
        rays.clear();
        for members in queries.chunks(LANES) {
            rays.push(Rays::new(members));
        }
        match Frame::new(lanes, trees, &rays) {
            Ok(frame) => together(lanes, trees, frame, &rays, queries, &mut stacks),
            Err(Split::Packets) => parts.extend(queries.chunks_mut(LANES)),
            Err(Split::Rays) => {
                for query in queries {
                    single::trace(L::SET, trees, query, &mut stacks.alone);
                }
            }
        }
    }
}

/// Takes rays that share a way through the scene.
#[inline(always)]
fn together<L: Lanes, Q: Query>(
    lanes: L,
    trees: &Trees,
    mut world: Frame,
    rays: &[Rays],
    queries: &mut [Q],
    stacks: &mut Stacks,
) {
    let mut sheared = Vec::with_capacity(LANES);
    for r in rays {
        sheared.push(ShearedPacket::new::<L::D16>(&r.origin, &r.direction));
    }
    let nodes = &trees.instances.nodes;
    stacks.outer.push(Entry::ROOT);
    while let Some((entry, packets)) = world.outline.next(lanes, nodes, &trees.placements, &mut stacks.outer) {
        for place in entry.child.first..entry.child.first + entry.child.count {
            let placement = &trees.placements[place as usize];
            let mesh = &trees.meshes[placement.mesh as usize];
            let rows = trees.rows(place);
            let mut view = None;
            if rows.is_some() {
                let object_from_world = &placement.object_from_world;
                view = Some(View::new(lanes, &world, nodes, &entry, packets, object_from_world, &mesh.tree));
            }
            stacks.inner.push(Entry::ROOT);
            loop {
                let outline = if let Some(view) = &view { &view.outline } else { &world.outline };
                let Some((Entry { child, .. }, packets)) =
                    outline.next(lanes, &mesh.tree.nodes, &mesh.blocks, &mut stacks.inner)
                else {
                    break;
                };
                let leaf = mesh.leaf(child.first);
                let touched = world.meet(lanes, trees, place, &leaf, rows.as_ref(), child, packets, &sheared, queries);
                if let (true, Some(view)) = (touched, &mut view) {
                    view.refresh::<L>(&world.outline.shafts);
                }
            }
        }
    }
}

/// What waits, of both levels of bundles and of rays that go alone.
struct Stacks {
    outer: Vec<Entry>,
    inner: Vec<Entry>,
    alone: Vec<single::Entry>,
}

/// Why rays cannot go as one bundle; it decides over time, never over answers.
enum Split {
    /// Their packets can.
    Packets,
    /// They go their own ways.
    Rays,
}
