//! Residential and office towers on their podiums.

use super::{
    Building, Frame, GROUNDED, Kind, Relief, SetbackRanges, Setbacks, balconies, buildable, flat, grounded, plot,
};
use crate::kit::buildings::{BuildingPlan, Facade, Furnishing, Mass, Roof, furnish, slot};
use crate::kit::parcels::Site;
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::{Rng, SeedPath};

/// Height of a tower for a quantile 0..1: lognormal, median 125 m, sigma 0.4, clipped to 60..298 m.
pub(in crate::city::toronto) fn tower_height_m(quantile: f64) -> f64 {
    (125.0 * libm::exp(0.4 * normal_quantile(quantile))).clamp(60.0, 298.0)
}

/// Mean height of a mechanical penthouse, m.
pub(in crate::city::toronto) const PENTHOUSE_M: f64 = 7.5;

/// Inverse of the normal distribution (Abramowitz and Stegun 1964, 26.2.23; error below 4.5e-4).
fn normal_quantile(u: f64) -> f64 {
    let p = u.min(1.0 - u).max(1e-9);
    let t = (-2.0 * libm::log(p)).sqrt();
    let x =
        t - (2.515_517 + t * (0.802_853 + t * 0.010_328)) / (1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308)));
    if u < 0.5 { -x } else { x }
}

/// Outline of a residential plate within `half`, m.
fn plate(half: DVec2, rng: &mut Rng) -> Vec<DVec2> {
    let r = polygon::rectangle(-half, half);
    match rng.weighted(&[3.0, 3.0, 1.5, 1.2, 1.0]) {
        0 => r,
        1 => {
            // Corners cut back in steps.
            let n = DVec2::new(rng.range(1.5, 4.0), rng.range(1.5, 4.0));
            [
                (-half.x + n.x, -half.y),
                (half.x - n.x, -half.y),
                (half.x - n.x, -half.y + n.y),
                (half.x, -half.y + n.y),
                (half.x, half.y - n.y),
                (half.x - n.x, half.y - n.y),
                (half.x - n.x, half.y),
                (-half.x + n.x, half.y),
                (-half.x + n.x, half.y - n.y),
                (-half.x, half.y - n.y),
                (-half.x, -half.y + n.y),
                (-half.x + n.x, -half.y + n.y),
            ]
            .map(|(x, y)| DVec2::new(x, y))
            .to_vec()
        }
        2 => polygon::rounded(&r, rng.range(2.0, 4.0), 1),
        3 => polygon::rounded(&r, rng.range(6.0, 10.0), 4),
        _ => {
            // A waist on the long sides.
            let (d, w) = (rng.range(1.5, 3.0), rng.range(0.2, 0.4));
            [
                (-half.x, -half.y),
                (-half.x * w, -half.y),
                (-half.x * w, -half.y + d),
                (half.x * w, -half.y + d),
                (half.x * w, -half.y),
                (half.x, -half.y),
                (half.x, half.y),
                (half.x * w, half.y),
                (half.x * w, half.y - d),
                (-half.x * w, half.y - d),
                (-half.x * w, half.y),
                (-half.x, half.y),
            ]
            .map(|(x, y)| DVec2::new(x, y))
            .to_vec()
        }
    }
}

/// Where a tower stands on its podium: centre in the site's frame and half sizes. `None` when the site is too small.
pub(in crate::city::toronto) fn tower_place(site: &Site, office: bool, path: &SeedPath) -> Option<(DVec2, DVec2)> {
    let frame = Frame::of(site);
    let podium = buildable(site, &frame, Setbacks { street: 5.5, side: 4.0, back: 4.5 })?;
    let (low, high) = polygon::bounds(&podium);
    let mut rng = path.child("plate").rng();
    let room = (high - low) / 2.0;
    let half = if office {
        DVec2::new(rng.range(21.0, 27.0).min(room.x - 0.5), rng.range(21.0, 27.0).min(room.y - 0.5))
    } else if rng.chance(0.2) {
        DVec2::new(rng.range(18.5, 21.0).min(room.x - 0.5), rng.range(8.0, 9.2))
    } else {
        let w = rng.range(11.0, 13.8);
        DVec2::new(w.min(room.x - 0.5), (rng.range(665.0, 749.0) / (4.0 * w)).min(16.0))
    };
    let least = if office { 16.5 } else { 8.0 };
    let slack = room - half;
    if half.x < least || half.y < least.min(8.0) || slack.y < 0.3 {
        return None;
    }
    let at = (low + high) / 2.0 + DVec2::new(rng.signed() * slack.x * 0.7, rng.signed() * slack.y * 0.85);
    // Skewed sites: the whole plate must stand on the podium.
    let corners = polygon::oriented_rectangle(at, DVec2::X, half + DVec2::splat(0.3));
    corners.iter().all(|p| polygon::contains(&podium, *p)).then_some((at, half))
}

/// A residential tower on a podium.
pub(in crate::city::toronto) fn condo(
    site: &Site,
    place: (DVec2, DVec2),
    height_m: f64,
    relief: &Relief<'_>,
    path: &SeedPath,
) -> Option<Building> {
    let mut rng = path.child("condo").rng();
    let ranges = SetbackRanges { street: [0.6, 2.4], side: [0.15, 1.5], back: [1.0, 4.0] };
    let (frame, area) = plot(site, &ranges, &mut rng)?;
    let (centre, half) = place;
    let shop_m = rng.range(4.5, 6.0);
    let podium_floor = 3.3;
    let podium_m = shop_m + podium_floor * rng.range(1.6, 5.4).round();
    let podium_facade = if rng.chance(0.6) {
        Facade::Punched {
            recess_m: rng.range(0.12, 0.25),
            band_m: rng.range(0.9, 1.5),
            pier_m: rng.range(0.5, 1.2),
            proud_m: 0.02,
        }
    } else {
        Facade::Slabs { recess_m: 0.2, slab_m: 0.35, pier_every: 2 }
    };
    let podium = Mass {
        outline: area,
        low_m: GROUNDED,
        roof_m: podium_m,
        first_floor_m: shop_m,
        floor_m: podium_floor,
        bay_m: rng.range(3.0, 4.5),
        shop: true,
        facade: podium_facade,
        roof: Roof::Flat {
            parapet_m: rng.range(0.9, 1.2),
            slot: [slot::TERRACE, slot::GREEN, slot::ROOF][rng.weighted(&[0.4, 0.14, 0.46])],
        },
        balconies: Vec::new(),
    };
    let floor_m = rng.range(2.95, 3.1);
    // The uppermost floors may step back.
    let crown = if rng.chance(0.4) { 2.0 + rng.below(4) as f64 } else { 0.0 };
    let floors = libm::round((height_m - podium_m) / floor_m - crown).max(10.0);
    let roof_m = podium_m + floors * floor_m;
    let shape: Vec<DVec2> = plate(half, &mut rng).into_iter().map(|p| p + centre).collect();
    let bay_m = rng.range(2.8, 3.6);
    let facade = if rng.chance(0.78) {
        let every = [0, 2, 3, 4][rng.below(4) as usize];
        Facade::Slabs { recess_m: rng.range(0.12, 0.25), slab_m: rng.range(0.22, 0.6), pier_every: every }
    } else {
        Facade::Punched {
            recess_m: rng.range(0.15, 0.25),
            band_m: rng.range(0.9, 1.3),
            pier_m: rng.range(0.6, 1.3),
            proud_m: rng.range(-0.03, 0.12),
        }
    };
    let with_balconies = rng.chance(0.68);
    let rounded = shape.len() > 12;
    let tower = Mass {
        balconies: if with_balconies && !rounded { balconies(&shape, bay_m, &mut rng) } else { Vec::new() },
        outline: shape.clone(),
        low_m: podium_m - 0.4,
        roof_m,
        first_floor_m: podium_m + 0.25,
        floor_m: (roof_m - podium_m - 0.25) / floors,
        bay_m,
        shop: false,
        facade,
        roof: flat(rng.range(0.9, 1.2)),
    };
    let mut masses = vec![podium, tower];
    let mut top_m = roof_m;
    let mut top_half = half - DVec2::splat(1.8);
    if crown > 0.0 {
        let n = crown;
        top_half = half - DVec2::new(rng.range(2.5, 3.5), rng.range(2.0, 3.2));
        top_m = roof_m + n * 3.2;
        masses.push(Mass {
            outline: polygon::oriented_rectangle(centre, DVec2::X, top_half),
            low_m: roof_m - 0.35,
            roof_m: top_m,
            first_floor_m: roof_m + 0.2,
            floor_m: (top_m - roof_m - 0.2) / n,
            bay_m,
            shop: false,
            facade: Facade::Slabs { recess_m: 0.2, slab_m: 0.3, pier_every: 0 },
            roof: flat(0.9),
            balconies: Vec::new(),
        });
    }
    masses.push(penthouse(centre, top_half, top_m, &mut rng));
    let mut plan = grounded(&frame, relief, masses);
    let calm = Furnishing { base_m: podium_m, machines: 0.12, panels: 0.05, beds: 0.75, bulkhead: 0.3 };
    furnish_tower(&mut plan, (centre, half + DVec2::splat(1.9)), calm, path);
    Some(Building { kind: Kind::Condo, plan })
}

/// An office tower on a low base.
pub(in crate::city::toronto) fn office(
    site: &Site,
    place: (DVec2, DVec2),
    height_m: f64,
    relief: &Relief<'_>,
    path: &SeedPath,
) -> Option<Building> {
    let mut rng = path.child("office").rng();
    let ranges = SetbackRanges { street: [1.0, 4.5], side: [0.3, 2.5], back: [1.0, 3.5] };
    let (frame, area) = plot(site, &ranges, &mut rng)?;
    let (centre, half) = place;
    let shop_m = rng.range(5.5, 8.0);
    let base_m = shop_m + 4.2 * (1.0 + rng.below(3) as f64);
    let base = Mass {
        outline: area,
        low_m: GROUNDED,
        roof_m: base_m,
        first_floor_m: shop_m,
        floor_m: 4.2,
        bay_m: 4.5,
        shop: true,
        facade: Facade::Punched { recess_m: 0.25, band_m: 1.3, pier_m: 0.9, proud_m: 0.05 },
        roof: Roof::Flat { parapet_m: 1.1, slot: if rng.chance(0.4) { slot::TERRACE } else { slot::ROOF } },
        balconies: Vec::new(),
    };
    let floor_m = rng.range(3.9, 4.1);
    let curtain = rng.chance(0.65);
    let (facade, bay_m) = if curtain {
        (
            Facade::Curtain { fin_m: if rng.chance(0.6) { rng.range(0.08, 0.25) } else { 0.0 } },
            [1.5, 1.5, 3.0][rng.below(3) as usize],
        )
    } else {
        let proud_m = if rng.chance(0.5) { rng.range(0.08, 0.3) } else { 0.0 };
        (
            Facade::Punched { recess_m: 0.25, band_m: rng.range(1.2, 1.9), pier_m: rng.range(0.5, 1.1), proud_m },
            rng.range(3.0, 4.5),
        )
    };
    let mut masses = vec![base];
    let (mut low, mut h) = (base_m, half);
    let stages = 1 + rng.weighted(&[0.55, 0.3, 0.15]);
    for stage in 0..stages {
        let top =
            if stage + 1 == stages { height_m } else { base_m + (height_m - base_m) * (0.55 + 0.2 * stage as f64) };
        let floors = libm::round((top - low) / floor_m).max(3.0);
        let roof_m = low + floors * floor_m;
        masses.push(Mass {
            outline: polygon::oriented_rectangle(centre, DVec2::X, h),
            low_m: low - 0.5,
            roof_m,
            first_floor_m: low + 0.3,
            floor_m: (roof_m - low - 0.3) / floors,
            bay_m,
            shop: false,
            facade,
            roof: flat(rng.range(0.9, 1.2)),
            balconies: Vec::new(),
        });
        low = roof_m;
        h *= DVec2::new(rng.range(0.75, 0.9), rng.range(0.75, 0.9));
    }
    let under = h - DVec2::splat(1.0);
    masses.push(penthouse(centre, under, low, &mut rng));
    let mut plan = grounded(&frame, relief, masses);
    let what = Furnishing { base_m, machines: 0.3, panels: 0.1, beds: 0.35, bulkhead: 0.3 };
    furnish_tower(&mut plan, (centre, half + DVec2::splat(0.6)), what, path);
    Some(Building { kind: Kind::Office, plan })
}

/// The mechanical penthouse of a tower.
pub(in crate::city) fn penthouse(centre: DVec2, under: DVec2, base_m: f64, rng: &mut Rng) -> Mass {
    let half = DVec2::new(under.x * rng.range(0.45, 0.8), under.y * rng.range(0.45, 0.8));
    let at = centre + DVec2::new(rng.signed() * (under.x - half.x) * 0.5, rng.signed() * (under.y - half.y) * 0.5);
    let roof_m = base_m + rng.range(6.0, 9.0);
    Mass {
        outline: polygon::oriented_rectangle(at, DVec2::X, half),
        low_m: base_m - 0.3,
        roof_m,
        first_floor_m: base_m,
        floor_m: roof_m - base_m,
        bay_m: 0.0,
        shop: false,
        facade: Facade::Plain,
        roof: flat(rng.range(0.5, 0.9)),
        balconies: Vec::new(),
    }
}

/// Furniture of a tower's podium around its foot (centre and half sizes), and of all roofs above: around what stands on
/// them, and on top.
fn furnish_tower(plan: &mut BuildingPlan, foot: (DVec2, DVec2), podium: Furnishing, path: &SeedPath) {
    let foot = [polygon::oriented_rectangle(foot.0, DVec2::X, foot.1)];
    plan.items = furnish(&plan.masses[0].outline, &foot, podium, &path.child("podium roof"));
    for k in 1..plan.masses.len() {
        let above: Vec<Vec<DVec2>> = plan.masses.get(k + 1).map(|m| vec![m.outline.clone()]).unwrap_or_default();
        let last = k + 1 == plan.masses.len();
        let what = Furnishing {
            base_m: plan.masses[k].roof_m,
            machines: if last { 1.2 } else { 0.5 },
            panels: 0.06,
            beds: if last { 0.0 } else { 0.12 },
            bulkhead: if last { 0.5 } else { 0.2 },
        };
        let roof = path.child("roof").index(k as u64);
        let mut items = furnish(&plan.masses[k].outline, &above, what, &roof);
        plan.items.append(&mut items);
    }
}
