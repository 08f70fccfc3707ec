//! A sample in four pictures: image, truth, prediction, error.

use super::super::prediction::{self, Size};
use super::super::report::SampleScores;
use super::super::source::{Item, Maps};
use super::super::{EvaluateError, Options};
use super::page::put;
use crate::dataset::formats::{Pixels, Plane};
use crate::dataset::validity;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use std::path::Path;

/// Longest side of a picture, px.
const MOST_PX: usize = 384;

/// Errors up to each bound, px, have one colour.
const ERRORS: [(f64, [u8; 3]); 6] = [
    (0.5, [20, 60, 140]),
    (1.0, [70, 130, 200]),
    (2.0, [170, 205, 235]),
    (3.0, [250, 205, 120]),
    (8.0, [235, 130, 45]),
    (f64::INFINITY, [170, 20, 25]),
];
const UNPREDICTED: [u8; 3] = [205, 0, 205];
const NOT_COUNTED: [u8; 3] = [128, 128, 128];

/// Names the colours of errors.
pub(super) fn key(page: &mut String) {
    page.push_str("<p class=\"key\">");
    let mut from = 0.0;
    for (to, [r, g, b]) in ERRORS {
        let name = if to.is_finite() { format!("{from} to {to} px") } else { format!("above {from} px") };
        put(page, format_args!("<span><i style=\"background:rgb({r},{g},{b})\"></i>{name}</span>"));
        from = to;
    }
    for ([r, g, b], name) in [(UNPREDICTED, "no prediction"), (NOT_COUNTED, "not counted")] {
        put(page, format_args!("<span><i style=\"background:rgb({r},{g},{b})\"></i>{name}</span>"));
    }
    page.push_str("</p>\n");
}

/// Puts a sample's pictures on the page. Disparities of truth and prediction have one scale.
pub(super) fn sample(
    page: &mut String,
    item: Item<'_>,
    predictions: &Path,
    options: &Options,
    scores: &SampleScores,
) -> Result<(), EvaluateError> {
    let Maps { size, rgb: image, disparity_px: truth, validity: seen } = item.maps()?;
    // The file was read a moment ago; if it has gone since, its pictures are empty, and that is all.
    let predicted = prediction::read(&predictions.join(&scores.file), size, options.png_scale)
        .unwrap_or_else(|_| vec![f64::NAN; truth.len()]);

    let (low, high) = range(&truth);
    let reduced = Reduced::new(size);
    let disparity = |d: f64| if d.is_finite() { ramp((d - low) / (high - low)) } else { UNPREDICTED };
    let counted = |i: usize| matches!(seen[i], validity::VALID | validity::OCCLUDED) && truth[i].is_finite();
    let error = |i: usize| match (predicted[i] - f64::from(truth[i])).abs() {
        _ if !counted(i) => NOT_COUNTED,
        e if !e.is_finite() => UNPREDICTED,
        e => ERRORS.iter().find(|(to, _)| e <= *to).map_or(UNPREDICTED, |(_, colour)| *colour),
    };
    page.push_str("<div class=\"four\">");
    let scale = format!("{:.1} to {high:.1} px", (low * 10.0).round() / 10.0 + 0.0);
    for (name, picture) in [
        ("left image", reduced.picture(|i| [image[3 * i], image[3 * i + 1], image[3 * i + 2]])),
        (&*format!("truth, {scale}"), reduced.picture(|i| disparity(truth[i].into()))),
        (&*format!("prediction, {scale}"), reduced.picture(|i| disparity(predicted[i]))),
        ("error", reduced.picture(error)),
    ] {
        let bytes = picture.encode().map(|png| STANDARD.encode(png)).unwrap_or_default();
        put(
            page,
            format_args!(
                "<figure><img alt=\"{name}\" src=\"data:image/png;base64,{bytes}\"><figcaption>{name}</figcaption>\
                 </figure>"
            ),
        );
    }
    page.push_str("</div>\n");
    Ok(())
}

/// Lowest and highest disparity, at least 1 px apart.
fn range(truth: &[f32]) -> (f64, f64) {
    let finite = || truth.iter().filter(|d| d.is_finite()).map(|d| f64::from(*d));
    let (low, high) = (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
    if low <= high { (low, high.max(low + 1.0)) } else { (0.0, 1.0) }
}

/// Every k-th pixel of every k-th row: labels have no means.
struct Reduced {
    size: Size,
    every: usize,
}

impl Reduced {
    fn new(size: Size) -> Self {
        Self { size, every: (size.width.max(size.height) as usize).div_ceil(MOST_PX).max(1) }
    }

    fn picture(&self, colour: impl Fn(usize) -> [u8; 3]) -> Plane {
        let (width, height) = (self.size.width as usize, self.size.height as usize);
        let columns = width.div_ceil(self.every);
        let rows = height.div_ceil(self.every);
        let pixels = (0..columns * rows)
            .flat_map(|i| colour((i / columns) * self.every * width + (i % columns) * self.every))
            .collect();
        Plane { width: columns as u32, height: rows as u32, pixels: Pixels::Rgb(pixels) }
    }
}

/// A colour whose brightness grows with the value from 0 to 1: Green's cubehelix (2011), start 0.5, -1.5 rotations.
fn ramp(value: f64) -> [u8; 3] {
    let x = value.clamp(0.0, 1.0) * 0.9 + 0.05;
    let angle = std::f64::consts::TAU * (0.5 / 3.0 + 1.0 - 1.5 * x);
    let strength = x * (1.0 - x) / 2.0;
    let (sin, cos) = libm::sincos(angle);
    [[-0.14861, 1.78277], [-0.29227, -0.90649], [1.97294, 0.0]].map(|[a, b]| {
        let level = x + strength * (a * cos + b * sin);
        (level.clamp(0.0, 1.0) * 255.0).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brightness_grows() {
        let light = |v: f64| {
            let [r, g, b] = ramp(v).map(f64::from);
            0.3 * r + 0.59 * g + 0.11 * b
        };
        for i in 0..50 {
            assert!(light(f64::from(i) / 50.0) < light(f64::from(i + 1) / 50.0), "{i}");
        }
    }

    #[test]
    fn pictures_are_small_and_in_place() {
        let size = Size { width: 1000, height: 400 };
        let picture = Reduced::new(size).picture(|i| [(i % 1000 / 4) as u8, (i / 1000 / 2) as u8, 7]);
        assert_eq!((picture.width, picture.height), (334, 134));
        let Pixels::Rgb(values) = picture.pixels else { panic!() };
        let last = &values[values.len() - 3..];
        assert_eq!(last, [(999 / 4) as u8, (399 / 2) as u8, 7]);
        assert_eq!(range(&[f32::NAN]), (0.0, 1.0));
        assert_eq!(range(&[3.0, f32::NAN, 3.25]), (3.0, 4.0));
    }
}
