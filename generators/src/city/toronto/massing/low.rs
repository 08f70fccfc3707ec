//! Mid-rise blocks of masonry, and low shops and workshops.

use super::{Building, Frame, GROUNDED, Kind, Relief, SetbackRanges, balconies, flat, grounded, laid_into, plot};
use crate::kit::buildings::{Balcony, Facade, Furnishing, Mass, furnish};
use crate::kit::parcels::Site;
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::SeedPath;

/// A mid-rise block, 18 to 36 m, of one of several shapes.
pub(in crate::city) fn mid_rise(site: &Site, relief: &Relief<'_>, path: &SeedPath) -> Option<Building> {
    let mut rng = path.child("mid").rng();
    let ranges = SetbackRanges { street: [0.3, 2.5], side: [0.12, 0.5], back: [0.6, 4.5] };
    let (frame, area) = plot(site, &ranges, &mut rng)?;
    let (low, high) = polygon::bounds(&area);
    if (high - low).min_element() < 9.0 {
        return None;
    }
    let wide = high.x - low.x > 26.0 && high.y - low.y > 30.0;
    let (a, b) = (rng.range(0.45, 0.7), rng.range(0.32, 0.42));
    let shape: Vec<[f64; 2]> = match if wide { rng.below(5) } else { rng.below(2) } {
        0 => vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        1 => vec![[0.0, 0.0], [1.0, 0.0], [1.0, a], [b + 0.3, a], [b + 0.3, 1.0], [0.0, 1.0]],
        2 => vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [b + 0.2, 1.0], [b + 0.2, a], [0.0, a]],
        3 => vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0 - b, 1.0], [1.0 - b, a], [b, a], [b, 1.0], [0.0, 1.0]],
        _ => vec![
            [0.0, 0.0],
            [b, 0.0],
            [b, a * 0.7],
            [1.0 - b, a * 0.7],
            [1.0 - b, 0.0],
            [1.0, 0.0],
            [1.0, 1.0],
            [0.0, 1.0],
        ],
    };
    let outline = laid_into(&area, &shape);
    let shop = rng.chance(0.6);
    let first_floor_m = if shop { rng.range(4.2, 5.2) } else { 1.0 };
    let floor_m = rng.range(3.1, 3.6);
    let floors = rng.range(4.6, 10.4).round();
    let roof_m = first_floor_m + floors * floor_m;
    let bay_m = rng.range(2.8, 4.2);
    let facade = match rng.weighted(&[0.7, 0.3]) {
        0 => Facade::Punched {
            recess_m: rng.range(0.12, 0.25),
            band_m: rng.range(1.2, 1.8),
            pier_m: rng.range(0.8, 1.8),
            proud_m: rng.range(-0.03, 0.06),
        },
        _ => Facade::Slabs { recess_m: 0.2, slab_m: 0.4, pier_every: 2 },
    };
    let with_balconies = rng.chance(0.3);
    let mut masses = vec![Mass {
        balconies: if with_balconies {
            street_only(&outline, site, &frame, balconies(&outline, bay_m, &mut rng))
        } else {
            Vec::new()
        },
        outline,
        low_m: GROUNDED,
        roof_m,
        first_floor_m,
        floor_m,
        bay_m,
        shop,
        facade,
        roof: flat(rng.range(0.7, 1.2)),
    }];
    let mut above = Vec::new();
    if shape.len() == 4 && rng.chance(0.45) {
        // One or two floors stepped back.
        if let Some(inner) = polygon::inset(&masses[0].outline, rng.range(2.2, 4.0)) {
            let (l, h) = polygon::bounds(&inner);
            if (h - l).min_element() > 6.0 {
                let top = roof_m + 3.3 * (1.0 + rng.below(2) as f64);
                above.push(inner.clone());
                masses.push(Mass {
                    outline: inner,
                    low_m: roof_m - 0.3,
                    roof_m: top,
                    first_floor_m: roof_m + 0.2,
                    floor_m: 3.25,
                    bay_m,
                    shop: false,
                    facade: Facade::Slabs { recess_m: 0.2, slab_m: 0.35, pier_every: 2 },
                    roof: flat(0.6),
                    balconies: Vec::new(),
                });
            }
        }
    }
    if wide
        && above.is_empty()
        && let Some(wing) = higher_wing(&area, &shape, a, &masses[0], path)
    {
        above.push(wing.outline.clone());
        masses.push(wing);
    }
    if shape.len() == 4 && above.is_empty() && rng.chance(0.75) {
        // Machine room, off the middle.
        let half = DVec2::new(rng.range(2.5, 6.0), rng.range(2.2, 4.5));
        let at = polygon::centroid(&masses[0].outline) + DVec2::new(rng.signed() * 4.0, rng.signed() * 6.0);
        let room = polygon::oriented_rectangle(at, DVec2::X, half);
        if room.iter().all(|p| {
            polygon::contains(&masses[0].outline, *p) && polygon::border_distance(&masses[0].outline, *p) > 1.5
        }) {
            above.push(room.clone());
            masses.push(Mass {
                outline: room,
                low_m: roof_m - 0.3,
                roof_m: roof_m + rng.range(3.0, 5.0),
                first_floor_m: roof_m,
                floor_m: 4.0,
                bay_m: 0.0,
                shop: false,
                facade: Facade::Plain,
                roof: flat(rng.range(0.2, 0.6)),
                balconies: Vec::new(),
            });
        }
    }
    let mut plan = grounded(&frame, relief, masses);
    for k in 0..plan.masses.len() {
        let what =
            Furnishing { base_m: plan.masses[k].roof_m, machines: 0.75, panels: 0.15, beds: 0.12, bulkhead: 0.9 };
        let over: &[Vec<DVec2>] = if k == 0 { &above } else { &[] };
        let items = furnish(&plan.masses[k].outline.clone(), over, what, &path.child("roof").index(k as u64));
        plan.items.extend(items);
    }
    Some(Building { kind: Kind::Block, plan })
}

/// One to three further floors over a part of a large block's long bar, which is its front one, `depth` deep of the whole, or
/// the rear one where the front is notched: large blocks have seldom one roof.
fn higher_wing(area: &[DVec2], shape: &[[f64; 2]], depth: f64, under: &Mass, path: &SeedPath) -> Option<Mass> {
    let mut rng = path.child("wing").rng();
    if area.len() != 4 || !rng.chance(0.65) {
        return None;
    }
    let notched = shape.iter().filter(|c| c[1] == 0.0).count() > 2;
    let (near, far) = match (notched, shape.len()) {
        (true, _) => (depth * 0.7 + 0.07, 0.93),
        (false, 4) => (0.07, rng.range(0.45, 0.7)),
        (false, _) => (0.07, depth - 0.07),
    };
    let width = rng.range(0.4, 0.7);
    let left = if rng.chance(0.5) { 0.07 } else { 0.93 - width };
    let right = left + width;
    let outline = laid_into(area, &[[left, near], [right, near], [right, far], [left, far]]);
    let clear = |p: &DVec2| polygon::contains(&under.outline, *p) && polygon::border_distance(&under.outline, *p) > 1.2;
    if !outline.iter().all(clear) {
        return None;
    }
    let floors = 1.0 + rng.below(3) as f64;
    let roof_m = under.roof_m + floors * under.floor_m;
    Some(Mass {
        outline,
        low_m: under.roof_m - 0.3,
        roof_m,
        first_floor_m: under.roof_m + 0.2,
        floor_m: (roof_m - under.roof_m - 0.2) / floors,
        bay_m: under.bay_m,
        shop: false,
        facade: under.facade,
        roof: flat(rng.range(0.6, 1.1)),
        balconies: Vec::new(),
    })
}

/// Balconies on edges whose front is free: not towards a party wall.
fn street_only(outline: &[DVec2], site: &Site, frame: &Frame, all: Vec<Balcony>) -> Vec<Balcony> {
    let local: Vec<DVec2> = site.outline.iter().map(|p| frame.local(*p)).collect();
    all.into_iter()
        .filter(|b| {
            let (p, q) = (outline[b.edge], outline[(b.edge + 1) % outline.len()]);
            let outward = -(q - p).normalize().perp();
            polygon::contains(&local, (p + q) * 0.5 + outward * 2.2)
        })
        .collect()
}

/// One or two storeys over nearly the whole site.
pub(in crate::city) fn shop(site: &Site, relief: &Relief<'_>, path: &SeedPath) -> Option<Building> {
    let mut rng = path.child("shop").rng();
    let ranges = SetbackRanges { street: [0.2, 1.2], side: [0.1, 0.3], back: [0.6, 5.0] };
    let (frame, area) = plot(site, &ranges, &mut rng)?;
    let a = rng.range(0.45, 0.75);
    let outline = if rng.chance(0.55) {
        laid_into(&area, &[[0.0, 0.0], [1.0, 0.0], [1.0, a], [0.55, a], [0.55, 1.0], [0.0, 1.0]])
    } else {
        area
    };
    let floors = 1.0 + rng.below(3) as f64;
    let floor_m = rng.range(3.6, 4.3);
    let roof_m = floors * floor_m + rng.range(0.5, 1.2);
    let mass = Mass {
        outline,
        low_m: GROUNDED,
        roof_m,
        first_floor_m: 0.0,
        floor_m,
        bay_m: rng.range(3.2, 5.0),
        shop: false,
        facade: Facade::Plain,
        roof: flat(rng.range(0.4, 1.0)),
        balconies: Vec::new(),
    };
    let mut plan = grounded(&frame, relief, vec![mass]);
    let what = Furnishing { base_m: roof_m, machines: 0.9, panels: 0.1, beds: 0.03, bulkhead: 0.35 };
    plan.items = furnish(&plan.masses[0].outline.clone(), &[], what, &path.child("roof"));
    Some(Building { kind: Kind::Shop, plan })
}
