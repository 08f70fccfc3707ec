//! Recipes, overrides and seed lists out of thin air: whatever the text, there is a legal recipe or one sentence, and never
//! a panic. What is read can be written and read again.

#![allow(clippy::unwrap_used, clippy::format_collect)]

mod support;

use satseed::plan::Plan;
use satseed::recipe::{PRESETS, Preset, Recipe, RecipeError};
use satseed_scene::{Rng, SeedPath};

/// Everything that a recipe can say.
const ALL: &str = r#"
extends = "satunreal"
seed = 3
camera = { altitude_m = 1_000.0, gsd_m = 3e-1, size_px = [64, 0x40], datum = -12.5 }
[acquisition]
convergence_deg = { from = 2.8, to = 11.4, steps = 3 }
azimuth_deg = [-90, 12.5, 90]
pivot_along_baseline = "random"
pairs_per_pivot = 5
[light]
sun = { elevation_deg = 42.0, azimuth_deg = 145.0 }
aerosol_optical_depth = 0.12
[sensor]
preset = "ideal"
samples_per_pixel = 1
bands = "rgb_nir"
mtf_at_nyquist = 0.12
smear_px = 0.5
snr = 90
read_noise = 1e-3
column_gain = 0.002
colour_ratio = 4
colour_offset_px = -0.1
coding = "8bit"
stretch_percent = [1, 99]
gamma = 0.6
[labels]
write = ["disparity_right", "class", "elevation", "instance", "normal", "shadow", "edge"]
disparity_precision = "1/256"
[split]
rule = "by-pivot"
[[scene]]
pivots = 2
[scene.canyon]
relief_m = 150
radius_m = 3e2
[[scene]]
toronto = { variant = "midtown", density = 0.5 }
seeds = [1, 18446744073709551615]
[generators]
"#;

const SETS: &[&str] = &[
    "camera.gsd_m=0.5",
    "camera.datum=pivot",
    "acquisition.baseline_m={from=10,to=20,steps=2}",
    "scene.canyon.relief_m=150",
    "scene.pivots=3",
    "labels.write=[\"class\"]",
    "scene=[{canyon={relief_m=160},pivots=1}]",
    "seed=5",
];

const LIST: &str =
    "# scenes\ncanyon 42\ntoronto/midtown 7 density=0.8 trees=1.5 # hi\n\n canyon/gorge 43 relief_m=150\n";

/// Texts that parsers trip over.
const WORDS: &[&str] = &[
    "nan",
    "inf",
    "-inf",
    "1e999",
    "-0.0",
    "0x",
    "9223372036854775808",
    "-9223372036854775809",
    "1e-400",
    "''",
    "\"\"\"",
    "'''",
    "[[",
    "]]",
    "{",
    "}",
    "[",
    "]",
    "=",
    ".",
    ",",
    "#",
    "\n",
    "\r",
    "\0",
    "\\u0000",
    "\\",
    "\"",
    "'",
    " ",
    "\t",
    "\u{feff}",
    "é",
    "\u{202e}",
    "true",
    "1979-05-27T07:32:00Z",
    "scene",
    "[[scene]]\n",
    "canyon",
    "extends",
    "seeds",
    "pivots = 10000\n",
    "steps = 1000",
    "1/256",
    "_",
    "+",
    "1__0",
    "a.b.c.d.e.f",
    "{a={a={a={a={a={a={a={a=1}}}}}}}}",
];

fn pick<'a>(texts: &[&'a str], rng: &mut Rng) -> &'a str {
    texts[rng.below(texts.len() as u64) as usize]
}

fn mutate(text: &str, rng: &mut Rng) -> String {
    let mut bytes = text.as_bytes().to_vec();
    support::mutate::mutate(&mut bytes, WORDS, rng);
    String::from_utf8_lossy(&bytes).into_owned()
}

/// A legal recipe reads back equal, and has a plan or one sentence; an error is short and has its place.
fn judge(result: Result<Recipe, RecipeError>, input: &str) -> bool {
    match result {
        Ok(recipe) => {
            let text = recipe.to_toml();
            let again = Recipe::parse("again", &text).unwrap_or_else(|e| panic!("{e}\nfrom {input}"));
            assert_eq!(again, recipe, "{input}");
            match Plan::new(&recipe) {
                Ok(plan) => {
                    assert_eq!(plan.pair_count(), plan.split_counts().iter().sum::<usize>());
                    for (scene, _) in plan.pairs() {
                        assert!(scene.name.len() <= 64 && !scene.name.contains(['/', '.', '\\']), "{}", scene.name);
                    }
                }
                Err(e) => assert!(!e.to_string().contains('\n') && e.to_string().len() < 400, "{e}"),
            }
            true
        }
        Err(e) => {
            let told = e.to_string();
            assert!(e.line_column().is_some(), "{told}\n{input}");
            assert!(told.len() < 4000 && told.lines().count() == 4, "{told}\n{input}");
            assert!(!told.chars().any(|c| c.is_control() && c != '\n'), "{told:?}\n{input}");
            false
        }
    }
}

#[test]
fn mutated_inputs_never_panic() {
    mutate_and_judge(20);
}

/// Over a million inputs.
#[test]
#[ignore = "long: run by ./check --long"]
fn many_mutated_inputs_never_panic() {
    (100..150).for_each(mutate_and_judge);
}

/// 9,000 recipes, 9,000 overrides, 6,000 seed lists.
fn mutate_and_judge(seed: u64) {
    let mut rng = SeedPath::root("fuzz", seed).rng();
    let mut legal = [0; 3];
    let texts: Vec<&str> = PRESETS.iter().map(|p| p.text).chain([ALL, ALL, ALL]).collect();
    for text in &texts {
        // Small plans, since a debug build makes many of them.
        assert!(
            judge(Recipe::parse_with("whole", text, &["scene.pivots=1".to_owned()]), text) || text.contains("seeds")
        );
    }
    for _ in 0..9000 {
        let text = mutate(pick(&texts, &mut rng), &mut rng);
        let set = ["acquisition.pairs_per_pivot=1".to_owned()];
        legal[0] += u32::from(judge(Recipe::parse_with("fuzz", &text, &set), &text));
    }
    for _ in 0..9000 {
        let set = [mutate(pick(SETS, &mut rng), &mut rng)];
        legal[1] += u32::from(judge(Recipe::parse_with("fuzz", PRESETS[0].text, &set), &set[0]));
    }
    let quickstart = Preset::by_name("quickstart").unwrap();
    for _ in 0..6000 {
        let list = mutate(LIST, &mut rng);
        legal[2] += u32::from(judge(Recipe::parse_with_seed_list(quickstart, "fuzz", &list), &list));
    }
    // The mutations are mild enough that some stay legal: both ways are walked.
    assert!(legal.iter().all(|n| *n > 300), "{legal:?}");
}

/// 79 x 70 levels by dotted keys within inline tables, on a thread with a small stack.
#[test]
fn nesting_does_not_overflow_the_stack() {
    let dotted = vec!["a"; 79].join(".");
    let bomb = format!("a = {}1{}", format!("{{{dotted}=").repeat(75), "}".repeat(75));
    let judge = move || Recipe::parse("bomb", &bomb).unwrap_err().to_string();
    let told = std::thread::Builder::new().stack_size(2 << 20).spawn(judge).unwrap().join().unwrap();
    assert!(told.contains("nested deeper than 12"), "{told}");
}
