//! Ramps: where each of them runs, how high, and what it is built of.

use super::form::{Form, Left};
use super::{
    BARRIER_M, HALF_M, Interchange, LEVELS_M, Post, RAMP_HALF_M, STEP_M, Sweep, VIADUCT_M, freeway_m, slot, smooth,
    traffic,
};
use crate::city::california::Params;
use crate::city::california::land::Land;
use crate::city::california::layout::Line;
use crate::kit::mesh_builder::MeshBuilder;
use core::f64::consts::{FRAC_PI_2, PI};
use glam::DVec2;
use satseed_scene::SeedPath;

/// Ramps leave and join at this distance from the freeway's middle, m: decks do not touch where the freeways lean.
const BESIDE_M: f64 = HALF_M + RAMP_HALF_M + 1.7;
/// Where a ramp's middle begins and ends inside a freeway's deck, m.
const INSIDE_M: f64 = HALF_M - RAMP_HALF_M - 0.4;

/// A way from one freeway to the other, in the quarter's own frame: x to the right of, y along the freeway that it leaves.
pub(super) struct Turn {
    name: &'static str,
    path: Vec<DVec2>,
    /// Height above the ground at a distance along, m.
    above_m: Box<dyn Fn(f64) -> f64>,
}

impl Turn {
    fn new(name: &'static str, path: Vec<DVec2>, above_m: impl Fn(f64, f64) -> f64 + 'static) -> Self {
        let total = length(&path);
        Self { name, path, above_m: Box::new(move |s| above_m(s, total)) }
    }
}

fn length(path: &[DVec2]) -> f64 {
    path.windows(2).map(|w| w[0].distance(w[1])).sum()
}

/// A quarter's frame in the form's.
fn turned(quarter: usize, p: DVec2) -> DVec2 {
    (0..quarter).fold(p, |p, _| p.perp())
}

/// Whether a pier would stand on a freeway or in a loop.
fn in_the_way(form: &Form, p: DVec2) -> bool {
    let near = |x: f64| x.abs() < HALF_M + 2.5;
    near(p.x)
        || near(p.y)
        || (0..4).any(|quarter| {
            let Left::Loop { radius_m } = form.left[quarter] else { return false };
            let p = turned((4 - quarter) % 4, p);
            let c = BESIDE_M + radius_m;
            let beside = |across: f64, along: f64| (across - BESIDE_M).abs() < 9.0 && (0.0..c).contains(&along);
            (p.distance(DVec2::splat(c)) - radius_m).abs() < RAMP_HALF_M + 3.0 || beside(p.x, p.y) || beside(p.y, p.x)
        })
}

/// Whether a place lies over a street, `streets` being those below the lower and the upper freeway.
fn over_street(streets: &[Vec<[f64; 2]>; 2], p: DVec2) -> bool {
    let strip_m = Line::Freeway.half_row_m();
    let below = |upper: usize, s: f64| streets[upper].iter().any(|[low, high]| (*low..*high).contains(&s));
    (p.x.abs() < strip_m && below(0, p.y)) || (p.y.abs() < strip_m && below(1, -p.x))
}

/// Builds a ramp, with who drives on it.
#[allow(clippy::too_many_arguments)]
pub(super) fn build(
    params: &Params,
    land: &Land,
    form: &Form,
    streets: &[Vec<[f64; 2]>; 2],
    quarter: usize,
    turn: &Turn,
    key: &SeedPath,
    out: &mut Interchange,
) {
    let path: Vec<DVec2> = turn.path.iter().map(|p| turned(quarter, *p)).collect();
    let total = length(&path);
    let mut posts = Vec::with_capacity(path.len());
    let mut s = 0.0;
    for (k, p) in path.iter().enumerate() {
        if k > 0 {
            s += p.distance(path[k - 1]);
        }
        // At its ends it lies under the freeway's surface and has no barriers of its own.
        let end = s.min(total - s);
        let free = smooth((end - 62.0) / 14.0);
        posts.push(Post {
            flat: form.flat(*p),
            above_m: (turn.above_m)(s) - 0.14 * (1.0 - free),
            barrier_m: 0.02 + (BARRIER_M - 0.02) * free,
        });
    }
    let sweep = Sweep::new(land, posts);
    let mut b = MeshBuilder::default();
    let n = path.len() - 1;
    sweep.deck(&mut b, 0, n, RAMP_HALF_M, slot::RAMP);
    out.decks.push(sweep.outline(0, n, RAMP_HALF_M));
    // Low parts stand on earth, high ones on piers, and streets pass through.
    let earthen = |k: usize| {
        let (p, above) = (path[k], sweep.stations[k].3);
        // Beside a freeway's embankment, at its height, it shares that.
        let shares = [(false, p.x, p.y), (true, p.y, p.x)].into_iter().any(|(upper, across, along)| {
            across.abs() < Line::Freeway.half_row_m()
                && along.abs() > VIADUCT_M[usize::from(upper)]
                && (above - freeway_m(upper, along)).abs() < 0.5
        });
        (above < 8.6 || shares) && !over_street(streets, p)
    };
    let mut from = 0;
    while from < n {
        let kind = earthen(from);
        let mut to = from + 1;
        while to < n && earthen(to) == kind {
            to += 1;
        }
        if kind {
            sweep.embankment(&mut b, from, to, RAMP_HALF_M - 0.9);
        } else {
            out.spans.push(sweep.outline(from, to, RAMP_HALF_M));
            let bents = ((to - from) as f64 * STEP_M / 36.0).round().max(1.0) as usize;
            for k in 1..bents {
                let station = from + (to - from) * k / bents;
                if !in_the_way(form, path[station]) && !over_street(streets, path[station]) {
                    sweep.pier(&mut b, station, 0.0, RAMP_HALF_M - 0.6);
                }
            }
        }
        from = to;
    }
    let name = format!("ramp/{}/{quarter}", turn.name);
    let key = key.child(&name);
    out.pieces.push((name, b.finish()));
    traffic(params, &sweep, 0.8, 1.0, &key.child("lane").index(0), [6.0, 18.0], out);
}

/// A polyline divided into pieces of about [`STEP_M`].
fn divided(points: &[DVec2]) -> Vec<DVec2> {
    let mut out = Vec::new();
    for w in points.windows(2) {
        let n = libm::ceil(w[0].distance(w[1]) / STEP_M).max(1.0) as usize;
        out.extend((0..n).map(|k| w[0].lerp(w[1], k as f64 / n as f64)));
    }
    out.extend(points.last());
    out
}

/// An arc without its end.
fn arc(centre: DVec2, radius: f64, from_rad: f64, to_rad: f64) -> Vec<DVec2> {
    let n = libm::ceil((to_rad - from_rad).abs() * radius / STEP_M) as usize;
    (0..n)
        .map(|k| {
            let (s, c) = libm::sincos(from_rad + (to_rad - from_rad) * k as f64 / n as f64);
            centre + DVec2::new(c, s) * radius
        })
        .collect()
}

/// To the left: over both freeways, or by a loop.
pub(super) fn left(form: &Form, quarter: usize) -> Turn {
    // Quarters 0 and 2 leave the lower freeway for the upper one, the others the other way.
    let leaves_upper = quarter % 2 == 1;
    match form.left[quarter] {
        Left::Over { radius_m, run_m, level_m } => over(leaves_upper, radius_m, run_m, level_m),
        Left::Loop { radius_m } => around(leaves_upper, radius_m),
    }
}

fn over(leaves_upper: bool, r: f64, run: f64, top: f64) -> Turn {
    let x = BESIDE_M;
    let mut path = divided(&[DVec2::new(INSIDE_M, -run - 70.0), DVec2::new(x, -run), DVec2::new(x, x - r)]);
    path.pop();
    path.extend(arc(DVec2::splat(x - r), r, 0.0, FRAC_PI_2));
    path.extend(divided(&[DVec2::new(x - r, x), DVec2::new(-run, x), DVec2::new(-run - 70.0, INSIDE_M)]));
    Turn::new("left", path, move |s, total| {
        let climb = run + x - r;
        let end = s.min(total - s);
        let t = smooth((end - 75.0) / (climb - 5.0));
        let upper = if s < total / 2.0 { leaves_upper } else { !leaves_upper };
        let base = freeway_m(upper, run + 70.0 - end);
        base + (top - base) * t
    })
}

fn around(leaves_upper: bool, r: f64) -> Turn {
    let x = BESIDE_M;
    let c = x + r;
    let mut path = divided(&[DVec2::new(INSIDE_M, 6.0), DVec2::new(x, c - 2.0), DVec2::new(x, c)]);
    path.pop();
    path.extend(arc(DVec2::splat(c), r, PI, -FRAC_PI_2));
    path.extend(divided(&[DVec2::new(c, x), DVec2::new(c - 2.0, x), DVec2::new(6.0, INSIDE_M)]));
    Turn::new("left", path, move |s, total| {
        let [from, to] = if leaves_upper { [LEVELS_M[1], LEVELS_M[0]] } else { [LEVELS_M[0], LEVELS_M[1]] };
        from + (to - from) * smooth((s - 70.0) / (total - 140.0))
    })
}

/// To the right, outside of all, and low between the freeways.
pub(super) fn right(form: &Form, quarter: usize) -> Turn {
    const TAPER_M: f64 = 150.0;
    let x = BESIDE_M + 2.0 * RAMP_HALF_M + 1.2;
    let r = form.right_m[quarter];
    // It parts before, and joins after, the left turns that run beside the same freeways.
    let [from, to] = [quarter, (quarter + 2) % 4].map(|q| (form.beside_m(q) + 75.0).max(x + r + 80.0));
    let mut path = divided(&[DVec2::new(INSIDE_M, -from - TAPER_M), DVec2::new(x, -from), DVec2::new(x, -x - r)]);
    path.pop();
    path.extend(arc(DVec2::new(x + r, -x - r), r, PI, FRAC_PI_2));
    path.extend(divided(&[DVec2::new(x + r, -x), DVec2::new(to, -x), DVec2::new(to + TAPER_M, -INSIDE_M)]));
    let leaves_upper = quarter % 2 == 1;
    Turn::new("right", path, move |s, total| {
        let (run, end, upper) = if s < total / 2.0 { (from, s, leaves_upper) } else { (to, total - s, !leaves_upper) };
        let along = run + TAPER_M - end;
        let base = freeway_m(upper, along);
        // Only where it turns away: beside the freeway it would lie in that one's embankment, and streets pass below.
        base + (3.4 - base) * smooth((x + r - along) / (0.7 * r))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a quarter's way in the form's frame: place, height above the ground, distance to its nearer end.
    fn points(turn: &Turn, quarter: usize) -> Vec<(DVec2, f64, f64)> {
        let total = length(&turn.path);
        let mut s = 0.0;
        (0..turn.path.len())
            .map(|k| {
                s += if k > 0 { turn.path[k].distance(turn.path[k - 1]) } else { 0.0 };
                (turned(quarter, turn.path[k]), (turn.above_m)(s), s.min(total - s))
            })
            .collect()
    }

    /// A lorry of 4.7 m fits between any two decks that cross, and none touch but where they part or join.
    #[test]
    fn decks_pass_each_other() {
        const APART_M: f64 = super::super::DECK_M + 4.7;
        for seed in 0..200 {
            let form = Form::new(DVec2::ZERO, &SeedPath::root("interchange", seed));
            let ways: Vec<_> = (0..4).flat_map(|q| [points(&left(&form, q), q), points(&right(&form, q), q)]).collect();
            for (w, way) in ways.iter().enumerate() {
                for &(p, above, end) in way {
                    for (upper, across, along) in [(false, p.x, p.y), (true, p.y, p.x)] {
                        let gap = (freeway_m(upper, along) - above).abs();
                        let joins = end < 160.0 && gap < 0.2;
                        // The parts that run beside a freeway keep off its deck.
                        let beside = across.abs() >= HALF_M + RAMP_HALF_M;
                        assert!(joins || beside || gap > APART_M, "seed {seed}, way {w} at {p}: {gap}");
                    }
                    for (o, other) in ways.iter().enumerate().skip(w + 1) {
                        for &(q, under, other_end) in other {
                            let near = form.flat(p).distance(form.flat(q)) < 2.0 * RAMP_HALF_M;
                            let gap = (above - under).abs();
                            let joins = end < 85.0 && other_end < 85.0 && gap < 0.2;
                            assert!(!near || joins || gap > APART_M, "seed {seed}, ways {w} and {o} at {p}: {gap}");
                        }
                    }
                }
            }
        }
    }

    /// No two interchanges are of one form: bends, leans, loops.
    #[test]
    fn forms_differ() {
        let forms: Vec<Form> = (0..40).map(|s| Form::new(DVec2::ZERO, &SeedPath::root("interchange", s))).collect();
        let loops = |f: &Form| f.left.iter().filter(|l| matches!(l, Left::Loop { .. })).count();
        for k in 0..3 {
            assert!(forms.iter().any(|f| loops(f) == k), "none has {k} loops");
        }
        let crossing = |f: &Form| {
            let direction = |p: DVec2| (f.flat(p) - f.centre).normalize();
            direction(DVec2::Y).angle_to(direction(DVec2::X)).abs().to_degrees()
        };
        let angles: Vec<f64> = forms.iter().map(crossing).collect();
        assert!(angles.iter().any(|a| *a < 82.0) && angles.iter().any(|a| *a > 98.0), "{angles:?}");
        for (i, a) in forms.iter().enumerate() {
            assert!(forms[i + 1..].iter().all(|b| a.left != b.left), "form {i} is there twice");
        }
    }
}
