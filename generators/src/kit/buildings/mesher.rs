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

/// Everything on a roof is sunk into it by this, m: nothing floats and nothing is coplanar.
const SUNK_M: f64 = 0.15;

fn roof_item(b: &mut MeshBuilder, item: &RoofItem) {
    let (low, high) = (item.base_m - SUNK_M, item.base_m + item.height_m);
    let outline = polygon::oriented_rectangle(item.centre_m, item.axis, item.half_m);
    let at = |x: f64, y: f64| item.centre_m + item.axis * (item.half_m.x * x) + item.axis.perp() * (item.half_m.y * y);
    match item.kind {
        RoofItemKind::AirHandler => {
            b.prism(slot::METAL, slot::METAL, &outline, low, high, Wall::PLAIN);
            let r = (item.half_m.y * 0.72).min(item.half_m.x * 0.42);
            for x in [-0.5, 0.5] {
                b.prism(slot::METAL, slot::DARK, &disc(at(x, 0.0), r, 8), high - 0.1, high + 0.18, Wall::PLAIN);
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
