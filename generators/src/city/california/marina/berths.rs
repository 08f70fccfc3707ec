//! Where docks lie in a basin, and which boat lies at which berth.

use super::boats::{Boat, INDIVIDUALS};
use super::docks::{Dock, WALK_M};
use super::harbour::{Cell, Harbour};
use crate::city::california::land::Land;
use glam::DVec2;
use satseed_scene::{Rng, SeedPath};

/// A boat on the water.
#[derive(Clone, Debug, PartialEq)]
pub(in super::super) struct Afloat {
    pub(in super::super) boat: Boat,
    /// Which individual of its kind.
    pub(in super::super) individual: u64,
    /// World.
    pub(in super::super) at: DVec2,
    /// Where its bow points.
    pub(in super::super) axis: DVec2,
    pub(in super::super) name: String,
}

/// A dock in its place.
#[derive(Clone, Debug, PartialEq)]
pub(in super::super) struct Moored {
    pub(in super::super) dock: Dock,
    /// Where its walk leaves the shore, world.
    pub(in super::super) at: DVec2,
    /// Away from the shore.
    pub(in super::super) axis: DVec2,
    pub(in super::super) name: String,
}

/// Lengths of berths, m, and how often a dock has them.
const BERTHS: [(f64, f64); 5] = [(8.0, 0.16), (10.0, 0.3), (12.5, 0.28), (15.5, 0.18), (22.0, 0.08)];

/// Room between the boats of two neighbours at a finger, m.
const CLEAR_M: f64 = 0.75;

/// Everything afloat in one cell.
#[derive(Clone, Debug, Default)]
pub(super) struct Fleet {
    pub(super) docks: Vec<Moored>,
    pub(super) boats: Vec<Afloat>,
}

/// A kind's share among the boats of berths of a length.
fn share(boat: Boat, berth_m: f64) -> f64 {
    match boat {
        Boat::Runabout => 0.34,
        Boat::Cruiser => 0.3,
        Boat::Flybridge | Boat::Yacht => 0.5,
        Boat::Sloop => 0.52,
        Boat::Catamaran => f64::from(u8::from(berth_m > 14.0)) * 0.1,
    }
}

/// Kinds and individuals that fit a berth, with their weights.
fn fitting(berth_m: f64, width_m: f64) -> Vec<(Boat, u64, f64)> {
    let mut out = Vec::new();
    for boat in Boat::ALL {
        for n in 0..INDIVIDUALS {
            let [l, w] = boat.size_m(n);
            if l <= berth_m + 0.4 && l >= 0.7 * berth_m && w <= width_m - 0.3 {
                out.push((boat, n, share(boat, berth_m)));
            }
        }
    }
    out
}

/// Width of a berth, m: the widest usual boat of its length.
fn berth_width_m(berth_m: f64) -> f64 {
    0.3 * berth_m + 1.55
}

/// Draws one of the fitting boats for each of a row of berths; no two neighbours are the same individual.
fn row(fits: &[(Boat, u64, f64)], count: usize, key: &SeedPath) -> Vec<(Boat, u64)> {
    let weights: Vec<f64> = fits.iter().map(|f| f.2).collect();
    let drawn: Vec<usize> = (0..count).map(|i| key.index(i as u64).child("boat").rng().weighted(&weights)).collect();
    (0..count)
        .map(|i| {
            let mut k = drawn[i];
            if i % 2 == 1 {
                let beside = [Some(drawn[i - 1]), drawn.get(i + 1).copied()];
                while fits.len() > 2 && beside.contains(&Some(k)) {
                    k = (k + 1) % fits.len();
                }
            }
            (fits[k].0, fits[k].1)
        })
        .collect()
}

/// The docks and boats of a cell's basin, and boats under way before it. `boats` is a factor on the share of taken berths.
pub(super) fn fleet(cell: &Cell, harbour: &Harbour, land: &Land, boats: f64, city: &SeedPath) -> Fleet {
    let mut out = Fleet::default();
    let key = city.child("basin").index(cell.k as u64);
    let sides = [cell.x[0] + cell.mole_m[0], cell.x[1] - cell.mole_m[1]];
    let reach = ((sides[1] - sides[0]) / 2.0 - 12.0).min(92.0);
    for (s, x) in sides.into_iter().enumerate() {
        let out_of_shore = if s == 0 { DVec2::X } else { -DVec2::X };
        let end = cell.head - if cell.sandy_head { 72.0 } else { 12.0 };
        let mut y = cell.tip[s] + 22.0;
        let mut n = 0;
        loop {
            let key = key.child("dock").index(s as u64).index(n);
            let mut rng = key.rng();
            let berth_m = BERTHS[rng.weighted(&BERTHS.map(|b| b.1))].0;
            // Two rows of berths and half of the water between this dock and the next.
            let half = WALK_M + berth_m + 0.64 * berth_m;
            if y + 2.0 * half > end {
                break;
            }
            let name = format!("harbour/basin/{}/{s}/dock/{n}", cell.k);
            let length_m = (reach - rng.range(0.0, 5.0)).max(34.0);
            berths(&name, DVec2::new(x, y + half), out_of_shore, length_m, berth_m, boats, land, &key, &mut out);
            y += 2.0 * half;
            n += 1;
        }
    }
    under_way(cell, harbour, land, boats, &key.child("under way"), &mut out);
    out
}

/// One dock with its boats.
#[allow(clippy::too_many_arguments)]
fn berths(
    name: &str,
    root: DVec2,
    axis: DVec2,
    length_m: f64,
    berth_m: f64,
    boats: f64,
    land: &Land,
    key: &SeedPath,
    out: &mut Fleet,
) {
    let width = berth_width_m(berth_m);
    let pair = 2.0 * width + 1.1;
    let first = 14.6;
    let pairs = libm::floor((length_m - first - 1.0) / pair).max(1.0) as usize;
    let length_m = first + pair * pairs as f64 + 0.6;
    let finger_m = 0.88 * berth_m;
    let dock = Dock {
        length_m,
        fingers: (0..=pairs).map(|k| first + pair * k as f64).collect(),
        reach_m: finger_m,
        head_m: WALK_M + finger_m,
    };
    let at = |p: DVec2| land.world(root + axis * p.x + axis.perp() * p.y);
    let turned = |v: DVec2| (at(v) - at(DVec2::ZERO)).normalize();
    let fits = fitting(berth_m, width - CLEAR_M + 0.3);
    let taken = key.child("taken").rng().range(0.74, 0.96) * boats;
    for (s, side) in [-1.0, 1.0].into_iter().enumerate() {
        let key = key.child("row").index(s as u64);
        for (i, (boat, n)) in row(&fits, 2 * pairs, &key).into_iter().enumerate() {
            let mut rng = key.index(i as u64).rng();
            if !rng.chance(taken) {
                continue;
            }
            let [l, _] = boat.size_m(n);
            let x = first + pair * (i / 2) as f64 + 0.55 + width * (0.5 + (i % 2) as f64);
            let bow_in = rng.chance(if boat == Boat::Sloop { 0.75 } else { 0.5 });
            // Motors and platforms reach behind the stern.
            let y = WALK_M + l / 2.0 + rng.range(0.5, 0.9) + if bow_in { 0.0 } else { 0.9 };
            let lean = rng.signed() * 0.025;
            let bow = DVec2::new(lean, if bow_in { -side } else { side });
            out.boats.push(Afloat {
                boat,
                individual: n,
                at: at(DVec2::new(x + rng.signed() * 0.12, side * y)),
                axis: turned(bow),
                name: format!("{name}/boat/{s}/{i}"),
            });
        }
    }
    // A long boat may lie across the dock's end.
    let mut rng = key.child("end").rng();
    if rng.chance(0.55 * boats) {
        let boat =
            if berth_m > 14.0 { Boat::Yacht } else { *rng.pick(&[Boat::Flybridge, Boat::Sloop, Boat::Catamaran]) };
        let n = rng.below(3);
        let [l, w] = boat.size_m(n);
        if l < 2.0 * dock.head_m + 2.0 {
            let way = if rng.chance(0.5) { 1.0 } else { -1.0 };
            let p = DVec2::new(length_m + 2.2 + 0.4 + w / 2.0, rng.signed() * 1.0);
            let name = format!("{name}/boat/end");
            out.boats.push(Afloat { boat, individual: n, at: at(p), axis: turned(DVec2::new(0.0, way)), name });
        }
    }
    out.docks.push(Moored { dock, at: at(DVec2::ZERO), axis: turned(DVec2::X), name: name.to_owned() });
}

/// Boats that go along the channel, on the right of its middle.
fn under_way(cell: &Cell, harbour: &Harbour, land: &Land, boats: f64, key: &SeedPath, out: &mut Fleet) {
    let middle = f64::midpoint(harbour.channel[0], harbour.channel[1]);
    let mut x = cell.x[0] + 20.0;
    let mut i = 0;
    while x < cell.x[1] - 20.0 {
        let mut rng: Rng = key.index(i).rng();
        if rng.chance(0.3 * boats.min(1.5)) {
            let way = if rng.chance(0.5) { 1.0 } else { -1.0 };
            let y = middle - way * rng.range(7.0, 24.0);
            let boat = *rng.pick(&[Boat::Runabout, Boat::Cruiser, Boat::Sloop, Boat::Flybridge]);
            let at = DVec2::new(x, y);
            let bow = DVec2::new(way, rng.signed() * 0.12);
            out.boats.push(Afloat {
                boat,
                individual: rng.below(INDIVIDUALS),
                at: land.world(at),
                axis: (land.world(at + bow) - land.world(at)).normalize(),
                name: format!("harbour/channel/{}/boat/{i}", cell.k),
            });
        }
        x += 38.0;
        i += 1;
    }
}
