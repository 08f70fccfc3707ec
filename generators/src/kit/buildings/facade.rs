//! Walls: cores, slabs, piers, fins and balconies as closed solids that run into each other.

use super::plan::{Balcony, Facade, Mass, Roof, slot};
use crate::kit::mesh_builder::{BlockSlots, MeshBuilder, Parapet, Wall};
use crate::kit::polygon;
use glam::DVec2;

/// Width of a parapet, m.
const PARAPET_WIDTH_M: f64 = 0.25;

/// Heights of the floor slabs of a mass from the first full floor up, m; the roof is not one.
fn slabs(mass: &Mass) -> impl Iterator<Item = f64> + '_ {
    let count = libm::round((mass.roof_m - mass.first_floor_m) / mass.floor_m).max(0.0) as u32;
    (0..count).map(|k| mass.first_floor_m + mass.floor_m * f64::from(k))
}

/// The walls, floors and (flat) roof of a mass.
pub(super) fn flat_mass(b: &mut MeshBuilder, mass: &Mass, parapet_m: f64, roof_slot: u16) {
    let wall = mass.wall();
    let parapet = Parapet { height_m: parapet_m, width_m: PARAPET_WIDTH_M, strip_m: strip_width(&mass.outline) };
    let slots = BlockSlots { side: slot::SLAB, coping: slot::COPING, strip: slot::STRIP, roof: roof_slot };
    match mass.facade {
        Facade::Plain => {
            let slots = BlockSlots { side: slot::WALL, ..slots };
            b.parapet_block(slots, &mass.outline, mass.low_m, mass.roof_m, parapet, wall);
        }
        Facade::Slabs { recess_m, slab_m, pier_every } => {
            core(b, mass, recess_m, wall);
            for z in slabs(mass) {
                b.prism(slot::SLAB, slot::SLAB, &mass.outline, z - slab_m, z, Wall::PLAIN);
            }
            if pier_every > 0 {
                piers(b, mass, recess_m, 0.5, -0.03, pier_every);
            }
            b.parapet_block(slots, &mass.outline, mass.roof_m - 0.35, mass.roof_m, parapet, Wall::PLAIN);
            balconies(b, mass);
        }
        Facade::Punched { recess_m, band_m, pier_m, proud_m } => {
            core(b, mass, recess_m, wall);
            for z in slabs(mass) {
                // The band reaches from the lintel below to the sill above the slab.
                b.prism(slot::WALL, slot::COPING, &mass.outline, z - band_m * 0.35, z + band_m * 0.65, Wall::PLAIN);
            }
            piers(b, mass, recess_m, pier_m, proud_m, 1);
            let slots = BlockSlots { side: slot::WALL, ..slots };
            b.parapet_block(slots, &mass.outline, mass.roof_m - band_m * 0.4, mass.roof_m, parapet, Wall::PLAIN);
            balconies(b, mass);
        }
        Facade::Curtain { fin_m } => {
            core(b, mass, 0.06, wall);
            for z in slabs(mass) {
                b.prism(slot::SLAB, slot::SLAB, &mass.outline, z - 0.55, z + 0.25, Wall::PLAIN);
            }
            if fin_m > 0.0 {
                piers(b, mass, 0.1, 0.08, fin_m, 1);
            }
            b.parapet_block(slots, &mass.outline, mass.roof_m - 0.8, mass.roof_m, parapet, Wall::PLAIN);
        }
    }
}

fn strip_width(outline: &[DVec2]) -> f64 {
    // Narrow parts leave no room for it.
    let shortest =
        (0..outline.len()).map(|i| outline[i].distance(outline[(i + 1) % outline.len()])).fold(f64::MAX, f64::min);
    if shortest > 4.0 { 0.55 } else { 0.0 }
}

/// The glazed core behind the wall's plane, and the base below the first floor.
fn core(b: &mut MeshBuilder, mass: &Mass, recess_m: f64, wall: Wall) {
    let inner = polygon::mitred(&mass.outline, recess_m);
    let top = mass.roof_m - 0.2;
    if mass.shop {
        let ground = polygon::mitred(&mass.outline, recess_m + 0.35);
        b.prism(
            slot::SHOP,
            slot::SHOP,
            &ground,
            mass.low_m,
            mass.first_floor_m - 0.1,
            Wall { bay_m: 4.0, floor_m: mass.first_floor_m, datum_m: 0.0 },
        );
        b.prism(slot::GLASS, slot::SLAB, &inner, mass.first_floor_m - 0.17, top, wall);
        b.prism(slot::WALL, slot::WALL, &polygon::mitred(&mass.outline, -0.04), mass.low_m, 0.35, Wall::PLAIN);
    } else {
        b.prism(slot::GLASS, slot::SLAB, &inner, mass.low_m, top, wall);
        if mass.low_m < 0.0 {
            b.prism(slot::WALL, slot::WALL, &polygon::mitred(&mass.outline, -0.04), mass.low_m, 0.6, Wall::PLAIN);
        }
    }
}

/// Full-height piers at the borders of bays, `every` n-th, and at the corners.
fn piers(b: &mut MeshBuilder, mass: &Mass, recess_m: f64, width_m: f64, proud_m: f64, every: u32) {
    let outline = &mass.outline;
    let low = if mass.low_m < 0.0 { mass.low_m + 0.05 } else { mass.low_m };
    let high = mass.roof_m - 0.15;
    let depth = recess_m + 0.15 + proud_m;
    for i in 0..outline.len() {
        let (p, q) = (outline[i], outline[(i + 1) % outline.len()]);
        let side = p.distance(q);
        let along = (q - p) / side;
        let inward = along.perp();
        let bays = libm::round(side / mass.bay_m).max(1.0) as u32;
        for k in 1..bays {
            if !k.is_multiple_of(every) {
                continue;
            }
            let centre = p + along * (side * f64::from(k) / f64::from(bays)) + inward * (depth / 2.0 - proud_m);
            b.block(slot::WALL, slot::WALL, centre, along, DVec2::new(width_m / 2.0, depth / 2.0), low, high);
        }
        // A square pier holds the corner; its faces stand a little behind or before the bands'.
        let before = outline[(i + outline.len() - 1) % outline.len()];
        let inward_before = (p - before).normalize().perp();
        let size = width_m.max(0.3);
        let centre = p + (inward + inward_before) * (size / 2.0 - proud_m * 0.9);
        if (p - before).perp_dot(q - p) > 0.0 {
            b.block(slot::WALL, slot::WALL, centre, along, DVec2::splat(size / 2.0), low, high - 0.02);
        }
    }
}

fn balconies(b: &mut MeshBuilder, mass: &Mass) {
    for balcony in &mass.balconies {
        for (k, z) in slabs(mass).enumerate() {
            // The lowest floor has the podium's roof for a terrace.
            if k > 0 && (k as u32).is_multiple_of(balcony.every) {
                one_balcony(b, mass, balcony, z);
            }
        }
    }
}

/// A slab that grows out of the building, and its guard on three sides.
fn one_balcony(b: &mut MeshBuilder, mass: &Mass, balcony: &Balcony, z_m: f64) {
    let (p, q) = (mass.outline[balcony.edge], mass.outline[(balcony.edge + 1) % mass.outline.len()]);
    let along = (q - p).normalize();
    let outward = -along.perp();
    let at = |s: f64, d: f64| p + along * s + outward * d;
    let ([s0, s1], d) = (balcony.span_m, balcony.depth_m);
    let slab = [at(s0, -0.3), at(s0, d), at(s1, d), at(s1, -0.3)];
    b.prism(slot::SLAB, slot::SLAB, &slab, z_m - 0.22, z_m - 0.02, Wall::PLAIN);
    let (e, t) = (0.04, 0.1);
    // Counter-clockwise seen from above: outward is on the right of p -> q.
    let guard = [
        at(s0 + e, -0.05),
        at(s0 + e, d - e),
        at(s1 - e, d - e),
        at(s1 - e, -0.05),
        at(s1 - e - t, -0.05),
        at(s1 - e - t, d - e - t),
        at(s0 + e + t, d - e - t),
        at(s0 + e + t, -0.05),
    ];
    b.prism(slot::GUARD, slot::COPING, &guard, z_m - 0.1, z_m + 1.05, Wall::PLAIN);
}

/// A four-cornered mass under two or four slopes: walls, and a roof with thickness that overhangs them.
pub(super) fn pitched_mass(b: &mut MeshBuilder, mass: &Mass) {
    let Roof::Gable { along_first, rise_m, eaves_m, hip } = mass.roof else { return };
    let mut c: Vec<DVec2> = mass.outline.clone();
    if !along_first {
        c.rotate_left(1);
    }
    let wall = mass.wall();
    // Walls go up into the roof; gable ends are closed by the wall's own gable-shaped solid.
    b.prism(slot::WALL, slot::WALL, &mass.outline, mass.low_m, mass.roof_m, wall);
    let (z, top) = (mass.roof_m, mass.roof_m + rise_m);
    let o = polygon::mitred(&c, -eaves_m);
    let mid = |a: DVec2, b: DVec2| (a + b) * 0.5;
    let (m0, m1) = (mid(o[3], o[0]), mid(o[1], o[2]));
    let cut = hip * 0.5;
    let (r0, r1) = (m0 + (m1 - m0) * cut, m1 + (m0 - m1) * cut);
    // A low ridge (the coping of a fence) has a thin roof: an edge higher than the ridge would turn the ends inside out.
    let thick = (0.1 + 0.5 * rise_m).min(0.22);
    let p = |q: DVec2, h: f64| q.extend(h);
    let uv = |x: f64, y: f64| DVec2::new(x, y);
    let slope = |a: DVec2, r: DVec2| (a.distance(r) * a.distance(r) + rise_m * rise_m).sqrt();
    let (low, eave) = (z - 0.1, z - 0.1 + thick);
    let (l, s) = (o[0].distance(o[1]), slope(o[0], m0));
    let long = |b: &mut MeshBuilder, a: DVec2, e: DVec2, re: DVec2, ra: DVec2| {
        b.fan(
            slot::ROOF,
            &[(p(a, eave), uv(0.0, 0.0)), (p(e, eave), uv(l, 0.0)), (p(re, top), uv(l, s)), (p(ra, top), uv(0.0, s))],
        );
    };
    long(b, o[0], o[1], r1, r0);
    long(b, o[2], o[3], r0, r1);
    let end_slot = if hip > 0.05 { slot::ROOF } else { slot::WALL };
    let w = o[1].distance(o[2]);
    for (a, e, r) in [(o[1], o[2], r1), (o[3], o[0], r0)] {
        b.fan(end_slot, &[(p(a, eave), uv(0.0, 0.0)), (p(e, eave), uv(w, 0.0)), (p(r, top), uv(w / 2.0, s))]);
    }
    b.band(slot::COPING, &o, low, eave, Wall::PLAIN, false);
    b.cap(slot::COPING, &o, low, false);
}
