//! A document as a [`Recipe`]: every table, key by key, with its range.

use super::node::{Entry, Node, Table, Value};
use super::parts::{
    Acquisition, Ambient, Azimuths, Baselines, Camera, Datum, DisparityPrecision, Label, Labels, Light,
    PivotAlongBaseline, Pivots, SceneEntry, Series, SplitRule,
};
use super::reader::{Reader, number, whole, word, wrong};
use super::region::region_from;
use super::sensor::sensor;
use super::source::{Origin, RecipeError};
use super::{MAX_PIVOTS, MAX_SEED, MAX_STEPS, Recipe, versions};
use satseed_generators::Region;
use std::ops::RangeInclusive;

/// Reads a resolved document: `extends` and overrides have been worked in.
pub(super) fn recipe_from(document: Table, origin: Origin) -> Result<Recipe, RecipeError> {
    let mut root = Reader::root(document, origin);
    let seed = root.whole("seed", 0..=MAX_SEED)?.map_or(1, |(seed, _)| seed);
    let camera = camera(root.table("camera")?)?;
    let acquisition = acquisition(root.table("acquisition")?, &camera)?;
    let light = light(root.table("light")?)?;
    let sensor = sensor(root.table("sensor")?)?;
    let labels = labels(root.table("labels")?)?;
    let mut table = root.table("split")?;
    let split = table.word("rule", SplitRule::ALL)?.unwrap_or(SplitRule::ByPivot);
    table.finish()?;
    versions::check_stages(root.table("stages")?)?;
    versions::check_generators(root.table("generators")?)?;
    let list = root.take("scene");
    // Unknown keys before missing ones: who writes `[[scenes]]` should hear of that.
    let origin = root.origin.clone();
    root.finish()?;
    let scenes = scenes(list, &origin)?;
    Ok(Recipe { seed, camera, acquisition, light, sensor, labels, split, scenes })
}

fn camera(mut table: Reader) -> Result<Camera, RecipeError> {
    let altitude_m = table.number_or("altitude_m", 100.0..=1e6, 1000.0)?;
    let gsd_m = table.number_or("gsd_m", 0.01..=30.0, 0.3)?;
    let size_px = size_px(&mut table)?;
    let datum = datum(&mut table, altitude_m)?;
    table.finish()?;
    Ok(Camera { altitude_m, gsd_m, size_px, datum })
}

fn size_px(table: &mut Reader) -> Result<[u32; 2], RecipeError> {
    let name = table.name("size_px");
    let Some(node) = table.take("size_px") else { return Ok([2048, 2048]) };
    match &node.value {
        Value::List(items) if items.len() == 2 => {
            let side = |item| whole(&name, item, 8..=16384).map(|n| n as u32);
            Ok([side(&items[0])?, side(&items[1])?])
        }
        _ => Err(wrong(&name, &node, "width and height such as [2048, 2048]")),
    }
}

fn datum(table: &mut Reader, altitude_m: f64) -> Result<Datum, RecipeError> {
    let name = table.name("datum");
    let Some(node) = table.take("datum") else { return Ok(Datum::None) };
    match &node.value {
        Value::Float(_) | Value::Integer(_) => {
            let height_m = number(&name, &node, -1000.0..=9000.0)?;
            if height_m < altitude_m {
                Ok(Datum::HeightM(height_m))
            } else {
                let message = format!("`{name}` is {height_m} m, but must lie below the cameras at {altitude_m} m");
                Err(node.origin.error(message))
            }
        }
        Value::Text(text) => match text.as_str() {
            "none" => Ok(Datum::None),
            "pivot" => Ok(Datum::Pivot),
            "lowest" => Ok(Datum::Lowest),
            _ => Err(wrong(&name, &node, DATUM_EXPECTED)),
        },
        _ => Err(wrong(&name, &node, DATUM_EXPECTED)),
    }
}

const DATUM_EXPECTED: &str = "\"none\", \"pivot\", \"lowest\" or a height in metres";

fn acquisition(mut table: Reader, camera: &Camera) -> Result<Acquisition, RecipeError> {
    let baselines = baselines(&mut table)?;
    let azimuths = azimuths(&mut table)?;
    let pivot_along_baseline = pivot_along_baseline(&mut table)?;
    let crossed = u64::from(baselines.0.count()) * u64::from(azimuths.count());
    let pairs_per_pivot = match table.whole("pairs_per_pivot", 1..=1_000_000)? {
        Some((n, origin)) if n > crossed => {
            let (b, a) = (baselines.0.count(), azimuths.count());
            let message = format!(
                "`{}` is {n}, but {b} baselines crossed with {a} azimuths make only {crossed} pairs",
                table.name("pairs_per_pivot")
            );
            return Err(origin.error(message));
        }
        other => other.map(|(n, _)| n as u32),
    };
    frames_overlap(camera, &baselines.0, &baselines.1)?;
    table.finish()?;
    Ok(Acquisition { baselines: baselines.0, azimuths, pivot_along_baseline, pairs_per_pivot })
}

/// Without a datum the frames of a long baseline show different ground: a dataset of nothing is refused.
fn frames_overlap(camera: &Camera, baselines: &Baselines, origin: &Origin) -> Result<(), RecipeError> {
    let longest_m = baselines.lengths_m(camera.altitude_m).into_iter().fold(0.0, f64::max);
    if longest_m > 2.0 * camera.altitude_m {
        let message = format!(
            "a baseline of {longest_m:.1} m at an altitude of {} m converges by more than 90 degrees; at most {} m",
            camera.altitude_m,
            2.0 * camera.altitude_m
        );
        return Err(origin.error(message));
    }
    let width_m = camera.footprint_m()[0];
    if camera.datum == Datum::None && longest_m >= width_m {
        let message = format!(
            "with `camera.datum` \"none\" a baseline of {longest_m:.1} m leaves no overlap of frames {width_m:.1} m \
             wide: name a datum such as \"pivot\", or keep baselines below {width_m:.1} m"
        );
        return Err(origin.error(message));
    }
    Ok(())
}

fn baselines(table: &mut Reader) -> Result<(Baselines, Origin), RecipeError> {
    let length = series(table, "baseline_m", 0.01..=2e6)?;
    let angle = series(table, "convergence_deg", 0.01..=90.0)?;
    match (length, angle) {
        (Some(_), Some((_, origin))) => {
            Err(origin.error("`acquisition.baseline_m` and `acquisition.convergence_deg` exclude each other: keep one"))
        }
        (Some((series, origin)), None) => Ok((Baselines::LengthM(series), origin)),
        (None, Some((series, origin))) => Ok((Baselines::ConvergenceDeg(series), origin)),
        (None, None) => {
            let published = Series::Steps { from: 50.0, to: 200.0, steps: 20 };
            Ok((Baselines::LengthM(published), table.origin.clone()))
        }
    }
}

/// A number, a list of numbers, or `{ from, to, steps }`.
fn series(
    table: &mut Reader,
    key: &'static str,
    range: RangeInclusive<f64>,
) -> Result<Option<(Series, Origin)>, RecipeError> {
    let name = table.name(key);
    let Some(node) = table.take(key) else { return Ok(None) };
    let origin = node.origin.clone();
    let series = match &node.value {
        Value::Float(_) | Value::Integer(_) => Series::List(vec![number(&name, &node, range)?]),
        Value::List(items) => Series::List(list(&name, &node, items, range)?),
        Value::Table(_) => {
            let mut steps = Reader::of(&name, node)?;
            let (from, to) = ends(&mut steps, range)?;
            let Some((n, _)) = steps.whole("steps", 1..=MAX_STEPS)? else { return Err(steps.missing("steps")) };
            steps.finish()?;
            Series::Steps { from, to, steps: n as u32 }
        }
        _ => return Err(wrong(&name, &node, "a number, a list of numbers, or { from = .., to = .., steps = .. }")),
    };
    if let Series::Steps { from, to, steps } = &series
        && *steps > 1
        && from == to
    {
        return Err(origin.error(format!("`{name}` has {steps} steps from {from} to {to}, all equal: keep one")));
    }
    Ok(Some((series, origin)))
}

fn list(name: &str, node: &Node, items: &[Node], range: RangeInclusive<f64>) -> Result<Vec<f64>, RecipeError> {
    if items.is_empty() || items.len() as u64 > MAX_STEPS {
        let message = format!("`{name}` must hold 1 to {MAX_STEPS} numbers, found {}", items.len());
        return Err(node.origin.error(message));
    }
    let mut values: Vec<f64> = Vec::with_capacity(items.len());
    for (i, item) in items.iter().enumerate() {
        let value = number(&format!("{name}[{i}]"), item, range.clone())?;
        if values.contains(&value) {
            return Err(item.origin.error(format!("`{name}` holds {} twice", item.describe())));
        }
        values.push(value);
    }
    Ok(values)
}

fn ends(table: &mut Reader, range: RangeInclusive<f64>) -> Result<(f64, f64), RecipeError> {
    let from = table.required("from", range.clone())?;
    let name = table.name("to");
    let Some((to, origin)) = table.number("to", range)? else { return Err(table.missing("to")) };
    if to < from {
        return Err(origin.error(format!("`{name}` is {to}, but must not lie below `from`, which is {from}")));
    }
    Ok((from, to))
}

fn azimuths(table: &mut Reader) -> Result<Azimuths, RecipeError> {
    let range = -360.0..=360.0;
    let name = table.name("azimuth_deg");
    let Some(node) = table.take("azimuth_deg") else {
        return Ok(Azimuths::Drawn { from_deg: -90.0, to_deg: 90.0, draws: 20 });
    };
    match &node.value {
        Value::Float(_) | Value::Integer(_) => Ok(Azimuths::List(vec![number(&name, &node, range)?])),
        Value::List(items) => Ok(Azimuths::List(list(&name, &node, items, range)?)),
        Value::Table(_) => {
            let mut drawn = Reader::of(&name, node)?;
            let (from_deg, to_deg) = ends(&mut drawn, range)?;
            let Some((n, _)) = drawn.whole("draws", 1..=MAX_STEPS)? else { return Err(drawn.missing("draws")) };
            drawn.finish()?;
            Ok(Azimuths::Drawn { from_deg, to_deg, draws: n as u32 })
        }
        _ => Err(wrong(&name, &node, "a number, a list of numbers, or { from = .., to = .., draws = .. }")),
    }
}

fn pivot_along_baseline(table: &mut Reader) -> Result<PivotAlongBaseline, RecipeError> {
    let name = table.name("pivot_along_baseline");
    let Some(node) = table.take("pivot_along_baseline") else { return Ok(PivotAlongBaseline::Fixed(0.5)) };
    match &node.value {
        Value::Text(text) if text == "random" => Ok(PivotAlongBaseline::Random),
        Value::Float(_) | Value::Integer(_) => Ok(PivotAlongBaseline::Fixed(number(&name, &node, -10.0..=11.0)?)),
        _ => Err(wrong(&name, &node, "a number (0 under the left camera, 1 under the right one) or \"random\"")),
    }
}

fn light(mut table: Reader) -> Result<Light, RecipeError> {
    let mut sun = table.table("sun")?;
    let light = Light {
        sun_elevation_deg: sun.number_or("elevation_deg", 10.0..=90.0, 42.0)?,
        sun_azimuth_deg: sun.number_or("azimuth_deg", -360.0..=360.0, 145.0)?,
        aerosol_optical_depth: table.number_or("aerosol_optical_depth", 0.0..=1.0, 0.12)?,
        ambient: table.word("ambient", Ambient::ALL)?.unwrap_or(Ambient::PerScene),
    };
    sun.finish()?;
    table.finish()?;
    Ok(light)
}

fn labels(mut table: Reader) -> Result<Labels, RecipeError> {
    let name = table.name("write");
    let write = match table.take("write") {
        None => [Label::DisparityRight, Label::Class, Label::Elevation].into(),
        Some(Node { value: Value::List(items), .. }) => {
            let mut labels = std::collections::BTreeSet::new();
            for item in &items {
                if !labels.insert(word(&name, item, Label::ALL)?) {
                    return Err(item.origin.error(format!("`{name}` holds {} twice", item.describe())));
                }
            }
            labels
        }
        Some(node) => return Err(wrong(&name, &node, "a list of labels such as [\"disparity_right\", \"class\"]")),
    };
    let disparity_precision =
        table.word("disparity_precision", DisparityPrecision::ALL)?.unwrap_or(DisparityPrecision::Full);
    table.finish()?;
    Ok(Labels { write, disparity_precision })
}

fn scenes(list: Option<Node>, document: &Origin) -> Result<Vec<SceneEntry>, RecipeError> {
    let list = match list {
        None => return Err(document.error("no `[[scene]]` names a region, and `extends` brings none")),
        Some(Node { value: Value::List(list), origin }) if list.is_empty() => {
            return Err(origin.error("`scene` is empty: at least one `[[scene]]` has to name a region"));
        }
        Some(Node { value: Value::List(list), .. }) => list,
        Some(node) => return Err(wrong("scene", &node, "a list of tables, each under `[[scene]]`")),
    };
    let mut scenes: Vec<SceneEntry> = Vec::new();
    for node in list {
        let entry = scene(node)?;
        // A seed list has one line a scene: neighbours of one kind are one entry.
        match (scenes.last_mut(), &entry.pivots) {
            (Some(SceneEntry { region, pivots: Pivots::Seeds(seeds) }), Pivots::Seeds(more))
                if *region == entry.region =>
            {
                seeds.extend(more);
            }
            _ => scenes.push(entry),
        }
    }
    Ok(scenes)
}

fn scene(node: Node) -> Result<SceneEntry, RecipeError> {
    let mut table = Reader::of("scene", node)?;
    let count = table.whole("pivots", 1..=MAX_PIVOTS)?;
    let seeds = seeds(&mut table)?;
    let pivots = match (count, seeds) {
        (Some((_, origin)), Some(_)) => {
            return Err(origin.error("`scene.pivots` and `scene.seeds` exclude each other: keep one"));
        }
        (_, Some(seeds)) => Pivots::Seeds(seeds),
        (count, None) => Pivots::Count(count.map_or(1, |(n, _)| n as u32)),
    };
    let names = Region::NAMES.join(", ");
    let mut rest = table.take_rest().into_iter();
    let (Some((name, Entry { key, node })), second) = (rest.next(), rest.next()) else {
        return Err(table.origin.error(format!("this `[[scene]]` names no region; regions are {names}")));
    };
    for (name, key) in [(&name, &key)].into_iter().chain(second.as_ref().map(|(n, e)| (n, &e.key))) {
        if !Region::NAMES.contains(&name.as_str()) {
            let name = super::source::plain(name, 60);
            let message = format!(
                "unknown key `{name}` in `scene`: neither pivots nor seeds nor a region of this build; regions are {names}"
            );
            return Err(key.error(message));
        }
    }
    if let Some((other, entry)) = second {
        let message = format!("this `[[scene]]` names {name} and {other}: one region each");
        return Err(entry.key.error(message));
    }
    let region = region_from(&format!("scene.{name}"), &name, &key, &node)?;
    Ok(SceneEntry { region, pivots })
}

fn seeds(table: &mut Reader) -> Result<Option<Vec<u64>>, RecipeError> {
    let name = table.name("seeds");
    let Some(node) = table.take("seeds") else { return Ok(None) };
    match &node.value {
        Value::List(items) if !items.is_empty() && items.len() as u64 <= MAX_PIVOTS * 100 => {
            items.iter().map(|item| whole(&name, item, 0..=u64::MAX)).collect::<Result<_, _>>().map(Some)
        }
        _ => Err(wrong(&name, &node, &format!("a list of 1 to {} scene seeds", MAX_PIVOTS * 100))),
    }
}
