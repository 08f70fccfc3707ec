//! A block of the low city: shops on the larger streets, apartments and workshops behind, alleys of 6 m between.

use super::grid::CityBlock;
use super::site::{Place, Work, wide_enough};
use super::{Use, apartments, ground, open, store, yard};
use crate::city::california::Params;
use crate::city::california::lot::Content;
use crate::city::california::paving::Layer;
use crate::city::toronto::ground_slot as slot;
use crate::city::toronto::massing::{self, Relief};
use crate::kit::parcels::{Site, subdivide};
use crate::kit::polygon;
use satseed_scene::SeedPath;

/// Width of an alley, m.
const ALLEY_M: f64 = 6.0;

/// What prevails in a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Character {
    Shops,
    Homes,
    Works,
    Large,
}

/// Shares of what prevails, spread evenly over the numbers of blocks (Roberts 2018, the R2 sequence).
fn character(block: &CityBlock, city: &SeedPath) -> Character {
    let [i, j] = block.index;
    let x =
        city.child("character").rng().unit() + i as f64 * 0.754_877_666_246_692_7 + j as f64 * 0.569_840_290_998_053_2;
    let u = x - libm::floor(x);
    let limits = if block.busy { [0.56, 0.72, 0.87] } else { [0.16, 0.66, 0.96] };
    let order = [Character::Shops, Character::Homes, Character::Works, Character::Large];
    order[limits.iter().take_while(|l| u >= **l).count()]
}

fn site_width_m(character: Character, path: &SeedPath) -> f64 {
    let mut rng = path.rng();
    let [from, to] = match character {
        Character::Shops => *rng.pick(&[[11.0, 18.0], [16.0, 28.0], [30.0, 46.0]]),
        Character::Homes => *rng.pick(&[[15.0, 18.5], [15.0, 20.0], [28.0, 38.0]]),
        Character::Works => *rng.pick(&[[14.0, 24.0], [22.0, 38.0]]),
        Character::Large => [70.0, 120.0],
    };
    rng.range(from, to)
}

/// Decides a block.
pub(super) fn plan(params: &Params, block: &CityBlock, relief: &Relief<'_>, city: &SeedPath) -> Content {
    let mut work = Work { params, relief, out: Content::default(), taken: Vec::new() };
    let axis = (block.kerb[1] - block.kerb[0]).normalize();
    work.cover(Layer::Yard, polygon::rounded(&block.kerb, 7.0, 5), ground::of(slot::SIDEWALK), axis);
    if let Some(inner) = polygon::inset(&block.property, 0.06) {
        work.cover(Layer::Yard, inner, ground::of(slot::YARD), axis);
    }
    let n = block.property.len();
    let whole = |front: usize| Site { outline: block.property.clone(), front, on_street: vec![true; n], index: 80 };
    if n != 4 {
        let site = whole(0);
        let place = Place::new(&site, &block.name, &block.key);
        let mut rng = place.key.child("wedge").rng();
        work.floor(&place, ground::YARDS[1]);
        store::flatiron(&mut work, &place, &mut rng);
        return work.out;
    }
    let character = character(block, city);
    if character == Character::Large {
        let long =
            usize::from(block.property[1].distance(block.property[2]) > block.property[0].distance(block.property[1]));
        let site = whole(long + 2 * block.key.child("front").rng().below(2) as usize);
        let place = Place::new(&site, &block.name, &block.key);
        if block.key.child("built").rng().unit() < params.density && store::large(&mut work, &place) {
            return work.out;
        }
    }
    let cut = subdivide(&block.property, ALLEY_M, &block.key.child("rows"), |p| site_width_m(character, p));
    if let Some(lane) = cut.lane.and_then(|l| polygon::inset(&l, 0.1)) {
        work.cover(Layer::Front, lane, ground::of(slot::LANE), axis);
    }
    for site in &cut.sites {
        one_site(&mut work, &Place::new(site, &block.name, &block.key), character, block.busy);
    }
    work.out
}

fn one_site(work: &mut Work<'_>, place: &Place<'_>, character: Character, busy: bool) {
    let mut rng = place.key.child("use").rng();
    let built = rng.unit() < work.params.density;
    let wide = place.site.front_m() > 26.0;
    // Shop, mall, drive-through, station, mid-rise, box on posts, court, walk-up, works, parking, cleared.
    let weights = match (character, wide) {
        (Character::Shops, true) => [0.15, 0.27, 0.14, 0.09, 0.17, 0.0, 0.03, 0.05, 0.04, 0.04, 0.02],
        (Character::Shops, false) => [0.74, 0.05, 0.0, 0.0, 0.05, 0.03, 0.0, 0.03, 0.04, 0.04, 0.02],
        (Character::Homes, true) => [0.0, 0.02, 0.0, 0.0, 0.03, 0.08, 0.45, 0.34, 0.0, 0.06, 0.02],
        (Character::Homes, false) => [0.02, 0.0, 0.0, 0.0, 0.0, 0.66, 0.0, 0.26, 0.01, 0.03, 0.02],
        (_, true) => [0.02, 0.05, 0.03, 0.02, 0.03, 0.0, 0.0, 0.0, 0.76, 0.06, 0.03],
        (_, false) => [0.08, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.8, 0.08, 0.04],
    };
    let usage = rng.weighted(&weights);
    let stands = built
        && match usage {
            0 => store::shop(work, place),
            1 => store::mall(work, place),
            2 => store::drive_through(work, place),
            3 => store::station(work, place),
            4 => busy && mid_rise(work, place),
            5 => apartments::dingbat(work, place),
            6 => apartments::court(work, place),
            7 => apartments::walk_up(work, place),
            8 => yard::works(work, place),
            _ => false,
        };
    if stands {
        return;
    }
    let Some(r) = place.rect(0.8, 0.4, 0.4) else {
        work.floor(place, ground::YARDS[1]);
        return;
    };
    // What found no room becomes the next best thing.
    let next = built
        && usage < 9
        && match character {
            Character::Shops => store::shop(work, place),
            Character::Homes => apartments::dingbat(work, place) || apartments::walk_up(work, place),
            _ => yard::works(work, place),
        };
    if !next {
        if usage == 10 || r[1] - r[0] < 12.0 { open::cleared(work, place, r) } else { open::lot(work, place, r) }
    }
}

/// A mid-rise block of 15 to 30 m on a larger street.
fn mid_rise(work: &mut Work<'_>, place: &Place<'_>) -> bool {
    let relief = work.relief;
    let draw =
        |k: u64| massing::mid_rise(place.site, relief, &place.key.child("mid-rise").index(k)).and_then(wide_enough);
    let Some(plan) = (0..8).find_map(|k| draw(k).filter(|p| p.roof_m() < 31.0)) else { return false };
    work.floor(place, ground::YARDS[2]);
    work.adopt(place, Use::Block, plan);
    true
}
