//! Open ground: squares, parks, parking lots, yards that stand empty.

use super::ground;
use super::site::{Place, Rect, Work, corners, shrunk};
use crate::city::california::ground_slot as suburb;
use crate::city::california::lot::Plant;
use crate::city::california::paving::Layer;
use crate::city::toronto::ground_slot as slot;
use crate::kit::vehicles::Body;
use glam::DVec2;
use satseed_scene::Rng;

/// A square: beds in a pattern, palms in rows, water, benches left to the eye.
pub(super) fn square(work: &mut Work<'_>, place: &Place<'_>, r: Rect, rng: &mut Rng) {
    let frame = place.frame;
    let (wide, deep) = (r[1] - r[0], r[3] - r[2]);
    if wide < 8.0 || deep < 5.0 {
        return;
    }
    work.lay(Layer::Walk, &frame, &corners(shrunk(r, 0.3)), *rng.pick(&ground::SQUARES));
    let (nx, ny) =
        (libm::floor(wide / rng.range(9.0, 15.0)).max(1.0), libm::floor(deep / rng.range(8.0, 14.0)).max(1.0));
    let (px, py) = (wide / nx, deep / ny);
    let water = rng.below((nx * ny) as u64 + 2);
    let palms = rng.chance(0.6);
    let green = rng.chance(0.6);
    let bed = DVec2::new(rng.range(0.25, 0.4) * px, rng.range(0.22, 0.4) * py);
    for j in 0..ny as u64 {
        for i in 0..nx as u64 {
            let c = DVec2::new(r[0] + (i as f64 + 0.5) * px, r[2] + (j as f64 + 0.5) * py);
            let b = [c.x - bed.x, c.x + bed.x, c.y - bed.y, c.y + bed.y];
            if j * nx as u64 + i == water {
                work.lay(Layer::Coping, &frame, &corners(shrunk(b, -0.5)), suburb::COPING);
                work.lay(Layer::Water, &frame, &corners(b), suburb::POOL[1]);
                continue;
            }
            let slot =
                if green { suburb::TURF } else { *rng.pick(&[suburb::MULCH, suburb::FRONT[7], suburb::FRONT[1]]) };
            if rng.chance(0.75) {
                work.lay(Layer::Bed, &frame, &corners(b), slot);
                let plant = if palms { Plant::Palm } else { Plant::Broad };
                let size = rng.range(0.65, 1.05);
                if rng.chance((0.85 * work.params.trees).min(1.0)) {
                    work.plant(frame.world(c), plant, size);
                }
                work.strew(&frame, b, 9.0, [0.03, 0.02, 0.95], rng);
            }
        }
    }
}

/// A park: lawns worn at their edges, paths of decomposed granite, a round place, trees and palms.
pub(super) fn park(work: &mut Work<'_>, place: &Place<'_>, r: Rect, rng: &mut Rng) {
    let frame = place.frame;
    let c = DVec2::new(f64::midpoint(r[0], r[1]), f64::midpoint(r[2], r[3]));
    work.lay(Layer::Walk, &frame, &corners(shrunk(r, 2.2)), suburb::TURF);
    let half = DVec2::new((r[1] - r[0]) / 2.0, (r[3] - r[2]) / 2.0) - 2.2;
    let path = ground::of(slot::PATH);
    let width = rng.range(1.3, 2.2);
    for (along, reach) in [
        (DVec2::X, half.x),
        (DVec2::Y, half.y),
        (half.normalize(), half.length() - 1.5),
        ((half * DVec2::new(1.0, -1.0)).normalize(), half.length() - 1.5),
    ] {
        if along.x.abs() < 0.99 && along.y.abs() < 0.99 || rng.chance(0.6) {
            let strip = crate::kit::polygon::oriented_rectangle(c, along, DVec2::new(reach, width));
            work.lay(Layer::Bed, &frame, &strip, path);
        }
    }
    let radius = rng.range(9.0, 0.75 * half.min_element().max(12.1));
    work.lay(Layer::Drive, &frame, &super::fittings::round(c, radius, 32), *rng.pick(&ground::SQUARES));
    let pond = rng.chance(0.6);
    if pond {
        work.lay(Layer::Coping, &frame, &super::fittings::round(c, radius * 0.42 + 0.5, 24), suburb::COPING);
        work.lay(Layer::Water, &frame, &super::fittings::round(c, radius * 0.42, 24), suburb::POOL[1]);
    }
    // Palms in a ring, trees in groups over the lawns.
    let n = 10 + rng.below(8);
    for k in 0..n {
        let (s, co) = libm::sincos(core::f64::consts::TAU * k as f64 / n as f64);
        let size = rng.range(0.8, 1.1);
        if rng.chance((0.9 * work.params.trees).min(1.0)) {
            work.plant(frame.world(c + DVec2::new(co, s) * (radius - 1.2)), Plant::Palm, size);
        }
    }
    let centre = frame.world(c);
    let before = work.out.plants.len();
    work.strew(&frame, shrunk(r, 3.0), 0.9, [0.66, 0.26, 0.08], rng);
    let mut k = 0;
    work.out.plants.retain(|p| {
        k += 1;
        k <= before || p.at.distance(centre) > radius + 1.0
    });
}

/// A parking lot over a site.
pub(super) fn lot(work: &mut Work<'_>, place: &Place<'_>, r: Rect) {
    let mut rng = place.key.child("lot").rng();
    work.floor(place, ground::YARDS[rng.below(2) as usize]);
    let occupancy = rng.range(0.3, 0.8);
    // Rows run along the longer side.
    let frame = place.frame;
    if r[1] - r[0] >= r[3] - r[2] {
        work.parking(&frame, shrunk(r, 0.4), occupancy, &place.key);
    } else {
        let turned = crate::city::toronto::massing::Frame { centre: frame.centre, axis: frame.axis.perp() };
        work.parking(&turned, shrunk([r[2], r[3], -r[1], -r[0]], 0.4), occupancy, &place.key);
    }
    if rng.chance(0.5) {
        // The attendant's booth is a van more often than not.
        work.car(&frame, DVec2::new(r[1] - 3.0, r[3] - 1.6), DVec2::X, Body::Van);
    }
}

/// A cleared site: dirt with weeds, what is left of a slab, a few cars.
pub(super) fn cleared(work: &mut Work<'_>, place: &Place<'_>, r: Rect) {
    let mut rng = place.key.child("cleared").rng();
    work.floor(place, ground::YARDS[3]);
    let frame = place.frame;
    for _ in 0..2 + rng.below(3) {
        let c = DVec2::new(rng.range(r[0], r[1]), rng.range(r[2], r[3]));
        let half = DVec2::new(rng.range(2.0, 9.0), rng.range(2.0, 7.0));
        let b =
            [(c.x - half.x).max(r[0]), (c.x + half.x).min(r[1]), (c.y - half.y).max(r[2]), (c.y + half.y).min(r[3])];
        work.lay(
            Layer::Walk,
            &frame,
            &corners(b),
            *rng.pick(&[ground::YARDS[2], ground::of(slot::YARD), ground::YARDS[0]]),
        );
    }
    work.strew(&frame, r, 1.2, [0.05, 0.03, 0.92], &mut rng);
    for _ in 0..rng.below(5) {
        let at = DVec2::new(rng.range(r[0] + 3.0, r[1] - 3.0), rng.range(r[2] + 3.0, r[3] - 3.0));
        let (s, c) = libm::sincos(rng.range(0.0, 6.3));
        let body = *rng.pick(&[Body::Truck, Body::Pickup, Body::Van]);
        work.car(&frame, at, DVec2::new(c, s), body);
    }
}
