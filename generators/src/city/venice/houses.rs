//! Houses as data: a lot's outline in the world, heights, roof, and what stands on it.

use super::fabric::{Lot, Use};
use super::lie::{Lie, WATER_M};
use super::piece::{Piece, Side};
use super::roof::Roof;
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::{Rng, SeedPath, quantise_m};

/// Least and greatest height of eaves, m.
pub(super) const EAVES_M: [f64; 2] = [7.0, 22.0];
/// How deep walls go below the water, m.
pub(super) const FOOT_M: f64 = 1.7;

/// What covers a house.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Cover {
    /// Tiles.
    Tiles(Roof),
    /// A terrace behind a parapet of this height, m.
    Terrace(f64),
}

/// Something on a roof. Places are in the house's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Item {
    /// Chimney: half its width, and how high it stands above the tiles, m.
    Chimney { at: DVec2, axis: DVec2, half_m: DVec2, over_m: f64, flared: bool },
    /// Dormer looking along `out`: half its width, its depth, and the height of its front, m.
    Dormer { at: DVec2, out: DVec2, half_m: f64, depth_m: f64, front_m: f64 },
    /// Wooden platform on posts: half sizes, and height of its boards, m.
    Altana { at: DVec2, axis: DVec2, half_m: DVec2, deck_m: f64 },
    /// Skylight in the plane of the tiles.
    Skylight { at: DVec2, axis: DVec2, half_m: DVec2 },
    /// Antenna mast: height above the tiles, m.
    Mast { at: DVec2, over_m: f64 },
    /// A box on a terrace: air conditioner, pots, awning.
    Box { at: DVec2, axis: DVec2, half_m: DVec2, over_m: f64 },
}

/// A house.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct House {
    /// Its path below the city's.
    pub name: String,
    /// What it is.
    pub used: Use,
    /// Origin of its frame in the world, m, on the lattice.
    pub centre_m: DVec2,
    /// Outline of its walls, convex.
    pub outline: Vec<DVec2>,
    /// What lies beyond each wall.
    pub sides: Vec<Side>,
    /// Height of its eaves, m.
    pub eaves_m: f64,
    /// Height of a floor, m.
    pub floor_m: f64,
    /// Width of a bay, m.
    pub bay_m: f64,
    /// Cover.
    pub cover: Cover,
    /// What stands on it.
    pub items: Vec<Item>,
}

impl House {
    /// Its outline in the world.
    #[cfg(test)]
    pub(super) fn world_outline(&self) -> Vec<DVec2> {
        self.outline.iter().map(|p| self.centre_m + *p).collect()
    }

    /// Where its walls begin, m.
    pub(super) fn low_m() -> f64 {
        WATER_M - FOOT_M
    }
}

/// A piece's corners in the world, without those at which the outline is all but straight or turns inward.
pub(super) fn bent(piece: &Piece, lie: &Lie) -> Option<(Vec<DVec2>, Vec<Side>)> {
    let mut corners: Vec<(DVec2, Side)> =
        piece.corners.iter().map(|p| lie.world(*p)).zip(piece.sides.iter().copied()).collect();
    loop {
        let n = corners.len();
        if n < 3 {
            return None;
        }
        let flat = (0..n).find(|&i| {
            let (a, p, b) = (corners[(i + n - 1) % n].0, corners[i].0, corners[(i + 1) % n].0);
            let (u, v) = ((p - a).normalize_or_zero(), (b - p).normalize_or_zero());
            // Ten degrees, or a corner that a hand would hide.
            u.perp_dot(v) < 0.17 || a.distance(p) < 0.5
        });
        let Some(i) = flat else { break };
        // The side that goes is the shorter one's name.
        let before = (i + n - 1) % n;
        if corners[before].0.distance(corners[i].0) < corners[i].0.distance(corners[(i + 1) % n].0) {
            corners[before].1 = corners[i].1;
        }
        corners.remove(i);
    }
    Some(corners.into_iter().unzip())
}

/// A convex outline with each side moved outward by its own distance.
pub(super) fn widened(outline: &[DVec2], by_m: impl Fn(usize) -> f64) -> Vec<DVec2> {
    let n = outline.len();
    (0..n)
        .map(|i| {
            let (a, p, b) = (outline[(i + n - 1) % n], outline[i], outline[(i + 1) % n]);
            let (u, v) = ((p - a).normalize(), (b - p).normalize());
            let (du, dv) = (by_m((i + n - 1) % n), by_m(i));
            // Outward is right of a side; the corner is where both moved lines meet.
            let sin = u.perp_dot(v);
            p + (u * dv - v * du) / sin
        })
        .collect()
}

/// Whether a side of a moved outline runs against the side that it was.
pub(super) fn turned_around(outline: &[DVec2], moved: &[DVec2]) -> bool {
    let n = outline.len();
    (0..n).any(|i| {
        let j = (i + 1) % n;
        (outline[j] - outline[i]).dot(moved[j] - moved[i]) <= 0.0
    })
}

/// A house on a lot; none where the lot is too small.
pub(super) fn house(lot: &Lot, lie: &Lie, city: &SeedPath) -> Option<House> {
    let (world, sides) = bent(&lot.piece, lie)?;
    let centre = polygon::centroid(&world);
    let centre_m = DVec2::new(quantise_m(centre.x).into(), quantise_m(centre.y).into());
    let outline: Vec<DVec2> = world.iter().map(|p| *p - centre_m).collect();
    let area = polygon::area(&outline);
    let (axis, length_m, width_m) = Piece::new(outline.clone(), Side::Party).long_axis();
    if area < 12.0 || width_m < 2.0 {
        return None;
    }
    let mut rng = city.child(&lot.name).rng();
    let palace = sides.contains(&Side::Water) && area > 190.0;
    let eaves_m = match lot.used {
        Use::House => 13.5 + lot.block_m + if palace { 1.3 } else { 0.0 } + 2.25 * rng.normal(),
        // Wings and small back houses.
        Use::Wing => rng.range(3.4, 11.5),
    };
    let eaves_m = match lot.used {
        Use::House => eaves_m.clamp(EAVES_M[0], EAVES_M[1]),
        Use::Wing => eaves_m,
    };
    // Narrow houses are seldom the highest.
    let eaves_m = if width_m < 5.0 { eaves_m.min(12.0) } else { eaves_m };
    let floors = libm::round(eaves_m / rng.range(3.1, 3.7)).max(1.0);
    let terrace = rng.chance(if lot.used == Use::Wing { 0.12 } else { 0.03 });
    let cover = if terrace {
        Cover::Terrace(rng.range(0.7, 1.05))
    } else {
        Cover::Tiles(tiles(&outline, &sides, axis, lot.used, eaves_m, &mut rng))
    };
    let mut house = House {
        name: lot.name.clone(),
        used: lot.used,
        centre_m,
        outline,
        sides,
        eaves_m,
        floor_m: eaves_m / floors,
        bay_m: rng.range(1.9, 2.9),
        cover,
        items: Vec::new(),
    };
    let roof_path = city.child(&house.name).child("roof");
    furnish(&mut house, axis, [length_m, width_m], &roof_path);
    Some(house)
}

/// The roof of a house.
fn tiles(outline: &[DVec2], sides: &[Side], axis: DVec2, used: Use, eaves_m: f64, rng: &mut Rng) -> Roof {
    let n = outline.len();
    let slope = libm::tan(rng.range(18.0, 24.0_f64).to_radians());
    let hipped = rng.unit();
    let lean = used == Use::Wing && rng.chance(0.55);
    let inward = |i: usize| (outline[(i + 1) % n] - outline[i]).normalize().perp();
    let mut slopes: Vec<Option<f64>> = (0..n)
        .map(|i| {
            let end = inward(i).dot(axis).abs() > 0.72;
            let gable = if sides[i] == Side::Party { 0.78 } else { 0.3 };
            (!end || hipped > gable).then_some(slope)
        })
        .collect();
    if lean {
        // One plane, up to the neighbour's wall.
        let low = (0..n).filter(|i| sides[*i] != Side::Party).max_by(|a, b| {
            let length = |i: usize| outline[i].distance(outline[(i + 1) % n]);
            length(*a).total_cmp(&length(*b))
        });
        if let Some(low) = low {
            for (i, s) in slopes.iter_mut().enumerate() {
                *s = (i == low).then_some(slope * 0.8);
            }
        }
    }
    let overhang = rng.range(0.2, 0.42);
    let mut eaves = widened(outline, |i| if sides[i] == Side::Party || slopes[i].is_none() { 0.04 } else { overhang });
    if turned_around(outline, &eaves) {
        // A short side at a flat corner: an even edge.
        eaves = widened(outline, |_| 0.04);
    }
    Roof { outline: eaves, slopes, eaves_m }
}

/// Places things on a house.
fn furnish(house: &mut House, axis: DVec2, [length_m, width_m]: [f64; 2], path: &SeedPath) {
    let mut rng = path.rng();
    let area = polygon::area(&house.outline);
    let (low, high) = polygon::bounds(&house.outline);
    let mut taken: Vec<(DVec2, f64)> = Vec::new();
    let outline = house.outline.clone();
    let mut place = |rng: &mut Rng, clear_m: f64, near_border: bool| -> Option<DVec2> {
        for _ in 0..10 {
            let at = DVec2::new(rng.range(low.x, high.x), rng.range(low.y, high.y));
            let border = polygon::border_distance(&outline, at);
            let fits = polygon::contains(&outline, at)
                && border > clear_m
                && (!near_border || border < clear_m + 0.9)
                && taken.iter().all(|(p, r)| p.distance(at) > r + clear_m);
            if fits {
                taken.push((at, clear_m));
                return Some(at);
            }
        }
        None
    };
    let mut items = Vec::new();
    match &house.cover {
        Cover::Terrace(_) => {
            for _ in 0..(1.0 + area / 14.0) as u32 {
                let half_m = DVec2::new(rng.range(0.25, 0.9), rng.range(0.2, 0.5));
                let over_m = rng.range(0.4, 1.1);
                if let Some(at) = place(&mut rng, 1.1, true) {
                    items.push(Item::Box { at, axis, half_m, over_m });
                }
            }
        }
        Cover::Tiles(roof) => {
            if house.used == Use::House && area > 70.0 && rng.chance(0.10) {
                let half_m = DVec2::new(rng.range(1.5, 2.6), rng.range(1.2, 1.9));
                if let Some(at) = place(&mut rng, half_m.length() + 0.2, false) {
                    let top = [-1.0, 1.0].map(|s| roof.height_m(at + axis * (half_m.x * s)));
                    let deck_m = roof.height_m(at).max(top[0]).max(top[1]) + rng.range(0.5, 1.6);
                    items.push(Item::Altana { at, axis, half_m, deck_m });
                }
            }
            let dormers =
                if house.used == Use::House && width_m > 6.0 && rng.chance(0.33) { 1 + rng.below(2) } else { 0 };
            for _ in 0..dormers {
                let (half_m, front_m) = (rng.range(0.65, 1.15), rng.range(1.1, 1.7));
                let depth_m = front_m * 2.1;
                let Some(at) = place(&mut rng, 1.9, false) else { continue };
                let Some(side) = roof.side_at(at) else { continue };
                let n = outline.len();
                let out = -(outline[(side + 1) % n] - outline[side]).normalize().perp();
                items.push(Item::Dormer { at, out, half_m, depth_m, front_m });
            }
            let chimneys = (rng.range(0.3, 1.6) + area / 75.0).min(5.0) as u32;
            for _ in 0..chimneys {
                let half_m = DVec2::new(rng.range(0.28, 0.55), rng.range(0.24, 0.38));
                let over_m = rng.range(1.0, 2.4);
                let flared = rng.chance(0.6);
                let near = rng.chance(0.6);
                if let Some(at) = place(&mut rng, 0.75, near) {
                    items.push(Item::Chimney { at, axis, half_m, over_m, flared });
                }
            }
            if rng.chance(0.34) && length_m > 6.0 {
                for _ in 0..=rng.below(3) {
                    let half_m = DVec2::new(rng.range(0.3, 0.6), rng.range(0.4, 0.7));
                    let Some(at) = place(&mut rng, 1.0, false) else { continue };
                    let Some(side) = roof.side_at(at) else { continue };
                    let n = outline.len();
                    let along = (outline[(side + 1) % n] - outline[side]).normalize();
                    items.push(Item::Skylight { at, axis: along, half_m });
                }
            }
            if rng.chance(0.4)
                && let Some(at) = place(&mut rng, 0.5, false)
            {
                items.push(Item::Mast { at, over_m: rng.range(2.0, 4.0) });
            }
        }
    }
    house.items = items;
}
