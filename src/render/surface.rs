//! A surface point: its material over a footprint, and how it scatters light.

use glam::{DVec2, DVec3};
use satseed_scene::{Bands, Brdf, Ray, Shade, SurfacePoint};
use satseed_tracer::{Hit, Tracer};

const INV_PI: f32 = core::f32::consts::FRAC_1_PI;

/// Where a hit lies, in every frame that a material may be keyed by. The footprint (m, square on) stretches where the
/// surface leans away; its geometric mean side counts.
pub(super) fn place(tracer: &Tracer, ray: &Ray, hit: &Hit, footprint_m: f64) -> SurfacePoint {
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
    let cos = (-ray.direction.dot(hit.normal)).max(0.1);
    SurfacePoint {
        world_m: hit.point,
        object_m,
        uv_m,
        normal,
        footprint_m: footprint_m / cos.sqrt(),
        variation: instance.variation,
    }
}

/// The material at a place of a hit's triangle.
pub(super) fn dress(tracer: &Tracer, hit: &Hit, point: &SurfacePoint) -> Shade {
    let scene = tracer.scene();
    let mut shade = scene.material(hit.instance, hit.triangle).shade(point, &scene.rasters);
    if shade.normal.dot(hit.normal) < 0.05 {
        // A bump must not turn a surface away from its own side.
        shade.normal = (shade.normal + hit.normal * (0.05 - shade.normal.dot(hit.normal))).normalize();
    }
    shade
}

/// The material at a hit over a footprint (m, square on).
pub(super) fn surface(tracer: &Tracer, ray: &Ray, hit: &Hit, footprint_m: f64) -> Shade {
    dress(tracer, hit, &place(tracer, ray, hit, footprint_m))
}

/// Bidirectional reflectance times the cosine, per unit of irradiance on a surface that faces the light.
pub(super) fn scatter(shade: &Shade, geometric: DVec3, to_light: DVec3, view: DVec3) -> Bands {
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
        Brdf::Water { slope_variance } if front && cos > 0.0 => {
            let mirrored = fresnel((-view.dot(shade.normal)).clamp(0.0, 1.0) as f32, Brdf::WATER_INDEX);
            shade.albedo * (cos * INV_PI * (1.0 - mirrored))
                + Bands::grey(glint(slope_variance, shade.normal, to_light))
        }
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

/// Radiance of the sun in water's facets, per unit of irradiance on a surface that faces it (Cox and Munk 1954): facets whose
/// slopes against the mean surface are Gaussian. It is that of a look straight down: a satellite's direction hardly
/// changes over a frame, and both of a pair's views see the same glitter.
fn glint(slope_variance: f32, normal: DVec3, to_light: DVec3) -> f32 {
    let half = (to_light + DVec3::Z).normalize();
    let cos_tilt = half.dot(normal).max(0.05);
    let square = cos_tilt * cos_tilt;
    let slope2 = (1.0 - square).max(0.0) / square;
    let variance = f64::from(slope_variance);
    let density = libm::exp(-slope2 / variance) / (core::f64::consts::PI * variance);
    let mirrored = fresnel(half.dot(to_light).clamp(0.0, 1.0) as f32, Brdf::WATER_INDEX);
    mirrored * (density / (4.0 * normal.z.max(0.1) * square * square)) as f32
}

/// Unpolarised Fresnel reflectance of a dielectric.
pub(super) fn fresnel(cos: f32, index: f32) -> f32 {
    let sin2 = (1.0 - cos * cos) / (index * index);
    let cos_t = (1.0 - sin2).max(0.0).sqrt();
    let parallel = (index * cos - cos_t) / (index * cos + cos_t);
    let perpendicular = (cos - index * cos_t) / (cos + index * cos_t);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

#[cfg(test)]
mod tests {
    use super::super::sampling::{Sample, cosine_direction};
    use super::*;

    #[test]
    fn fresnel_at_normal_and_grazing_incidence() {
        assert!((fresnel(1.0, 1.52) - 0.0426).abs() < 1e-3);
        assert!((fresnel(0.0, 1.52) - 1.0).abs() < 1e-6);
    }

    /// All directions of the sun together give back to the zenith what still water mirrors, since facets turn light and take none;
    /// steep facets see the sky at a slant, which adds a little.
    #[test]
    fn glitter_under_light_from_everywhere_is_a_mirror() {
        for slope_variance in [0.005, 0.02, 0.05] {
            let count = 40_000;
            let sum: f64 = (0..count)
                .map(|i| {
                    let d = cosine_direction(DVec3::Z, Sample::new(0, 0, i, 0).square(0));
                    // Radiance 1 from everywhere, and directions by cosine: the irradiance that each stands for is pi over its cosine.
                    f64::from(glint(slope_variance, DVec3::Z, d)) * core::f64::consts::PI / d.z.max(1e-3)
                })
                .sum::<f64>()
                / f64::from(count);
            let still = f64::from(fresnel(1.0, Brdf::WATER_INDEX));
            assert!((sum / still - 1.0).abs() < 0.05, "{slope_variance}: {sum} against {still}");
        }
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
}
