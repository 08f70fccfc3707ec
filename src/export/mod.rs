//! A dataset in the layouts that stereo trainers load: <https://github.com/pytorch/vision> and others, see docs/export.md.
//!
//! Each layout says in its own place what its loader makes of a value: what is invalid, which sign, how large. What a
//! loader would read wrongly is refused in a sentence before anything is written.

mod encode;
mod layouts;
mod pair;

pub use layouts::Layout;
pub use pair::{Overlap, OverlapError};

use crate::dataset::formats::FormatError;
use crate::dataset::{Dataset, ReadError, SampleRecord};
use layouts::Coded;
use pair::Pair;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// What is made of each sample before it is written.
#[derive(Clone, Debug)]
pub struct Options {
    /// For which loader.
    pub layout: Layout,
    /// Only what both views show.
    pub overlap: Option<Overlap>,
    /// One pixel for so many by so many; 1 for all of them.
    pub downsample: u32,
    /// Side of square tiles, px of what is written.
    pub tile: Option<u32>,
    /// Only samples of this split.
    pub split: Option<String>,
}

/// What was written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Exported {
    /// Pairs, tiles counted one by one.
    pub pairs: usize,
    /// Files.
    pub files: usize,
    /// Their bytes.
    pub bytes: u64,
}

/// Why a dataset cannot be exported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The dataset cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// An array cannot be encoded.
    #[error("sample `{id}`: {reason}")]
    Encode {
        /// The sample.
        id: String,
        /// What is wrong.
        reason: FormatError,
    },
    /// The layout's loader would read something wrongly.
    #[error("layout {layout} cannot hold sample `{id}`: {what}")]
    Coding {
        /// The layout's name.
        layout: &'static str,
        /// The sample.
        id: String,
        /// What it cannot hold, and what to do.
        what: String,
    },
    /// The options leave nothing of a frame.
    #[error("sample `{id}`: {what}")]
    Nothing {
        /// The sample.
        id: String,
        /// What is too small.
        what: String,
    },
    /// No sample is chosen.
    #[error("no sample is of split `{0}`; `satseed info` tells the splits")]
    NoSamples(String),
    /// The layout's loader wants more pairs.
    #[error(
        "the loader of layout {layout} wants at least {least} pairs, one in each of its folders, but there are {pairs}; --tile makes more of them"
    )]
    TooFew {
        /// The layout's name.
        layout: &'static str,
        /// How many it wants.
        least: usize,
        /// How many there are.
        pairs: usize,
    },
    /// The folder holds something.
    #[error("`{}` holds something already; an export wants a folder of its own", .0.display())]
    NotEmpty(PathBuf),
    /// The folder's name misleads a loader.
    #[error("`{}`: the loaders of layout {layout} make the right image's path by putting `right` for `left` in all of it; choose a folder without `left` in its path", .root.display())]
    Root {
        /// The folder.
        root: PathBuf,
        /// The layout's name.
        layout: &'static str,
    },
    /// A file cannot be written.
    #[error("cannot write `{}`: {reason}", .path.display())]
    Write {
        /// Which.
        path: PathBuf,
        /// The system's reason.
        reason: io::Error,
    },
}

/// A file of a layout: its path below the export's folder, and its content.
type File = (String, Vec<u8>);

/// Where a pair stands among all: layouts number by it.
#[derive(Clone, Copy, Debug)]
struct Place {
    /// Of all pairs, from 0, and of its region's.
    number: usize,
    in_region: usize,
    /// Its sample among all that are exported, from 0.
    sample: usize,
    /// Of its sample's tiles, row and column.
    tile: [u32; 2],
}

/// Writes a dataset's samples to a folder of their own. `done` is told of each sample. Where it fails, nothing is left.
///
/// # Errors
/// Where the dataset cannot be read, a value does not fit the layout, or the folder cannot be written or is not empty.
pub fn export(
    dataset: &Dataset<'_>,
    out: &Path,
    options: &Options,
    done: &(dyn Fn(&str) + Sync),
) -> Result<Exported, ExportError> {
    let layout = options.layout;
    let root = std::path::absolute(out).unwrap_or_else(|_| out.to_owned());
    if layout.swaps_left() && root.to_string_lossy().contains("left") {
        return Err(ExportError::Root { root, layout: layout.name() });
    }
    if std::fs::read_dir(&root).is_ok_and(|mut entries| entries.next().is_some()) {
        return Err(ExportError::NotEmpty(root));
    }
    let wanted = |r: &&SampleRecord| options.split.as_ref().is_none_or(|s| *s == r.identity.split);
    let records: Vec<&SampleRecord> = dataset.records().iter().filter(wanted).collect();
    if records.is_empty() {
        return Err(ExportError::NoSamples(options.split.clone().unwrap_or_default()));
    }
    // Written beside, and given its name when all is there: an export that exists is whole.
    let mut beside = root.clone().into_os_string();
    beside.push(".satseed-unfinished");
    let beside = PathBuf::from(beside);
    if beside.exists() {
        std::fs::remove_dir_all(&beside).map_err(|e| failed(&beside, e))?;
    }
    let written = write_all(dataset, &records, &beside, options, done).and_then(|exported| {
        if root.exists() {
            std::fs::remove_dir(&root).map_err(|e| failed(&root, e))?;
        }
        std::fs::rename(&beside, &root).map_err(|e| failed(&root, e))?;
        Ok(exported)
    });
    if written.is_err() {
        // What cannot be removed is found and removed by the next export.
        let _ = std::fs::remove_dir_all(&beside);
    }
    written
}

fn write_all(
    dataset: &Dataset<'_>,
    records: &[&SampleRecord],
    root: &Path,
    options: &Options,
    done: &(dyn Fn(&str) + Sync),
) -> Result<Exported, ExportError> {
    let mut numbers: BTreeMap<&str, usize> = BTreeMap::new();
    let numbered: Vec<(&SampleRecord, [usize; 2])> = records
        .iter()
        .enumerate()
        .map(|(k, r)| {
            let next = numbers.entry(&r.identity.region).or_default();
            *next += 1;
            (*r, [k, *next - 1])
        })
        .collect();
    let (together, end) = options.layout.shared();
    let exported: Vec<(Exported, Vec<String>)> = numbered
        .par_chunks(together)
        .map(|group| {
            let mut exported = Exported::default();
            let mut listed = Vec::new();
            let mut begun: BTreeSet<String> = BTreeSet::new();
            for (record, number) in group {
                let coded = sample(dataset, record, *number, options)?;
                exported.pairs += coded.len();
                for (path, bytes) in coded.iter().flat_map(|c| &c.files) {
                    let first = begun.insert(path.clone());
                    write(&root.join(path), bytes, first)?;
                    exported.files += usize::from(first);
                    exported.bytes += bytes.len() as u64;
                }
                listed.extend(coded.into_iter().flat_map(|c| c.listed));
                done(record.id());
            }
            for path in begun.iter().filter(|_| !end.is_empty()) {
                write(&root.join(path), end, false)?;
                exported.bytes += end.len() as u64;
            }
            Ok((exported, listed))
        })
        .collect::<Result<_, ExportError>>()?;
    let mut sum = Exported::default();
    for (one, _) in &exported {
        sum = Exported { pairs: sum.pairs + one.pairs, files: sum.files + one.files, bytes: sum.bytes + one.bytes };
    }
    let least = options.layout.least_pairs();
    if sum.pairs < least {
        return Err(ExportError::TooFew { layout: options.layout.name(), least, pairs: sum.pairs });
    }
    let listed: Vec<String> = exported.into_iter().flat_map(|(_, listed)| listed).collect();
    for (path, bytes) in options.layout.closing(&listed) {
        write(&root.join(path), &bytes, true)?;
        sum.files += 1;
        sum.bytes += bytes.len() as u64;
    }
    Ok(sum)
}

/// The files of one sample.
fn sample(
    dataset: &Dataset<'_>,
    record: &SampleRecord,
    [number, in_region]: [usize; 2],
    options: &Options,
) -> Result<Vec<Coded>, ExportError> {
    let id = || record.id().to_owned();
    let whole = Pair::read(dataset, record, options.layout == Layout::Us3d)?;
    let mut pair = if options.downsample > 1 { whole.downsampled(options.downsample) } else { whole };
    if let Some(overlap) = options.overlap {
        pair = pair.overlap(overlap).map_err(|e| ExportError::Nothing { id: id(), what: e.to_string() })?;
    }
    let [width, height] = [pair.camera.left.width_px, pair.camera.left.height_px];
    if width == 0 || height == 0 {
        return Err(ExportError::Nothing { id: id(), what: "nothing is left of the frame".to_owned() });
    }
    let tiles = match options.tile {
        None => vec![([0, 0], pair)],
        Some(side) if side > width || side > height => {
            let what = format!("a tile of {side} px does not fit into {width} x {height} px");
            return Err(ExportError::Nothing { id: id(), what });
        }
        Some(side) => {
            let places = (0..height / side).flat_map(|j| (0..width / side).map(move |i| [j, i]));
            places.map(|[j, i]| ([j, i], pair.window([i * side; 2], j * side, side, side))).collect()
        }
    };
    let count = tiles.len();
    tiles
        .into_iter()
        .enumerate()
        .map(|(k, (tile, mut pair))| {
            if count > 1 {
                pair.name = format!("{}_t{:02}-{:02}", pair.name, tile[0], tile[1]);
            }
            let place = Place { number: number * count + k, in_region: in_region * count + k, sample: number, tile };
            options.layout.code(&pair, place)
        })
        .collect()
}

/// Writes a file, or goes on with one that was begun.
fn write(path: &Path, bytes: &[u8], first: bool) -> Result<(), ExportError> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|e| failed(folder, e))?;
    }
    let mut options = std::fs::OpenOptions::new();
    let file = if first { options.write(true).create(true).truncate(true) } else { options.append(true) };
    file.open(path).and_then(|mut file| file.write_all(bytes)).map_err(|e| failed(path, e))
}

fn failed(path: &Path, reason: io::Error) -> ExportError {
    ExportError::Write { path: path.to_owned(), reason }
}
