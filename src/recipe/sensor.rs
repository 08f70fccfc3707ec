//! `[sensor]`: a preset, and single settings of it changed.

use super::node::{Node, Value};
use super::parts::{BANDS, RadianceFile, Sensor, SensorCoding, SensorPreset, word_of};
use super::reader::{Reader, number, wrong};
use super::source::RecipeError;
use crate::render;
use crate::render::sensor::{BandSet, Coding, MAX_MTF, MIN_MTF, Noise, PanSharpening};
use std::fmt::Write as _;
use std::ops::RangeInclusive;

pub(super) fn sensor(mut table: Reader) -> Result<Sensor, RecipeError> {
    let preset = table.word("preset", SensorPreset::ALL)?.unwrap_or(SensorPreset::Worldview3Rgb);
    let samples_per_pixel = table.whole("samples_per_pixel", 1..=4096)?.map_or(16, |(n, _)| n as u32);
    let mut imager = preset.sensor();
    if let Some(bands) = table.word("bands", BANDS)? {
        imager.bands = bands;
    }
    optics(&mut table, &mut imager)?;
    noise(&mut table, &mut imager)?;
    sharpening(&mut table, &mut imager)?;
    let radiance_file = coding(&mut table, &mut imager)?;
    table.finish()?;
    Ok(Sensor { preset, imager, radiance_file, samples_per_pixel })
}

fn optics(table: &mut Reader, imager: &mut render::Sensor) -> Result<(), RecipeError> {
    let optics = &mut imager.optics;
    if let Some(NumberOrNone(mtf)) = number_or_none(table, "mtf_at_nyquist", MIN_MTF..=MAX_MTF)? {
        optics.mtf_at_nyquist = mtf;
        if mtf.is_none() {
            optics.smear_px = 0.0;
        }
    }
    let name = table.name("smear_px");
    if let Some((smear_px, origin)) = table.number("smear_px", 0.0..=2.0)? {
        if smear_px > 0.0 && optics.mtf_at_nyquist.is_none() {
            let message = format!(
                "`{name}` is {smear_px}, but without optics there is no smear: set `{}` to a number in {MIN_MTF} to \
                 {MAX_MTF}, or the smear to 0",
                table.name("mtf_at_nyquist")
            );
            return Err(origin.error(message));
        }
        optics.smear_px = smear_px;
    }
    Ok(())
}

fn noise(table: &mut Reader, imager: &mut render::Sensor) -> Result<(), RecipeError> {
    let noise = &mut imager.noise;
    let stated = table.origin.clone();
    if let Some(NumberOrNone(snr)) = number_or_none(table, "snr", 5.0..=100_000.0)? {
        noise.snr = snr;
    }
    let read = table.number("read_noise", 0.0..=0.05)?;
    if let Some((read, _)) = read {
        noise.read = read;
    } else if noise.snr.is_none() {
        noise.read = 0.0;
    }
    if let Some(snr) = noise.snr
        && noise.read > Noise::most_read(snr)
    {
        let origin = read.map_or(stated, |(_, origin)| origin);
        let (name, most) = (table.name("read_noise"), Noise::most_read(snr));
        return Err(origin.error(format!(
            "`{name}` is {}, but a signal-to-noise ratio of {snr} at reflectance 0.3 leaves at most {most:.6}",
            noise.read
        )));
    }
    noise.column_gain = table.number_or("column_gain", 0.0..=0.05, noise.column_gain)?;
    Ok(())
}

fn sharpening(table: &mut Reader, imager: &mut render::Sensor) -> Result<(), RecipeError> {
    let (ratio_name, offset_name) = (table.name("colour_ratio"), table.name("colour_offset_px"));
    let ratio = table.whole("colour_ratio", 1..=8)?;
    let offset = table.number("colour_offset_px", -2.0..=2.0)?;
    let pan = imager.bands == BandSet::Pan;
    match ratio {
        Some((n, origin)) if n > 1 && pan => {
            let message = format!("`{ratio_name}` is {n}, but a panchromatic image has no colour: 1 is its only ratio");
            return Err(origin.error(message));
        }
        Some((1, _)) => imager.sharpening = None,
        Some((n, _)) => {
            let offset_px = imager.sharpening.map_or(0.0, |s| s.offset_px);
            imager.sharpening = Some(PanSharpening { ratio: n as u32, offset_px });
        }
        None if pan => imager.sharpening = None,
        None => {}
    }
    match (offset, &mut imager.sharpening) {
        (Some((offset_px, _)), Some(sharpening)) => sharpening.offset_px = offset_px,
        (Some((offset_px, origin)), None) if offset_px != 0.0 => {
            let message = format!(
                "`{offset_name}` is {offset_px}, but there are no coarser colour bands: set `{ratio_name}` to 2 to 8, or \
                 the offset to 0"
            );
            return Err(origin.error(message));
        }
        _ => {}
    }
    Ok(())
}

fn coding(table: &mut Reader, imager: &mut render::Sensor) -> Result<RadianceFile, RecipeError> {
    let coding = table.word("coding", SensorCoding::ALL)?.unwrap_or(match imager.coding {
        Coding::Stretched { .. } => SensorCoding::Stretched,
        Coding::Counts => SensorCoding::Counts,
        Coding::Radiance => SensorCoding::Exr,
    });
    let stretch_name = table.name("stretch_percent");
    let stretch = table.take("stretch_percent");
    let gamma = table.number("gamma", 0.2..=1.0)?;
    if coding != SensorCoding::Stretched {
        let places = [
            stretch.as_ref().map(|node| (stretch_name.clone(), &node.origin)),
            gamma.as_ref().map(|(_, origin)| (table.name("gamma"), origin)),
        ];
        if let Some((name, origin)) = places.into_iter().flatten().next() {
            let word = coding.word();
            let message = format!("`{name}` is for `coding = \"8bit\"`, but the coding is \"{word}\": leave it out");
            return Err(origin.error(message));
        }
    }
    imager.coding = match (coding, imager.coding) {
        (SensorCoding::Counts, _) => Coding::Counts,
        (SensorCoding::Float | SensorCoding::Exr, _) => Coding::Radiance,
        (SensorCoding::Stretched, old @ Coding::Stretched { .. }) => old,
        (SensorCoding::Stretched, _) => Coding::WORLDVIEW3_8_BIT,
    };
    if let Coding::Stretched { low_percent, high_percent, gamma: exponent } = &mut imager.coding {
        if let Some(node) = &stretch {
            [*low_percent, *high_percent] = percentiles(&stretch_name, node)?;
        }
        if let Some((gamma, _)) = gamma {
            *exponent = gamma;
        }
    }
    Ok(if coding == SensorCoding::Exr { RadianceFile::Exr } else { RadianceFile::Tiff })
}

/// Two percentiles, the dark end's and the bright end's.
fn percentiles(name: &str, node: &Node) -> Result<[f64; 2], RecipeError> {
    match &node.value {
        Value::List(ends) if ends.len() == 2 => Ok([
            number(&format!("{name}[0]"), &ends[0], 0.0..=20.0)?,
            number(&format!("{name}[1]"), &ends[1], 80.0..=100.0)?,
        ]),
        _ => Err(wrong(name, node, "two percentiles such as [0.3, 99.6]")),
    }
}

/// What a key says: a number, or the word `none`.
struct NumberOrNone(Option<f64>);

fn number_or_none(
    table: &mut Reader,
    key: &'static str,
    range: RangeInclusive<f64>,
) -> Result<Option<NumberOrNone>, RecipeError> {
    let name = table.name(key);
    let Some(node) = table.take(key) else { return Ok(None) };
    match &node.value {
        Value::Text(text) if text == "none" => Ok(Some(NumberOrNone(None))),
        Value::Float(_) | Value::Integer(_) => Ok(Some(NumberOrNone(Some(number(&name, &node, range)?)))),
        _ => {
            let (low, high) = range.into_inner();
            Err(wrong(&name, &node, &format!("a number in {low} to {high} or \"none\"")))
        }
    }
}

/// The table as text: every setting.
pub(super) fn write(sensor: &Sensor, out: &mut String) -> std::fmt::Result {
    let number_or_none = |x: Option<f64>| x.map_or("\"none\"".to_owned(), |x| format!("{x:?}"));
    let imager = &sensor.imager;
    writeln!(out, "\n[sensor]\npreset = \"{}\"", sensor.preset.word())?;
    writeln!(out, "samples_per_pixel = {}", sensor.samples_per_pixel)?;
    writeln!(out, "bands = \"{}\"", word_of(BANDS, &imager.bands))?;
    writeln!(out, "mtf_at_nyquist = {}", number_or_none(imager.optics.mtf_at_nyquist))?;
    writeln!(out, "smear_px = {:?}", imager.optics.smear_px)?;
    writeln!(out, "snr = {}", number_or_none(imager.noise.snr))?;
    writeln!(out, "read_noise = {:?}", imager.noise.read)?;
    writeln!(out, "column_gain = {:?}", imager.noise.column_gain)?;
    match imager.sharpening {
        Some(s) => writeln!(out, "colour_ratio = {}\ncolour_offset_px = {:?}", s.ratio, s.offset_px)?,
        None => writeln!(out, "colour_ratio = 1")?,
    }
    writeln!(out, "coding = \"{}\"", sensor.coding().word())?;
    if let Coding::Stretched { low_percent, high_percent, gamma } = imager.coding {
        writeln!(out, "stretch_percent = [{low_percent:?}, {high_percent:?}]\ngamma = {gamma:?}")?;
    }
    Ok(())
}
