//! Closed forms: furnaces and the Lambert plane.

use super::super::test_scenes::{of, one, plane};
use super::*;
use satseed_scene::{Class, Field, Fractal, Layer, Material, Mesh, Scene, Space};

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
    radiance(&tracer, light, &rays, 1e-3, &samples, 1).iter().map(|b| b[1]).sum::<f32>() / count as f32
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
    let (shade, origin) = (surface(&tracer, &ray, &hit, 0.3), Origin::on(&hit));
    let count = 4096;
    let (mut sun, mut sky) = (0.0, 0.0);
    for i in 0..count {
        let sample = Sample::new(1, 1, i, 5);
        let (to_sun, radiance) = sunlit(&light, &hit, &shade, ray.direction, sample.square(purpose::SUN));
        assert!(!tracer.blocked(&origin, to_sun, 1e4));
        sun += radiance[1];
        let patch = Patch { ray: 0, cell: 0, count: 1, hit, point: place(&tracer, &ray, &hit, 0.3) };
        let [side, _] = Side::of(&patch, &shade, 1.0);
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

/// A wall in an open plain: half the sky's irradiance under a dome that is the same everywhere, and half of what the plain
/// sends up. The plain is lit by the sun and, where the series of bounces ends, by half the sky.
#[test]
fn a_wall_in_an_open_plain_sees_half_sky_and_half_ground() {
    let far = 2.0e4;
    let mut positions = vec![[-far, -far, 0.0], [far, -far, 0.0], [far, far, 0.0], [-far, far, 0.0]];
    // Facing south, 12 m high and wide enough that its ends do not count; thin, so that it has no top to speak of.
    positions.extend([[-8.0, 0.0, 0.0], [8.0, 0.0, 0.0], [8.0, 0.0, 12.0], [-8.0, 0.0, 12.0]]);
    let triangles = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    let ground = 0.3;
    let scene = one(positions, triangles, Material::diffuse("plain", Class::Ground, Bands::grey(ground)));
    let tracer = Tracer::new(&scene);
    // The sun in the south: the plain before the wall is lit, and so is the wall, but not by the sun here.
    let environment =
        Environment { sun_elevation_rad: 0.73, sun_azimuth_rad: core::f64::consts::PI, aerosol_optical_depth: 0.12 };
    let sky = 40.0;
    let light = Light {
        sky_irradiance: Bands::grey(core::f32::consts::PI * sky),
        sky_scale: Bands::ZERO,
        sky_uniform: Bands::grey(sky),
        ..Light::over(&environment, Bands::ZERO)
    };
    let ray = Ray { origin: DVec3::new(0.3, -40.0, 5.0), direction: DVec3::Y };
    let hit = tracer.closest(&ray, 100.0).expect("the wall is there");
    assert!(hit.normal.y < -0.99, "{}", hit.normal);
    let count = 8192;
    let rays: Vec<_> = (0..count)
        .map(|i| (Origin::on(&hit), cosine_direction(hit.normal, Sample::new(2, 9, i, 4).square(purpose::SKY))))
        .collect();
    let arrived = incoming(&tracer, &light, &rays, |k| Sample::new(2, 9, k as u32, 4).square(purpose::BOUNCE_SUN));
    let found = arrived.iter().map(|b| b[1]).sum::<f32>() * core::f32::consts::PI / count as f32;
    let (sky, sun) = (light.sky_irradiance[1], light.sun_irradiance[1] * libm::sin(0.73) as f32);
    let traced = 0.5 * sky + 0.5 * ground * (sun + 0.5 * sky);
    assert!((found / traced - 1.0).abs() < 0.01, "{found} against {traced}");
    // All bounces: what is left out is small.
    let whole = 0.5 * sky + 0.5 * ground * (sun + sky);
    assert!((0.93..1.0).contains(&(found / whole)), "{found} against {whole}");
}

/// The edge of a plate 100 m up, the sun in the zenith: the lit share of the disc follows from the distance, over 0.93 m.
#[test]
fn a_penumbra_is_as_wide_as_the_suns_disc() {
    let far = 500.0;
    let mut positions = vec![[-far, -far, 0.0], [far, -far, 0.0], [far, far, 0.0], [-far, far, 0.0]];
    positions.extend([[-far, -far, 100.0], [0.0, -far, 100.0], [0.0, far, 100.0], [-far, far, 100.0]]);
    let triangles = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    let scene = one(positions, triangles, Material::diffuse("grey", Class::Ground, Bands::grey(0.2)));
    let tracer = Tracer::new(&scene);
    let environment = Environment {
        sun_elevation_rad: core::f64::consts::FRAC_PI_2,
        sun_azimuth_rad: 0.0,
        aerosol_optical_depth: 0.1,
    };
    let light = Light::over(&environment, Bands::ZERO);
    let radius_m = 100.0 * libm::tan(Environment::SUN_ANGULAR_RADIUS_RAD);
    assert!((2.0 * radius_m - 0.93).abs() < 0.01, "{radius_m}");
    for t in [-1.1, -0.6, 0.0, 0.4, 0.8, 1.1_f64] {
        let ray = Ray { origin: DVec3::new(t * radius_m, 3.0, 50.0), direction: DVec3::NEG_Z };
        let hit = tracer.closest(&ray, 100.0).expect("the ground is there");
        let (shade, origin) = (surface(&tracer, &ray, &hit, 0.3), Origin::on(&hit));
        let count = 4096;
        let lit = (0..count)
            .filter(|i| {
                let square = Sample::new(6, 1, *i, 3).square(purpose::SUN);
                let (to_sun, _) = sunlit(&light, &hit, &shade, ray.direction, square);
                !tracer.blocked(&origin, to_sun, 1e4)
            })
            .count() as f64
            / f64::from(count);
        let c = t.clamp(-1.0, 1.0);
        let expected = 0.5 + (libm::asin(c) + c * (1.0 - c * c).sqrt()) / core::f64::consts::PI;
        assert!((lit - expected).abs() < 0.01, "{t}: {lit} against {expected}");
    }
}

/// What rays of a cell share costs no accuracy that counts: a plane of two materials, one of noise that a cell resolves, one
/// plain, with a ridge across it that throws a shadow.
#[test]
fn cells_that_share_are_the_mean_of_their_rays() {
    const PER_CELL: usize = 4;
    let mut positions: Vec<[f32; 3]> = Vec::new();
    let (mut triangles, mut slots) = (Vec::new(), Vec::new());
    for (k, (x0, x1)) in [(-50.0_f32, 0.0), (0.0, 50.0)].into_iter().enumerate() {
        let first = positions.len() as u32;
        positions.extend([[x0, -50.0, 0.0], [x1, -50.0, 0.0], [x1, 50.0, 0.0], [x0, 50.0, 0.0]]);
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        slots.extend([k as u16; 2]);
    }
    let first = positions.len() as u32;
    positions.extend([[-50.0, 8.0, 0.0], [50.0, 8.0, 0.0], [50.0, 9.0, 3.0], [-50.0, 9.0, 3.0]]);
    positions.extend([[-50.0, 10.0, 0.0], [50.0, 10.0, 0.0]]);
    triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    triangles.extend([[first + 3, first + 2, first + 5], [first + 3, first + 5, first + 4]]);
    slots.extend([1; 4]);
    let rough = Material::diffuse("rough", Class::Ground, Bands::grey(0.3))
        .rough(0.3)
        .with(Layer::Brightness { amount: Field::Noise(Fractal::new(Space::World, 5, 0.9, 1)) });
    let plain = Material::diffuse("plain", Class::Ground, Bands::grey(0.2));
    // Off the planes between the light lattice's slabs.
    for p in &mut positions {
        p[2] += 0.4;
    }
    let mesh = Mesh { positions_m: positions, triangles, slots, ..Mesh::default() };
    let scene = of(mesh, vec![rough, plain]);
    let tracer = Tracer::new(&scene);
    let environment = Environment { sun_elevation_rad: 0.6, sun_azimuth_rad: 0.0, aerosol_optical_depth: 0.1 };
    let light = Light::over(&environment, Bands::grey(0.2)).with_ambient(super::super::AmbientMode::PerScene, 60.0);
    let side_m = 0.15;
    let from = DVec3::new(3.0, -4.0, 900.0);
    let cells: Vec<(i32, i32)> = (-40..40).flat_map(|j| (-40..40).map(move |i| (i, j * 3))).collect();
    let (mut rays, mut samples) = (Vec::new(), Vec::new());
    for (i, j) in &cells {
        for index in 0..PER_CELL as u32 {
            let sample = Sample::new(*i, *j, index, 3);
            let step = DVec2::new(f64::from(index % 2), f64::from(index / 2));
            let foot = (DVec2::new(f64::from(*i) - 0.5, f64::from(*j)) + (step + sample.square(0)) * 0.5) * side_m;
            rays.push(Ray { origin: from, direction: (foot.extend(0.0) - from).normalize() });
            samples.push(sample);
        }
    }
    let spread = side_m / 900.0;
    let together = radiance(&tracer, &light, &rays, spread, &samples, PER_CELL);
    let alone = radiance(&tracer, &light, &rays, 0.5 * spread, &samples, 1);
    let (mut square, mut sum, mut total) = (0.0, 0.0, 0.0);
    let mut mixed = 0;
    for (k, (i, _)) in cells.iter().enumerate() {
        let mean = alone[k * PER_CELL..][..PER_CELL].iter().map(|b| f64::from(b[1])).sum::<f64>() / PER_CELL as f64;
        let found = f64::from(together[k][1]);
        square += (found - mean) * (found - mean);
        sum += found - mean;
        total += mean;
        // Plain ground far from the ridge: nothing but the place on the sun's disc differs.
        if *i > 2 && cells[k].1 < 0 {
            assert!((found / mean - 1.0).abs() < 2e-3, "{found} against {mean}");
        }
        mixed += i32::from(*i == 0);
    }
    let n = cells.len() as f64;
    let (rms, bias) = ((square / n).sqrt() / (total / n), sum / total);
    assert!(mixed > 50 && rms < 0.01 && bias.abs() < 1e-3, "rms {rms}, bias {bias}, {mixed} cells at the border");
}
