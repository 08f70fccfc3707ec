//! The bin oracle's candidates: for some rows of a rectified pair, the triangles behind every pixel of both cameras.
//!
//! Every primary segment starts in its camera's centre, and every way back ends in the other's. Such a segment is one
//! image point, so only triangles whose projection covers that point can meet it. Rows of a rectified pair are the same
//! in both images, so a band of rows needs the bins of that band alone, and a whole scene fits.

use super::brute::{Candidates, Tri};
use glam::{DVec2, DVec3};
use satseed::camera::{Camera, StereoRig};
use satseed::labels::View;
use satseed_scene::Scene;
use std::ops::Range;

/// By how much a projection is grown, px: far more than f64's rounding and the band of 1e-9 of the length.
const MARGIN_PX: f64 = 0.02;

pub(crate) struct Bins {
    triangles: Vec<Tri>,
    rows: Range<u32>,
    cameras: [Bin; 2],
}

struct Bin {
    width: u32,
    /// For each pixel of the band, where its triangles begin; one more at the end.
    starts: Vec<u32>,
    indices: Vec<u32>,
}

/// A triangle over some columns of a row.
struct Span {
    triangle: u32,
    row: u32,
    from: u32,
    to: u32,
}

impl Bins {
    pub(crate) fn new(scene: &Scene, rig: &StereoRig, rows: Range<u32>) -> Self {
        let cameras = [&rig.left, &rig.right];
        let bounds: Vec<Option<(DVec3, DVec3)>> = scene.meshes.iter().map(satseed_scene::Mesh::bounds_m).collect();
        let mut triangles = Vec::new();
        let mut spans = [Vec::new(), Vec::new()];
        for (i, instance) in scene.instances.iter().enumerate() {
            let Some((low, high)) = bounds[instance.mesh as usize] else { continue };
            let corners: Vec<DVec3> = (0..8)
                .map(|k| {
                    let pick = |bit: usize, axis: usize| if k >> bit & 1 == 0 { low[axis] } else { high[axis] };
                    instance.world_from_object.transform_point3(DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2)))
                })
                .collect();
            if !cameras.iter().any(|c| covers(c, &corners, &rows)) {
                continue;
            }
            for t in 0..scene.meshes[instance.mesh as usize].triangles.len() {
                let tri = Tri { corners: scene.corners(i as u32, t as u32), instance: i as u32, triangle: t as u32 };
                let before = spans[0].len() + spans[1].len();
                for (camera, spans) in cameras.iter().zip(&mut spans) {
                    add_spans(camera, &tri, triangles.len() as u32, &rows, spans);
                }
                if spans[0].len() + spans[1].len() > before {
                    triangles.push(tri);
                }
            }
        }
        let [left, right] = spans;
        let bin = |camera: &Camera, spans: Vec<Span>| Bin::new(camera.width_px, &rows, &spans);
        let cameras = [bin(&rig.left, left), bin(&rig.right, right)];
        Self { triangles, rows, cameras }
    }

    /// Triangles in the band, and the mean number behind a pixel.
    pub(crate) fn load(&self) -> (usize, f64) {
        let pixels = (self.cameras[0].starts.len() + self.cameras[1].starts.len() - 2) as f64;
        let held = self.cameras[0].indices.len() + self.cameras[1].indices.len();
        (self.triangles.len(), held as f64 / pixels)
    }
}

impl Candidates for Bins {
    fn triangles(&self) -> &[Tri] {
        &self.triangles
    }

    fn behind(&self, view: View, image_px: DVec2) -> Option<&[u32]> {
        let bin = &self.cameras[view as usize];
        let (u, v) = (libm::floor(image_px.x + 0.5) as u32, libm::floor(image_px.y + 0.5) as u32);
        assert!(u < bin.width && self.rows.contains(&v), "{image_px} is not in this band");
        assert!((image_px.y - f64::from(v)).abs() < MARGIN_PX / 2.0, "{image_px} lies between rows");
        let at = ((v - self.rows.start) * bin.width + u) as usize;
        Some(&bin.indices[bin.starts[at] as usize..bin.starts[at + 1] as usize])
    }
}

impl Bin {
    fn new(width: u32, rows: &Range<u32>, spans: &[Span]) -> Self {
        let first = |s: &Span| ((s.row - rows.start) * width + s.from) as usize;
        let mut starts = vec![0_u32; rows.len() * width as usize + 1];
        for s in spans {
            for at in first(s)..=first(s) + (s.to - s.from) as usize {
                starts[at + 1] += 1;
            }
        }
        for at in 1..starts.len() {
            starts[at] += starts[at - 1];
        }
        let mut next = starts.clone();
        let mut indices = vec![0; starts[starts.len() - 1] as usize];
        for s in spans {
            for at in first(s)..=first(s) + (s.to - s.from) as usize {
                indices[next[at] as usize] = s.triangle;
                next[at] += 1;
            }
        }
        Self { width, starts, indices }
    }
}

/// Whether the projection of some points' hull can touch the band.
fn covers(camera: &Camera, points: &[DVec3], rows: &Range<u32>) -> bool {
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for p in points {
        let image = camera.project(*p).expect("the scene lies below the cameras");
        low = low.min(image);
        high = high.max(image);
    }
    high.y + 1.0 >= f64::from(rows.start)
        && low.y - 1.0 <= f64::from(rows.end)
        && high.x + 1.0 >= -0.5
        && low.x - 1.0 <= f64::from(camera.width_px)
}

fn add_spans(camera: &Camera, tri: &Tri, triangle: u32, rows: &Range<u32>, spans: &mut Vec<Span>) {
    let corners = tri.corners.map(|p| camera.project(p).expect("the scene lies below the cameras"));
    let low = corners[0].min(corners[1]).min(corners[2]);
    let high = corners[0].max(corners[1]).max(corners[2]);
    let last = f64::from(camera.width_px - 1);
    if high.x < -0.5 - MARGIN_PX || low.x > last + 0.5 + MARGIN_PX {
        return;
    }
    let first_row = libm::ceil(low.y - MARGIN_PX).max(rows.start.into());
    let last_row = libm::floor(high.y + MARGIN_PX).min(f64::from(rows.end) - 1.0);
    if first_row > last_row {
        return;
    }
    for row in first_row as u32..=last_row as u32 {
        let (from, to) = (f64::from(row) - MARGIN_PX, f64::from(row) + MARGIN_PX);
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            if a.y.min(b.y) > to || a.y.max(b.y) < from {
                continue;
            }
            for limit in [from, to] {
                let s = if a.y == b.y { 0.0 } else { ((limit - a.y) / (b.y - a.y)).clamp(0.0, 1.0) };
                let u = a.x + (b.x - a.x) * s;
                left = left.min(u);
                right = right.max(u);
            }
            if a.y == b.y {
                left = left.min(b.x);
                right = right.max(b.x);
            }
        }
        let from = libm::floor(left - MARGIN_PX + 0.5).max(0.0);
        let to = libm::floor(right + MARGIN_PX + 0.5).min(last);
        if from <= to {
            spans.push(Span { triangle, row, from: from as u32, to: to as u32 });
        }
    }
}
