//! Where disparity jumps, how far each pixel is from there, and the soft edge error.

/// A jump: neighbours whose disparities differ by more than this, px.
pub(super) const JUMP_PX: f64 = 3.0;

/// Marks the pixels on either side of a jump between horizontal or vertical neighbours.
pub(super) fn jumps(truth_px: &[f32], width: usize) -> Vec<bool> {
    let mut marks = vec![false; truth_px.len()];
    let differ = |a: usize, b: usize| (f64::from(truth_px[a]) - f64::from(truth_px[b])).abs() > JUMP_PX;
    for i in 0..truth_px.len() {
        if i % width + 1 < width && differ(i, i + 1) {
            (marks[i], marks[i + 1]) = (true, true);
        }
        if i + width < truth_px.len() && differ(i, i + width) {
            (marks[i], marks[i + width]) = (true, true);
        }
    }
    marks
}

/// Squared distance of each pixel's centre to the nearest marked one's, px^2; `u32::MAX` where none is marked.
///
/// Exact, in two passes: along columns, then the lower envelope of parabolas along rows (Felzenszwalb and Huttenlocher,
/// Distance Transforms of Sampled Functions, 2012), with the whole-number comparisons of Meijster et al. (2000).
pub(super) fn squared_distances(marks: &[bool], width: usize) -> Vec<u32> {
    const FAR: u32 = u32::MAX;
    let height = marks.len() / width;
    // Distance along the column.
    let mut along = vec![FAR; marks.len()];
    for u in 0..width {
        let mut last = FAR;
        for v in 0..height {
            last = if marks[v * width + u] { 0 } else { last.saturating_add(1) };
            along[v * width + u] = last;
        }
        last = FAR;
        for v in (0..height).rev() {
            last = if marks[v * width + u] { 0 } else { last.saturating_add(1) };
            along[v * width + u] = along[v * width + u].min(last);
        }
    }
    let mut out = vec![u32::MAX; marks.len()];
    // The parabolas of the envelope, and from which column on each is the lowest.
    let (mut at, mut from): (Vec<i64>, Vec<i64>) = (Vec::new(), Vec::new());
    for (row, out) in along.chunks_exact(width).zip(out.chunks_exact_mut(width)) {
        at.clear();
        from.clear();
        let height_of = |q: i64| i64::from(row[q as usize]) * i64::from(row[q as usize]);
        let value = |q: i64, u: i64| (u - q) * (u - q) + height_of(q);
        for q in (0..width as i64).filter(|q| row[*q as usize] != FAR) {
            while let (Some(p), Some(begin)) = (at.last(), from.last()) {
                if value(*p, *begin) <= value(q, *begin) {
                    break;
                }
                at.pop();
                from.pop();
            }
            match at.last() {
                None => {
                    at.push(q);
                    from.push(0);
                }
                Some(p) => {
                    // The first column where q is lower than p.
                    let p = *p;
                    let crossing = (q * q - p * p + height_of(q) - height_of(p)).div_euclid(2 * (q - p)) + 1;
                    if crossing < width as i64 {
                        at.push(q);
                        from.push(crossing);
                    }
                }
            }
        }
        let mut k = 0;
        for (u, out) in (0..width as i64).zip(out) {
            while k + 1 < at.len() && from[k + 1] <= u {
                k += 1;
            }
            if let Some(q) = at.get(k) {
                *out = value(*q, u) as u32;
            }
        }
    }
    out
}

/// Soft edge error of a pixel: the least difference of its prediction to any truth in the window of `side` pixels around
/// it, px (Chen et al., On the Over-Smoothing Problem of CNN Based Disparity Estimation, 2019; SMD-Nets, 2021).
pub(super) fn soft_edge_error_px(truth_px: &[f32], width: usize, at: usize, side: usize, predicted_px: f64) -> f64 {
    let height = truth_px.len() / width;
    let (u, v, reach) = (at % width, at / width, side / 2);
    let mut least = f64::INFINITY;
    for y in v.saturating_sub(reach)..=(v + reach).min(height - 1) {
        for x in u.saturating_sub(reach)..=(u + reach).min(width - 1) {
            // A NaN truth is passed over by `min`.
            least = least.min((predicted_px - f64::from(truth_px[y * width + x])).abs());
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jumps_mark_both_sides() {
        #[rustfmt::skip]
        let truth = [
            0.0, 0.0, 3.0, 9.0,
            0.0, 0.0, 0.0, f32::NAN,
        ];
        #[rustfmt::skip]
        let marked = [
            false, false, true, true,
            false, false, false, false,
        ];
        assert_eq!(jumps(&truth, 4), marked, "3 px are no jump, 6 px are; a hole is none");
        assert_eq!(jumps(&[0.0, 4.0], 1), [true, true]);
    }

    #[test]
    fn distances_agree_with_all_pairs() {
        let mut draws = blake3::Hasher::new().update(b"distances").finalize_xof();
        for (width, height, one_in) in [(1, 1, 2), (1, 9, 3), (9, 1, 3), (17, 13, 4), (23, 31, 40), (40, 40, 300)] {
            for _ in 0..20 {
                let mut bytes = vec![0; width * height * 2];
                draws.fill(&mut bytes);
                let marks: Vec<bool> =
                    bytes.chunks(2).map(|b| u32::from(u16::from_le_bytes([b[0], b[1]])) % one_in == 0).collect();
                let expected: Vec<u32> = (0..marks.len())
                    .map(|i| {
                        let to = |j: usize| {
                            let (du, dv) = ((i % width).abs_diff(j % width), (i / width).abs_diff(j / width));
                            (du * du + dv * dv) as u32
                        };
                        (0..marks.len()).filter(|j| marks[*j]).map(to).min().unwrap_or(u32::MAX)
                    })
                    .collect();
                assert_eq!(squared_distances(&marks, width), expected, "{width} x {height}");
            }
        }
    }

    #[test]
    fn soft_edges_forgive_the_other_side() {
        let truth = [10.0, 10.0, 50.0, 50.0, f32::NAN, 7.0];
        assert_eq!(soft_edge_error_px(&truth, 6, 1, 3, 50.5), 0.5, "the other side is one pixel away");
        assert_eq!(soft_edge_error_px(&truth, 6, 0, 3, 50.5), 40.5, "and here two");
        assert_eq!(soft_edge_error_px(&truth, 6, 0, 5, 50.5), 0.5);
        assert_eq!(soft_edge_error_px(&truth, 6, 1, 3, 30.0), 20.0, "a mean of both sides is wrong");
        assert_eq!(soft_edge_error_px(&truth, 6, 4, 3, 8.0), 1.0);
    }
}
