//! The land beside an interchange: a yard with shops at its far end, and what is left to itself before the ramps.

use super::ground_slot as slot;
use super::lot::{Kind, Plant};
use super::paving::Layer;
use super::slabs::{Site, any_tree};
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::Rng;

impl Site<'_> {
    /// Open land below ramps, and a large shop with its parking where the ramps are far enough.
    pub(super) fn junction(&mut self) {
        let size = self.size();
        let key = self.slab.key;
        let mut rng = key.rng();
        // u by its distance from the interchange.
        let far = self.slab.junction_far;
        let span = |a: f64, b: f64| if far { [size.x - b, size.x - a] } else { [a, b] };
        let start = 236.0;
        if size.x - start > 60.0 {
            let [u0, u1] = span(start, size.x - 0.2);
            self.lay(Layer::Yard, &Self::rect(u0, u1, 8.0, size.y - 0.2), slot::YARD_ASPHALT);
            let wide = (u1 - u0 - 16.0).min(70.0);
            let [b0, b1] = [u0 + 6.0, u0 + 6.0 + wide];
            self.flat(
                "shop/0",
                Kind::Shop,
                [b0, b1, size.y - 62.0, size.y - 12.0],
                rng.range(7.5, 10.0),
                &key.child("shop"),
            );
            self.parking([u0 + 4.0, u1 - 4.0, 60.0, size.y - 68.0], rng.range(0.35, 0.7), &key.child("parking"));
            self.flat("pad/0", Kind::Shop, [b0 + 4.0, b0 + 30.0, 24.0, 44.0], rng.range(4.6, 6.0), &key.child("pad"));
        }
        let [u0, u1] = span(4.0, start - 6.0);
        self.wild([u0, u1, 2.0, size.y - 4.0], &mut rng);
    }

    /// Land that is left to itself, from bare to wooded: swards in several states, a dirt track, thickets.
    fn wild(&mut self, [u0, u1, v0, v1]: [f64; 4], rng: &mut Rng) {
        let size = DVec2::new(u1 - u0, v1 - v0);
        let anywhere = |rng: &mut Rng| DVec2::new(u0 + size.x * rng.unit(), v0 + size.y * rng.unit());
        for _ in 0..rng.below(7) {
            let (at, reach) = (anywhere(rng), rng.range(14.0, 55.0));
            let corners = 11;
            let blob: Vec<DVec2> = (0..corners)
                .map(|k| {
                    let (s, c) = libm::sincos(core::f64::consts::TAU * f64::from(k) / f64::from(corners));
                    let p = at + DVec2::new(c, s) * reach * rng.range(0.55, 1.0);
                    p.clamp(DVec2::new(u0, v0 + 2.0), DVec2::new(u1, v1))
                })
                .collect();
            if polygon::area(&blob) > 100.0 {
                let state = *rng.pick(&[slot::FRONT[3], slot::FRONT[4], slot::FRONT[5], slot::REAR[3]]);
                self.lay(Layer::Yard, &blob, state);
            }
        }
        if rng.chance(0.6) {
            // From the far side towards the ramps, as who mows it drives.
            let (from, to) = (rng.range(0.1, 0.9), rng.range(0.1, 0.9));
            let (a, b) = (DVec2::new(u0 + size.x * from, v1), DVec2::new(u0 + size.x * to, v0 + 0.25 * size.y));
            let bow = rng.signed() * 25.0;
            let side = (b - a).normalize().perp();
            let line: Vec<DVec2> = (0..=12)
                .map(|k| {
                    let t = f64::from(k) / 12.0;
                    a.lerp(b, t) + side * bow * 4.0 * t * (1.0 - t)
                })
                .map(|p| p.clamp(DVec2::new(u0 + 2.0, v0 + 4.0), DVec2::new(u1 - 2.0, v1)))
                .collect();
            let mut track: Vec<DVec2> = line.iter().map(|p| *p + side * 1.5).collect();
            track.extend(line.iter().rev().map(|p| *p - side * 1.5));
            if polygon::area(&track) < 0.0 {
                track.reverse();
            }
            self.lay(Layer::Front, &track, slot::REAR[6]);
        }
        let thickets: Vec<(DVec2, f64)> =
            (0..2 + rng.below(5)).map(|_| (anywhere(rng), rng.range(6.0, 26.0))).collect();
        let trees = *rng.pick(&[20, 50, 90, 150]);
        let shrubs = rng.range(150.0, 900.0);
        for (count, tree) in [(f64::from(trees), true), (shrubs, false)] {
            for _ in 0..libm::floor(count * self.params.trees) as u32 {
                let (middle, reach) = *rng.pick(&thickets);
                let near = rng.chance(0.65);
                let beside = DVec2::new(rng.normal(), rng.normal()) * reach;
                let p = if near { middle + beside } else { anywhere(rng) };
                let kind = any_tree(rng);
                let plant = if tree { kind } else { Plant::Shrub };
                let size = if tree { rng.range(0.6, 1.5) } else { libm::exp(0.45 * rng.normal()).clamp(0.5, 2.4) };
                if (u0..u1).contains(&p.x) && (v0..v1).contains(&p.y) {
                    self.tree(p.x, p.y, plant, size);
                }
            }
        }
    }
}
