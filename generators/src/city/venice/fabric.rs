//! What fills an island: quays, a campo, calli that cut it into blocks, and blocks cut into lots, courts and gardens.
//!
//! In the plan's straight frame. Calli are gaps of recursive cuts: each ends at an older one, so they form a tree with
//! loops; the first begin where bridges land.

use super::canals::{Isle, Landing};
use super::piece::{Piece, Side};
use glam::DVec2;
use satseed_scene::{Rng, SeedPath};

/// What stands on a lot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    /// A house.
    House,
    /// A lower wing between the houses of a block.
    Wing,
}

/// A piece that is built on.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Lot {
    /// Ground.
    pub piece: Piece,
    /// What stands on it.
    pub used: Use,
    /// Mean height of the block's eaves against the city's, m.
    pub block_m: f64,
    /// Its path below the city's.
    pub name: String,
}

/// What a piece of open ground is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Open {
    /// A square.
    Campo,
    /// A small square.
    Campiello,
    /// A court between houses.
    Court,
    /// A walled garden.
    Garden,
}

/// What fills an island.
#[derive(Clone, Debug, Default)]
pub(super) struct Fabric {
    /// Lots.
    pub lots: Vec<Lot>,
    /// Open ground with its path.
    pub opens: Vec<(Piece, Open, String)>,
    /// Ground of the church beside the campo.
    pub church: Option<Piece>,
    /// Which sides of the island have a quay.
    pub quays: Vec<bool>,
}

struct Filler<'a> {
    /// How densely built, 0.5 to 1.3.
    density: f64,
    path: &'a SeedPath,
    key: u64,
    out: Fabric,
}

/// Fills an island.
pub(super) fn fill(isle: &Isle, density: f64, path: &SeedPath) -> Fabric {
    let quays: Vec<f64> = (0..isle.piece.corners.len())
        .map(|i| {
            let [a, b] = isle.piece.ends(i);
            let mut rng = path.child("quay").index(i as u64).rng();
            if a.distance(b) > 28.0 && rng.chance(0.5) { rng.range(2.1, 4.2) } else { 0.0 }
        })
        .collect();
    let mut filler = Filler { density, path, key: isle.key, out: Fabric::default() };
    filler.out.quays = quays.iter().map(|q| *q > 0.0).collect();
    let ground = isle.piece.inset(|i| if quays[i] > 0.0 { (quays[i], Side::Quay) } else { (0.12, Side::Water) });
    if let Some(ground) = ground {
        let square = isle.campo.then(|| ground.centre());
        filler.divide(&ground, 1, square, isle.landings.clone());
    }
    filler.out
}

/// A calle's width, m: lognormal about the median of the city's, with a few salizade.
fn calle_m(rng: &mut Rng) -> f64 {
    rng.lognormal(2.3, 0.34).clamp(1.0, 5.0)
}

impl Filler<'_> {
    fn name(&self, what: &str, key: u64, k: u64) -> String {
        format!("isle/{}/{what}/{key}/{k}", self.key)
    }

    fn divide(&mut self, piece: &Piece, key: u64, square: Option<DVec2>, mut landings: Vec<Landing>) {
        let mut rng = self.path.child("calle").index(key).rng();
        let area = piece.area();
        landings.retain(|l| piece.border_distance(l.at) < 6.0);
        if square.is_some() && area < 4_300.0 && landings.is_empty() {
            self.campo(piece, key);
            return;
        }
        let wanted = rng.lognormal(1_060.0, 0.42).clamp(440.0, 2_500.0);
        if (area < wanted && landings.is_empty() && square.is_none()) || area < 240.0 {
            self.block(&piece.blunted(4.5, Side::Calle), key);
            return;
        }
        let (axis, length_m, _) = piece.long_axis();
        let (on, along, gap_m) = if let Some(landing) = landings.pop() {
            // From the bridge inland.
            let (sin, cos) = libm::sincos(rng.signed() * 0.2);
            let d = landing.inward;
            (landing.at, d * cos + d.perp() * sin, rng.range(2.9, 4.4))
        } else {
            let (sin, cos) = libm::sincos(rng.signed() * 0.2);
            let [low, _] = piece.extent(axis);
            let centre = piece.centre();
            let on = centre + axis * (low + length_m * rng.range(0.36, 0.64) - centre.dot(axis));
            let gap_m = if key < 4 { rng.range(2.4, 4.6) } else { calle_m(&mut rng) };
            (on, axis.perp() * cos + axis * sin, gap_m)
        };
        let parts = piece.cut(on, along, gap_m, Side::Calle);
        // The campo lies in the part that holds its place, or in the larger one when a calle took that.
        let holds = |p: &Option<Piece>, at: DVec2| p.as_ref().is_some_and(|p| p.contains(at));
        let size = |p: &Option<Piece>| p.as_ref().map_or(0.0, Piece::area);
        let first =
            square.map(|at| holds(&parts[0], at) || (!holds(&parts[1], at) && size(&parts[0]) > size(&parts[1])));
        for (k, part) in (0..2_u64).zip(parts) {
            if let Some(part) = part {
                let square = square
                    .filter(|_| first == Some(k == 0))
                    .map(|at| if part.contains(at) { at } else { part.centre() });
                self.divide(&part, 2 * key + k, square, landings.clone());
            }
        }
    }

    /// A campo, houses on one of its sides if it is long, and the ground of the church.
    fn campo(&mut self, piece: &Piece, key: u64) {
        let mut rng = self.path.child("campo").rng();
        let (axis, length_m, _) = piece.long_axis();
        let [low, _] = piece.extent(axis);
        let centre = piece.centre();
        let at = |share: f64| centre + axis * (low + length_m * share - centre.dot(axis));
        let church = rng.range(0.34, 0.44);
        let area = piece.area();
        // What is more than a campo of its size needs is built on.
        let open = (rng.range(1_200.0, 2_300.0) / area).clamp(0.28, 1.0 - church);
        let [rest, church_ground] = piece.cut(at(church), axis.perp(), 0.0, Side::Campo);
        let is_low = |p: &Piece| p.centre().dot(axis) < at(church).dot(axis);
        let (church_ground, rest) = match (church_ground, rest) {
            (Some(a), Some(b)) if is_low(&a) => (a, b),
            (Some(a), Some(b)) => (b, a),
            _ => return,
        };
        self.out.church = Some(church_ground);
        if church + open < 0.82 {
            for part in rest.cut(at(church + open), axis.perp(), 0.0, Side::Campo).into_iter().flatten() {
                if part.centre().dot(axis) < at(church + open).dot(axis) {
                    let name = self.name("campo", key, 0);
                    self.out.opens.push((part, Open::Campo, name));
                } else {
                    self.divide(&part, 2 * key + 1, None, Vec::new());
                }
            }
        } else {
            let name = self.name("campo", key, 0);
            self.out.opens.push((rest, Open::Campo, name));
        }
    }

    /// A block becomes houses wall to wall around courts.
    fn block(&mut self, piece: &Piece, key: u64) {
        let path = self.path.child("block").index(key);
        let mut rng = path.rng();
        let (axis, length_m, width_m) = piece.long_axis();
        let area = piece.area();
        let block_m = rng.normal() * 1.1;
        if area < 700.0 && rng.chance(0.035) {
            let name = self.name("campiello", key, 0);
            self.out.opens.push((piece.clone(), Open::Campiello, name));
            return;
        }
        if area > 420.0 && area < 1_500.0 && rng.chance(0.027 * (2.0 - self.density)) {
            let name = self.name("garden", key, 0);
            self.out.opens.push((piece.clone(), Open::Garden, name));
            return;
        }
        let mut k = 0;
        if width_m > 22.0 && length_m > 20.0 {
            // Two rows, and between them a band of courts and wings.
            let band_m = rng.range(4.2, 7.6) + (width_m - 24.0).max(0.0) * 0.16;
            let [low, _] = piece.extent(axis.perp());
            let centre = piece.centre();
            let middle = centre + axis.perp() * (low + width_m * rng.range(0.43, 0.57) - centre.dot(axis.perp()));
            let left = axis.perp() * (band_m / 2.0);
            for row in piece.cut(middle, axis, band_m, Side::Court).into_iter().flatten() {
                self.row(&row, axis, block_m, &path, key, &mut k);
            }
            let band = piece
                .clipped(middle - left, axis.perp(), Side::Party)
                .and_then(|p| p.clipped(middle + left, -axis.perp(), Side::Party));
            if let Some(band) = band {
                self.band(&band, axis, block_m, &path, key, &mut k);
            }
        } else {
            self.row(piece, axis, block_m, &path, key, &mut k);
        }
    }

    /// Houses side by side.
    fn row(&mut self, piece: &Piece, axis: DVec2, block_m: f64, path: &SeedPath, key: u64, k: &mut u64) {
        let mut rest = Some(piece.clone());
        while let Some(piece) = rest.take() {
            *k += 1;
            let mut rng = path.child("lot").index(*k).rng();
            let [low, high] = piece.extent(axis);
            let length_m = high - low;
            let depth_m = piece.area() / length_m.max(1.0);
            let wide = piece.sides.contains(&Side::Water);
            let front_m = rng.lognormal(if wide { 12.5 } else { 10.5 }, 0.3).clamp(6.5, 19.0);
            let mut lot = piece;
            if length_m > front_m + 6.0 {
                let at = axis * (low + front_m) + axis.perp() * lot.centre().dot(axis.perp());
                let (sin, cos) = libm::sincos(rng.signed() * 0.09);
                let parts = lot.cut(at, axis.perp() * cos + axis * sin, 0.0, Side::Party);
                let [Some(beyond), Some(near)] = parts.map(|p| p.filter(|p| p.area() > 24.0)) else {
                    self.lot(lot, Use::House, block_m, key, *k);
                    continue;
                };
                let swapped = near.centre().dot(axis) > beyond.centre().dot(axis);
                let (first, second) = if swapped { (beyond, near) } else { (near, beyond) };
                lot = first;
                rest = Some(second);
            }
            // A deep lot has a light court behind its house.
            if depth_m > 15.0 && lot.area() > 150.0 && rng.chance(0.23 * (2.0 - self.density)) {
                self.with_court(&lot, axis, block_m, key, *k, &mut rng);
            } else {
                self.lot(lot, Use::House, block_m, key, *k);
            }
        }
    }

    /// A house, a court behind it, and what stands beside the court.
    fn with_court(&mut self, lot: &Piece, axis: DVec2, block_m: f64, key: u64, k: u64, rng: &mut Rng) {
        let [low, high] = lot.extent(axis.perp());
        let centre = lot.centre();
        let share = rng.range(0.3, 0.42);
        let from_low = rng.chance(0.5);
        let t = if from_low { low + (high - low) * share } else { high - (high - low) * share };
        let on = centre + axis.perp() * (t - centre.dot(axis.perp()));
        let [upper, lower] = lot.cut(on, axis, 0.0, Side::Court);
        let (Some(upper), Some(lower)) = (upper, lower) else {
            self.lot(lot.clone(), Use::House, block_m, key, k);
            return;
        };
        let (back, house) = if from_low { (lower, upper) } else { (upper, lower) };
        self.lot(house, Use::House, block_m, key, k);
        let [a, b] = back.cut(back.centre() + axis * (rng.signed() * 1.5), axis.perp(), 0.0, Side::Court);
        let swap = rng.chance(0.5);
        let (court, wing) = if swap { (a, b) } else { (b, a) };
        if let Some(court) = court {
            let name = self.name("court", key, k);
            self.out.opens.push((court, Open::Court, name));
        }
        if let Some(wing) = wing {
            self.lot(wing, Use::Wing, block_m, key, k + 1000);
        }
    }

    /// Courts, gardens and wings in turn between two rows.
    fn band(&mut self, band: &Piece, axis: DVec2, block_m: f64, path: &SeedPath, key: u64, k: &mut u64) {
        let [low, high] = band.extent(axis);
        let centre = band.centre();
        let mut at = low;
        let mut rest = Some(band.clone());
        while let Some(piece) = rest.take() {
            *k += 1;
            let mut rng = path.child("cell").index(*k).rng();
            let step_m = rng.range(4.5, 12.0);
            at += step_m;
            let mut cell = piece;
            if high - at > 4.0 {
                let on = centre + axis * (at - centre.dot(axis));
                let [a, b] = cell.cut(on, axis.perp(), 0.0, Side::Party);
                if let (Some(a), Some(b)) = (a, b) {
                    let (first, second) = if a.centre().dot(axis) < b.centre().dot(axis) { (a, b) } else { (b, a) };
                    cell = first;
                    rest = Some(second);
                }
            }
            // Streets are closed by buildings, so courts lie inside.
            let outside = cell.sides.iter().any(|s| !matches!(s, Side::Party | Side::Court));
            let open = if outside { 0.10 } else { 0.50 };
            if rng.chance(open * (2.0 - self.density)) {
                let green = cell.area() > 45.0 && rng.chance(0.3);
                let (open, what) = if green { (Open::Garden, "garden") } else { (Open::Court, "court") };
                let name = self.name(what, key, *k);
                self.out.opens.push((cell, open, name));
            } else {
                self.lot(cell, Use::Wing, block_m, key, *k);
            }
        }
    }

    fn lot(&mut self, piece: Piece, used: Use, block_m: f64, key: u64, k: u64) {
        if piece.area() < 14.0 || piece.long_axis().2 < 2.2 {
            return;
        }
        let name = self.name("house", key, k);
        self.out.lots.push(Lot { piece, used, block_m, name });
    }
}
