//! The ground: asphalt of several ages, concrete, and the mosaic of yards.

use super::super::freeway::slot as deck;
use super::super::ground_slot as slot;
use crate::city::toronto::materials::surfaces::{
    aged, asphalt, bgr, brightness, concrete, noise, paint_left, repeating,
};
use satseed_scene::{Bands, Brdf, Class, Coordinate, Field, Layer, Material, Space};

/// The materials of all ground slots, in their order.
pub(super) fn materials(seed: &impl Fn(&str, u64) -> u32) -> Vec<Material> {
    let blank = Material::diffuse("blank", Class::Ground, Bands::grey(0.2));
    let mut out = vec![blank; slot::COUNT];
    let mut put = |slot: u16, m: Material| out[slot as usize] = m;
    put(slot::LAND, open_land(seed("land", 0)));
    put(slot::KERB, concrete("kerb", Class::Ground, 0.3, 0.0, seed("kerb", 0)));
    put(slot::SIDEWALK, concrete("sidewalk", Class::Ground, 0.28, 1.5, seed("sidewalk", 0)));
    put(slot::PARKWAY, yard("parkway", [0.55, 0.2], seed("parkway", 0)));
    put(slot::GUTTER, gutter(seed("gutter", 0)));
    for k in 0..slot::ASPHALTS {
        let age = [0.35, 0.6, 0.8, 1.0][k as usize];
        put(slot::ASPHALT + k, sealed(&format!("local asphalt {k}"), age, seed("local", u64::from(k))));
    }
    put(slot::ARTERIAL, lanes("arterial", 0.7, true, seed("arterial", 0)));
    put(slot::COLLECTOR, lanes("collector", 0.8, false, seed("collector", 0)));
    put(slot::JUNCTION, asphalt("junction", 0.75, seed("arterial", 0)));
    let wear = paint_left(seed("paint", 0), 3.0, 0.65);
    let ladder = Field::Product(vec![repeating(Coordinate::V, 1.25, 0.55, 0.2), wear.clone()]);
    let paint = bgr(0.4, 0.42, 0.43);
    put(
        slot::CROSSING,
        asphalt("crossing", 0.7, seed("arterial", 0)).with(Layer::Mix { color: paint, amount: ladder.times(0.8) }),
    );
    put(
        slot::STOP,
        asphalt("stop bar", 0.7, seed("arterial", 0))
            .with(Layer::Mix { color: paint, amount: wear.clone().times(0.8) }),
    );
    put(slot::PATCH, asphalt("patch", 0.15, seed("patch", 0)));
    put(slot::TRENCH, asphalt("trench", 0.35, seed("patch", 1)));
    put(slot::MEDIAN, yard("median", [0.35, 0.35], seed("median", 0)));
    put(slot::MULCH, soil("mulch", bgr(0.06, 0.078, 0.1), 0.16, seed("mulch", 0)));
    put(slot::COPING, concrete("coping", Class::Ground, 0.4, 0.0, seed("coping", 0)));
    let stalls = Field::Product(vec![
        repeating(Coordinate::U, 2.6, 0.11, -0.055),
        repeating(Coordinate::V, 17.5, 11.0, -5.5),
        noise(seed("stall", 1), 5.0, 3).affine(0.7, 0.6).ramp(0.0, 1.0),
    ]);
    let spots = noise(seed("stall", 2), 1.9, 2).ramp(0.3, 0.55).times(0.4);
    put(
        slot::PARKING,
        sealed("parking lot", 0.8, seed("stall", 0))
            .with(Layer::Mix { color: paint, amount: stalls.times(0.75) })
            .with(Layer::Mix { color: bgr(0.05, 0.05, 0.052), amount: spots }),
    );
    put(slot::PLAZA, concrete("plaza", Class::Ground, 0.24, 3.0, seed("plaza", 0)));
    put(slot::TURF, turf(seed("turf", 0)));
    put(slot::INFIELD, soil("infield", bgr(0.1, 0.14, 0.215), 0.08, seed("infield", 0)));
    put(slot::COURT, court(seed("court", 0)));
    put(slot::TRACK, soil("sand", bgr(0.19, 0.25, 0.3), 0.1, seed("track", 0)));
    put(slot::YARD_ASPHALT, sealed("yard asphalt", 0.85, seed("yard asphalt", 0)));
    // Green and the part of it that is dry or worn: from watered to bare.
    let front: [[f32; 2]; 7] =
        [[1.0, 0.08], [0.85, 0.25], [0.65, 0.35], [0.45, 0.5], [0.25, 0.45], [0.12, 0.7], [0.05, 1.0]];
    for (k, look) in front.into_iter().enumerate() {
        put(slot::FRONT[k], yard(&format!("front yard {k}"), look, seed("front", k as u64)));
    }
    put(slot::FRONT[7], soil("gravel yard", bgr(0.19, 0.215, 0.235), 0.1, seed("front", 7)));
    put(slot::FRONT[8], soil("bark yard", bgr(0.075, 0.1, 0.135), 0.14, seed("front", 8)));
    let rear: [[f32; 2]; 6] = [[0.95, 0.15], [0.7, 0.4], [0.45, 0.6], [0.25, 0.7], [0.12, 0.8], [0.06, 1.0]];
    for (k, look) in rear.into_iter().enumerate() {
        put(slot::REAR[k], yard(&format!("rear yard {k}"), look, seed("rear", k as u64)));
    }
    put(slot::REAR[6], soil("gravel rear yard", bgr(0.165, 0.19, 0.21), 0.12, seed("rear", 6)));
    put(slot::REAR[7], concrete("paved rear yard", Class::Ground, 0.24, 3.0, seed("rear", 7)));
    for (k, (level, joint)) in [(0.3, 3.0), (0.25, 2.4), (0.2, 3.0), (0.35, 1.5)].into_iter().enumerate() {
        let m = concrete(&format!("drive {k}"), Class::Ground, level, joint, seed("drive", k as u64));
        let oil = noise(seed("drive oil", k as u64), 2.4, 2).ramp(0.28, 0.6).times(0.35);
        put(slot::DRIVE[k], m.with(Layer::Mix { color: bgr(0.09, 0.09, 0.09), amount: oil }));
    }
    put(slot::DRIVE[4], pavers("red pavers", bgr(0.1, 0.13, 0.19), seed("drive", 4)));
    put(slot::DRIVE[5], pavers("grey pavers", bgr(0.15, 0.17, 0.185), seed("drive", 5)));
    let water = [bgr(0.37, 0.35, 0.15), bgr(0.34, 0.31, 0.11), bgr(0.3, 0.32, 0.13), bgr(0.07, 0.13, 0.07)];
    for (k, base) in water.into_iter().enumerate() {
        let s = seed("pool", k as u64);
        let mut m =
            Material::diffuse(&format!("pool {k}"), Class::Water, Bands::new(base.0[0], base.0[1], base.0[2], 0.02))
                .with(brightness(noise(s, 5.0, 2).times(0.14)))
                .with(brightness(noise(s ^ 1, 0.9, 2).times(0.1)));
        m.brdf = Brdf::Coated { index: Brdf::WATER_INDEX };
        put(slot::POOL[k], m);
    }
    out
}

/// A yard by how green it is, and how much of it is dry or bare.
fn yard(name: &str, [green, worn]: [f32; 2], seed: u32) -> Material {
    let lush = Bands::new(0.032, 0.074, 0.046, 0.36);
    let faded = Bands::new(0.062, 0.108, 0.1, 0.32);
    let straw = bgr(0.095, 0.135, 0.175);
    let bare = bgr(0.115, 0.15, 0.19);
    let base = if green > 0.5 { faded.lerp(lush, green * 2.0 - 1.0) } else { straw.lerp(faded, green * 2.0) };
    let class = if green > 0.09 { Class::LowVegetation } else { Class::Ground };
    let m = aged(Material::diffuse(name, class, base).rough(0.5), seed, 0.15, 0.13);
    let dry = noise(seed ^ 0x15, 7.0, 4).ramp(0.55 - 1.1 * worn, 0.85 - 0.9 * worn);
    let trodden = noise(seed ^ 0x16, 3.6, 3).ramp(0.75 - 0.75 * worn, 1.0 - 0.7 * worn);
    let tufts = noise(seed ^ 0x17, 1.6, 2).ramp(0.25, 0.5).times(0.25 + 0.3 * (1.0 - worn));
    m.with(Layer::Mix { color: straw.lerp(faded, green * 0.7), amount: dry.times(0.8) })
        .with(Layer::Mix { color: bare, amount: trodden.times(0.3 + 0.55 * worn) })
        .with(Layer::Mix { color: lush.lerp(faded, 0.4), amount: tufts.times(0.6) })
}

/// Dry grass of last winter, thin and thick, with low scrub that is still green and with bare tracks.
fn open_land(seed: u32) -> Material {
    let straw = noise(seed ^ 0x61, 26.0, 4).ramp(-0.05, 0.35).times(0.75);
    let scrub = Field::Product(vec![
        noise(seed ^ 0x62, 38.0, 3).ramp(0.0, 0.3),
        noise(seed ^ 0x63, 2.2, 3).ramp(0.0, 0.3).times(0.7),
    ]);
    let bare = noise(seed ^ 0x64, 13.0, 4).ramp(0.22, 0.45).times(0.7);
    yard("open land", [0.12, 0.6], seed)
        .with(Layer::Mix { color: bgr(0.12, 0.165, 0.2), amount: straw })
        .with(Layer::Mix { color: Bands::new(0.045, 0.076, 0.064, 0.33), amount: scrub })
        .with(Layer::Mix { color: bgr(0.15, 0.185, 0.22), amount: bare })
}

/// Mown grass of fields, in the bands of the mower.
fn turf(seed: u32) -> Material {
    yard("turf", [0.75, 0.28], seed).with(brightness(repeating(Coordinate::U, 5.2, 2.6, 0.0).times(0.07)))
}

fn soil(name: &str, base: Bands, grain: f32, seed: u32) -> Material {
    aged(Material::diffuse(name, Class::Ground, base).rough(0.5), seed, 0.16, grain)
        .with(Layer::Mix { color: base * 0.65, amount: noise(seed ^ 0x31, 3.0, 3).ramp(0.1, 0.6).times(0.4) })
}

/// Asphalt that cracks have been sealed on with black tar.
fn sealed(name: &str, age: f32, seed: u32) -> Material {
    let tar = Field::Warped {
        of: Box::new(Field::Cracks { space: Space::World, seed: seed ^ 0x71, cell_m: 9.0, width_m: 0.1 }),
        seed: seed ^ 0x72,
        wavelength_m: 6.0,
        amplitude_m: 1.6,
    };
    let amount = Field::Product(vec![noise(seed ^ 0x73, 60.0, 2).ramp(-0.1, 0.25), tar]);
    asphalt(name, age, seed).with(Layer::Mix { color: bgr(0.035, 0.036, 0.037), amount: amount.times(0.6) })
}

fn gutter(seed: u32) -> Material {
    let m = concrete("gutter", Class::Road, 0.27, 0.0, seed);
    m.with(Layer::Mix { color: bgr(0.09, 0.095, 0.1), amount: noise(seed ^ 0x41, 6.0, 3).ramp(0.0, 0.5).times(0.6) })
}

fn pavers(name: &str, base: Bands, seed: u32) -> Material {
    let each = Field::Cells { space: Space::Uv, seed, size_m: [0.6, 0.3, 0.0], stagger: 0.5 };
    aged(Material::diffuse(name, Class::Ground, base).rough(0.4), seed, 0.12, 0.1).with(brightness(each.times(0.2)))
}

/// A painted court: green inside, red-brown outside.
fn court(seed: u32) -> Material {
    let m = aged(Material::diffuse("court", Class::Ground, bgr(0.075, 0.11, 0.075)).rough(0.4), seed, 0.08, 0.06);
    let line = |across, at: f32| Field::Stripes { across, period_m: 4000.0, width_m: 0.1, offset_m: at };
    let lines = Field::Max(vec![
        line(Coordinate::U, 1.8),
        line(Coordinate::U, 8.9),
        line(Coordinate::V, 2.0),
        line(Coordinate::V, 10.5),
    ]);
    m.with(Layer::Mix { color: bgr(0.5, 0.52, 0.52), amount: lines.times(0.8) })
}

/// A wide street's carriageway with its worn lines and the dark bands that tyres leave; V runs across from its middle.
fn lanes(name: &str, age: f32, arterial: bool, seed: u32) -> Material {
    let stripe = |at: f32, width_m: f32| Field::Stripes {
        across: Coordinate::V,
        period_m: 4000.0,
        width_m,
        offset_m: at - width_m / 2.0,
    };
    let (lane, dashed, solid, yellow): (&[f32], &[f32], &[f32], &[f32]) = if arterial {
        (&[-10.3, -6.9, -3.5, 3.5, 6.9, 10.3], &[-8.6, -5.2, 5.2, 8.6], &[], &[-1.85, 1.85])
    } else {
        (&[-3.4, 3.4], &[], &[-5.2, 5.2], &[-1.75, -1.55, 1.55, 1.75])
    };
    let mut m = asphalt(name, age, seed);
    let oil = Field::Sum(lane.iter().map(|c| stripe(*c, 0.9)).collect());
    m = m.with(brightness(Field::Product(vec![oil, noise(seed ^ 0xb, 17.0, 2).affine(0.5, 0.7)]).times(-0.13)));
    let tracks = lane.iter().flat_map(|c| [c - 0.85, c + 0.85]).map(|c| stripe(c, 0.6)).collect();
    m = m.with(brightness(Field::Sum(tracks).times(0.06)));
    let wear = paint_left(seed ^ 0xc, 6.0, 0.75);
    let dashes = Field::Product(vec![
        repeating(Coordinate::U, 14.6, 3.7, 0.0),
        Field::Sum(dashed.iter().map(|c| stripe(*c, 0.13)).collect()),
    ]);
    let lines = Field::Sum(solid.iter().map(|c| stripe(*c, 0.13)).collect());
    let white = Field::Product(vec![Field::Sum(vec![dashes, lines]), wear.clone()]);
    m = m.with(Layer::Mix { color: bgr(0.38, 0.4, 0.41), amount: white.times(0.75) });
    let pair = Field::Sum(yellow.iter().map(|c| stripe(*c, 0.11)).collect());
    m.with(Layer::Mix { color: bgr(0.09, 0.26, 0.36), amount: Field::Product(vec![pair, wear]).times(0.75) })
}

/// The materials of freeways, in the order of their slots.
pub(super) fn freeway(seed: &impl Fn(&str, u64) -> u32) -> Vec<Material> {
    let blank = Material::diffuse("blank", Class::Bridge, Bands::grey(0.2));
    let mut out = vec![blank; deck::COUNT];
    let edge = [2.0, 16.4];
    let both = |list: &[f32]| -> Vec<f32> { list.iter().flat_map(|x| [*x, -*x]).collect() };
    out[deck::LANES as usize] = slabs(
        "freeway",
        &both(&[3.8, 7.4, 11.0, 14.6]),
        &both(&[5.6, 9.2, 12.8]),
        &both(&edge[1..]),
        &both(&edge[..1]),
        seed("freeway", 0),
    );
    out[deck::RAMP as usize] = slabs("ramp", &[0.8], &[], &[-1.0], &[2.6], seed("freeway", 1));
    let streaks = Field::Noise(satseed_scene::Fractal::new(Space::Plan, seed("freeway", 3), 0.9, 2));
    out[deck::CONCRETE as usize] =
        concrete("structure", Class::Bridge, 0.29, 0.0, seed("freeway", 2)).with(brightness(streaks.times(0.16)));
    out[deck::SLOPE as usize] = yard("embankment", [0.2, 0.5], seed("freeway", 4));
    out
}

/// Concrete pavement in slabs, with joints, tyre bands and worn lines.
fn slabs(name: &str, lanes: &[f32], dashed: &[f32], white: &[f32], yellow: &[f32], seed: u32) -> Material {
    let stripe = |at: f32, width_m: f32| Field::Stripes {
        across: Coordinate::V,
        period_m: 4000.0,
        width_m,
        offset_m: at - width_m / 2.0,
    };
    let base = bgr(0.2, 0.235, 0.258);
    let m = aged(Material::diffuse(name, Class::Bridge, base).rough(0.3), seed, 0.1, 0.08);
    let each = Field::Cells { space: Space::Uv, seed, size_m: [4.6, 3.6, 0.0], stagger: 0.0 };
    let oil = Field::Sum(lanes.iter().map(|c| stripe(*c, 1.0)).collect());
    let tracks = lanes.iter().flat_map(|c| [c - 0.9, c + 0.9]).map(|c| stripe(c, 0.6)).collect();
    let wear = paint_left(seed ^ 0xc, 6.0, 0.75);
    let dashes = Field::Product(vec![
        repeating(Coordinate::U, 14.6, 3.7, 0.0),
        Field::Sum(dashed.iter().map(|c| stripe(*c, 0.14)).collect()),
    ]);
    let solid = Field::Sum(white.iter().map(|c| stripe(*c, 0.15)).collect());
    let left = Field::Sum(yellow.iter().map(|c| stripe(*c, 0.15)).collect());
    m.with(brightness(each.times(0.07)))
        .with(brightness(repeating(Coordinate::U, 4.6, 0.05, 0.0).times(-0.25)))
        .with(brightness(Field::Product(vec![oil, noise(seed ^ 0xb, 17.0, 2).affine(0.5, 0.8)]).times(-0.2)))
        .with(brightness(Field::Sum(tracks).times(-0.08)))
        .with(Layer::Mix {
            color: bgr(0.07, 0.072, 0.075),
            amount: noise(seed ^ 0xd, 90.0, 2).ramp(0.15, 0.3).times(0.5),
        })
        .with(Layer::Mix {
            color: bgr(0.45, 0.47, 0.48),
            amount: Field::Product(vec![Field::Sum(vec![dashes, solid]), wear.clone()]).times(0.75),
        })
        .with(Layer::Mix { color: bgr(0.1, 0.28, 0.38), amount: Field::Product(vec![left, wear]).times(0.75) })
}
