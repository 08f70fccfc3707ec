//! What lies around the buildings of an estate's site: drives, lots, paths, courts, pools, lawns with trees.

use super::slab::{self, Shape};
use crate::city::toronto::blocks::open::parking;
use crate::city::toronto::blocks::{BlockPlan, Stall};
use crate::city::toronto::ground_slot;
use crate::city::toronto::massing::{Building, Frame, Relief};
use crate::kit::ground::Patch;
use crate::kit::parcels::Site;
use crate::kit::polygon;
use glam::DVec2;
use satseed_scene::{Rng, SeedPath};

/// From the rectangle inside a site out to its street's kerb, m: a drive crosses the sidewalk, and ends before the
/// narrowest one does.
const TO_KERB_M: f64 = INSIDE_M + 4.6;

/// The rectangle inside a site keeps this far from its borders, which are not quite at right angles, m.
const INSIDE_M: f64 = 2.6;

/// Trees keep this far from each other, m.
const TREE_GAP_M: f64 = 4.6;

/// A site in the making, in its own frame: x along its street, y away from it.
pub(super) struct Grounds<'a> {
    frame: Frame,
    /// Corner of the rectangle in which things stand.
    pub(super) low: DVec2,
    /// The opposite corner.
    pub(super) high: DVec2,
    /// Where no tree grows.
    taken: Vec<Vec<DVec2>>,
    out: &'a mut BlockPlan,
}

impl<'a> Grounds<'a> {
    pub(super) fn new(site: &Site, out: &'a mut BlockPlan) -> Self {
        let frame = Frame::of(site);
        let local: Vec<DVec2> = site.outline.iter().map(|p| frame.local(*p)).collect();
        let (low, high) = polygon::bounds(&local);
        Self { frame, low: low + INSIDE_M, high: high - INSIDE_M, taken: Vec::new(), out }
    }

    /// Lays a surface.
    pub(super) fn lay(&mut self, outline: &[DVec2], slot: u16) {
        let (low, high) = polygon::bounds(outline);
        self.taken.push(outline.to_vec());
        self.out.patches.push(Patch {
            outline: outline.iter().map(|p| self.frame.world(*p)).collect(),
            slot,
            origin_m: self.frame.world((low + high) * 0.5),
            axis: self.frame.axis,
            lowered: false,
        });
    }

    /// A rectangle as a site of its own, its front towards the street.
    pub(super) fn piece(&self, low: DVec2, high: DVec2) -> Site {
        let outline = polygon::rectangle(low, high).iter().map(|p| self.frame.world(*p)).collect();
        Site { outline, front: 0, on_street: vec![false; 4], index: 0 }
    }

    /// Places a finished building.
    pub(super) fn place(&mut self, name: String, building: Building) {
        let outlines = building.plan.masses.iter().map(|m| building.plan.world_outline(m));
        self.taken.extend(outlines.map(|o| o.iter().map(|p| self.frame.local(*p)).collect()));
        self.out.buildings.push((name, building));
    }

    /// A block of flats at a place, its front along `axis`.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn stand(
        &mut self,
        name: &str,
        at: DVec2,
        axis: DVec2,
        shape: &Shape,
        storeys: u32,
        relief: &Relief<'_>,
        path: &SeedPath,
    ) {
        let direction = self.frame.axis * axis.x + self.frame.axis.perp() * axis.y;
        let frame = Frame { centre: self.frame.world(at), axis: direction };
        let building = slab::flats(&frame, shape, storeys, relief, path);
        // A paved strip before the entrance's side.
        let local = |p: DVec2| at + axis * p.x + axis.perp() * p.y;
        let door = shape.door;
        let strip = polygon::rectangle(door - DVec2::new(9.0, 8.5), door + DVec2::new(9.0, 0.6));
        let strip: Vec<DVec2> = strip.into_iter().map(local).collect();
        self.lay(&strip, ground_slot::PAVING);
        self.place(name.to_owned(), building);
    }

    /// A straight drive from the street to a depth.
    pub(super) fn drive(&mut self, x0: f64, x1: f64, to: f64) {
        let outline = polygon::rectangle(DVec2::new(x0, self.low.y - TO_KERB_M), DVec2::new(x1, to));
        self.lay(&outline, ground_slot::PAVING_DARK);
    }

    /// Walks between the site and its neighbours: one from the street to the back on some sides, and one along the block's
    /// middle, which belongs to the sites on one side of it.
    pub(super) fn walks(&mut self, path: &SeedPath) {
        let (low, high) = (self.low, self.high);
        if self.frame.axis.x > 0.0 {
            let (from, to) = (DVec2::new(low.x - INSIDE_M, high.y + 0.4), DVec2::new(high.x + INSIDE_M, high.y + 2.0));
            self.lay(&polygon::rectangle(from, to), ground_slot::PATH);
        }
        if path.child("walks").rng().chance(0.45) {
            let from = DVec2::new(high.x + 0.3, low.y - TO_KERB_M);
            self.lay(&polygon::rectangle(from, high + 1.9), ground_slot::PATH);
        }
    }

    /// A loop from the street to a door and back, with a lawn in it and a few cars on it.
    pub(super) fn loop_drive(&mut self, door: DVec2, half_m: f64) {
        let foot = self.low.y - TO_KERB_M;
        let rise = door.y - 7.6 - foot;
        let arc = |half: f64, rise: f64| -> Vec<DVec2> {
            (0..=20)
                .map(|k| {
                    let (s, c) = libm::sincos(core::f64::consts::PI * f64::from(k) / 20.0);
                    DVec2::new(door.x + half * c, foot + rise * s.sqrt())
                })
                .collect()
        };
        let mut ring = arc(half_m + 3.0, rise + 3.0);
        ring.extend(arc(half_m - 3.0, rise - 3.0).into_iter().rev());
        self.lay(&ring, ground_slot::PAVING_DARK);
        for (k, x) in [-5.5, 3.5].into_iter().enumerate() {
            let centre = self.frame.world(DVec2::new(door.x + x, foot + rise - 1.6 + k as f64 * 0.2));
            self.out.stalls.push(Stall { centre, axis: -self.frame.axis });
        }
        let path = polygon::rectangle(DVec2::new(door.x - 1.0, foot), DVec2::new(door.x + 1.0, foot + rise - 3.4));
        self.lay(&path, ground_slot::PATH);
    }

    /// A parking lot, its rows along the longer side, with islands of grass.
    pub(super) fn lot(&mut self, low: DVec2, high: DVec2, path: &SeedPath) {
        let size = high - low;
        if size.min_element() < 8.0 {
            return;
        }
        let mut piece = self.piece(low, high);
        let (long, short) = if size.y > size.x * 1.2 {
            piece.outline.rotate_left(1);
            (size.y, size.x)
        } else {
            (size.x, size.y)
        };
        let frame = Frame::of(&piece);
        parking(&piece, &frame, path, self.out);
        self.taken.push(polygon::rectangle(low, high));
        // Islands stand across some pairs of rows.
        let mut rng = path.child("islands").rng();
        let mut y = 5.5;
        while y < short - 6.0 {
            let mut x = 2.2;
            while x < long - 2.0 {
                let at = DVec2::new(x - long / 2.0, y + 0.9 - short / 2.0);
                let outline = polygon::oriented_rectangle(at, DVec2::X, DVec2::new(0.95, 4.7));
                let outline = polygon::rounded(&outline, 0.9, 3);
                let inside = |p: &DVec2| p.x.abs() < long / 2.0 - 1.0 && p.y.abs() < short / 2.0 - 1.0;
                if outline.iter().all(inside) && rng.chance(0.7) {
                    let world: Vec<DVec2> = outline.iter().map(|p| frame.world(*p)).collect();
                    self.out.stalls.retain(|s| {
                        polygon::border_distance(&world, s.centre) > 1.6 && !polygon::contains(&world, s.centre)
                    });
                    self.out.patches.push(Patch {
                        outline: world,
                        slot: ground_slot::YARD,
                        origin_m: frame.world(at),
                        axis: frame.axis,
                        lowered: false,
                    });
                    self.out.trees.push(frame.world(at));
                }
                x += 26.0 * rng.range(0.8, 1.4);
            }
            y += 17.5;
        }
    }

    /// Courts, a pool or a playground in a rectangle, where there is room.
    pub(super) fn amenity(&mut self, low: DVec2, high: DVec2, rng: &mut Rng) {
        let size = high - low;
        let kind = rng.weighted(&[0.3, 0.3, 0.3, 0.1]);
        let need = [DVec2::new(36.6, 18.3), DVec2::new(24.0, 17.0), DVec2::new(15.0, 13.0), DVec2::splat(1e3)][kind];
        let across = size.x < need.x + 2.0;
        let need = if across { DVec2::new(need.y, need.x) } else { need };
        if (size - need).min_element() < 2.0 {
            return;
        }
        let slack = (size - need) / 2.0 - 1.0;
        let at = (low + high) * 0.5 + DVec2::new(rng.signed() * slack.x, rng.signed() * slack.y);
        let along = if across { DVec2::Y } else { DVec2::X };
        let rect = |half: DVec2| polygon::oriented_rectangle(at, along, half);
        match kind {
            0 => {
                self.lay(&rect(DVec2::new(18.3, 9.15)), ground_slot::COURT_EDGE);
                self.lay(&rect(DVec2::new(11.9, 5.5)), ground_slot::COURT);
                if let Some(p) = self.out.patches.last_mut() {
                    p.axis = self.frame.axis * along.x + self.frame.axis.perp() * along.y;
                }
            }
            1 => {
                self.lay(&rect(DVec2::new(12.0, 8.5)), ground_slot::PAVING);
                self.lay(&polygon::rounded(&rect(DVec2::new(7.6, 4.1)), 1.2, 3), ground_slot::PLAZA);
                self.lay(&polygon::rounded(&rect(DVec2::new(7.1, 3.6)), 0.9, 3), ground_slot::POOL);
            }
            _ => self.lay(&polygon::rounded(&rect(DVec2::new(7.5, 6.5)), 4.0, 4), ground_slot::PLAY),
        }
    }

    /// Plants the lawns, a row along the street and old trees wherever nothing else is.
    pub(super) fn plant(self, parkland: bool, path: &SeedPath) {
        let Self { frame, low, high, taken, out } = self;
        let mut rng = path.child("lawn").rng();
        let mut trees: Vec<DVec2> = Vec::new();
        if parkland {
            let pitch = rng.range(8.5, 12.0);
            let mut x = low.x + rng.range(0.0, pitch);
            while x < high.x {
                let p = DVec2::new(x, low.y + rng.range(0.3, 1.4));
                if rng.chance(0.75) {
                    trees.push(p);
                }
                x += pitch * rng.range(0.9, 1.1);
            }
        }
        // Groups: a place draws others near it.
        let size = high - low;
        let groups = (size.x * size.y / 420.0) as u32;
        for _ in 0..groups {
            let middle = DVec2::new(rng.range(low.x, high.x), rng.range(low.y, high.y));
            for _ in 0..2 + rng.below(5) {
                let p = middle + DVec2::new(rng.signed(), rng.signed()) * 11.0;
                if p.cmpge(low).all() && p.cmple(high).all() && trees.iter().all(|t| t.distance(p) > TREE_GAP_M) {
                    trees.push(p);
                }
            }
        }
        let bounds: Vec<(DVec2, DVec2)> = taken.iter().map(|t| polygon::bounds(t)).collect();
        trees.retain(|p| {
            taken.iter().zip(&bounds).all(|(t, (low, high))| {
                let near = p.cmpge(*low - 1.0).all() && p.cmple(*high + 1.0).all();
                !near || (!polygon::contains(t, *p) && polygon::border_distance(t, *p) > 1.0)
            })
        });
        out.trees.extend(trees.into_iter().map(|p| frame.world(p)));
    }
}
