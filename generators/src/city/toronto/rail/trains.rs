//! Trains: two-level and single-level coaches, locomotives, freight cars, as closed bodies on bogies, and where they stand or
//! run.
//!
//! x is forward, z = 0 the top of the rails. Sizes after the Canadian types: two-level coaches of 25.9 x 3.0 x 4.9 m, single-level
//! ones of 26 x 3.05 x 4.2 m, locomotives of 20.7 x 3.1 x 4.7 m, freight cars of 13 to 18 m.

use super::{Corridor, DEPTH_M, RAIL_M};
use crate::city::toronto::relief::Swells;
use crate::kit::mesh_builder::{MeshBuilder, Wall};
use crate::kit::polygon;
use glam::{DAffine3, DMat3, DVec2, DVec3};
use satseed_scene::{Mesh, Rng};

/// Slots of a car's mesh.
pub(in super::super) mod slot {
    pub(in super::super::super) const BODY: u16 = 0;
    pub(in super::super::super) const STRIPE: u16 = 1;
    pub(in super::super::super) const WINDOW: u16 = 2;
    pub(in super::super::super) const ROOF: u16 = 3;
    pub(in super::super::super) const UNDER: u16 = 4;
    pub(in super::super::super) const COUNT: usize = 5;
}

/// Kinds of cars.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Body {
    /// Two-level commuter coach.
    Bilevel,
    /// The same with a driver's cab.
    Cab,
    /// Single-level coach.
    Coach,
    /// Passenger locomotive.
    Locomotive,
    /// Covered goods car.
    Boxcar,
    /// Tank car.
    Tank,
    /// Covered hopper.
    Hopper,
    /// Flat car with a container.
    Flat,
}

/// A car on the rails.
#[derive(Clone, Debug)]
pub(in super::super) struct Car {
    pub(in super::super) name: String,
    pub(in super::super) body: Body,
    /// Which of its train's colours.
    pub(in super::super) livery: u64,
    pub(in super::super) world_from_object: DAffine3,
}

/// Between the ends of two coupled cars, m.
const COUPLING_M: f64 = 0.75;

impl Body {
    pub(in super::super) const ALL: [Self; 8] =
        [Self::Bilevel, Self::Cab, Self::Coach, Self::Locomotive, Self::Boxcar, Self::Tank, Self::Hopper, Self::Flat];

    fn length_m(self) -> f64 {
        match self {
            Self::Bilevel | Self::Cab => 25.9,
            Self::Coach => 26.0,
            Self::Locomotive => 20.7,
            Self::Boxcar => 16.8,
            Self::Tank => 14.2,
            Self::Hopper => 17.6,
            Self::Flat => 15.4,
        }
    }

    /// Its mesh.
    pub(in super::super) fn mesh(self) -> Mesh {
        let mut b = MeshBuilder::default();
        let half = self.length_m() / 2.0;
        match self {
            Self::Bilevel => bilevel(&mut b, half),
            Self::Cab => {
                bilevel(&mut b, half);
                let cab = polygon::rectangle(DVec2::new(half - 0.5, -1.1), DVec2::new(half + 0.03, 1.1));
                b.prism(slot::WINDOW, slot::STRIPE, &cab, 2.2, 3.2, Wall::PLAIN);
            }
            Self::Coach => {
                let hull = hull(half, 1.52);
                b.prism(slot::BODY, slot::UNDER, &hull, 0.95, 3.5, Wall::PLAIN);
                b.frustum(slot::ROOF, slot::ROOF, &hull, &polygon::mitred(&hull, 0.5), 3.45, 4.2);
                band(&mut b, half - 2.2, 1.535, [1.9, 2.75], slot::WINDOW);
                band(&mut b, half - 0.1, 1.53, [1.1, 1.45], slot::STRIPE);
                for x in [-half + 3.0, half - 3.0] {
                    b.block(slot::ROOF, slot::UNDER, DVec2::new(x, 0.0), DVec2::X, DVec2::new(1.3, 0.7), 4.0, 4.34);
                }
                bogies(&mut b, half - 3.6);
            }
            Self::Locomotive => locomotive(&mut b, half),
            Self::Boxcar => {
                let hull = hull(half, 1.5);
                b.prism(slot::BODY, slot::UNDER, &hull, 1.05, 4.3, Wall::PLAIN);
                b.frustum(slot::ROOF, slot::ROOF, &hull, &polygon::mitred(&hull, 0.9), 4.28, 4.52);
                for k in -6..=6 {
                    let x = f64::from(k) * half / 6.6;
                    b.block(slot::ROOF, slot::ROOF, DVec2::new(x, 0.0), DVec2::X, DVec2::new(0.06, 1.3), 4.3, 4.56);
                    b.block(slot::BODY, slot::BODY, DVec2::new(x, 0.0), DVec2::X, DVec2::new(0.07, 1.56), 1.1, 4.2);
                }
                b.block(slot::STRIPE, slot::STRIPE, DVec2::ZERO, DVec2::X, DVec2::new(1.5, 1.6), 1.15, 4.1);
                bogies(&mut b, half - 2.4);
            }
            Self::Tank => {
                let axis = |x: f64| DVec3::new(x, 0.0, 2.75);
                b.limb(slot::BODY, axis(-half + 0.9), axis(half - 0.9), [1.45; 2], 14);
                for way in [-1.0, 1.0] {
                    b.limb(slot::BODY, axis(way * (half - 1.0)), axis(way * (half - 0.45)), [1.4, 0.75], 14);
                }
                b.prism(
                    slot::UNDER,
                    slot::UNDER,
                    &polygon::oriented_rectangle(DVec2::ZERO, DVec2::X, DVec2::new(half, 0.45)),
                    0.95,
                    1.4,
                    Wall::PLAIN,
                );
                b.block(slot::STRIPE, slot::UNDER, DVec2::ZERO, DVec2::X, DVec2::new(0.55, 0.55), 4.0, 4.6);
                b.block(slot::UNDER, slot::UNDER, DVec2::ZERO, DVec2::X, DVec2::new(1.6, 1.1), 4.05, 4.15);
                bogies(&mut b, half - 2.1);
            }
            Self::Hopper => {
                let top = hull(half - 0.2, 1.55);
                let bottom = hull(half - 2.9, 1.2);
                b.frustum(slot::BODY, slot::UNDER, &bottom, &top, 1.0, 2.5);
                b.prism(slot::BODY, slot::UNDER, &top, 2.45, 4.15, Wall::PLAIN);
                b.frustum(slot::ROOF, slot::ROOF, &top, &polygon::mitred(&top, 0.75), 4.1, 4.5);
                // Hatches between the running boards.
                for k in 0..9 {
                    let x = (f64::from(k) - 4.0) * (half - 1.2) / 4.5;
                    b.block(slot::STRIPE, slot::STRIPE, DVec2::new(x, 0.0), DVec2::X, DVec2::new(0.5, 0.42), 4.4, 4.66);
                }
                b.block(slot::UNDER, slot::UNDER, DVec2::ZERO, DVec2::X, DVec2::new(half, 0.4), 0.95, 1.25);
                bogies(&mut b, half - 1.9);
            }
            Self::Flat => {
                b.block(slot::UNDER, slot::UNDER, DVec2::ZERO, DVec2::X, DVec2::new(half, 1.4), 0.95, 1.3);
                let x = 12.2 / 2.0;
                let wide = polygon::rectangle(DVec2::new(-x, -1.22), DVec2::new(x, 1.22));
                b.prism(slot::BODY, slot::ROOF, &wide, 1.25, 3.95, Wall::PLAIN);
                for k in 0..10 {
                    let at = DVec2::new((f64::from(k) - 4.5) * 1.2, 0.0);
                    b.block(slot::ROOF, slot::ROOF, at, DVec2::X, DVec2::new(0.12, 1.1), 3.9, 3.99);
                }
                bogies(&mut b, half - 2.2);
            }
        }
        // Couplers reach to the middle of the gap, the lower half from this side.
        for way in [-1.0, 1.0] {
            let at = DVec2::new(way * half, 0.0);
            b.block(slot::UNDER, slot::UNDER, at, DVec2::X, DVec2::new(COUPLING_M / 2.0 - 0.01, 0.14), 0.85, 1.1);
        }
        b.finish()
    }
}

fn hull(half_m: f64, side_m: f64) -> Vec<DVec2> {
    polygon::rounded(&polygon::rectangle(DVec2::new(-half_m, -side_m), DVec2::new(half_m, side_m)), 0.25, 1)
}

/// A band around a hull, a little proud of it.
fn band(b: &mut MeshBuilder, half_m: f64, side_m: f64, [low, high]: [f64; 2], slot: u16) {
    b.block(slot, slot, DVec2::ZERO, DVec2::X, DVec2::new(half_m, side_m), low, high);
}

/// A two-level coach: full height between the bogies, its roof and floor tapering towards the ends.
fn bilevel(b: &mut MeshBuilder, half: f64) {
    let side = 1.5;
    let body = hull(half, side);
    b.prism(slot::STRIPE, slot::UNDER, &body, 0.9, 1.75, Wall::PLAIN);
    b.prism(slot::BODY, slot::UNDER, &polygon::mitred(&body, 0.01), 1.7, 3.75, Wall::PLAIN);
    let long = polygon::mitred(&body, 0.03);
    let top: Vec<DVec2> = long.iter().map(|p| DVec2::new(p.x * 0.82, p.y * 0.72)).collect();
    b.frustum(slot::ROOF, slot::ROOF, &long, &top, 3.7, 4.87);
    // The lower floor between the bogies.
    let low = polygon::rectangle(DVec2::new(-half + 5.6, -side + 0.02), DVec2::new(half - 5.6, side - 0.02));
    b.frustum(slot::STRIPE, slot::UNDER, &polygon::mitred(&low, 0.12), &low, 0.32, 1.0);
    band(b, half - 6.4, side + 0.012, [1.05, 1.65], slot::WINDOW);
    band(b, half - 6.0, side + 0.014, [2.75, 3.45], slot::WINDOW);
    for way in [-1.0, 1.0] {
        let x = way * (half - 2.9);
        b.block(slot::WINDOW, slot::WINDOW, DVec2::new(x, 0.0), DVec2::X, DVec2::new(1.1, side + 0.016), 2.0, 2.75);
        b.block(slot::ROOF, slot::UNDER, DVec2::new(way * 6.0, 0.0), DVec2::X, DVec2::new(1.6, 0.75), 4.6, 5.02);
    }
    bogies(b, half - 3.4);
}

/// A passenger locomotive with a cab at its front, fans and vents on its roof.
fn locomotive(b: &mut MeshBuilder, half: f64) {
    let side = 1.52;
    let body = polygon::rectangle(DVec2::new(-half, -side), DVec2::new(half - 2.6, side));
    b.prism(slot::BODY, slot::UNDER, &body, 1.0, 4.0, Wall::PLAIN);
    b.frustum(slot::ROOF, slot::ROOF, &body, &polygon::mitred(&body, 0.55), 3.95, 4.55);
    let nose = polygon::rectangle(DVec2::new(half - 2.8, -side + 0.01), DVec2::new(half, side - 0.01));
    let brow = polygon::rectangle(DVec2::new(half - 2.7, -side + 0.3), DVec2::new(half - 1.7, side - 0.3));
    b.prism(slot::STRIPE, slot::UNDER, &nose, 0.7, 2.3, Wall::PLAIN);
    b.frustum(slot::STRIPE, slot::STRIPE, &nose, &brow, 2.25, 4.2);
    let pane = |p: &[DVec2]| p.iter().map(|c| *c + DVec2::new(0.06, 0.0)).collect::<Vec<_>>();
    let upright = |x: f64| polygon::rectangle(DVec2::new(x - 0.6, -1.15), DVec2::new(x, 1.15));
    b.frustum(slot::WINDOW, slot::WINDOW, &pane(&upright(half - 0.62)), &pane(&upright(half - 1.2)), 2.85, 3.55);
    band(b, half - 2.7, side + 0.01, [1.15, 1.7], slot::STRIPE);
    for (k, x) in [-half + 2.2, -half + 4.6, 1.0, 4.0].into_iter().enumerate() {
        let r = if k < 2 { 0.85 } else { 0.6 };
        let disc =
            polygon::rounded(&polygon::oriented_rectangle(DVec2::new(x, 0.0), DVec2::X, DVec2::splat(r)), r * 0.8, 2);
        b.prism(slot::ROOF, slot::UNDER, &disc, 4.4, 4.68, Wall::PLAIN);
    }
    b.block(slot::UNDER, slot::UNDER, DVec2::new(-2.0, 0.0), DVec2::X, DVec2::new(1.4, 0.5), 4.4, 4.64);
    b.block(slot::UNDER, slot::UNDER, DVec2::new(-0.4, 0.0), DVec2::X, DVec2::new(2.6, 1.35), 0.35, 1.05);
    bogies(b, half - 3.7);
}

/// Two bogies with two axles each, and a frame between them.
fn bogies(b: &mut MeshBuilder, at_m: f64) {
    for way in [-1.0, 1.0] {
        let x = way * at_m;
        for side in [-1.0, 1.0] {
            let beam = DVec2::new(x, side * 0.98);
            b.block(slot::UNDER, slot::UNDER, beam, DVec2::X, DVec2::new(1.5, 0.1), 0.32, 0.75);
            for axle in [-0.95, 0.95] {
                let wheel = |y: f64| DVec3::new(x + axle, side * y, 0.44);
                let (from, to) = if side > 0.0 { (0.69, 0.82) } else { (0.82, 0.69) };
                b.limb(slot::UNDER, wheel(from), wheel(to), [0.455; 2], 10);
            }
        }
        b.block(slot::UNDER, slot::UNDER, DVec2::new(x, 0.0), DVec2::X, DVec2::new(0.5, 1.05), 0.5, 1.0);
    }
    b.block(slot::UNDER, slot::UNDER, DVec2::ZERO, DVec2::X, DVec2::new(at_m, 0.3), 0.7, 1.02);
}

/// The cars of one train, from its front, and its colours.
fn train(freight: bool, rng: &mut Rng) -> (Vec<Body>, u64) {
    if freight {
        let mut cars = Vec::new();
        // Cars of a kind come in blocks.
        while cars.len() < 34 {
            let kind = *rng.pick(&[Body::Boxcar, Body::Tank, Body::Hopper, Body::Hopper, Body::Flat, Body::Flat]);
            cars.extend((0..=rng.below(7)).map(|_| kind));
        }
        return (cars, 2);
    }
    if rng.chance(0.8) {
        let mut cars = vec![Body::Locomotive];
        let coaches = 5 + rng.below(6);
        cars.extend((0..coaches).map(|_| Body::Bilevel));
        cars.push(Body::Cab);
        return (cars, rng.below(2));
    }
    let mut cars = vec![Body::Locomotive];
    cars.extend((0..4 + rng.below(4)).map(|_| Body::Coach));
    (cars, 3)
}

/// All cars whose middle lies within a distance of the pivot. Each track has its own trains.
pub(in super::super) fn consists(corridor: &Corridor, relief: &Swells, share: f64, reach_m: f64) -> Vec<Car> {
    let mut out = Vec::new();
    let last = corridor.tracks.len() - 1;
    let freight_side = corridor.key.child("freight").rng().chance(0.6);
    for (t, track) in corridor.tracks.iter().enumerate() {
        let mut rng = corridor.key.child("trains").index(t as u64).rng();
        // Sidings are for trains that wait; through tracks have one now and then.
        let siding = track.span_m[0] > -1000.0;
        let wanted = if siding { 0.72 } else { 0.44 } * share;
        let [from, to] = track.span_m;
        let mut at = from + 8.0 + rng.range(0.0, if siding { 30.0 } else { 420.0 });
        let mut number = 0;
        while at < to - 8.0 {
            let freight = freight_side && t == last && !siding;
            let (cars, livery) = train(freight, &mut rng);
            let length: f64 = cars.iter().map(|c| c.length_m() + COUPLING_M).sum();
            let fits = siding && at + length > to - 8.0;
            let stands = rng.chance(wanted);
            let forward = if rng.chance(0.5) { 1.0 } else { -1.0 };
            let left = rng.range(25.0, if siding { 60.0 } else { 500.0 });
            if stands && !fits {
                let mut front = at;
                for (k, body) in cars.iter().enumerate() {
                    let middle = front + body.length_m() / 2.0;
                    front += body.length_m() + COUPLING_M;
                    // Counted from the end that the train points to.
                    let along = if forward > 0.0 { at + length - (middle - at) } else { middle };
                    let place = corridor.line.at(along, track.left_m);
                    if place.length() < reach_m {
                        out.push(Car {
                            name: format!("rail/track/{t}/train/{number}/car/{k}"),
                            body: *body,
                            livery,
                            world_from_object: on_rails(
                                corridor,
                                relief,
                                along,
                                track.left_m,
                                forward,
                                body.length_m(),
                            ),
                        });
                    }
                }
            }
            at += length + left;
            number += 1;
        }
    }
    out
}

/// The frame of a car on a track, leaning along it as the ground does.
fn on_rails(corridor: &Corridor, relief: &Swells, along: f64, left: f64, forward: f64, length_m: f64) -> DAffine3 {
    let bogie = 0.36 * length_m;
    let height = |s: f64| relief.height_m(corridor.line.at(s, left)) - DEPTH_M + RAIL_M - 0.012;
    let (rear, front) = (height(along - bogie), height(along + bogie));
    let d = corridor.line.direction;
    let x = (d.extend((front - rear) / (2.0 * bogie)) * forward).normalize();
    let y = (d.perp() * forward).extend(0.0);
    let columns = DMat3::from_cols(x, y, x.cross(y));
    let at = corridor.line.at(along, left).extend(f64::midpoint(rear, front));
    DAffine3::from_mat3_translation(columns, at)
}
