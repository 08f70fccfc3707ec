//! Least-squares matching of the two pictures of a pair through its disparity.

use glam::DVec2;
use satseed::labels::{Validity, ViewLabels};
use satseed::render::Image;
use satseed::render::sensor::ImagePixels;

/// Side of the windows in which gain and offset are fitted, px.
const WINDOW_PX: usize = 32;
/// Mean gradient from which a pixel counts as textured, grey levels a pixel.
const TEXTURE: f64 = 2.0;
/// Rows and columns beside a pixel that must be as whole as it is: what optics and colours spread.
const MARGIN_PX: usize = 2;

/// An image of one channel.
pub(crate) struct Grey {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) data: Vec<f64>,
}

impl Grey {
    /// The mean of an image's bands.
    pub(crate) fn of(image: &Image) -> Self {
        let values: Vec<f64> = match &image.pixels {
            ImagePixels::Bytes(values) => values.iter().map(|x| f64::from(*x)).collect(),
            ImagePixels::Counts(values) => values.iter().map(|x| f64::from(*x)).collect(),
            ImagePixels::Radiance(values) => values.iter().map(|x| f64::from(*x)).collect(),
        };
        let mean = |pixel: &[f64]| pixel.iter().sum::<f64>() / pixel.len() as f64;
        let data = values.chunks(image.channels).map(mean).collect();
        Self { width: image.width as usize, height: image.height as usize, data }
    }

    /// The same image with other values.
    pub(crate) fn map(&self, value: impl Fn(f64) -> f64) -> Self {
        Self { data: self.data.iter().map(|x| value(*x)).collect(), ..*self }
    }

    fn at(&self, u: usize, v: usize) -> f64 {
        self.data[v * self.width + u]
    }

    fn gradient(&self, u: usize, v: usize) -> DVec2 {
        DVec2::new(self.at(u + 1, v) - self.at(u - 1, v), self.at(u, v + 1) - self.at(u, v - 1)) / 2.0
    }
}

/// Values between pixels by cubic B-splines through all of them (Unser, Aldroubi and Eden 1991). A cubic of four pixels alone
/// (Catmull and Rom) moves fine texture by up to 0.01 px, and on even ground, where all disparities have one fraction, that
/// does not average out.
struct Spline(Grey);

impl Spline {
    fn through(image: &Grey) -> Self {
        let mut coefficients = Grey { data: image.data.clone(), ..*image };
        let (width, height) = (image.width, image.height);
        let data = &mut coefficients.data;
        for v in 0..height {
            prefilter(data, v * width, 1, width);
        }
        for u in 0..width {
            prefilter(data, u, width, height);
        }
        Self(coefficients)
    }

    /// `None` near the border.
    fn at(&self, u: f64, v: f64) -> Option<f64> {
        let (i, j) = (libm::floor(u), libm::floor(v));
        let inside = |first: f64, size: usize| first >= 1.0 && first + 2.0 < size as f64;
        if !inside(i, self.0.width) || !inside(j, self.0.height) {
            return None;
        }
        let (columns, rows) = (basis(u - i), basis(v - j));
        let (i, j) = (i as usize - 1, j as usize - 1);
        let row = |y: usize| (0..4).map(|x| columns[x] * self.0.at(i + x, j + y)).sum::<f64>();
        Some((0..4).map(|y| rows[y] * row(y)).sum())
    }
}

/// Turns a line of values into a spline's coefficients: the recursion there and back.
fn prefilter(data: &mut [f64], first: usize, step: usize, count: usize) {
    let pole = 3.0_f64.sqrt() - 2.0;
    let at = |k: usize| first + k * step;
    // The line goes on in its mirror image; after 30 pixels that counts for nothing.
    let mut power = 1.0;
    let mut sum = 0.0;
    for k in 0..count.min(30) {
        sum += power * data[at(k)];
        power *= pole;
    }
    data[at(0)] = sum;
    for k in 1..count {
        data[at(k)] += pole * data[at(k - 1)];
    }
    let last = count - 1;
    data[at(last)] = pole / (pole * pole - 1.0) * (data[at(last)] + pole * data[at(last - 1)]);
    for k in (0..last).rev() {
        data[at(k)] = pole * (data[at(k + 1)] - data[at(k)]);
    }
    for k in 0..count {
        data[at(k)] *= 6.0;
    }
}

/// Weights of the four neighbours at -1, 0, 1, 2 for a place in 0..1.
fn basis(s: f64) -> [f64; 4] {
    let (s2, s3) = (s * s, s * s * s);
    [1.0 - 3.0 * s + 3.0 * s2 - s3, 4.0 - 6.0 * s2 + 3.0 * s3, 1.0 + 3.0 * (s + s2 - s3), s3].map(|w| w / 6.0)
}

/// Whether gain and offset are estimated with the shift.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Levels {
    /// Grey values of both pictures are the same.
    Equal,
    /// In each window the right picture has a gain and an offset of its own.
    Fitted,
}

/// What was found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Match {
    /// How far the right picture, fetched by the disparity, lies off the left one, px: it shows at `x` what the left one
    /// shows at `x + shift`.
    pub(crate) shift_px: DVec2,
    /// Textured pixels that it rests on.
    pub(crate) textured: usize,
}

/// A pixel's part of the sums.
struct Sample {
    /// Gradient of both pictures' mean, grey levels a pixel.
    gradient: DVec2,
    /// That mean.
    level: f64,
    /// Right minus left.
    difference: f64,
    window: usize,
}

/// What of a pair is matched.
#[derive(Clone, Copy)]
pub(crate) struct Counted<'a> {
    /// Labels of the left view, with its edges.
    pub(crate) labels: &'a ViewLabels,
    /// Left pixels whose surface sends both views one radiance: no mirrors.
    pub(crate) matt: &'a [bool],
    /// How far disparity may depart from a straight line over three pixels, px. A pixel beside a step is blurred with the higher
    /// surface, so its texture moves as that one does: even steps far below those of the edge label pull the shift up.
    pub(crate) step_px: f64,
}

impl Counted<'_> {
    /// Pixels that count by themselves and with all of their surroundings.
    fn whole(&self, width: usize, height: usize) -> Vec<bool> {
        let edge = self.labels.edge.as_ref().expect("asked");
        let d = |at: usize| f64::from(self.labels.disparity_px[at]);
        let valid = |at: usize| self.labels.validity[at] == Validity::Valid as u8;
        let straight = |at: usize, step: usize| {
            valid(at - step) && valid(at + step) && (d(at - step) - 2.0 * d(at) + d(at + step)).abs() <= self.step_px
        };
        let good = |at: usize| valid(at) && edge[at] == 0 && self.matt[at] && straight(at, 1) && straight(at, width);
        let inside = |at: usize, size: usize| at > MARGIN_PX && at + MARGIN_PX + 1 < size;
        let near = |at: usize| at - MARGIN_PX..=at + MARGIN_PX;
        let whole = |(u, v): (usize, usize)| {
            inside(u, width) && inside(v, height) && near(v).all(|v| near(u).all(|u| good(v * width + u)))
        };
        (0..width * height).map(|at| whole((at % width, at / width))).collect()
    }

    /// The right picture where the left pixels' points are, moved by a further shift; NaN where there is none.
    fn warped(&self, right: &Spline, shift: DVec2) -> Grey {
        let Grey { width, height, .. } = right.0;
        let value = |at: usize| {
            let (u, v) = ((at % width) as f64, (at / width) as f64);
            let there = || right.at(u - f64::from(self.labels.disparity_px[at]) + shift.x, v + shift.y);
            (self.labels.validity[at] == Validity::Valid as u8).then(there).flatten().unwrap_or(f64::NAN)
        };
        Grey { width, height, data: (0..width * height).map(value).collect() }
    }
}

/// Matches two pictures where they may be.
///
/// The model is that of least-squares matching (Gruen 1985): right - left = g . s + a * level + b, with one shift s for the
/// picture and a gain and an offset for each window, solved together. What is found moves the right picture, until nothing is
/// left to find (Lucas and Kanade 1981): so the finite differences that stand for g do not scale the answer. g and level are
/// means of both pictures, so that noise in one of them pulls neither shift nor gain towards 0.
pub(crate) fn matched(left: &Grey, right: &Grey, counted: Counted, levels: Levels) -> Match {
    let whole = counted.whole(left.width, left.height);
    let right = Spline::through(right);
    let mut shift_px = DVec2::ZERO;
    let mut textured = 0;
    for _ in 0..8 {
        let samples = samples(left, &counted.warped(&right, -shift_px), &whole);
        textured = samples.iter().filter(|s| s.gradient.length() >= TEXTURE).count();
        let step = robust_shift(&samples, levels);
        shift_px += step;
        if !shift_px.is_finite() || step.length() < 1e-4 {
            break;
        }
    }
    Match { shift_px, textured }
}

fn samples(left: &Grey, warped: &Grey, whole: &[bool]) -> Vec<Sample> {
    let windows = left.width.div_ceil(WINDOW_PX);
    let sample = |at: usize| {
        let (u, v) = (at % left.width, at / left.width);
        let (here, there) = (left.at(u, v), warped.at(u, v));
        let gradient = (left.gradient(u, v) + warped.gradient(u, v)) / 2.0;
        let window = v / WINDOW_PX * windows + u / WINDOW_PX;
        let sample = Sample { gradient, level: f64::midpoint(here, there), difference: there - here, window };
        (gradient.is_finite() && there.is_finite()).then_some(sample)
    };
    (0..whole.len()).filter(|at| whole[*at]).filter_map(sample).collect()
}

/// Weighted sums over a window's pixels.
#[derive(Clone, Copy, Debug, Default)]
struct Window {
    weight: f64,
    gradient: DVec2,
    level: f64,
    difference: f64,
    level_level: f64,
    level_gradient: DVec2,
    level_difference: f64,
}

/// The shift of all windows, by weighted least squares: Tukey's biweight takes what moves between views (glints, mixed
/// pixels, leaves) out of the sums. Each window's gain and offset are eliminated from the normal equations.
fn robust_shift(samples: &[Sample], levels: Levels) -> DVec2 {
    let mut shift = DVec2::ZERO;
    let count = samples.iter().map(|s| s.window + 1).max().unwrap_or(0);
    let mut weights = vec![1.0; samples.len()];
    for _ in 0..12 {
        let mut windows = vec![Window::default(); count];
        for (s, w) in samples.iter().zip(&weights) {
            let sum = &mut windows[s.window];
            sum.weight += w;
            sum.gradient += *w * s.gradient;
            sum.level += w * s.level;
            sum.difference += w * s.difference;
        }
        for window in &mut windows {
            // Without levels nothing is taken off.
            let scale = if levels == Levels::Fitted { 1.0 / window.weight.max(1e-9) } else { 0.0 };
            (window.gradient, window.difference) = (window.gradient * scale, window.difference * scale);
            window.level *= scale;
        }
        let centred = |s: &Sample| {
            let mean = &windows[s.window];
            (s.gradient - mean.gradient, s.level - mean.level, s.difference - mean.difference, s.window)
        };
        let mut sums = windows.clone();
        let (mut a, mut b, mut c, mut p) = (0.0, 0.0, 0.0, DVec2::ZERO);
        for (s, w) in samples.iter().zip(&weights) {
            let (g, m, t, window) = centred(s);
            a += w * g.x * g.x;
            b += w * g.x * g.y;
            c += w * g.y * g.y;
            p += w * t * g;
            let sum = &mut sums[window];
            sum.level_level += w * m * m;
            sum.level_gradient += w * m * g;
            sum.level_difference += w * m * t;
        }
        if levels == Levels::Fitted {
            for sum in sums.iter_mut().filter(|sum| sum.level_level > 0.0) {
                let (g, t) = (sum.level_gradient, sum.level_difference / sum.level_level);
                a -= g.x * g.x / sum.level_level;
                b -= g.x * g.y / sum.level_level;
                c -= g.y * g.y / sum.level_level;
                p -= g * t;
            }
        }
        shift = DVec2::new(c * p.x - b * p.y, a * p.y - b * p.x) / (a * c - b * b);
        let gain = |window: usize| {
            let sum = &sums[window];
            let known = levels == Levels::Fitted && sum.level_level > 0.0;
            if known { (sum.level_difference - sum.level_gradient.dot(shift)) / sum.level_level } else { 0.0 }
        };
        let gains: Vec<f64> = (0..count).map(gain).collect();
        let residuals: Vec<f64> = samples
            .iter()
            .map(|s| {
                let (g, m, t, window) = centred(s);
                t - g.dot(shift) - gains[window] * m
            })
            .collect();
        let mut sizes: Vec<f64> = residuals.iter().map(|r| r.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let Some(median) = sizes.get(sizes.len() / 2) else { return DVec2::NAN };
        let limit = 4.685 * 1.4826 * median.max(0.1);
        for (weight, residual) in weights.iter_mut().zip(residuals) {
            let r = residual / limit;
            *weight = if r.abs() < 1.0 { (1.0 - r * r) * (1.0 - r * r) } else { 0.0 };
        }
    }
    shift
}
