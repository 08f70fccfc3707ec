//! Radiance of one ray.

use super::ambient::Ask;
use super::light::Light;
use super::sampling::{Sample, cosine_direction, disc_direction};
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
        if let Brdf::Coated { index } = shade.brdf {
            let view = rays[i].direction;
            let cos = -view.dot(shade.normal);
            let fresnel = fresnel(cos.clamp(0.0, 1.0) as f32, index);
            clear -= fresnel;
            sums[i] = sums[i] * clear;
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

/// The material at a hit over a footprint (m, square on), and the start of the rays that leave it.
fn surface(tracer: &Tracer, ray: &Ray, hit: &Hit, footprint_m: f64) -> (Shade, Origin) {
    let scene = tracer.scene();
    let instance = &scene.instances[hit.instance as usize];
    let mesh = &scene.meshes[instance.mesh as usize];
    let corners = mesh.triangles[hit.triangle as usize].map(|v| v as usize);
    let w = hit.weights;
    let object_m = (0..3).fold(DVec3::ZERO, |sum, k| {
        let p = mesh.positions_m[corners[k]];
        sum + DVec3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2])) * w[k]
    });
    let uv_m = if mesh.uvs_m.is_empty() {
        DVec2::ZERO
    } else {
        (0..3).fold(DVec2::ZERO, |sum, k| {
            let p = mesh.uvs_m[corners[k]];
            sum + DVec2::new(f64::from(p[0]), f64::from(p[1])) * w[k]
        })
    };
    let normal = if mesh.normals.is_empty() {
        hit.normal
    } else {
        let smooth = (0..3).fold(DVec3::ZERO, |sum, k| {
            let n = mesh.normals[corners[k]];
            sum + DVec3::new(f64::from(n[0]), f64::from(n[1]), f64::from(n[2])) * w[k]
        });
        // The cofactors turn normals as the inverse's transpose does, up to a length that does not count here.
        let m = instance.world_from_object.matrix3;
        let world = m.y_axis.cross(m.z_axis) * smooth.x
            + m.z_axis.cross(m.x_axis) * smooth.y
            + m.x_axis.cross(m.y_axis) * smooth.z;
        let n = world.try_normalize().unwrap_or(hit.normal);
        if n.dot(hit.normal) < 0.0 { -n } else { n }
    };
    // The footprint stretches where the surface leans away; its geometric mean side counts.
    let cos = (-ray.direction.dot(hit.normal)).max(0.1);
    let point = SurfacePoint {
        world_m: hit.point,
        object_m,
        uv_m,
        normal,
        footprint_m: footprint_m / cos.sqrt(),
        variation: instance.variation,
    };
    let mut shade = scene.material(hit.instance, hit.triangle).shade(&point, &scene.rasters);
    if shade.normal.dot(hit.normal) < 0.05 {
        // A bump must not turn a surface away from its own side.
        shade.normal = (shade.normal + hit.normal * (0.05 - shade.normal.dot(hit.normal))).normalize();
    }
    (shade, Origin::on(hit))
}

/// A direction to the sun's disc, chosen by a point of the unit square, and the radiance scattered from there if nothing stands between.
fn sunlit(light: &Light, hit: &Hit, shade: &Shade, view: DVec3, square: DVec2) -> (DVec3, Bands) {
    let to_sun = disc_direction(light.sun, Environment::SUN_ANGULAR_RADIUS_RAD, square);
    (to_sun, light.sun_irradiance * scatter(shade, hit.normal, to_sun, view))
}

/// Bidirectional reflectance times the cosine, per unit of irradiance on a surface that faces the light.
fn scatter(shade: &Shade, geometric: DVec3, to_light: DVec3, view: DVec3) -> Bands {
    let cos = to_light.dot(shade.normal) as f32;
    let front = to_light.dot(geometric) > 0.0;
    match shade.brdf {
        Brdf::Leaf { transmission } => {
            if front {
                shade.albedo * (cos.max(0.0) * INV_PI)
            } else {
                transmission * ((-cos).max(0.0) * INV_PI)
            }
        }
        Brdf::Diffuse { roughness_rad } if front && cos > 0.0 => {
            shade.albedo * (cos * INV_PI * oren_nayar(roughness_rad, shade.normal, to_light, -view))
        }
        Brdf::Coated { .. } if front && cos > 0.0 => shade.albedo * (cos * INV_PI),
        _ => Bands::ZERO,
    }
}

/// The factor on Lambert's law of a surface of rough facets (Oren and Nayar 1994, the qualitative model).
fn oren_nayar(sigma: f32, normal: DVec3, light: DVec3, view: DVec3) -> f32 {
    if sigma <= 0.0 {
        return 1.0;
    }
    let s2 = f64::from(sigma * sigma);
    let a = 1.0 - 0.5 * s2 / (s2 + 0.33);
    let b = 0.45 * s2 / (s2 + 0.09);
    let (ci, cr) = (light.dot(normal).clamp(1e-4, 1.0), view.dot(normal).clamp(1e-4, 1.0));
    let across = light.dot(view) - ci * cr;
    // Oren-Nayar in vector form: cos(phi) sin(alpha) tan(beta) = across / max(ci, cr).
    let lobe = if across > 0.0 { across / ci.max(cr) } else { 0.0 };
    (a + b * lobe) as f32
}

/// Unpolarised Fresnel reflectance of a dielectric.
pub(super) fn fresnel(cos: f32, index: f32) -> f32 {
    let sin2 = (1.0 - cos * cos) / (index * index);
    let cos_t = (1.0 - sin2).max(0.0).sqrt();
    let parallel = (index * cos - cos_t) / (index * cos + cos_t);
    let perpendicular = (cos - index * cos_t) / (cos + index * cos_t);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
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
mod tests {
    use super::*;
    use glam::DAffine3;
    use satseed_scene::{Class, Instance, Material, Mesh, Object, Scene};

    #[test]
    fn fresnel_at_normal_and_grazing_incidence() {
        assert!((fresnel(1.0, 1.52) - 0.0426).abs() < 1e-3);
        assert!((fresnel(0.0, 1.52) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_rough_surface_does_not_create_energy() {
        let n = DVec3::Z;
        let view = DVec3::new(0.4, 0.0, 0.9).normalize();
        let count = 2000;
        let reflected: f64 = (0..count)
            .map(|i| {
                let d = cosine_direction(n, Sample::new(0, 0, i, 0).square(0));
                f64::from(oren_nayar(0.5, n, d, view))
            })
            .sum::<f64>()
            / f64::from(count);
        assert!(reflected < 1.0 && reflected > 0.7, "{reflected}");
    }

    /// A plane of one square, Lambert, reflectance 0.4.
    fn plane() -> Scene {
        let corner = |x: f32, y: f32| [x * 100.0, y * 100.0, 3.0];
        Scene {
            meshes: vec![Mesh {
                positions_m: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                slots: vec![0, 0],
                ..Mesh::default()
            }],
            instances: vec![Instance {
                mesh: 0,
                world_from_object: DAffine3::IDENTITY,
                object: 0,
                material_set: 0,
                variation: [0.0; 4],
            }],
            materials: vec![Material::diffuse("plane", Class::Ground, Bands::grey(0.4))],
            material_sets: vec![vec![0]],
            objects: vec![Object { path: "terrain".to_owned(), class: Class::Ground }],
            ..Scene::default()
        }
    }

    /// A sky that is the same from everywhere, and no sun.
    fn furnace(radiance: f32) -> Light {
        let environment = Environment { sun_elevation_rad: 0.7, sun_azimuth_rad: 2.0, aerosol_optical_depth: 0.1 };
        Light {
            sun_irradiance: Bands::ZERO,
            sky_irradiance: Bands::grey(core::f32::consts::PI * radiance),
            sky_scale: Bands::ZERO,
            sky_uniform: Bands::grey(radiance),
            ..Light::over(&environment, Bands::ZERO)
        }
    }

    /// A scene of one mesh and one material.
    fn one(positions_m: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>, material: Material) -> Scene {
        let slots = vec![0; triangles.len()];
        let mesh = Mesh { positions_m, triangles, slots, ..Mesh::default() };
        Scene { meshes: vec![mesh], materials: vec![material], ..plane() }
    }

    fn octahedron(material: Material) -> Scene {
        let axis = |k: usize, sign: f32| core::array::from_fn(|i| if i == k { 10.0 * sign } else { 0.0 });
        let positions = vec![axis(0, 1.0), axis(0, -1.0), axis(1, 1.0), axis(1, -1.0), axis(2, 1.0), axis(2, -1.0)];
        let mut triangles = Vec::new();
        for (x, y, z) in [(0, 2, 4), (0, 3, 4), (1, 2, 4), (1, 3, 4), (0, 2, 5), (0, 3, 5), (1, 2, 5), (1, 3, 5)] {
            // Outward whichever octant it is.
            let flip = (x ^ (y - 2) ^ (z - 4)) & 1 == 1;
            triangles.push(if flip { [x, z, y] } else { [x, y, z] });
        }
        one(positions, triangles, material)
    }

    /// Mean radiance of a spot that a ray meets.
    fn spot(scene: &Scene, light: &Light, ray: Ray, count: u32) -> f32 {
        let tracer = Tracer::new(scene);
        let samples: Vec<Sample> = (0..count).map(|i| Sample::new(4, 7, i, 11)).collect();
        let rays = vec![ray; count as usize];
        radiance(&tracer, light, &rays, 1e-3, &samples).iter().map(|b| b[1]).sum::<f32>() / count as f32
    }

    /// A convex body under a uniform sky sends back the sky's radiance times all that its surface does not absorb: nothing
    /// else stands before it, whatever its surface does with light.
    #[test]
    fn white_furnace_of_a_convex_body() {
        let light = furnace(3.0);
        let white = |brdf| Material { brdf, ..Material::diffuse("white", Class::Ground, Bands::grey(0.95)) };
        let surfaces = [
            (Brdf::Diffuse { roughness_rad: 0.0 }, 0.95, 1e-4),
            // Rough facets as Oren and Nayar's qualitative model has them: some inter-reflection is missing, none added.
            (Brdf::Diffuse { roughness_rad: 0.5 }, 0.95, 0.0),
        ];
        for from in [DVec3::new(3.0, 4.0, 40.0), DVec3::new(-30.0, 12.0, -20.0)] {
            let ray = Ray { origin: from, direction: (DVec3::new(0.4, 0.5, 0.3) - from).normalize() };
            for (brdf, kept, tolerance) in surfaces {
                let found = spot(&octahedron(white(brdf)), &light, ray, 256);
                assert!(found <= 3.0 * kept * 1.0001, "{brdf:?} makes light: {found}");
                assert!(tolerance == 0.0 || (found / (3.0 * kept) - 1.0).abs() < tolerance, "{brdf:?}: {found}");
            }
            // A coat mirrors what it does not let in: with a base that keeps 0.95, between that and 1.
            let coat = spot(&octahedron(white(Brdf::Coated { index: 1.5 })), &light, ray, 256);
            assert!((2.85..=3.0001).contains(&coat), "a coat: {coat}");
        }
        // A leaf that absorbs nothing sends back all of it.
        let leaf = Brdf::Leaf { transmission: Bands::grey(0.4) };
        let material = Material { brdf: leaf, ..Material::diffuse("leaf", Class::Tree, Bands::grey(0.6)) };
        let scene = Scene { materials: vec![material], ..plane() };
        let ray = Ray { origin: DVec3::new(1.0, 2.0, 900.0), direction: DVec3::NEG_Z };
        let found = spot(&scene, &light, ray, 4096);
        assert!((found / 3.0 - 1.0).abs() < 0.01, "a leaf: {found}");
    }

    /// A hemispherical bowl: every place sees its rim's opening and itself by one half each (a sphere's form factors), so
    /// that n bounces give `L (r/2 + (r/2)^2 + ...)`; two are traced.
    #[test]
    fn white_furnace_of_a_bowl() {
        const RINGS: u32 = 24;
        const SECTORS: u32 = 96;
        let mut positions = Vec::new();
        for ring in 0..=RINGS {
            let (down, out) = libm::sincos(f64::from(ring) / f64::from(RINGS) * core::f64::consts::FRAC_PI_2);
            for sector in 0..SECTORS {
                let (s, c) = libm::sincos(f64::from(sector) / f64::from(SECTORS) * core::f64::consts::TAU);
                positions.push([(20.0 * out * c) as f32, (20.0 * out * s) as f32, (-20.0 * down) as f32]);
            }
        }
        let mut triangles = Vec::new();
        for ring in 0..RINGS {
            for k in 0..SECTORS {
                let (a, b) = (ring * SECTORS + k, ring * SECTORS + (k + 1) % SECTORS);
                let (c, d) = (a + SECTORS, b + SECTORS);
                triangles.push([a, b, c]);
                if ring + 1 < RINGS {
                    triangles.push([b, d, c]);
                }
            }
        }
        let light = furnace(3.0);
        for reflectance in [0.3_f32, 0.9] {
            let material = Material::diffuse("bowl", Class::Ground, Bands::grey(reflectance));
            let scene = one(positions.clone(), triangles.clone(), material);
            for foot in [DVec3::new(0.3, 0.2, 0.0), DVec3::new(11.0, 5.0, 0.0), DVec3::new(-2.0, 18.0, 0.0)] {
                let ray = Ray { origin: foot + DVec3::Z * 50.0, direction: DVec3::NEG_Z };
                let half = reflectance / 2.0;
                let expected = 3.0 * (half + half * half);
                let found = spot(&scene, &light, ray, 4096);
                assert!((found / expected - 1.0).abs() < 0.015, "{reflectance} at {foot}: {found} against {expected}");
            }
        }
    }

    /// `rho / pi * E * cos(theta)`, to the disc's own spread; and under the dome alone `rho / pi * E_sky` in the mean.
    #[test]
    fn a_lambert_plane_has_its_closed_form() {
        let scene = plane();
        let tracer = Tracer::new(&scene);
        let environment = Environment { sun_elevation_rad: 0.7, sun_azimuth_rad: 2.0, aerosol_optical_depth: 0.12 };
        let light = Light::over(&environment, Bands::grey(0.4));
        let ray = Ray { origin: DVec3::new(1.0, 2.0, 900.0), direction: DVec3::NEG_Z };
        let hit = tracer.closest(&ray, 2000.0).expect("the plane is there");
        let (shade, origin) = surface(&tracer, &ray, &hit, 0.3);
        let count = 4096;
        let (mut sun, mut sky) = (0.0, 0.0);
        for i in 0..count {
            let sample = Sample::new(1, 1, i, 5);
            let (to_sun, radiance) = sunlit(&light, &hit, &shade, ray.direction, sample.square(purpose::SUN));
            assert!(!tracer.blocked(&origin, to_sun, 1e4));
            sun += radiance[1];
            let [side, _] = Side::of(&hit, &shade, 1.0);
            let side = side.expect("every surface has one");
            if let Some(direction) = side.direction(sample) {
                let square = sample.square(purpose::BOUNCE_SUN);
                sky += (side.scattered * incoming(&tracer, &light, &[(origin, direction)], |_| square)[0])[1];
            }
        }
        let n = count as f32;
        let expected = 0.4 * INV_PI * light.sun_irradiance[1] * libm::sin(0.7) as f32;
        assert!((sun / n / expected - 1.0).abs() < 2e-5, "sun {} against {expected}", sun / n);
        let expected = 0.4 * INV_PI * light.sky_irradiance[1];
        assert!((sky / n / expected - 1.0).abs() < 0.01, "sky {} against {expected}", sky / n);
    }
}
