//! What the command line takes. Doc comments are what `--help` prints, so names stand in them without backticks.

#![allow(clippy::doc_markdown)]

use super::shard::ShardChoice;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum};
use satseed::evaluate::{self, Limit};
use satseed::export::{Layout, Overlap};
use satseed::recipe::{Changes, Recipe, RecipeError};
use satseed::sweep::Vary;
use std::path::PathBuf;

/// Synthetic satellite-stereo datasets from seeds, with exact labels.
///
/// A recipe and a seed go in; stereo pairs with exact labels come out, the same bytes on every machine.
#[derive(Debug, Parser)]
#[command(name = "satseed", version, propagate_version = true, subcommand_required = true)]
pub(crate) struct Cli {
    #[command(flatten)]
    pub(crate) logging: LoggingArgs,
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// List the recipes that come with the program, or show one
    Presets(PresetsArgs),
    /// Print the scenes and pairs of a recipe without making them
    Plan(PlanArgs),
    /// Make a dataset; the same command again resumes it
    Generate(GenerateArgs),
    /// Make one picture of a scene
    Preview(PreviewArgs),
    /// Write a scene as a 3-D model, a point cloud or height maps
    Scene(SceneArgs),
    /// Join what the shards of one plan wrote
    Merge(MergeArgs),
    /// Check a dataset's files against their hashes
    Verify(VerifyArgs),
    /// Tell what a dataset holds
    Info(InfoArgs),
    /// Tell what one pixel saw: hit, object, projection, occluder
    Explain(ExplainArgs),
    /// Hold predicted disparities against a dataset's labels
    Evaluate(EvaluateArgs),
    /// Make one dataset for each value of a parameter, with the same scenes and pairs in all
    Sweep(SweepArgs),
    /// Write a dataset in the layout that another loader reads
    Export(ExportArgs),
    /// Make the page that shows a dataset again, or elsewhere
    Gallery(GalleryArgs),
    /// Print a completion script for a shell
    Completions(CompletionsArgs),
}

#[derive(Debug, Args)]
pub(crate) struct LoggingArgs {
    /// How logs on stderr look
    #[arg(long, global = true, value_enum, default_value_t = LogFormat::Text, help_heading = "Logging")]
    pub(crate) log_format: LogFormat,
    /// Tell more (twice: even more)
    #[arg(short, long, global = true, action = clap::ArgAction::Count, help_heading = "Logging")]
    pub(crate) verbose: u8,
    /// Tell errors only (twice: nothing)
    #[arg(short, long, global = true, action = clap::ArgAction::Count, conflicts_with = "verbose", help_heading = "Logging")]
    pub(crate) quiet: u8,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum LogFormat {
    /// One line of text each
    Text,
    /// One JSON object a line
    Json,
}

/// A recipe and what is changed of it.
#[derive(Debug, Args)]
pub(crate) struct RecipeArgs {
    /// A preset's name (see `satseed presets`) or the path of a TOML file
    pub(crate) recipe: String,
    /// Seed of the recipe; the scenes' seeds follow from it
    #[arg(long, value_name = "N", allow_negative_numbers = true, conflicts_with = "seeds")]
    pub(crate) seed: Option<u64>,
    /// Seed list whose scenes replace the recipe's: `region[/variant] seed [key=value ...]` a line
    #[arg(long, value_name = "FILE")]
    pub(crate) seeds: Option<PathBuf>,
    /// Override a key of the recipe, such as camera.gsd_m=0.5 or scene.canyon.relief_m=150
    #[arg(long, value_name = "K=V")]
    pub(crate) set: Vec<String>,
}

impl RecipeArgs {
    /// The recipe that the arguments name.
    pub(crate) fn load(&self) -> Result<Recipe, RecipeError> {
        Recipe::load(&self.recipe, &self.changes())
    }

    /// What they change of it.
    pub(crate) fn changes(&self) -> Changes {
        Changes { set: self.set.clone(), seed: self.seed, seed_list: self.seeds.clone() }
    }
}

#[derive(Debug, Args)]
pub(crate) struct PresetsArgs {
    #[command(subcommand)]
    pub(crate) command: Option<PresetsCommand>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum PresetsCommand {
    /// List all presets (the default)
    List,
    /// Print the JSON schema of recipes, for editors
    Schema,
    /// Print a preset's text
    Show {
        /// The preset
        name: String,
    },
}

#[derive(Debug, Args)]
pub(crate) struct PlanArgs {
    #[command(flatten)]
    pub(crate) recipe: RecipeArgs,
    /// A table of scenes with totals, or one JSON object a pair
    #[arg(long, value_enum, default_value_t = PlanFormat::Table)]
    pub(crate) format: PlanFormat,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PlanFormat {
    /// A table of scenes with totals
    Table,
    /// One JSON object a pair
    Jsonl,
}

#[derive(Debug, Args)]
pub(crate) struct GenerateArgs {
    #[command(flatten)]
    pub(crate) recipe: RecipeArgs,
    /// Where the dataset goes: new, empty, or what holds this plan already. A folder, or s3://BUCKET/PREFIX,
    /// gs://BUCKET/PREFIX, az://CONTAINER/PREFIX
    #[arg(long, value_name = "DIR|URL")]
    pub(crate) out: PathBuf,
    /// Threads that trace; as many as there are cores by default. As many more build the next scene beside them, unless
    /// N is 1, and as many write files. Changes no byte
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub(crate) jobs: Option<u32>,
    /// Make only part I of N of the pairs, I from 1; merge joins them. In a job array: auto takes I and N from Slurm,
    /// auto/N takes I from Slurm (1 to N) or from a Kubernetes indexed job
    #[arg(long, value_name = "I/N|auto[/N]")]
    pub(crate) shard: Option<ShardChoice>,
    /// Print pairs, bytes, memory, time and what more of the kind would cost, and write nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Refuse to start if more memory could be needed, such as 8GiB. Where it is too little for two scenes at once, no
    /// scene is built ahead
    #[arg(long, value_name = "BYTES", value_parser = bytes)]
    pub(crate) max_memory: Option<u64>,
    /// Print time, rays and memory by stage on stderr at the end, and write them to a file. Changes no byte
    #[arg(long, value_name = "FILE.json", conflicts_with = "dry_run")]
    pub(crate) profile: Option<PathBuf>,
}

/// One scene: a region of a recipe, and a seed.
#[derive(Debug, Args)]
pub(crate) struct OneSceneArgs {
    /// A preset's name (see `satseed presets`) or the path of a TOML file
    pub(crate) recipe: String,
    /// The region, such as canyon
    #[arg(long, value_name = "R")]
    pub(crate) region: String,
    /// The region's variant; the recipe's own by default
    #[arg(long, value_name = "V")]
    pub(crate) variant: Option<String>,
    /// Seed of the scene, as it stands in its name; that of the recipe's first scene of the region by default
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) seed: Option<u64>,
    /// Override a key of the recipe, such as scene.canyon.relief_m=150
    #[arg(long, value_name = "K=V")]
    pub(crate) set: Vec<String>,
}

#[derive(Debug, Args)]
pub(crate) struct PreviewArgs {
    #[command(flatten)]
    pub(crate) scene: OneSceneArgs,
    /// From where
    #[arg(long, value_enum, default_value_t = View::Nadir)]
    pub(crate) view: View,
    /// Width and height of the picture, px
    #[arg(long, value_name = "PX", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(8..=16384))]
    pub(crate) size: u32,
    /// The picture
    #[arg(short, long = "output", value_name = "FILE.png")]
    pub(crate) output: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct SceneArgs {
    #[command(flatten)]
    pub(crate) scene: OneSceneArgs,
    /// For a point cloud: which pair, such as b03-a17; the scene's first by default
    #[arg(long, value_name = "PAIR")]
    pub(crate) pair: Option<String>,
    /// What its ending says: .glb is the scene as a 3-D model, .ply a pair's surface points with colour, .tif the height of
    /// the first surface from above, with that of the bare ground beside it as FILE-dtm.tif
    #[arg(short, long = "output", value_name = "FILE.glb|.ply|.tif")]
    pub(crate) output: PathBuf,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum View {
    /// Straight down, as a pair's frame
    Nadir,
    /// From the side
    Oblique,
}

#[derive(Debug, Args)]
pub(crate) struct MergeArgs {
    /// The dataset that the shards wrote into, a folder or URL; with --from it may be new
    #[arg(value_name = "DIR|URL")]
    pub(crate) dir: PathBuf,
    /// A folder or URL that some shards wrote into instead; may be given several times
    #[arg(long, value_name = "DIR|URL")]
    pub(crate) from: Vec<PathBuf>,
    /// Leave out the card and the gallery, for which every sample is read
    #[arg(long)]
    pub(crate) no_pages: bool,
    /// How many files are asked for at once; as many as there are cores by default, 32 in object storage
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub(crate) jobs: Option<u32>,
}

#[derive(Debug, Args)]
pub(crate) struct VerifyArgs {
    /// The dataset: a folder or URL
    #[arg(value_name = "DIR|URL")]
    pub(crate) dir: PathBuf,
    /// Make N samples again from their seeds and compare
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) regenerate: u32,
    /// Print findings as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// The dataset: a folder or URL
    #[arg(value_name = "DIR|URL")]
    pub(crate) dir: PathBuf,
    /// Print as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Print the seed list that makes the same scenes
    #[arg(long, conflicts_with = "json")]
    pub(crate) seeds: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ExplainArgs {
    /// Folder of the dataset
    pub(crate) dir: PathBuf,
    /// The sample, such as canyon-gorge-42/b03-a17
    #[arg(long, value_name = "ID")]
    pub(crate) sample: String,
    /// Column and row in the left image, from 0
    #[arg(long, value_name = "U,V", value_parser = pixel)]
    pub(crate) pixel: [u32; 2],
}

#[derive(Debug, Args)]
pub(crate) struct EvaluateArgs {
    /// Folder of the dataset, or of a sweep
    pub(crate) dir: PathBuf,
    /// Folder of the predictions: `<scene>/<sample>.pfm`, .tif, .npy or .png (16 bits), or with `__` for the slash; of a sweep,
    /// a folder for each cell
    #[arg(long, value_name = "DIR")]
    pub(crate) predictions: PathBuf,
    /// DIR is another dataset, in the layout in which it is given out
    #[arg(long, value_enum, value_name = "LAYOUT")]
    pub(crate) truth_layout: Option<TruthLayout>,
    /// Only samples of this split, such as test
    #[arg(long, value_name = "S")]
    pub(crate) split: Option<String>,
    /// What the numbers of a 16-bit PNG are divided by
    #[arg(long, value_name = "N", default_value_t = 256.0, value_parser = scale)]
    pub(crate) png_scale: f64,
    /// Write everything that is measured as JSON
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    /// Write a report with plots and the worst samples, one file that needs no network
    #[arg(long, value_name = "FILE.html")]
    pub(crate) report: Option<PathBuf>,
    /// Exit with 1 where a metric is above a value, such as noc.epe_px=1.5, all.d1=0.05 or boundary.bad_1=0.3
    #[arg(long, value_name = "METRIC=VALUE")]
    pub(crate) fail_above: Vec<Limit>,
}

#[derive(Debug, Args)]
pub(crate) struct ExportArgs {
    /// Folder of the dataset
    pub(crate) dir: PathBuf,
    /// For which loader; docs/export.md tells what each is
    #[arg(long, value_name = "NAME", value_parser = layouts())]
    pub(crate) layout: Layout,
    /// Folder to write, new or empty
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Only what both views show of the ground at the pivot's height; `overlap:lowest` and `overlap:METRES` choose another
    /// height
    #[arg(long, value_name = "overlap", value_parser = overlap)]
    pub(crate) crop: Option<Overlap>,
    /// One pixel for K by K; disparity in pixels shrinks with them
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=64))]
    pub(crate) downsample: u32,
    /// Cut into square tiles of N px, the same windows of both views; what fills no tile is left out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..))]
    pub(crate) tile: Option<u32>,
    /// Only samples of this split, such as test
    #[arg(long, value_name = "S")]
    pub(crate) split: Option<String>,
}

#[derive(Debug, Args)]
pub(crate) struct SweepArgs {
    #[command(flatten)]
    pub(crate) recipe: RecipeArgs,
    /// Folder of the sweep: one dataset a cell, and sweep.json
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// What takes which values: KEY=FROM:TO:COUNT or KEY=VALUE,VALUE; several make a grid
    #[arg(long, value_name = "KEY=VALUES", required = true)]
    pub(crate) vary: Vec<Vary>,
    /// Threads that trace; as many as there are cores by default. Changes no byte
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub(crate) jobs: Option<u32>,
    /// Print the cells with their pairs, bytes and time, and write nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
}

#[derive(Debug, Args)]
pub(crate) struct GalleryArgs {
    /// Folder of the dataset
    pub(crate) dir: PathBuf,
    /// The page; gallery.html in the dataset's folder by default, where it can also show whole images
    #[arg(short, long = "output", value_name = "FILE.html")]
    pub(crate) output: Option<PathBuf>,
}

fn layouts() -> impl TypedValueParser<Value = Layout> {
    let by_name = |name: String| Layout::ALL.into_iter().find(|l| l.name() == name).ok_or("no layout has this name");
    PossibleValuesParser::new(Layout::ALL.map(Layout::name)).try_map(by_name)
}

fn overlap(text: &str) -> Result<Overlap, String> {
    match text.split_once(':') {
        None if text == "overlap" => Ok(Overlap::Pivot),
        Some(("overlap", "lowest")) => Ok(Overlap::Lowest),
        Some(("overlap", height)) => match height.parse::<f64>() {
            Ok(height_m) if height_m.is_finite() => Ok(Overlap::HeightM(height_m)),
            _ => Err(format!("`{height}` is no height in metres; write overlap, overlap:lowest or overlap:85.5")),
        },
        _ => Err("a crop is overlap, overlap:lowest or overlap:METRES".to_owned()),
    }
}

/// Layouts of other datasets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum TruthLayout {
    /// Urban Semantic 3D, data fusion contest 2019
    Us3d,
    /// WHU-Stereo
    Whu,
    /// Middlebury 2014 as in `MiddEval3`
    Middlebury,
    /// ETH3D, two views
    Eth3d,
    /// KITTI 2015 or 2012
    Kitti,
}

impl From<TruthLayout> for evaluate::TruthLayout {
    fn from(layout: TruthLayout) -> Self {
        match layout {
            TruthLayout::Us3d => Self::Us3d,
            TruthLayout::Whu => Self::Whu,
            TruthLayout::Middlebury => Self::Middlebury,
            TruthLayout::Eth3d => Self::Eth3d,
            TruthLayout::Kitti => Self::Kitti,
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct CompletionsArgs {
    /// The shell
    pub(crate) shell: clap_complete::Shell,
}

/// `8000000`, `8GB` (thousands), `8GiB` or `8G` (1024s).
fn bytes(text: &str) -> Result<u64, String> {
    let digits = text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let (number, unit) = text.split_at(digits);
    let factor = match unit.to_ascii_lowercase().as_str() {
        "" | "b" => 1,
        "k" | "kib" => 1 << 10,
        "kb" => 1_000,
        "m" | "mib" => 1 << 20,
        "mb" => 1_000_000,
        "g" | "gib" => 1 << 30,
        "gb" => 1_000_000_000,
        "t" | "tib" => 1 << 40,
        "tb" => 1_000_000_000_000,
        _ => 0,
    };
    let bytes = number.parse::<u64>().ok().and_then(|n| n.checked_mul(factor)).filter(|n| *n > 0);
    bytes.ok_or_else(|| "a size is a number of bytes such as 8000000000, 8GB or 8GiB".to_owned())
}

/// A positive number.
fn scale(text: &str) -> Result<f64, String> {
    let scale = text.parse::<f64>().ok().filter(|s| s.is_finite() && *s > 0.0);
    scale.ok_or_else(|| "a scale is a positive number such as 256".to_owned())
}

/// `812,40`
fn pixel(text: &str) -> Result<[u32; 2], String> {
    let parse = || {
        let (u, v) = text.split_once(',')?;
        Some([u.trim().parse().ok()?, v.trim().parse().ok()?])
    };
    parse().ok_or_else(|| "a pixel is column and row, such as 812,40".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    #[test]
    fn the_definition_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn sizes_and_pixels() {
        assert_eq!(bytes("17"), Ok(17));
        assert_eq!(bytes("2GB"), Ok(2_000_000_000));
        assert_eq!(bytes("2GiB"), Ok(2 << 30));
        assert_eq!(bytes("2g"), Ok(2 << 30));
        for bad in ["", "0", "-1", "GB", "2 GB", "2X", "99999999999999999999", "20000000T"] {
            assert!(bytes(bad).is_err(), "{bad}");
        }
        assert_eq!(scale("32"), Ok(32.0));
        for bad in ["", "0", "-1", "nan", "inf", "x"] {
            assert!(scale(bad).is_err(), "{bad}");
        }
        assert_eq!(pixel("812,40"), Ok([812, 40]));
        for bad in ["", "1", "1,", "1,2,3", "-1,2", "1.5,2"] {
            assert!(pixel(bad).is_err(), "{bad}");
        }
    }
}
