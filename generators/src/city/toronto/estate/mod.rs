//! The slab estate: towers in a park. Blocks of flats stand in lawns with drives, parking lots and old trees; rows of
//! houses, a school, a few shops and gardens lie between them.
//!
//! After the estates of the nineteen-sixties and seventies around the city's core (Thorncliffe Park, Flemingdon Park):
//! slabs of 10 to 20 storeys, about one to a hectare, that cover a tenth to a fifth of their land.

mod grounds;
mod slab;

use super::blocks::BlockPlan;
use super::blocks::open::scatter;
use super::blocks::site::rows;
use super::blocks::spread;
use super::massing::{self, Frame, Relief};
use super::{Params, ground_slot};
use crate::kit::parcels::Site;
use crate::kit::polygon;
use crate::kit::streets::Block;
use glam::DVec2;
use grounds::Grounds;
use satseed_scene::{Rng, SeedPath};
use slab::Shape;

/// What a site is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Use {
    Flats,
    Rows,
    School,
    Shops,
    Garden,
}

/// Least and greatest number of storeys of a block of flats.
pub(super) const STOREYS: [u32; 2] = [10, 20];

/// What a site of a block is used for; each block has its start in a low-discrepancy sequence, so that every frame has
/// about the same shares.
fn usage(params: &Params, site: &Site, u: f64, rng: &mut Rng) -> Use {
    let order = [Use::Flats, Use::Rows, Use::School, Use::Shops, Use::Garden];
    let limits = [0.76, 0.87, 0.92, 0.965];
    let wanted = order[limits.iter().take_while(|l| u >= **l).count()];
    let built = wanted != Use::Garden && rng.chance(params.density.min(1.0));
    if !built || site.front_m() < 48.0 { Use::Garden } else { wanted }
}

/// Decides a site and adds what stands and lies on it.
pub(super) fn site(
    params: &Params,
    block: &Block,
    site: &Site,
    relief: &Relief<'_>,
    city: &SeedPath,
    path: &SeedPath,
    out: &mut BlockPlan,
) {
    let [i, j] = block.index;
    let name = |what: &str| format!("block/{i}/{j}/site/{}/{what}", site.index);
    let start = |of: &str| city.child(of).rng().unit();
    let number = site.index as f64;
    let mut rng = path.child("use").rng();
    let usage = usage(params, site, spread(start("estate") + 0.618_033_988_749_895 * number, i, j), &mut rng);
    let mut grounds = Grounds::new(site, out);
    match usage {
        Use::Flats => {
            let count = f64::from(STOREYS[1] - STOREYS[0] + 1);
            // Another sequence than that of uses: the same one shifted would leave out some heights.
            let share = spread(start("storeys") + 0.414_213_562_373_095 * number, j, i);
            let storeys = STOREYS[0] + (share * count) as u32;
            flats(&mut grounds, storeys, &name, relief, path);
            grounds.walks(path);
        }
        Use::School => school(&mut grounds, &name, relief, path),
        Use::Shops => shops(&mut grounds, &name, relief, path),
        Use::Rows | Use::Garden => {}
    }
    match usage {
        Use::Rows => houses(site, &name, relief, path, out),
        Use::Garden => scatter(site, 7.0, path, out),
        Use::Flats | Use::School | Use::Shops => grounds.plant(usage == Use::Flats, path),
    }
}

/// Blocks of flats with their drives and parking.
fn flats(g: &mut Grounds<'_>, storeys: u32, name: &dyn Fn(&str) -> String, relief: &Relief<'_>, path: &SeedPath) {
    let mut rng = path.child("layout").rng();
    let (low, high) = (g.low, g.high);
    let (w, d) = (high.x - low.x, high.y - low.y);
    let depth_m = rng.range(15.5, 18.5);
    let arrangement = rng.weighted(&[0.44, 0.3, if w > 92.0 { 0.2 } else { 0.0 }, 0.18]);
    let middle = f64::midpoint(low.x, high.x);
    if arrangement == 1 || arrangement == 2 {
        // Slabs across the street's direction, a lot beside or between them.
        let mirrored = rng.chance(0.5);
        let x = |from_side: f64, side: bool| if side { high.x - from_side } else { low.x + from_side };
        let sides: &[bool] = if arrangement == 2 { &[false, true] } else { &[mirrored] };
        let mut reach = [low.x + 1.0, high.x - 1.0];
        for (k, side) in sides.iter().enumerate() {
            let length = rng.range(0.72, 1.0) * (d - 14.0).min(86.0);
            let shape = Shape::bar(length, depth_m - k as f64 * 0.7, &mut rng);
            let out_m = 5.0 + shape.half().y;
            let at = DVec2::new(
                x(out_m, *side),
                low.y + rng.range(7.0, 9.0).max((d - length) * rng.range(0.2, 0.7)) + length / 2.0,
            );
            let at = DVec2::new(at.x, at.y.min(high.y - 3.0 - length / 2.0));
            // The door looks towards the lot.
            let axis = if *side { -DVec2::Y } else { DVec2::Y };
            let storeys = if k == 0 { storeys } else { storeys - 1 + 2 * u32::from(storeys == STOREYS[0]) };
            g.stand(&name(&format!("flats/{k}")), at, axis, &shape, storeys, relief, &path.index(k as u64));
            let drive = x(out_m + shape.half().y + 7.6, *side);
            g.drive(drive - 3.0, drive + 3.0, at.y + length * 0.3);
            let clear = x(out_m + shape.half().y + 10.4, *side);
            if *side { reach[1] = clear } else { reach[0] = clear }
        }
        let from = low.y + rng.range(12.0, 24.0);
        let to = (high.y - 1.0).min(from + rng.range(52.0, 90.0));
        g.lot(DVec2::new(reach[0], from), DVec2::new(reach[1], to), path);
        g.amenity(DVec2::new(reach[0], to + 2.0), DVec2::new(reach[1], high.y), &mut rng);
        return;
    }
    // A slab along the street, or a winged tower, behind a loop; the lot behind it.
    let shape = if arrangement == 0 {
        Shape::bar(rng.range(0.85, 1.0) * (w - 15.0).min(94.0), depth_m, &mut rng)
    } else {
        Shape::winged(rng.range(19.0, 24.0).min(w / 2.0 - 9.0), rng.range(13.0, 15.0), &mut rng)
    };
    let half = shape.half();
    let slack = (w / 2.0 - 7.2 - half.x).max(0.0);
    let centre = DVec2::new(middle + rng.signed() * slack, low.y + rng.range(20.0, 30.0) + half.y);
    g.stand(&name("flats/0"), centre, DVec2::X, &shape, storeys, relief, path);
    let door = centre + shape.door;
    g.loop_drive(door, rng.range(16.0, 24.0).min(door.x - low.x - 3.5).min(high.x - 3.5 - door.x));
    let from = centre.y + half.y + rng.range(5.0, 9.0);
    let side = rng.chance(0.5);
    let x = if side { high.x - 3.2 } else { low.x + 3.2 };
    let width = rng.range(0.55, 1.0) * w;
    let (x0, x1) = if side { (high.x - width, high.x) } else { (low.x, low.x + width) };
    let to = (from + rng.range(17.5, 36.0)).min(high.y);
    if to - from > 12.0 {
        g.lot(DVec2::new(x0, from), DVec2::new(x1, to), path);
        g.drive(x - 3.0, x + 3.0, from + 2.0);
        let (a, b) = if side { (low.x, x0 - 2.0) } else { (x1 + 2.0, high.x) };
        g.amenity(DVec2::new(a, from), DVec2::new(b, high.y), &mut rng);
        g.amenity(DVec2::new(x0, to + 2.0), DVec2::new(x1, high.y), &mut rng);
    }
}

/// Two or three rows of houses behind one another, with lanes between.
fn houses(site: &Site, name: &dyn Fn(&str) -> String, relief: &Relief<'_>, path: &SeedPath, out: &mut BlockPlan) {
    let frame = Frame::of(site);
    let local: Vec<DVec2> = site.outline.iter().map(|p| frame.local(*p)).collect();
    let (low, high) = polygon::bounds(&local);
    let (low, high) = (low + 3.0, high - 3.0);
    let mut y = low.y;
    let mut k = 0;
    while y + 29.0 < high.y {
        let depth = 31.0_f64.min(high.y - y);
        let strip = polygon::rectangle(DVec2::new(low.x, y), DVec2::new(high.x, y + depth));
        let outline = strip.iter().map(|p| frame.world(*p)).collect();
        let piece = Site { outline, front: 0, on_street: vec![true, false, false, false], index: k };
        let path = path.child("row").index(k);
        rows(&piece, &name(&format!("row/{k}/house")), relief, &path, out);
        k += 1;
        y += depth + 5.0;
    }
}

/// A school: low wings around a yard, a playing field behind.
fn school(g: &mut Grounds<'_>, name: &dyn Fn(&str) -> String, relief: &Relief<'_>, path: &SeedPath) {
    let mut rng = path.child("school").rng();
    let (low, high) = (g.low, g.high);
    let depth = rng.range(30.0, 42.0);
    let piece =
        g.piece(DVec2::new(low.x + 3.0, low.y + 9.0), DVec2::new(high.x - rng.range(3.0, 16.0), low.y + 9.0 + depth));
    if let Some(building) = massing::shop(&piece, relief, &path.child("wings")) {
        g.place(name("school"), building);
    }
    g.drive(low.x + 0.5, low.x + 6.0, low.y + 16.0);
    let yard = low.y + 9.0 + depth + 3.0;
    g.lay(
        &polygon::rectangle(DVec2::new(low.x + 3.0, yard), DVec2::new(low.x + 38.0, yard + 20.0)),
        ground_slot::PAVING_DARK,
    );
    g.amenity(DVec2::new(low.x + 42.0, yard), DVec2::new(high.x, yard + 24.0), &mut rng);
    let field = polygon::rectangle(DVec2::new(low.x + 4.0, yard + 23.0), DVec2::new(high.x - 4.0, high.y - 2.0));
    if high.y - yard > 45.0 {
        g.lay(&polygon::rounded(&field, 6.0, 4), ground_slot::YARD);
    }
}

/// A row of shops behind its parking.
fn shops(g: &mut Grounds<'_>, name: &dyn Fn(&str) -> String, relief: &Relief<'_>, path: &SeedPath) {
    let (low, high) = (g.low, g.high);
    let depth = path.child("shops").rng().range(24.0, 36.0);
    let piece = g.piece(DVec2::new(low.x + 1.0, high.y - depth), high - 1.0);
    if let Some(building) = massing::shop(&piece, relief, &path.child("shops")) {
        g.place(name("shops"), building);
    }
    g.lot(DVec2::new(low.x, low.y), DVec2::new(high.x, high.y - depth - 2.0), path);
    g.drive(low.x + 8.0, low.x + 14.5, low.y + 4.0);
    g.drive(high.x - 15.0, high.x - 8.5, low.y + 4.0);
}

#[cfg(test)]
mod tests;
