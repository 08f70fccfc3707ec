//! Mistakes that are likely when predictions do not fit: opposite sign, a scale, half a pixel, a flip.
//!
//! A hypothesis changes the predictions of a sample; it is convincing where the median error of the pixels that both
//! cameras see falls far below what it was. A constant would fit nothing but flat ground, so what explains a sample must
//! also beat the best constant.

use super::truth::Truth;
use serde::Serialize;

/// Pixels that a sample is judged by, spread evenly.
const MOST_PIXELS: usize = 1 << 16;
/// Fewer than these tell nothing.
const LEAST_PIXELS: usize = 64;

/// What a mistake may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum MistakeKind {
    /// `u_R - u_L` in place of `u_L - u_R`.
    Sign,
    /// `|d|` in place of `d`.
    Absolute,
    /// All multiplied by something.
    Scale,
    /// Half a pixel off.
    HalfPixel,
    /// A whole pixel off.
    WholePixel,
    /// `doffs_px` added or not taken away.
    Doffs,
    /// Off by something else.
    Offset,
    /// Rows from the bottom up.
    UpsideDown,
    /// Columns from right to left.
    Mirrored,
    /// Many pixels hold one number that is far from the truth.
    Constant,
}

/// A likely mistake of one sample, with its number: the factor or summand that would mend it, or the constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Suspicion {
    pub(super) kind: MistakeKind,
    pub(super) value: f64,
}

/// A likely mistake of the whole set of predictions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mistake {
    /// What it is.
    pub mistake: MistakeKind,
    /// In how many samples it is likely.
    pub samples: usize,
    /// Median over them of the factor, of what is missing, px, or of the constant; 1 where there is no number.
    pub value: f64,
    /// The sentence for people.
    pub told: String,
}

/// What is wrong with a sample's predictions, if anything.
pub(super) fn suspicions(truth: &Truth, predicted: &[f64]) -> Vec<Suspicion> {
    let width = truth.size.width as usize;
    let counted: Vec<usize> =
        (0..predicted.len()).filter(|i| truth.occluded(*i) == Some(false) && predicted[*i].is_finite()).collect();
    let every = counted.len().div_ceil(MOST_PIXELS).max(1);
    let at: Vec<usize> = counted.into_iter().step_by(every).collect();
    if at.len() < LEAST_PIXELS {
        return Vec::new();
    }
    let pixels: Vec<(f64, f64)> = at.iter().map(|i| (f64::from(truth.disparity_px[*i]), predicted[*i])).collect();
    let direct = median(pixels.iter().map(|(d, p)| (p - d).abs()));
    let mut out: Vec<Suspicion> = constant(&pixels).into_iter().collect();

    let middle = median(pixels.iter().map(|(d, _)| *d));
    let spread = median(pixels.iter().map(|(d, _)| (d - middle).abs()));
    let residual = |f: &dyn Fn(f64) -> f64| median(pixels.iter().map(|(d, p)| (f(*p) - d).abs()));
    // Each with what is left of the median error, if that convinces.
    let mut likely: Vec<(f64, Suspicion)> = Vec::new();
    let mut propose = |kind, value, left: f64, most: f64| {
        if left < most {
            likely.push((left, Suspicion { kind, value }));
        }
    };
    if is_absolute(&pixels) {
        propose(MistakeKind::Absolute, 1.0, 0.0, f64::INFINITY);
    }
    let factor = median(pixels.iter().filter(|(_, p)| *p != 0.0).map(|(d, p)| d / p));
    if (factor + 1.0).abs() < 0.05 {
        propose(MistakeKind::Sign, -1.0, residual(&|p| -p), (direct / 2.0).min(spread / 2.0));
    } else if (factor - 1.0).abs() > 0.03 && factor.is_finite() {
        propose(MistakeKind::Scale, factor, residual(&|p| p * factor), (direct / 4.0).min(spread / 2.0));
    }
    let summand = median(pixels.iter().map(|(d, p)| d - p));
    if summand.abs() > 0.3 {
        let near = |x: f64| (summand.abs() - x.abs()).abs() <= 0.15;
        let kind = match () {
            () if near(0.5) => MistakeKind::HalfPixel,
            () if near(1.0) => MistakeKind::WholePixel,
            () if truth.doffs_px.abs() > 2.0 && near(truth.doffs_px) => MistakeKind::Doffs,
            () => MistakeKind::Offset,
        };
        let most = if summand.abs() <= 1.2 { direct / 2.0 } else { (direct / 2.0).min(spread / 2.0) };
        propose(kind, summand, residual(&|p| p + summand), most);
    }
    for (kind, flip) in [(MistakeKind::UpsideDown, predicted.len() - width), (MistakeKind::Mirrored, width - 1)] {
        // Upside down, the row goes over to its counterpart and the column stays; mirrored, the other way round.
        let other = |i: usize| {
            let column = i % width;
            if kind == MistakeKind::UpsideDown { flip - (i - column) + column } else { i - column + flip - column }
        };
        let left = median(
            at.iter()
                .map(|i| (predicted[other(*i)] - f64::from(truth.disparity_px[*i])).abs())
                .filter(|e| e.is_finite()),
        );
        propose(kind, 1.0, left, (direct / 4.0).min(spread / 2.0));
    }
    out.extend(likely.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, s)| s));
    out
}

/// A disparity of either sign whose negative half is predicted as positive, while the positive half fits.
fn is_absolute(pixels: &[(f64, f64)]) -> bool {
    let (below, above): (Vec<_>, Vec<_>) = pixels.iter().filter(|(d, _)| d.abs() > 1.0).partition(|(d, _)| *d < 0.0);
    if below.len().min(above.len()) < LEAST_PIXELS.max(pixels.len() / 100) {
        return false;
    }
    let direct = |set: &[&(f64, f64)]| median(set.iter().map(|(d, p)| (p - d).abs()));
    let turned = |set: &[&(f64, f64)]| median(set.iter().map(|(d, p)| (p + d).abs()));
    turned(&below) < direct(&below) / 4.0 && direct(&above) < turned(&above) / 4.0
}

/// The number that most pixels hold, where they are many and it is far from their truth.
fn constant(pixels: &[(f64, f64)]) -> Option<Suspicion> {
    let mut sorted = pixels.to_vec();
    sorted.sort_by(|a, b| a.1.total_cmp(&b.1));
    let run = sorted.chunk_by(|a, b| a.1 == b.1).max_by_key(|run| run.len())?;
    let far = median(run.iter().map(|(d, p)| (p - d).abs())) > 3.0;
    (run.len() * 50 > pixels.len() && far).then(|| Suspicion { kind: MistakeKind::Constant, value: run[0].1 })
}

/// The lower median; infinite where there is none.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    if values.is_empty() {
        return f64::INFINITY;
    }
    let middle = (values.len() - 1) / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Puts the samples' suspicions together: the most frequent first.
pub(super) fn together(suspicions: &[Suspicion]) -> Vec<Mistake> {
    let mut kinds: Vec<MistakeKind> = suspicions.iter().map(|s| s.kind).collect();
    kinds.sort_unstable();
    kinds.dedup();
    let mut out: Vec<Mistake> = kinds
        .into_iter()
        .map(|mistake| {
            let values = || suspicions.iter().filter(|s| s.kind == mistake).map(|s| s.value);
            let value = median(values());
            Mistake { mistake, samples: values().count(), value, told: told(mistake, value) }
        })
        .collect();
    out.sort_by_key(|m| std::cmp::Reverse(m.samples));
    out
}

fn told(kind: MistakeKind, value: f64) -> String {
    let side = if value > 0.0 { "low" } else { "high" };
    let px = value.abs();
    match kind {
        MistakeKind::Sign => {
            "the sign: predictions fit when negated; disparity here is u_L - u_R, so that u_R = u_L - d".to_owned()
        }
        MistakeKind::Absolute => {
            "absolute values: negative disparities are predicted as positive ones; the truth is signed".to_owned()
        }
        MistakeKind::Scale => format!("the scale: predictions fit when multiplied by {value:.6}{}", scale_hint(value)),
        MistakeKind::HalfPixel => {
            format!("half a pixel: predictions are {px:.2} px too {side}; pixel centres stand at whole numbers here")
        }
        MistakeKind::WholePixel => format!("a whole pixel: predictions are {px:.2} px too {side}"),
        MistakeKind::Doffs => format!(
            "doffs: predictions are {px:.2} px too {side}, as much as doffs_px of camera.json; d = f B / depth - doffs"
        ),
        MistakeKind::Offset => format!("an offset: predictions are {px:.2} px too {side}"),
        MistakeKind::UpsideDown => {
            "upside down: predictions fit with the last row first; PFM begins with the last row, the others do not"
                .to_owned()
        }
        MistakeKind::Mirrored => "mirrored: predictions fit with the last column first".to_owned(),
        MistakeKind::Constant => format!(
            "no value: many predictions are exactly {value}, far from the truth; if that stands for no prediction, \
             write NaN, here it counts as a number"
        ),
    }
}

fn scale_hint(factor: f64) -> &'static str {
    let near = |x: f64| (factor.abs() / x - 1.0).abs() < 0.03;
    match () {
        () if near(1.0 / 16.0) => ": OpenCV's matchers give 16ths of a pixel",
        () if near(1.0 / 256.0) => ": 16-bit files hold 256ths of a pixel",
        () if near(8.0) => ": a 16-bit PNG in 32nds of a pixel is read with --png-scale 32",
        () if near(256.0) => ": a 16-bit PNG in whole pixels is read with --png-scale 1",
        () if near(2.0) || near(4.0) => ": a map that is enlarged needs its disparities multiplied too",
        () if near(0.5) || near(0.25) => ": a map that is reduced needs its disparities divided too",
        () => "",
    }
}

#[cfg(test)]
mod tests {
    use super::super::prediction::Size;
    use super::*;

    const WIDTH: u32 = 40;
    const HEIGHT: u32 = 30;

    /// A surface that is nowhere symmetric, between two disparities.
    fn truth(low: f32, high: f32, doffs_px: f64) -> Truth {
        let pixels = (WIDTH * HEIGHT) as usize;
        let at = |i: usize| {
            let (u, v) = ((i % WIDTH as usize) as f32 / WIDTH as f32, (i / WIDTH as usize) as f32 / HEIGHT as f32);
            low + (high - low) * (0.5 * u * u + 0.4 * v * v * v + 0.1 * u * v)
        };
        Truth {
            size: Size { width: WIDTH, height: HEIGHT },
            disparity_px: (0..pixels).map(at).collect(),
            validity: (0..pixels).map(|i| if i % 11 == 0 { 2 } else { 1 }).collect(),
            jumps: vec![false; pixels],
            jump_distances: vec![u32::MAX; pixels],
            bins: [const { None }; 7],
            doffs_px,
        }
    }

    /// Truth with an error of up to 0.4 px, then changed.
    fn made(truth: &Truth, change: impl Fn(f64) -> f64) -> Vec<f64> {
        let noise = |i: usize| f64::from((i * 7919 % 81) as u32) / 100.0 - 0.4;
        truth.disparity_px.iter().enumerate().map(|(i, d)| change(f64::from(*d) + noise(i))).collect()
    }

    fn found(truth: &Truth, predicted: &[f64]) -> Option<(MistakeKind, f64)> {
        let all = suspicions(truth, predicted);
        assert!(all.len() < 2, "{all:?}");
        all.first().map(|s| (s.kind, s.value))
    }

    #[test]
    fn mistakes_are_recognised() {
        for (low, high) in [(300.0, 420.0), (-60.0, 90.0), (-90.0, -20.0)] {
            let t = truth(low, high, 33.0);
            let kind = |change: &dyn Fn(f64) -> f64| found(&t, &made(&t, change)).map(|f| f.0);
            assert_eq!(kind(&|d| d), None, "{low}: good predictions");
            assert_eq!(kind(&|d| d + 0.2), None);
            assert_eq!(kind(&|d| -d), Some(MistakeKind::Sign), "{low}");
            assert_eq!(kind(&|d| d * 16.0), Some(MistakeKind::Scale));
            assert_eq!(kind(&|d| d / 256.0), Some(MistakeKind::Scale));
            assert_eq!(kind(&|d| d + 0.5), Some(MistakeKind::HalfPixel), "{low}");
            assert_eq!(kind(&|d| d - 1.0), Some(MistakeKind::WholePixel));
            assert_eq!(kind(&|d| d + 33.0), Some(MistakeKind::Doffs));
            assert_eq!(kind(&|d| d - 20.0), Some(MistakeKind::Offset));
            assert_eq!(kind(&|_| high.into()), Some(MistakeKind::Constant));
            let flip = |index: &dyn Fn(usize, usize) -> usize| {
                let p = made(&t, |d| d);
                let (w, h) = (WIDTH as usize, HEIGHT as usize);
                let q: Vec<f64> = (0..w * h).map(|i| p[index(i % w, i / w)]).collect();
                found(&t, &q).map(|f| f.0)
            };
            let (w, h) = (WIDTH as usize, HEIGHT as usize);
            assert_eq!(flip(&|u, v| (h - 1 - v) * w + u), Some(MistakeKind::UpsideDown));
            assert_eq!(flip(&|u, v| v * w + w - 1 - u), Some(MistakeKind::Mirrored));
        }
        let t = truth(-60.0, 90.0, 0.0);
        assert_eq!(found(&t, &made(&t, f64::abs)), Some((MistakeKind::Absolute, 1.0)));
        let (_, factor) = found(&t, &made(&t, |d| d / 256.0)).unwrap();
        assert!((factor - 256.0).abs() < 3.0, "{factor}");
        let (_, missing) = found(&t, &made(&t, |d| d - 0.5)).unwrap();
        assert!((missing - 0.5).abs() < 0.05, "{missing}");
    }

    /// A bad matcher is bad, not mistaken.
    #[test]
    fn noise_is_no_mistake() {
        let t = truth(100.0, 180.0, 12.0);
        let mut bytes = vec![0; t.disparity_px.len() * 2];
        blake3::Hasher::new().update(b"noise").finalize_xof().fill(&mut bytes);
        let noise: Vec<f64> =
            bytes.chunks(2).map(|b| f64::from(u16::from_le_bytes([b[0], b[1]])) / 65536.0 * 80.0 + 100.0).collect();
        assert_eq!(found(&t, &noise), None);
        let broad: Vec<f64> = noise.iter().zip(&t.disparity_px).map(|(n, d)| (n - 140.0) + f64::from(*d)).collect();
        assert_eq!(found(&t, &broad), None);
        assert_eq!(found(&t, &vec![f64::NAN; noise.len()]), None);
    }

    #[test]
    fn a_number_that_stands_for_nothing_is_named() {
        let t = truth(100.0, 180.0, 0.0);
        let mut p = made(&t, |d| d);
        p.iter_mut().step_by(10).for_each(|x| *x = -999.0);
        let all = suspicions(&t, &p);
        assert_eq!(all, [Suspicion { kind: MistakeKind::Constant, value: -999.0 }]);
        let told = &together(&[all[0], all[0]])[0];
        assert_eq!((told.samples, told.value), (2, -999.0));
        assert!(told.told.contains("exactly -999") && told.told.contains("write NaN"), "{}", told.told);
    }
}
