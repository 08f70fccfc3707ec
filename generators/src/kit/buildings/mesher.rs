//! A building's plan as one mesh in the building's frame: z = 0 is its ground level.

use super::facade::{flat_mass, pitched_mass};
use super::plan::{BuildingPlan, Roof, RoofItem, RoofItemKind, slot};
use crate::kit::mesh_builder::{MeshBuilder, Wall};
use crate::kit::polygon;
use glam::{DVec2, DVec3};
use satseed_scene::Mesh;

/// How much of a building is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detail {
    /// Everything.
    Full,
    /// Its masses only, as plain blocks: for shadows and reflections from outside the detailed circle.
    Massing,
}

/// The mesh of a building.
pub fn mesh(plan: &BuildingPlan, detail: Detail) -> Mesh {
    let mut b = MeshBuilder::default();
    for mass in &plan.masses {
        match (detail, mass.roof) {
            (Detail::Full, Roof::Flat { parapet_m, slot }) => flat_mass(&mut b, mass, parapet_m, slot),
            (_, Roof::Gable { .. }) => pitched_mass(&mut b, mass),
            (Detail::Massing, Roof::Flat { slot: roof, .. }) => {
                let wall = mass.wall();
                b.prism(slot::WALL, roof, &mass.outline, mass.low_m, mass.roof_m, wall);
            }
        }
    }
    if detail == Detail::Full {
        for item in &plan.items {
            roof_item(&mut b, item);
        }
    }
    b.finish()
}

fn disc(centre: DVec2, radius_m: f64, corners: usize) -> Vec<DVec2> {
    (0..corners)
        .map(|k| {
            let (s, c) = libm::sincos(core::f64::consts::TAU * (k as f64 + 0.37) / corners as f64);
            centre + DVec2::new(c, s) * radius_m
        })
        .collect()
}

/// A fan in a low ring on a machine whose top is at `z_m`.
fn fan(b: &mut MeshBuilder, centre: DVec2, radius_m: f64, z_m: f64) {
    b.prism(slot::METAL, slot::DARK, &disc(centre, radius_m, 8), z_m - 0.1, z_m + 0.18, Wall::PLAIN);
}

/// Everything on a roof is sunk into it by this, m: nothing floats and nothing is coplanar.
const SUNK_M: f64 = 0.15;

fn roof_item(b: &mut MeshBuilder, item: &RoofItem) {
    let (low, high) = (item.base_m - SUNK_M, item.base_m + item.height_m);
    let outline = polygon::oriented_rectangle(item.centre_m, item.axis, item.half_m);
    let at = |x: f64, y: f64| item.centre_m + item.axis * (item.half_m.x * x) + item.axis.perp() * (item.half_m.y * y);
    match item.kind {
        RoofItemKind::AirHandler => {
            let between = |x0: f64, x1: f64, y: f64| [at(x0, -y), at(x1, -y), at(x1, y), at(x0, y)];
            b.prism(slot::METAL, slot::METAL, &between(-0.74, 1.0, 1.0), low, high, Wall::PLAIN);
            // The hood slopes down from the end into which it runs.
            let (foot, top) = (item.base_m + 0.4 * item.height_m, item.base_m + 0.85 * item.height_m);
            b.frustum(slot::METAL, slot::METAL, &between(-1.0, -0.7, 0.75), &between(-0.8, -0.7, 0.75), foot, top);
            if item.half_m.x < 1.9 * item.half_m.y {
                fan(b, at(0.4, 0.0), (item.half_m.y * 0.7).min(item.half_m.x * 0.5), high);
            }
        }
        RoofItemKind::Condenser => {
            b.prism(slot::METAL, slot::METAL, &outline, low, high, Wall::PLAIN);
            let count = libm::round(item.half_m.x / item.half_m.y).clamp(1.0, 6.0) as u32;
            let r = (item.half_m.y * 0.78).min(item.half_m.x / f64::from(count) * 0.84);
            for k in 0..count {
                fan(b, at((2.0 * f64::from(k) + 1.0) / f64::from(count) - 1.0, 0.0), r, high);
            }
        }
        RoofItemKind::CoolingTower => {
            let deck = high - 0.8;
            b.prism(slot::METAL, slot::METAL, &outline, low, deck, Wall::PLAIN);
            let r = item.half_m.min_element() * 0.82;
            let (lower, upper) = (disc(item.centre_m, r, 14), disc(item.centre_m, r * 0.9, 14));
            b.frustum(slot::METAL, slot::DARK, &lower, &upper, deck - 0.1, high);
        }
        RoofItemKind::Screen => {
            let (t, axis) = (0.09, item.axis);
            for end in [-1.0, 1.0] {
                let half = DVec2::new(item.half_m.x, t);
                b.block(slot::WALL, slot::COPING, at(0.0, end), axis, half, low, high);
                // A little lower than those that they end in, so that no two tops lie in one plane.
                let half = DVec2::new(t, item.half_m.y);
                b.block(
                    slot::WALL,
                    slot::COPING,
                    at(end * (1.0 - t / item.half_m.x), 0.0),
                    axis,
                    half,
                    low,
                    high - 0.04,
                );
            }
        }
        RoofItemKind::Duct => b.prism(slot::METAL, slot::METAL, &outline, low, high, Wall::PLAIN),
        RoofItemKind::Bulkhead => {
            b.prism(slot::WALL, slot::COPING, &outline, low, high, Wall::PLAIN);
            let door = polygon::oriented_rectangle(at(0.2, -1.0), item.axis, DVec2::new(0.5, 0.06));
            b.prism(slot::DARK, slot::DARK, &door, low, item.base_m + 2.1, Wall::PLAIN);
        }
        RoofItemKind::Vent => {
            b.prism(slot::METAL, slot::DARK, &disc(item.centre_m, item.half_m.x, 6), low, high, Wall::PLAIN);
        }
        RoofItemKind::Skylight => {
            b.prism(slot::COPING, slot::COPING, &outline, low, item.base_m + 0.3, Wall::PLAIN);
            let lower = polygon::mitred(&outline, 0.1);
            let upper = polygon::mitred(&outline, (item.half_m.y * 0.5).min(0.6));
            b.frustum(slot::SHOP, slot::SHOP, &lower, &upper, item.base_m + 0.2, high);
        }
        RoofItemKind::Panels => {
            // A wedge down to the roof: trays of ballast close the sides.
            let p = |q: DVec2, z: f64| q.extend(z);
            let (c0, c1, c2, c3) = (outline[0], outline[1], outline[2], outline[3]);
            let (front, back) = (item.base_m + 0.12, high);
            let uv = |x: f64, y: f64| DVec2::new(x, y);
            let (l, w) = (2.0 * item.half_m.x, 2.0 * item.half_m.y);
            let quad = |b: &mut MeshBuilder, s: u16, q: [DVec3; 4]| {
                b.fan(s, &[(q[0], uv(0.0, 0.0)), (q[1], uv(l, 0.0)), (q[2], uv(l, w)), (q[3], uv(0.0, w))]);
            };
            quad(b, slot::PANEL, [p(c0, front), p(c1, front), p(c2, back), p(c3, back)]);
            quad(b, slot::METAL, [p(c0, low), p(c1, low), p(c1, front), p(c0, front)]);
            quad(b, slot::METAL, [p(c1, low), p(c2, low), p(c2, back), p(c1, front)]);
            quad(b, slot::METAL, [p(c2, low), p(c3, low), p(c3, back), p(c2, back)]);
            quad(b, slot::METAL, [p(c3, low), p(c0, low), p(c0, front), p(c3, back)]);
            quad(b, slot::METAL, [p(c3, low), p(c2, low), p(c1, low), p(c0, low)]);
        }
        RoofItemKind::Tank => {
            b.prism(slot::METAL, slot::METAL, &disc(item.centre_m, item.half_m.x, 10), low, high, Wall::PLAIN);
            let rim = disc(item.centre_m, item.half_m.x * 0.7, 10);
            b.prism(slot::METAL, slot::DARK, &rim, high - 0.2, high + 0.3, Wall::PLAIN);
        }
        RoofItemKind::Bed => b.prism(slot::COPING, slot::GREEN, &outline, low, high, Wall::PLAIN),
        RoofItemKind::Chimney => {
            b.prism(slot::WALL, slot::DARK, &outline, item.base_m - 1.5, high, Wall::PLAIN);
        }
        RoofItemKind::Mast => {
            let c = item.centre_m;
            b.limb(slot::METAL, c.extend(low), c.extend(high), [item.half_m.x, item.half_m.x * 0.4], 5);
        }
    }
}
