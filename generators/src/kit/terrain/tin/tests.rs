use super::*;
use crate::kit::terrain::noise::fractal;
use glam::DVec3;
use std::collections::BTreeMap;

fn rough(p: DVec2) -> f64 {
    let wall = if fractal(p, 9, 60.0, 3, 0.5) > 0.05 { 20.0 } else { 0.0 };
    wall + fractal(p, 2, 40.0, 6, 0.55) * 15.0
}

fn layout() -> Layout {
    let fine = Grain { post_m: 0.5, max_error_m: 0.05 };
    let coarse = Grain { post_m: 4.0, max_error_m: 0.8 };
    let grains = (0..9).map(|t| if t % 3 == 2 || t / 3 == 2 { coarse } else { fine }).collect();
    Layout { origin_m: DVec2::splat(-48.0), tile_m: 32.0, columns: 3, rows: 3, grains }
}

fn ring() -> Breakline {
    let points = (0..=40).map(|k| {
        let (s, c) = libm::sincos(f64::from(k % 40) * core::f64::consts::TAU / 40.0);
        DVec3::new(30.0 * c + 1.7, 30.0 * s + 0.3, 4.0)
    });
    Breakline { points_m: points.collect() }
}

/// Every edge by the bits of its ends, with the number of triangles on its left and right.
fn edge_uses(tiles: &[TileMesh]) -> BTreeMap<[[u32; 3]; 2], [u32; 2]> {
    let mut uses = BTreeMap::new();
    for tile in tiles {
        for t in &tile.triangles {
            for k in 0..3 {
                let bits = |v: u32| tile.positions_m[v as usize].map(|x| (x + 0.0).to_bits());
                let (a, b) = (bits(t[k]), bits(t[(k + 1) % 3]));
                let entry = uses.entry([a.min(b), a.max(b)]).or_insert([0, 0]);
                entry[usize::from(a > b)] += 1;
            }
        }
    }
    uses
}

#[test]
fn tiles_fit_without_cracks_and_face_up() {
    let layout = layout();
    let tiles = triangulate(&layout, &rough, &[ring()]);
    let mut rim = 0.0;
    for (edge, uses) in edge_uses(&tiles) {
        let [a, b] = edge.map(|p| DVec3::from_array(p.map(|x| f64::from(f32::from_bits(x)))));
        let on_rim = |axis: usize| a[axis] == b[axis] && a[axis].abs() == 48.0;
        if on_rim(0) || on_rim(1) {
            assert_eq!(uses.iter().sum::<u32>(), 1, "{a} {b}");
            rim += (a - b).truncate().length();
        } else {
            assert_eq!(uses, [1, 1], "{a} {b}");
        }
    }
    assert_eq!(rim, 4.0 * 96.0);
    for tile in &tiles {
        for t in &tile.triangles {
            let [a, b, c] = t.map(|v| DVec3::from_array(tile.positions_m[v as usize].map(f64::from)));
            assert!((b - a).truncate().perp_dot((c - a).truncate()) > 0.0);
        }
    }
}

#[test]
fn every_post_lies_within_the_bound() {
    let layout = layout();
    let tiles = triangulate(&layout, &rough, &[]);
    for (tile, mesh) in tiles.iter().enumerate() {
        let grain = layout.grains[tile];
        let corner = layout.corner_m(tile % 3, tile / 3);
        let side = (layout.tile_m / grain.post_m) as usize;
        let mut seen = vec![false; (side + 1) * (side + 1)];
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| DVec3::from_array(mesh.positions_m[v as usize].map(f64::from)));
            let normal = (b - a).cross(c - a);
            let low = ((a.min(b).min(c).truncate() - corner) / grain.post_m).floor();
            let high = ((a.max(b).max(c).truncate() - corner) / grain.post_m).ceil();
            for j in low.y as usize..=high.y as usize {
                for i in low.x as usize..=high.x as usize {
                    let p = corner + DVec2::new(i as f64, j as f64) * grain.post_m;
                    let inside = [(a, b), (b, c), (c, a)]
                        .iter()
                        .all(|(u, v)| (*v - *u).truncate().perp_dot(p - u.truncate()) >= 0.0);
                    if inside {
                        seen[j * (side + 1) + i] = true;
                        let z = a.z - ((p.x - a.x) * normal.x + (p.y - a.y) * normal.y) / normal.z;
                        assert!((z - rough(p)).abs() <= grain.max_error_m, "tile {tile} at {p}: {z} {}", rough(p));
                    }
                }
            }
        }
        assert!(seen.iter().all(|s| *s));
    }
}

#[test]
fn breaklines_are_edges_across_tiles() {
    let layout = layout();
    let tiles = triangulate(&layout, &rough, &[ring()]);
    // The ring's length is found again as edges at its height between points near its circle.
    let mut length = 0.0;
    for (edge, _) in edge_uses(&tiles) {
        let [a, b] = edge.map(|p| DVec3::from_array(p.map(|x| f64::from(f32::from_bits(x)))));
        let near = |p: DVec3| ((p.truncate() - DVec2::new(1.7, 0.3)).length() - 30.0).abs() < 0.1;
        if a.z == 4.0 && b.z == 4.0 && near(a) && near(b) {
            length += (a - b).length();
        }
    }
    let chord = 2.0 * 30.0 * libm::sin(core::f64::consts::PI / 40.0);
    assert!((length - 40.0 * chord).abs() < 0.1, "{length} for {}", 40.0 * chord);
}

#[test]
fn a_plane_needs_two_triangles_a_tile() {
    let plane = |p: DVec2| 0.25 * p.x - 0.5 * p.y;
    let tiles = triangulate(&layout(), &plane, &[]);
    assert!(tiles.iter().all(|t| t.triangles.len() == 2));
}
