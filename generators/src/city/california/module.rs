//! One module: a slab of other uses here and there, and rows of lots along local streets.
//!
//! Rows of lots lie back to back across the module. Between every two rows runs a street, crossed by one spine; at the
//! module's border it opens into the larger street, ends in a bulb, or turns into its neighbour.

use super::land::{Land, Sheet};
use super::layout::{
    BULB_ROW_M, Border, Fillet, Grid, LOCAL_ROADWAY_M, LOCAL_ROW_M, Line, Lot, Module, Rear, Slab, SlabUse, Strip,
};
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::{Rng, SeedPath};

/// How a row street ends at the module's border.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    Open,
    Bulb,
    /// It turns towards the next row (true) or the one before.
    Elbow(bool),
}

/// Distance of a bulb's or a knuckle's middle from the border, m.
const BULB_DEPTH_M: f64 = 33.0;
const ELBOW_DEPTH_M: f64 = 38.5;

/// Lots smaller than this are left as open land, m^2.
const LEAST_LOT_M2: f64 = 300.0;

struct Layout<'a> {
    module: Module<'a>,
    size: DVec2,
    /// Depth of a lot, m.
    depth: f64,
    /// Width that lots are about, m.
    width: f64,
    spine: f64,
    borders: [Border; 4],
}

/// Lays out module `index` between two corners of the sheet.
pub(super) fn lay_out<'a>(
    index: [i64; 2],
    low: DVec2,
    high: DVec2,
    grid: &Grid,
    land: &'a Land,
    city: &SeedPath,
) -> Module<'a> {
    let name = format!("module/{}/{}", index[0], index[1]);
    let key = city.child("module").index(index[0] as u64).index(index[1] as u64);
    let mut rng = key.child("layout").rng();
    let mut low = low;
    let mut high = high;
    let mut borders = [0, 1, 2, 3].map(|k| match grid.kind(k / 2, index[k / 2] + (k % 2) as i64) {
        Line::Freeway => Border::Freeway,
        line => Border::Street(line),
    });
    let mut slabs = Vec::new();
    if let Some((usage, axis)) = usage_of(index, grid, city) {
        // Shops look at an arterial, schools and parks at a collector.
        let wanted = i64::from(matches!(usage, SlabUse::School | SlabUse::Park));
        let far = (index[axis] + 1).rem_euclid(2) == wanted;
        let depth = match usage {
            SlabUse::Commercial => rng.range(82.0, 96.0),
            SlabUse::School => rng.range(98.0, 116.0),
            SlabUse::Park => rng.range(70.0, 100.0),
            SlabUse::Junction => 225.0,
        };
        let (mut a, mut b) = (low, high);
        if far {
            a[axis] = high[axis] - depth;
            high[axis] = a[axis];
        } else {
            b[axis] = low[axis] + depth;
            low[axis] = b[axis];
        }
        borders[axis * 2 + usize::from(far)] = Border::Land;
        let swapped = axis == 0;
        let size = b - a;
        let size = if swapped { DVec2::new(size.y, size.x) } else { size };
        slabs.push(Slab {
            name: format!("{name}/slab"),
            key: key.child("slab"),
            usage,
            sheet: Sheet { land, origin: a, swapped, size, bow_m: [0.0; 2] },
            street_far: far,
            junction_far: index[1 - axis] == -1,
        });
    }
    // Rows run along the longer side, or, when it hardly matters, as drawn.
    let extent = high - low;
    let swapped = if (extent.x - extent.y).abs() < 40.0 { rng.chance(0.5) } else { extent.y > extent.x };
    let size = if swapped { DVec2::new(extent.y, extent.x) } else { extent };
    if swapped {
        borders.rotate_left(2);
    }
    let bow_m = if rng.chance(0.6) {
        [rng.signed() * 19.0, rng.signed() * 5.0]
    } else {
        [rng.signed() * 7.0, (6.0 + 5.0 * rng.unit()) * if rng.chance(0.5) { 1.0 } else { -1.0 }]
    };
    let sheet = Sheet { land, origin: low, swapped, size, bow_m };
    let rows = libm::round(size.y / (2.0 * 31.0 + 2.0 * LOCAL_ROW_M)).max(1.0);
    let mut layout = Layout {
        module: Module {
            key,
            name,
            sheet,
            lots: Vec::new(),
            strips: Vec::new(),
            fillets: Vec::new(),
            bulbs: Vec::new(),
            slabs,
        },
        size,
        depth: (size.y / rows - 2.0 * LOCAL_ROW_M) / 2.0,
        width: rng.range(15.6, 17.8),
        spine: size.x * rng.range(0.36, 0.64),
        borders,
    };
    layout.fill(rows as usize, &mut rng);
    layout.module
}

/// What one of the four modules of a square of arterials is used for beside dwellings: one has shops, another a school
/// or a park; and along which axis that slab has its depth.
fn usage_of(index: [i64; 2], grid: &Grid, city: &SeedPath) -> Option<(SlabUse, usize)> {
    if grid.has_freeways() && index.iter().all(|k| (-1..=0).contains(k)) {
        let mut rng = city.child("junction").index(index[0] as u64).index(index[1] as u64).rng();
        return Some((SlabUse::Junction, rng.below(2) as usize));
    }
    let square = index.map(|k| k.div_euclid(2) as u64);
    let mut rng = city.child("square").index(square[0]).index(square[1]).rng();
    let mut places = [0, 1, 2, 3];
    rng.shuffle(&mut places);
    let civic = if rng.chance(0.5) { SlabUse::School } else { SlabUse::Park };
    let axes = [rng.below(2) as usize, rng.below(2) as usize];
    let mine = index[0].rem_euclid(2) + 2 * index[1].rem_euclid(2);
    if places[0] == mine {
        Some((SlabUse::Commercial, axes[0]))
    } else if places[1] == mine && rng.chance(0.5) {
        Some((civic, axes[1]))
    } else {
        None
    }
}

impl Layout<'_> {
    /// Middle of row street `k`.
    fn row(&self, k: usize) -> f64 {
        (k as f64 + 0.5) * (2.0 * self.depth + 2.0 * LOCAL_ROW_M)
    }

    /// A place by its distance from the left (0) or right (1) border.
    fn at(&self, side: usize, from_border: f64, b: f64) -> DVec2 {
        DVec2::new(if side == 0 { from_border } else { self.size.x - from_border }, b)
    }

    /// Distance of the spine's middle from a border.
    fn to_spine(&self, side: usize) -> f64 {
        if side == 0 { self.spine } else { self.size.x - self.spine }
    }

    fn fill(&mut self, rows: usize, rng: &mut Rng) {
        let mut opens = [0, 1].map(|k| match self.borders[2 + k] {
            Border::Street(Line::Collector) => true,
            Border::Street(_) => rng.chance(0.35),
            Border::Land | Border::Freeway => false,
        });
        let mut ends = [0, 1].map(|side| self.ends(side, rows, rng));
        let reached = opens.contains(&true) || ends.iter().flatten().any(|e| *e == End::Open);
        if !reached {
            // Somewhere the module must be entered.
            for side in 0..2 {
                if matches!(self.borders[side], Border::Street(_)) {
                    ends[side] = vec![End::Bulb; rows];
                    ends[side][rows / 2] = End::Open;
                }
                if let Border::Street(_) = self.borders[2 + side] {
                    opens[side] = true;
                }
            }
        }
        self.spine_street(rows, opens);
        for (side, ends) in ends.iter().enumerate() {
            for (k, end) in ends.iter().enumerate() {
                self.half_row(side, k, rows, *end, opens);
            }
        }
        for (k, (left, right)) in ends[0].iter().zip(&ends[1]).enumerate() {
            let (from, to) = (self.row_end(0, k, *left), self.row_end(1, k, *right));
            self.module.strips.push(Strip { from, to });
        }
    }

    fn ends(&self, side: usize, rows: usize, rng: &mut Rng) -> Vec<End> {
        let collector = self.borders[side] == Border::Street(Line::Collector);
        let arterial = self.borders[side] == Border::Street(Line::Arterial);
        let mut out = Vec::with_capacity(rows);
        while out.len() < rows {
            let open = if collector {
                0.42
            } else if arterial {
                0.1
            } else {
                0.0
            };
            if rng.chance(open) {
                out.push(End::Open);
            } else if out.len() + 1 < rows && rng.chance(0.45) {
                out.extend([End::Elbow(true), End::Elbow(false)]);
            } else {
                out.push(End::Bulb);
            }
        }
        out
    }

    /// Where a row street's middle line ends: in the middle of the street that it meets.
    fn row_end(&self, side: usize, k: usize, end: End) -> DVec2 {
        let b = self.row(k);
        match (end, self.borders[side]) {
            (End::Open, Border::Street(line)) => self.at(side, -line.half_row_m(), b),
            (End::Elbow(_), _) => self.at(side, ELBOW_DEPTH_M, b),
            _ => self.at(side, BULB_DEPTH_M, b),
        }
    }

    fn spine_street(&mut self, rows: usize, opens: [bool; 2]) {
        let reach = |k: usize, near: f64, border: f64| match (opens[k], self.borders[2 + k]) {
            (true, Border::Street(line)) => (border, Some(line)),
            _ => (near, None),
        };
        let (low, low_line) = reach(0, self.row(0), 0.0);
        let (high, high_line) = reach(1, self.row(rows - 1), self.size.y);
        let out = |line: Option<Line>| line.map_or(0.0, Line::half_row_m);
        let x = self.spine;
        let from = DVec2::new(x, low - out(low_line));
        let to = DVec2::new(x, high + out(high_line));
        self.module.strips.push(Strip { from, to });
        let r = LOCAL_ROADWAY_M;
        for k in 0..rows {
            for sy in [-1.0, 1.0] {
                if (k == 0 && sy < 0.0 && low_line.is_none()) || (k + 1 == rows && sy > 0.0 && high_line.is_none()) {
                    continue;
                }
                for sx in [-1.0, 1.0] {
                    let into = DVec2::new(sx, sy);
                    self.module.fillets.push(Fillet { corner: DVec2::new(x, self.row(k)) + into * r, into });
                }
            }
        }
        for (line, border, sy) in [(low_line, 0.0, 1.0), (high_line, self.size.y, -1.0)] {
            if let Some(line) = line {
                let kerb = border - sy * (line.half_row_m() - line.half_roadway_m());
                for sx in [-1.0, 1.0] {
                    self.module.fillets.push(Fillet { corner: DVec2::new(x + sx * r, kerb), into: DVec2::new(sx, sy) });
                }
            }
        }
    }

    /// Lots on both sides of the street `k` between the spine and one border, and what its end needs.
    fn half_row(&mut self, side: usize, k: usize, rows: usize, end: End, opens: [bool; 2]) {
        let b = self.row(k);
        let inward = if side == 0 { 1.0 } else { -1.0 };
        for (f, facing) in [-1.0, 1.0].into_iter().enumerate() {
            let outermost = (k == 0 && f == 0) || (k + 1 == rows && f == 1);
            let to_spine = self.to_spine(side) - if outermost && !opens[f] { 0.0 } else { LOCAL_ROW_M };
            let (from, bulge_at) = match end {
                End::Open => (0.0, None),
                End::Bulb => (BULB_DEPTH_M, Some(BULB_DEPTH_M)),
                End::Elbow(up) if up == (f == 1) => (ELBOW_DEPTH_M + LOCAL_ROW_M, None),
                End::Elbow(_) => (ELBOW_DEPTH_M, Some(ELBOW_DEPTH_M)),
            };
            let rear = match (outermost, self.borders[2 + f]) {
                (true, Border::Street(_) | Border::Freeway) => Rear::Wall,
                (true, Border::Land) => Rear::Fence,
                _ if f == 1 => Rear::Fence,
                _ => Rear::Shared,
            };
            let name = format!("{side}/{k}/{f}");
            let run =
                [self.at(side, from, b + facing * LOCAL_ROW_M), self.at(side, to_spine, b + facing * LOCAL_ROW_M)];
            let bulge_at = bulge_at.map(|e| self.at(side, e, b));
            self.row_of_lots(&name, run, DVec2::new(0.0, facing), bulge_at, rear);
        }
        match end {
            End::Open => {
                if let Border::Street(line) = self.borders[side] {
                    let kerb = -(line.half_row_m() - line.half_roadway_m());
                    for facing in [-1.0, 1.0] {
                        let corner = self.at(side, kerb, b + facing * LOCAL_ROADWAY_M);
                        self.module.fillets.push(Fillet { corner, into: DVec2::new(inward, facing) });
                    }
                }
            }
            End::Bulb => {
                let centre = self.at(side, BULB_DEPTH_M, b);
                self.module.bulbs.push(centre);
                let half = self.depth + LOCAL_ROW_M;
                let region = [self.at(side, 0.0, b - half), self.at(side, BULB_DEPTH_M, b + half)];
                self.wedges(
                    &format!("{side}/{k}/bulb"),
                    centre,
                    region,
                    -inward,
                    [-90.0, -45.0, 0.0, 45.0, 90.0].as_slice(),
                );
            }
            End::Elbow(up) => {
                let centre = self.at(side, ELBOW_DEPTH_M, b);
                self.module.bulbs.push(centre);
                let half = self.depth + LOCAL_ROW_M;
                let out = if up { -half } else { half };
                let region = [self.at(side, 0.0, b + out), self.at(side, ELBOW_DEPTH_M, b)];
                let angles: &[f64] = if up { &[-90.0, -45.0, 0.0] } else { &[0.0, 45.0, 90.0] };
                self.wedges(&format!("{side}/{k}/knuckle"), centre, region, -inward, angles);
                let toward = if up { 1.0 } else { -1.0 };
                let corner = self.at(side, ELBOW_DEPTH_M + LOCAL_ROADWAY_M, b + toward * LOCAL_ROADWAY_M);
                self.module.fillets.push(Fillet { corner, into: DVec2::new(inward, toward) });
                if up {
                    let next = self.row(k + 1);
                    self.module.strips.push(Strip { from: centre, to: self.at(side, ELBOW_DEPTH_M, next) });
                    let edge = ELBOW_DEPTH_M - LOCAL_ROW_M;
                    let run = [self.at(side, edge, b), self.at(side, edge, next)];
                    self.column_of_lots(&format!("{side}/{k}/column"), run, -inward, edge);
                }
            }
        }
    }

    /// Lots side by side along a street; `run` is their front line, `into` points to their rear.
    fn row_of_lots(&mut self, name: &str, run: [DVec2; 2], into: DVec2, bulge_at: Option<DVec2>, rear: Rear) {
        for (k, [p, q]) in self.fronts(name, run).into_iter().enumerate() {
            let back = into * self.depth;
            let bulge_m = bulge_at.map_or(0.0, |c| {
                let dx = if (p.x - c.x) * (q.x - c.x) < 0.0 { 0.0 } else { (p.x - c.x).abs().min((q.x - c.x).abs()) };
                ((BULB_ROW_M * BULB_ROW_M - dx * dx).max(0.0).sqrt() - LOCAL_ROW_M).max(0.0)
            });
            self.lot(&format!("{name}/{k}"), &[p, q, q + back, p + back], bulge_m, rear);
        }
    }

    fn column_of_lots(&mut self, name: &str, run: [DVec2; 2], outward: f64, depth: f64) {
        let rear = match self.borders[usize::from(outward > 0.0)] {
            Border::Street(_) | Border::Freeway => Rear::Wall,
            Border::Land => Rear::Fence,
        };
        let count = self.fronts(name, run).len();
        for (k, [p, q]) in self.fronts(name, run).into_iter().enumerate() {
            let back = DVec2::new(outward * depth, 0.0);
            // Knuckles reach into the first and the last.
            let bulge_m = if k == 0 || k + 1 == count { BULB_ROW_M - LOCAL_ROW_M } else { 0.0 };
            self.lot(&format!("{name}/{k}"), &[p, q, q + back, p + back], bulge_m, rear);
        }
    }

    /// A front line cut into lots' fronts.
    fn fronts(&self, name: &str, [from, to]: [DVec2; 2]) -> Vec<[DVec2; 2]> {
        let length = from.distance(to);
        if length < 0.7 * self.width {
            return Vec::new();
        }
        let count = libm::round(length / self.width).max(1.0) as usize;
        let mut rng = self.module.key.child("widths").child(name).rng();
        let mut cuts: Vec<f64> = (0..=count).map(|k| k as f64).collect();
        for c in &mut cuts[1..count] {
            *c += rng.signed() * 0.07;
        }
        cuts.windows(2).map(|c| [from.lerp(to, c[0] / count as f64), from.lerp(to, c[1] / count as f64)]).collect()
    }

    /// Lots around a bulb: sectors of a rectangle between rays from its middle, cut off at the bulb. Angles are counted
    /// from the direction away from the street, degrees.
    fn wedges(&mut self, name: &str, centre: DVec2, region: [DVec2; 2], outward: f64, angles: &[f64]) {
        let (low, high) = (region[0].min(region[1]), region[0].max(region[1]));
        let region = polygon::rectangle(low, high);
        let ray = |degrees: f64| {
            let (s, c) = libm::sincos(degrees.to_radians());
            DVec2::new(c * outward, s)
        };
        for (k, pair) in angles.windows(2).enumerate() {
            let middle = ray(f64::midpoint(pair[0], pair[1]));
            let half = (pair[1] - pair[0]).to_radians() / 2.0;
            let mut piece = Some(region.clone());
            for edge in pair {
                let r = ray(*edge);
                let inward = (middle - r * middle.dot(r)).normalize();
                piece = piece.and_then(|p| polygon::clip(&p, centre, inward));
            }
            let chord = centre + middle * (BULB_ROW_M * libm::cos(half));
            let Some(mut piece) = piece.and_then(|p| polygon::clip(&p, chord, middle)) else { continue };
            let n = piece.len();
            let on_chord = |p: DVec2| ((p - chord).dot(middle)).abs() < 1e-6;
            if let Some(front) = (0..n).find(|i| on_chord(piece[*i]) && on_chord(piece[(*i + 1) % n])) {
                piece.rotate_left(front);
                self.lot(&format!("{name}/{k}"), &piece, 0.0, Rear::Fence);
            }
        }
    }

    /// One lot by its corners in the module's frame, the front first.
    fn lot(&mut self, name: &str, corners: &[DVec2], bulge_m: f64, rear: Rear) {
        let mut outline: Vec<DVec2> = corners.iter().map(|p| self.module.sheet.world(*p)).collect();
        if polygon::area(&outline) < 0.0 {
            // Turned over: the front stays the first edge.
            outline.reverse();
            let n = outline.len();
            outline.rotate_left(n - 2);
        }
        if polygon::area(&outline) < LEAST_LOT_M2 {
            return;
        }
        let name = format!("{}/lot/{name}", self.module.name);
        let key = self.module.key.child("lot").child(&name);
        self.module.lots.push(Lot { name, key, outline, bulge_m, rear, hillside: false });
    }
}
