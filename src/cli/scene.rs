//! `satseed scene`

use super::Exit;
use super::args::SceneArgs;
use super::new_file::NewFile;
use super::one_scene::OneScene;
use super::output::bytes_text;
use anyhow::Context as _;
use satseed::model::{About, PointCloud, glb, height_files};
use satseed::pipeline::{BuiltScene, build_scene, make_sample};
use satseed::plan::{PairSpec, SceneSpec};
use satseed_scene::Scene;
use std::path::{Path, PathBuf};

/// What a point cloud is made of, whatever else the recipe writes.
const LABELS_OF_POINTS: [&str; 2] =
    [r#"labels.write=["disparity_right", "class"]"#, r#"labels.disparity_precision="full""#];

/// Which file is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Glb,
    Ply,
    Tif,
}

impl Kind {
    fn of(path: &Path) -> anyhow::Result<Self> {
        let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        match extension.as_deref() {
            Some("glb") => Ok(Self::Glb),
            Some("ply") => Ok(Self::Ply),
            Some("tif" | "tiff") => Ok(Self::Tif),
            _ => anyhow::bail!(
                "{} has no ending that is known: .glb is a 3-D model, .ply a point cloud, .tif a height map",
                path.display()
            ),
        }
    }
}

pub(crate) fn run(args: &SceneArgs) -> anyhow::Result<Exit> {
    let kind = Kind::of(&args.output)?;
    if args.pair.is_some() && kind != Kind::Ply {
        anyhow::bail!(
            "--pair names the pair of a point cloud (.ply); {} shows the scene itself",
            args.output.display()
        );
    }
    let one = OneScene::of(&args.scene, if kind == Kind::Ply { &LABELS_OF_POINTS } else { &[] })?;
    let pair = match kind {
        Kind::Ply => Some(pair(&one, args.pair.as_deref())?),
        Kind::Glb | Kind::Tif => None,
    };
    let output = NewFile::create(&args.output)?;
    let written = match (kind, pair) {
        (Kind::Tif, _) => {
            let beside = NewFile::create(&beside(&args.output))?;
            let scene = build(&one.spec)?;
            let files = height_files(&scene, one.spec.region.full_detail_radius_m(), one.recipe.camera().gsd_m)?;
            let filled = [output.fill(&files.dsm)?, beside.fill(&files.dtm)?];
            filled.into_iter().try_for_each(super::new_file::Filled::keep)?;
            files.dsm.len() + files.dtm.len()
        }
        (Kind::Ply, Some(pair)) => {
            let scene = build(&one.spec)?;
            let sample = make_sample(&BuiltScene::new(&one.recipe, &one.spec, &scene), pair)?;
            let cloud = PointCloud::of(&sample)?;
            tracing::info!(sample = cloud.sample, points = cloud.points.len(), "point cloud made");
            let bytes = cloud.ply(&about(&one.spec));
            output.finish(&bytes)?;
            bytes.len()
        }
        _ => {
            let bytes = glb(&build(&one.spec)?, &about(&one.spec))?;
            output.finish(&bytes)?;
            bytes.len()
        }
    };
    tracing::info!(file = %args.output.display(), size = bytes_text(written as u64), "written");
    Ok(Exit::Fine)
}

fn build(spec: &SceneSpec) -> anyhow::Result<Scene> {
    let scene = build_scene(spec)?;
    let (held, placed) = scene.triangle_counts();
    tracing::info!(scene = spec.name, triangles = held, placed, "scene built");
    Ok(scene)
}

/// The pair by the name of its folder; the first where none is named.
fn pair<'s>(one: &'s OneScene, name: Option<&str>) -> anyhow::Result<&'s PairSpec> {
    one.spec.check_frames(&one.recipe)?;
    let pairs = &one.spec.pairs;
    let found = name.map_or_else(|| pairs.first(), |name| pairs.iter().find(|p| p.folder() == name));
    found.with_context(|| {
        let (name, first) = (name.unwrap_or_default(), pairs.first().map_or("none", PairSpec::folder));
        format!("scene {} has no pair `{name}`; it has {} of them, the first is {first}", one.spec.name, pairs.len())
    })
}

fn about(spec: &SceneSpec) -> About {
    About {
        scene: spec.name.clone(),
        region: spec.region.name().to_owned(),
        variant: spec.region.variant().to_owned(),
        seed: spec.seed,
        generator_version: spec.region.version(),
        params_hash: spec.params_hash.clone(),
    }
}

/// `out/town.tif` gives `out/town-dtm.tif`.
fn beside(path: &Path) -> PathBuf {
    let (stem, extension) = (path.file_stem().unwrap_or_default(), path.extension().unwrap_or_default());
    let mut name = stem.to_owned();
    name.push("-dtm.");
    name.push(extension);
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endings_say_what_is_meant() {
        assert_eq!(Kind::of(Path::new("a/b.GLB")).unwrap(), Kind::Glb);
        assert_eq!(Kind::of(Path::new("b.tiff")).unwrap(), Kind::Tif);
        for bad in ["a", "a.gltf", ".glb", "a.glb.gz", "a."] {
            let told = Kind::of(Path::new(bad)).unwrap_err().to_string();
            assert!(told.starts_with(bad) && told.contains(".ply a point cloud"), "{told}");
        }
        assert_eq!(beside(Path::new("out/a.b.tif")), Path::new("out/a.b-dtm.tif"));
    }
}
