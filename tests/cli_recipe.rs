//! Recipes, seed lists and overrides through the program: what is refused, how it is said, and that nothing is written.

#![allow(clippy::unwrap_used, clippy::format_collect)]

use std::path::Path;
use std::process::{Command, Output, Stdio};

fn satseed(dir: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_satseed")).current_dir(dir).args(args).output().unwrap()
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// One file `name` with `bytes`, and `satseed generate` with `args` beside it: refused with exit code 2, one error that
/// holds every one of `parts`, and nothing written beside the file.
fn refused(name: &str, bytes: &[u8], args: &[&str], parts: &[&str]) {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join(name), bytes).unwrap();
    let args = [&["generate"], args, &["--out", "out"]].concat();
    let output = satseed(dir.path(), &args);
    let told = stderr(&output);
    let input = String::from_utf8_lossy(&bytes[..bytes.len().min(300)]).into_owned();
    assert_eq!(output.status.code(), Some(2), "{input}\n{args:?}\n{told}");
    assert!(output.stdout.is_empty(), "{input}\n{args:?}");
    assert_eq!(told.matches("error:").count(), 1, "{input}\n{args:?}\n{told}");
    for part in parts {
        assert!(told.contains(part), "{input}\n{args:?}\n  told: {told}\n  but not: {part}");
    }
    assert!(told.len() < 1500 && !told.contains("panicked") && !told.contains('\u{1b}'), "{told}");
    let left: Vec<_> = std::fs::read_dir(dir.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left, [name], "{input}\n{args:?}");
}

/// A scene that makes a recipe legal, so that only the line before it is wrong.
const TAIL: &str = "\n[[scene]]\ncanyon = {}\n";

/// What stands in the recipe, where the mistake is (line:column), and what the message must hold.
const BAD_RECIPES: &[(&str, &str, &[&str])] = &[
    // Not TOML.
    ("seed = ", "1:8", &["not TOML"]),
    ("seed 1", "1:6", &["not TOML"]),
    ("seed = 1\nseed = 2", "2:1", &["not TOML", "duplicate key"]),
    ("[camera]\n[camera]", "2:2", &["not TOML", "duplicate key"]),
    ("[camera", "1:8", &["not TOML"]),
    ("seed = 'one\n", "1:12", &["not TOML"]),
    ("camera = { gsd_m = 0.3", "2:1", &["not TOML"]),
    ("\u{1b}[31m = 1", "1:2", &["not TOML"]),
    // The root.
    ("sead = 1", "1:1", &["unknown key `sead`", "seed", "camera"]),
    ("[[scenes]]\ncanyon = {}", "1:3", &["unknown key `scenes`", "scene"]),
    ("seed = -1", "1:8", &["`seed`", "-1", "0 to 900000000000000"]),
    ("seed = 1.5", "1:8", &["`seed`", "whole number", "1.5"]),
    ("seed = 1e999", "1:8", &["finite", "1e999"]),
    ("seed = 9223372036854775808", "1:8", &["`seed`", "0 to 900000000000000"]),
    ("seed = 0xfffffffffffffffffffffffffffffffffffffff", "1:8", &["too many digits"]),
    ("seed = '1'", "1:8", &["`seed`", "whole number", "the text \"1\""]),
    ("seed = 2026-11-22", "1:8", &["`seed`", "date"]),
    ("seed = true", "1:8", &["`seed`", "whole number", "true"]),
    ("camera = 5", "1:10", &["`camera`", "a table"]),
    ("extends = 'nosuch'", "1:11", &["`extends`", "nosuch", "quickstart"]),
    ("extends = 5", "1:11", &["`extends`", "preset"]),
    ("extends = '../quickstart.toml'", "1:11", &["`extends`", "no preset"]),
    // [camera]
    ("[camera]\ngsd_m = -0.3", "2:9", &["`camera.gsd_m`", "-0.3", "0.01 to 30", "metres"]),
    ("[camera]\ngsd_m = 0", "2:9", &["`camera.gsd_m`", "0.01 to 30"]),
    ("[camera]\ngsd_m = nan", "2:9", &["finite", "nan"]),
    ("[camera]\ngsd_m = inf", "2:9", &["finite", "inf"]),
    ("[camera]\ngsd_m = '0.3m'", "2:9", &["`camera.gsd_m`", "number", "0.3m", "metres"]),
    ("[camera]\ngsd = 0.3", "2:1", &["unknown key `gsd`", "`camera`", "gsd_m"]),
    ("[camera]\naltitude_m = 50", "2:14", &["`camera.altitude_m`", "100 to 1000000"]),
    ("[camera]\naltitude_km = 1", "2:1", &["unknown key `altitude_km`", "altitude_m"]),
    ("[camera]\nsize_px = 2048", "2:11", &["`camera.size_px`", "[2048, 2048]", "2048"]),
    ("[camera]\nsize_px = [2048]", "2:11", &["`camera.size_px`", "width and height"]),
    ("[camera]\nsize_px = [2048, 7]", "2:18", &["`camera.size_px`", "8 to 16384"]),
    ("[camera]\nsize_px = [99999999, 99999999]", "2:12", &["`camera.size_px`", "8 to 16384"]),
    ("[camera]\nsize_px = [512.5, 512]", "2:12", &["`camera.size_px`", "whole number"]),
    ("[camera]\ndatum = 'ground'", "2:9", &["`camera.datum`", "ground", "\"pivot\"", "\"lowest\""]),
    ("[camera]\ndatum = true", "2:9", &["`camera.datum`", "a height in metres"]),
    ("[camera]\ndatum = 1e6", "2:9", &["`camera.datum`", "-1000 to 9000"]),
    ("[camera]\ndatum = 1000", "2:9", &["`camera.datum`", "below the cameras", "1000 m"]),
    // [acquisition]
    ("[acquisition]\nbaseline_m = 0", "2:14", &["`acquisition.baseline_m`", "0.01 to 2000000"]),
    ("[acquisition]\nbaseline_m = []", "2:14", &["`acquisition.baseline_m`", "1 to 1000 numbers"]),
    ("[acquisition]\nbaseline_m = [50, 50.0]", "2:19", &["`acquisition.baseline_m`", "twice"]),
    ("[acquisition]\nbaseline_m = [50, 'x']", "2:19", &["`acquisition.baseline_m[1]`", "number"]),
    ("[acquisition]\nbaseline_m = { from = 50, to = 200 }", "2:14", &["`acquisition.baseline_m.steps` is missing"]),
    ("[acquisition]\nbaseline_m = { from = 50, steps = 3 }", "2:14", &["`acquisition.baseline_m.to` is missing"]),
    ("[acquisition]\nbaseline_m = { from = 200, to = 50, steps = 3 }", "2:33", &["baseline_m.to`", "below `from`"]),
    ("[acquisition]\nbaseline_m = { from = 50, to = 50, steps = 3 }", "2:14", &["all equal"]),
    ("[acquisition]\nbaseline_m = { from = 50, to = 60, steps = 0 }", "2:44", &["baseline_m.steps`", "1 to 1000"]),
    (
        "[acquisition]\nbaseline_m = { from = 50, to = 200, steps = 4000000000 }",
        "2:45",
        &["baseline_m.steps`", "1 to 1000"],
    ),
    ("[acquisition]\nbaseline_m = { from = 50, to = 200, draws = 4 }", "2:14", &["steps` is missing"]),
    ("[acquisition]\nbaseline_m = { from = 5, to = 9, steps = 3, by = 2 }", "2:45", &["unknown key `by`", "steps"]),
    ("[acquisition]\nbaseline_m = 100\nconvergence_deg = 5", "3:19", &["exclude each other"]),
    ("[acquisition]\nconvergence_deg = 91", "2:19", &["`acquisition.convergence_deg`", "0.01 to 90", "degrees"]),
    ("[acquisition]\nbaseline_m = 2500", "2:14", &["2500", "2000 m"]),
    ("[acquisition]\nbaseline_m = 900", "2:14", &["no overlap", "614.4 m", "datum"]),
    ("[acquisition]\nazimuth_deg = 400", "2:15", &["`acquisition.azimuth_deg`", "-360 to 360"]),
    (
        "[acquisition]\nazimuth_deg = { from = -90, to = 90, draws = 18446744073709551615 }",
        "2:46",
        &["azimuth_deg.draws`", "1 to 1000"],
    ),
    ("[acquisition]\nazimuth_deg = 'north'", "2:15", &["`acquisition.azimuth_deg`", "north", "draws"]),
    ("[acquisition]\npivot_along_baseline = 'left'", "2:24", &["pivot_along_baseline`", "random"]),
    ("[acquisition]\npivot_along_baseline = 12", "2:24", &["pivot_along_baseline`", "-10 to 11"]),
    ("[acquisition]\npairs_per_pivot = 0", "2:19", &["`acquisition.pairs_per_pivot`", "1 to"]),
    ("[acquisition]\npairs_per_pivot = 401", "2:19", &["401", "20 baselines", "20 azimuths", "400 pairs"]),
    // [light], [sensor], [labels], [split]
    ("[light]\nsun = { elevation_deg = 5 }", "2:25", &["`light.sun.elevation_deg`", "10 to 90", "degrees"]),
    ("[light]\nsun = 45", "2:7", &["`light.sun`", "a table"]),
    ("[light]\nsun = { elevation = 5 }", "2:9", &["unknown key `elevation`", "elevation_deg"]),
    ("[light]\nsun = { elevation_deg = 40, date = '2024-06-21' }", "2:25", &["sun.elevation_deg`", "`light.sun.date`"]),
    (
        "[light]\nsun = { date = '2024-06-21', latitude_deg = 43.7 }",
        "2:7",
        &["`light.sun.local_solar_time` is missing"],
    ),
    ("[light.sun]\ndate = '2024-02-30'", "2:8", &["`light.sun.date`", "2024-02-30", "\"2024-06-21\""]),
    ("[light.sun]\nlocal_solar_time = 10.5", "2:20", &["`light.sun.local_solar_time`", "10.5", "\"10:30\""]),
    ("[light.sun]\nlatitude_deg = 91", "2:16", &["`light.sun.latitude_deg`", "-90 to 90", "degrees"]),
    (
        "[light.sun]\nlatitude_deg = 70\ndate = 2024-12-21\nlocal_solar_time = '10:30'",
        "3:8",
        &["`light.sun.date`", "-4.8 degrees high", "10 to 90"],
    ),
    ("[light]\naerosol_optical_depth = 2", "2:25", &["`light.aerosol_optical_depth`", "0 to 1"]),
    ("[sensor]\nsamples_per_pixel = 0", "2:21", &["`sensor.samples_per_pixel`", "1 to 4096"]),
    ("[sensor]\nsamples_per_pixel = 99999999999999", "2:21", &["`sensor.samples_per_pixel`", "1 to 4096"]),
    ("[sensor]\npreset = 'worldview4'", "2:10", &["`sensor.preset`", "worldview4", "\"worldview3_rgb\""]),
    ("[sensor]\nbands = 'infrared'", "2:9", &["`sensor.bands`", "infrared", "\"rgb_nir\""]),
    ("[sensor]\nmtf_at_nyquist = 0.7", "2:18", &["`sensor.mtf_at_nyquist`", "0.02 to 0.4"]),
    ("[sensor]\nmtf_at_nyquist = 'sharp'", "2:18", &["`sensor.mtf_at_nyquist`", "sharp", "\"none\""]),
    ("[sensor]\nsmear_px = 3", "2:12", &["`sensor.smear_px`", "0 to 2", "pixels"]),
    ("[sensor]\npreset = 'ideal'\nsmear_px = 0.4", "3:12", &["`sensor.smear_px`", "`sensor.mtf_at_nyquist`"]),
    ("[sensor]\nsnr = 1", "2:7", &["`sensor.snr`", "5 to 100000"]),
    ("[sensor]\nread_noise = 0.2", "2:14", &["`sensor.read_noise`", "0 to 0.05"]),
    ("[sensor]\nsnr = 300\nread_noise = 0.002", "3:14", &["`sensor.read_noise`", "300", "at most 0.001"]),
    ("[sensor]\ncolumn_gain = -1", "2:15", &["`sensor.column_gain`", "0 to 0.05"]),
    ("[sensor]\ncolour_ratio = 9", "2:16", &["`sensor.colour_ratio`", "1 to 8"]),
    ("[sensor]\nbands = 'pan'\ncolour_ratio = 4", "3:16", &["`sensor.colour_ratio`", "panchromatic"]),
    ("[sensor]\ncolour_ratio = 1\ncolour_offset_px = 0.2", "3:20", &["`sensor.colour_offset_px`", "colour_ratio"]),
    ("[sensor]\ncoding = '16bit'", "2:10", &["`sensor.coding`", "16bit", "\"11bit\""]),
    ("[sensor]\ncoding = '11bit'\ngamma = 0.5", "3:9", &["`sensor.gamma`", "\"11bit\""]),
    ("[sensor]\ncoding = 'float'\nstretch_percent = [1, 99]", "3:19", &["stretch_percent`", "\"float\""]),
    ("[sensor]\nstretch_percent = [30, 99]", "2:20", &["`sensor.stretch_percent[0]`", "0 to 20"]),
    ("[sensor]\nstretch_percent = 99", "2:19", &["`sensor.stretch_percent`", "percentiles"]),
    ("[sensor]\ngamma = 2", "2:9", &["`sensor.gamma`", "0.2 to 1"]),
    ("[labels]\nwrite = ['depth']", "2:10", &["`labels.write`", "depth", "\"elevation\""]),
    ("[labels]\nwrite = 'class'", "2:9", &["`labels.write`", "a list"]),
    ("[labels]\nwrite = ['class', 'class']", "2:19", &["`labels.write`", "twice"]),
    ("[labels]\ndisparity_precision = '1/16'", "2:23", &["disparity_precision`", "\"1/256\""]),
    ("[split]\nrule = 'random'", "2:8", &["`split.rule`", "\"by-pivot\"", "\"published\""]),
    ("[generators]\ncanyon = 999999", "2:10", &["version 999999", "canyon", "this build"]),
    ("[generators]\natlantis = 1", "2:1", &["atlantis", "canyon, toronto"]),
    ("[stages]\nrender = 999999", "2:10", &["version 999999", "stage render", "this build", "other bytes"]),
    ("[stages]\nlabels = 0", "2:10", &["`stages.labels`", "1 to"]),
    ("[stages]\nmagic = 1", "2:1", &["magic", "plan, render, labels, files"]),
];

#[test]
fn bad_recipes_are_refused_where_they_are_wrong() {
    for (text, place, parts) in BAD_RECIPES {
        let place = format!("r.toml:{place}: ");
        refused("r.toml", format!("{text}{TAIL}").as_bytes(), &["r.toml"], &[&[place.as_str()], *parts].concat());
    }
}

/// The same for the scenes, which make the whole recipe here.
const BAD_SCENES: &[(&str, &str, &[&str])] = &[
    ("", "1:1", &["no `[[scene]]`"]),
    ("seed = 1\n", "1:1", &["no `[[scene]]`"]),
    ("scene = []", "1:9", &["`scene` is empty"]),
    ("scene = 5", "1:9", &["`scene`", "[[scene]]"]),
    ("scene = [5]", "1:10", &["`scene`", "a table", "5"]),
    ("[scene]\ncanyon = {}", "1:1", &["`scene`", "[[scene]]"]),
    ("[[scene]]\n", "1:1", &["names no region", "canyon, toronto"]),
    ("[[scene]]\npivots = 2", "1:1", &["names no region"]),
    ("[[scene]]\natlantis = {}", "2:1", &["`atlantis`", "canyon, toronto"]),
    ("[[scene]]\ncanyon = {}\npivot = 2", "3:1", &["`pivot`", "pivots"]),
    ("[[scene]]\ncanyon = {}\ntoronto = {}", "3:1", &["canyon and toronto", "one region each"]),
    ("[[scene]]\ncanyon = 7", "2:10", &["`scene.canyon`", "table of parameters", "7"]),
    ("[[scene]]\ncanyon = {}\npivots = 0", "3:10", &["`scene.pivots`", "1 to 10000"]),
    ("[[scene]]\ncanyon = {}\npivots = 1e3", "3:10", &["`scene.pivots`", "whole number"]),
    ("[[scene]]\ncanyon = {}\npivots = 2\nseeds = [1]", "3:10", &["exclude each other"]),
    ("[[scene]]\ncanyon = {}\nseeds = []", "3:9", &["`scene.seeds`", "scene seeds"]),
    ("[[scene]]\ncanyon = {}\nseeds = [1, -1]", "3:13", &["`scene.seeds`", "-1"]),
    ("[[scene]]\ncanyon = { relief_m = 500 }", "2:23", &["`scene.canyon.relief_m` is 500", "120 to 220"]),
    ("[[scene]]\ncanyon = { relief_m = 'deep' }", "2:23", &["`scene.canyon.relief_m`", "deep", "expected f64"]),
    ("[[scene]]\ncanyon = { relief_m = [150] }", "2:23", &["`scene.canyon.relief_m`", "expected f64"]),
    ("[[scene]]\ncanyon = { relief = 150 }", "2:12", &["`scene.canyon`", "`relief`", "`relief_m`"]),
    ("[[scene]]\n[scene.canyon]\nrelief_m = nan", "3:12", &["finite"]),
    ("[[scene]]\ntoronto = { variant = 'suburb' }", "2:23", &["`scene.toronto.variant`", "suburb", "`midtown`"]),
    ("[[scene]]\ntoronto = { variant = 3 }", "2:23", &["`scene.toronto.variant`", "3", "midtown"]),
    ("[[scene]]\ntoronto = { density = 1.0, density = 0.5 }", "2:28", &["not TOML", "duplicate key"]),
];

#[test]
fn bad_scenes_are_refused_where_they_are_wrong() {
    for (text, place, parts) in BAD_SCENES {
        let place = format!("r.toml:{place}: ");
        refused("r.toml", text.as_bytes(), &["r.toml"], &[&[place.as_str()], *parts].concat());
    }
}

/// Overrides of preset quickstart: the column within the `K=V` (0 where it has no place) and what the message must hold.
const BAD_SETS: &[(&str, usize, &[&str])] = &[
    ("camera.gsd_m", 1, &["not KEY=VALUE", "camera.gsd_m=0.5"]),
    ("camera.gsd_m=", 14, &["nothing stands after"]),
    ("camera.gsd_m=-1", 14, &["`camera.gsd_m` is -1", "0.01 to 30"]),
    ("camera.gsd_m=0.3m", 14, &["`camera.gsd_m`", "number", "0.3m"]),
    ("camera.gsd_m=[1", 16, &["not TOML"]),
    ("camera.gsd_m=nan", 14, &["finite"]),
    ("camera.gsd_m.x=1", 14, &["`camera.gsd_m`", "number", "a table"]),
    ("camera..gsd_m=1", 8, &["not a key path"]),
    ("=1", 1, &["not a key path"]),
    ("camera.gsd m=1", 8, &["not a key path"]),
    ("a.b.c.d.e.f.g.h.i=1", 1, &["at most 8 parts"]),
    ("camra.gsd_m=1", 1, &["unknown key `camra`", "camera"]),
    ("camera=1", 8, &["`camera`", "a table"]),
    ("seed=abc", 6, &["`seed`", "abc"]),
    ("extends=canyon", 1, &["RECIPE"]),
    ("scene=[]", 7, &["`scene` is empty"]),
    ("scene.atlantis.x=1", 7, &["atlantis", "canyon, toronto"]),
    ("scene.canyon.relief_m=500", 23, &["`scene.canyon.relief_m` is 500", "120 to 220"]),
    ("scene.canyon.relif_m=150", 14, &["`relif_m`", "`relief_m`"]),
    ("scene.canyon=5", 14, &["`scene.canyon`", "table of parameters"]),
    ("scene.canyon.pivots=-3", 21, &["`scene.pivots` is -3"]),
    ("scene.pivots=0", 14, &["`scene.pivots` is 0"]),
    ("acquisition.baseline_m.steps=3000", 30, &["baseline_m.steps` is 3000", "1 to 1000"]),
    ("acquisition.pairs_per_pivot=17", 29, &["4 baselines", "4 azimuths", "16 pairs"]),
    ("labels.write=class", 14, &["`labels.write`", "a list"]),
    ("labels.disparity_precision=1/16", 28, &["disparity_precision`", "\"1/256\""]),
    ("camera.datum=none", 0, &["preset quickstart:", "no overlap"]),
    ("scene.canyon.radius_m=100", 0, &["scene.canyon.radius_m = 100", "it must be at least "]),
    ("camera.altitude_m=200", 0, &["camera.altitude_m = 200", " is needed"]),
    ("camera.datum=900", 0, &["camera.datum is 900", "between"]),
];

#[test]
fn bad_overrides_are_refused_where_they_are_wrong() {
    for (set, column, parts) in BAD_SETS {
        let place = if *column == 0 { "error: ".to_owned() } else { format!("--set {set}, column {column}: ") };
        refused("unused", b"", &["quickstart", "--set", set], &[&[place.as_str()], *parts].concat());
    }
    refused("unused", b"", &["quickstart", "--seed", "999999999999999999"], &["--seed, column 1", "`seed`"]);
    refused("unused", b"", &["quickstart", "--seed", "-1"], &["--seed"]);
    refused("unused", b"", &["quickstart", "--seed", "1", "--seeds", "x"], &["cannot be used with"]);
}

/// Seed lists, where they are wrong, and what the message must hold.
const BAD_SEED_LISTS: &[(&str, &str, &[&str])] = &[
    ("", "1:1", &["names no scene", "region[/variant] seed"]),
    ("# nothing\n\n", "1:1", &["names no scene"]),
    ("atlantis 1", "1:1", &["`atlantis`", "canyon, toronto"]),
    ("canyon 1\n  toronto", "2:10", &["a seed is missing"]),
    ("canyon -1", "1:8", &["`-1`", "whole number"]),
    ("canyon +1", "1:8", &["`+1`", "whole number"]),
    ("canyon 1.0", "1:8", &["`1.0`", "whole number"]),
    ("canyon 18446744073709551616", "1:8", &["whole number"]),
    ("canyon seed=1", "1:8", &["`seed=1`", "whole number"]),
    ("canyon 1 relief_m", "1:10", &["KEY=VALUE"]),
    ("canyon 1 relief_m=500", "1:19", &["`scene.canyon.relief_m` is 500", "120 to 220"]),
    ("canyon 1 relief_m=150 relief_m=160", "1:23", &["`relief_m` stands twice"]),
    ("canyon 1 relief_m = 150", "1:10", &["KEY=VALUE"]),
    ("canyon 1 depth_m=150", "1:10", &["`depth_m`", "`relief_m`"]),
    ("canyon/gully 1", "1:8", &["canyon has one variant, gorge", "`gully`"]),
    ("toronto/suburb 7", "1:9", &["`scene.toronto.variant`", "suburb", "`midtown`"]),
    ("toronto/core 7 variant=midtown", "1:16", &["`variant` stands twice"]),
    ("canyon 1\ncanyon 2\ncanyon 1", "", &["canyon-gorge-1 stands twice"]),
];

#[test]
fn bad_seed_lists_are_refused_where_they_are_wrong() {
    for (text, place, parts) in BAD_SEED_LISTS {
        let place = if place.is_empty() { "error: ".to_owned() } else { format!("s.txt:{place}: ") };
        refused("s.txt", text.as_bytes(), &["satunreal", "--seeds", "s.txt"], &[&[place.as_str()], *parts].concat());
    }
}

#[test]
fn hostile_files_are_refused_in_one_sentence() {
    let big = vec![b' '; (1 << 20) + 1];
    refused("r.toml", &big, &["r.toml"], &["r.toml", "larger than 1048576 bytes"]);
    refused("r.toml", b"seed = 1\nx = \"\xff\xfe\"", &["r.toml"], &["r.toml:2:6: ", "UTF-8"]);
    refused("r.toml", &[0; 1000], &["r.toml"], &["r.toml:1:1001: ", "not TOML"]);
    refused("r.toml", b"", &["missing.toml"], &["missing.toml", "No such file"]);
    refused("r.toml", b"", &["nosuch"], &["`nosuch`", "preset", "quickstart"]);
    refused("r.toml", b"", &["."], &["cannot read recipe ."]);
    refused("r.toml", b"", &[""], &["neither a preset"]);
    refused("r.toml", b"", &["satunreal", "--seeds", "missing.txt"], &["seed list missing.txt", "No such file"]);
    // Nesting, by every way that TOML has.
    let deep = 100_000;
    refused("r.toml", format!("a = {}", "[".repeat(deep)).as_bytes(), &["r.toml"], &["r.toml:1:"]);
    refused("r.toml", format!("a = {}", "{a=".repeat(deep)).as_bytes(), &["r.toml"], &["r.toml:1:"]);
    refused("r.toml", format!("{}a = 1", "a.".repeat(deep)).as_bytes(), &["r.toml"], &["r.toml:1:"]);
    refused("r.toml", format!("[{}a]", "a.".repeat(deep)).as_bytes(), &["r.toml"], &["r.toml:1:"]);
    let dotted = vec!["a"; 79].join(".");
    let nested = format!("{}1{}", format!("{{{dotted}=").repeat(70), "}".repeat(70));
    refused("r.toml", format!("a = {nested}").as_bytes(), &["r.toml"], &["r.toml:1:", "nested deeper than 12"]);
    refused("unused", b"", &["quickstart", "--set", &format!("camera={nested}")], &["nested deeper than 12"]);
    // Numbers and names without end.
    refused("r.toml", format!("seed = {}", "9".repeat(100_000)).as_bytes(), &["r.toml"], &["too many digits"]);
    refused("r.toml", format!("{} = 1", "k".repeat(500_000)).as_bytes(), &["r.toml"], &["r.toml:1:1: unknown key"]);
    let name = format!("[camera]\ndatum = '{}'", "x".repeat(500_000));
    refused("r.toml", name.as_bytes(), &["r.toml"], &["r.toml:2:9: ", "`camera.datum`"]);
    refused("r.toml", b"extends = \"\\u001b[31mred\"", &["r.toml"], &["r.toml:1:11: ", "no preset"]);
    let many = "[[scene]]\ncanyon = {}\npivots = 10000\n".repeat(30);
    refused("r.toml", many.as_bytes(), &["r.toml"], &["120000000 pairs", "at most 1000000"]);
    refused("r.toml", "[[scene]]\n".repeat(100_000).as_bytes(), &["r.toml"], &["names no region"]);
    let list = "canyon 1\n".repeat(500_000);
    refused("s.txt", list.as_bytes(), &["satunreal", "--seeds", "s.txt"], &["larger than 4194304 bytes"]);
    let list: String = (0..300_000).map(|i| format!("canyon {i}\n")).collect();
    refused("s.txt", list.as_bytes(), &["satunreal", "--seeds", "s.txt"], &["120000000 pairs"]);
}

#[test]
fn every_preset_has_a_plan_and_quickstart_is_small() {
    let dir = tempfile::tempdir().unwrap();
    let listed = stdout(&satseed(dir.path(), &["presets"]));
    let names: Vec<_> = listed.lines().map(|line| line.split_whitespace().next().unwrap()).collect();
    let general = ["quickstart", "satunreal", "satseed", "lowtexture", "ablation"];
    let regions = ["canyon", "toronto", "desert", "field", "forest", "coast", "california", "venice"];
    assert_eq!(names, [&general[..], &regions].concat());
    for name in names {
        let output = satseed(dir.path(), &["plan", name, "--format", "jsonl"]);
        assert!(output.status.success(), "{name}: {}", stderr(&output));
        let shown = satseed(dir.path(), &["presets", "show", name]);
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("presets/{name}.toml"));
        assert_eq!(shown.stdout, std::fs::read(file).unwrap());
    }
    let quickstart = stdout(&satseed(dir.path(), &["plan", "quickstart", "--format", "jsonl"]));
    let pairs: Vec<serde_json::Value> = quickstart.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(pairs.len(), 8);
    for (region, n) in [("canyon", 4), ("toronto", 4)] {
        assert_eq!(pairs.iter().filter(|p| p["region"] == region).count(), n);
    }
    // Each of the four baselines and each of the four azimuths once.
    for pairs in pairs.chunks(4) {
        for key in ["baseline_m", "azimuth_deg"] {
            let mut values: Vec<_> = pairs.iter().map(|p| p[key].to_string()).collect();
            values.sort();
            values.dedup();
            assert_eq!(values.len(), 4, "{key}");
        }
    }
    assert_eq!(satseed(dir.path(), &["presets", "show", "nosuch"]).status.code(), Some(2));
}

#[test]
fn a_seed_list_replaces_the_scenes() {
    let dir = tempfile::tempdir().unwrap();
    let list =
        "\u{feff}# mine\ncanyon 42\r\ncanyon/gorge 43 relief_m=150 # deep\n\ttoronto/midtown 7 density=0.8 trees=2\n";
    std::fs::write(dir.path().join("s.txt"), list.trim_start_matches('\u{feff}')).unwrap();
    let args = ["plan", "satunreal", "--seeds", "s.txt", "--set", "acquisition.pairs_per_pivot=1", "--format", "jsonl"];
    let output = satseed(dir.path(), &args);
    assert!(output.status.success(), "{}", stderr(&output));
    let names: Vec<_> = stdout(&output)
        .lines()
        .map(|l| serde_json::from_str::<serde_json::Value>(l).unwrap()["id"].as_str().unwrap().to_owned())
        .collect();
    assert!(names[0].starts_with("canyon-gorge-42/b"), "{names:?}");
    assert!(names[1].starts_with("canyon-gorge-43-"), "{names:?}");
    assert!(names[2].starts_with("toronto-midtown-7-"), "{names:?}");
}

#[test]
fn a_closed_pipe_is_quiet() {
    let dir = tempfile::tempdir().unwrap();
    for args in [
        &["plan", "satunreal", "--format", "jsonl"][..],
        &["plan", "satunreal"],
        &["presets"],
        &["presets", "show", "satunreal"],
        &["completions", "bash"],
    ] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_satseed"))
            .current_dir(dir.path())
            .args(args)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{args:?} {}", stderr(&output));
        assert!(!stderr(&output).contains("error"), "{args:?} {}", stderr(&output));
    }
}

#[test]
fn logs_can_be_json_and_stdout_stays_clean() {
    let dir = tempfile::tempdir().unwrap();
    let output = satseed(dir.path(), &["plan", "quickstart", "--set", "seed=-1", "--log-format", "json"]);
    assert_eq!(output.status.code(), Some(2));
    let line: serde_json::Value = serde_json::from_str(stderr(&output).trim()).unwrap();
    assert_eq!(line["level"], "ERROR");
    assert!(line["fields"]["message"].as_str().unwrap().contains("`seed` is -1"));
    let output = satseed(dir.path(), &["plan", "quickstart", "--format", "jsonl", "-v"]);
    assert!(stderr(&output).contains("split val stays empty"));
    assert!(stdout(&output).lines().all(|l| serde_json::from_str::<serde_json::Value>(l).is_ok()));
    let output = satseed(dir.path(), &["plan", "quickstart", "--format", "jsonl", "-q"]);
    assert!(output.stderr.is_empty());
}

#[test]
fn the_dry_run_writes_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let output = satseed(dir.path(), &["generate", "quickstart", "--out", "out", "--dry-run"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let told = stdout(&output);
    assert!(told.contains("8 of 2 scenes") && told.contains("memory") && told.contains("disk"), "{told}");
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
}

#[test]
fn completions_come_for_every_shell() {
    let dir = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        assert!(stdout(&satseed(dir.path(), &["completions", shell])).contains("satseed"), "{shell}");
    }
}
