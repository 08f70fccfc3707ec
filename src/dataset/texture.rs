//! Local contrast of an image: how much there is to match.

/// Half a side of the window less the middle pixel: the window has 9 x 9 pixels, less at the image's border.
const REACH: usize = 4;
/// Steps of contrast a grey level.
const STEPS_PER_LEVEL: f64 = 16.0;
/// Steps that there can be: a deviation is at most half the range of 255 levels.
pub(crate) const STEPS: usize = 2041;

/// Standard deviation of (R + G + B) / 3 in the window around each pixel, in steps of 1/16 grey level, rounded down.
///
/// Sums of whole numbers: the same everywhere, and whichever way they are summed.
pub(crate) fn contrast_steps(rgb: &[u8], width: usize) -> Vec<u16> {
    let height = rgb.len() / 3 / width;
    let (mut sums, mut squares) = (vec![0_u64; width + 1], vec![0_u64; width + 1]);
    let mut columns = vec![(0_u32, 0_u64); width];
    let grey = |u: usize, v: usize| rgb[3 * (v * width + u)..][..3].iter().map(|c| u32::from(*c)).sum::<u32>();
    let mut out = Vec::with_capacity(width * height);
    let (mut top, mut bottom) = (0, 0);
    for v in 0..height {
        while bottom < (v + REACH + 1).min(height) {
            for (u, column) in columns.iter_mut().enumerate() {
                let g = grey(u, bottom);
                *column = (column.0 + g, column.1 + u64::from(g * g));
            }
            bottom += 1;
        }
        while top + REACH < v {
            for (u, column) in columns.iter_mut().enumerate() {
                let g = grey(u, top);
                *column = (column.0 - g, column.1 - u64::from(g * g));
            }
            top += 1;
        }
        for u in 0..width {
            sums[u + 1] = sums[u] + u64::from(columns[u].0);
            squares[u + 1] = squares[u] + columns[u].1;
        }
        for u in 0..width {
            let (left, right) = (u.saturating_sub(REACH), (u + REACH + 1).min(width));
            let n = ((right - left) * (bottom - top)) as u64;
            let (sum, square) = (sums[right] - sums[left], squares[right] - squares[left]);
            let deviation = ((n * square - sum * sum) as f64).sqrt() / (3 * n) as f64;
            out.push((deviation * STEPS_PER_LEVEL) as u16);
        }
    }
    out
}

/// The contrast at which a step begins, grey levels.
pub(crate) fn levels(step: usize) -> f64 {
    step as f64 / STEPS_PER_LEVEL
}

/// Which tenth of the pixels each step belongs to, given how many pixels each has. Steps are not divided: the tenth
/// that holds a step's first pixel has all of it.
pub(crate) fn deciles(counts: &[u64]) -> Vec<usize> {
    let total: u64 = counts.iter().sum();
    let mut below = 0_u64;
    counts
        .iter()
        .map(|n| {
            let decile = (below * 10).checked_div(total).unwrap_or(0).min(9) as usize;
            below += n;
            decile
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contrast_agrees_with_its_definition() {
        let (width, height) = (23, 14);
        let mut rgb = vec![0; width * height * 3];
        blake3::Hasher::new().update(b"contrast").finalize_xof().fill(&mut rgb);
        let steps = contrast_steps(&rgb, width);
        for v in 0..height {
            for u in 0..width {
                let mut window = Vec::new();
                for y in v.saturating_sub(4)..(v + 5).min(height) {
                    for x in u.saturating_sub(4)..(u + 5).min(width) {
                        let i = 3 * (y * width + x);
                        window.push((f64::from(rgb[i]) + f64::from(rgb[i + 1]) + f64::from(rgb[i + 2])) / 3.0);
                    }
                }
                let mean = window.iter().sum::<f64>() / window.len() as f64;
                let variance = window.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / window.len() as f64;
                let step = f64::from(steps[v * width + u]);
                let exact = variance.sqrt() * 16.0;
                assert!(step <= exact + 1e-9 && exact < step + 1.0 + 1e-9, "{u}, {v}: {step} of {exact}");
            }
        }
    }

    #[test]
    fn the_flattest_and_the_hardest_image() {
        assert!(contrast_steps(&[77; 30 * 20 * 3], 30).iter().all(|s| *s == 0));
        let stripes: Vec<u8> = (0..40 * 40).flat_map(|i| if i % 2 == 0 { [0; 3] } else { [255; 3] }).collect();
        let most = contrast_steps(&stripes, 40).into_iter().max().unwrap();
        assert!(usize::from(most) < STEPS && most == 2040, "{most}");
    }

    #[test]
    fn tenths_hold_a_tenth_each() {
        assert_eq!(deciles(&[1; 20]), (0..20).map(|i| i / 2).collect::<Vec<_>>());
        assert_eq!(deciles(&[50, 0, 50]), [0, 5, 5]);
        assert_eq!(deciles(&[95, 5]), [0, 9]);
        assert_eq!(deciles(&[0, 0]), [0, 0]);
    }
}
