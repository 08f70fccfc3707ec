use super::*;
use crate::kit::checks::{assert_between, assert_closed, assert_rooted, terrain};
use crate::kit::terrain::flow::NEIGHBOURS;
use std::sync::OnceLock;

fn params(radius_m: f64) -> Params {
    Params { radius_m, ..Params::default() }
}

fn root(seed: u64) -> SeedPath {
    SeedPath::root("canyon", seed)
}

/// A small scene that several tests look at.
fn small() -> &'static Scene {
    static SCENE: OnceLock<Scene> = OnceLock::new();
    SCENE.get_or_init(|| build(&params(60.0), root(1)))
}

/// The full-detail ground of a seed, without its triangles.
fn with_relief<T>(seed: u64, radius_m: f64, f: impl FnOnce(&Relief<'_>) -> T) -> T {
    let params = params(radius_m);
    let landscape = Landscape::new(&params, &root(seed));
    let tiling = tiling(radius_m);
    f(&landscape.relief(extent(radius_m, &tiling), 1.0, &root(seed)))
}

#[test]
fn the_terrain_of_all_tiles_is_one_closed_surface() {
    assert_closed(small(), tiling(60.0).scene_half_m());
}

#[test]
fn the_number_of_threads_does_not_show() {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| build(&params(60.0), root(1)).hash())
    };
    assert_eq!(with(1), with(2));
    assert_eq!(with(1), small().hash());
}

#[test]
fn any_seed_keeps_the_stated_bounds() {
    for seed in 0..4 {
        let params = Params {
            relief_m: [120.0, 170.0, 220.0][seed as usize % 3],
            roughness: [1.0, 2.0][seed as usize % 2],
            ..params(60.0)
        };
        let scene = build(&params, root(seed));
        assert_between(&scene, params.height_bounds_m(), &format!("seed {seed}"));
        assert!(scene.instances.iter().any(|i| i.object != 0), "seed {seed}: nothing lies or grows");
    }
}

#[test]
fn what_stands_on_the_ground_reaches_below_it() {
    with_relief(1, 60.0, |relief| {
        assert_rooted(small(), 0.06, |p| relief.height_m(p));
    });
}

#[test]
fn every_post_of_the_ground_drains() {
    with_relief(4, 100.0, |relief| {
        let z = &relief.window;
        for j in 1..z.height - 1 {
            for i in 1..z.width - 1 {
                let lower = NEIGHBOURS.iter().any(|(di, dj)| z.get_clamped(i as i64 + di, j as i64 + dj) < z.get(i, j));
                assert!(lower, "a pit at {}", z.position(i, j));
            }
        }
    });
}

/// Relief, m, and share of the area steeper than 60 degrees within a radius.
fn form(relief: &Relief<'_>, radius_m: f64) -> (f64, f64) {
    let z = &relief.window;
    let (mut low, mut high, mut all, mut steep) = (f32::MAX, f32::MIN, 0_u32, 0_u32);
    for j in 0..z.height {
        for i in 0..z.width {
            let p = z.position(i, j);
            if p.length() < radius_m {
                (low, high) = (low.min(z.get(i, j)), high.max(z.get(i, j)));
                all += 1;
                steep += u32::from(relief.slope(p).length() > 1.732);
            }
        }
    }
    (f64::from(high - low), f64::from(steep) / f64::from(all))
}

#[test]
fn walls_are_as_high_and_as_steep_as_a_canyons() {
    for seed in [1, 2] {
        let (height, steep) = with_relief(seed, 280.0, |relief| form(relief, 280.0));
        assert!((120.0..=220.0).contains(&height), "seed {seed}: relief {height}");
        assert!((0.05..=0.15).contains(&steep), "seed {seed}: {steep} steeper than 60 degrees");
    }
}

/// The acceptance numbers of five seeds at full size; run with `--ignored --nocapture` and `--release`.
#[test]
#[ignore = "minutes: full size"]
fn five_seeds_at_full_size() {
    for seed in 1..=5 {
        let (height, steep) = with_relief(seed, 434.0, |relief| form(relief, 434.0));
        let (small_height, small_steep) = with_relief(seed, 150.0, |relief| form(relief, 150.0));
        let report = format!(
            "seed {seed}: relief {height:.1} m, steeper than 60 deg {steep:.3}; within 150 m {small_height:.1} m, {small_steep:.3}"
        );
        assert!((120.0..=220.0).contains(&height) && (0.05..=0.15).contains(&steep), "{report}");
    }
}

/// Ground and slabs that face down lie over ground.
#[test]
fn walls_overhang() {
    let plan_m2 = |t: [DVec3; 3]| (t[1] - t[0]).truncate().perp_dot((t[2] - t[0]).truncate()) / 2.0;
    let down_m2: f64 = terrain(small()).map(|t| (-plan_m2(t)).max(0.0)).sum();
    assert!(down_m2 > 150.0, "{down_m2} square metres face down");
    for seed in [1, 2] {
        let share = with_relief(seed, 280.0, |relief| {
            let z = &relief.window;
            let over = |k: &usize| relief.top_m(z.position(k % z.width, k / z.width)) - f64::from(z.data[*k]) > 1.0;
            let within = |k: &usize| z.position(k % z.width, k / z.width).length() < 280.0;
            let posts: Vec<usize> = (0..z.data.len()).filter(within).collect();
            posts.iter().filter(|k| over(k)).count() as f64 / posts.len() as f64
        });
        assert!((0.005..=0.03).contains(&share), "seed {seed}: {share} of the plan overhangs");
    }
}
