//! Houses as closed solids in the house's frame; z is the world's height.

use super::houses::{Cover, House, Item, widened};
use super::piece::Side;
use super::roof::{Roof, RoofSlots};
use crate::kit::mesh_builder::{BlockSlots, MeshBuilder, NOMINAL_BAY_M, NOMINAL_FLOOR_M, Parapet, Wall};
use crate::kit::polygon;
use glam::{DVec2, DVec3};
use satseed_scene::Mesh;

/// Slots of a house's material set.
pub(super) mod slot {
    /// Walls with windows.
    pub(in super::super) const WALL: u16 = 0;
    /// Walls without.
    pub(in super::super) const BLANK: u16 = 1;
    /// Tiles.
    pub(in super::super) const ROOF: u16 = 2;
    /// Eaves and gutters.
    pub(in super::super) const EDGE: u16 = 3;
    /// Chimneys and dormers.
    pub(in super::super) const CHIMNEY: u16 = 4;
    /// Boards and posts.
    pub(in super::super) const WOOD: u16 = 5;
    /// Openings.
    pub(in super::super) const DARK: u16 = 6;
    /// Istrian stone.
    pub(in super::super) const STONE: u16 = 7;
    /// Panes.
    pub(in super::super) const GLASS: u16 = 8;
    /// Sheet metal, masts.
    pub(in super::super) const METAL: u16 = 9;
    /// Ridge tiles in mortar.
    pub(in super::super) const RIDGE: u16 = 10;
    /// A terrace's floor.
    pub(in super::super) const TERRACE: u16 = 11;
    /// How many.
    pub(in super::super) const COUNT: usize = 12;
}

const ROOF_SLOTS: RoofSlots = RoofSlots { roof: slot::ROOF, edge: slot::EDGE, gable: slot::BLANK };

/// The mesh of a house; `full` with all that stands on it.
pub(super) fn mesh(house: &House, full: bool) -> Mesh {
    let mut b = MeshBuilder::default();
    match &house.cover {
        Cover::Tiles(roof) => {
            walls(&mut b, house, house.eaves_m - 0.1);
            let mut made = roof.mesh(&mut b, ROOF_SLOTS);
            let mut roof = roof.clone();
            if !made {
                // Odd corners: four slopes on all sides, or none at all.
                let slope = roof.slopes.iter().flatten().copied().fold(0.0, f64::max);
                roof.slopes.fill(Some(slope));
                made = roof.mesh(&mut b, ROOF_SLOTS);
            }
            if !made {
                b.prism(slot::EDGE, slot::ROOF, &roof.outline, house.eaves_m - 0.2, house.eaves_m, Wall::PLAIN);
            } else if full {
                ridges(&mut b, &roof);
            }
            if full && made {
                for item in &house.items {
                    on_tiles(&mut b, item, &roof);
                }
            }
        }
        Cover::Terrace(parapet_m) => {
            walls(&mut b, house, house.eaves_m - 0.6);
            let slots =
                BlockSlots { side: slot::BLANK, coping: slot::STONE, strip: slot::TERRACE, roof: slot::TERRACE };
            let shape = Parapet { height_m: *parapet_m, width_m: 0.22, strip_m: 0.0 };
            let outline = widened(&house.outline, |_| 0.03);
            b.parapet_block(slots, &outline, house.eaves_m - 0.75, house.eaves_m, shape, Wall::PLAIN);
            if full {
                for item in &house.items {
                    if let Item::Box { at, axis, half_m, over_m } = item {
                        let (low, high) = (house.eaves_m - 0.1, house.eaves_m + over_m);
                        b.block(slot::WOOD, slot::EDGE, *at, *axis, *half_m, low, high);
                    }
                }
            }
        }
    }
    b.finish()
}

/// Walls from below the water up to a height; those to neighbours have no windows.
fn walls(b: &mut MeshBuilder, house: &House, high_m: f64) {
    let low_m = House::low_m();
    let outline = &house.outline;
    let v = |z: f64| z / house.floor_m * NOMINAL_FLOOR_M;
    let mut u = 0.0;
    for i in 0..outline.len() {
        let (p, q) = (outline[i], outline[(i + 1) % outline.len()]);
        let bays = libm::round(p.distance(q) / house.bay_m).max(1.0);
        let w = bays * NOMINAL_BAY_M;
        let blank = house.sides[i] == Side::Party || p.distance(q) < 1.8;
        b.fan(
            if blank { slot::BLANK } else { slot::WALL },
            &[
                (p.extend(low_m), DVec2::new(u, v(low_m))),
                (q.extend(low_m), DVec2::new(u + w, v(low_m))),
                (q.extend(high_m), DVec2::new(u + w, v(high_m))),
                (p.extend(high_m), DVec2::new(u, v(high_m))),
            ],
        );
        u += w + NOMINAL_BAY_M * 8.0;
    }
    b.cap(slot::BLANK, outline, high_m, true);
    b.cap(slot::BLANK, outline, low_m, false);
}

/// Ridge tiles: a low bar along every ridge and hip.
fn ridges(b: &mut MeshBuilder, roof: &Roof) {
    for [p, q] in roof.ridges() {
        let d = q - p;
        if d.truncate().length() < 0.8 {
            continue;
        }
        let along = d.truncate().normalize();
        let left = along.perp() * 0.14;
        let at = |c: DVec3, s: f64, z: f64| (c.truncate() + left * s).extend(c.z + z);
        // The bar's ends are cut square within the roof, so none shows.
        let (p, q) = (p + d * (0.05 / d.length()), q - d * (0.05 / d.length()));
        let section = [(-1.0, -0.2), (1.0, -0.2), (1.0, 0.02), (0.0, 0.11), (-1.0, 0.02)];
        bar(b, slot::RIDGE, &section.map(|(s, z)| at(p, s, z)), &section.map(|(s, z)| at(q, s, z)));
    }
}

/// A closed bar between two equal sections, counter-clockwise seen from the far end looking back.
fn bar(b: &mut MeshBuilder, slot: u16, near: &[DVec3], far: &[DVec3]) {
    let n = near.len();
    let length = near[0].distance(far[0]);
    for k in 0..n {
        let j = (k + 1) % n;
        let (v0, v1) = (k as f64 * 0.2, k as f64 * 0.2 + 0.2);
        b.fan(
            slot,
            &[
                (near[k], DVec2::new(0.0, v0)),
                (near[j], DVec2::new(0.0, v1)),
                (far[j], DVec2::new(length, v1)),
                (far[k], DVec2::new(length, v0)),
            ],
        );
    }
    let flat = |p: &DVec3| (*p, DVec2::new(p.x + p.y, p.z));
    b.fan(slot, &near.iter().rev().map(flat).collect::<Vec<_>>());
    b.fan(slot, &far.iter().map(flat).collect::<Vec<_>>());
}

fn on_tiles(b: &mut MeshBuilder, item: &Item, roof: &Roof) {
    match *item {
        Item::Chimney { at, axis, half_m, over_m, flared } => {
            let z = roof.height_m(at);
            let shaft = polygon::oriented_rectangle(at, axis, half_m);
            let top = z + over_m;
            if flared {
                b.prism(slot::CHIMNEY, slot::CHIMNEY, &shaft, z - 0.6, top - 0.55, Wall::PLAIN);
                let (lower, upper) = (polygon::mitred(&shaft, -0.02), polygon::mitred(&shaft, -half_m.y * 0.75));
                b.frustum(slot::CHIMNEY, slot::DARK, &lower, &upper, top - 0.65, top);
            } else {
                b.prism(slot::CHIMNEY, slot::DARK, &shaft, z - 0.6, top - 0.3, Wall::PLAIN);
                let hat = polygon::mitred(&shaft, -0.12);
                let tip = polygon::mitred(&shaft, half_m.y * 0.6);
                b.frustum(slot::ROOF, slot::ROOF, &hat, &tip, top - 0.12, top + 0.15);
                b.block(slot::DARK, slot::DARK, at, axis, half_m * 0.6, top - 0.4, top - 0.05);
            }
        }
        Item::Dormer { at, out, half_m, depth_m, front_m } => {
            let across = out.perp();
            let front = at + out * (depth_m * 0.5);
            let eaves = roof.height_m(front) + front_m;
            let rect = |w: f64, before: f64, behind: f64| {
                vec![
                    at - across * w - out * behind,
                    at - across * w + out * before,
                    at + across * w + out * before,
                    at + across * w - out * behind,
                ]
            };
            let body = rect(half_m, depth_m * 0.5, depth_m * 0.5);
            let low = roof.height_m(front) - 0.4;
            b.prism(slot::CHIMNEY, slot::CHIMNEY, &body, low, eaves - 0.08, Wall::PLAIN);
            let pane = polygon::oriented_rectangle(front, across, DVec2::new(half_m * 0.55, 0.04));
            b.prism(slot::GLASS, slot::GLASS, &pane, eaves - front_m + 0.15, eaves - 0.25, Wall::PLAIN);
            let small = Roof {
                outline: rect(half_m + 0.18, depth_m * 0.5 + 0.2, depth_m * 0.5 + 0.1),
                slopes: vec![Some(0.36), None, Some(0.36), None],
                eaves_m: eaves,
            };
            small.mesh(b, ROOF_SLOTS);
        }
        Item::Altana { at, axis, half_m, deck_m } => {
            let deck = polygon::oriented_rectangle(at, axis, half_m);
            b.prism(slot::WOOD, slot::WOOD, &deck, deck_m - 0.14, deck_m, Wall::PLAIN);
            let n = axis.perp();
            for (x, y) in [(-1.0, -1.0), (0.0, -1.0), (1.0, -1.0), (1.0, 1.0), (0.0, 1.0), (-1.0, 1.0)] {
                let p = at + axis * (x * (half_m.x - 0.1)) + n * (y * (half_m.y - 0.1));
                b.block(slot::WOOD, slot::WOOD, p, axis, DVec2::splat(0.07), roof.height_m(p) - 0.4, deck_m + 1.0);
            }
            for (d, reach, off) in [(axis, half_m.x, half_m.y), (n, half_m.y, half_m.x)] {
                for s in [-1.0, 1.0] {
                    for z in [0.5, 0.94] {
                        let c = at + d.perp() * (s * (off - 0.1));
                        b.block(slot::WOOD, slot::WOOD, c, d, DVec2::new(reach, 0.04), deck_m + z, deck_m + z + 0.08);
                    }
                }
            }
        }
        Item::Skylight { at, axis, half_m } => {
            let q = polygon::oriented_rectangle(at, axis, half_m);
            let top: Vec<DVec3> = q.iter().map(|p| p.extend(roof.height_m(*p) + 0.09)).collect();
            let low: Vec<DVec3> = q.iter().map(|p| p.extend(roof.height_m(*p) - 0.15)).collect();
            let uv = |p: &DVec3| (*p, DVec2::new(p.x, p.y));
            b.fan(slot::GLASS, &top.iter().map(uv).collect::<Vec<_>>());
            b.fan(slot::METAL, &low.iter().rev().map(uv).collect::<Vec<_>>());
            for k in 0..4 {
                let j = (k + 1) % 4;
                b.fan(slot::METAL, &[uv(&low[k]), uv(&low[j]), uv(&top[j]), uv(&top[k])]);
            }
        }
        Item::Mast { at, over_m } => {
            let z = roof.height_m(at);
            b.limb(slot::METAL, at.extend(z - 0.3), at.extend(z + over_m), [0.03, 0.03], 4);
            b.block(slot::METAL, slot::METAL, at, DVec2::X, DVec2::new(0.5, 0.03), z + over_m - 0.3, z + over_m - 0.22);
        }
        Item::Box { .. } => {}
    }
}
