//! The tables of a recipe as types. Every value that stands in a [`Recipe`](super::Recipe) has passed its range.

use super::sun::Sun;
use crate::camera;
use crate::render::{
    self, AmbientMode,
    sensor::{BandSet, Coding},
};
use glam::DVec3;
use satseed_generators::Region;
use satseed_scene::Environment;
use std::collections::BTreeSet;

/// `[camera]`: the rectified rig, without its baseline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Height of both cameras above z = 0, m, 100..1,000,000.
    pub altitude_m: f64,
    /// Size of a pixel at z = 0, m, 0.01..30.
    pub gsd_m: f64,
    /// Width and height of a frame, px, 8..16384 each.
    pub size_px: [u32; 2],
    /// Where the disparity is zero.
    pub datum: Datum,
}

impl Camera {
    /// Focal length, px: `altitude / gsd`.
    pub fn focal_px(&self) -> f64 {
        self.altitude_m / self.gsd_m
    }

    /// Convergence angle 2 atan(B / 2H) of a baseline, degrees.
    pub fn convergence_deg(&self, baseline_m: f64) -> f64 {
        (2.0 * libm::atan(baseline_m / (2.0 * self.altitude_m))).to_degrees()
    }

    /// Size of a frame's footprint at z = 0, m.
    pub fn footprint_m(&self) -> [f64; 2] {
        self.size_px.map(|n| f64::from(n) * self.gsd_m)
    }

    /// The rig of one pair, once the pivot's place and the height of the datum are known.
    pub fn rig_spec(&self, pair: &PairGeometry, pivot_m: DVec3, datum: camera::Datum) -> camera::RigSpec {
        camera::RigSpec {
            altitude_m: self.altitude_m,
            gsd_m: self.gsd_m,
            size_px: self.size_px,
            baseline_m: pair.baseline_m,
            azimuth_rad: pair.azimuth_deg.to_radians(),
            pivot_along_baseline: pair.pivot_along_baseline,
            pivot_m,
            datum,
        }
    }

    /// Pixels of one frame.
    pub fn pixels(&self) -> u64 {
        u64::from(self.size_px[0]) * u64::from(self.size_px[1])
    }
}

/// What tells one pair of a pivot from another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairGeometry {
    /// Distance of the cameras, m.
    pub baseline_m: f64,
    /// Direction from the left to the right camera, degrees clockwise from north.
    pub azimuth_deg: f64,
    /// Where the pivot's foot stands along the baseline: 0 under the left camera, 1 under the right one.
    pub pivot_along_baseline: f64,
}

/// The height at which the disparity is zero and both frames show the same ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Datum {
    /// None: centred principal points, as published; disparity is zero at infinity.
    None,
    /// The ground's height at the pivot, known once the scene stands.
    Pivot,
    /// Just under the lowest point in view, so that every disparity is positive; known once the scene stands.
    Lowest,
    /// A height, m above z = 0, -1,000..9,000 and below the cameras.
    HeightM(f64),
}

/// `[acquisition]`: which pairs are taken at every pivot.
#[derive(Clone, Debug, PartialEq)]
pub struct Acquisition {
    /// The baselines, or the angles that they follow from.
    pub baselines: Baselines,
    /// The azimuths of the baseline.
    pub azimuths: Azimuths,
    /// Where the pivot's foot stands along the baseline.
    pub pivot_along_baseline: PivotAlongBaseline,
    /// Takes only so many pairs of a pivot, drawn by its seed and spread over baselines and azimuths; all where `None`.
    pub pairs_per_pivot: Option<u32>,
}

/// How baselines are given.
#[derive(Clone, Debug, PartialEq)]
pub enum Baselines {
    /// Lengths, m, 0.01..2,000,000.
    LengthM(Series),
    /// Convergence angles 2 atan(B / 2H) at z = 0, degrees, 0.01..90.
    ConvergenceDeg(Series),
}

impl Baselines {
    /// The lengths, m, for cameras at an altitude.
    pub fn lengths_m(&self, altitude_m: f64) -> Vec<f64> {
        match self {
            Self::LengthM(series) => series.values(),
            Self::ConvergenceDeg(series) => {
                let length = |deg: f64| 2.0 * altitude_m * libm::tan(deg.to_radians() / 2.0);
                series.values().into_iter().map(length).collect()
            }
        }
    }

    /// How many.
    pub fn count(&self) -> u32 {
        match self {
            Self::LengthM(series) | Self::ConvergenceDeg(series) => series.count(),
        }
    }
}

/// Numbers given one by one or as equal steps.
#[derive(Clone, Debug, PartialEq)]
pub enum Series {
    /// One after the other; at least one, at most 1,000, no two equal.
    List(Vec<f64>),
    /// `steps` numbers at equal distances, both ends included; one step is `from` alone.
    Steps {
        /// First.
        from: f64,
        /// Last; not below `from`.
        to: f64,
        /// How many, 1..1000.
        steps: u32,
    },
}

impl Series {
    /// How many.
    pub fn count(&self) -> u32 {
        match self {
            Self::List(values) => values.len() as u32,
            Self::Steps { steps, .. } => *steps,
        }
    }

    /// The numbers in order.
    pub fn values(&self) -> Vec<f64> {
        match self {
            Self::List(values) => values.clone(),
            Self::Steps { from, to, steps } => {
                let gaps = f64::from(steps.saturating_sub(1).max(1));
                (0..*steps).map(|i| from + f64::from(i) * (to - from) / gaps).collect()
            }
        }
    }
}

/// How the azimuths of the baseline are given, degrees clockwise from north, -360..360.
#[derive(Clone, Debug, PartialEq)]
pub enum Azimuths {
    /// The same for every pivot; at least one, at most 1,000, no two equal.
    List(Vec<f64>),
    /// Drawn uniformly by each pivot's own seed.
    Drawn {
        /// Lower end, degrees.
        from_deg: f64,
        /// Upper end, degrees; not below the lower.
        to_deg: f64,
        /// How many, 1..1000.
        draws: u32,
    },
}

impl Azimuths {
    /// How many.
    pub fn count(&self) -> u32 {
        match self {
            Self::List(values) => values.len() as u32,
            Self::Drawn { draws, .. } => *draws,
        }
    }
}

/// Where the pivot's foot stands along the baseline: 0 under the left camera, 1 under the right one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PivotAlongBaseline {
    /// For all pairs, -10..11.
    Fixed(f64),
    /// Drawn uniformly in 0..1 for every pair by its pivot's seed.
    Random,
}

/// Enums that a recipe names by a word: the words stand in one place.
macro_rules! words {
    ($(#[$doc:meta])* $name:ident { $($(#[$variant_doc:meta])* $variant:ident = $word:literal,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum $name {
            $($(#[$variant_doc])* $variant,)*
        }

        impl $name {
            /// All of them, with their words in recipes.
            pub const ALL: &'static [(&'static str, Self)] = &[$(($word, Self::$variant)),*];

            /// Its word in recipes and file names.
            pub fn word(self) -> &'static str {
                match self {
                    $(Self::$variant => $word,)*
                }
            }
        }
    };
}

/// The words of `light.ambient`.
pub(super) const AMBIENT: &[(&str, AmbientMode)] =
    &[("per-scene", AmbientMode::PerScene), ("per-sample", AmbientMode::PerSample)];

/// The words of `sensor.bands`.
pub(super) const BANDS: &[(&str, BandSet)] =
    &[("pan", BandSet::Pan), ("rgb", BandSet::Rgb), ("rgb_nir", BandSet::RgbNir)];

/// The word of a value of the renderer's.
pub(super) fn word_of<T: PartialEq>(words: &[(&'static str, T)], value: &T) -> &'static str {
    words.iter().find(|(_, v)| v == value).map_or("", |(word, _)| word)
}

/// `[light]`: sun and air, the same for all pairs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Where the sun stands.
    pub sun: Sun,
    /// Aerosol optical depth at 550 nm, 0..1.
    pub aerosol_optical_depth: f64,
    /// How the light of the sky and of the surfaces around is worked out.
    pub ambient: AmbientMode,
}

impl From<&Light> for Environment {
    fn from(light: &Light) -> Self {
        let [sun_elevation_rad, sun_azimuth_rad] = light.sun.angles_deg().map(f64::to_radians);
        Self { sun_elevation_rad, sun_azimuth_rad, aerosol_optical_depth: light.aerosol_optical_depth }
    }
}

words! {
    /// What turns radiance into pixels, before a recipe changes single settings of it.
    SensorPreset {
        /// No blur, no noise: radiance as it is, stretched to 8 bits.
        Ideal = "ideal",
        /// Like WorldView-3's pan-sharpened colour, 8 bits.
        Worldview3Rgb = "worldview3_rgb",
        /// Like GF-7's panchromatic stereo cameras, 11 bits.
        Gf7Pan = "gf7_pan",
        /// No blur, no noise: radiance at the sensor as 32-bit floats in `OpenEXR`.
        Linear = "linear",
    }
}

impl SensorPreset {
    /// Its settings.
    pub fn sensor(self) -> render::Sensor {
        match self {
            Self::Ideal => render::Sensor::IDEAL,
            Self::Worldview3Rgb => render::Sensor::WORLDVIEW3_RGB,
            Self::Gf7Pan => render::Sensor::GF7_PAN,
            Self::Linear => render::Sensor::LINEAR,
        }
    }
}

words! {
    /// What numbers an image holds, and in which kind of file where there are several.
    SensorCoding {
        /// 8 bits, stretched.
        Stretched = "8bit",
        /// 11-bit counts in 16 bits.
        Counts = "11bit",
        /// Radiance, 32-bit floats in a TIFF.
        Float = "float",
        /// Radiance, 32-bit floats in `OpenEXR`.
        Exr = "exr",
    }
}

/// The file that radiance is written to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RadianceFile {
    /// 32-bit TIFF.
    Tiff,
    /// `OpenEXR`.
    Exr,
}

/// `[sensor]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// Where its settings started.
    pub preset: SensorPreset,
    /// What turns radiance into pixels: the preset with what the recipe changes.
    pub imager: render::Sensor,
    /// Which file holds its images where they are radiance.
    pub radiance_file: RadianceFile,
    /// Rays that a pixel's colour is averaged over, 1..4096. Labels are traced through pixel centres whatever this is.
    pub samples_per_pixel: u32,
}

impl Sensor {
    /// What the renderer takes.
    pub fn settings(&self) -> render::Settings {
        render::Settings { samples_per_pixel: self.samples_per_pixel, sensor: self.imager }
    }

    /// What its images hold, as recipes say it.
    pub fn coding(&self) -> SensorCoding {
        match (self.imager.coding, self.radiance_file) {
            (Coding::Stretched { .. }, _) => SensorCoding::Stretched,
            (Coding::Counts, _) => SensorCoding::Counts,
            (Coding::Radiance, RadianceFile::Tiff) => SensorCoding::Float,
            (Coding::Radiance, RadianceFile::Exr) => SensorCoding::Exr,
        }
    }
}

words! {
    /// A label beyond the left view's disparity and validity, which are always written.
    Label {
        /// Disparity and validity of the right view.
        DisparityRight = "disparity_right",
        /// Semantic class of both views.
        Class = "class",
        /// Height of the surface seen, m, of both views.
        Elevation = "elevation",
        /// Object id of both views.
        Instance = "instance",
        /// Geometric normal of both views.
        Normal = "normal",
        /// Direct sun of both views.
        Shadow = "shadow",
        /// Mixed pixels of both views.
        Edge = "edge",
    }
}

words! {
    /// How finely a disparity file tells a value.
    DisparityPrecision {
        /// The f32 nearest to the f64 truth.
        Full = "full",
        /// Rounded to 1/256 px, half the bytes.
        Px256th = "1/256",
    }
}

/// `[labels]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Labels {
    /// What is written beside the left view's disparity and validity.
    pub write: BTreeSet<Label>,
    /// How finely a disparity file tells a value.
    pub disparity_precision: DisparityPrecision,
}

impl Labels {
    /// Whether a label is written.
    pub fn has(&self, label: Label) -> bool {
        self.write.contains(&label)
    }
}

words! {
    /// `[split]`: how pairs fall into train, val and test.
    SplitRule {
        /// The published counts, scaled, drawn pair by pair: one scene may stand in train and in test.
        Published = "published",
        /// Whole pivots, region by region, nearest to the published shares: no scene stands in two splits.
        ByPivot = "by-pivot",
    }
}

/// `[[scene]]`: a region with its parameters, and how often it is built.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneEntry {
    /// The region with its parameters.
    pub region: Region,
    /// Its pivots.
    pub pivots: Pivots,
}

/// The pivots of one `[[scene]]`: each is a scene of its own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Pivots {
    /// So many, 1..10,000; their seeds follow from the recipe's.
    Count(u32),
    /// One for each scene seed.
    Seeds(Vec<u64>),
}

impl Pivots {
    /// How many.
    pub fn count(&self) -> usize {
        match self {
            Self::Count(n) => *n as usize,
            Self::Seeds(seeds) => seeds.len(),
        }
    }
}
