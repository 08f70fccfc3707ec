//! Closed solids along a line: decks, walls, platforms, rails.

use super::mesh_builder::MeshBuilder;
use super::polygon;
use core::ops::RangeInclusive;
use glam::{DVec2, DVec3};

/// A point of a line that a section is swept along.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Station {
    /// Place in the plan, m.
    pub at: DVec2,
    /// Direction of the line there, unit.
    pub direction: DVec2,
    /// Height of the section's origin, m.
    pub height_m: f64,
}

/// A solid along some stations: `section` gives offset to the right and height against the station for each corner,
/// counter-clockwise seen by who looks along the line; `slots` those of its edges. Every station's section has as many
/// corners. Texture coordinates are metres along and to the left.
pub fn solid(
    b: &mut MeshBuilder,
    station: &dyn Fn(usize) -> Station,
    range: RangeInclusive<usize>,
    section: &dyn Fn(usize) -> Vec<DVec2>,
    slots: &[u16],
) {
    let corner = |k: usize, c: DVec2| -> DVec3 {
        let Station { at, direction, height_m } = station(k);
        (at - direction.perp() * c.x).extend(height_m + c.y)
    };
    let (from, to) = (*range.start(), *range.end());
    let mut s = 0.0;
    for k in from..to {
        let (near, far) = (section(k), section(k + 1));
        let length = station(k).at.distance(station(k + 1).at);
        for i in 0..near.len() {
            let j = (i + 1) % near.len();
            let uv = |c: DVec2, s: f64| DVec2::new(s, -c.x);
            b.fan(
                slots[i],
                &[
                    (corner(k, near[i]), uv(near[i], s)),
                    (corner(k + 1, far[j]), uv(far[j], s + length)),
                    (corner(k, near[j]), uv(near[j], s)),
                ],
            );
            b.fan(
                slots[i],
                &[
                    (corner(k, near[i]), uv(near[i], s)),
                    (corner(k + 1, far[i]), uv(far[i], s + length)),
                    (corner(k + 1, far[j]), uv(far[j], s + length)),
                ],
            );
        }
        s += length;
    }
    for (k, ahead) in [(from, false), (to, true)] {
        let outline = section(k);
        for t in polygon::triangulate(&outline) {
            let p = t.map(|i| (corner(k, outline[i]), outline[i]));
            let order = if ahead { [p[0], p[2], p[1]] } else { p };
            b.fan(slots[0], &order);
        }
    }
}
