//! Section land: a grid of half-mile quarters, some under a centre pivot, some in strips.

use super::Params;
use super::crops::Crop;
use super::mosaic::{Sheet, Tagged, cut};
use super::plan::{Border, DOMAIN_HALF_M, Edge, Piece};
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::SeedPath;

/// Half a mile, m.
const QUARTER_M: f64 = 804.67;
/// Corners of a whole circle.
const ARCS: usize = 96;

pub(super) fn lay(params: &Params, path: &SeedPath) -> Sheet {
    let mut sheet = Sheet::default();
    let mut rng = path.child("section grid").rng();
    let (s, c) = libm::sincos(rng.signed() * 0.035 + if rng.chance(0.5) { core::f64::consts::FRAC_PI_2 } else { 0.0 });
    let axis = DVec2::new(c, s);
    // The corner of four quarters, so that a frame sees parts of each.
    let flip = |v: f64, turn: bool| if turn { -v } else { v };
    let node = DVec2::new(flip(rng.range(45.0, 185.0), rng.chance(0.5)), flip(rng.range(45.0, 185.0), rng.chance(0.5)));
    let at = |i: i64, j: i64| axis.rotate(node + DVec2::new(i as f64, j as f64) * QUARTER_M);
    let cells = 3_i64;
    let border = |sheet: &mut Sheet, a: DVec2, b: DVec2, edge: Edge| {
        sheet.borders.push(Border { ends: [a, b], edge });
        sheet.borders.len() as u32 - 1
    };
    // Lines of the grid, whole: eastward, then northward.
    let kind = |k: i64| {
        if k == 0 {
            Edge::Lane
        } else if k % 2 == 0 {
            Edge::Track
        } else {
            Edge::Margin
        }
    };
    let rows: Vec<u32> = (-cells..=cells).map(|j| border(&mut sheet, at(-cells, j), at(cells, j), kind(j))).collect();
    let columns: Vec<u32> = (-cells..=cells)
        .map(|i| border(&mut sheet, at(i, -cells), at(i, cells), if i == 0 { Edge::Track } else { kind(i) }))
        .collect();
    // The quarter that holds the pivot's foot has a circle, and at least one other of the four.
    let mut has_yard = false;
    for j in -cells..cells {
        for i in -cells..cells {
            let code = ((i + 8) * 16 + j + 8) as u64;
            let mut rng = path.child("quarter").index(code).rng();
            let corners = vec![at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            let (row, column) = ((j + cells) as usize, (i + cells) as usize);
            let borders = vec![rows[row], columns[column + 1], rows[row + 1], columns[column]];
            if corners.iter().all(|p| p.length() > DOMAIN_HALF_M + QUARTER_M) {
                continue;
            }
            let holds = polygon::contains(&corners, DVec2::ZERO);
            let central = (-1..1).contains(&i) && (-1..1).contains(&j);
            let opposite = central && polygon::contains(&corners, axis.rotate(node) * 2.0);
            let circle =
                holds || opposite && rng.chance(0.7) || !opposite && rng.chance(if central { 0.35 } else { 0.6 });
            let quarter = Tagged { corners, borders };
            if circle {
                let with_yard = central && !has_yard && holds;
                has_yard |= with_yard;
                self::circle(params, &quarter, code, with_yard, path, &mut sheet);
            } else {
                strips(params, quarter, code, path, &mut sheet);
            }
        }
    }
    sheet
}

/// A quarter in long strips, each as wide as a few passes of a machine.
fn strips(params: &Params, quarter: Tagged, code: u64, path: &SeedPath, sheet: &mut Sheet) {
    let mut rng = path.child("strips").index(code).rng();
    if rng.chance(0.3) {
        let wide = Params { parcel_ha: 2.4 * params.parcel_ha, hedges: 0.0, ..params.clone() };
        cut(&wide, quarter, (1 << 32) + (code << 16) + 1, false, path, sheet);
        return;
    }
    let along_first = rng.chance(0.5);
    let c = &quarter.corners;
    let along = if along_first { (c[1] - c[0]).normalize() } else { (c[2] - c[1]).normalize() };
    let mut rest = quarter.clone();
    let step = along.perp();
    let from = c.iter().map(|p| p.dot(step)).fold(f64::MAX, f64::min);
    let mut at = from;
    let mut k = 0;
    loop {
        at += rng.range(46.0, 105.0);
        if at > from + QUARTER_M - 45.0 {
            break;
        }
        let edge = if rng.chance(0.6) { Edge::Furrow } else { Edge::Margin };
        let Some([left, right]) =
            rest.split(along * along.dot(rest.corners[0]) + step * at, along, edge, &mut sheet.borders)
        else {
            break;
        };
        push(sheet, right, (1 << 32) + (code << 16) + 16 + k, None);
        rest = left;
        k += 1;
    }
    push(sheet, rest, (1 << 32) + (code << 16) + 16 + k, None);
}

fn push(sheet: &mut Sheet, t: Tagged, code: u64, pivot: Option<(DVec2, f64)>) {
    sheet.pieces.push(Piece { whole: t.corners, borders: t.borders, code, convex: true, crop: None, pivot });
}

/// A circle in its quarter: wedges within, four corners without.
fn circle(_params: &Params, quarter: &Tagged, code: u64, with_yard: bool, path: &SeedPath, sheet: &mut Sheet) {
    let mut rng = path.child("circle").index(code).rng();
    let c = &quarter.corners;
    let centre = (c[0] + c[2]) / 2.0;
    let radius = rng.range(386.0, 396.5);
    let axis = (c[1] - c[0]).normalize();
    let point = |k: usize| {
        let (s, cos) = libm::sincos(core::f64::consts::TAU * k as f64 / ARCS as f64);
        centre + axis.rotate(DVec2::new(cos, s)) * radius
    };
    let ring: Vec<u32> = (0..ARCS)
        .map(|k| {
            sheet.borders.push(Border { ends: [point(k), point((k + 1) % ARCS)], edge: Edge::Margin });
            sheet.borders.len() as u32 - 1
        })
        .collect();
    sheet.pivots.push((centre, radius));
    // Wedges of 3 to 5 shares; none is more than half.
    let count = 3 + rng.below(3) as usize;
    let mut cuts: Vec<usize> = (0..count)
        .map(|k| ((k as f64 + rng.range(-0.22, 0.22)) * ARCS as f64 / count as f64 + 200.0) as usize % ARCS)
        .collect();
    let turn = rng.below(ARCS as u64) as usize;
    for cut in &mut cuts {
        *cut = (*cut + turn) % ARCS;
    }
    cuts.sort_unstable();
    let spokes: Vec<u32> = cuts
        .iter()
        .map(|k| {
            let edge = if rng.chance(0.5) { Edge::Furrow } else { Edge::Margin };
            sheet.borders.push(Border { ends: [centre, point(*k)], edge });
            sheet.borders.len() as u32 - 1
        })
        .collect();
    for w in 0..count {
        let (from, to) = (cuts[w], cuts[(w + 1) % count] + if w + 1 == count { ARCS } else { 0 });
        let mut corners = vec![centre];
        let mut borders = vec![spokes[w]];
        for k in from..to {
            corners.push(point(k % ARCS));
            borders.push(ring[k % ARCS]);
        }
        corners.push(point(to % ARCS));
        borders.push(spokes[(w + 1) % count]);
        let wedge = Tagged { corners, borders };
        push(sheet, wedge, (2 << 32) + (code << 16) + w as u64, Some((centre, radius)));
    }
    // The yard stands in the corner that is nearest to the pivot's foot.
    let nearest = (0..4).min_by(|a, b| c[*a].length().total_cmp(&c[*b].length()));
    for k in 0..4 {
        // From the middle of the side before a corner round it, and back along the arc.
        let (before, after) = ((c[(k + 3) % 4] + c[k]) / 2.0, (c[k] + c[(k + 1) % 4]) / 2.0);
        let (side_before, side_after) = (quarter.borders[(k + 3) % 4], quarter.borders[k]);
        // Corner k of the square lies at 225 degrees plus k quarters of the frame's own turn.
        let first = ARCS / 2 + k * ARCS / 4;
        let mut corners = vec![before, c[k], after];
        let mut borders = vec![side_before, side_after, side_after];
        for a in (first..=first + ARCS / 4).rev() {
            corners.push(point(a % ARCS));
            borders.push(if a == first { side_before } else { ring[(a + ARCS - 1) % ARCS] });
        }
        let code = (3 << 32) + (code << 16) + 4 * k as u64;
        let mut whole = Tagged { corners, borders };
        if with_yard && nearest == Some(k) {
            whole = yard(&whole, c[k], [before, after], code + 1, sheet, path);
        }
        let Tagged { corners, borders } = whole;
        sheet.pieces.push(Piece { whole: corners, borders, code, convex: false, crop: None, pivot: None });
    }
}

/// Takes a rectangle out of a corner piece; what is left keeps its arc.
fn yard(
    whole: &Tagged,
    corner: DVec2,
    [before, after]: [DVec2; 2],
    code: u64,
    sheet: &mut Sheet,
    path: &SeedPath,
) -> Tagged {
    let mut rng = path.child("yard").rng();
    let (u, v) = ((before - corner).normalize(), (after - corner).normalize());
    let (a, b) = (rng.range(74.0, 86.0), rng.range(70.0, 80.0));
    let (pu, pv, inner) = (corner + u * a, corner + v * b, corner + u * a + v * b);
    let first = sheet.borders.len() as u32;
    sheet.borders.push(Border { ends: [pv, inner], edge: Edge::Margin });
    sheet.borders.push(Border { ends: [inner, pu], edge: Edge::Hedge });
    let (side_before, side_after) = (whole.borders[0], whole.borders[1]);
    sheet.pieces.push(Piece {
        whole: vec![corner, pv, inner, pu],
        borders: vec![side_after, first, first + 1, side_before],
        code,
        convex: true,
        crop: Some(Crop::Yard),
        pivot: None,
    });
    let mut corners = vec![whole.corners[0], pu, inner, pv];
    let mut borders = vec![side_before, first + 1, first, side_after];
    corners.extend(&whole.corners[2..]);
    borders.extend(&whole.borders[2..]);
    Tagged { corners, borders }
}
