use super::*;
use crate::Region;
use crate::kit::checks::{assert_between, assert_closed, assert_rises, assert_rooted};
use crate::kit::woods;
use satseed_scene::{Material, Raster, SurfacePoint};
use std::collections::BTreeMap;
use std::sync::OnceLock;

const VARIANTS: [Variant; 3] = [Variant::Mixed, Variant::Conifer, Variant::Logged];

fn params(radius_m: f64, variant: Variant) -> Params {
    Params { variant, radius_m, ..Params::default() }
}

fn root(seed: u64) -> SeedPath {
    SeedPath::root("forest", seed)
}

/// A small scene that several tests look at.
fn small() -> &'static Scene {
    static SCENE: OnceLock<Scene> = OnceLock::new();
    SCENE.get_or_init(|| build(&params(60.0, Variant::Mixed), root(1)))
}

/// What a look straight down finds, over a square of half side `half_m` with posts half a metre apart.
struct Looks {
    /// Share of posts over which something stands higher than 2 m.
    cover: f64,
    /// Share of posts on which nothing stands at all.
    bare: f64,
    /// Median and 95 in 100 of the canopy's height where it is higher than 2 m, m.
    heights_m: [f64; 2],
}

fn look_down(scene: &Scene, half_m: f64) -> Looks {
    let cell_m = 0.5;
    let n = (2.0 * half_m / cell_m) as usize;
    let map = || Raster::filled(DVec2::splat(0.5 * cell_m - half_m), cell_m, n, n, f64::NEG_INFINITY);
    let [mut ground, mut top] = [map(), map()];
    for (k, i) in scene.instances.iter().enumerate() {
        if i.object != 0 && i.world_from_object.translation.truncate().abs().max_element() > half_m + 12.0 {
            continue;
        }
        let onto = if i.object == 0 { &mut ground } else { &mut top };
        for t in 0..scene.meshes[i.mesh as usize].triangles.len() {
            let c = scene.corners(k as u32, t as u32);
            let [a, b, d] = c.map(DVec3::truncate);
            let area = (b - a).perp_dot(d - a);
            if area == 0.0 {
                continue;
            }
            let low = onto.grid_from_world(a.min(b).min(d)).ceil().max(DVec2::ZERO);
            let high = onto.grid_from_world(a.max(b).max(d)).floor().min(DVec2::splat(n as f64 - 1.0));
            if low.x > high.x || low.y > high.y {
                continue;
            }
            for y in low.y as usize..=high.y as usize {
                for x in low.x as usize..=high.x as usize {
                    let p = onto.position(x, y);
                    let w =
                        [(d - b).perp_dot(p - b), (a - d).perp_dot(p - d), (b - a).perp_dot(p - a)].map(|w| w / area);
                    if w.iter().all(|w| *w >= 0.0) {
                        let z = c[0].z * w[0] + c[1].z * w[1] + c[2].z * w[2];
                        onto.set(x, y, z.max(onto.get(x, y)));
                    }
                }
            }
        }
    }
    let above: Vec<f64> = top.data.iter().zip(&ground.data).map(|(t, g)| t - g).collect();
    let mut high: Vec<f64> = above.iter().copied().filter(|h| *h > 2.0).collect();
    high.sort_by(f64::total_cmp);
    let share = |count: usize| count as f64 / above.len() as f64;
    Looks {
        cover: share(high.len()),
        bare: share(above.iter().filter(|h| **h < 0.15).count()),
        heights_m: [0.5, 0.95].map(|q| high[(q * high.len() as f64) as usize]),
    }
}

fn grown(seed: u64, params: &Params, half_m: f64) -> (Land, Stands, Growth) {
    let path = root(seed).child(params.variant());
    let land = Land::new(params.relief_m, params.roughness, 64.0, &path.child("land"));
    let stands = Stands::new(&land, params, &path.child("stands"));
    let growth = Growth::new(&land, &stands, params, half_m, &path.child("trees"));
    (land, stands, growth)
}

/// The numbers of five seeds of each variant; run with `--ignored --nocapture`.
#[test]
#[ignore = "long: fifteen forests"]
#[allow(clippy::print_stderr, reason = "the numbers are what it is for")]
fn numbers() {
    for seed in 1..=4 {
        for variant in VARIANTS {
            let p = params(130.0, variant);
            let (_, _, growth) = grown(seed, &p, REACH_M);
            let mut heights: Vec<f64> =
                growth.trees.iter().filter(|t| t.at_m.length() < 700.0).map(|t| t.height_m).collect();
            heights.sort_by(f64::total_cmp);
            let at = |q: f64| heights[(q * heights.len() as f64) as usize];
            let sick = growth.trees.iter().filter(|t| t.health != growth::Health::Green).count() as f64
                / growth.trees.len() as f64;
            let scene = build(&p, root(seed));
            let Looks { cover, bare, heights_m } = look_down(&scene, 120.0);
            eprintln!(
                "{variant:?} {seed}: {} trees within 700 m ({:.0}/ha), heights {:.1} {:.1} {:.1}, sick {sick:.3}; within 120 m cover {cover:.3} bare {bare:.3} canopy {:.1} {:.1}; {} instances, {:?} triangles",
                heights.len(),
                heights.len() as f64 / 153.9,
                at(0.05),
                at(0.5),
                at(0.95),
                heights_m[0],
                heights_m[1],
                scene.instances.len(),
                scene.triangle_counts(),
            );
        }
    }
}

#[test]
fn the_terrain_of_all_tiles_is_one_closed_surface() {
    assert_closed(small(), tiling(60.0).scene_half_m());
}

#[test]
fn the_number_of_threads_does_not_show() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(pool.install(|| build(&params(60.0, Variant::Mixed), root(1)).hash()), small().hash());
}

#[test]
fn what_stands_on_the_ground_reaches_below_it() {
    let (land, ..) = grown(1, &params(60.0, Variant::Mixed), 60.0);
    assert_rooted(small(), 0.02, |p| land.height_m(p));
}

/// A scene of a seed with the extremes of all parameters in turn.
fn any(seed: u64) -> Params {
    let pick = |values: [f64; 3], turn: u64| values[((seed / turn) % 3) as usize];
    Params {
        variant: VARIANTS[(seed % 3) as usize],
        radius_m: 60.0,
        relief_m: pick([70.0, 150.0, 20.0], 3),
        roughness: pick([1.0, 2.0, 0.0], 2),
        texture_contrast: pick([1.0, 0.0, 2.0], 4),
        density: pick([1.0, 1.5, 0.5], 5),
        conifers: pick([1.0, 3.0, 0.0], 1),
    }
}

fn seeds_build(seeds: core::ops::Range<u64>) {
    for k in seeds {
        let params = any(k);
        // Some small, some large.
        let seed = k.wrapping_mul(if k % 2 == 0 { 1 } else { 0x9e37_79b9_7f4a_7c15 });
        let scene = build(&params, root(seed));
        scene.validate().unwrap();
        assert_between(&scene, params.height_bounds_m(), &format!("{k}: {params:?}"));
        let trees = scene.objects.iter().filter(|o| o.class == Class::Tree).count();
        assert!(trees > 200, "{k}: {trees} trees");
    }
}

#[test]
fn any_seed_builds_within_the_stated_bounds() {
    seeds_build(0..5);
}

#[test]
#[ignore = "long: 200 scenes"]
fn two_hundred_seeds_build_within_the_stated_bounds() {
    seeds_build(1000..1200);
}

/// What two radii have in common is the same, to the last bit.
#[test]
fn a_crop_is_a_part_of_the_whole() {
    let [crop, whole] = [60.0, 150.0].map(|radius_m| build(&params(radius_m, Variant::Logged), root(5)));
    assert_eq!(crop.pivot_height_m.to_bits(), whole.pivot_height_m.to_bits());
    assert_eq!(format!("{:?}", crop.materials), format!("{:?}", whole.materials));
    let tiles = |scene: &Scene| scene.instances.iter().filter(|i| i.object == 0).count();
    let corner = |mesh: &Mesh| {
        mesh.positions_m.iter().fold([f32::MAX; 2], |low, p| [low[0].min(p[0]), low[1].min(p[1])]).map(f32::to_bits)
    };
    let tile = |scene: &Scene, at: [u32; 2]| scene.meshes[..tiles(scene)].iter().find(|m| corner(m) == at).cloned();
    for x in [-128.0_f32, 0.0] {
        for y in [-128.0_f32, 0.0] {
            let at = [x, y].map(f32::to_bits);
            let [a, b] = [&crop, &whole].map(|s| tile(s, at).expect("a tile of the full detail"));
            assert!(a.triangles.len() > 1000 && a == b, "the tile at {x}, {y}");
        }
    }
    assert!(crop.meshes[tiles(&crop)..] == whole.meshes[tiles(&whole)..], "other trees");
    // Things of the crop: by path, with their placement and mesh.
    let things = |scene: &Scene| -> BTreeMap<String, String> {
        let things = scene.instances.iter().filter(|i| i.object != 0);
        let near = things.filter(|i| i.world_from_object.translation.truncate().length() < 95.0);
        near.map(|i| {
            let mesh = i.mesh as usize - tiles(scene);
            let path = scene.objects[i.object as usize].path.clone();
            (path, format!("{:?} {:?} {mesh} {}", i.world_from_object, i.variation, i.material_set))
        })
        .collect()
    };
    let (few, many) = (things(&crop), things(&whole));
    assert!(few.len() > 500, "{} things", few.len());
    assert!(few == many, "what stands on the crop differs");
    for k in 0..128 * 128 {
        let p = DVec2::new(f64::from(k % 128) - 64.0, f64::from(k / 128) - 64.0) * 1.9;
        for footprint_m in [1.0, 4.0] {
            let [a, b] = [&crop, &whole].map(|s| s.rasters[0].sample(p, footprint_m));
            assert_eq!(a, b, "cover at {p}");
        }
    }
}

#[test]
fn hills_are_as_high_as_stated() {
    let spans = [20.0, 70.0, 150.0].map(|relief_m| {
        let land = Land::new(relief_m, 1.0, 4.0, &root(3));
        let mut heights: Vec<f64> = (0..176 * 176)
            .map(|k| DVec2::new(f64::from(k % 176) - 87.5, f64::from(k / 176) - 87.5) * 8.0)
            .filter(|p| p.length() < 690.0)
            .map(|p| land.hills_m(p))
            .collect();
        heights.sort_by(f64::total_cmp);
        let span = heights[heights.len() - 1] - heights[0];
        assert!((0.85..1.02).contains(&(span / relief_m)), "{span} m of {relief_m}");
        span
    });
    assert_rises("relief", &spans);
}

#[test]
fn roughness_roughens() {
    let bends = [0.0, 1.0, 2.0].map(|roughness| {
        let land = Land::new(70.0, roughness, 64.0, &root(3));
        let z = land.window();
        let bend = |i: usize, j: usize| f64::from(z.get(i - 1, j) - 2.0 * z.get(i, j) + z.get(i + 1, j)).abs();
        (1..z.height - 1).flat_map(|j| (1..z.width - 1).map(move |i| (i, j))).map(|(i, j)| bend(i, j)).sum::<f64>()
    });
    assert_rises("bends of the ground", &bends);
}

#[test]
fn density_adds_trees_and_conifers_their_share() {
    let of = |change: fn(&mut Params, f64), value: f64| {
        let mut p = params(60.0, Variant::Mixed);
        change(&mut p, value);
        grown(2, &p, 300.0).2.trees
    };
    assert_rises("trees", &[0.5, 1.0, 1.5].map(|v| of(|p, v| p.density = v, v).len() as f64));
    let conifers = [0.0, 1.0, 3.0].map(|v| {
        let trees = of(|p, v| p.conifers = v, v);
        trees.iter().filter(|t| t.species.is_conifer()).count() as f64 / trees.len() as f64
    });
    assert!(conifers[0] < 1e-9 && conifers[2] > 0.4, "{conifers:?}");
    assert_rises("share of conifers", &conifers);
}

/// A small scene draws fewer candidates; what it has of the forest is what the largest scene has there.
#[test]
fn trees_are_the_same_however_many_are_grown() {
    for (variant, sides_m) in [(Variant::Mixed, [40.0, 150.0]), (Variant::Logged, [60.0, 400.0])] {
        let p = Params { density: 1.5, ..params(60.0, variant) };
        let [few, many] = sides_m.map(|half_m| {
            let (_, _, growth) = grown(4, &p, half_m);
            let trees = growth.trees.iter().filter(|t| t.at_m.abs().max_element() < sides_m[0] + 8.0);
            let light = (0..400).map(|k| DVec2::new(f64::from(k % 20) - 9.5, f64::from(k / 20) - 9.5) * 4.1);
            (trees.map(|t| (t.key, t.health)).collect::<Vec<_>>(), light.map(|p| growth.light(p)).collect::<Vec<_>>())
        });
        assert!(few.0.len() > 60, "{} trees", few.0.len());
        assert_eq!(few, many);
    }
}

#[test]
fn no_two_trees_share_a_place_and_ways_are_free() {
    let (land, stands, growth) = grown(3, &params(60.0, Variant::Mixed), REACH_M);
    let near: Vec<_> = growth.trees.iter().filter(|t| t.at_m.length() < 150.0).collect();
    assert!(near.len() > 1000, "{} trees", near.len());
    for (k, a) in near.iter().enumerate() {
        assert!(land.track.beyond_m(a.at_m) > 1.9 && land.streams.beyond_m(a.at_m) > 0.4, "{:?}", a.key);
        let apart = stands.at(a.at_m).apart;
        for b in &near[..k] {
            // The one that came later kept its distance.
            let least = 0.5 * apart.min(stands.at(b.at_m).apart) * 0.84 * (a.crown_m + b.crown_m);
            assert!(a.at_m.distance(b.at_m) > least, "{:?} and {:?}", a.key, b.key);
        }
    }
    let species = woods::Species::ALL.map(|s| growth.trees.iter().filter(|t| t.species == s).count());
    assert!(species.iter().all(|n| n * 100 > growth.trees.len()), "shares of species {species:?}");
    let sick = growth.trees.iter().filter(|t| t.health != growth::Health::Green).count() as f64;
    let sick = sick / growth.trees.len() as f64;
    assert!((0.05..=0.15).contains(&sick), "dead or brown {sick}");
}

#[test]
fn crowns_close_over_the_ground_but_not_everywhere() {
    let Looks { cover, bare, heights_m } = look_down(&build(&params(110.0, Variant::Mixed), root(1)), 110.0);
    assert!((0.70..=0.95).contains(&cover), "cover {cover}");
    assert!((0.04..=0.28).contains(&bare), "bare {bare}");
    assert!((16.0..=26.0).contains(&heights_m[0]) && (23.0..=34.0).contains(&heights_m[1]), "{heights_m:?}");
}

/// Deviation of the reflectance over trees and ground, relative to its mean.
fn contrast_of(contrast: f64) -> f64 {
    let params = Params { texture_contrast: contrast, ..params(60.0, Variant::Mixed) };
    let scene = build(&params, root(3));
    let (mut sum, mut square, mut n) = (0.0, 0.0, 0.0);
    let mut look = |material: &Material, p: DVec3, variation: [f32; 4]| {
        let point =
            SurfacePoint { world_m: p, object_m: p, uv_m: DVec2::ZERO, normal: DVec3::Z, footprint_m: 0.3, variation };
        let v = f64::from(material.shade(&point, &scene.rasters).albedo.0[1]);
        (sum, square, n) = (sum + v, square + v * v, n + 1.0);
    };
    let oak = scene.materials.iter().find(|m| m.name == "oak leaves").expect("oaks");
    for k in 0..4000 {
        let p = DVec2::new(f64::from(k % 100) - 50.0, f64::from(k / 100) - 20.0) * 1.37;
        let own = [0.3, -0.7, 0.9, -0.2].map(|v: f32| v * ((k % 17) as f32 / 8.0 - 1.0));
        look(oak, p.extend(3.0), own);
        look(&scene.materials[0], p.extend(0.0), own);
    }
    let mean = sum / n;
    (square / n - mean * mean).max(0.0).sqrt() / mean
}

#[test]
fn texture_contrast_tells() {
    assert_rises("deviation of the colour", &[0.0, 1.0, 2.0].map(contrast_of));
}

#[test]
fn parameters_out_of_range_are_refused_with_their_range() {
    type Case = (fn(&mut Params), &'static str);
    let cases: [Case; 7] = [
        (|p| p.radius_m = 59.0, "`radius_m` is 59, but must lie in 60 to 900"),
        (|p| p.relief_m = 151.0, "`relief_m` is 151, but must lie in 20 to 150"),
        (|p| p.relief_m = f64::NAN, "`relief_m` is NaN, but must lie in 20 to 150"),
        (|p| p.roughness = -0.1, "`roughness` is -0.1, but must lie in 0 to 2"),
        (|p| p.texture_contrast = 2.5, "`texture_contrast` is 2.5, but must lie in 0 to 2"),
        (|p| p.density = 0.4, "`density` is 0.4, but must lie in 0.5 to 1.5"),
        (|p| p.conifers = 3.5, "`conifers` is 3.5, but must lie in 0 to 3"),
    ];
    for (change, expected) in cases {
        let mut p = Params::default();
        change(&mut p);
        assert_eq!(Region::Forest(p).check().unwrap_err().to_string(), expected);
    }
    assert_eq!(Region::by_name("forest").unwrap().check(), Ok(()));
}
