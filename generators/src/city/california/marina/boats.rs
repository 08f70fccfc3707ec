//! Boats of a marina: motor boats of several sizes, yachts, sloops with their masts and catamarans, each kind in several
//! individuals of their own proportions.
//!
//! x is forward, z = 0 the water. All are closed solids that run into each other.

use crate::kit::mesh_builder::{BlockSlots, MeshBuilder, Parapet, Wall};
use crate::kit::polygon;
use glam::{DVec2, DVec3};
use satseed_scene::{Mesh, Rng};

/// Slots of a boat's material set.
pub(in super::super) mod slot {
    /// Hull.
    pub(in super::super::super) const HULL: u16 = 0;
    /// Foredeck and roofs.
    pub(in super::super::super) const DECK: u16 = 1;
    /// Floor of the cockpit.
    pub(in super::super::super) const SOLE: u16 = 2;
    /// Canvas.
    pub(in super::super::super) const CANVAS: u16 = 3;
    /// Windows.
    pub(in super::super::super) const GLASS: u16 = 4;
    /// Masts, rails, motors.
    pub(in super::super::super) const SPAR: u16 = 5;
    /// How many.
    pub(in super::super::super) const COUNT: usize = 6;
}

/// Kinds of boats.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in super::super) enum Boat {
    /// Open motor boat.
    Runabout,
    /// Motor boat with a cabin before the cockpit.
    Cruiser,
    /// Motor yacht with a helm on its roof.
    Flybridge,
    /// Motor yacht of three decks.
    Yacht,
    /// Sailing boat with one mast.
    Sloop,
    /// Sailing boat with two hulls.
    Catamaran,
}

/// Individuals of each kind.
pub(super) const INDIVIDUALS: u64 = 6;

impl Boat {
    pub(super) const ALL: [Self; 6] =
        [Self::Runabout, Self::Cruiser, Self::Flybridge, Self::Yacht, Self::Sloop, Self::Catamaran];

    /// Shortest and longest, m.
    pub(super) fn lengths_m(self) -> [f64; 2] {
        match self {
            Self::Runabout => [5.8, 7.6],
            Self::Cruiser => [8.2, 11.4],
            Self::Flybridge => [12.2, 15.8],
            Self::Yacht => [18.0, 23.5],
            Self::Sloop => [8.2, 13.2],
            Self::Catamaran => [10.8, 12.8],
        }
    }

    /// Width over length.
    fn beam(self) -> f64 {
        match self {
            Self::Runabout => 0.36,
            Self::Cruiser => 0.335,
            Self::Flybridge => 0.31,
            Self::Yacht => 0.26,
            Self::Sloop => 0.315,
            Self::Catamaran => 0.54,
        }
    }

    /// Length and width of individual `n`, m: individuals are spread over their kind's range.
    pub(super) fn size_m(self, n: u64) -> [f64; 2] {
        let [low, high] = self.lengths_m();
        let l = low + (high - low) * n as f64 / (INDIVIDUALS - 1) as f64;
        // Large boats are slimmer than small ones of their kind.
        [l, l * self.beam() * (low / l).sqrt()]
    }

    /// The mesh of individual `n`.
    pub(super) fn mesh(self, n: u64, rng: &mut Rng) -> Mesh {
        let [l, w] = self.size_m(n);
        let mut b = Builder { b: MeshBuilder::default(), l, w };
        match self {
            Self::Runabout => b.runabout(rng),
            Self::Cruiser => b.cruiser(rng),
            Self::Flybridge | Self::Yacht => b.motor_yacht(self == Self::Yacht, rng),
            Self::Sloop => b.sloop(rng),
            Self::Catamaran => b.catamaran(rng),
        }
        b.b.finish()
    }
}

struct Builder {
    b: MeshBuilder,
    l: f64,
    w: f64,
}

/// The plan of a hull from the stern: a transom of a share of the beam, a bow that begins at a share of the length.
fn plan(l: f64, w: f64, bow: f64, transom: f64) -> Vec<DVec2> {
    let (x, h) = (l / 2.0, w / 2.0);
    let mut side: Vec<DVec2> = vec![DVec2::new(-x, h * transom), DVec2::new(-x + 0.3 * l, h)];
    for t in [0.0, 0.3, 0.55, 0.76, 0.91] {
        // A quarter of a rounded lens.
        side.push(DVec2::new(x - bow * l * (1.0 - t), h * (1.0 - t * t).max(0.0)));
    }
    let mut out: Vec<DVec2> = side.iter().map(|p| DVec2::new(p.x, -p.y)).collect();
    out.push(DVec2::new(x, 0.0));
    out.extend(side.iter().rev());
    out
}

impl Builder {
    /// A rectangle by shares of length (from the middle) and beam.
    fn rect(&self, x: [f64; 2], half: f64) -> Vec<DVec2> {
        polygon::rectangle(DVec2::new(x[0] * self.l, -half * self.w), DVec2::new(x[1] * self.l, half * self.w))
    }

    /// A hull with its cockpit open from the stern to `deck_from` and decked from there; freeboard and height of the cockpit's floor.
    fn hull(&mut self, [bow, transom]: [f64; 2], deck_from: f64, free_m: f64, sole_m: f64) {
        let rim = plan(self.l, self.w, bow, transom);
        let keel = plan(self.l * 0.93, self.w * 0.78, bow * 1.05, transom);
        self.b.frustum(slot::HULL, slot::HULL, &keel, &rim, -0.4, sole_m - 0.12);
        let slots = BlockSlots { side: slot::HULL, coping: slot::DECK, strip: slot::SOLE, roof: slot::SOLE };
        let shape = Parapet { height_m: free_m - sole_m, width_m: 0.17, strip_m: 0.0 };
        self.b.parapet_block(slots, &rim, sole_m - 0.17, sole_m, shape, Wall::PLAIN);
        let inner = polygon::mitred(&rim, 0.06);
        if let Some(deck) = polygon::clip(&inner, DVec2::new(deck_from * self.l, 0.0), DVec2::X) {
            self.b.prism(slot::DECK, slot::DECK, &deck, sole_m - 0.1, free_m + 0.04, Wall::PLAIN);
        }
    }

    /// A house with windows all round and a roof that overhangs; returns the height of the roof.
    fn house(&mut self, x: [f64; 2], half: f64, low_m: f64, high_m: f64, rake: f64) -> f64 {
        let foot = self.rect(x, half);
        let mut top = self.rect([x[0] + 0.01, x[1] - rake], half * 0.86);
        self.b.frustum(slot::GLASS, slot::GLASS, &foot, &top, low_m, high_m);
        top = polygon::mitred(&top, -0.12);
        self.b.prism(slot::DECK, slot::DECK, &top, high_m - 0.03, high_m + 0.14, Wall::PLAIN);
        high_m + 0.14
    }

    /// Canvas on four posts.
    fn bimini(&mut self, x: [f64; 2], half: f64, low_m: f64, high_m: f64) {
        let foot = self.rect(x, half);
        let top = polygon::mitred(&foot, 0.22);
        self.b.frustum(slot::CANVAS, slot::CANVAS, &foot, &top, high_m - 0.1, high_m + 0.08);
        for p in polygon::mitred(&foot, 0.1) {
            self.b.limb(slot::SPAR, p.extend(low_m), p.extend(high_m - 0.02), [0.03, 0.03], 4);
        }
    }

    /// A platform at the stern, seldom a dinghy on it.
    fn platform(&mut self, rng: &mut Rng) {
        let deep = rng.range(0.5, 1.0);
        let x = -0.5 - deep / self.l;
        let plate = self.rect([x, -0.49], 0.4);
        self.b.prism(slot::DECK, slot::SOLE, &plate, 0.22, 0.36, Wall::PLAIN);
        if self.l > 12.0 && rng.chance(0.35) {
            let tender = polygon::rounded(&self.rect([x + 0.1 / self.l, -0.5 + 0.2 / self.l], 0.3), 0.3, 2);
            self.b.prism(slot::SPAR, slot::HULL, &tender, 0.3, 0.8, Wall::PLAIN);
        }
    }

    fn runabout(&mut self, rng: &mut Rng) {
        let covered = rng.chance(0.45);
        self.hull([0.42, 0.86], 0.14, 0.72, 0.3);
        if covered {
            let rim = plan(self.l * 0.94, self.w * 0.96, 0.42, 0.86);
            let foot = polygon::clip(&rim, DVec2::new(0.2 * self.l, 0.0), -DVec2::X).unwrap_or(rim);
            let centre = polygon::centroid(&foot);
            let top: Vec<DVec2> = foot.iter().map(|p| centre + (*p - centre) * DVec2::new(0.7, 0.2)).collect();
            self.b.frustum(slot::CANVAS, slot::CANVAS, &foot, &top, 0.7, 1.15);
        } else {
            let console = rng.range(-0.08, 0.06);
            let low = self.rect([console, console + 0.1], 0.2);
            self.b.prism(slot::DECK, slot::DECK, &low, 0.2, 1.1, Wall::PLAIN);
            let glass = self.rect([console + 0.08, console + 0.11], 0.22);
            self.b.prism(slot::GLASS, slot::GLASS, &glass, 0.9, 1.45, Wall::PLAIN);
            for x in [-0.2, -0.36] {
                let seat = self.rect([x - 0.035, x + 0.035], 0.32);
                self.b.prism(slot::DECK, slot::DECK, &seat, 0.2, 0.72, Wall::PLAIN);
            }
            if rng.chance(0.5) {
                self.bimini([console - 0.14, console + 0.13], 0.4, 0.3, 2.1);
            }
        }
        let motor = self.rect([-0.5 - 0.5 / self.l, -0.5 + 0.1 / self.l], 0.15);
        self.b.prism(slot::SPAR, slot::SPAR, &motor, -0.25, 1.05, Wall::PLAIN);
    }

    fn cruiser(&mut self, rng: &mut Rng) {
        let free = 0.11 * self.l;
        let step = rng.range(-0.14, -0.02);
        self.hull([0.45, 0.9], step, free, 0.5);
        let hard = rng.chance(0.45);
        if hard {
            self.house([step + 0.005, step + rng.range(0.26, 0.34)], 0.37, free, free + 0.85, 0.1);
        } else {
            let trunk = self.rect([step + 0.02, 0.27], 0.28);
            let top = self.rect([step + 0.03, 0.2], 0.2);
            self.b.frustum(slot::DECK, slot::DECK, &trunk, &top, free, free + 0.32);
            let glass = self.rect([step - 0.02, step + 0.07], 0.4);
            let lean = self.rect([step - 0.02, step], 0.36);
            self.b.frustum(slot::GLASS, slot::GLASS, &glass, &lean, free - 0.02, free + 0.6);
        }
        let bench = self.rect([-0.47, -0.4], 0.34);
        self.b.prism(slot::DECK, slot::DECK, &bench, 0.4, 0.95, Wall::PLAIN);
        if rng.chance(if hard { 0.35 } else { 0.7 }) {
            let end = step + 0.02;
            self.bimini([end - rng.range(0.2, 0.34), end], 0.42, 0.5, free + 1.25);
        }
        self.platform(rng);
    }

    fn motor_yacht(&mut self, large: bool, rng: &mut Rng) {
        let free = 0.085 * self.l + 0.3;
        let aft = rng.range(-0.31, -0.24);
        self.hull([0.42, 0.92], aft + 0.02, free, 0.8);
        let fore = rng.range(0.14, 0.22);
        // The trunk of the forward cabins, then the deckhouse.
        let (trunk, top) = (self.rect([0.0, fore + 0.13], 0.27), self.rect([0.02, fore + 0.08], 0.2));
        self.b.frustum(slot::DECK, slot::DECK, &trunk, &top, free, free + 0.38);
        let mut roof = self.house([aft, fore], 0.4, free, free + 1.25, 0.09);
        if large {
            roof = self.house([aft + 0.05, fore - 0.11], 0.34, roof - 0.05, roof + 1.15, 0.07);
        }
        // The roof reaches back over the cockpit.
        let over = self.rect([aft - 0.11, aft + 0.05], 0.37);
        self.b.prism(slot::DECK, slot::DECK, &over, roof - 0.13, roof + 0.02, Wall::PLAIN);
        let bridge = if large { [aft + 0.09, fore - 0.24] } else { [aft + 0.03, fore - 0.13] };
        let coaming = polygon::rounded(&self.rect(bridge, 0.31), 0.5, 2);
        let slots = BlockSlots { side: slot::DECK, coping: slot::DECK, strip: slot::SOLE, roof: slot::SOLE };
        let shape = Parapet { height_m: 0.55, width_m: 0.1, strip_m: 0.0 };
        self.b.parapet_block(slots, &coaming, roof - 0.08, roof + 0.06, shape, Wall::PLAIN);
        let seat = self.rect([bridge[0] + 0.02, bridge[0] + 0.06], 0.24);
        self.b.prism(slot::HULL, slot::HULL, &seat, roof, roof + 0.5, Wall::PLAIN);
        if rng.chance(0.65) {
            self.bimini([bridge[0] + 0.01, bridge[0] + rng.range(0.13, 0.2)], 0.28, roof, roof + 2.0);
        }
        let arch = bridge[0] * self.l;
        self.b.limb(
            slot::SPAR,
            DVec3::new(arch, 0.0, roof),
            DVec3::new(arch - 0.3, 0.0, roof + rng.range(2.2, 3.4)),
            [0.09, 0.04],
            5,
        );
        self.platform(rng);
    }

    fn sloop(&mut self, rng: &mut Rng) {
        let (l, free) = (self.l, 0.085 * self.l + 0.1);
        self.hull([0.6, rng.range(0.55, 0.8)], -0.16, free, 0.45);
        // Decks beside the cockpit.
        for side in [-1.0, 1.0] {
            let (low, high) = (DVec2::new(-0.42 * l, side * 0.33 * self.w), DVec2::new(-0.15 * l, side * 0.2 * self.w));
            let strip = polygon::rectangle(low.min(high), low.max(high));
            self.b.prism(slot::DECK, slot::DECK, &strip, 0.4, free, Wall::PLAIN);
        }
        let (foot, top) = (self.rect([-0.17, 0.23], 0.29), self.rect([-0.15, 0.19], 0.22));
        self.b.frustum(slot::DECK, slot::DECK, &foot, &top, free, free + 0.42);
        for x in [0.02, 0.13] {
            let hatch = self.rect([x, x + 0.55 / l], 0.1);
            self.b.prism(slot::GLASS, slot::GLASS, &hatch, free + 0.3, free + 0.48, Wall::PLAIN);
        }
        if rng.chance(0.7) {
            let (foot, top) = (self.rect([-0.22, -0.09], 0.3), self.rect([-0.19, -0.13], 0.24));
            self.b.frustum(slot::CANVAS, slot::CANVAS, &foot, &top, free + 0.2, free + 0.95);
        }
        self.rig(DVec2::new(0.1 * l, 0.0), free, rng.range(1.2, 1.34) * l, rng.range(0.36, 0.42), rng);
        if rng.chance(0.25) {
            self.bimini([-0.44, -0.28], 0.34, free, free + 1.9);
        }
    }

    /// A mast with its boom under the sail's cover, spreaders and the furled foresail.
    fn rig(&mut self, foot: DVec2, free: f64, high: f64, boom: f64, rng: &mut Rng) {
        let (l, top) = (self.l, foot.extend(free + high));
        self.b.limb(slot::SPAR, foot.extend(free - 0.3), top, [0.1, 0.07], 6);
        let (z, end) = (free + 1.35, DVec2::new(foot.x - boom * l, 0.0));
        self.b.limb(slot::SPAR, foot.extend(z), end.extend(z + 0.05), [0.07, 0.06], 5);
        let cover = |share: f64, lift: f64| foot.lerp(end, share).extend(z + lift);
        if rng.chance(0.85) {
            self.b.limb(slot::CANVAS, cover(0.02, 0.3), cover(0.94, 0.14), [0.24, 0.14], 6);
        }
        for share in [0.42, 0.7] {
            let (at, half) = (free + high * share, 0.33 * self.w * (1.1 - share));
            let tip = |s: f64| DVec3::new(foot.x - 0.1, s * half, at);
            self.b.limb(slot::SPAR, tip(-1.0), tip(1.0), [0.04, 0.04], 4);
        }
        let bow = DVec3::new(0.475 * l, 0.0, free + 0.1);
        self.b.limb(slot::CANVAS, bow, top + (bow - top) * 0.12, [0.09, 0.05], 5);
    }

    fn catamaran(&mut self, rng: &mut Rng) {
        let (l, free) = (self.l, 1.15);
        let hull_w = 0.24 * self.w;
        for side in [-1.0, 1.0] {
            let out = DVec2::new(0.0, side * (self.w - hull_w) / 2.0);
            let shift = |p: Vec<DVec2>| -> Vec<DVec2> { p.into_iter().map(|q| q + out).collect() };
            let rim = shift(plan(l, hull_w, 0.5, 0.8));
            let keel = shift(plan(l * 0.96, hull_w * 0.7, 0.5, 0.8));
            self.b.frustum(slot::HULL, slot::DECK, &keel, &rim, -0.4, free);
        }
        let bridge = self.rect([-0.4, 0.16], 0.43);
        self.b.prism(slot::HULL, slot::DECK, &bridge, 0.55, free - 0.04, Wall::PLAIN);
        let net = self.rect([0.15, 0.3], 0.3);
        self.b.prism(slot::SPAR, slot::SPAR, &net, free - 0.2, free - 0.1, Wall::PLAIN);
        let roof = self.house([-0.16, 0.14], 0.3, free - 0.05, free + 0.95, 0.06);
        let over = self.rect([-0.4, -0.1], 0.3);
        self.b.prism(slot::DECK, slot::DECK, &over, roof - 0.11, roof + 0.03, Wall::PLAIN);
        for (x, y) in [(-0.38, 0.27), (-0.38, -0.27)] {
            let p = DVec2::new(x * l, y * self.w);
            self.b.limb(slot::SPAR, p.extend(free - 0.1), p.extend(roof), [0.06, 0.06], 5);
        }
        self.rig(DVec2::new(0.13 * l, 0.0), free, rng.range(1.25, 1.4) * l, 0.4, rng);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kit::mesh_builder::open_edges;
    use satseed_scene::SeedPath;

    #[test]
    fn boats_are_closed_afloat_and_of_their_size() {
        for boat in Boat::ALL {
            for n in 0..INDIVIDUALS {
                let m = boat.mesh(n, &mut SeedPath::root("boat", n).rng());
                assert_eq!((m.validate(), open_edges(&m)), (Ok(()), 0), "{boat:?} {n}");
                let (low, high) = m.bounds_m().unwrap();
                let [l, w] = boat.size_m(n);
                assert!((-0.5..-0.2).contains(&low.z) && high.z > 0.9, "{boat:?} {n} {low} {high}");
                let tall = matches!(boat, Boat::Sloop | Boat::Catamaran);
                assert!((high.z > l) == tall, "{boat:?} {n}: {}", high.z);
                let size = high - low;
                assert!(
                    (-0.01..1.3).contains(&(size.x - l)) && (size.y - w).abs() < 0.1,
                    "{boat:?} {n} {size} {l} {w}"
                );
            }
        }
    }
}
