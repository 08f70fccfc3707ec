//! Tracks: where they lie, where they join, and their rails and sleepers.

use super::{GAP_M, PIECE_M, PITCH_M, Piece, RAIL_M};
use crate::kit::mesh_builder::MeshBuilder;
use crate::kit::sweep::{self, Station};
use glam::DVec2;
use satseed_scene::{Mesh, SeedPath};

/// Slots of a track's mesh.
pub(super) mod slot {
    pub(in super::super) const RAIL: u16 = 0;
    pub(in super::super) const SLEEPER: u16 = 1;
}

/// A way from one track to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lead {
    /// Where it leaves and joins, along.
    pub(super) span_m: [f64; 2],
    /// From which and to which place, m to the left of the corridor's line.
    pub(super) left_m: [f64; 2],
}

/// A straight track with the leads that begin at it, going up along the corridor.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Track {
    /// To the left of the corridor's line, m.
    pub(super) left_m: f64,
    /// Where it begins and ends, along.
    pub(super) span_m: [f64; 2],
    pub(super) leads: Vec<Lead>,
    /// Which group it belongs to.
    pub(super) group: usize,
}

/// Half the distance of the rails' middles: 1.435 m between heads of 73 mm.
const HALF_GAUGE_M: f64 = 0.754;

/// Half length, half width and distance of sleepers, m.
const SLEEPER_M: [f64; 3] = [1.3, 0.115, 0.56];

/// Length of a lead for a metre of its offset: 45 m from track to track, a little shorter than two turnouts of 1 in 9.
const LEAD_SLOPE: f64 = 11.0;

/// A track that goes on as far as one sees ends here, m.
const FAR_M: f64 = 1620.0;

impl Lead {
    /// Where it is at a place along it: an S of two parabolas.
    fn left_at(&self, along: f64) -> f64 {
        let t = ((along - self.span_m[0]) / (self.span_m[1] - self.span_m[0])).clamp(0.0, 1.0);
        let share = if t < 0.5 { 2.0 * t * t } else { 1.0 - 2.0 * (1.0 - t) * (1.0 - t) };
        self.left_m[0] + (self.left_m[1] - self.left_m[0]) * share
    }
}

impl Track {
    /// The same, moved to the left.
    pub(super) fn shifted(mut self, by_m: f64) -> Self {
        self.left_m += by_m;
        for lead in &mut self.leads {
            lead.left_m = lead.left_m.map(|l| l + by_m);
        }
        self
    }

    /// Begin and end of its sleepers at a place: those under a turnout are longer.
    fn sleeper(&self, along: f64, leads: &[Lead]) -> [f64; 2] {
        let [half, ..] = SLEEPER_M;
        let mut ends = [self.left_m - half, self.left_m + half];
        for lead in leads.iter().filter(|l| along > l.span_m[0] && along < l.span_m[1]) {
            let at = lead.left_at(along);
            // Each of two tracks carries the half of a lead that is nearer to it.
            let middle = f64::midpoint(lead.left_m[0], lead.left_m[1]);
            let offset = at - self.left_m;
            let other = if (lead.left_m[0] - self.left_m).abs() < 0.01 { lead.left_m[1] } else { lead.left_m[0] };
            let own = (lead.left_m[0] - self.left_m).abs() < 0.01 || (lead.left_m[1] - self.left_m).abs() < 0.01;
            if !own || (at - self.left_m).abs() > (at - other).abs() {
                continue;
            }
            if offset > 0.0 {
                ends[1] = ends[1].max((at + half).min(middle - 0.02));
            } else {
                ends[0] = ends[0].min((at - half).max(middle + 0.02));
            }
        }
        ends
    }
}

/// The tracks, the middles of the gaps between their groups, and the width of the floor, m; the floor's middle lies at 0.
pub(super) fn layout(key: &SeedPath) -> (Vec<Track>, Vec<f64>, f64) {
    let mut rng = key.child("tracks").rng();
    let groups = 2 + rng.weighted(&[0.3, 0.5, 0.2]);
    // Six to fifteen in all.
    let (least, weights) = match groups {
        2 => (3, [0.5, 0.5, 0.0, 0.0]),
        3 => (2, [0.42, 0.33, 0.17, 0.08]),
        _ => (2, [0.5, 0.5, 0.0, 0.0]),
    };
    let counts: Vec<u64> = (0..groups).map(|_| least + rng.weighted(&weights) as u64).collect();
    let margins = [rng.range(3.4, 4.6), rng.range(5.5, 9.0)];
    let width: f64 = counts.iter().map(|n| (*n - 1) as f64 * PITCH_M).sum::<f64>()
        + (groups - 1) as f64 * GAP_M
        + margins[0]
        + margins[1];
    let mut tracks: Vec<Track> = Vec::new();
    let mut gaps = Vec::new();
    let mut left = -width / 2.0 + margins[0];
    for (group, count) in counts.iter().enumerate() {
        for k in 0..*count {
            if k > 0 {
                left += PITCH_M;
            }
            tracks.push(Track { left_m: left, span_m: [-FAR_M, FAR_M], leads: Vec::new(), group });
        }
        if group + 1 < groups {
            gaps.push(left + GAP_M / 2.0);
            left += GAP_M;
        }
    }
    fan(&mut tracks, &counts, key);
    crossovers(&mut tracks, key);
    (tracks, gaps, width)
}

/// In groups of four, the outer tracks leave one after another and come back: sidings.
fn fan(tracks: &mut [Track], counts: &[u64], key: &SeedPath) {
    let mut first = 0;
    for (group, count) in counts.iter().enumerate() {
        let n = *count as usize;
        let mut rng = key.child("fan").index(group as u64).rng();
        if n >= 3 {
            let (from, to) = (rng.range(-230.0, -60.0), rng.range(120.0, 330.0));
            for k in 2..n {
                let step = (k - 2) as f64 * 52.0;
                let (own, before) = (tracks[first + k].left_m, tracks[first + k - 1].left_m);
                let length = LEAD_SLOPE * PITCH_M;
                let span = [from + step, to - step];
                tracks[first + k].span_m = span;
                tracks[first + k - 1].leads.push(Lead { span_m: [span[0] - length, span[0]], left_m: [before, own] });
                tracks[first + k].leads.push(Lead { span_m: [span[1], span[1] + length], left_m: [own, before] });
            }
        }
        first += n;
    }
}

/// From the first to the second track of a group and back, here and there.
fn crossovers(tracks: &mut [Track], key: &SeedPath) {
    for k in 1..tracks.len() {
        if tracks[k].group != tracks[k - 1].group || tracks[k].span_m[0] > -FAR_M {
            continue;
        }
        let mut rng = key.child("crossover").index(k as u64).rng();
        let mut at = -FAR_M + rng.range(0.0, 300.0);
        let mut up = rng.chance(0.5);
        while at < FAR_M - 100.0 {
            let length = LEAD_SLOPE * PITCH_M;
            let (a, b) = if up { (k - 1, k) } else { (k, k - 1) };
            let left_m = [tracks[a].left_m, tracks[b].left_m];
            tracks[a].leads.push(Lead { span_m: [at, at + length], left_m });
            // The way back follows soon, then nothing for a while.
            at += length + if up == rng.chance(0.5) { rng.range(12.0, 40.0) } else { rng.range(150.0, 380.0) };
            up = !up;
        }
    }
}

/// A rail's section: foot in the sleeper, head on top.
fn rail_section(top_m: f64) -> Vec<DVec2> {
    [(-0.07, 0.03), (0.07, 0.03), (0.037, top_m), (-0.037, top_m)].map(|(x, y)| DVec2::new(x, y)).to_vec()
}

fn rails(b: &mut MeshBuilder, piece: &Piece<'_>, places: &[(f64, f64)], top_m: f64) {
    for side in [-HALF_GAUGE_M, HALF_GAUGE_M] {
        let stations: Vec<Station> = (0..places.len())
            .map(|k| {
                let (before, after) = (places[k.saturating_sub(1)], places[(k + 1).min(places.len() - 1)]);
                let direction = DVec2::new(after.0 - before.0, after.1 - before.1).normalize();
                let (along, left) = places[k];
                let at = DVec2::new(along, left) + direction.perp() * side;
                Station { direction, ..piece.station(at.x, at.y) }
            })
            .collect();
        let n = stations.len() - 1;
        sweep::solid(b, &|k| stations[k], 0..=n, &|_| rail_section(top_m), &[slot::RAIL; 4]);
    }
}

/// Rails and sleepers of all tracks in a piece.
pub(super) fn mesh(piece: &Piece<'_>) -> Mesh {
    let mut b = MeshBuilder::default();
    let tracks = &piece.corridor.tracks;
    let [low, high] = [piece.middle_m - PIECE_M / 2.0, piece.middle_m + PIECE_M / 2.0];
    let leads: Vec<Lead> = tracks.iter().flat_map(|t| t.leads.iter().copied()).collect();
    let near: Vec<Lead> = leads.into_iter().filter(|l| l.span_m[0] < high && l.span_m[1] > low).collect();
    for track in tracks {
        let (from, to) = (track.span_m[0].max(low), track.span_m[1].min(high));
        if to - from < 0.5 {
            continue;
        }
        let steps = libm::ceil((to - from) / 20.0).max(1.0);
        let places: Vec<(f64, f64)> =
            (0..=steps as u32).map(|k| (from + (to - from) * f64::from(k) / steps, track.left_m)).collect();
        rails(&mut b, piece, &places, RAIL_M);
        let [_, half, pitch] = SLEEPER_M;
        let mut k = libm::ceil(from / pitch);
        while k * pitch < to {
            let along = k * pitch;
            let [a, z] = track.sleeper(along, &near);
            let floor = piece.floor_m(along, track.left_m);
            let centre = DVec2::new(along - piece.middle_m, f64::midpoint(a, z));
            let size = DVec2::new(half, (z - a) / 2.0);
            b.block(slot::SLEEPER, slot::SLEEPER, centre, DVec2::X, size, floor - 0.12, floor + 0.05);
            k += 1.0;
        }
    }
    for lead in &near {
        let (from, to) = (lead.span_m[0].max(low), lead.span_m[1].min(high));
        let steps = libm::ceil((to - from) / 2.5).max(1.0);
        let place = |k: u32| {
            let along = from + (to - from) * f64::from(k) / steps;
            (along, lead.left_at(along))
        };
        let places: Vec<(f64, f64)> = (0..=steps as u32).map(place).collect();
        // A little lower, so that no two heads share a plane where they cross.
        rails(&mut b, piece, &places, RAIL_M - 0.006);
    }
    b.finish()
}
