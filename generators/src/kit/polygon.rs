//! Plane polygons, the stuff of plans: splitting, insetting, rounding, triangulating.
//!
//! A polygon is a list of corners, counter-clockwise, without repetition of the first. Blocks, sites and parcels are
//! convex; footprints may be L, U and other simple shapes.

use glam::DVec2;

/// Twice-signed-area over two: positive for counter-clockwise corners, m^2.
pub fn area(polygon: &[DVec2]) -> f64 {
    (0..polygon.len()).map(|i| polygon[i].perp_dot(polygon[(i + 1) % polygon.len()])).sum::<f64>() * 0.5
}

/// Centre of area.
pub fn centroid(polygon: &[DVec2]) -> DVec2 {
    let origin = polygon[0];
    let (mut sum, mut total) = (DVec2::ZERO, 0.0);
    for i in 1..polygon.len() - 1 {
        let (a, b) = (polygon[i] - origin, polygon[i + 1] - origin);
        let w = a.perp_dot(b);
        sum += (a + b) * (w / 3.0);
        total += w;
    }
    origin + sum / total
}

/// Smallest and largest coordinates.
pub fn bounds(polygon: &[DVec2]) -> (DVec2, DVec2) {
    polygon.iter().fold((polygon[0], polygon[0]), |(low, high), p| (low.min(*p), high.max(*p)))
}

/// Whether a point lies inside a simple polygon (crossing number; points on the border may go either way).
pub fn contains(polygon: &[DVec2], p: DVec2) -> bool {
    let mut inside = false;
    for i in 0..polygon.len() {
        let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
        if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) {
            inside = !inside;
        }
    }
    inside
}

/// Distance of a point to the polygon's border, m.
pub fn border_distance(polygon: &[DVec2], p: DVec2) -> f64 {
    (0..polygon.len())
        .map(|i| segment_distance(polygon[i], polygon[(i + 1) % polygon.len()], p))
        .fold(f64::INFINITY, f64::min)
}

/// Distance of `p` to the segment from `a` to `b`, m.
pub fn segment_distance(a: DVec2, b: DVec2, p: DVec2) -> f64 {
    let d = b - a;
    let t = ((p - a).dot(d) / d.length_squared()).clamp(0.0, 1.0);
    (p - a - d * t).length()
}

/// The part of a convex polygon where `(p - on) . inward >= 0`; `None` when nothing is left.
pub fn clip(polygon: &[DVec2], on: DVec2, inward: DVec2) -> Option<Vec<DVec2>> {
    let side = |p: DVec2| (p - on).dot(inward);
    let mut out: Vec<DVec2> = Vec::with_capacity(polygon.len() + 1);
    for i in 0..polygon.len() {
        let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
        let (sa, sb) = (side(a), side(b));
        if sa >= 0.0 {
            out.push(a);
        }
        if (sa > 0.0 && sb < 0.0) || (sa < 0.0 && sb > 0.0) {
            out.push(a + (b - a) * (sa / (sa - sb)));
        }
    }
    out.dedup_by(|a, b| a.distance_squared(*b) < 1e-12);
    while out.len() > 1 && out[0].distance_squared(out[out.len() - 1]) < 1e-12 {
        out.pop();
    }
    (out.len() >= 3 && area(&out) > 1e-6).then_some(out)
}

/// A convex polygon with every edge moved inward by the distance that `distance_m` gives for its index.
pub fn inset_edges(polygon: &[DVec2], distance_m: impl Fn(usize) -> f64) -> Option<Vec<DVec2>> {
    let mut out = polygon.to_vec();
    for i in 0..polygon.len() {
        let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
        let inward = (b - a).normalize().perp();
        out = clip(&out, a + inward * distance_m(i), inward)?;
    }
    Some(out)
}

/// A convex polygon moved inward by one distance.
pub fn inset(polygon: &[DVec2], distance_m: f64) -> Option<Vec<DVec2>> {
    inset_edges(polygon, |_| distance_m)
}

/// A simple polygon with every edge moved inward (negative: outward) and corners mitred. The distance must be small
/// against the edges; corners keep their number.
pub fn mitred(polygon: &[DVec2], distance_m: f64) -> Vec<DVec2> {
    let n = polygon.len();
    (0..n)
        .map(|i| {
            let (a, p, b) = (polygon[(i + n - 1) % n], polygon[i], polygon[(i + 1) % n]);
            let (m, k) = ((p - a).normalize().perp(), (b - p).normalize().perp());
            p + (m + k) * (distance_m / (1.0 + m.dot(k)))
        })
        .collect()
}

/// A convex polygon with its corners rounded by arcs of a radius, `steps` chords each. Radii too large for an edge
/// shrink.
pub fn rounded(polygon: &[DVec2], radius_m: f64, steps: usize) -> Vec<DVec2> {
    let n = polygon.len();
    let mut out = Vec::with_capacity(n * (steps + 1));
    for i in 0..n {
        let (a, p, b) = (polygon[(i + n - 1) % n], polygon[i], polygon[(i + 1) % n]);
        let (u, v) = ((a - p).normalize(), (b - p).normalize());
        let cos = u.dot(v).clamp(-1.0, 1.0);
        // Half the corner's angle by the half-angle formulas.
        let tan_half = ((1.0 - cos) / (1.0 + cos)).sqrt();
        let reach = (radius_m / tan_half).min(0.45 * a.distance(p)).min(0.45 * p.distance(b));
        if reach < 0.05 || cos < -0.99 {
            out.push(p);
            continue;
        }
        let (from, to) = (p + u * reach, p + v * reach);
        for s in 0..=steps {
            let t = s as f64 / steps as f64;
            // A quadratic Bezier: within centimetres of the arc for right angles, and no angles are needed.
            let w = 2.0 * t * (1.0 - t);
            out.push(from * ((1.0 - t) * (1.0 - t)) + p * w + to * (t * t));
        }
    }
    out
}

/// The polygon with extra corners on its edges so that none is longer than `longest_m`.
pub fn subdivided(polygon: &[DVec2], longest_m: f64) -> Vec<DVec2> {
    let mut out = Vec::with_capacity(polygon.len());
    for i in 0..polygon.len() {
        let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
        let n = libm::ceil(a.distance(b) / longest_m).max(1.0) as usize;
        out.extend((0..n).map(|k| a + (b - a) * (k as f64 / n as f64)));
    }
    out
}

/// An axis-aligned rectangle.
pub fn rectangle(low: DVec2, high: DVec2) -> Vec<DVec2> {
    vec![low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)]
}

/// A rectangle by its centre, the direction of its first axis, and its half sizes.
pub fn oriented_rectangle(centre: DVec2, axis: DVec2, half: DVec2) -> Vec<DVec2> {
    let (u, v) = (axis * half.x, axis.perp() * half.y);
    vec![centre - u - v, centre + u - v, centre + u + v, centre - u + v]
}

/// Triangles of a simple polygon by ear clipping, as indices of its corners, counter-clockwise.
pub fn triangulate(polygon: &[DVec2]) -> Vec<[usize; 3]> {
    let mut left: Vec<usize> = (0..polygon.len()).collect();
    let mut out = Vec::with_capacity(polygon.len().saturating_sub(2));
    while left.len() > 3 {
        let n = left.len();
        // The ear with the largest smallest angle would be nicer; the first one is enough for flat caps.
        let ear = (0..n).find(|&i| is_ear(polygon, &left, i)).unwrap_or(0);
        out.push([left[(ear + n - 1) % n], left[ear], left[(ear + 1) % n]]);
        left.remove(ear);
    }
    out.push([left[0], left[1], left[2]]);
    out
}

fn is_ear(polygon: &[DVec2], left: &[usize], i: usize) -> bool {
    let n = left.len();
    let (ia, ib, ic) = (left[(i + n - 1) % n], left[i], left[(i + 1) % n]);
    let (a, b, c) = (polygon[ia], polygon[ib], polygon[ic]);
    if (b - a).perp_dot(c - b) <= 1e-9 {
        return false;
    }
    left.iter().filter(|&&k| k != ia && k != ib && k != ic).all(|&k| {
        let p = polygon[k];
        let outside = |u: DVec2, v: DVec2| (v - u).perp_dot(p - u) < -1e-9;
        outside(a, b) || outside(b, c) || outside(c, a)
    })
}

/// Whether two convex polygons overlap (separating axes).
pub fn convex_overlap(a: &[DVec2], b: &[DVec2]) -> bool {
    let separated = |p: &[DVec2], q: &[DVec2]| {
        (0..p.len()).any(|i| {
            let (u, v) = (p[i], p[(i + 1) % p.len()]);
            let outward = -(v - u).perp();
            q.iter().all(|w| (*w - u).dot(outward) > 0.0)
        })
    };
    !separated(a, b) && !separated(b, a)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn l_shape() -> Vec<DVec2> {
        [(0.0, 0.0), (4.0, 0.0), (4.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)].map(|(x, y)| DVec2::new(x, y)).to_vec()
    }

    #[test]
    fn triangles_cover_a_concave_polygon_once() {
        let l = l_shape();
        let sum: f64 = triangulate(&l)
            .iter()
            .map(|t| {
                let a = area(&t.map(|i| l[i]));
                assert!(a > 0.0);
                a
            })
            .sum();
        assert!((sum - area(&l)).abs() < 1e-12 && (area(&l) - 6.0).abs() < 1e-12);
    }

    #[test]
    fn insets_keep_their_distance() {
        let l = mitred(&l_shape(), 0.25);
        assert!((area(&l) - (6.0 - 0.25 * 14.0 + 0.25 * 0.25 * 4.0)).abs() < 1e-9, "{}", area(&l));
        let r = rectangle(DVec2::ZERO, DVec2::new(10.0, 6.0));
        let i = inset(&r, 1.0).unwrap();
        assert!((area(&i) - 32.0).abs() < 1e-9);
        assert!(inset(&r, 3.1).is_none());
    }

    #[test]
    fn halves_make_the_whole() {
        let r = rectangle(DVec2::ZERO, DVec2::new(10.0, 6.0));
        let (on, n) = (DVec2::new(4.0, 1.0), DVec2::new(0.8, 0.6));
        let whole = area(&clip(&r, on, n).unwrap()) + area(&clip(&r, on, -n).unwrap());
        assert!((whole - 60.0).abs() < 1e-9);
    }

    #[test]
    fn rounding_stays_inside_and_near() {
        let r = rectangle(DVec2::ZERO, DVec2::new(30.0, 20.0));
        let a = area(&rounded(&r, 6.0, 5));
        let arc = 600.0 - (4.0 - core::f64::consts::PI) * 36.0;
        assert!((a - arc).abs() < 12.0 && a < 600.0, "{a} against {arc}");
    }
}
