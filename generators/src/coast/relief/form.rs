//! The numbers that make one coast unlike another.

use crate::coast::Params;
use glam::DVec2;
use satseed_scene::{Rng, SeedPath};

/// What grows on the land behind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Hinterland {
    /// Short turf with masses of scrub.
    Turf,
    /// Heath that covers about half of it.
    Heath,
    /// Rough grass, much of it dry.
    Rough,
}

/// A trodden way from the track to the beach, in metres along the coast over metres inland.
pub(super) struct Spur {
    at_m: f64,
    /// Metres along the coast per metre inland.
    lean: f64,
    /// It swings so far to each side, over such a length, from such a part of a turn on.
    swing_m: f64,
    swing_length_m: f64,
    turn: f64,
    /// Half its mean width, m.
    pub(super) half_m: f64,
}

impl Spur {
    /// How far a place lies beside its middle, m, signed.
    pub(super) fn off_m(&self, along_m: f64, inland_m: f64) -> f64 {
        let turns = core::f64::consts::TAU / self.swing_length_m;
        let (s, c) = libm::sincos(turns * inland_m + core::f64::consts::TAU * self.turn);
        let slope = self.lean + self.swing_m * turns * c;
        (along_m - self.at_m - self.lean * inland_m - self.swing_m * s) / f64::sqrt(1.0 + slope * slope)
    }
}

/// Length of coast that draws its own spurs, m.
const SPURS_CELL_M: f64 = 560.0;

/// None to three spurs for every length of coast, at uneven places and angles.
pub(super) fn spurs(path: &SeedPath) -> Vec<Spur> {
    let mut spurs = Vec::new();
    for cell in 0..7_u32 {
        let mut rng = path.index(u64::from(cell)).rng();
        let begin_m = (f64::from(cell) - 3.5) * SPURS_CELL_M;
        for _ in 0..rng.below(4) {
            spurs.push(Spur {
                at_m: begin_m + rng.range(0.0, SPURS_CELL_M),
                lean: rng.signed() * 0.75,
                // With these the radius of its bends is 9 m or more.
                swing_m: rng.range(1.5, 5.0),
                swing_length_m: rng.range(45.0, 95.0),
                turn: rng.unit(),
                half_m: rng.range(0.45, 1.0),
            });
        }
    }
    spurs
}

/// The numbers of one coast.
pub(super) struct Form {
    /// Slope of the foreshore.
    pub(super) foreshore: f64,
    /// Height of the berm, m.
    pub(super) berm_m: f64,
    /// Dean's factor, m^(1/3).
    pub(super) dean: f64,
    /// Distances of the bars from the shore, m, and their heights, m.
    pub(super) bars: [[f64; 2]; 2],
    /// Where the dunes begin, m inland: how wide the beach is.
    pub(super) toe_m: f64,
    /// Width of the belt of dunes, m.
    pub(super) belt_m: f64,
    /// How much of the dunes the wind keeps bare, 0 to 1.
    pub(super) bare: f64,
    /// Height of the dunes over the back of the beach, m.
    pub(super) dune_m: f64,
    /// Where the track behind the shore runs, m inland.
    pub(super) track_m: f64,
    /// Thickness of the rock's beds, m, and how they dip.
    pub(super) bed_m: f64,
    pub(super) dip: DVec2,
    /// Significant height of the wind's waves, m.
    pub(super) chop_m: f64,
    /// Mean square slope of waves too short for mesh and bump: most of the whole (Cox and Munk 1954).
    pub(super) slope_variance: f64,
    /// Length of the wind's longest strong waves, m.
    pub(super) peak_m: f64,
    /// What grows behind the shore.
    pub(super) hinterland: Hinterland,
}

impl Form {
    pub(super) fn drawn(params: &Params, cliffs: bool, rng: &mut Rng) -> Self {
        // Narrow and wide are as likely by their ratio.
        let spread = |rng: &mut Rng, low: f64, high: f64| low * libm::pow(high / low, rng.unit());
        let toe_m = spread(rng, 25.0, 88.0);
        // A narrow beach is a steep one: its berm must stand before its dunes.
        let room_m = toe_m - 6.0;
        let foreshore = rng.range(0.065, 0.105).max(1.6 / room_m);
        let berm_m = rng.range(1.7, 2.5).min(foreshore * room_m);
        let belt_m = spread(rng, 17.0, 115.0);
        let (s, c) = libm::sincos(rng.range(0.0, core::f64::consts::TAU));
        let wind_m_s = rng.range(4.0, 8.0);
        let narrow = 0.6 + 0.4 * ((belt_m - 15.0) / 50.0).clamp(0.0, 1.0);
        Self {
            foreshore,
            berm_m,
            dean: rng.range(0.09, 0.14),
            bars: [[rng.range(38.0, 62.0), rng.range(0.4, 0.8)], [rng.range(105.0, 150.0), rng.range(0.8, 1.4)]],
            toe_m,
            belt_m,
            bare: rng.range(0.05, 0.6),
            dune_m: (0.25 * params.relief_m).clamp(1.5, 9.0) * narrow,
            track_m: if cliffs { 46.0 + 1.1 * params.relief_m } else { toe_m + belt_m + rng.range(14.0, 60.0) },
            bed_m: rng.range(1.8, 3.6),
            dip: DVec2::new(c, s) * rng.range(0.02, 0.16),
            chop_m: 0.042 * wind_m_s,
            slope_variance: 0.7 * (0.003 + 0.00512 * wind_m_s),
            peak_m: 2.0 + 0.85 * wind_m_s,
            hinterland: match rng.below(3) {
                0 => Hinterland::Turf,
                1 => Hinterland::Heath,
                _ => Hinterland::Rough,
            },
        }
    }
}
