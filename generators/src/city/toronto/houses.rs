//! Brick rows: houses wall to wall, each with a rear wing, a yard, and often a garage on the lane.

use super::massing::{Building, Frame, Kind, Relief};
use crate::kit::buildings::{BuildingPlan, Facade, Mass, Roof, RoofItem, RoofItemKind, slot};
use crate::kit::parcels::Site;
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::{Rng, SeedPath};

/// A piece of open ground by a house.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Yard {
    /// Towards the street.
    Front,
    /// Paved, behind the house.
    Patio,
    /// The rest behind the house.
    Rear,
}

/// What a row leaves on the ground.
#[derive(Clone, Debug, Default)]
pub(super) struct Row {
    /// Houses and garages.
    pub buildings: Vec<Building>,
    /// Yards, world outlines.
    pub yards: Vec<(Vec<DVec2>, Yard)>,
}

/// Fills a site with a row of houses.
pub(super) fn row(site: &Site, relief: &Relief<'_>, path: &SeedPath) -> Row {
    let frame = Frame::of(site);
    let local: Vec<DVec2> = site.outline.iter().map(|p| frame.local(*p)).collect();
    let (low, high) = polygon::bounds(&local);
    let mut rng = path.child("row").rng();
    let mut out = Row::default();
    // Skewed borders: the row stands where a straight strip fits.
    let margin = 0.6;
    let setback = rng.range(1.5, 4.5);
    let style = Style::draw(&mut rng);
    let mut x = low.x + margin;
    let mut k = 0;
    while x + 4.4 < high.x - margin {
        let unit = path.child("unit").index(k);
        let mut rng = unit.rng();
        let mut width = rng.range(5.0, 7.4);
        if high.x - margin - x - width < 4.4 {
            width = high.x - margin - x;
        }
        let strip = [x + 0.02, x + width - 0.02];
        x += width;
        k += 1;
        if width > 11.0 || rng.chance(0.03) {
            continue;
        }
        house(&frame, &local, strip, [low.y, high.y], setback, &style, relief, &mut rng, &mut out);
    }
    out
}

/// What houses of one row share.
struct Style {
    storeys: f64,
    storey_m: f64,
    depth_m: f64,
    flat: bool,
    rise_m: f64,
}

impl Style {
    fn draw(rng: &mut Rng) -> Self {
        Self {
            storeys: 2.0 + rng.weighted(&[0.35, 0.5, 0.15]) as f64 * 0.999,
            storey_m: rng.range(3.0, 3.4),
            depth_m: rng.range(12.0, 18.0),
            flat: rng.chance(0.5),
            rise_m: rng.range(2.0, 3.4),
        }
    }
}

fn mass(outline: Vec<DVec2>, roof_m: f64, roof: Roof, storey_m: f64) -> Mass {
    Mass {
        outline,
        low_m: -1.0,
        roof_m,
        first_floor_m: 0.4,
        floor_m: storey_m,
        bay_m: 2.6,
        shop: false,
        facade: Facade::Plain,
        roof,
        balconies: Vec::new(),
    }
}

#[allow(clippy::too_many_arguments)]
fn house(
    frame: &Frame,
    site: &[DVec2],
    [x0, x1]: [f64; 2],
    [y0, y1]: [f64; 2],
    setback: f64,
    style: &Style,
    relief: &Relief<'_>,
    rng: &mut Rng,
    out: &mut Row,
) {
    let front = y0 + 0.8 + setback + rng.range(-0.25, 0.25);
    let depth = (style.depth_m + rng.range(-1.0, 2.0)).min(y1 - front - 4.0);
    if depth < 7.0 {
        return;
    }
    let rect = |a: f64, b: f64, c: f64, d: f64| polygon::rectangle(DVec2::new(a, c), DVec2::new(b, d));
    let inside = |q: &[DVec2]| q.iter().all(|p| polygon::contains(site, *p));
    let body = rect(x0, x1, front, front + depth);
    if !inside(&body) {
        return;
    }
    let eaves = style.storeys.floor() * style.storey_m + rng.range(0.3, 0.9);
    let flat = if rng.chance(0.15) { !style.flat } else { style.flat };
    let roof = if flat {
        Roof::Flat { parapet_m: rng.range(0.3, 0.7), slot: slot::ROOF }
    } else {
        Roof::Gable { along_first: true, rise_m: style.rise_m * rng.range(0.9, 1.1), eaves_m: 0.015, hip: 0.0 }
    };
    let mut masses = vec![mass(body, eaves, roof, style.storey_m)];
    let mut items = Vec::new();
    // Rear wing, narrower and lower.
    let wing_depth = rng.range(3.0, 8.0).min(y1 - front - depth - 3.5);
    let mut rear = front + depth;
    if wing_depth > 2.0 && rng.chance(0.75) {
        let w = (x1 - x0) * rng.range(0.5, 0.75);
        let left = rng.chance(0.5);
        let (a, b) = if left { (x0 + 0.15, x0 + w) } else { (x1 - w, x1 - 0.15) };
        let wing = rect(a, b, rear - 0.6, rear + wing_depth);
        if inside(&wing) {
            let top = eaves - rng.range(0.4, 0.6) - if rng.chance(0.6) { style.storey_m } else { 0.0 };
            masses.push(mass(wing, top, Roof::Flat { parapet_m: 0.25, slot: slot::ROOF }, style.storey_m));
            rear += wing_depth;
        }
    }
    if rng.chance(0.7) {
        let ridge = if flat { eaves + 1.3 } else { eaves + style.rise_m + 0.6 };
        let y = if flat { front + depth * rng.range(0.15, 0.85) } else { front + depth * rng.range(0.42, 0.58) };
        items.push(RoofItem {
            kind: RoofItemKind::Chimney,
            centre_m: DVec2::new(if rng.chance(0.5) { x0 + 0.65 } else { x1 - 0.65 }, y),
            axis: DVec2::X,
            half_m: DVec2::new(0.35, rng.range(0.35, 0.7)),
            base_m: ridge - 1.2,
            height_m: 1.2,
        });
    }
    if flat {
        for _ in 0..=rng.below(3) {
            let at = DVec2::new(rng.range(x0 + 1.2, x1 - 1.2), front + depth * rng.range(0.15, 0.85));
            let sky = rng.chance(0.4);
            let kind = if sky { RoofItemKind::Skylight } else { RoofItemKind::Vent };
            let half_m = if sky { DVec2::new(0.6, 0.45) } else { DVec2::splat(0.18) };
            items.push(RoofItem {
                kind,
                centre_m: at,
                axis: DVec2::X,
                half_m,
                base_m: eaves,
                height_m: rng.range(0.45, 0.7),
            });
        }
    }
    // A fence along one border of the rear yard.
    let fence = rect(x0 + 0.03, x0 + 0.17, front + depth + 0.2, y1 - 0.9);
    if y1 - rear > 4.0 && inside(&fence) {
        let coping = Roof::Gable { along_first: false, rise_m: 0.04, eaves_m: 0.015, hip: 0.0 };
        masses.push(mass(fence, rng.range(1.4, 1.9), coping, 3.0));
    }
    push(frame, relief, Kind::House, masses, items, out);
    // A garage on the lane.
    let mut yard_end = y1 - 0.8;
    if y1 - rear > 11.0 && rng.chance(0.85) {
        let (a, b) = (x0 + rng.range(0.1, 0.4), x1 - rng.range(0.1, 1.2));
        let garage = rect(a, b, y1 - 1.0 - rng.range(5.5, 6.5), y1 - 1.0);
        if inside(&garage) {
            yard_end = garage[0].y - 0.3;
            let roof = if rng.chance(0.6) {
                Roof::Flat { parapet_m: 0.15, slot: slot::ROOF }
            } else {
                Roof::Gable { along_first: rng.chance(0.5), rise_m: rng.range(0.9, 1.6), eaves_m: 0.06, hip: 0.0 }
            };
            push(frame, relief, Kind::Shed, vec![mass(garage, rng.range(2.5, 3.0), roof, 3.0)], Vec::new(), out);
        }
    }
    let mut yard = |q: Vec<DVec2>, kind: Yard| {
        if inside(&q) {
            out.yards.push((q.iter().map(|p| frame.world(*p)).collect(), kind));
        }
    };
    if front - 0.3 - (y0 + 0.75) > 0.8 {
        yard(rect(x0 + 0.12, x1 - 0.12, y0 + 0.75, front - 0.3), Yard::Front);
    }
    let mut from = rear + 0.25;
    if yard_end - rear > 7.0 && rng.chance(0.8) {
        let to = from + rng.range(2.5, 5.5);
        let left = rng.chance(0.5);
        let w = (x1 - x0) * rng.range(0.55, 0.9);
        let (a, b) = if left { (x0 + 0.25, x0 + w) } else { (x1 - w, x1 - 0.12) };
        yard(rect(a, b, from, to), Yard::Patio);
        from = to + 0.1;
    }
    if yard_end - from > 2.0 {
        yard(rect(x0 + 0.25, x1 - 0.12, from, yard_end), Yard::Rear);
    }
}

fn push(frame: &Frame, relief: &Relief<'_>, kind: Kind, mut masses: Vec<Mass>, items: Vec<RoofItem>, out: &mut Row) {
    // Its own frame: the house's middle, so that its coordinates stay small.
    let centre = polygon::centroid(&masses[0].outline);
    for m in &mut masses {
        for p in &mut m.outline {
            *p -= centre;
        }
    }
    let items = items.into_iter().map(|i| RoofItem { centre_m: i.centre_m - centre, ..i }).collect();
    let world = frame.world(centre);
    let ground_m = relief(world);
    let mut plan = BuildingPlan { centre_m: world, axis: frame.axis, ground_m, drop_m: 0.0, masses, items };
    let lowest =
        plan.masses.iter().flat_map(|m| m.outline.iter()).map(|p| relief(plan.to_world(*p))).fold(ground_m, f64::min);
    plan.drop_m = ground_m - lowest;
    for m in &mut plan.masses {
        m.low_m = -plan.drop_m - 1.0;
    }
    out.buildings.push(Building { kind, plan });
}
