//! The numbers that make a region that region, from the surface models of whole scenes at full size, as `satseed info`
//! gives them: over the circle of full detail.

#![allow(clippy::print_stderr)]

use satseed::dataset::SceneFigures;
use satseed::dataset::formats::HeightMap;
use satseed::labels::{SurfaceModels, surface_models};
use satseed_generators::Region;
use satseed_scene::Raster;

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
