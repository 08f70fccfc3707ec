//! Blocks cut into sites, every one with access to a street.

use super::polygon;
use glam::DVec2;
use satseed_scene::SeedPath;

/// A piece of a block.
#[derive(Clone, Debug, PartialEq)]
pub struct Site {
    /// Convex outline, counter-clockwise.
    pub outline: Vec<DVec2>,
    /// The edge on its street.
    pub front: usize,
    /// Which edges lie on a street.
    pub on_street: Vec<bool>,
    /// Number within its block.
    pub index: u64,
}

impl Site {
    /// Direction of its front, unit.
    pub fn axis(&self) -> DVec2 {
        let n = self.outline.len();
        (self.outline[(self.front + 1) % n] - self.outline[self.front]).normalize()
    }

    /// Length of its front, m.
    pub fn front_m(&self) -> f64 {
        self.outline[self.front].distance(self.outline[(self.front + 1) % self.outline.len()])
    }
}

/// A block cut up.
#[derive(Clone, Debug, PartialEq)]
pub struct Subdivision {
    /// Its sites.
    pub sites: Vec<Site>,
    /// The lane through it, if it has one.
    pub lane: Option<Vec<DVec2>>,
}

/// Cuts a convex four-cornered block: a lane along its longer axis (when `lane_m` is positive), then each half across
/// into sites of the widths that `next_width_m` draws.
pub fn subdivide(
    block: &[DVec2],
    lane_m: f64,
    path: &SeedPath,
    mut next_width_m: impl FnMut(&SeedPath) -> f64,
) -> Subdivision {
    // Let edge 0 be a longer one.
    let mut q = block.to_vec();
    if q[1].distance(q[2]) + q[3].distance(q[0]) > q[0].distance(q[1]) + q[2].distance(q[3]) {
        q.rotate_left(1);
    }
    let share = path.child("lane").rng().range(0.44, 0.56);
    let (m0, m1) = (q[0].lerp(q[3], share), q[1].lerp(q[2], share));
    let across = (m1 - m0).normalize().perp();
    let half = lane_m / 2.0;
    let mut sites = Vec::new();
    let halves = [polygon::clip(&q, m0 - across * half, -across), polygon::clip(&q, m0 + across * half, across)];
    for (h, strip) in halves.iter().enumerate() {
        let Some(strip) = strip else { continue };
        let path = path.child("half").index(h as u64);
        // The street of the lower half is edge 0 of the block, of the upper one edge 2.
        let (from, to) = if h == 0 { (q[0], q[1]) } else { (q[2], q[3]) };
        cut(strip, block, [from, to], &path, &mut next_width_m, &mut sites);
    }
    let lane = (lane_m > 0.0)
        .then(|| {
            let below = polygon::clip(&q, m0 - across * half, across)?;
            polygon::clip(&below, m0 + across * half, -across)
        })
        .flatten();
    Subdivision { sites, lane }
}

fn cut(
    strip: &[DVec2],
    block: &[DVec2],
    [from, to]: [DVec2; 2],
    path: &SeedPath,
    next_width_m: &mut impl FnMut(&SeedPath) -> f64,
    sites: &mut Vec<Site>,
) {
    let length = from.distance(to);
    let along = (to - from) / length;
    let mut widths = Vec::new();
    let mut sum = 0.0;
    while sum < length {
        let w = next_width_m(&path.child("width").index(widths.len() as u64));
        widths.push(w);
        sum += w;
    }
    // The last one gives way or all stretch, so that nothing is left over.
    if widths.len() > 1 && sum - length > 0.5 * widths[widths.len() - 1] {
        sum -= widths.pop().unwrap_or(0.0);
    }
    let mut rest = Some(strip.to_vec());
    let mut s = 0.0;
    for (k, w) in widths.iter().enumerate() {
        s += w * length / sum;
        let Some(whole) = rest.take() else { break };
        let piece = if k + 1 == widths.len() {
            Some(whole)
        } else {
            let on = from + along * s;
            rest = polygon::clip(&whole, on, along);
            polygon::clip(&whole, on, -along)
        };
        let Some(outline) = piece else { continue };
        let n = outline.len();
        let on_street: Vec<bool> =
            (0..n).map(|i| polygon::border_distance(block, (outline[i] + outline[(i + 1) % n]) * 0.5) < 0.05).collect();
        let facing = |i: usize| {
            let d = outline[(i + 1) % n] - outline[i];
            let lies = segment_on(outline[i], outline[(i + 1) % n], from, along);
            if lies { d.dot(along) } else { f64::MIN }
        };
        let front = (0..n).max_by(|a, b| facing(*a).total_cmp(&facing(*b))).unwrap_or(0);
        sites.push(Site { outline, front, on_street, index: sites.len() as u64 });
    }
}

fn segment_on(a: DVec2, b: DVec2, from: DVec2, along: DVec2) -> bool {
    let off = |p: DVec2| along.perp_dot(p - from).abs();
    off(a) < 0.05 && off(b) < 0.05
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sites_and_lane_cover_the_block_and_reach_a_street() {
        let block =
            vec![DVec2::new(0.0, 0.0), DVec2::new(118.0, 3.0), DVec2::new(121.0, 164.0), DVec2::new(-2.0, 160.0)];
        let path = SeedPath::root("parcels", 2);
        let cut = subdivide(&block, 5.0, &path, |p| p.rng().range(6.0, 60.0));
        let lane = polygon::area(cut.lane.as_ref().unwrap());
        let sum: f64 = cut.sites.iter().map(|s| polygon::area(&s.outline)).sum();
        assert!((sum + lane - polygon::area(&block)).abs() < 0.5, "{sum} + {lane}");
        assert!(cut.sites.iter().all(|s| s.on_street[s.front] && s.front_m() > 3.0));
    }
}
