//! Which rays go together.

use super::frame::axes;
use super::{LANES, STEEPEST};
use glam::{DVec2, DVec3};

/// How many times less packets must reach over for an order to be worth its while.
const LEAST_GAIN: f64 = 1.2;
/// Side of what a ray meets, about, m: a packet need not be much narrower.
const THING_M: f64 = 0.5;

/// An order in which rays, given as starts and ways of any length, make narrower packets than in the given one; none if there
/// is hardly any, or they go their own ways. The `k`-th is the ray that comes in place `k`.
///
/// Rays to the sun that start in crowns, side by side as the camera sees them, lie metres apart as the sun does: that is
/// where the order counts.
pub(crate) fn narrower(rays: impl ExactSizeIterator<Item = (DVec3, DVec3)> + Clone) -> Option<Vec<u32>> {
    let count = rays.len();
    if count <= 2 * LANES {
        return None;
    }
    let (start, mean) = rays.clone().fold((DVec3::ZERO, DVec3::ZERO), |(start, mean), (o, d)| (start + o, mean + d));
    let [x, y, z] = axes(mean);
    let sign = if mean[z] < 0.0 { -1.0 } else { 1.0 };
    let level = start[z] / count as f64;
    // Where they cross the plane through the middle of their starts.
    let mut places = Vec::with_capacity(count);
    for (o, d) in rays {
        let ahead = d[z] * sign;
        if !(d[x].abs() <= STEEPEST * ahead && d[y].abs() <= STEEPEST * ahead) {
            return None;
        }
        let t = (level - o[z]) / d[z];
        places.push(DVec2::new(o[x] + d[x] * t, o[y] + d[y] * t));
    }
    let given = reach(&places, 0..places.len());
    if given <= places.chunks(LANES).len() as f64 * grown(DVec2::splat(THING_M)) {
        return None;
    }
    let (low, size) = extent(places.iter().copied());
    let order = morton(&places, low, size.max_element());
    let found = reach(&places, order.iter().map(|k| *k as usize));
    (LEAST_GAIN * found < given).then_some(order)
}

/// Places in Morton's order on a grid of 256 by 256 squares.
fn morton(places: &[DVec2], low: DVec2, side: f64) -> Vec<u32> {
    let scale = f64::from(u8::MAX) / side;
    let keys: Vec<u16> = places
        .iter()
        .map(|place| {
            let at = (*place - low) * scale;
            every_other(at.x as u8) | every_other(at.y as u8) << 1
        })
        .collect();
    // By the lower byte, and then by the upper one without disturbing that.
    let mut order: Vec<u32> = (0..places.len() as u32).collect();
    let mut before = vec![0; places.len()];
    for shift in [0, 8] {
        let byte = |k: u32| usize::from(keys[k as usize] >> shift & 0xff);
        let mut next = [0_u32; 257];
        for k in &order {
            next[byte(*k) + 1] += 1;
        }
        for value in 0..256 {
            next[value + 1] += next[value];
        }
        core::mem::swap(&mut order, &mut before);
        for k in &before {
            let place = &mut next[byte(*k)];
            order[*place as usize] = *k;
            *place += 1;
        }
    }
    order
}

/// What packets may meet together: the sum of their areas, m^2, each grown by what a thing takes.
fn reach(places: &[DVec2], order: impl ExactSizeIterator<Item = usize>) -> f64 {
    let mut ordered = order.map(|k| places[k]);
    let mut sum = 0.0;
    while ordered.len() > 0 {
        sum += grown(extent(ordered.by_ref().take(LANES)).1);
    }
    sum
}

fn grown(size: DVec2) -> f64 {
    (size.x + THING_M) * (size.y + THING_M)
}

/// Lowest corner and size.
fn extent(places: impl Iterator<Item = DVec2>) -> (DVec2, DVec2) {
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for place in places {
        low = low.min(place);
        high = high.max(place);
    }
    (low, high - low)
}

/// Eight bits with a gap after each.
fn every_other(n: u8) -> u16 {
    let n = u16::from(n);
    let n = (n | n << 4) & 0x0f0f;
    let n = (n | n << 2) & 0x3333;
    (n | n << 1) & 0x5555
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rays(starts: impl Iterator<Item = DVec3>) -> Vec<(DVec3, DVec3)> {
        starts.map(|start| (start, DVec3::new(0.7, 0.1, 0.7))).collect()
    }

    /// A square of places over ground, row by row in squares as cameras have them, and in crowns of any height.
    fn square(height_m: impl Fn(u32) -> f64) -> impl Iterator<Item = DVec3> {
        crate::tile_order(16, 16)
            .zip(0..)
            .map(move |((i, j), k)| DVec3::new(0.1 * f64::from(i), 0.1 * f64::from(j), height_m(k)))
    }

    #[test]
    fn rays_from_level_ground_stay_as_they_are() {
        assert_eq!(narrower(rays(square(|_| 5.0)).into_iter()), None);
    }

    #[test]
    fn rays_from_crowns_make_narrower_packets() {
        let rough =
            |k: u32| 10.0 * f64::from(satseed_scene::unit_from_hash(satseed_scene::hash_cell(k as i32, 0, 0, 1)));
        let queries = rays(square(rough));
        let order = narrower(queries.iter().copied()).expect("they lie metres apart");
        let side = |order: &[u32]| -> f64 {
            let place = |k: &u32| {
                let o = queries[*k as usize].0;
                DVec2::new(o.y - o.z / 7.0, o.x - o.z)
            };
            order.chunks(LANES).map(|p| extent(p.iter().map(place)).1.max_element()).sum()
        };
        let given: Vec<u32> = (0..256).collect();
        assert!(side(&order) < 0.5 * side(&given), "{} against {}", side(&order), side(&given));
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, given);
    }

    #[test]
    fn rays_that_go_their_own_ways_have_no_order() {
        let mut queries = rays(square(f64::from));
        queries[7] = (DVec3::ZERO, DVec3::NEG_X);
        assert_eq!(narrower(queries.iter().copied()), None);
    }
}
