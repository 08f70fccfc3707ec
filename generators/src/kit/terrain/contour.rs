//! Contour lines of a smooth field.

use glam::DVec2;
use satseed_scene::Raster;

/// Polylines along which `values` is 0, positive values on their left. Closed ones end with their first point.
/// Points stand on the grid's edges.
pub fn contours(values: &Raster<f32>) -> Vec<Vec<DVec2>> {
    let (width, height) = (values.width, values.height);
    // An edge is the one east (2 p) or north (2 p + 1) of its post; a line enters an edge's cell once and leaves it once.
    let mut next = vec![u32::MAX; 2 * width * height];
    let mut has_before = vec![false; 2 * width * height];
    for j in 0..height - 1 {
        for i in 0..width - 1 {
            let p = j * width + i;
            let corners = [p, p + 1, p + 1 + width, p + width];
            let edges = [2 * p, 2 * (p + 1) + 1, 2 * (p + width), 2 * p + 1];
            let inside = corners.map(|c| values.data[c] > 0.0);
            for k in 0..4 {
                // From where the border leaves the inside back to where it came in.
                if inside[k] && !inside[(k + 1) % 4] {
                    let entry = (1..4).map(|back| (k + 4 - back) % 4).find(|e| !inside[*e]);
                    let entry = entry.expect("a corner outside exists");
                    next[edges[k]] = edges[entry] as u32;
                    has_before[edges[entry]] = true;
                }
            }
        }
    }
    let point = |edge: usize| {
        let p = edge / 2;
        let q = if edge.is_multiple_of(2) { p + 1 } else { p + width };
        let (a, b) = (f64::from(values.data[p]), f64::from(values.data[q]));
        let from = values.position(p % width, p / width);
        from.lerp(values.position(q % width, q / width), a / (a - b))
    };
    let mut lines = Vec::new();
    // Those that begin on the border first, then rings.
    for rings in [false, true] {
        for start in 0..next.len() {
            if next[start] == u32::MAX || has_before[start] != rings {
                continue;
            }
            let mut line = vec![point(start)];
            let mut at = start;
            while next[at] != u32::MAX {
                let to = next[at] as usize;
                next[at] = u32::MAX;
                at = to;
                line.push(point(at));
            }
            lines.push(line);
        }
    }
    lines
}

/// A polyline's points anew, `step_m` apart or a little less; a ring stays one.
pub fn resampled(line: &[DVec2], step_m: f64) -> Vec<DVec2> {
    let length: f64 = line.windows(2).map(|p| p[0].distance(p[1])).sum();
    let parts = libm::ceil(length / step_m).max(1.0) as usize;
    let mut points = vec![line[0]];
    let (mut done, mut k) = (0.0, 0);
    for part in 1..parts {
        let wanted = length * part as f64 / parts as f64;
        while k + 2 < line.len() && done + line[k].distance(line[k + 1]) < wanted {
            done += line[k].distance(line[k + 1]);
            k += 1;
        }
        let span = line[k].distance(line[k + 1]);
        let t = if span > 0.0 { (wanted - done) / span } else { 0.0 };
        points.push(line[k].lerp(line[k + 1], t.clamp(0.0, 1.0)));
    }
    points.push(line[line.len() - 1]);
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    fn raster(f: impl Fn(DVec2) -> f64) -> Raster<f32> {
        let mut r = Raster::filled(DVec2::splat(-20.0), 1.0, 41, 41, 0.0_f32);
        for j in 0..41 {
            for i in 0..41 {
                let p = r.position(i, j);
                r.set(i, j, f(p) as f32);
            }
        }
        r
    }

    #[test]
    fn a_disc_has_one_ring_around_it() {
        let lines = contours(&raster(|p| 12.3 - (p - DVec2::new(0.4, -1.1)).length()));
        assert_eq!(lines.len(), 1);
        let ring = &lines[0];
        assert_eq!(ring[0], ring[ring.len() - 1]);
        let middle = DVec2::new(0.4, -1.1);
        assert!(ring.iter().all(|p| (p.distance(middle) - 12.3).abs() < 0.02));
        // The disc lies on the left: counter-clockwise.
        let area: f64 = ring.windows(2).map(|p| (p[0] - middle).perp_dot(p[1] - middle) / 2.0).sum();
        assert!((area / (core::f64::consts::PI * 12.3 * 12.3) - 1.0).abs() < 0.01, "{area}");
        let even = resampled(ring, 2.0);
        assert_eq!(even[0], even[even.len() - 1]);
        assert!(even.windows(2).all(|p| p[0].distance(p[1]) < 2.001 && p[0].distance(p[1]) > 1.7));
    }

    #[test]
    fn lines_run_from_border_to_border() {
        let lines = contours(&raster(|p| p.y - 0.3 * p.x - 0.51));
        assert_eq!(lines.len(), 1);
        let (first, last) = (lines[0][0], lines[0][lines[0].len() - 1]);
        assert!(first.x < last.x, "high ground is on the left of a line that runs east: {first} {last}");
        assert_eq!((first.x, last.x), (-20.0, 20.0));
    }
}
