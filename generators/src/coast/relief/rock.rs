//! Rock: cliffs in beds and joints, platforms, reefs and stacks.

use super::{Relief, Surface, offing_m, soft_min};
use crate::coast::shore::Place;
use crate::kit::scatter::Cell;
use crate::kit::terrain::noise::{blocks, fractal, ridged};
use crate::kit::terrain::sampling::smoothstep;
use glam::DVec2;

/// Side of the cells in which at most one stack stands, m.
const STACK_CELL_M: f64 = 46.0;

/// A cliff as a place before, on or behind it sees it.
pub(super) struct Cliff {
    /// What joints set it back by at its place: -1 to 1.
    block: f64,
    /// Height of the platform before it, m.
    pub(super) platform_m: f64,
    /// Distance beyond its foot, m; negative before it.
    pub(super) beyond_m: f64,
}

impl Relief {
    /// Height of the cliff's top, m.
    pub(in super::super) fn top_m(&self, p: DVec2) -> f64 {
        self.land_height_m * (0.80 + 0.62 * fractal(p, self.seeds.hills, 520.0, 2, 0.5)).clamp(0.35, 1.35)
    }

    pub(super) fn cliff(&self, p: DVec2, place: &Place) -> Cliff {
        let f = &self.form;
        let sandy = smoothstep(0.15, 0.85, place.sandy);
        // Joints set the face back in blocks; gullies in tens of metres.
        let (block, _) = blocks(p, self.seeds.joints, 5.5);
        let jag = self.roughness * (6.0 * fractal(p, self.seeds.face, 46.0, 5, 0.55) + 0.9 * block);
        let d = place.inland_m + jag * (1.0 - 0.6 * sandy);
        let low = if sandy > 0.0 { self.beach_m(p, place) } else { 0.0 };
        let rock = self.bottom_m(p, place, d);
        let foot_m = 4.0
            + 6.0 * (fractal(p, self.seeds.platform ^ 1, 70.0, 2, 0.5) + 0.3).max(0.0)
            + sandy * (0.75 * f.berm_m / f.foreshore + 9.0 * fractal(p, self.seeds.platform ^ 2, 45.0, 4, 0.6));
        Cliff { block, platform_m: rock + (low - rock) * sandy, beyond_m: d - foot_m }
    }

    pub(super) fn rocky_m(&self, p: DVec2, place: &Place) -> f64 {
        let f = &self.form;
        let rough = self.roughness;
        let sandy = smoothstep(0.15, 0.85, place.sandy);
        let Cliff { block, platform_m: base, beyond_m: beyond } = self.cliff(p, place);
        if beyond < -1.0 {
            return base;
        }
        let top_m = self.top_m(p) * (1.0 - 0.45 * sandy);
        let wide_m = (0.34 + 0.10 * block + 1.15 * sandy) * top_m + 2.0;
        let climb = soft_min(beyond.max(0.0) / wide_m, 1.0, 0.06) * top_m;
        // Beds: a tread and a riser each.
        let bed = (climb + p.dot(f.dip)) / f.bed_m + 0.5 * fractal(p, self.seeds.face ^ 5, 30.0, 2, 0.5);
        let t = bed - libm::floor(bed);
        let stepped = (libm::floor(bed) + smoothstep(0.42, 0.92, t)) * f.bed_m
            - 0.5 * f.bed_m * fractal(p, self.seeds.face ^ 5, 30.0, 2, 0.5)
            - p.dot(f.dip);
        let on_face = smoothstep(0.02, 0.12, climb / top_m)
            * smoothstep(0.995, 0.90, climb / top_m)
            * (1.0 - sandy)
            * smoothstep(-0.35, 0.25, fractal(p, self.seeds.joints ^ 9, 24.0, 3, 0.6));
        let face =
            climb + (stepped - climb) * on_face + rough * on_face * 0.55 * fractal(p, self.seeds.fine, 3.2, 4, 0.6);
        let inland = (beyond - wide_m).max(0.0);
        let land = smoothstep(0.0, 30.0, inland)
            * (0.12 * self.land_height_m * fractal(p, self.seeds.rolling, 190.0, 4, 0.45)
                + 0.16 * rough * fractal(p, self.seeds.fine ^ 5, 9.0, 4, 0.5)
                - 0.5 * rough * self.damp(p))
            + 0.035 * inland.min(420.0);
        base.max(0.3 * sandy) + face + land - 0.10 * self.track(p, place)
    }

    /// Rock below and around the waterline: bottom, reefs, platform and stacks.
    fn bottom_m(&self, p: DVec2, place: &Place, d: f64) -> f64 {
        let rough = self.roughness.max(0.25);
        let y = (-d).max(0.0);
        let mut z = offing_m(&self.form, true, &Place { inland_m: d, ..*place });
        let near = smoothstep(120.0, 6.0, y);
        let reefs = ridged(p, self.seeds.reefs, 44.0, 5, 0.55);
        z += rough * near * (3.4 * (reefs - 0.1).max(-0.3) + 0.5 * fractal(p, self.seeds.fine, 7.0, 4, 0.6));
        // Platforms that the sea has planed, awash.
        let wide = 20.0 * smoothstep(-0.1, 0.4, fractal(p, self.seeds.platform, 120.0, 3, 0.5));
        let plane = 0.35 - 0.03 * y
            + rough
                * (0.42 * fractal(p, self.seeds.platform ^ 3, 8.0, 4, 0.6)
                    + 0.2 * blocks(p, self.seeds.joints ^ 3, 2.6).0);
        z += (plane.max(z) - z) * smoothstep(wide, wide - 5.0, y) * f64::from(wide > 1.0);
        // Boulders and shelves at the foot.
        if d > -6.0 {
            z = z.max(-1.1 + 0.28 * (d + 6.0) + rough * 0.5 * fractal(p, self.seeds.fine ^ 1, 4.0, 4, 0.6)).min(2.2);
        }
        let cell = |x: f64| libm::floor(x / STACK_CELL_M) as i32;
        for dj in -1..=1 {
            for di in -1..=1 {
                z = z.max(self.stack_m(p, Cell { at: (cell(p.x) + di, cell(p.y) + dj), side_m: STACK_CELL_M }));
            }
        }
        z
    }

    /// Height of a cell's stack at a place, far down where it has none.
    fn stack_m(&self, p: DVec2, cell: Cell) -> f64 {
        if cell.draw(self.seeds.joints ^ 0x4d) > 0.22 {
            return -1e3;
        }
        let mut rng = cell.key(&self.stacks).rng();
        let at = cell.point(rng.range(0.25, 0.75), rng.range(0.25, 0.75));
        // Sizes differ five times; the beds' strike draws them out, and the tops dip as the beds do.
        let (radius, share) = (1.9 * libm::pow(5.0, rng.unit()), rng.range(0.1, 0.8));
        let long = rng.range(1.15, 1.75);
        let turn = 0.5 * rng.signed();
        if p.distance(at) > long * radius + 16.0 {
            return -1e3;
        }
        let dips = (self.form.dip.normalize() + self.form.dip.perp().normalize() * turn).normalize();
        let [across, strike] = [(p - at).dot(dips), (p - at).dot(dips.perp())];
        let apart = DVec2::new(across * long, strike / long).length();
        let place = self.shore.at(at);
        if place.inland_m > -long * radius - 6.0 || place.inland_m < -75.0 || place.sandy > 0.35 {
            return -1e3;
        }
        let top = 1.0 + share * share * self.top_m(at);
        let (block, _) = blocks(p, self.seeds.joints, 3.7);
        let r = apart + self.roughness.max(0.3) * (3.0 * fractal(p, self.seeds.face ^ 2, 14.0, 4, 0.6) + 0.7 * block);
        let z = top - 0.26 * r - 3.2 * (r - 0.66 * radius).max(0.0) - 0.30 * across.clamp(-radius, radius);
        let bed = (z + p.dot(self.form.dip)) / self.form.bed_m;
        let stepped =
            (libm::floor(bed) + smoothstep(0.5, 0.95, bed - libm::floor(bed))) * self.form.bed_m - p.dot(self.form.dip);
        z + 0.7 * (stepped - z)
    }

    /// Whether dry ground is rock: steep, or low before a rocky shore.
    pub(in super::super) fn is_rock(&self, s: &Surface, up: f64) -> bool {
        self.cliffs && (up < 0.80 || (s.place.sandy < 0.5 && s.place.inland_m < 9.0))
    }
}
