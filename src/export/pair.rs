//! A sample on its way out: both views, their labels and cameras, cut and made smaller together.

use crate::dataset::formats::{Pixels, Plane};
use crate::dataset::{CameraFile, CameraRecord, Dataset, Identity, Layer, ReadError, SampleRecord, View, validity};

/// At which height both windows of a crop show the same ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Overlap {
    /// The pivot's.
    Pivot,
    /// The lowest that the sample sees, so that no disparity is negative.
    Lowest,
    /// A height, m.
    HeightM(f64),
}

/// Why there is no overlap.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct OverlapError(String);

/// One view's pixels and labels.
#[derive(Clone, Debug)]
pub(super) struct Side {
    pub(super) image: Plane,
    /// `u_L - u_R`, px; NaN where nothing was hit.
    pub(super) disparity_px: Vec<f32>,
    pub(super) validity: Vec<u8>,
}

/// A pair with its labels.
#[derive(Clone, Debug)]
pub(super) struct Pair {
    /// Its sample's id with `__` for the slash, and its tile.
    pub(super) name: String,
    pub(super) identity: Identity,
    pub(super) camera: CameraFile,
    pub(super) pivot_height_m: f64,
    pub(super) left: Side,
    /// Its labels are there where the recipe asks for `disparity_right`.
    pub(super) right: Side,
    pub(super) has_right_labels: bool,
    /// Of the left view, where the recipe asks for it.
    pub(super) class: Option<Vec<u8>>,
    /// Height of the left view's points over the bare ground, m; NaN where there is none. Empty where nobody asked.
    pub(super) above_ground_m: Vec<f64>,
}

impl Pair {
    /// Reads it; heights above the ground, which take the scene's ground model, only where they are wanted.
    pub(super) fn read(dataset: &Dataset<'_>, record: &SampleRecord, with_heights: bool) -> Result<Self, ReadError> {
        let camera = dataset.camera(record)?;
        let plane = |layer, view| dataset.plane(record, &camera, layer, view);
        let floats = |layer, view| Ok::<_, ReadError>(plane(layer, view)?.into_floats());
        let bytes = |layer, view| Ok::<_, ReadError>(plane(layer, view)?.into_bytes());
        let has = |layer: Layer, view| record.files.contains_key(&layer.key(view));
        let has_right_labels = has(Layer::Disparity, View::Right) && has(Layer::Validity, View::Right);
        let side = |view| {
            let image = plane(Layer::Image, view)?;
            let labelled = view == View::Left || has_right_labels;
            let disparity_px = if labelled { floats(Layer::Disparity, view)? } else { Vec::new() };
            let validity = if labelled { bytes(Layer::Validity, view)? } else { Vec::new() };
            Ok::<_, ReadError>(Side { image, disparity_px, validity })
        };
        let (left, right) = (side(View::Left)?, side(View::Right)?);
        let scene: serde_json::Value = serde_json::from_str(&dataset.text(record, "scene")?).unwrap_or_default();
        let class = has(Layer::Class, View::Left).then(|| bytes(Layer::Class, View::Left)).transpose()?;
        let above_ground_m = if with_heights {
            camera.heights_above(&dataset.height_map(record, "dtm")?, &left.disparity_px)
        } else {
            Vec::new()
        };
        Ok(Self {
            name: record.id().replace('/', "__"),
            identity: record.identity.clone(),
            pivot_height_m: scene["pivot_height_m"].as_f64().unwrap_or(0.0),
            left,
            right,
            has_right_labels,
            class,
            above_ground_m,
            camera,
        })
    }

    /// One pixel for `k` by `k`: of the images their mean, of the labels what stands in the middle. Disparity in pixels
    /// shrinks with them.
    pub(super) fn downsampled(&self, k: u32) -> Self {
        let [width, height] = [self.camera.left.width_px, self.camera.left.height_px];
        let of = Blocks { k: k as usize, from: width as usize, width: width / k, height: height / k };
        let side = |side: &Side| {
            let mut small = Side {
                image: Plane { width: of.width, height: of.height, pixels: of.mean(&side.image.pixels) },
                disparity_px: Vec::new(),
                validity: of.middle(&side.validity),
            };
            if !side.disparity_px.is_empty() {
                let middle = of.disparity(&side.disparity_px, &side.validity);
                small.disparity_px = middle.into_iter().map(|d| d / k as f32).collect();
            }
            small
        };
        let camera = |c: &CameraRecord| {
            let (scale, middle) = (f64::from(k), f64::from(k - 1) / 2.0);
            CameraRecord {
                width_px: of.width,
                height_px: of.height,
                fx_px: c.fx_px / scale,
                fy_px: c.fy_px / scale,
                cx_px: (c.cx_px - middle) / scale,
                cy_px: (c.cy_px - middle) / scale,
                projection: moved(&c.projection, [middle; 2], scale),
                ..c.clone()
            }
        };
        let mut pair = Self {
            left: side(&self.left),
            right: side(&self.right),
            class: self.class.as_ref().map(|c| of.middle(c)),
            above_ground_m: of.middle(&self.above_ground_m),
            camera: CameraFile {
                left: camera(&self.camera.left),
                right: camera(&self.camera.right),
                gsd_m: self.camera.gsd_m * f64::from(k),
                doffs_px: self.camera.doffs_px / f64::from(k),
                ..self.camera.clone()
            },
            ..self.clone()
        };
        pair.count();
        pair
    }

    /// What both views show of the ground at a height: a window of its own in each, shifted by whole pixels.
    pub(super) fn overlap(&self, at: Overlap) -> Result<Self, OverlapError> {
        let left = &self.camera.left;
        let disparity_px = |height_m: f64| {
            left.fx_px * self.camera.baseline_m / (left.position_m[2] - height_m) - self.camera.doffs_px
        };
        let shift = match at {
            Overlap::Pivot => disparity_px(self.pivot_height_m).round(),
            Overlap::HeightM(height_m) if height_m < left.position_m[2] => disparity_px(height_m).round(),
            Overlap::HeightM(height_m) => {
                let top = left.position_m[2];
                return Err(OverlapError(format!("a height of {height_m} m is above the cameras, at {top} m")));
            }
            Overlap::Lowest => {
                let lowest = self.left.disparity_px.iter().chain(&self.right.disparity_px).copied();
                f64::from(lowest.filter(|d| d.is_finite()).fold(f32::INFINITY, f32::min)).floor()
            }
        };
        let width = f64::from(left.width_px) - shift.abs();
        if !(width >= 1.0 && shift.is_finite()) {
            let (shift, all) = (shift.abs(), left.width_px);
            return Err(OverlapError(format!("frames of {all} px that are {shift} px apart show nothing in common")));
        }
        let from = [shift.max(0.0) as u32, (-shift).max(0.0) as u32];
        Ok(self.window(from, 0, width as u32, left.height_px))
    }

    /// A window of each view: columns from `from` (left, right), rows from `top`.
    pub(super) fn window(&self, from: [u32; 2], top: u32, width: u32, height: u32) -> Self {
        let rows = |i: usize| Window {
            all: self.camera.left.width_px as usize,
            from: from[i] as usize,
            top: top as usize,
            width: width as usize,
            height: height as usize,
        };
        let shift = f64::from(from[0]) - f64::from(from[1]);
        let side = |side: &Side, i: usize| {
            let cut = rows(i);
            let image = Plane { width, height, pixels: cut.pixels(&side.image.pixels) };
            let shifted = |d: f32| if shift == 0.0 { d } else { (f64::from(d) - shift) as f32 };
            let disparity_px: Vec<f32> = cut.cut(&side.disparity_px, 1).into_iter().map(shifted).collect();
            let mut map = cut.cut(&side.validity, 1);
            for (k, value) in map.iter_mut().enumerate() {
                // Where the point lies in the other window, as the label asks of frames.
                let (d, u) = (f64::from(disparity_px[k]), (k % width as usize) as f64);
                let there = if i == 0 { u - d } else { u + d };
                let within = there >= -0.5 && there < f64::from(width) - 0.5;
                if *value != validity::MISS && !within {
                    *value = validity::OUT_OF_FRAME;
                }
            }
            Side { image, disparity_px, validity: map }
        };
        let camera = |c: &CameraRecord, i: usize| {
            let [du, dv] = [f64::from(from[i]), f64::from(top)];
            CameraRecord {
                width_px: width,
                height_px: height,
                cx_px: c.cx_px - du,
                cy_px: c.cy_px - dv,
                projection: moved(&c.projection, [du, dv], 1.0),
                ..c.clone()
            }
        };
        let mut pair = Self {
            left: side(&self.left, 0),
            right: side(&self.right, 1),
            class: self.class.as_ref().map(|c| rows(0).cut(c, 1)),
            above_ground_m: rows(0).cut(&self.above_ground_m, 1),
            camera: CameraFile {
                left: camera(&self.camera.left, 0),
                right: camera(&self.camera.right, 1),
                doffs_px: self.camera.doffs_px + shift,
                ..self.camera.clone()
            },
            ..self.clone()
        };
        pair.count();
        pair
    }

    /// Takes over the range of disparities.
    fn count(&mut self) {
        let finite = self.left.disparity_px.iter().copied().filter(|d| d.is_finite());
        let [low, high] = finite.fold([f32::INFINITY, f32::NEG_INFINITY], |[a, b], d| [a.min(d), b.max(d)]);
        self.camera.disparity_range_px = (low <= high).then_some([low, high]);
    }
}

impl Side {
    /// Disparities where both cameras see; NaN elsewhere.
    pub(super) fn seen_by_both(&self) -> Vec<f32> {
        let value = |(d, v): (&f32, &u8)| if *v == validity::VALID { *d } else { f32::NAN };
        self.disparity_px.iter().zip(&self.validity).map(value).collect()
    }
}

/// A projection to pixels that are counted from another one, and are so many times larger.
fn moved(p: &[[f64; 4]; 3], by_px: [f64; 2], scale: f64) -> [[f64; 4]; 3] {
    let row = |i: usize| core::array::from_fn(|k| (p[i][k] - by_px[i] * p[2][k]) / scale);
    [row(0), row(1), p[2]]
}

/// Blocks of `k` by `k` pixels of rows of `from`.
struct Blocks {
    k: usize,
    from: usize,
    width: u32,
    height: u32,
}

impl Blocks {
    /// First pixel of each block.
    fn corners(&self) -> impl Iterator<Item = usize> {
        let (k, from, width) = (self.k, self.from, self.width as usize);
        (0..self.height as usize).flat_map(move |j| (0..width).map(move |i| (j * from + i) * k))
    }

    /// The pixel in the middle of each block; of four the first.
    fn middle<T: Copy>(&self, values: &[T]) -> Vec<T> {
        if values.is_empty() {
            return Vec::new();
        }
        let offset = (self.k - 1) / 2;
        self.corners().map(|first| values[first + offset * (self.from + 1)]).collect()
    }

    /// Disparity in the middle of each block: of four pixels around it their mean, where they are of one surface.
    fn disparity(&self, values: &[f32], map: &[u8]) -> Vec<f32> {
        /// Neighbours that differ by more are of two surfaces, px.
        const STEP_PX: f32 = 1.0;
        let offset = (self.k - 1) / 2;
        self.corners()
            .map(|first| {
                let at = first + offset * (self.from + 1);
                let four = [at, at + 1, at + self.from, at + self.from + 1];
                if self.k % 2 == 1 || four.iter().any(|i| map[*i] != map[at]) {
                    return values[at];
                }
                let four = four.map(|i| values[i]);
                let [low, high] = four.iter().fold([values[at]; 2], |[a, b], d| [a.min(*d), b.max(*d)]);
                if high - low <= STEP_PX { four.iter().sum::<f32>() / 4.0 } else { values[at] }
            })
            .collect()
    }

    fn mean(&self, pixels: &Pixels) -> Pixels {
        match pixels {
            Pixels::Gray(v) => Pixels::Gray(self.means(v, 1, f64::from, |x| (x + 0.5) as u8)),
            Pixels::Rgb(v) => Pixels::Rgb(self.means(v, 3, f64::from, |x| (x + 0.5) as u8)),
            Pixels::Bytes4(v) => Pixels::Bytes4(self.means(v, 4, f64::from, |x| (x + 0.5) as u8)),
            Pixels::Counts(n, v) => Pixels::Counts(*n, self.means(v, (*n).into(), f64::from, |x| (x + 0.5) as u16)),
            Pixels::Radiance(n, v) => Pixels::Radiance(*n, self.means(v, (*n).into(), f64::from, |x| x as f32)),
            other => other.clone(),
        }
    }

    fn means<T: Copy>(&self, v: &[T], n: usize, read: impl Fn(T) -> f64, write: impl Fn(f64) -> T) -> Vec<T> {
        let area = (self.k * self.k) as f64;
        let mut out = Vec::with_capacity(self.width as usize * self.height as usize * n);
        for first in self.corners() {
            for channel in 0..n {
                let mut sum = 0.0;
                for j in 0..self.k {
                    for i in 0..self.k {
                        sum += read(v[(first + j * self.from + i) * n + channel]);
                    }
                }
                out.push(write(sum / area));
            }
        }
        out
    }
}

/// Rows and columns that are kept, of rows of `all`.
struct Window {
    all: usize,
    from: usize,
    top: usize,
    width: usize,
    height: usize,
}

impl Window {
    /// Of an array with `n` values a pixel; an empty one stays empty.
    fn cut<T: Copy>(&self, values: &[T], n: usize) -> Vec<T> {
        if values.is_empty() {
            return Vec::new();
        }
        let row = |j: usize| &values[((self.top + j) * self.all + self.from) * n..][..self.width * n];
        (0..self.height).flat_map(row).copied().collect()
    }

    fn pixels(&self, pixels: &Pixels) -> Pixels {
        match pixels {
            Pixels::Gray(v) => Pixels::Gray(self.cut(v, 1)),
            Pixels::Rgb(v) => Pixels::Rgb(self.cut(v, 3)),
            Pixels::Bytes4(v) => Pixels::Bytes4(self.cut(v, 4)),
            Pixels::Counts(n, v) => Pixels::Counts(*n, self.cut(v, (*n).into())),
            Pixels::Radiance(n, v) => Pixels::Radiance(*n, self.cut(v, (*n).into())),
            other => other.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 12;
    const HEIGHT: usize = 6;

    /// Two cameras 60 m apart, 1000 m high, over a slope: 30 px of disparity and a twentieth for each column; one pixel missed.
    fn pair() -> Pair {
        let camera = |x: f64, cx: f64| CameraRecord {
            width_px: WIDTH as u32,
            height_px: HEIGHT as u32,
            fx_px: 500.0,
            fy_px: 500.0,
            cx_px: cx,
            cy_px: 2.5,
            position_m: [x, 0.0, 1000.0],
            world_from_camera: [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
            projection: [[500.0, 0.0, cx, 0.0], [0.0, 500.0, 2.5, 0.0], [0.0, 0.0, 1.0, 0.0]],
        };
        let count = WIDTH * HEIGHT;
        let side = || {
            let mut disparity_px: Vec<f32> = (0..count).map(|i| 3.0 + (i % WIDTH) as f32 / 20.0).collect();
            let mut map: Vec<u8> = (0..count).map(|i| if i % WIDTH < 3 { 3 } else { 1 }).collect();
            (disparity_px[17], map[17]) = (f32::NAN, validity::MISS);
            map[20] = validity::OCCLUDED;
            let pixels = Pixels::Gray((0..count as u8).collect());
            Side { image: Plane { width: WIDTH as u32, height: HEIGHT as u32, pixels }, disparity_px, validity: map }
        };
        Pair {
            name: "a__b".into(),
            identity: Identity {
                id: "a/b".into(),
                region: "a".into(),
                variant: "a".into(),
                scene_seed: 1,
                split: "train".into(),
                scene_params_hash: "00000000".into(),
                baseline_m: 60.0,
                azimuth_deg: 0.0,
                convergence_deg: 3.0,
            },
            camera: CameraFile {
                left: camera(-30.0, 5.5),
                right: camera(30.0, 32.5),
                baseline_m: 60.0,
                altitude_m: 1000.0,
                gsd_m: 2.0,
                azimuth_deg: 0.0,
                convergence_deg: 3.0,
                convergence_at_pivot_deg: 3.0,
                doffs_px: 27.0,
                disparity_range_px: None,
            },
            pivot_height_m: 0.0,
            left: side(),
            right: side(),
            has_right_labels: true,
            class: Some((0..count as u8).map(|i| i % 15).collect()),
            above_ground_m: vec![1.0; count],
        }
    }

    fn depth_m(pair: &Pair, i: usize) -> f64 {
        pair.camera.left.fx_px * pair.camera.baseline_m / (f64::from(pair.left.disparity_px[i]) + pair.camera.doffs_px)
    }

    #[test]
    fn a_crop_shifts_its_windows_against_each_other_and_keeps_every_depth() {
        let whole = pair();
        // At the pivot: 500 * 60 / 1000 - 27 = 3 px.
        let cut = whole.overlap(Overlap::Pivot).unwrap();
        assert_eq!((cut.camera.left.width_px, cut.camera.left.cx_px, cut.camera.right.cx_px), (9, 2.5, 32.5));
        assert_eq!(cut.camera.doffs_px, 30.0);
        assert_eq!(cut.camera.left.projection[0][2], 2.5);
        let (Pixels::Gray(left), Pixels::Gray(right)) = (&cut.left.image.pixels, &cut.right.image.pixels) else {
            panic!()
        };
        assert_eq!((left[0], right[0], left[9]), (3, 0, 15));
        for v in 0..HEIGHT {
            for u in 0..9 {
                let (new, old) = (v * 9 + u, v * WIDTH + u + 3);
                assert!(
                    whole.left.disparity_px[old].is_nan() || (depth_m(&cut, new) - depth_m(&whole, old)).abs() < 1e-3
                );
            }
        }
        // Columns 3 to 11 of the left view, disparities 0.15 to 0.55 px: the first match lies before the window's border
        // only where it is more than half a pixel out.
        assert_eq!(cut.left.validity[..9], [1; 9]);
        assert_eq!(cut.left.validity[9 + 2], validity::MISS);
        assert_eq!(cut.left.validity[9 + 5], validity::OCCLUDED);
        assert_eq!(cut.class.as_ref().unwrap()[0], 3);
        let lowest = whole.overlap(Overlap::Lowest).unwrap();
        assert!(lowest.left.disparity_px.iter().all(|d| d.is_nan() || *d >= 0.0));
        assert!(whole.overlap(Overlap::HeightM(2000.0)).unwrap_err().to_string().contains("above the cameras"));
        assert!(whole.overlap(Overlap::HeightM(900.0)).unwrap_err().to_string().contains("nothing in common"));
    }

    #[test]
    fn a_window_cuts_off_matches() {
        let tile = pair().window([4, 4], 2, 6, 3);
        assert_eq!((tile.camera.left.cy_px, tile.camera.doffs_px), (0.5, 27.0));
        // Column u has its match at u - 3.2 and less: the first three and a bit are out of the frame.
        assert_eq!(tile.left.validity[..6], [3, 3, 3, 1, 1, 1]);
        // In the right view the match lies to the right.
        assert_eq!(tile.right.validity[..6], [1, 1, 1, 3, 3, 3]);
    }

    #[test]
    fn half_size_keeps_the_middle_and_every_ray() {
        let whole = pair();
        let half = whole.downsampled(2);
        assert_eq!((half.camera.left.width_px, half.camera.left.cx_px, half.camera.left.fx_px), (6, 2.5, 250.0));
        // Four neighbours of one surface: their mean, halved.
        assert_eq!(half.left.disparity_px[0], (3.0 + 3.05 + 3.0 + 3.05) / 4.0 / 2.0);
        assert!((depth_m(&half, 0) - 500.0 * 60.0 / (27.0 + 3.025)).abs() < 1e-3);
        // Beside the pixel that was missed, which is another's second column: the first of the four.
        assert_eq!((half.left.validity[2], half.left.disparity_px[2]), (1, 3.2_f32 / 2.0));
        let Pixels::Gray(image) = &half.left.image.pixels else { panic!() };
        assert_eq!(image[0], 7); // (0 + 1 + 12 + 13) / 4 = 6.5
        let third = whole.downsampled(3);
        assert_eq!((third.camera.left.width_px, third.camera.left.cx_px), (4, 1.5));
        assert_eq!(third.left.disparity_px[0], (3.0 + 1.0 / 20.0) / 3.0);
        // A ray is the same before and after: pixel (0, 0) of the third is (1, 1) of the whole.
        let ray = |c: &CameraRecord, u: f64, v: f64| [(u - c.cx_px) / c.fx_px, (v - c.cy_px) / c.fy_px];
        for (a, b) in ray(&third.camera.left, 0.0, 0.0).into_iter().zip(ray(&whole.camera.left, 1.0, 1.0)) {
            assert!((a - b).abs() < 1e-15);
        }
    }
}
