//! Under and between the trees: bushes, ferns, fallen stems, stumps, heaps of brush.

use super::growth::Growth;
use super::land::Land;
use super::plant::leaves;
use super::stands::{Kind as StandKind, Stands};
use crate::kit::scatter::{Cell, Kind, Placed, add, lowest, place, variation};
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::sampling::smoothstep;
use crate::kit::terrain::tin::Ground;
use crate::kit::woods;
use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};
use satseed_scene::{Bands, Class, Field, Layer, Material, Mesh, Rng, Scene, SeedPath, quantise_m};

/// Different meshes of each kind.
const VARIANTS: usize = 16;

struct Floor<'a> {
    land: &'a Land,
    stands: &'a Stands,
    growth: &'a Growth,
}

/// What decides what grows at a place.
struct Place {
    light: f64,
    wet: f64,
    /// How far inside a gap or clearing, m; negative outside.
    open_m: f64,
    cut: bool,
    along: DVec2,
    /// Whether ways and water leave it free.
    free: bool,
}

impl Floor<'_> {
    fn at(&self, p: DVec2) -> Place {
        let stand = self.stands.at(p);
        let track = self.land.track.beyond_m(p);
        Place {
            light: self.growth.light(p),
            wet: self.land.wetness(p),
            open_m: -self.stands.outside_m(p),
            cut: stand.kind == StandKind::Cut,
            along: stand.along,
            free: track > 1.3 && self.land.rides.beyond_m(p) > 0.3 && self.land.streams.beyond_m(p) > 0.3,
        }
    }

    /// Something of a size on the ground, its foot in it.
    fn planted(&self, p: DVec2, scale: DVec3, mesh: u64, path: String, rng: &mut Rng) -> Placed {
        let base = f64::from(quantise_m(lowest(self.land, p, 0.25 * scale.x))) - 0.04;
        let turn = DMat3::from_rotation_z(rng.range(0.0, core::f64::consts::TAU));
        let lean = DVec3::new(rng.signed(), rng.signed(), 0.0) * 0.08;
        let tilt = DMat3::from_quat(DQuat::from_rotation_arc(DVec3::Z, (DVec3::Z + lean).normalize()));
        Placed {
            at_m: p,
            world_from_object: DAffine3::from_mat3_translation(
                tilt * turn * DMat3::from_diagonal(scale),
                p.extend(base),
            ),
            variation: variation(rng),
            mesh: mesh as u32,
            path,
        }
    }

    fn bush(&self, path: &SeedPath, cell: Cell) -> Option<Placed> {
        let seed = path.hash_u32();
        let draw = cell.draw(seed);
        if draw > 0.5 {
            return None;
        }
        let mut rng = cell.key(path).rng();
        let p = cell.point(rng.unit(), rng.unit());
        let here = self.at(p);
        let groups = smoothstep(-0.25, 0.35, fractal(p, seed, 17.0, 3, 0.6));
        let edge = smoothstep(3.5, 0.5, (here.open_m - 0.5).abs());
        let share = if here.cut { 0.20 * groups } else { groups * (0.05 + 0.42 * here.light * (0.25 + edge)) + 0.02 };
        if draw > share || !here.free {
            return None;
        }
        let height = rng.lognormal(if here.light > 0.4 { 1.25 } else { 1.7 }, 0.35).clamp(0.5, 3.2);
        let scale = DVec3::new(rng.range(0.9, 1.35), rng.range(0.8, 1.2), 1.0) * height;
        Some(self.planted(p, scale, rng.below(VARIANTS as u64), cell.name("bush"), &mut rng))
    }

    fn fern(&self, path: &SeedPath, cell: Cell) -> Option<Placed> {
        let seed = path.hash_u32();
        let draw = cell.draw(seed);
        if draw > 0.5 {
            return None;
        }
        let mut rng = cell.key(path).rng();
        let p = cell.point(rng.unit(), rng.unit());
        let here = self.at(p);
        let groups = smoothstep(-0.05, 0.3, fractal(p, seed, 13.0, 3, 0.6) + 0.2 * (here.wet - 0.4));
        let share = groups * (0.03 + 0.45 * here.light) * if here.cut { 0.7 } else { 1.0 };
        if draw > share || !here.free {
            return None;
        }
        let size = rng.range(0.8, 1.5);
        let scale = DVec3::new(size, size, size * rng.range(0.7, 1.1));
        Some(self.planted(p, scale, rng.below(VARIANTS as u64), cell.name("fern"), &mut rng))
    }

    fn stump(&self, path: &SeedPath, cell: Cell) -> Option<Placed> {
        let draw = cell.draw(path.hash_u32());
        if draw > 0.5 {
            return None;
        }
        let mut rng = cell.key(path).rng();
        let p = cell.point(rng.unit(), rng.unit());
        let here = self.at(p);
        if draw > if here.cut { 0.5 } else { 0.03 } || !here.free {
            return None;
        }
        let size = rng.lognormal(0.38, 0.3).clamp(0.2, 0.8);
        let scale = DVec3::new(size, size, rng.range(0.35, 0.7));
        Some(self.planted(p, scale, rng.below(VARIANTS as u64), cell.name("stump"), &mut rng))
    }

    /// A fallen stem: its ends lie on the ground, so that it bridges hollows.
    fn log(&self, path: &SeedPath, cell: Cell) -> Option<Placed> {
        let draw = cell.draw(path.hash_u32());
        if draw > 0.35 {
            return None;
        }
        let mut rng = cell.key(path).rng();
        let p = cell.point(rng.unit(), rng.unit());
        let here = self.at(p);
        let share = if here.cut { 0.20 } else { 0.05 + 0.22 * smoothstep(-2.0, 2.0, here.open_m) };
        if draw > share || !here.free {
            return None;
        }
        let length = if here.cut { rng.range(2.5, 7.0) } else { rng.range(5.0, 17.0) };
        let thick = (0.013 * length + 0.06) * rng.range(0.8, 1.4);
        let (s, c) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
        let end = p + DVec2::new(c, s) * length;
        if !self.at(end).free {
            return None;
        }
        // Sunk in by a third of its thickness at the thick end, wholly at the thin one.
        let at = |q: DVec2, sink: f64| q.extend(f64::from(quantise_m(self.land.height_m(q))) + sink);
        let (from, to) = (at(p, 0.55 * thick), at(end, -0.1 * thick));
        let x = to - from;
        let y = DVec3::new(-s, c, 0.0);
        let z = x.cross(y).normalize();
        Some(Placed {
            at_m: p,
            world_from_object: DAffine3::from_mat3_translation(DMat3::from_cols(x, y * thick, z * thick), from),
            variation: variation(&mut rng),
            mesh: rng.below(VARIANTS as u64) as u32,
            path: cell.name("log"),
        })
    }

    /// Brush lies in lines where felling drew it together, in heaps elsewhere.
    fn brush(&self, path: &SeedPath, cell: Cell) -> Option<Placed> {
        let draw = cell.draw(path.hash_u32());
        let mut rng = cell.key(path).rng();
        let p = cell.point(rng.unit(), rng.unit());
        if draw > 0.9 || self.stands.at(p).kind != StandKind::Cut {
            return None;
        }
        let here = self.at(p);
        let bend = fractal(p, path.hash_u32(), 40.0, 2, 0.5) * 3.0;
        let across = (p.dot(here.along.perp()) + bend) / 15.0;
        let line = ((across - libm::round(across)) * 15.0).abs();
        let share = if line < 1.3 { 0.85 } else { 0.035 };
        if draw > share || !here.free {
            return None;
        }
        let size = rng.lognormal(0.95, 0.25).clamp(0.6, 1.8);
        let scale = DVec3::new(size * 1.15, size, size * rng.range(0.6, 1.0));
        Some(self.planted(p, scale, rng.below(VARIANTS as u64), cell.name("brush"), &mut rng))
    }
}

/// Adds all that grows and lies on the floor within `reach_m` of the pivot.
pub(super) fn scatter(
    scene: &mut Scene,
    land: &Land,
    stands: &Stands,
    growth: &Growth,
    reach_m: f64,
    contrast: f64,
    path: &SeedPath,
) {
    let floor = Floor { land, stands, growth };
    let k = contrast as f32;
    let seed = path.child("materials").hash_u32();
    let wood = |name: &str, color: Bands| {
        Material::diffuse(name, Class::OtherStructure, color)
            .rough(0.3)
            .with(Layer::Brightness { amount: Field::Variation(1).times(0.25 * k) })
            .with(Layer::Brightness { amount: Field::object_noise(seed ^ 3, 0.5, 2).times(0.25 * k) })
    };
    let low = Class::LowVegetation;
    let stem = Material { class: low, ..wood("bush stems", Bands::new(0.07, 0.08, 0.095, 0.16)) };
    let green = |name: &str, leaf: Bands, through: Bands| leaves(name, low, [leaf, through], k, seed);
    let bush = green("bush leaves", Bands::new(0.036, 0.086, 0.052, 0.40), Bands::new(0.006, 0.026, 0.01, 0.25));
    let fern = green("fern", Bands::new(0.042, 0.105, 0.068, 0.38), Bands::new(0.008, 0.035, 0.016, 0.25));
    let dry = green("cut twigs", Bands::new(0.075, 0.098, 0.120, 0.24), Bands::new(0.004, 0.01, 0.012, 0.1));
    let pale = wood("weathered wood", Bands::new(0.155, 0.175, 0.195, 0.28));
    let cut = wood("stumps", Bands::new(0.13, 0.165, 0.205, 0.3));
    let make = |name: &str, mesh: fn(&SeedPath) -> Mesh| -> Vec<Mesh> {
        let path = path.child(name).child("mesh");
        (0..VARIANTS).map(|k| mesh(&path.index(k as u64))).collect()
    };
    let mut kind =
        |name: &str, mesh: fn(&SeedPath) -> Mesh, materials: Vec<Material>, class: Class, things: Vec<Placed>| {
            add(scene, Kind { meshes: make(name, mesh), materials, class }, reach_m, things);
        };
    let of = |name: &str| path.child(name);
    let (bushes, ferns, stumps, logs, heaps) = (of("bush"), of("fern"), of("stump"), of("log"), of("brush"));
    // A log's thin end reaches beyond its foot.
    let inner_m = reach_m - 18.0;
    kind("bush", woods::bush, vec![stem.clone(), bush], low, place(reach_m, 2.8, |c| floor.bush(&bushes, c)));
    kind("fern", woods::fern, vec![stem.clone(), fern], low, place(reach_m, 1.9, |c| floor.fern(&ferns, c)));
    kind(
        "stump",
        woods::stump,
        vec![cut.clone(), cut],
        Class::OtherStructure,
        place(reach_m, 4.5, |c| floor.stump(&stumps, c)),
    );
    let lying: Vec<Placed> =
        place(reach_m, 8.0, |c| floor.log(&logs, c)).into_iter().filter(|l| l.at_m.length() < inner_m).collect();
    kind("log", woods::log, vec![pale.clone(), pale.clone()], Class::OtherStructure, lying);
    kind(
        "brush",
        woods::brush,
        vec![pale, dry],
        Class::OtherStructure,
        place(reach_m, 2.1, |c| floor.brush(&heaps, c)),
    );
}
