//! Where vertical lines cross a scene.
//!
//! Millions of parallel lines through a grid's cells need no rays: every triangle is laid onto the grid once, and each
//! cell that it covers learns at what height. Edges are decided by the same arithmetic for the two triangles that share
//! them, so that a line meets a closed surface as often from inside as from outside.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use satseed_scene::Scene;

/// Rows of cells that are worked on at a time.
pub(super) const BAND_ROWS: usize = 16;

/// Crossings of a line, in a band of a city's core.
const USUAL_CROSSINGS: usize = 16;

/// An instance that reaches over more bands than this has its triangles sorted by band.
const FEW_BANDS: usize = 4;

/// Cells over the plane, seen by their centres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    /// Centre of the first cell, m.
    pub first: DVec2,
    /// Distance of centres, m.
    pub cell_m: f64,
    /// Cells in a row, and rows.
    pub side: usize,
}

impl Grid {
    fn centre(&self, column: usize, row: usize) -> DVec2 {
        self.first + DVec2::new(column as f64, row as f64) * self.cell_m
    }

    /// A place, and the cells around it within some rows.
    #[inline(always)]
    fn corner(&self, at: DVec3, rows: &core::ops::Range<usize>) -> Corner {
        // Far above the rounding of coordinates, far below anything that costs time.
        const SLACK: f64 = 1e-6;
        let cell = (at.truncate() - self.first) / self.cell_m;
        let around = |x: f64, cells: &core::ops::Range<usize>| {
            // Never below zero, so that what is cut off its fraction is rounded down: rounding is a call on many processors.
            let low = (x - SLACK).max(cells.start as f64);
            let first = low as i32 + i32::from(f64::from(low as i32) < low);
            let last = ((x + SLACK).clamp(-1.0, cells.end as f64 - 1.0) + 1.0) as i32 - 1;
            [-first, last]
        };
        let ([a, b], [c, d]) = (around(cell.x, &(0..self.side)), around(cell.y, rows));
        Corner { at, around: [a, b, c, d] }
    }

    /// A place, and the cells around it.
    fn corner_anywhere(&self, at: DVec3) -> Corner {
        self.corner(at, &(0..self.side))
    }
}

/// A triangle's corner.
#[derive(Clone, Copy, Debug)]
struct Corner {
    /// World, m.
    at: DVec3,
    /// Less the first column whose centre is not west of the place, the last that is not east of it; the same for rows.
    around: [i32; 4],
}

/// Columns and rows whose centres lie between some corners; a little generous. Most triangles of a tree lie between all
/// centres, so this is where time goes: of each pair of numbers the greatest decide.
#[inline(always)]
fn between<const N: usize>(corners: &[Corner; N]) -> Option<[core::ops::Range<usize>; 2]> {
    let mut most = corners[0].around;
    for corner in &corners[1..] {
        for (most, other) in most.iter_mut().zip(corner.around) {
            *most = (*most).max(other);
        }
    }
    let [west, east, south, north] = most;
    // No branch between the two: which of them sends a triangle away is not to be foreseen.
    let least = (west + east).min(south + north);
    let range = |low: i32, high: i32| (-low) as usize..(high + 1) as usize;
    (least >= 0).then(|| [range(west, east), range(south, north)])
}

/// A vertical line's way through a surface, in one number, so that hundreds of millions sort quickly. In their order they go
/// cell by cell, each from above; where a line enters one solid and leaves another at the same height, it enters first:
/// solids that touch leave no room between them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Crossing(u64);

impl Crossing {
    fn new(cell: u32, z_m: f32, enters: bool, terrain: bool) -> Self {
        // The bits of a float in an order that unsigned numbers share, then turned round: from above.
        let bits = z_m.to_bits();
        let ascending = if bits >> 31 == 1 { !bits } else { bits | 1 << 31 };
        Self(u64::from(cell) << 34 | u64::from(!ascending) << 2 | u64::from(!enters) << 1 | u64::from(terrain))
    }

    /// The line's cell, counted from the first of its band.
    pub(super) fn cell(self) -> usize {
        (self.0 >> 34) as usize
    }

    /// Height, m.
    pub(super) fn z_m(self) -> f32 {
        let ascending = !((self.0 >> 2) as u32);
        f32::from_bits(if ascending >> 31 == 1 { ascending & !(1 << 31) } else { !ascending })
    }

    /// Whether the surface looks up: going down, the line enters a solid.
    pub(super) fn enters(self) -> bool {
        self.0 & 2 == 0
    }

    /// Whether it is bare terrain.
    pub(super) fn is_terrain(self) -> bool {
        self.0 & 1 == 1
    }
}

/// A scene's triangles, sorted by the bands of a grid.
pub(super) struct Columns<'s> {
    scene: &'s Scene,
    grid: Grid,
    /// For each band, the instances that reach into it.
    bands: Vec<Vec<Part>>,
}

/// What of an instance concerns a band.
struct Part {
    instance: u32,
    /// Its triangles there; none where all have to be looked at.
    triangles: Option<Vec<u32>>,
}

impl<'s> Columns<'s> {
    /// Sorts a scene's triangles.
    pub(super) fn new(scene: &'s Scene, grid: Grid) -> Self {
        let bounds: Vec<Option<(DVec3, DVec3)>> = scene.meshes.par_iter().map(satseed_scene::Mesh::bounds_m).collect();
        let parts: Vec<Vec<(usize, Part)>> = (0..scene.instances.len())
            .into_par_iter()
            .map(|i| match bounds[scene.instances[i].mesh as usize] {
                Some(bounds) => parts(scene, &grid, i as u32, bounds),
                None => Vec::new(),
            })
            .collect();
        let mut bands: Vec<Vec<Part>> = (0..grid.side.div_ceil(BAND_ROWS)).map(|_| Vec::new()).collect();
        for (band, part) in parts.into_iter().flatten() {
            bands[band].push(part);
        }
        Self { scene, grid, bands }
    }

    /// All crossings of a band's lines, sorted.
    pub(super) fn band(&self, band: usize) -> Vec<Crossing> {
        let first = band * BAND_ROWS;
        let rows = first..(first + BAND_ROWS).min(self.grid.side);
        let mut out = Vec::with_capacity(rows.len() * self.grid.side * USUAL_CROSSINGS);
        let mut corners: Vec<Corner> = Vec::new();
        for part in &self.bands[band] {
            let placed = &self.scene.instances[part.instance as usize];
            let terrain = placed.object == 0;
            let mut add = |corners: [Corner; 3]| {
                cover(&self.grid, first, &corners, |cell, enters, z_m| {
                    out.push(Crossing::new(cell, z_m as f32, enters, terrain));
                });
            };
            if let Some(triangles) = &part.triangles {
                for t in triangles {
                    add(self.scene.corners(part.instance, *t).map(|p| self.grid.corner(p, &rows)));
                }
            } else {
                // Each vertex is placed once: six triangles have it.
                let mesh = &self.scene.meshes[placed.mesh as usize];
                let place = |p: &[f32; 3]| placed.world_from_object.transform_point3(DVec3::from(p.map(f64::from)));
                corners.clear();
                corners.extend(mesh.positions_m.iter().map(|p| self.grid.corner(place(p), &rows)));
                for [a, b, c] in &mesh.triangles {
                    add([corners[*a as usize], corners[*b as usize], corners[*c as usize]]);
                }
            }
        }
        out.sort_unstable();
        out
    }
}

/// The bands that rows lie in.
fn bands_of(rows: &core::ops::Range<usize>) -> core::ops::Range<usize> {
    rows.start / BAND_ROWS..rows.end.div_ceil(BAND_ROWS)
}

/// The bands that an instance reaches into.
fn parts(scene: &Scene, grid: &Grid, instance: u32, (low, high): (DVec3, DVec3)) -> Vec<(usize, Part)> {
    let placed = &scene.instances[instance as usize];
    let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for k in 0..8 {
        let pick = |bit: u32, axis: usize| if k >> bit & 1 == 0 { low[axis] } else { high[axis] };
        let p = placed.world_from_object.transform_point3(DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2)));
        least = least.min(p);
        most = most.max(p);
    }
    let Some([_, rows]) = between(&[least, most].map(|p| grid.corner_anywhere(p))) else { return Vec::new() };
    let bands = bands_of(&rows);
    if bands.len() <= FEW_BANDS {
        return bands.map(|band| (band, Part { instance, triangles: None })).collect();
    }
    let mut lists: Vec<Vec<u32>> = bands.clone().map(|_| Vec::new()).collect();
    for triangle in 0..scene.meshes[placed.mesh as usize].triangles.len() as u32 {
        let corners = scene.corners(instance, triangle).map(|p| grid.corner_anywhere(p));
        let Some([_, rows]) = between(&corners) else { continue };
        for band in bands_of(&rows) {
            lists[band - bands.start].push(triangle);
        }
    }
    let full = bands.zip(lists).filter(|(_, list)| !list.is_empty());
    full.map(|(band, list)| (band, Part { instance, triangles: Some(list) })).collect()
}

/// Calls `found` for every cell whose vertical line crosses a triangle, among the rows that its corners know: the cell,
/// counted from the start of row `first`, whether the triangle looks up, and the height.
#[inline(always)]
fn cover(grid: &Grid, first: usize, corners: &[Corner; 3], mut found: impl FnMut(u32, bool, f64)) {
    let Some([columns, rows]) = between(corners) else { return };
    let [a, b, c] = corners.map(|corner| corner.at);
    let area = (b - a).truncate().perp_dot((c - a).truncate());
    if area == 0.0 {
        // A wall: no vertical line crosses it.
        return;
    }
    let enters = area > 0.0;
    let [p, q, r] = if enters { [a, b, c] } else { [a, c, b] };
    let (low, high) = (a.z.min(b.z).min(c.z), a.z.max(b.z).max(c.z));
    let edges = [Edge::new(p, q), Edge::new(q, r), Edge::new(r, p)];
    for row in rows {
        for column in columns.clone() {
            let at = grid.centre(column, row);
            // By name: `map` over an array is at times not compiled into this loop, which then takes twice as long.
            let (pq, qr, rp) = (edges[0].side(at), edges[1].side(at), edges[2].side(at));
            if pq.0 && qr.0 && rp.0 {
                let z = (r.z * pq.1 + p.z * qr.1 + q.z * rp.1) / (pq.1 + qr.1 + rp.1);
                // A triangle nearly on edge has a height only within its corners'; a number that is none falls on the lowest.
                let cell = ((row - first) * grid.side + column) as u32;
                found(cell, enters, z.min(high).max(low));
            }
        }
    }
}

/// An edge seen from above. The two triangles of an edge go along it in opposite directions and get opposite answers, on
/// the line as well: always the same end comes first.
struct Edge {
    first: DVec2,
    along: DVec2,
    turned: bool,
}

impl Edge {
    fn new(from: DVec3, to: DVec3) -> Self {
        let (from, to) = (from.truncate(), to.truncate());
        let turned = (from.x, from.y) >= (to.x, to.y);
        let (first, last) = if turned { (to, from) } else { (from, to) };
        Self { first, along: last - first, turned }
    }

    /// Whether a point lies to the left, and twice the area that it spans with the edge.
    #[inline(always)]
    fn side(&self, at: DVec2) -> (bool, f64) {
        let area = self.along.perp_dot(at - self.first);
        if self.turned { (area < 0.0, -area) } else { (area >= 0.0, area) }
    }
}
