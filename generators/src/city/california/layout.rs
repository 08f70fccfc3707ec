//! Streets and lots: arterials, collectors, and between them modules of local streets with loops and cul-de-sacs.
//!
//! Arterials and collectors are lines of the sheet, numbered alternately; a module is the land between four of them and is
//! keyed by its numbers, so that a crop has the same modules. Each is laid out whole, or not at all.

use super::land::{Land, Sheet};
use super::module;
use glam::DVec2;
use satseed_scene::SeedPath;

/// Kinds of lines of the sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Line {
    /// Six lanes and a median.
    Arterial,
    /// Two lanes, a turning lane and bicycle lanes.
    Collector,
    /// A freeway on its embankment; nothing opens into it, and what crosses it passes below.
    Freeway,
    /// No line: the street that comes here ends.
    End,
}

impl Line {
    /// From the middle to the kerb, m.
    pub(super) fn half_roadway_m(self) -> f64 {
        match self {
            Self::Arterial => 12.6,
            Self::Collector => 7.0,
            Self::Freeway | Self::End => 0.0,
        }
    }

    /// From the middle to the property line, m.
    pub(super) fn half_row_m(self) -> f64 {
        match self {
            Self::Arterial => 17.0,
            Self::Collector => 11.0,
            Self::Freeway => 52.0,
            Self::End => 0.0,
        }
    }
}

/// Local streets: from the middle to the kerb and to the property line, m.
pub(super) const LOCAL_ROADWAY_M: f64 = 5.5;
pub(super) const LOCAL_ROW_M: f64 = 9.0;

/// Kerb radius of a cul-de-sac's bulb, m.
pub(super) const BULB_M: f64 = 12.4;
/// Radius of its property line, m.
pub(super) const BULB_ROW_M: f64 = 15.6;

/// The lines of one scene.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    pitch_m: [f64; 2],
    offset_m: [f64; 2],
    path: SeedPath,
    /// The arterials of number 0 are freeways.
    freeways: bool,
    /// The land between the lines -1 and 0 of the second axis is a harbour, and all lines of the first axis are collectors.
    harbour: bool,
}

impl Grid {
    pub(super) fn new(city: &SeedPath, freeways: bool) -> Self {
        let path = city.child("grid");
        let mut rng = path.rng();
        let pitch_m = [rng.range(770.0, 830.0), rng.range(770.0, 830.0)];
        // Freeways cross near the pivot, arterials rather not.
        let offset_m = pitch_m.map(|p| if freeways { 45.0 * rng.signed() } else { -p * rng.range(0.12, 0.88) });
        Self { pitch_m, offset_m, path, freeways, harbour: false }
    }

    /// Lines around a harbour that the pivot lies in: close together where streets run out onto its moles.
    pub(super) fn around_harbour(city: &SeedPath) -> Self {
        let path = city.child("grid");
        let mut rng = path.rng();
        let pitch_m = [rng.range(510.0, 570.0), rng.range(1120.0, 1200.0)];
        let mut this = Self { pitch_m, offset_m: [0.0; 2], path, freeways: false, harbour: true };
        let width_m = -this.position(1, -1);
        this.offset_m = [-pitch_m[0] * rng.unit(), width_m * rng.range(0.27, 0.47)];
        this
    }

    /// Kind of a line: even ones are arterials.
    pub(super) fn kind(&self, axis: usize, k: i64) -> Line {
        match k {
            0 if self.freeways => Line::Freeway,
            _ if self.harbour && axis == 0 => Line::Collector,
            _ if k.rem_euclid(2) == 0 => Line::Arterial,
            _ => Line::Collector,
        }
    }

    /// Whether two freeways cross here.
    pub(super) fn has_freeways(&self) -> bool {
        self.freeways
    }

    /// Whether the land after a line of the second axis is a harbour.
    pub(super) fn is_harbour(&self, j: i64) -> bool {
        self.harbour && j == -1
    }

    /// Where a line crosses an axis of the sheet, m.
    pub(super) fn position(&self, axis: usize, k: i64) -> f64 {
        let cell = k.div_euclid(2);
        let start = self.offset_m[axis] + cell as f64 * self.pitch_m[axis];
        if k.rem_euclid(2) == 0 {
            return start;
        }
        let mut rng = self.path.child("collector").index(axis as u64).index(cell as u64).rng();
        start + self.pitch_m[axis] * rng.range(0.44, 0.56)
    }

    /// Numbers of the lines of an axis within a distance of the pivot, and one more on either side.
    pub(super) fn numbers(&self, axis: usize, reach_m: f64) -> core::ops::RangeInclusive<i64> {
        let mut first = 0;
        while self.position(axis, first) > -reach_m {
            first -= 1;
        }
        let mut last = 0;
        while self.position(axis, last) < reach_m {
            last += 1;
        }
        first..=last
    }
}

/// A line between two crossings.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    /// Axis that it crosses, its number, and the number of the crossing line at its begin.
    pub(super) index: [i64; 3],
    pub(super) kind: Line,
    /// Middle at its begin and its end, sheet.
    pub(super) ends: [DVec2; 2],
    /// The lines that it meets there.
    pub(super) meets: [Line; 2],
}

/// All pieces of lines near the pivot.
pub(super) fn pieces(grid: &Grid, reach_m: f64) -> Vec<Piece> {
    let mut out = Vec::new();
    for axis in 0..2_usize {
        let other = 1 - axis;
        for k in grid.numbers(axis, reach_m) {
            if grid.kind(axis, k) == Line::Freeway {
                continue;
            }
            let across = grid.position(axis, k);
            let numbers = grid.numbers(other, reach_m);
            for j in *numbers.start()..*numbers.end() {
                if axis == 0 && grid.is_harbour(j) {
                    continue;
                }
                let point = |along: f64| {
                    let mut p = DVec2::ZERO;
                    p[axis] = across;
                    p[other] = along;
                    p
                };
                out.push(Piece {
                    index: [axis as i64, k, j],
                    kind: grid.kind(axis, k),
                    ends: [point(grid.position(other, j)), point(grid.position(other, j + 1))],
                    meets: [grid.kind(other, j), grid.kind(other, j + 1)],
                });
            }
        }
    }
    out
}

/// What borders a module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Border {
    /// A line.
    Street(Line),
    /// Other land of the same module.
    Land,
    /// The foot of a freeway.
    Freeway,
}

/// Uses of a slab of land that is not lots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SlabUse {
    /// Strip mall with its parking lot.
    Commercial,
    /// School with its fields.
    School,
    /// Park.
    Park,
    /// Land below the ramps of an interchange, and what is built beside it.
    Junction,
}

/// A rectangle of land in one use.
#[derive(Clone, Debug)]
pub(super) struct Slab<'a> {
    pub(super) name: String,
    pub(super) key: SeedPath,
    pub(super) usage: SlabUse,
    /// Its frame: the first axis runs along the street, the second into the land.
    pub(super) sheet: Sheet<'a>,
    /// The street's side lies at the far end of the second axis.
    pub(super) street_far: bool,
    /// The end of the first axis that is nearer to the interchange is the far one.
    pub(super) junction_far: bool,
}

/// A lot.
#[derive(Clone, Debug)]
pub(super) struct Lot {
    pub(super) name: String,
    pub(super) key: SeedPath,
    /// Convex outline, world, counter-clockwise; the front is its first edge.
    pub(super) outline: Vec<DVec2>,
    /// How much further back than the front edge the street's property line reaches (bulbs), m.
    pub(super) bulge_m: f64,
    /// What stands along its rear border: nothing of its own, a fence, a wall towards a larger street.
    pub(super) rear: Rear,
    /// A level pad on a slope: larger houses, some with flat roofs, and decks beyond the pad's rear.
    pub(super) hillside: bool,
}

/// What stands along the rear border of a lot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rear {
    /// The neighbour's fence.
    Shared,
    /// Its own fence.
    Fence,
    /// A block wall.
    Wall,
}

/// A local street's strip in the frame of its module.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strip {
    pub(super) from: DVec2,
    pub(super) to: DVec2,
}

/// The rounded corner of two kerb lines.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fillet {
    /// Where the kerb lines cross.
    pub(super) corner: DVec2,
    /// Towards the land between them.
    pub(super) into: DVec2,
}

/// A module laid out.
#[derive(Clone, Debug)]
pub(super) struct Module<'a> {
    pub(super) key: SeedPath,
    pub(super) name: String,
    pub(super) sheet: Sheet<'a>,
    pub(super) lots: Vec<Lot>,
    pub(super) strips: Vec<Strip>,
    pub(super) fillets: Vec<Fillet>,
    /// Centres of bulbs and knuckles.
    pub(super) bulbs: Vec<DVec2>,
    pub(super) slabs: Vec<Slab<'a>>,
}

/// All modules that come near to the pivot.
pub(super) fn modules<'a>(grid: &Grid, land: &'a Land, city: &SeedPath, reach_m: f64) -> Vec<Module<'a>> {
    let mut out = Vec::new();
    let (xs, ys) = (grid.numbers(0, reach_m), grid.numbers(1, reach_m));
    for j in (*ys.start()..*ys.end()).filter(|j| !grid.is_harbour(*j)) {
        for i in *xs.start()..*xs.end() {
            let edge = |axis: usize, k: i64, side: f64| grid.position(axis, k) + side * grid.kind(axis, k).half_row_m();
            let low = DVec2::new(edge(0, i, 1.0), edge(1, j, 1.0));
            let high = DVec2::new(edge(0, i + 1, -1.0), edge(1, j + 1, -1.0));
            let nearest = DVec2::ZERO.clamp(low, high);
            if nearest.length() <= reach_m {
                out.push(module::lay_out([i, j], low, high, grid, land, city));
            }
        }
    }
    out
}
