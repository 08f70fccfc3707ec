use super::*;
use crate::Region;
use crate::kit::checks::{assert_between, assert_closed, assert_rises, assert_rooted, vertices};
use crate::kit::polygon;
use crops::{Form, TABLE};
use satseed_scene::SurfacePoint;
use std::collections::BTreeSet;
use std::sync::OnceLock;

const VARIANTS: [Variant; 2] = [Variant::European, Variant::Pivot];
/// Half a frame's side, m: 2048 px of 0.3 m.
const FRAME_M: f64 = 307.2;

fn params(radius_m: f64, variant: Variant) -> Params {
    Params { variant, radius_m, ..Params::default() }
}

fn root(seed: u64) -> SeedPath {
    SeedPath::root("field", seed)
}

fn with_relief<T>(seed: u64, params: &Params, f: impl FnOnce(&Relief) -> T) -> T {
    f(&ground(params, &root(seed).child(params.variant())))
}

fn plan(seed: u64, params: &Params) -> Plan {
    Plan::new(params, &root(seed).child(params.variant()).child("plan"))
}

fn on_threads(threads: usize) -> Scene {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| build(&params(60.0, Variant::European), root(1)))
}

/// A small scene that several tests look at.
fn small() -> &'static Scene {
    static SCENE: OnceLock<Scene> = OnceLock::new();
    SCENE.get_or_init(|| on_threads(2))
}

#[test]
fn the_terrain_of_all_tiles_is_one_closed_surface() {
    assert_closed(small(), tiling(60.0).scene_half_m());
}

#[test]
fn the_number_of_threads_does_not_show() {
    assert_eq!(on_threads(1).hash(), small().hash());
}

/// A scene of a seed with the extremes of all parameters in turn.
fn any(seed: u64) -> Params {
    let pick = |values: [f64; 3], turn: u64| values[((seed / turn) % 3) as usize];
    Params {
        variant: VARIANTS[(seed % 2) as usize],
        radius_m: 60.0,
        relief_m: pick([18.0, 60.0, 0.0], 2),
        parcel_ha: pick([2.5, 0.8, 6.0], 3),
        hedges: pick([1.0, 2.0, 0.0], 5),
        roughness: pick([1.0, 2.0, 0.0], 4),
        texture_contrast: pick([1.0, 0.0, 2.0], 7),
    }
}

fn seeds_build(seeds: impl IntoParallelIterator<Item = u64>) {
    seeds.into_par_iter().for_each(|k| {
        let params = any(k);
        // Some small, some large.
        let seed = k.wrapping_mul(if k % 4 < 2 { 1 } else { 0x9e37_79b9_7f4a_7c15 });
        let scene = build(&params, root(seed));
        scene.validate().unwrap();
        assert_between(&scene, params.height_bounds_m(), &format!("{k}, {params:?}"));
        assert!(scene.instances.iter().any(|i| i.object != 0), "{k}: nothing stands anywhere");
        if k % 10 == 0 {
            assert_closed(&scene, tiling(params.radius_m).scene_half_m());
        }
    });
}

#[test]
fn any_seed_builds_within_the_stated_bounds() {
    seeds_build(0..8);
}

#[test]
#[ignore = "long: 200 scenes"]
fn two_hundred_seeds_build_within_the_stated_bounds() {
    seeds_build(1000..1200);
}

#[test]
fn what_stands_on_the_ground_reaches_below_it() {
    for variant in VARIANTS {
        let params = params(60.0, variant);
        let scene = build(&params, root(3));
        with_relief(3, &params, |relief| assert_rooted(&scene, 0.04, |p| relief.height_m(p)));
    }
}

/// Numbers of the plan within a frame: parcels, species, areas of the mosaic's parcels in hectares.
fn in_frame(plan: &Plan) -> (usize, usize, Vec<f64>) {
    let mut seen = BTreeSet::new();
    for j in 0..=150 {
        for i in 0..=150 {
            let p = DVec2::new(f64::from(i) - 75.0, f64::from(j) - 75.0) * (FRAME_M / 75.0);
            seen.extend(plan.parcel_at(plan.warp.plan(p)));
        }
    }
    let species: BTreeSet<u8> = seen.iter().map(|k| plan.parcels[*k].crop.facts().species).collect();
    let areas = plan.parcels.iter().filter(|p| p.convex).map(|p| polygon::area(&p.outline) / 1e4).collect();
    (seen.len(), species.len(), areas)
}

#[test]
fn a_frame_holds_enough_parcels_and_crops() {
    for variant in VARIANTS {
        for seed in 1..=12 {
            let plan = plan(seed, &params(700.0, variant));
            let (parcels, species, _) = in_frame(&plan);
            assert!((12..=60).contains(&parcels), "{variant:?} {seed}: {parcels} parcels");
            assert!(species >= 6, "{variant:?} {seed}: {species} crops");
            assert!(plan.yard.is_some(), "{variant:?} {seed}: no farmstead");
        }
    }
}

#[test]
fn parcels_of_the_mosaic_are_as_large_as_told() {
    for (parcel_ha, seed) in [(0.8, 1), (2.5, 2), (2.5, 3), (6.0, 4)] {
        let params = Params { parcel_ha, ..params(700.0, Variant::European) };
        let mut areas = in_frame(&plan(seed, &params)).2;
        areas.sort_by(f64::total_cmp);
        let median = areas[areas.len() / 2];
        assert!((median / parcel_ha - 1.0).abs() < 0.25, "median {median} ha for {parcel_ha}");
        let deviation = {
            let logs: Vec<f64> = areas.iter().map(|a| libm::log(*a)).collect();
            let mean = logs.iter().sum::<f64>() / logs.len() as f64;
            (logs.iter().map(|l| (l - mean) * (l - mean)).sum::<f64>() / logs.len() as f64).sqrt()
        };
        assert!((0.3..0.9).contains(&deviation), "deviation of the logarithm {deviation}");
    }
}

#[test]
fn neighbours_never_bear_the_same() {
    for variant in VARIANTS {
        for seed in 1..=4 {
            let plan = plan(seed, &params(700.0, variant));
            // Across every border, from one side to the other.
            let mut pairs = 0;
            for border in &plan.borders {
                let [a, b] = border.ends;
                let across = (b - a).normalize().perp() * (border.edge.half_m() + 1.0);
                for k in 1..40 {
                    let q = a.lerp(b, f64::from(k) / 40.0);
                    if let (Some(i), Some(j)) = (plan.parcel_at(q + across), plan.parcel_at(q - across))
                        && i != j
                    {
                        pairs += 1;
                        let [x, y] = [i, j].map(|k| plan.parcels[k].crop);
                        assert!(x != y, "{variant:?} {seed}: {x:?} on both sides at {q}");
                    }
                }
            }
            assert!(pairs > 500, "{pairs} places looked at");
        }
    }
}

/// Rows that can be told from each other stand at their period, and every one starts at the same phase.
#[test]
fn rows_stand_at_their_period() {
    let mut kinds = BTreeSet::new();
    for seed in 1..=6 {
        let params = params(60.0, Variant::European);
        with_relief(seed, &params, |relief| {
            for parcel in &relief.plan.parcels {
                let (Some(stand), Form::Rows { row_m, .. }) = (Stand::of(parcel), parcel.crop.facts().form) else {
                    continue;
                };
                let placed = rows::place(relief, parcel, &stand, &root(seed));
                // Places across the rows of single pieces along the parcel's own direction.
                let across = parcel.axis.perp();
                let mut at: Vec<f64> = placed
                    .iter()
                    .filter(|p| p.mesh >= 14 && p.world_from_object.x_axis.truncate().dot(parcel.axis) > 0.999_999)
                    .map(|p| p.at_m.dot(across))
                    .collect();
                at.sort_by(f64::total_cmp);
                at.dedup_by(|a, b| (*a - *b).abs() < 0.02);
                let steps: Vec<f64> = at.windows(2).map(|w| w[1] - w[0]).filter(|d| *d < 1.5 * row_m).collect();
                if steps.len() < 8 {
                    continue;
                }
                kinds.insert(parcel.crop);
                let mean = steps.iter().sum::<f64>() / steps.len() as f64;
                assert!((mean / row_m - 1.0).abs() < 0.005, "{:?}: {mean} for {row_m}", parcel.crop);
                assert!(steps.iter().all(|d| (d / row_m - 1.0).abs() < 0.03), "{:?}: {steps:?}", parcel.crop);
            }
        });
    }
    assert!(kinds.len() >= 3, "only {kinds:?} stand near the pivot");
}

/// Canopies stand as high over their ground as their crop.
#[test]
fn canopies_have_their_height() {
    let params = params(120.0, Variant::European);
    let mut looked_at = 0;
    with_relief(2, &params, |relief| {
        for parcel in &relief.plan.parcels {
            let Form::Slab { height_m, .. } = parcel.crop.facts().form else { continue };
            let mut tops: Vec<f64> = canopy::sheets(relief, parcel)
                .iter()
                .flat_map(|mesh| {
                    let of_top = |t: &usize| mesh.slots[*t] == canopy::TOP;
                    (0..mesh.triangles.len()).filter(of_top).map(|t| mesh.corners(t)[0]).collect::<Vec<_>>()
                })
                .map(|p| p.z - relief.height_m(p.truncate()))
                .collect();
            if tops.is_empty() {
                continue;
            }
            looked_at += 1;
            tops.sort_by(f64::total_cmp);
            let median = tops[tops.len() / 2];
            assert!((median / height_m - 1.0).abs() < 0.22, "{:?}: {median} m for {height_m}", parcel.crop);
            assert!(tops[0] > 0.08 && tops[tops.len() - 1] < 1.5 * height_m, "{:?}", parcel.crop);
        }
    });
    assert!(looked_at >= 2, "{looked_at} canopies near the pivot");
    let steps = TABLE.iter().filter_map(|f| match f.form {
        Form::Slab { height_m, .. } | Form::Rows { height_m, .. } => Some(height_m),
        _ => None,
    });
    assert!(steps.clone().all(|h| (0.2..=2.8).contains(&h)) && steps.fold(0.0, f64::max) > 2.0);
}

/// What two radii have in common is the same, to the last bit.
#[test]
fn a_crop_is_a_part_of_the_whole() {
    for variant in VARIANTS {
        let [crop, whole] = [60.0, 150.0].map(|radius_m| build(&params(radius_m, variant), root(5)));
        assert_eq!(crop.pivot_height_m.to_bits(), whole.pivot_height_m.to_bits());
        let ground = |s: &Scene| {
            format!("{:?}", s.material_sets[0].iter().map(|m| &s.materials[*m as usize]).collect::<Vec<_>>())
        };
        assert_eq!(ground(&crop), ground(&whole));
        let corner = |mesh: &Mesh| {
            mesh.positions_m.iter().fold([f32::MAX; 2], |low, p| [low[0].min(p[0]), low[1].min(p[1])]).map(f32::to_bits)
        };
        let tiles = |scene: &Scene| -> BTreeMap<[u32; 2], Mesh> {
            let terrain = scene.instances.iter().filter(|i| i.object == 0).map(|i| &scene.meshes[i.mesh as usize]);
            terrain.map(|mesh| (corner(mesh), mesh.clone())).collect()
        };
        let (inner, outer) = (tiles(&crop), tiles(&whole));
        for x in [-128.0_f32, 0.0] {
            for y in [-128.0_f32, 0.0] {
                let at = [x, y].map(f32::to_bits);
                assert!(inner[&at].triangles.len() > 300 && inner[&at] == outer[&at], "the tile at {x}, {y}");
            }
        }
        // Everything that stands on these tiles: its object, where, and the shape of its mesh. A block of rows stands or
        // falls with its beginning, so the outermost 14 m are left out.
        let things = |scene: &Scene| -> BTreeSet<String> {
            let things = scene.instances.iter().filter(|i| i.object != 0);
            let near = things.filter(|i| vertices(scene, i).all(|p| p.truncate().abs().max_element() < 114.0));
            near.map(|i| {
                let first = &scene.meshes[i.mesh as usize].positions_m[..3];
                let path = &scene.objects[i.object as usize].path;
                format!("{path} {:?} {:?} {first:?}", i.world_from_object, i.variation)
            })
            .collect()
        };
        let (few, many) = (things(&crop), things(&whole));
        assert!(few.len() > 60, "{variant:?}: {} things", few.len());
        assert!(
            few == many,
            "{variant:?}: what stands on the crop differs: {:?}",
            few.symmetric_difference(&many).take(4).collect::<Vec<_>>()
        );
        for k in 0..128 * 128 {
            let p = DVec2::new(f64::from(k % 128) - 64.0, f64::from(k / 128) - 64.0) * 1.9;
            for footprint_m in [1.0, 4.0] {
                let [a, b] = [&crop, &whole].map(|s| s.rasters[0].sample(p, footprint_m));
                assert_eq!(a, b, "cover at {p}");
            }
        }
    }
}

fn bare(change: impl Fn(&mut Params)) -> Params {
    let mut p = params(60.0, Variant::European);
    change(&mut p);
    p
}

#[test]
fn relief_raises_hills() {
    let spans = [6.0, 18.0, 60.0].map(|relief_m| {
        with_relief(3, &bare(|p| p.relief_m = relief_m), |r| {
            let z = (0..900).map(|k| r.height_m(DVec2::new(f64::from(k % 30) - 15.0, f64::from(k / 30) - 15.0) * 45.0));
            let (low, high) = z.fold((f64::MAX, f64::MIN), |(l, h), z| (l.min(z), h.max(z)));
            assert!(high - low < relief_m + 2.0 * DETAIL_LIMIT_M, "{low} {high}");
            high - low
        })
    });
    assert_rises("span of heights", &spans);
    assert!(spans[2] > 30.0, "{spans:?}");
}

#[test]
fn roughness_roughens() {
    let bends = [0.0, 1.0, 2.0].map(|roughness| {
        with_relief(3, &bare(|p| p.roughness = roughness), |r| {
            let z = |x: i32, y: i32| r.height_m(DVec2::new(f64::from(x), f64::from(y)));
            let bend = |x: i32, y: i32| (z(x - 1, y) - 2.0 * z(x, y) + z(x + 1, y)).abs();
            (-50..50).flat_map(|y| (-50..50).map(move |x| (x, y))).map(|(x, y)| bend(x, y)).sum::<f64>()
        })
    });
    assert_rises("bends of the ground", &bends);
}

#[test]
fn hedges_grow_in_number() {
    let counts = [0.0, 1.0, 2.0].map(|hedges| {
        let scene = build(&bare(|p| (p.hedges, p.radius_m) = (hedges, 150.0)), root(3));
        let along = |o: &&Object| o.path.starts_with("hedge/") || o.path.starts_with("tree/");
        scene.objects.iter().filter(along).count() as f64
    });
    assert_eq!(counts[0], 0.0);
    assert_rises("hedge pieces and trees", &counts);
}

/// Deviation of the reflectance over the ground and the crops of a scene, relative to its mean, and of the normal's tilt.
fn contrast_of(scene: &Scene) -> (f64, f64) {
    let (mut sum, mut square, mut tilt, n) = (0.0, 0.0, 0.0_f64, 8000);
    let painted: Vec<&Material> = scene
        .materials
        .iter()
        .filter(|m| {
            !matches!(m.class, Class::Tree | Class::Vehicle | Class::Roof | Class::Facade | Class::OtherStructure)
        })
        .filter(|m| !m.name.starts_with("hedge"))
        .collect();
    for k in 0..n {
        let p = DVec2::new(f64::from(k % 100) - 50.0, f64::from(k / 100) - 40.0) * 1.37;
        let point = SurfacePoint {
            world_m: p.extend(0.0),
            object_m: p.extend(0.0),
            uv_m: DVec2::ZERO,
            normal: glam::DVec3::Z,
            footprint_m: 0.3,
            variation: [0.3, -0.4, 0.9, 0.0],
        };
        let shade = painted[k as usize % painted.len()].shade(&point, &scene.rasters);
        let v = f64::from(shade.albedo.0[1]);
        sum += v;
        square += v * v;
        tilt = tilt.max(shade.normal.truncate().length());
    }
    let mean = sum / f64::from(n);
    ((square / f64::from(n) - mean * mean).max(0.0).sqrt() / mean, tilt)
}

#[test]
fn texture_contrast_goes_down_to_nothing() {
    let found =
        [0.0, 0.5, 1.0, 2.0].map(|contrast| contrast_of(&build(&bare(|p| p.texture_contrast = contrast), root(3))));
    assert!(found[0].0 < 1e-4 && found[0].1 < 1e-6, "{found:?}");
    assert_rises("deviation of the colour", &found.map(|f| f.0));
    assert_rises("tilt of the normals", &found.map(|f| f.1));
}

#[test]
fn parameters_out_of_range_are_refused_with_their_range() {
    type Case = (fn(&mut Params), &'static str);
    let cases: [Case; 8] = [
        (|p| p.radius_m = 59.0, "`radius_m` is 59, but must lie in 60 to 900"),
        (|p| p.radius_m = f64::INFINITY, "`radius_m` is inf, but must lie in 60 to 900"),
        (|p| p.relief_m = -1.0, "`relief_m` is -1, but must lie in 0 to 60"),
        (|p| p.relief_m = f64::NAN, "`relief_m` is NaN, but must lie in 0 to 60"),
        (|p| p.parcel_ha = 0.5, "`parcel_ha` is 0.5, but must lie in 0.8 to 6"),
        (|p| p.hedges = 2.5, "`hedges` is 2.5, but must lie in 0 to 2"),
        (|p| p.roughness = -0.1, "`roughness` is -0.1, but must lie in 0 to 2"),
        (|p| p.texture_contrast = 2.5, "`texture_contrast` is 2.5, but must lie in 0 to 2"),
    ];
    for (change, expected) in cases {
        let error = Region::Field(bare(change)).check().unwrap_err();
        assert_eq!(error.to_string(), expected);
    }
    assert_eq!(Region::by_name("field").unwrap().check(), Ok(()));
}
