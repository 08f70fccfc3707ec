//! A picture of a scene: `preview REGION SEED RADIUS_M nadir|oblique|oblique2 SIZE_PX SPP CENTRE_X,CENTRE_Y OUT.png`.
//! nadir at size S covers S * 0.3 m. A stand-in until the command line has its own.
#![allow(clippy::unwrap_used, clippy::print_stderr)]
use glam::{DMat3, DVec3};
use satseed::camera::Camera;
use satseed::render::{Sensor, Settings, render};
use satseed_generators::Region;
use satseed_scene::{Environment, Ray, SeedPath};
use satseed_tracer::Tracer;
use std::time::Instant;

fn main() {
    let a: Vec<String> = std::env::args().skip(1).collect();
    let mut region = Region::by_name(&a[0]).unwrap();
    let radius: f64 = a[2].parse().unwrap();
    match &mut region {
        Region::Canyon(p) => p.radius_m = radius,
        Region::Toronto(p) => p.radius_m = radius,
    }
    let size: u32 = a[4].parse().unwrap();
    let (cx, cy) = a[6].split_once(',').unwrap();
    let (cx, cy): (f64, f64) = (cx.parse().unwrap(), cy.parse().unwrap());
    let t = Instant::now();
    let scene = region.build(a[1].parse().unwrap());
    scene.validate().unwrap();
    eprintln!(
        "built in {:?}: {:?} triangles, {} instances",
        t.elapsed(),
        scene.triangle_counts(),
        scene.instances.len()
    );
    let t = Instant::now();
    let tracer = Tracer::new(&scene);
    eprintln!("trees in {:?}, {} MB", t.elapsed(), tracer.bytes() >> 20);
    let ground = tracer
        .closest(&Ray { origin: DVec3::new(cx, cy, 900.0), direction: DVec3::NEG_Z }, 3000.0)
        .map_or(scene.pivot_height_m, |h| h.point.z);
    let look = DVec3::new(cx, cy, ground);
    let camera = match a[3].as_str() {
        "nadir" => Camera {
            width_px: size,
            height_px: size,
            fx_px: 1000.0 / 0.3,
            fy_px: 1000.0 / 0.3,
            cx_px: (f64::from(size) - 1.0) / 2.0,
            cy_px: (f64::from(size) - 1.0) / 2.0,
            position_m: DVec3::new(cx, cy, 1000.0),
            world_from_camera: DMat3::from_cols(DVec3::X, DVec3::NEG_Y, DVec3::NEG_Z),
        },
        "oblique" => Camera::looking_at(
            look + DVec3::new(-0.9, -1.2, 1.0) * radius * 0.5,
            look,
            [size, size * 3 / 4],
            f64::from(size) * 0.9,
        ),
        _ => {
            Camera::looking_at(look + DVec3::new(40.0, -55.0, 45.0), look, [size, size * 3 / 4], f64::from(size) * 0.8)
        }
    };
    let environment = Environment {
        sun_elevation_rad: 42.0_f64.to_radians(),
        sun_azimuth_rad: 145.0_f64.to_radians(),
        aerosol_optical_depth: 0.12,
    };
    let settings = Settings { samples_per_pixel: a[5].parse().unwrap(), sensor: Sensor::WorldView3Rgb };
    let t = Instant::now();
    let image = render(&tracer, &camera, &environment, settings, &SeedPath::root("noise", 1));
    eprintln!("rendered in {:?}", t.elapsed());
    let file = std::fs::File::create(&a[7]).unwrap();
    let mut encoder = png::Encoder::new(file, image.width, image.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header().unwrap().write_image_data(&image.rgb).unwrap();
}
