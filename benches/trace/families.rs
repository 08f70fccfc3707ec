//! Kinds of rays as a pair asks for them, and the time that they take.
//!
//! Rays come in tiles, as labels and images trace them; 4,096 at a time are made outside of the clock and traced inside,
//! so that what is measured is tracing alone, with rays that the caches still hold, as they do when a pair is made.

use crate::clock::thread_cpu;
use crate::scenes::sun;
use glam::DVec3;
use rayon::prelude::*;
use satseed::camera::{Camera, Datum, RigSpec, StereoRig};
use satseed_scene::{Environment, Ray, Rng, SeedPath};
use satseed_tracer::{Hit, Origin, TILE_SIDE, Tracer, tile_order};
use std::time::Duration;

/// Rays that are made and traced at a time.
const BATCH: usize = 4096;
/// Rays that the tracer is given at a time.
const TILE: usize = (TILE_SIDE * TILE_SIDE) as usize;

/// A kind of rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Family {
    /// First hits of pixel centres, as labels ask.
    Primary,
    /// First hits of four samples a pixel, as images ask.
    Primary4,
    /// From the first hits of pixel centres to the other camera: is anything between?
    Label,
    /// From the first hits of samples into the sun's disc: is anything there?
    Sun,
    /// From the first hits of samples into the dome, by the cosine: what is there?
    Ambient,
}

impl Family {
    pub(crate) const ALL: [(&str, Self); 5] = [
        ("primary", Self::Primary),
        ("primary4", Self::Primary4),
        ("label", Self::Label),
        ("sun", Self::Sun),
        ("ambient", Self::Ambient),
    ];

    /// Whether the closest hit is asked, or whether there is any.
    pub(crate) fn is_closest(self) -> bool {
        matches!(self, Self::Primary | Self::Primary4 | Self::Ambient)
    }
}

/// A frame of 2048 x 2048 pixels over a scene, and what its rays start on.
pub(crate) struct Frame {
    left: Camera,
    right: Camera,
    centres: Vec<Ray>,
    samples: Vec<Ray>,
    pixel_hits: Vec<Hit>,
    sample_hits: Vec<Hit>,
}

/// Some rays of a family.
pub(crate) enum Batch {
    First(Vec<Ray>),
    Line(Vec<(Origin, DVec3)>),
    Blocked(Vec<(Origin, DVec3)>),
    From(Vec<(Origin, DVec3)>),
}

impl Frame {
    /// The preset's rig with a baseline of 100 m. One in `share` groups of rows is traced,
    /// and of the samples, of which there are four times as many, one in four times as many.
    pub(crate) fn new(tracer: &Tracer, share: u32) -> Self {
        let pivot_m = DVec3::new(0.0, 0.0, tracer.scene().pivot_height_m);
        let rig = StereoRig::new(RigSpec {
            altitude_m: 1000.0,
            gsd_m: 0.3,
            size_px: [2048; 2],
            baseline_m: 100.0,
            azimuth_rad: 0.4,
            pivot_along_baseline: 0.5,
            pivot_m,
            datum: Datum::Height(pivot_m.z),
        });
        let (left, right) = (rig.left, rig.right);
        let centres = rays(&left, 1, share);
        let samples = rays(&left, 2, 4 * share);
        let hits = |rays: &[Ray]| -> Vec<Hit> {
            rays.par_chunks(TILE).flat_map_iter(|tile| tracer.closest_all(tile).into_iter().flatten()).collect()
        };
        let (pixel_hits, sample_hits) = (hits(&centres), hits(&samples));
        Self { left, right, centres, samples, pixel_hits, sample_hits }
    }

    /// How many rays a family has, with those that start on the side of a surface that the sun does not see.
    fn len(&self, family: Family) -> usize {
        match family {
            Family::Primary => self.centres.len(),
            Family::Primary4 => self.samples.len(),
            Family::Label => self.pixel_hits.len(),
            Family::Sun | Family::Ambient => self.sample_hits.len(),
        }
    }

    /// The camera that sees the frame.
    pub(crate) fn camera(&self) -> &Camera {
        &self.left
    }

    /// The rays of a family, batch by batch.
    pub(crate) fn batches(&self, family: Family) -> impl Iterator<Item = Batch> {
        (0..self.len(family).div_ceil(BATCH)).map(move |k| self.batch(family, k))
    }

    fn batch(&self, family: Family, k: usize) -> Batch {
        let part = k * BATCH..((k + 1) * BATCH).min(self.len(family));
        let mut rng = SeedPath::root("rays", 1).index(k as u64).rng();
        match family {
            Family::Primary => Batch::First(self.centres[part].to_vec()),
            Family::Primary4 => Batch::First(self.samples[part].to_vec()),
            Family::Label => {
                let target = self.right.position_m;
                Batch::Line(self.pixel_hits[part].iter().map(|hit| (Origin::on(hit), target)).collect())
            }
            Family::Sun => {
                let sun = sun();
                let rays = self.sample_hits[part].iter().map(|hit| (hit, in_disc(sun, &mut rng)));
                let lit = rays.filter(|(hit, d)| d.dot(hit.normal) > 0.0);
                Batch::Blocked(lit.map(|(hit, d)| (Origin::on(hit), d)).collect())
            }
            Family::Ambient => {
                let rays = self.sample_hits[part].iter().map(|hit| (Origin::on(hit), in_dome(hit.normal, &mut rng)));
                Batch::From(rays.collect())
            }
        }
    }

    /// Traces a family with the threads of the current pool. Gives the rays, how many of them met something, and the
    /// processor time of their tracing.
    pub(crate) fn trace(&self, tracer: &Tracer, family: Family) -> (usize, usize, Duration) {
        (0..self.len(family).div_ceil(BATCH))
            .into_par_iter()
            .map(|k| {
                let batch = self.batch(family, k);
                let begun = thread_cpu();
                let met = batch.trace(tracer);
                (batch.len(), met, thread_cpu().saturating_sub(begun))
            })
            .reduce(Default::default, |a, b| (a.0 + b.0, a.1 + b.1, a.2 + b.2))
    }
}

impl Batch {
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::First(rays) => rays.len(),
            Self::Line(rays) | Self::Blocked(rays) | Self::From(rays) => rays.len(),
        }
    }

    /// How many of the rays meet something.
    fn trace(&self, tracer: &Tracer) -> usize {
        let hits = |hits: Vec<Option<Hit>>| hits.iter().flatten().count();
        let blocked = |blocked: Vec<bool>| blocked.into_iter().filter(|b| *b).count();
        match self {
            Self::First(rays) => rays.chunks(TILE).map(|r| hits(tracer.closest_all(r))).sum(),
            Self::Line(rays) => rays.chunks(TILE).map(|r| blocked(tracer.occluded_all(r))).sum(),
            Self::Blocked(rays) => rays.chunks(TILE).map(|r| blocked(tracer.blocked_all(r))).sum(),
            Self::From(rays) => rays.chunks(TILE).map(|r| hits(tracer.closest_from_all(r))).sum(),
        }
    }

    /// For each ray the distance of what it meets, or infinity; of those that ask for anything at all, 0 or infinity.
    pub(crate) fn answers(&self, tracer: &Tracer) -> Vec<f32> {
        let hits = |hits: Vec<Option<Hit>>| hits.into_iter().map(|h| h.map_or(f32::INFINITY, |h| h.t as f32)).collect();
        let any = |met: Vec<bool>| met.into_iter().map(|met| if met { 0.0 } else { f32::INFINITY }).collect();
        match self {
            Self::First(rays) => hits(tracer.closest_all(rays)),
            Self::Line(rays) => any(tracer.occluded_all(rays)),
            Self::Blocked(rays) => any(tracer.blocked_all(rays)),
            Self::From(rays) => hits(tracer.closest_from_all(rays)),
        }
    }

    /// The rays as a tracer of f32 takes them: start, least distance, direction, largest distance. One that starts on a
    /// surface starts this far off it, m; what it meets there is not the same in any case.
    pub(crate) fn plain(&self, tracer: &Tracer) -> Vec<[f32; 8]> {
        const OFF_M: f64 = 0.002;
        let plain = |start: DVec3, direction: DVec3, length: f64| {
            let [start, direction] = [start, direction].map(|v| v.to_array().map(|x| x as f32));
            [start[0], start[1], start[2], 0.0, direction[0], direction[1], direction[2], length as f32]
        };
        let off = |origin: &Origin| origin.point() + origin.normal() * OFF_M;
        match self {
            Self::First(rays) => rays.iter().map(|r| plain(r.origin, r.direction, tracer.reach_m(r.origin))).collect(),
            Self::Line(lines) => lines
                .iter()
                .map(|(origin, target)| {
                    let way = *target - off(origin);
                    plain(off(origin), way.normalize(), way.length())
                })
                .collect(),
            Self::Blocked(rays) | Self::From(rays) => {
                rays.iter().map(|(origin, d)| plain(off(origin), *d, tracer.reach_m(origin.point()))).collect()
            }
        }
    }
}

/// Rays of one in `share` groups of 8 rows of tiles, of pixels cut into `fine` by `fine`, in the order of tiles.
fn rays(camera: &Camera, fine: u32, share: u32) -> Vec<Ray> {
    const GROUP: u32 = 8 * TILE_SIDE;
    let mut rng = SeedPath::root("samples", u64::from(fine)).rng();
    let (width, height) = (camera.width_px * fine, camera.height_px * fine);
    let mut rays = Vec::new();
    for top in (0..height).step_by(TILE_SIDE as usize).filter(|top| top / GROUP % share == share / 2) {
        for left in (0..width).step_by(TILE_SIDE as usize) {
            for (x, y) in tile_order(TILE_SIDE.min(width - left), TILE_SIDE.min(height - top)) {
                let mut place = |cell: u32| {
                    let within = if fine == 1 { 0.5 } else { rng.unit() };
                    (f64::from(cell) + within) / f64::from(fine) - 0.5
                };
                let (u, v) = (place(left + x), place(top + y));
                rays.push(camera.ray(u, v));
            }
        }
    }
    rays
}

/// A direction into the sun's disc.
fn in_disc(sun: DVec3, rng: &mut Rng) -> DVec3 {
    let (a, b) = sun.any_orthonormal_pair();
    loop {
        let (x, y) = (rng.signed(), rng.signed());
        if x * x + y * y <= 1.0 {
            return (sun + (a * x + b * y) * Environment::SUN_ANGULAR_RADIUS_RAD).normalize();
        }
    }
}

/// A direction into the dome about a normal, by the cosine: a point of the unit sphere about the normal's end.
fn in_dome(normal: DVec3, rng: &mut Rng) -> DVec3 {
    let point = DVec3::new(rng.normal(), rng.normal(), rng.normal()).normalize_or(DVec3::Z);
    (normal + point).normalize_or(normal)
}
