//! Radiance along rays: what sun, dome and bounce send by way of the surfaces that they meet.

use super::ambient::Ask;
use super::light::Light;
use super::sampling::{Sample, cosine_direction, disc_direction};
use super::surface::{fresnel, scatter, surface};
use glam::{DVec2, DVec3};
use satseed_scene::{Bands, Brdf, Environment, Ray, Shade};
use satseed_tracer::{Hit, Origin, Tracer};

const INV_PI: f32 = core::f32::consts::FRAC_1_PI;

/// What each pair of random numbers is for.
mod purpose {
    pub(super) const SUN: u32 = 1;
    pub(super) const SKY: u32 = 2;
    pub(super) const BOUNCE_SUN: u32 = 4;
}

/// A surface point under way to a colour.
struct Lit {
    hit: Hit,
    shade: Shade,
    origin: Origin,
}

/// Radiance at the ground along camera rays, W / (m^2 sr um). `spread` is the footprint's growth per metre. Neighbouring
/// rays cost least.
pub(super) fn radiance(tracer: &Tracer, light: &Light, rays: &[Ray], spread: f64, samples: &[Sample]) -> Vec<Bands> {
    let points: Vec<Option<Lit>> = tracer
        .closest_all(rays)
        .into_iter()
        .zip(rays)
        .map(|(hit, ray)| {
            let hit = hit?;
            let (shade, origin) = surface(tracer, ray, &hit, hit.t * spread);
            Some(Lit { hit, shade, origin })
        })
        .collect();
    let mut sums: Vec<Bands> = points
        .iter()
        .zip(rays)
        .map(|(point, ray)| if point.is_some() { Bands::ZERO } else { light.sky_radiance(ray.direction) })
        .collect();
    // The sun's rays go side by side too.
    let mut scattered = Vec::with_capacity(rays.len());
    let mut sunward = Vec::with_capacity(rays.len());
    for (i, point) in points.iter().enumerate() {
        let Some(Lit { hit, shade, origin }) = point else { continue };
        let (to_sun, radiance) = sunlit(light, hit, shade, rays[i].direction, samples[i].square(purpose::SUN));
        if radiance.max_band() > 0.0 {
            scattered.push((i, radiance));
            sunward.push((*origin, to_sun));
        }
    }
    for ((i, radiance), blocked) in scattered.into_iter().zip(tracer.blocked_all(&sunward)) {
        if !blocked {
            sums[i] = radiance;
        }
    }
    // The mirrored direction where a surface has a coat; the dome from what the scene's views share, or one direction of it.
    let mut asked: Vec<(usize, Bands)> = Vec::with_capacity(rays.len());
    let mut outward: Vec<(Origin, DVec3)> = Vec::with_capacity(rays.len());
    let mut sides: Vec<(usize, Side)> = Vec::with_capacity(rays.len());
    for (i, point) in points.iter().enumerate() {
        let Some(Lit { hit, shade, origin }) = point else { continue };
        let mut clear = 1.0;
        if let Some(index) = shade.brdf.mirror_index() {
            let view = rays[i].direction;
            let cos = -view.dot(shade.normal);
            let fresnel = fresnel(cos.clamp(0.0, 1.0) as f32, index);
            clear -= fresnel;
            if let Brdf::Coated { .. } = shade.brdf {
                sums[i] = sums[i] * clear;
            }
            asked.push((i, Bands::grey(fresnel)));
            outward.push((*origin, (view + shade.normal * (2.0 * cos)).normalize()));
        }
        sides.extend(Side::of(hit, shade, clear).into_iter().flatten().map(|side| (i, side)));
    }
    let known = match &light.ambient {
        Some(ambient) => {
            let asks: Vec<Ask> = sides.iter().map(|(_, side)| side.ask).collect();
            ambient.irradiance(tracer, light, &asks)
        }
        None => vec![None; sides.len()],
    };
    for ((i, side), irradiance) in sides.iter().zip(known) {
        if let Some(irradiance) = irradiance {
            sums[*i] += side.scattered * irradiance * INV_PI;
        } else if let Some(Lit { origin, .. }) = &points[*i]
            && let Some(direction) = side.direction(samples[*i])
        {
            asked.push((*i, side.scattered));
            outward.push((*origin, direction));
        }
    }
    let incoming = incoming(tracer, light, &outward, |k| samples[asked[k].0].square(purpose::BOUNCE_SUN));
    for ((i, weight), incoming) in asked.iter().zip(incoming) {
        sums[*i] += *weight * incoming;
    }
    sums
}

/// A side of a surface that the dome lights, and how much of it goes on to the viewer.
struct Side {
    ask: Ask,
    scattered: Bands,
}

impl Side {
    /// The viewer's side, and a leaf's other one. `clear` is what a coat lets through.
    fn of(hit: &Hit, shade: &Shade, clear: f32) -> [Option<Self>; 2] {
        let ask = Ask { point_m: hit.point, geometric: hit.normal, normal: shade.normal, leaf: false };
        let side = |ask, scattered: Bands| Some(Self { ask, scattered: scattered * clear });
        match shade.brdf {
            Brdf::Leaf { transmission } => {
                let behind = Ask { geometric: -hit.normal, normal: -shade.normal, leaf: true, ..ask };
                [side(Ask { leaf: true, ..ask }, shade.albedo), side(behind, transmission)]
            }
            _ => [side(ask, shade.albedo), None],
        }
    }

    /// One direction of this side's dome, with density cos / pi; none where a bump turned it into the surface.
    fn direction(&self, sample: Sample) -> Option<DVec3> {
        let direction = cosine_direction(self.ask.normal, sample.square(purpose::SKY));
        (direction.dot(self.ask.geometric) > 0.0).then_some(direction)
    }
}

/// A direction to the sun's disc, chosen by a point of the unit square, and the radiance scattered from there if nothing stands between.
fn sunlit(light: &Light, hit: &Hit, shade: &Shade, view: DVec3, square: DVec2) -> (DVec3, Bands) {
    let to_sun = disc_direction(light.sun, Environment::SUN_ANGULAR_RADIUS_RAD, square);
    (to_sun, light.sun_irradiance * scatter(shade, hit.normal, to_sun, view))
}

/// Least footprint at which a surface lights another, m.
const BOUNCE_FOOTPRINT_M: f64 = 1.5;

/// Radiance that arrives at surface points from directions: sky, or the sunlit and sky-lit surface that hides it. `square`
/// gives the point of the unit square that chooses the k-th one's place on the sun's disc.
pub(super) fn incoming(
    tracer: &Tracer,
    light: &Light,
    from: &[(Origin, DVec3)],
    square: impl Fn(usize) -> DVec2,
) -> Vec<Bands> {
    let mut sums = Vec::with_capacity(from.len());
    let mut sunlit_from = Vec::new();
    let mut sunward = Vec::new();
    for (k, (hit, (origin, direction))) in tracer.closest_from_all(from).into_iter().zip(from).enumerate() {
        let Some(hit) = hit else {
            sums.push(light.sky_radiance(*direction));
            continue;
        };
        let ray = Ray { origin: origin.point(), direction: *direction };
        // One of many directions: the other surface counts with its mean colour over a good part of itself.
        let (shade, start) = surface(tracer, &ray, &hit, BOUNCE_FOOTPRINT_M.max(0.3 * hit.t));
        // Half the dome, for a wall sees half of it and a street less: the series of further bounces ends here.
        sums.push(shade.albedo * light.sky_irradiance * (0.5 * INV_PI));
        let (to_sun, radiance) = sunlit(light, &hit, &shade, *direction, square(k));
        if radiance.max_band() > 0.0 {
            sunlit_from.push((k, radiance));
            sunward.push((start, to_sun));
        }
    }
    for ((k, radiance), blocked) in sunlit_from.into_iter().zip(tracer.blocked_all(&sunward)) {
        if !blocked {
            sums[k] += radiance;
        }
    }
    sums
}

#[cfg(test)]
mod tests;
