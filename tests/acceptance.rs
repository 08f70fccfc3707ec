//! The numbers that make a region that region, from the surface models of whole scenes at full size, as `satseed info`
//! gives them: over the circle of full detail.

#![allow(clippy::print_stderr)]

use glam::{DVec2, DVec3};
use satseed::camera::{Datum, RigSpec, StereoRig};
use satseed::dataset::SceneFigures;
use satseed::dataset::formats::HeightMap;
use satseed::labels::{Extra, SurfaceModels, Validity, View, extract, surface_models};
use satseed::render::{Image, Light, Sensor, Settings, render};
use satseed_generators::Region;
use satseed_scene::{Environment, Raster, Ray, Scene, SeedPath};
use satseed_tracer::Tracer;

/// Surface models of a scene with cells of `cell_m`, and its figures.
fn figures(region: &Region, seed: u64, cell_m: f64) -> (SurfaceModels, SceneFigures) {
    let radius_m = region.full_detail_radius_m();
    let models = surface_models(&region.build(seed), radius_m, cell_m);
    let map = |raster: &Raster<f32>| HeightMap {
        west_m: raster.origin_m.x,
        south_m: raster.origin_m.y,
        cell_m: raster.cell_m,
        width: raster.width as u32,
        height: raster.height as u32,
        heights_m: raster.data.clone(),
    };
    let figures = SceneFigures::of(&map(&models.dsm_m), &map(&models.dtm_m), radius_m);
    eprintln!("{} {seed}: {figures:?}, several layers {:.4}", region.name(), several_layers(&models));
    let complete = |r: &Raster<f32>| r.data.iter().all(|z| z.is_finite());
    assert!(complete(&models.dsm_m) && complete(&models.dtm_m) && complete(&models.ndsm_m), "a hole in a map");
    (models, figures)
}

fn several_layers(models: &SurfaceModels) -> f64 {
    models.layers.data.iter().filter(|n| **n >= 2).count() as f64 / models.layers.data.len() as f64
}

#[test]
fn toronto() {
    for seed in [1, 5, 10_000] {
        let mut region = Region::by_name("toronto").expect("registered");
        let (_, with_trees) = figures(&region, seed, 2.0);
        // Without trees and vehicles, what stands above the ground is built.
        let Region::Toronto(p) = &mut region else { unreachable!("asked for by name") };
        (p.trees, p.vehicles) = (0.0, 0.0);
        let (models, f) = figures(&region, seed, 2.0);
        assert!((0.45..=0.60).contains(&f.raised_fraction), "seed {seed}: built {}", f.raised_fraction);
        assert!((0.05..=0.12).contains(&f.above_60_m_fraction), "seed {seed}: tall {}", f.above_60_m_fraction);
        let median_m = f.tower_height_median_m.expect("towers");
        assert!((110.0..=140.0).contains(&median_m), "seed {seed}: median {median_m} m");
        // 25 to 45 towers a frame of 614 m; the circle is four frames large.
        assert!((100..=180).contains(&f.towers), "seed {seed}: {} towers", f.towers);
        // Trees change nothing of this: no crown stands above 60 m.
        assert_eq!((with_trees.towers, with_trees.tower_height_median_m), (f.towers, f.tower_height_median_m));
        assert!(with_trees.raised_fraction > f.raised_fraction + 0.01);
        // Balconies, canopies and steps are there; solid buildings on their plots do not count.
        let several = several_layers(&models);
        assert!((0.002..0.08).contains(&several), "seed {seed}: several layers over {several}");
    }
}

/// Relief and slopes over the circle of full detail. Each canyon erodes sixteen square kilometres first.
#[test]
#[ignore = "over a minute a canyon without optimisation: run by ./check --long"]
fn canyon() {
    for seed in [1, 2, 3, 4, 5, 10_000] {
        let (models, f) = figures(&Region::by_name("canyon").expect("registered"), seed, 1.0);
        assert!((120.0..=220.0).contains(&f.relief_m), "seed {seed}: relief {} m", f.relief_m);
        let steep = f.steeper_than_60_deg_fraction;
        assert!((0.05..=0.15).contains(&steep), "seed {seed}: steeper than 60 degrees {steep}");
        assert_eq!(f.towers, 0, "seed {seed}");
        assert!(several_layers(&models) > 0.0, "seed {seed}: shrubs and blocks stand over the ground");
    }
}

/// What vertical rays find over a circle: the share that come upon nothing higher than half a metre, the share that meet
/// what is higher than 2 m first, and the median and 95 in 100 of those heights, m.
fn canopy(scene: &Scene, tracer: &Tracer<'_>, radius_m: f64, step_m: f64) -> (f64, f64, [f64; 2]) {
    let bare =
        Scene { instances: scene.instances.iter().filter(|i| i.object == 0).cloned().collect(), ..scene.clone() };
    let ground = Tracer::new(&bare);
    let n = (2.0 * radius_m / step_m) as u32;
    let (mut all, mut gaps, mut heights) = (0.0, 0.0, Vec::new());
    for k in 0..n * n {
        let at = DVec2::new(f64::from(k % n) + 0.5, f64::from(k / n) + 0.5) * step_m - radius_m;
        if at.length() > radius_m {
            continue;
        }
        let down = Ray { origin: at.extend(1000.0), direction: DVec3::NEG_Z };
        let z = |tracer: &Tracer<'_>| tracer.closest(&down, 2000.0).expect("ground everywhere").point.z;
        let height_m = z(tracer) - z(&ground);
        all += 1.0;
        gaps += f64::from(u8::from(height_m < 0.5));
        if height_m > 2.0 {
            heights.push(height_m);
        }
    }
    heights.sort_by(f64::total_cmp);
    let at = |q: f64| heights[(q * heights.len() as f64) as usize];
    (gaps / all, heights.len() as f64 / all, [at(0.5), at(0.95)])
}

/// Share of pixels of a frame's middle that the other view, 200 m apart, cannot see.
fn occluded(scene: &Scene, tracer: &Tracer<'_>, size_px: u32) -> f64 {
    let rig = StereoRig::new(RigSpec {
        altitude_m: 1000.0,
        gsd_m: 0.3,
        size_px: [size_px; 2],
        baseline_m: 200.0,
        azimuth_rad: 0.6,
        pivot_along_baseline: 0.5,
        pivot_m: DVec3::new(0.0, 0.0, scene.pivot_height_m),
        datum: Datum::Height(scene.pivot_height_m),
    });
    let environment = Environment { sun_elevation_rad: 0.73, sun_azimuth_rad: 2.53, aerosol_optical_depth: 0.12 };
    let labels = extract(tracer, &rig, View::Left, &environment, Extra::default());
    let hidden: u32 = labels.validity.iter().map(|v| u32::from(*v == Validity::Occluded as u8)).sum();
    f64::from(hidden) / labels.validity.len() as f64
}

struct ForestNumbers {
    gaps: f64,
    cover: f64,
    heights_m: [f64; 2],
    several: f64,
    hidden: f64,
}

fn forest_numbers(region: &Region, seed: u64, radius_m: f64, size_px: u32) -> ForestNumbers {
    let scene = region.build(seed);
    let tracer = Tracer::new(&scene);
    let (gaps, cover, heights_m) = canopy(&scene, &tracer, radius_m, 1.0);
    let several = several_layers(&surface_models(&scene, radius_m * core::f64::consts::FRAC_1_SQRT_2, 0.5));
    let hidden = occluded(&scene, &tracer, size_px);
    let [median, high] = heights_m;
    eprintln!(
        "forest {seed}: gaps {gaps:.3}, cover {cover:.3}, heights {median:.1} and {high:.1} m, several layers \
         {several:.3}, occluded {hidden:.3}"
    );
    ForestNumbers { gaps, cover, heights_m, several, hidden }
}

/// A small forest: whoever looks down sees crowns, gaps, and ground under crowns.
#[test]
fn a_small_forest() {
    let mut region = Region::by_name("forest").expect("registered");
    let Region::Forest(p) = &mut region else { unreachable!("asked for by name") };
    p.radius_m = 90.0;
    let ForestNumbers { gaps, cover, heights_m, several, hidden } = forest_numbers(&region, 1, 90.0, 256);
    assert!((0.03..=0.25).contains(&gaps) && (0.72..=0.97).contains(&cover), "gaps {gaps}, cover {cover}");
    assert!((16.0..=26.0).contains(&heights_m[0]) && (22.0..=34.0).contains(&heights_m[1]), "{heights_m:?}");
    assert!(several > 0.6, "several layers {several}");
    assert!((0.08..=0.4).contains(&hidden), "occluded {hidden}");
}

/// The numbers of whole forests over the circle that frames see.
#[test]
#[ignore = "minutes without optimisation: run by ./check --long"]
fn forest() {
    let mut faults = Vec::new();
    for seed in [1, 2, 3, 4, 5] {
        let region = Region::by_name("forest").expect("registered");
        let ForestNumbers { gaps, cover, heights_m, several, hidden } = forest_numbers(&region, seed, 434.0, 1024);
        let fine = (0.05..=0.20).contains(&gaps)
            && (0.75..=0.95).contains(&cover)
            && (16.0..=26.0).contains(&heights_m[0])
            && (24.0..=34.0).contains(&heights_m[1])
            && several > 0.6
            && (0.10..=0.35).contains(&hidden);
        if !fine {
            faults.push(format!("seed {seed}: {gaps} {cover} {heights_m:?} {several} {hidden}"));
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

/// Slopes of the map's cells in whole degrees, counted.
fn slope_histogram(map: &Raster<f32>) -> [usize; 91] {
    let mut bins = [0; 91];
    for j in 1..map.height - 1 {
        for i in 1..map.width - 1 {
            let d = |a: f32, b: f32| f64::from(b - a) / (2.0 * map.cell_m);
            let (x, y) = (d(map.get(i - 1, j), map.get(i + 1, j)), d(map.get(i, j - 1), map.get(i, j + 1)));
            bins[libm::atan((x * x + y * y).sqrt()).to_degrees() as usize] += 1;
        }
    }
    bins
}

/// Bits of the green band's histogram.
fn entropy(image: &Image) -> f64 {
    let mut counts = [0_u32; 256];
    image.bytes().chunks_exact(3).for_each(|p| counts[usize::from(p[1])] += 1);
    let n = f64::from(image.width * image.height);
    counts.iter().filter(|c| **c > 0).map(|c| f64::from(*c) / n).map(|p| -p * libm::log2(p)).sum()
}

/// Share of the 9 x 9 windows of the green band whose deviation is at least 1.5 times that of the sensor's noise there,
/// which two images of the same place with other noise tell.
fn matchable(a: &Image, b: &Image) -> f64 {
    let (width, side) = (a.width as usize, 9);
    let green = |image: &Image, i: usize, j: usize| f64::from(image.bytes()[3 * (j * width + i) + 1]);
    let (mut good, mut all) = (0, 0);
    for j in (0..a.height as usize - side).step_by(4) {
        for i in (0..width - side).step_by(4) {
            let cells = || (0..side * side).map(|k| (i + k % side, j + k / side));
            let n = (side * side) as f64;
            let mean = cells().map(|(x, y)| green(a, x, y)).sum::<f64>() / n;
            let square = |v: f64| v * v;
            let variance = cells().map(|(x, y)| square(green(a, x, y) - mean)).sum::<f64>() / n;
            let noise = cells().map(|(x, y)| square(green(a, x, y) - green(b, x, y))).sum::<f64>() / (2.0 * n);
            all += 1;
            good += u32::from(variance >= 1.5 * 1.5 * noise);
        }
    }
    f64::from(good) / f64::from(all)
}

/// Form over the circle of full detail; light, occlusion and texture of a frame's middle.
#[test]
#[ignore = "over a minute a desert without optimisation: run by ./check --long"]
fn desert() {
    use satseed_generators::desert::Variant::{Barchan, Linear, Transverse};
    // All seeds are told before any fault is.
    let mut faults = Vec::new();
    let mut expect = |good: bool, fault: String| {
        if !good {
            faults.push(fault);
        }
    };
    for (seed, variant) in [1, 2, 3, 4, 5].into_iter().zip([Barchan, Transverse, Linear, Barchan, Transverse]) {
        let mut region = Region::by_name("desert").expect("registered");
        let Region::Desert(p) = &mut region else { unreachable!("asked for by name") };
        p.variant = variant;
        let (models, f) = figures(&region, seed, 0.5);
        expect((9.0..=28.0).contains(&f.relief_m), format!("seed {seed}: relief {} m", f.relief_m));
        let bins = slope_histogram(&models.dtm_m);
        let peak = (20..91).max_by_key(|k| bins[*k]).expect("bins");
        let steep = bins[35..].iter().sum::<usize>() as f64 / bins.iter().sum::<usize>() as f64;
        expect((32..34).contains(&peak), format!("seed {seed}: slip faces at {peak} degrees"));
        expect(steep < 2e-3, format!("seed {seed}: {steep} steeper than 35 degrees"));

        let scene = region.build(seed);
        let tracer = Tracer::new(&scene);
        let rig = StereoRig::new(RigSpec {
            altitude_m: 1000.0,
            gsd_m: 0.3,
            size_px: [512, 512],
            baseline_m: 200.0,
            azimuth_rad: 0.6,
            pivot_along_baseline: 0.5,
            pivot_m: DVec3::new(0.0, 0.0, scene.pivot_height_m),
            datum: Datum::Height(scene.pivot_height_m),
        });
        let environment = Environment {
            sun_elevation_rad: 42.0_f64.to_radians(),
            sun_azimuth_rad: 145.0_f64.to_radians(),
            aerosol_optical_depth: 0.12,
        };
        let labels = extract(&tracer, &rig, View::Left, &environment, Extra::default());
        let hidden: u32 = labels.validity.iter().map(|v| u32::from(*v == Validity::Occluded as u8)).sum();
        let occluded = f64::from(hidden) / labels.validity.len() as f64;
        let settings = Settings { samples_per_pixel: 4, sensor: Sensor::WORLDVIEW3_RGB };
        let light = Light::of(&tracer, &environment);
        let picture =
            |name: &str| render(&tracer, View::Left.cameras(&rig).0, &light, settings, &SeedPath::root(name, seed));
        let (a, b) = (picture("acceptance"), picture("acceptance, again"));
        let (bits, textured) = (entropy(&a), matchable(&a, &b));
        eprintln!(
            "desert/{variant:?} {seed}: slip faces {peak} deg, over 35 deg {steep:.5}, occluded {occluded:.5}, \
             entropy {bits:.2}, textured {textured:.3}"
        );
        expect(occluded < 0.01, format!("seed {seed}: occluded {occluded}"));
        expect((4.8..=6.3).contains(&bits), format!("seed {seed}: entropy {bits}"));
        expect(textured >= 0.6, format!("seed {seed}: textured {textured}"));
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

/// Hedges, crops and occlusion over a whole frame of each kind of farmland.
#[test]
#[ignore = "over a minute a field without optimisation: run by ./check --long"]
fn field() {
    use satseed_generators::field::Variant::{European, Pivot};
    let mut faults = Vec::new();
    let mut expect = |good: bool, fault: String| {
        if !good {
            faults.push(fault);
        }
    };
    for (seed, variant) in [1, 2, 3, 4, 5].into_iter().zip([European, Pivot, European, Pivot, European]) {
        let mut region = Region::by_name("field").expect("registered");
        let Region::Field(p) = &mut region else { unreachable!("asked for by name") };
        p.variant = variant;
        // A frame's corner and what the baseline shows beyond it.
        p.radius_m = 560.0;
        let scene = region.build(seed);
        let tracer = Tracer::new(&scene);
        let rig = StereoRig::new(RigSpec {
            altitude_m: 1000.0,
            gsd_m: 0.6,
            size_px: [1024, 1024],
            baseline_m: 200.0,
            azimuth_rad: 0.6,
            pivot_along_baseline: 0.5,
            pivot_m: DVec3::new(0.0, 0.0, scene.pivot_height_m),
            datum: Datum::Height(scene.pivot_height_m),
        });
        let environment = Environment {
            sun_elevation_rad: 42.0_f64.to_radians(),
            sun_azimuth_rad: 145.0_f64.to_radians(),
            aerosol_optical_depth: 0.12,
        };
        let extra = Extra { instance: true, elevation: true, ..Extra::default() };
        let labels = extract(&tracer, &rig, View::Left, &environment, extra);
        let hidden = labels.validity.iter().map(|v| usize::from(*v == Validity::Occluded as u8)).sum::<usize>();
        let all = labels.validity.len() as f64;
        let occluded = hidden as f64 / all;
        let instances = labels.instance.as_ref().expect("asked for");
        let share = |wanted: &dyn Fn(&str) -> bool| {
            let seen = |i: &&u32| scene.objects.get(**i as usize).is_some_and(|o| wanted(&o.path));
            instances.iter().filter(seen).count() as f64 / all
        };
        let woody = share(&|path| path.starts_with("hedge/") || path.contains("tree/"));
        let crops = share(&|path| path.starts_with("parcel/") && !path.contains("tree/"));
        let heights = labels.elevation_m.as_ref().expect("asked for");
        let (low, high) = heights.iter().fold((f32::MAX, f32::MIN), |(l, h), z| (l.min(*z), h.max(*z)));
        eprintln!(
            "field/{variant:?} {seed}: hedges and trees {woody:.4}, standing crops {crops:.3}, occluded {occluded:.4}, \
             heights {low:.1} to {high:.1} m"
        );
        let least = if variant == European { 0.03 } else { 0.0 };
        expect((least..=0.10).contains(&woody), format!("seed {seed}: hedges and trees {woody}"));
        expect(crops > 0.1, format!("seed {seed}: standing crops {crops}"));
        expect(occluded < 0.03, format!("seed {seed}: occluded {occluded}"));
    }
    assert!(faults.is_empty(), "{faults:#?}");
}
