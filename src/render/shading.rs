//! Radiance along rays: what sun, dome and bounce send by way of the surfaces that they meet.

use super::ambient::Ask;
use super::light::Light;
use super::sampling::{Sample, cosine_direction, disc_direction};
use super::surface::{dress, fresnel, place, scatter, surface};
use glam::{DVec2, DVec3};
use satseed_scene::{Bands, Brdf, Environment, Ray, Shade, SurfacePoint};
use satseed_tracer::{Hit, Origin, Tracer};

const INV_PI: f32 = core::f32::consts::FRAC_1_PI;

/// What each pair of random numbers is for.
mod purpose {
    pub(super) const SUN: u32 = 1;
    pub(super) const SKY: u32 = 2;
    pub(super) const BOUNCE_SUN: u32 = 4;
}

/// A piece of surface that one ray of a cell meets, or several of them.
struct Patch {
    /// Place of its first ray, and of its cell.
    ray: usize,
    cell: usize,
    /// How many rays meet it.
    count: u32,
    /// Where the first ray meets it.
    hit: Hit,
    /// Of all rays: first their sum, then their mean.
    point: SurfacePoint,
}

impl Patch {
    /// Whether another ray of the cell meets the same surface: one material of one thing, lying the same way, without a
    /// seam between in its texture.
    fn is_met(&self, tracer: &Tracer, hit: &Hit, point: &SurfacePoint) -> bool {
        /// Cosine of the angle by which one surface may turn within a cell.
        const ALIKE: f64 = 0.98;
        let scene = tracer.scene();
        let first = &self.hit;
        if first.instance != hit.instance || first.normal.dot(hit.normal) < ALIKE {
            return false;
        }
        if first.triangle == hit.triangle {
            return true;
        }
        let mesh = &scene.meshes[scene.instances[hit.instance as usize].mesh as usize];
        let slot = |h: &Hit| mesh.slots[h.triangle as usize];
        let share = 1.0 / f64::from(self.count);
        let (apart_m, apart_uv_m) =
            ((self.point.world_m * share - point.world_m).length(), (self.point.uv_m * share - point.uv_m).length());
        slot(first) == slot(hit) && apart_uv_m <= 2.0 * apart_m + 1e-3
    }

    fn join(&mut self, point: &SurfacePoint) {
        self.count += 1;
        self.point.world_m += point.world_m;
        self.point.object_m += point.object_m;
        self.point.uv_m += point.uv_m;
        self.point.normal += point.normal;
        self.point.footprint_m += point.footprint_m;
    }

    fn close(&mut self) {
        if self.count > 1 {
            let share = 1.0 / f64::from(self.count);
            self.point.world_m *= share;
            self.point.object_m *= share;
            self.point.uv_m *= share;
            self.point.normal = self.point.normal.try_normalize().unwrap_or(self.hit.normal);
            self.point.footprint_m *= share;
        }
    }
}

/// The patch of a ray that meets nothing.
const NO_PATCH: u32 = u32::MAX;

/// The patches that rays meet, cell by cell, and for each ray the number of its own.
fn patches(
    tracer: &Tracer,
    rays: &[Ray],
    hits: &[Option<Hit>],
    spread: f64,
    per_cell: usize,
) -> (Vec<Patch>, Vec<u32>) {
    let mut patches: Vec<Patch> = Vec::with_capacity(rays.len());
    let mut patch_of = vec![NO_PATCH; rays.len()];
    for cell in 0..rays.len() / per_cell {
        let first_patch = patches.len();
        for ray in cell * per_cell..(cell + 1) * per_cell {
            let Some(hit) = &hits[ray] else { continue };
            let point = place(tracer, &rays[ray], hit, hit.t * spread);
            let known = patches[first_patch..].iter().position(|patch| patch.is_met(tracer, hit, &point));
            let patch = known.map_or(patches.len(), |k| first_patch + k);
            patch_of[ray] = patch as u32;
            if let Some(patch) = patches.get_mut(patch) {
                patch.join(&point);
            } else {
                patches.push(Patch { ray, cell, count: 1, hit: *hit, point });
            }
        }
        patches[first_patch..].iter_mut().for_each(Patch::close);
    }
    (patches, patch_of)
}

/// Mean radiance at the ground over cells, W / (m^2 sr um), each of `per_cell` camera rays one after the other. `spread` is a
/// cell's side per metre of distance. Neighbouring rays cost least.
///
/// What rays of a cell meet of one surface is dressed and lit once, over the cell's footprint: textures are filtered,
/// so that to ask them at each ray adds time and hardly anything else. Whether the sun is hidden is asked for each ray.
pub(super) fn radiance(
    tracer: &Tracer,
    light: &Light,
    rays: &[Ray],
    spread: f64,
    samples: &[Sample],
    per_cell: usize,
) -> Vec<Bands> {
    let share = 1.0 / per_cell as f32;
    let hits = tracer.closest_all(rays);
    let mut sums = vec![Bands::ZERO; rays.len() / per_cell];
    for (ray, _) in hits.iter().enumerate().filter(|(_, hit)| hit.is_none()) {
        sums[ray / per_cell] += light.sky_radiance(rays[ray].direction) * share;
    }
    let (patches, patch_of) = patches(tracer, rays, &hits, spread, per_cell);
    let shades: Vec<Shade> = patches.iter().map(|patch| dress(tracer, &patch.hit, &patch.point)).collect();
    // The sun's rays go side by side too.
    let lit: Vec<Bands> = patches
        .iter()
        .zip(&shades)
        .map(|(patch, shade)| {
            let square = if patch.count == 1 { samples[patch.ray].square(purpose::SUN) } else { DVec2::ZERO };
            sunlit(light, &patch.hit, shade, rays[patch.ray].direction, square).1
        })
        .collect();
    let mut scattered = Vec::with_capacity(rays.len());
    let mut sunward = Vec::with_capacity(rays.len());
    for (ray, patch) in patch_of.iter().enumerate() {
        if *patch != NO_PATCH && lit[*patch as usize].max_band() > 0.0 {
            let hit = hits[ray].as_ref().expect("a ray of a patch has a hit");
            scattered.push(*patch as usize);
            sunward.push((Origin::on(hit), to_sun(light, samples[ray].square(purpose::SUN))));
        }
    }
    let mut sums_of_patches = vec![Bands::ZERO; patches.len()];
    for (patch, blocked) in scattered.into_iter().zip(tracer.blocked_all(&sunward)) {
        if !blocked {
            sums_of_patches[patch] += lit[patch];
        }
    }
    // The mirrored direction where a surface has a coat; the dome from what the scene's views share, or one direction of it.
    let mut asked: Vec<(usize, Bands)> = Vec::with_capacity(patches.len());
    let mut outward: Vec<(Origin, DVec3)> = Vec::with_capacity(patches.len());
    let mut sides: Vec<(usize, Side)> = Vec::with_capacity(patches.len());
    for (k, (patch, shade)) in patches.iter().zip(&shades).enumerate() {
        let mut clear = 1.0;
        if let Some(index) = shade.brdf.mirror_index() {
            let view = rays[patch.ray].direction;
            let cos = -view.dot(shade.normal);
            let fresnel = fresnel(cos.clamp(0.0, 1.0) as f32, index);
            clear -= fresnel;
            if let Brdf::Coated { .. } = shade.brdf {
                sums_of_patches[k] = sums_of_patches[k] * clear;
            }
            asked.push((k, Bands::grey(fresnel * patch.count as f32)));
            outward.push((Origin::on(&patch.hit), (view + shade.normal * (2.0 * cos)).normalize()));
        }
        sides.extend(Side::of(patch, shade, clear).into_iter().flatten().map(|side| (k, side)));
    }
    let known = match &light.ambient {
        Some(ambient) => {
            let asks: Vec<Ask> = sides.iter().map(|(_, side)| side.ask).collect();
            ambient.irradiance(tracer, light, &asks)
        }
        None => vec![None; sides.len()],
    };
    let mut squares: Vec<usize> = asked.iter().map(|(k, _)| patches[*k].ray).collect();
    for ((k, side), irradiance) in sides.iter().zip(known) {
        if let Some(irradiance) = irradiance {
            sums_of_patches[*k] += side.scattered * irradiance * (INV_PI * patches[*k].count as f32);
            continue;
        }
        // Each ray asks for itself.
        let of_cell = patches[*k].cell * per_cell..(patches[*k].cell + 1) * per_cell;
        for ray in of_cell.filter(|ray| patch_of[*ray] == *k as u32) {
            let hit = hits[ray].as_ref().expect("a ray of a patch has a hit");
            if let Some(direction) = side.direction(samples[ray]) {
                asked.push((*k, side.scattered));
                outward.push((Origin::on(hit), direction));
                squares.push(ray);
            }
        }
    }
    let incoming = incoming(tracer, light, &outward, |i| samples[squares[i]].square(purpose::BOUNCE_SUN));
    for ((k, weight), incoming) in asked.iter().zip(incoming) {
        sums_of_patches[*k] += *weight * incoming;
    }
    for (patch, sum) in patches.iter().zip(sums_of_patches) {
        sums[patch.cell] += sum * share;
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
    fn of(patch: &Patch, shade: &Shade, clear: f32) -> [Option<Self>; 2] {
        let geometric = patch.hit.normal;
        let ask = Ask { point_m: patch.point.world_m, geometric, normal: shade.normal, leaf: false };
        let side = |ask, scattered: Bands| Some(Self { ask, scattered: scattered * clear });
        match shade.brdf {
            Brdf::Leaf { transmission } => {
                let behind = Ask { geometric: -geometric, normal: -shade.normal, leaf: true, ..ask };
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
    let to_sun = to_sun(light, square);
    (to_sun, light.sun_irradiance * scatter(shade, hit.normal, to_sun, view))
}

/// A direction to the sun's disc, chosen by a point of the unit square; (0, 0) is its centre.
fn to_sun(light: &Light, square: DVec2) -> DVec3 {
    disc_direction(light.sun, Environment::SUN_ANGULAR_RADIUS_RAD, square)
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
        let shade = surface(tracer, &ray, &hit, BOUNCE_FOOTPRINT_M.max(0.3 * hit.t));
        let start = Origin::on(&hit);
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
