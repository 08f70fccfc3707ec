//! A recipe as text again: the resolved recipe that stands in a dataset.

use super::parts::{Azimuths, Baselines, Datum, PivotAlongBaseline, Pivots, Series};
use super::source::{RecipeError, plain};
use super::{Recipe, SceneEntry, versions};
use satseed_generators::Region;
use std::fmt::Write as _;
use toml::Value;

impl Recipe {
    /// The resolved recipe as TOML: every value stands in it, no `extends`, and the versions of generators and stages.
    ///
    /// Reading it gives an equal recipe; equal recipes give equal text.
    pub fn to_toml(&self) -> String {
        let mut out = String::from("# The resolved recipe: it and the versions at its end decide every byte.\n");
        self.write_head(&mut out).expect("writing to a String cannot fail");
        for scene in &self.scenes {
            write_scene(&mut out, scene).expect("writing to a String cannot fail");
        }
        out.push_str(&versions::tables(self));
        out
    }

    fn write_head(&self, out: &mut String) -> std::fmt::Result {
        let camera = &self.camera;
        writeln!(out, "seed = {}\n", self.seed)?;
        writeln!(out, "[camera]\naltitude_m = {:?}\ngsd_m = {:?}", camera.altitude_m, camera.gsd_m)?;
        writeln!(out, "size_px = [{}, {}]", camera.size_px[0], camera.size_px[1])?;
        match camera.datum {
            Datum::None => writeln!(out, "datum = \"none\"")?,
            Datum::Pivot => writeln!(out, "datum = \"pivot\"")?,
            Datum::Lowest => writeln!(out, "datum = \"lowest\"")?,
            Datum::HeightM(z) => writeln!(out, "datum = {z:?}")?,
        }
        writeln!(out, "\n[acquisition]")?;
        let acquisition = &self.acquisition;
        match &acquisition.baselines {
            Baselines::LengthM(series) => writeln!(out, "baseline_m = {}", series_text(series))?,
            Baselines::ConvergenceDeg(series) => writeln!(out, "convergence_deg = {}", series_text(series))?,
        }
        match &acquisition.azimuths {
            Azimuths::List(values) => writeln!(out, "azimuth_deg = {values:?}")?,
            Azimuths::Drawn { from_deg, to_deg, draws } => {
                writeln!(out, "azimuth_deg = {{ from = {from_deg:?}, to = {to_deg:?}, draws = {draws} }}")?;
            }
        }
        match acquisition.pivot_along_baseline {
            PivotAlongBaseline::Fixed(t) => writeln!(out, "pivot_along_baseline = {t:?}")?,
            PivotAlongBaseline::Random => writeln!(out, "pivot_along_baseline = \"random\"")?,
        }
        if let Some(n) = acquisition.pairs_per_pivot {
            writeln!(out, "pairs_per_pivot = {n}")?;
        }
        let light = &self.light;
        writeln!(out, "\n[light]")?;
        let (elevation, azimuth) = (light.sun_elevation_deg, light.sun_azimuth_deg);
        writeln!(out, "sun = {{ elevation_deg = {elevation:?}, azimuth_deg = {azimuth:?} }}")?;
        writeln!(out, "aerosol_optical_depth = {:?}", light.aerosol_optical_depth)?;
        writeln!(out, "ambient = \"{}\"", light.ambient.word())?;
        super::sensor::write(&self.sensor, out)?;
        let labels: Vec<_> = self.labels.write.iter().map(|l| l.word()).collect();
        writeln!(out, "\n[labels]\nwrite = {labels:?}")?;
        writeln!(out, "disparity_precision = \"{}\"", self.labels.disparity_precision.word())?;
        writeln!(out, "\n[split]\nrule = \"{}\"", self.split.word())
    }
}

fn series_text(series: &Series) -> String {
    match series {
        Series::List(values) => format!("{values:?}"),
        Series::Steps { from, to, steps } => format!("{{ from = {from:?}, to = {to:?}, steps = {steps} }}"),
    }
}

fn write_scene(out: &mut String, scene: &SceneEntry) -> std::fmt::Result {
    writeln!(out, "\n[[scene]]")?;
    writeln!(out, "{} = {}", scene.region.name(), parameters_text(&scene.region))?;
    match &scene.pivots {
        Pivots::Count(n) => writeln!(out, "pivots = {n}"),
        Pivots::Seeds(seeds) => writeln!(out, "seeds = {seeds:?}"),
    }
}

/// All parameters of a region as an inline TOML table with sorted keys: equal parameters give equal text.
pub(crate) fn parameters_text(region: &Region) -> String {
    let Value::Table(table) = parameters(region) else { return "{}".to_owned() };
    let mut entries: Vec<_> = table.iter().map(|(key, v)| format!("{key} = {}", inline(v))).collect();
    entries.sort();
    format!("{{ {} }}", entries.join(", "))
}

/// Whether the variant is one of the region's parameters.
pub(super) fn has_variants(region: &Region) -> bool {
    parameters(region).get("variant").is_some()
}

/// The region with another variant.
pub(super) fn with_variant(region: &Region, variant: &str) -> Result<Region, RecipeError> {
    if region.variant() == variant {
        return Ok(region.clone());
    }
    let refused = |why: &str| {
        let (name, variant) = (region.name(), plain(variant, 60));
        RecipeError::placeless(format!("region {name} has no variant `{variant}`: {why}"))
    };
    let mut parameters = parameters(region);
    match parameters.get_mut("variant") {
        Some(value) => *value = Value::String(variant.to_owned()),
        None => return Err(refused(&format!("its only one is {}", region.variant()))),
    }
    let tagged = Value::Table([(region.name().to_owned(), parameters)].into_iter().collect());
    let region = tagged.try_into::<Region>().map_err(|e| refused(e.message()))?;
    region.check().map_err(|e| refused(&e.to_string()))?;
    Ok(region)
}

/// The parameters of a region that differ from the defaults of its variant, `key` and inline TOML; nested keys dotted.
pub(crate) fn changed_parameters(region: &Region) -> Vec<(String, String)> {
    let mut defaults = Region::by_name(region.name()).map_or(Value::Table(toml::Table::new()), |r| parameters(&r));
    let own = parameters(region);
    if let (Value::Table(defaults), Some(variant)) = (&mut defaults, own.get("variant")) {
        defaults.insert("variant".to_owned(), variant.clone());
    }
    let mut changed = Vec::new();
    differences("", &own, &defaults, &mut changed);
    changed.sort();
    changed
}

fn differences(path: &str, own: &Value, default: &Value, out: &mut Vec<(String, String)>) {
    match (own, default) {
        (Value::Table(own), Value::Table(default)) => {
            for (key, value) in own {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                match default.get(key) {
                    Some(default) => differences(&path, value, default, out),
                    None => out.push((path, inline(value))),
                }
            }
        }
        (own, default) if own != default => out.push((path.to_owned(), inline(own))),
        _ => {}
    }
}

fn parameters(region: &Region) -> Value {
    let tagged = Value::try_from(region).expect("parameter structs hold numbers, words, lists and tables only");
    match tagged {
        Value::Table(table) => table.into_iter().next().map_or(Value::Table(toml::Table::new()), |(_, v)| v),
        other => other,
    }
}

/// A value as inline TOML without blanks, so that it is one word of a seed list.
fn inline(value: &Value) -> String {
    match value {
        Value::Table(table) => {
            let mut entries: Vec<_> = table.iter().map(|(key, v)| format!("{key}={}", inline(v))).collect();
            entries.sort();
            format!("{{{}}}", entries.join(","))
        }
        Value::Array(items) => format!("[{}]", items.iter().map(inline).collect::<Vec<_>>().join(",")),
        Value::Float(x) => format!("{x:?}"),
        other => other.to_string(),
    }
}
