//! Bodies by formula: which surface a ray meets first, and whether a line from there to a camera is free.
//!
//! All in the frame (along the baseline, image up, up), m.

use glam::{DVec2, DVec3};

/// A point of a body's surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    /// Vertical distance from the camera, m.
    pub(crate) depth_m: f64,
    pub(crate) point: DVec3,
    /// Which part of the scene.
    pub(crate) part: u32,
    /// Unit normal towards the camera.
    pub(crate) normal: DVec3,
}

pub(crate) trait Bodies {
    /// The first surface on the way down from `centre` by `slopes` metres for each metre of depth.
    fn first(&self, centre: DVec3, slopes: DVec2) -> Option<Surface>;
    /// Whether the straight line from the surface to `centre` is blocked.
    fn blocked(&self, from: &Surface, centre: DVec3) -> bool;
}

/// A square of ground around the origin, and boxes that stand on it, in it or over it.
#[derive(Clone, Debug)]
pub(crate) struct Boxes {
    pub(crate) ground_z: f64,
    pub(crate) ground_half: f64,
    /// Lower and upper corners; box k is part k + 1.
    pub(crate) solids: Vec<[DVec3; 2]>,
}

/// Where p + s * d, for s, lies between two planes of each axis: the range of s, and the axis at which it begins.
fn slabs(p: DVec3, d: DVec3, [low, high]: [DVec3; 2]) -> Option<(f64, f64, usize)> {
    let (mut enter, mut leave, mut axis) = (f64::NEG_INFINITY, f64::INFINITY, 0);
    for k in 0..3 {
        if d[k] == 0.0 {
            if p[k] <= low[k] || p[k] >= high[k] {
                return None;
            }
            continue;
        }
        let (a, b) = ((low[k] - p[k]) / d[k], (high[k] - p[k]) / d[k]);
        if a.min(b) > enter {
            enter = a.min(b);
            axis = k;
        }
        leave = leave.min(a.max(b));
    }
    (enter < leave).then_some((enter, leave, axis))
}

impl Bodies for Boxes {
    fn first(&self, centre: DVec3, slopes: DVec2) -> Option<Surface> {
        let way = slopes.extend(-1.0);
        let depth = centre.z - self.ground_z;
        let at = centre + way * depth;
        let mut best = (at.x.abs() <= self.ground_half && at.y.abs() <= self.ground_half).then_some(Surface {
            depth_m: depth,
            point: at.with_z(self.ground_z),
            part: 0,
            normal: DVec3::Z,
        });
        for (k, b) in self.solids.iter().enumerate() {
            let Some((enter, _, axis)) = slabs(centre, way, *b) else { continue };
            if best.is_none_or(|s| enter < s.depth_m) {
                let side = usize::from(way[axis] <= 0.0);
                let mut point = centre + way * enter;
                point[axis] = b[side][axis];
                let mut normal = DVec3::ZERO;
                normal[axis] = if side == 0 { -1.0 } else { 1.0 };
                best = Some(Surface { depth_m: enter, point, part: k as u32 + 1, normal });
            }
        }
        best
    }

    fn blocked(&self, from: &Surface, centre: DVec3) -> bool {
        // A piece of the line longer than nothing inside a box: 1e-11 of its length is far above rounding.
        self.solids.iter().any(|b| {
            slabs(from.point, centre - from.point, *b)
                .is_some_and(|(enter, leave, _)| leave.min(1.0) - enter.max(0.0) > 1e-11)
        })
    }
}

/// Ground at z = 0 (part 0) and a wedge (part 1): a slope that rises from (x0, 0) to (x1, h), and a wall that falls
/// from there. x1 may lie on either side of x0. It has no ends in y.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wedge {
    pub(crate) x0: f64,
    pub(crate) x1: f64,
    pub(crate) height: f64,
    pub(crate) ground_half: f64,
}

impl Wedge {
    fn slope(&self) -> f64 {
        self.height / (self.x1 - self.x0)
    }
}

impl Bodies for Wedge {
    fn first(&self, centre: DVec3, slopes: DVec2) -> Option<Surface> {
        let (s, h) = (self.slope(), centre.z);
        let surface = |depth_m: f64, part, normal| Surface {
            depth_m,
            point: centre + slopes.extend(-1.0) * depth_m,
            part,
            normal,
        };
        let (low, high) = (self.x0.min(self.x1), self.x0.max(self.x1));
        // h - depth = s (c + k depth - x0)
        let on_slope = (h - s * (centre.x - self.x0)) / (1.0 + s * slopes.x);
        let x = centre.x + slopes.x * on_slope;
        let mut best = None;
        if on_slope > 0.0 && (low..=high).contains(&x) {
            let facing = if h > s * (centre.x - self.x0) { 1.0 } else { -1.0 };
            best = Some(surface(on_slope, 1, DVec3::new(-s, 0.0, 1.0).normalize() * facing));
        }
        let on_wall = (self.x1 - centre.x) / slopes.x;
        let z = h - on_wall;
        if (0.0..=self.height).contains(&z) && best.is_none_or(|b: Surface| on_wall < b.depth_m) {
            let mut at = surface(on_wall, 1, DVec3::X * -slopes.x.signum());
            at.point.x = self.x1;
            best = Some(at);
        }
        let ground = surface(h, 0, DVec3::Z);
        if best.is_none() && ground.point.x.abs() <= self.ground_half && ground.point.y.abs() <= self.ground_half {
            best = Some(Surface { point: ground.point.with_z(0.0), ..ground });
        }
        best
    }

    fn blocked(&self, from: &Surface, centre: DVec3) -> bool {
        let rising = (self.x1 - self.x0).signum();
        if from.part == 1 && from.normal.z == 0.0 {
            // The wall looks away from the slope.
            return (centre.x - self.x1) * rising < 0.0;
        }
        if from.part == 1 {
            return centre.z < self.slope() * (centre.x - self.x0);
        }
        // Where the line is as high as the crest: beyond it, the wedge is in the way.
        let x = from.point.x + (centre.x - from.point.x) * self.height / centre.z;
        if (from.point.x - self.x0) * rising < 0.0 {
            (x - self.x1) * rising > 0.0
        } else {
            (x - self.x1) * rising < 0.0
        }
    }
}
