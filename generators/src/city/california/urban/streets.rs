//! Streets of the grid: carriageways, what lies, stands and moves on them, and a bridge over one of them.

use super::grid::{DIAGONAL_M, Grid};
use super::{Use, ground};
use crate::city::california::Params;
use crate::city::california::ground_slot as suburb;
use crate::city::california::lot::{Building, Content, Kind, Parked, Plant, Planted};
use crate::city::california::paving::Layer;
use crate::city::toronto::{self, ground_slot as slot, traffic};
use crate::kit::buildings::{BuildingPlan, Facade, Mass, Roof, slot as part};
use crate::kit::ground::Patch;
use crate::kit::polygon;
use crate::kit::streets::Segment;
use glam::DVec2;
use satseed_scene::SeedPath;

/// The asphalt below everything, and the diagonals on it.
pub(super) fn carriageways(grid: &Grid) -> Content {
    let mut out = Content::default();
    for cell in &grid.cells {
        let patch = Patch {
            outline: cell.clone(),
            slot: ground::of(slot::CARRIAGEWAY),
            origin_m: DVec2::ZERO,
            axis: DVec2::X,
            lowered: true,
        };
        out.patches.push((Layer::Yard, patch));
    }
    for d in &grid.diagonals {
        let side = d.along.perp();
        let edge = DIAGONAL_M[0] - 0.45;
        let inner = polygon::inset(&d.kerb, 0.5);
        let strip = inner
            .and_then(|k| polygon::clip(&k, d.through + side * edge, -side))
            .and_then(|k| polygon::clip(&k, d.through - side * edge, side));
        if let Some(outline) = strip {
            let slot = ground::of(slot::ROAD + toronto::materials::ROAD_AGES + 1);
            out.patches
                .push((Layer::Major, Patch { outline, slot, origin_m: d.through, axis: d.along, lowered: true }));
        }
    }
    out
}

/// A street between two crossings.
pub(super) fn segment(params: &Params, segment: &Segment, city: &SeedPath, detail_m: f64) -> (String, Content) {
    let [f, i, j] = segment.index;
    let name = format!("street/{f}/{i}/{j}");
    let borrowed = toronto::Params { trees: params.trees, vehicles: params.vehicles, ..toronto::Params::default() };
    let plan = traffic::plan(&borrowed, segment, city);
    let mut out = Content::default();
    for (k, patch) in plan.patches.into_iter().enumerate() {
        let layer = match k {
            _ if !patch.lowered => Layer::Island,
            0 => Layer::Major,
            _ => Layer::Mark,
        };
        out.patches.push((layer, Patch { slot: ground::of(patch.slot), ..patch }));
    }
    let middle = segment.street.at(f64::midpoint(segment.span_m[0], segment.span_m[1]), 0.0);
    if middle.length() > detail_m {
        out.patches.truncate(1);
        return (name, out);
    }
    out.vehicles = plan
        .vehicles
        .into_iter()
        .map(|v| Parked { centre: v.centre, axis: v.axis, body: v.body, lowered: true })
        .collect();
    out.lights = plan.lights;
    // A street has palms, or broad-leaved trees, or both in turn.
    let mut rng = city.child(&name).child("species").rng();
    let style = rng.weighted(&[0.4, 0.35, 0.25]);
    for (k, at) in plan.trees.into_iter().enumerate() {
        let plant = if style == 0 || (style == 2 && k % 2 == 0) { Plant::Palm } else { Plant::Broad };
        out.plants.push(Planted { at, plant, size: rng.range(0.6, 1.05) });
        let pit = polygon::oriented_rectangle(at, segment.street.direction, DVec2::splat(0.75));
        let patch =
            Patch { origin_m: at, outline: pit, slot: suburb::MULCH, axis: segment.street.direction, lowered: false };
        out.patches.push((Layer::Walk, patch));
    }
    (name, out)
}

/// Floor and roof of the bridge above the ground, m.
const BRIDGE_M: [f64; 2] = [6.4, 10.2];

/// The bridge for pedestrians between the first two buildings, from the pivot outward, that face each other over a street.
pub(super) fn footbridge(
    grid: &Grid,
    parts: &[(String, Content)],
    height_m: &dyn Fn(DVec2) -> f64,
    city: &SeedPath,
) -> Option<(String, Content)> {
    let mut segments: Vec<&Segment> = grid.segments.iter().filter(|s| s.street.section.kind < 3).collect();
    segments.sort_by_key(|s| (s.index[1].abs() + s.index[2].abs(), s.index));
    let walls: Vec<(Vec<DVec2>, f64)> = parts
        .iter()
        .flat_map(|(_, c)| &c.buildings)
        .flat_map(|(_, b)| b.plan.masses.iter().filter(|m| m.low_m < 0.0).map(|m| (b.plan.world_outline(m), m.roof_m)))
        .filter(|(o, roof_m)| *roof_m > BRIDGE_M[1] + 2.5 && o[0].length() < 480.0)
        .collect();
    let high = |p: DVec2| walls.iter().any(|(o, _)| polygon::contains(o, p));
    for segment in segments {
        let half = segment.street.section.right_of_way_m() / 2.0;
        let [s0, s1] = segment.span_m;
        for k in 1..12 {
            let along = s0 + (s1 - s0) * f64::from(k) / 12.0;
            // Both walls must stand on the whole width of the bridge.
            let wall = |side: f64| {
                let depths = (0..20).map(|d| half + 0.5 * f64::from(d));
                let stands = |d: f64| [-2.4, 0.0, 2.4].iter().all(|w| high(segment.street.at(along + w, side * d)));
                depths.into_iter().find(|d| stands(*d))
            };
            let (Some(left), Some(right)) = (wall(1.0), wall(-1.0)) else { continue };
            let centre = segment.street.at(along, (left - right) / 2.0);
            let name = format!("footbridge/{}/{}/{}", segment.index[0], segment.index[1], segment.index[2]);
            let span = f64::midpoint(left, right) + 0.4;
            let masses = vec![Mass {
                outline: polygon::rectangle(DVec2::new(-span, -2.0), DVec2::new(span, 2.0)),
                low_m: BRIDGE_M[0],
                roof_m: BRIDGE_M[1],
                first_floor_m: BRIDGE_M[0] + 0.6,
                floor_m: BRIDGE_M[1] - BRIDGE_M[0] - 0.6,
                bay_m: 2.5,
                shop: false,
                facade: Facade::Curtain { fin_m: if city.child(&name).rng().chance(0.5) { 0.12 } else { 0.0 } },
                roof: Roof::Flat { parapet_m: 0.2, slot: part::ROOF },
                balconies: Vec::new(),
            }];
            let axis = segment.street.direction.perp();
            let plan = BuildingPlan {
                centre_m: centre,
                axis,
                ground_m: height_m(centre),
                drop_m: 0.0,
                masses,
                items: Vec::new(),
            };
            let kind = Kind::Urban(Use::Footbridge);
            let building = Building { kind, plan, extras: Vec::new(), ridge_m: BRIDGE_M[1] };
            return Some((name.clone(), Content { buildings: vec![(name, building)], ..Content::default() }));
        }
    }
    None
}
