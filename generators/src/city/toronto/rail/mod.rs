//! The rail corridor: a cutting through the city with six to fifteen tracks on ballast, platforms, trains, and streets that
//! cross on bridges or end at its fence.
//!
//! The corridor is a street of the grid that carries tracks, so that blocks and streets end at its borders by themselves. Its
//! floor lies below them: the ground's height is the relief less the cutting's depth, with a wall or a bank on each side.

mod bridges;
mod ground;
mod tracks;
mod trains;
mod works;

pub(super) use ground::{patches, segments};
pub(super) use trains::{Body, consists, slot as train};
pub(super) use works::{parts, slot as works_slot};

use super::relief::Swells;
use crate::kit::streets::{CrossSection, Street, StreetPlan};
use glam::DVec2;
use satseed_scene::SeedPath;
use tracks::Track;

/// Depth of the cutting: a road above clears a train of 4.9 m with a deck 1.5 m thick, m.
pub(super) const DEPTH_M: f64 = 7.6;

/// Top of a rail over the ballast, m.
const RAIL_M: f64 = 0.21;

/// Between two tracks side by side, m.
const PITCH_M: f64 = 4.1;

/// Between two groups of tracks, where platforms and piers stand, m.
const GAP_M: f64 = 9.6;

/// Width of the ground under a retaining wall's face, over which the ground falls, m.
const WALL_M: f64 = 0.45;

/// Run of a bank of grass, m: 1 in 1.8.
const BANK_M: f64 = 1.8 * DEPTH_M;

/// Between a cutting's edge and the property line, m: grass and a fence.
const VERGE_M: f64 = 8.0;

/// Things along the corridor are made in pieces of this length, m, each in one part of a scene and never cut.
const PIECE_M: f64 = 60.0;

/// The kind of the corridor's cross-section, after those of streets.
const KIND: u16 = super::materials::STREET_KINDS;

/// What crosses the corridor in a street's line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Crossing {
    Road,
    Foot,
    None,
}

/// The corridor, decided.
#[derive(Clone, Debug)]
pub(super) struct Corridor {
    /// Its line and cross-section.
    line: Street,
    /// Half its width, m.
    half_m: f64,
    /// Run of the slope on the right and on the left, m.
    run_m: [f64; 2],
    /// Its tracks from right to left.
    tracks: Vec<Track>,
    /// Middles of the gaps between groups, m to the left.
    gaps_m: Vec<f64>,
    /// Where a station's platforms begin and end, along.
    station_m: Option<[f64; 2]>,
    /// The station is roofed over from platform to platform.
    shed: bool,
    /// The streets that cross, with their index.
    crossings: Vec<(i64, Street, Crossing)>,
    key: SeedPath,
}

impl Corridor {
    /// The corridor of a city, put between the lines -1 and 0 of the eastward family, which move apart for it.
    pub(super) fn insert(streets: &mut StreetPlan, city: &SeedPath) -> Self {
        let key = city.child("rail");
        let (tracks, gaps_m, floor_m) = tracks::layout(&key);
        let mut rng = key.child("corridor").rng();
        let run_m = match rng.weighted(&[0.5, 0.2, 0.2, 0.1]) {
            0 => [WALL_M; 2],
            1 => [WALL_M, BANK_M],
            2 => [BANK_M, WALL_M],
            _ => [BANK_M; 2],
        };
        let half_m = (floor_m + run_m[0] + run_m[1]) / 2.0;
        // The floor's middle is not the corridor's where its sides differ.
        let shift = (run_m[0] - run_m[1]) / 2.0;
        let section = CrossSection { kind: KIND, roadway_m: 2.0 * half_m, sidewalk_m: VERGE_M };
        let [_, eastward] = &mut streets.streets;
        let at = usize::try_from(-streets.first[1]).unwrap_or(0);
        let direction = eastward[at].direction;
        let offset = rng.signed() * 0.3 * half_m;
        let left = direction.perp();
        let gap = [rng.range(90.0, 130.0), rng.range(90.0, 130.0)];
        for (side, sign) in [(0, -1.0), (1, 1.0)] {
            let nearest = if side == 0 { at - 1 } else { at };
            let street = eastward[nearest];
            let wanted = offset + sign * (half_m + VERGE_M + gap[side] + street.section.right_of_way_m() / 2.0);
            let move_m = wanted - street.through_m.dot(left);
            let range = if side == 0 { 0..at } else { at..eastward.len() };
            for street in &mut eastward[range] {
                street.through_m += left * move_m;
            }
        }
        let line = Street { through_m: left * offset, direction, section };
        eastward.insert(at, line);
        let station_m = rng.chance(0.7).then(|| {
            let from = rng.range(-260.0, -20.0);
            [from, from + rng.range(190.0, 300.0)]
        });
        let crossings = streets.streets[0]
            .iter()
            .enumerate()
            .map(|(k, street)| {
                let index = streets.first[0] + k as i64;
                (index, *street, Self::crossing(index, street, &key))
            })
            .collect();
        let tracks = tracks.into_iter().map(|t| t.shifted(shift)).collect();
        let gaps_m = gaps_m.into_iter().map(|g| g + shift).collect();
        let shed = rng.chance(0.45);
        Self { line, half_m, run_m, tracks, gaps_m, station_m, shed, crossings, key }
    }

    /// Every second street crosses; of the others some have a footbridge.
    fn crossing(index: i64, street: &Street, key: &SeedPath) -> Crossing {
        let even = key.child("even").rng().below(2) as i64;
        let mut rng = key.child("crossing").index(index as u64).rng();
        if index.rem_euclid(2) == even || street.section.kind == 3 {
            Crossing::Road
        } else if rng.chance(0.4) {
            Crossing::Foot
        } else {
            Crossing::None
        }
    }

    /// Distance along and to the left of a place of the world.
    fn local(&self, p: DVec2) -> DVec2 {
        DVec2::new(self.line.along(p), self.line.direction.perp_dot(p - self.line.through_m))
    }

    /// How far the ground lies below the relief at a place, m.
    pub(super) fn depth_m(&self, p: DVec2) -> f64 {
        let left = self.local(p).y;
        let run = self.run_m[usize::from(left > 0.0)];
        DEPTH_M * ((self.half_m - left.abs()) / run).clamp(0.0, 1.0)
    }

    /// Whether a place lies in the corridor or nearer to it than a distance.
    pub(super) fn holds(&self, p: DVec2, clear_m: f64) -> bool {
        self.local(p).y.abs() < self.half_m + clear_m
    }

    /// Left borders of the floor, m.
    fn floor_m(&self) -> [f64; 2] {
        [-self.half_m + self.run_m[0], self.half_m - self.run_m[1]]
    }
}

/// A stretch of the corridor in a frame of its own: x along, y to the left of the corridor's line, z from the floor at its
/// middle.
struct Piece<'a> {
    corridor: &'a Corridor,
    relief: &'a Swells,
    /// Its middle along the corridor.
    middle_m: f64,
    /// Height of its frame's origin, world.
    base_m: f64,
}

impl<'a> Piece<'a> {
    fn new(corridor: &'a Corridor, relief: &'a Swells, middle_m: f64) -> Self {
        let base_m = relief.height_m(corridor.line.at(middle_m, 0.0)) - DEPTH_M;
        Self { corridor, relief, middle_m, base_m }
    }

    /// Height of the floor at a place of the corridor, in this frame.
    fn floor_m(&self, along: f64, left: f64) -> f64 {
        self.relief.height_m(self.corridor.line.at(along, left)) - DEPTH_M - self.base_m
    }

    /// A point of a line parallel to the corridor's, on the floor.
    fn station(&self, along: f64, left: f64) -> crate::kit::sweep::Station {
        crate::kit::sweep::Station {
            at: DVec2::new(along - self.middle_m, left),
            direction: DVec2::X,
            height_m: self.floor_m(along, left),
        }
    }
}

#[cfg(test)]
mod tests;
