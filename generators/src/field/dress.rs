//! What the ground looks like: the raster all materials read, and the material of each parcel.

use super::crops::{Crop, Form, Season};
use super::plan::{Edge, Parcel, Plan};
use super::relief::{CARRIAGEWAY_M, RUT_M, Relief};
use crate::kit::terrain::noise::fractal;
use crate::kit::terrain::sampling::smoothstep;
use glam::DVec2;
use rayon::prelude::*;
use satseed_scene::{
    Bands, Brdf, Class, Coordinate, Field, Fractal, Layer, Material, MaterialRaster, Raster, SeedPath, Space,
};

/// Slots of the terrain: borders first, then two for each parcel.
pub(super) mod slot {
    pub(in super::super) const LANE: u16 = 0;
    pub(in super::super) const TRACK: u16 = 1;
    pub(in super::super) const VERGE: u16 = 2;
    pub(in super::super) const DITCH: u16 = 3;
    const PARCELS: u16 = 4;

    /// A parcel's ground: below what stands on it, or with the look of it where nothing does.
    pub(in super::super) fn parcel(index: usize, bare: bool) -> u16 {
        PARCELS + 2 * index as u16 + u16::from(!bare)
    }
}

/// The only raster.
const COVER: u32 = 0;

/// Channels of the cover.
mod channel {
    /// Distance beyond the nearest border's width, of [`EDGE_M`](super::EDGE_M).
    pub(super) const EDGE: u8 = 0;
    /// Wet and heavy soil, in blotches.
    pub(super) const MOIST: u8 = 1;
    /// Patches of 5 to 30 m around one half.
    pub(super) const TONE: u8 = 2;
    /// Stains of a few metres around one half.
    pub(super) const STAIN: u8 = 3;
    /// Hue over 100 m around one half.
    pub(super) const HUE: u8 = 4;
    /// Growth around one half.
    pub(super) const VIGOUR: u8 = 5;
    /// Where plants are missing.
    pub(super) const THIN: u8 = 6;
    /// Where cereals lie.
    pub(super) const LODGED: u8 = 7;
    /// Signed distance from a track's or lane's middle, of twice [`ROAD_M`](super::ROAD_M).
    pub(super) const ROAD: u8 = 8;
    /// Weeds and docks: small patches.
    pub(super) const WEEDS: u8 = 9;
    /// Nearness of a ditch's bottom.
    pub(super) const BOTTOM: u8 = 10;
    /// Wheel tracks of a pivot's towers.
    pub(super) const TOWERS: u8 = 11;
}

/// Distance of the raster's posts, m.
const CELL_M: f64 = 1.0;
/// Range of the distance from borders, m.
const EDGE_M: f64 = 32.0;
/// Range of the distance from a road's middle, m.
const ROAD_M: f64 = 6.0;
/// Distance of a pivot's towers, m.
pub(super) const TOWER_M: f64 = 49.0;

type Post = [u8; MaterialRaster::CHANNELS];

fn in_255ths(value: f64) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

/// The raster over the whole scene.
pub(super) fn cover(relief: &Relief, path: &SeedPath) -> MaterialRaster {
    let names = ["moist", "tone", "stain", "hue", "weeds", "drainage"];
    let seeds = names.map(|name| path.child(name).hash_u32());
    let half_m = relief.tiling().scene_half_m();
    let n = (2.0 * half_m / CELL_M) as usize + 1;
    let shape = Raster::filled(DVec2::splat(-half_m), CELL_M, n, n, ());
    let rows: Vec<Vec<Post>> =
        (0..n).into_par_iter().map(|j| (0..n).map(|i| bake(relief, &seeds, shape.position(i, j))).collect()).collect();
    MaterialRaster::new(Raster { origin_m: shape.origin_m, cell_m: CELL_M, width: n, height: n, data: rows.concat() })
}

fn bake(relief: &Relief, seeds: &[u32; 6], p: DVec2) -> Post {
    let plan = &relief.plan;
    let q = plan.warp.plan(p);
    let near = plan.nearest(q);
    let edge = near.map_or(1.0, |n| (n.beyond_m / EDGE_M).clamp(0.0, 1.0));
    let mut road = 1.0;
    let mut bottom = 0.0;
    if let Some(n) = near {
        match plan.borders[n.border as usize].edge {
            Edge::Lane | Edge::Track => road = (0.5 + 0.5 * n.side_m / ROAD_M).clamp(0.0, 1.0),
            Edge::Ditch => bottom = smoothstep(1.7, 0.2, n.side_m.abs()),
            _ => {}
        }
    }
    let at = |k: usize, wavelength_m: f64, octaves: u32, gain: f64| fractal(p, seeds[k], wavelength_m, octaves, gain);
    // Old channels wind through the blotches; hollows are wetter than knolls.
    let channels = 1.0 - 4.5 * fractal(p, seeds[5], 170.0, 3, 0.5).abs();
    let moist = 0.5 + 0.9 * at(0, 64.0, 5, 0.6) + 0.22 * smoothstep(0.35, 0.95, channels);
    let towers = plan.pivots.iter().map(|(c, r)| (q - *c).length() / *r * 8.0).filter(|t| *t < 7.9 && *t > 0.4);
    let tower = towers.map(|t| (t - libm::round(t)).abs() * TOWER_M).fold(f64::MAX, f64::min);
    let values = [
        edge,
        moist,
        0.5 + 0.5 * at(1, 26.0, 4, 0.55),
        0.5 + 0.5 * at(2, 4.8, 2, 0.5),
        0.5 + 0.5 * at(3, 130.0, 3, 0.5),
        0.5 + 0.4 * relief.vigour(p),
        relief.thin(p),
        relief.lodged(p),
        road,
        smoothstep(0.25, 0.6, at(4, 8.0, 3, 0.6)),
        bottom,
        (tower / 8.0).min(1.0),
    ];
    let mut post = Post::default();
    for (channel, value) in post.iter_mut().zip(values) {
        *channel = in_255ths(value);
    }
    post
}

/// The look of one scene, from which every material is made.
pub(super) struct Look {
    /// Loam of the region.
    soil: Bands,
    /// Grass of verges and pastures.
    grass: Bands,
    /// What all colours become without contrast.
    middle: Bands,
    contrast: f32,
    path: SeedPath,
}

/// Materials of one parcel.
pub(super) struct ParcelLook {
    /// Top of what stands on it.
    pub(super) crop: Material,
    /// Its sides.
    pub(super) side: Material,
}

fn raster(channel: u8) -> Field {
    Field::Raster { raster: COVER, channel }
}

fn product(fields: Vec<Field>) -> Field {
    Field::Product(fields)
}

fn turned(of: Field, d: DVec2) -> Field {
    Field::Turned { of: Box::new(of), along: [d.x, d.y] }
}

const ACROSS: Coordinate = Coordinate { space: Space::Plan, axis: 1 };

impl Look {
    pub(super) fn new(plan: &Plan, contrast: f64, path: &SeedPath) -> Self {
        let mut rng = path.child("palette").rng();
        let brown = Bands::new(0.092, 0.124, 0.152, 0.22);
        let dark = Bands::new(0.062, 0.080, 0.095, 0.15);
        let pale = Bands::new(0.134, 0.168, 0.196, 0.27);
        let t = rng.range(-0.7, 0.8) as f32;
        let soil = brown.lerp(if t < 0.0 { dark } else { pale }, t.abs());
        let green = Bands::new(0.052, 0.095, 0.076, 0.31);
        let dry = Bands::new(0.088, 0.130, 0.138, 0.27);
        let grass = match plan.season {
            Season::Early => green.lerp(dry, rng.range(0.0, 0.35) as f32),
            Season::Late => green.lerp(dry, rng.range(0.2, 0.75) as f32),
        };
        let middle = Bands::new(0.085, 0.122, 0.130, 0.27);
        Self { soil, grass, middle, contrast: contrast as f32, path: *path }
    }

    /// A colour as far from the middle as the contrast says.
    fn apart(&self, c: Bands) -> Bands {
        self.middle.lerp(c, self.contrast).map(|v| v.max(0.02))
    }

    fn seed(&self, name: &str) -> u32 {
        self.path.child(name).hash_u32()
    }

    fn brightness(&self, amount: Field) -> Layer {
        Layer::Brightness { amount: amount.times(self.contrast) }
    }

    fn noise(seed: u32, wavelength_m: f32, octaves: u8, gain: f32) -> Field {
        Field::Noise(Fractal::new(Space::Plan, seed, wavelength_m, octaves).gain(gain))
    }

    /// Patches, stains and hue that all ground has.
    fn common(&self, m: Material) -> Material {
        m.with(self.brightness(raster(channel::TONE).affine(0.24, -0.12)))
            .with(self.brightness(raster(channel::STAIN).affine(0.16, -0.08)))
            .with(Layer::Tint {
                tint: Bands::new(-0.5, -0.1, 0.5, 0.2),
                amount: raster(channel::HUE).affine(0.20 * self.contrast, -0.10 * self.contrast),
            })
    }

    /// Passes of a machine: each a little brighter or darker than the next, every second one tilted the other way.
    fn passes(&self, m: Material, axis: DVec2, width_m: f32, amount: f32, seed: u32, headland_m: f32) -> Material {
        let inside = raster(channel::EDGE).ramp((headland_m - 0.8) / EDGE_M as f32, (headland_m + 0.8) / EDGE_M as f32);
        let cells = Field::Cells { space: Space::Plan, seed, size_m: [0.0, width_m, 0.0], stagger: 0.0 };
        let stripes =
            Field::Stripes { across: ACROSS, period_m: 2.0 * width_m, width_m, offset_m: 0.0 }.affine(2.0, -1.0);
        m.with(self.brightness(product(vec![inside.clone(), turned(cells, axis)]).times(0.6 * amount)))
            .with(self.brightness(product(vec![inside, turned(stripes, axis)]).times(amount)))
    }

    /// Fine streaks along a direction.
    fn streaks(&self, axis: DVec2, seed: u32, wavelength_m: f32, amount: f32) -> Layer {
        let noise =
            Field::Noise(Fractal::new(Space::Plan, seed, wavelength_m, 3).stretched([16.0, 1.0, 1.0]).gain(0.8));
        self.brightness(turned(noise, axis).times(amount))
    }

    /// Bare soil with its moisture.
    fn soil(&self, name: &str, base: Bands, wet: f32) -> Material {
        let m = Material::diffuse(name, Class::Ground, self.apart(base)).rough(0.45).with(Layer::Mix {
            color: self.apart(base * 0.62),
            amount: raster(channel::MOIST).ramp(0.42, 0.85).times(wet),
        });
        self.common(m)
            .with(self.brightness(Self::noise(self.seed("clods"), 1.5, 3, 0.95).times(0.17)))
            .bumpy(Self::noise(self.seed("clod bump"), 1.3, 2, 0.8), 0.03 * self.contrast)
    }

    /// Grass with its tussocks and bare spots.
    fn grassland(&self, name: &str, class: Class, base: Bands) -> Material {
        let m = Material::diffuse(name, class, self.apart(base)).with(Layer::Mix {
            color: self.apart(base.lerp(Bands::new(0.105, 0.145, 0.160, 0.26), 0.8)),
            amount: raster(channel::VIGOUR).ramp(0.62, 0.1).times(0.8),
        });
        self.common(m)
            .with(Layer::Mix {
                color: self.apart(Bands::new(0.048, 0.080, 0.056, 0.30)),
                amount: raster(channel::WEEDS).times(0.5),
            })
            .with(self.brightness(Self::noise(self.seed("tussocks"), 2.1, 3, 0.95).times(0.34)))
            .bumpy(Self::noise(self.seed("tussock bump"), 1.6, 2, 0.8), 0.05 * self.contrast)
    }

    /// Materials of borders, by slot.
    pub(super) fn borders(&self) -> Vec<Material> {
        let distance = || raster(channel::ROAD).affine(2.0 * ROAD_M as f32, -ROAD_M as f32);
        let on = |middle: f32, half: f32, soft: f32| {
            let arm = |s: f32| {
                product(vec![
                    distance().times(s).ramp(middle - half - soft, middle - half + soft),
                    distance().times(s).ramp(middle + half + soft, middle + half - soft),
                ])
            };
            Field::Max(vec![arm(1.0), arm(-1.0)])
        };
        let edge = CARRIAGEWAY_M as f32;
        let lane = Material::diffuse("lane", Class::Road, self.apart(Bands::new(0.106, 0.122, 0.126, 0.14))).rough(0.4);
        let lane = self
            .common(lane)
            .with(self.brightness(on(1.0, 0.35, 0.3).times(-0.10)))
            .with(self.brightness(on(0.0, 0.22, 0.2).times(-0.06)))
            // Trench patches, and mud that tractors carry out of gateways.
            .with(
                self.brightness(
                    Field::Cells {
                        space: Space::Plan,
                        seed: self.seed("patches"),
                        size_m: [9.0, 7.0, 0.0],
                        stagger: 0.4,
                    }
                    .ramp(0.86, 0.9)
                    .times(-0.11),
                ),
            )
            .with(Layer::Mix { color: self.apart(self.soil), amount: raster(channel::WEEDS).times(0.35) })
            .with(Layer::Mix {
                color: self.apart(self.grass),
                amount: Field::Sum(vec![
                    on(edge, 0.28, 0.2),
                    Self::noise(self.seed("crumble"), 1.4, 2, 0.9).times(0.5),
                ])
                .ramp(0.45, 0.95),
            })
            .with(self.brightness(Self::noise(self.seed("asphalt"), 0.9, 2, 1.0).times(0.09)));
        let rut = RUT_M as f32;
        let track = self
            .grassland("track", Class::Ground, self.grass)
            .with(Layer::Mix {
                color: self.apart(self.soil * 1.22),
                amount: Field::Sum(vec![
                    on(rut, 0.42, 0.2),
                    Self::noise(self.seed("rut"), 3.6, 3, 0.7).times(0.55),
                    raster(channel::WEEDS).times(0.3),
                ])
                .ramp(0.32, 0.85),
            })
            .with(Layer::Mix {
                color: self.apart(self.soil * 0.6),
                amount: product(vec![
                    on(rut, 0.3, 0.15),
                    Self::noise(self.seed("puddle"), 5.0, 2, 0.6).ramp(0.25, 0.4),
                    raster(channel::MOIST).ramp(0.4, 0.7),
                ])
                .times(0.8),
            });
        let verge =
            self.grassland("verge", Class::LowVegetation, self.grass.lerp(Bands::new(0.05, 0.08, 0.06, 0.3), 0.25));
        let ditch = self.grassland("ditch", Class::LowVegetation, self.grass * 0.9).with(Layer::Mix {
            color: self.apart(Bands::new(0.040, 0.052, 0.050, 0.10)),
            amount: Field::Sum(vec![raster(channel::BOTTOM), Self::noise(self.seed("reeds"), 2.6, 3, 0.7).times(0.45)])
                .ramp(0.62, 0.95),
        });
        vec![lane, track, verge, ditch]
    }

    /// The loam of a parcel: a little its own.
    fn loam(&self, parcel: &Parcel) -> Bands {
        let mut rng = self.path.child("loam").index(parcel.code).rng();
        let bright = rng.range(0.88, 1.13) as f32;
        let red = rng.signed() as f32 * 0.05;
        let c = self.soil * bright;
        Bands([c.0[0] * (1.0 - red), c.0[1], c.0[2] * (1.0 + red), c.0[3]])
    }

    /// The colour of a parcel's crop: sorts and sowing dates differ.
    fn green(&self, parcel: &Parcel) -> Bands {
        let mut rng = self.path.child("sort").index(parcel.code).rng();
        let bright = rng.range(0.87, 1.14) as f32;
        let ripe = rng.signed() as f32 * 0.10;
        let c = parcel.crop.facts().color * bright;
        Bands([c.0[0] * (1.0 + 0.3 * ripe), c.0[1] * (1.0 + 0.3 * ripe), c.0[2] * (1.0 + ripe), c.0[3]])
    }

    /// Drains: lines some 8 to 20 m apart where the soil dries first.
    fn drains(&self, parcel: &Parcel, amount: f32) -> Layer {
        let mut rng = self.path.child("drains").index(parcel.code).rng();
        let period_m = rng.range(9.0, 19.0) as f32;
        let (s, c) = libm::sincos(rng.range(0.25, 0.7) * if rng.chance(0.5) { 1.0 } else { -1.0 });
        let amount = if rng.chance(0.45) { amount } else { 0.0 };
        let lines = Field::Stripes { across: ACROSS, period_m, width_m: 1.1, offset_m: 0.3 };
        let lines =
            Field::Warped { of: Box::new(lines), seed: self.seed("drain bend"), wavelength_m: 40.0, amplitude_m: 0.8 };
        let shown =
            product(vec![raster(channel::MOIST).ramp(0.35, 0.6), turned(lines, parcel.axis.rotate(DVec2::new(c, s)))]);
        self.brightness(shown.times(amount))
    }

    /// Wheel tracks of a pivot's towers, over any cover.
    fn towers(&self, m: Material, parcel: &Parcel, color: Bands) -> Material {
        if parcel.pivot.is_none() {
            return m;
        }
        m.with(Layer::Mix {
            color: self.apart(color),
            amount: raster(channel::TOWERS).ramp(0.75 / 8.0, 0.25 / 8.0).times(0.85),
        })
    }

    /// A parcel's ground: `bare` below what stands on it, else with the look of it.
    pub(super) fn ground(&self, parcel: &Parcel, bare: bool) -> Material {
        let facts = parcel.crop.facts();
        let key = self.path.child("parcel").index(parcel.code);
        let seed = |name: &str| key.child(name).hash_u32();
        let mut rng = key.rng();
        let loam = self.loam(parcel);
        let axis = parcel.axis;
        let m = match facts.form {
            Form::Slab { .. } if !bare => return self.crop(parcel, Class::Crop).crop,
            Form::Slab { .. } => {
                let m = self.soil(facts.name, loam * 0.85, 0.8);
                m.with(self.streaks(axis, seed("rows"), 1.2, 0.08))
            }
            Form::Rows { row_m, half_m, .. } => {
                let m = self.soil(facts.name, loam, 0.8);
                let m = self.passes(m, axis, 3.04, 0.03, seed("passes"), 8.0);
                let m = if parcel.crop == Crop::Vines {
                    // Grass in every second or in each alley.
                    let every = if rng.chance(0.5) { 1.0 } else { 2.0 };
                    let (period_m, width_m) = (row_m as f32 * every, row_m as f32 - 0.9);
                    let alley = Field::Stripes { across: ACROSS, period_m, width_m, offset_m: -width_m / 2.0 };
                    m.with(Layer::Mix {
                        color: self.apart(self.grass * 1.05),
                        amount: Field::Sum(vec![
                            turned(alley, axis),
                            Self::noise(seed("alley"), 3.0, 3, 0.8).times(0.4),
                        ])
                        .ramp(0.3, 0.8)
                        .times(0.85),
                    })
                } else {
                    m.with(self.streaks(axis, seed("rows"), 1.1, 0.07)).with(Layer::Mix {
                        color: self.apart(self.green(parcel) * 0.9),
                        amount: raster(channel::WEEDS).times(0.25),
                    })
                };
                if bare {
                    m
                } else {
                    let width_m = 2.0 * half_m as f32;
                    let offset_m = (row_m as f32 - width_m) / 2.0;
                    let rows = Field::Stripes { across: ACROSS, period_m: row_m as f32, width_m, offset_m };
                    let m = m.with(Layer::Mix {
                        color: self.apart(self.green(parcel)),
                        amount: turned(rows, axis).times(0.92),
                    });
                    Material { class: Class::Crop, ..m }
                }
            }
            Form::Orchard { row_m, .. } => {
                let strip = Field::Stripes {
                    across: ACROSS,
                    period_m: row_m as f32,
                    width_m: 1.3,
                    offset_m: row_m as f32 / 2.0 - 0.65,
                };
                let m = self.grassland(facts.name, Class::Ground, self.grass * 1.04).with(Layer::Mix {
                    color: self.apart(loam.lerp(self.grass, 0.25)),
                    amount: turned(strip, axis).times(0.75),
                });
                if bare {
                    m
                } else {
                    let crowns = Field::Stripes {
                        across: ACROSS,
                        period_m: row_m as f32,
                        width_m: 2.6,
                        offset_m: row_m as f32 / 2.0 - 1.3,
                    };
                    m.with(Layer::Mix {
                        color: self.apart(facts.color * 0.7),
                        amount: turned(crowns, axis).times(0.85),
                    })
                }
            }
            Form::Flat => self.flat(parcel),
        };
        self.towers(m, parcel, loam * 0.8)
    }

    /// Covers that are no geometry.
    fn flat(&self, parcel: &Parcel) -> Material {
        let facts = parcel.crop.facts();
        let key = self.path.child("parcel").index(parcel.code);
        let seed = |name: &str| key.child(name).hash_u32();
        let mut rng = key.child("flat").rng();
        let loam = self.loam(parcel);
        let axis = parcel.axis;
        match parcel.crop {
            Crop::Copse => {
                let floor = loam.lerp(self.grass, 0.5) * 0.75;
                self.grassland(facts.name, Class::Ground, floor)
            }
            Crop::Pasture => {
                // Grazed short in places, rank where dung lies; paths that cattle trod.
                let m = self.grassland(facts.name, Class::LowVegetation, self.green(parcel));
                let paths = Field::Cracks { space: Space::Plan, seed: seed("paths"), cell_m: 46.0, width_m: 0.55 };
                let paths =
                    Field::Warped { of: Box::new(paths), seed: seed("bend"), wavelength_m: 17.0, amplitude_m: 3.0 };
                m.with(Layer::Mix {
                    color: self.apart(loam.lerp(self.grass, 0.3)),
                    amount: product(vec![paths, raster(channel::HUE).ramp(0.35, 0.6)]).times(0.55),
                })
                .with(self.brightness(Self::noise(seed("grazed"), 13.0, 5, 0.75).times(0.30)))
                // Rank tufts round old dung, and bare, dusty spots.
                .with(Layer::Mix {
                    color: self.apart(Bands::new(0.040, 0.074, 0.052, 0.34)),
                    amount: Self::noise(seed("dung"), 3.4, 3, 0.7).ramp(0.34, 0.6).times(0.55),
                })
                .with(Layer::Mix {
                    color: self.apart(loam.lerp(self.grass, 0.2)),
                    amount: Self::noise(seed("bare"), 6.1, 4, 0.8).ramp(0.4, 0.7).times(0.5),
                })
            }
            Crop::Hay => {
                let m = self.grassland(facts.name, Class::LowVegetation, self.green(parcel));
                let width = rng.range(3.0, 4.6) as f32;
                self.passes(m, axis, width, 0.085, seed("mower"), width + 1.0).with(self.streaks(
                    axis,
                    seed("mown"),
                    1.0,
                    0.10,
                ))
            }
            Crop::Yard => {
                let m = Material::diffuse(facts.name, Class::Ground, self.apart(Bands::new(0.098, 0.116, 0.132, 0.18)));
                self.common(m)
                    .with(Layer::Mix {
                        color: self.apart(self.soil),
                        amount: Self::noise(seed("mud"), 16.0, 4, 0.6).ramp(-0.05, 0.35).times(0.75),
                    })
                    .with(Layer::Mix {
                        color: self.apart(self.grass),
                        amount: Field::Sum(vec![
                            raster(channel::EDGE).affine(-4.0, 0.55),
                            Self::noise(seed("lawn"), 22.0, 3, 0.6).times(0.9),
                        ])
                        .ramp(0.22, 0.4),
                    })
                    .with(self.brightness(Self::noise(seed("gravel"), 1.2, 2, 1.0).times(0.10)))
            }
            Crop::Stubble | Crop::Straw | Crop::Bales => {
                let m = self.soil(facts.name, loam, 0.55);
                let width = parcel.pass_m as f32;
                let cover = facts.cover * rng.range(0.72, 1.05) as f32;
                let m = m.with(Layer::Mix {
                    color: self.apart(self.green(parcel)),
                    amount: Field::Sum(vec![
                        Field::Constant(cover),
                        raster(channel::VIGOUR).affine(0.5, -0.25),
                        Self::noise(seed("straw"), 2.4, 3, 0.9).times(0.30),
                    ]),
                });
                let m = self.passes(m, axis, width, 0.05, seed("combine"), width);
                // Chaff lies where the combine let it fall, in the middle of each pass.
                let chaff =
                    Field::Stripes { across: ACROSS, period_m: width, width_m: 1.5, offset_m: 0.5 * width - 0.75 };
                let chaff =
                    Field::Warped { of: Box::new(chaff), seed: seed("sway"), wavelength_m: 23.0, amplitude_m: 0.35 };
                let shown = if parcel.crop == Crop::Stubble { 0.55 } else { 0.25 };
                m.with(Layer::Mix {
                    color: self.apart(self.green(parcel) * 1.18),
                    amount: product(vec![
                        turned(chaff, axis),
                        Field::Sum(vec![Field::Constant(0.7), Self::noise(seed("chaff"), 2.0, 3, 0.9)]).ramp(0.0, 1.0),
                    ])
                    .times(shown),
                })
                .with(self.streaks(axis, seed("rows"), 0.9, 0.13))
            }
            _ => {
                let seedbed = parcel.crop == Crop::Seedbed;
                let base = if seedbed { loam * 1.16 } else { loam * 0.92 };
                let m = self.soil(facts.name, base, if seedbed { 0.75 } else { 1.0 });
                let width = rng.range(3.6, 6.4) as f32;
                let m = self.passes(m, axis, width, if seedbed { 0.04 } else { 0.075 }, seed("tillage"), 1.6 * width);
                let m = m.with(self.streaks(axis, seed("tines"), if seedbed { 0.8 } else { 1.4 }, 0.15));
                // Straw not wholly ploughed in, and the first weeds.
                m.with(Layer::Mix {
                    color: self.apart(Bands::new(0.115, 0.158, 0.195, 0.27)),
                    amount: Self::noise(seed("trash"), 9.0, 4, 0.75).ramp(0.1, 0.7).times(0.35),
                })
                .with(Layer::Mix { color: self.apart(self.grass), amount: raster(channel::WEEDS).times(0.22) })
                .with(self.drains(parcel, 0.13))
            }
        }
    }

    /// What stands on a parcel.
    pub(super) fn crop(&self, parcel: &Parcel, class: Class) -> ParcelLook {
        let facts = parcel.crop.facts();
        let key = self.path.child("parcel").index(parcel.code);
        let seed = |name: &str| key.child(name).hash_u32();
        let mut rng = key.child("crop").rng();
        // Leaves that stand as geometry throw their own shadows; a canopy's colour holds them.
        let leaf = if matches!(facts.form, Form::Rows { .. }) { 1.5 } else { 1.0 };
        let green = self.green(parcel) * leaf;
        let loam = self.loam(parcel);
        let axis = parcel.axis;
        let base = Material::diffuse(facts.name, class, self.apart(green)).rough(0.35);
        // Better and worse growth: darker green or later to ripen; poorer, where soil is shallow.
        let growth = rng.range(0.5, 1.0) as f32;
        let lush = Bands([green.0[0] * 0.82, green.0[1] * 0.92, green.0[2] * 0.76, green.0[3] * 1.04]);
        let poor = green.lerp(loam * 1.1, 0.42);
        let m = base
            .with(Layer::Mix { color: self.apart(lush), amount: raster(channel::VIGOUR).ramp(0.5, 0.95).times(growth) })
            .with(Layer::Mix {
                color: self.apart(poor),
                amount: raster(channel::VIGOUR).ramp(0.42, 0.02).times(growth),
            })
            .with(Layer::Mix {
                color: self.apart(lush * 0.9),
                amount: raster(channel::MOIST).ramp(0.6, 0.95).times(0.45 * growth),
            });
        let mut m = self.common(m);
        if let Form::Slab { row_m, boom_m, .. } = facts.form {
            let drill = [3.0, 4.0, 6.0][rng.below(3) as usize];
            let headland_m = if boom_m > 0.0 { 0.5 * boom_m as f32 } else { 0.0 };
            m = self.passes(m, axis, drill, rng.range(0.015, 0.055) as f32, seed("drill"), headland_m.max(3.0));
            m = m.with(self.streaks(axis, seed("streak"), 1.0, 0.085));
            if parcel.crop == Crop::Meadow {
                // Grasses and herbs in flower, in patches of their own.
                m = m.with(self.brightness(Self::noise(seed("sward"), 7.0, 5, 0.8).times(0.32)));
            }
            if row_m > 0.4 {
                // Wide enough for the soil to show between the rows.
                let width_m = row_m as f32 * facts.cover.clamp(0.3, 0.85);
                let gaps =
                    Field::Stripes { across: ACROSS, period_m: row_m as f32, width_m, offset_m: 0.0 }.affine(-1.0, 1.0);
                let open = 0.35 + 0.65 * (1.0 - facts.cover);
                m = m.with(Layer::Mix { color: self.apart(loam * 0.9), amount: turned(gaps, axis).times(open) });
            }
            m = m.with(Layer::Mix {
                color: self.apart(loam.lerp(green, 0.25)),
                amount: raster(channel::THIN).times(0.6 * growth),
            });
            if matches!(parcel.crop, Crop::WheatGreen | Crop::WheatRipe | Crop::Barley) {
                m = m.with(self.brightness(raster(channel::LODGED).times(0.08))).with(self.brightness(
                    product(vec![raster(channel::LODGED), Self::noise(seed("swirl"), 3.1, 3, 0.8)]).times(0.22),
                ));
            }
            // The rim is thinner: shade, weeds, a turned wheel.
            m = m.with(Layer::Mix {
                color: self.apart(poor),
                amount: Field::Sum(vec![
                    raster(channel::EDGE).ramp(3.0 / EDGE_M as f32, 0.0),
                    Self::noise(seed("rim"), 5.0, 3, 0.7).times(0.5),
                ])
                .ramp(0.35, 1.1)
                .times(0.7),
            });
            m = m.with(self.drains(parcel, -0.06));
            m = m
                .with(self.brightness(Self::noise(seed("grain"), 1.15, 2, 1.0).times(0.10)))
                .bumpy(Self::noise(seed("bump"), 1.2, 2, 0.9), 0.035 * self.contrast);
        } else {
            m = m
                .with(self.brightness(Field::Variation(1).times(0.12)))
                .with(self.brightness(Field::world_noise(seed("grain"), 0.5, 2).times(0.22)));
            let through = self.apart(green) * 0.28;
            m.brdf = Brdf::Leaf { transmission: through };
        }
        let m = self.towers(m, parcel, loam * 0.8);
        let side = Material::diffuse(facts.name, class, self.apart(green.lerp(loam, 0.35) * 1.05))
            .rough(0.35)
            .with(self.brightness(Field::world_noise(seed("stems"), 0.6, 2).times(0.25)));
        ParcelLook { crop: m, side }
    }

    /// Straw in swaths and bales.
    pub(super) fn straw(&self, name: &str, class: Class, bright: f32) -> Material {
        let base = Bands::new(0.135, 0.192, 0.236, 0.33) * bright;
        Material::diffuse(name, class, self.apart(base))
            .rough(0.4)
            .with(self.brightness(Field::Variation(1).times(0.12)))
            .with(self.brightness(Field::world_noise(self.seed("straw"), 0.5, 2).times(0.2)))
    }
}
