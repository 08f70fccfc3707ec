//! `satseed explain`

use super::Exit;
use super::args::ExplainArgs;
use super::output::write_stdout;
use super::verify::planned;
use anyhow::Context as _;
use glam::DVec3;
use satseed::dataset::DiskStore;
use satseed::labels::{Explanation, Seen, Validity, View, explain};
use satseed::pipeline::{BuiltScene, rig};
use std::io::{self, Write};

pub(crate) fn run(args: &ExplainArgs) -> anyhow::Result<Exit> {
    let store = DiskStore::open(&args.dir)?;
    let (recipe, plan) = planned(&store, &args.dir).context("a pixel is explained by tracing it again")?;
    let (spec, pair) = plan
        .pairs()
        .find(|(_, pair)| pair.id == args.sample)
        .with_context(|| format!("the dataset has no sample `{}`; its manifest lists what there is", args.sample))?;
    let [width, height] = recipe.camera().size_px;
    let [u, v] = args.pixel;
    if u >= width || v >= height {
        anyhow::bail!("pixel {u},{v} is outside the image: columns are 0 to {}, rows 0 to {}", width - 1, height - 1);
    }
    let scene = spec.region.build(spec.seed);
    let built = BuiltScene::new(&recipe, spec, &scene);
    let told = explain(&built.tracer, &rig(&built, pair), View::Left, args.pixel);
    write_stdout(|out| write_text(out, &args.sample, args.pixel, &told))?;
    Ok(Exit::Fine)
}

fn write_text(out: &mut dyn Write, sample: &str, [u, v]: [u32; 2], told: &Explanation) -> io::Result<()> {
    let verdict = match told.validity {
        Validity::Miss => "miss: the ray met nothing",
        Validity::Valid => "valid: the right camera sees the same point",
        Validity::Occluded => "occluded: something stands between the point and the right camera",
        Validity::OutOfFrame => "out of frame: the point projects outside the right image",
    };
    writeln!(out, "{sample}, left pixel {u},{v}: {verdict}")?;
    let Some(seen) = &told.seen else { return Ok(()) };
    write_seen(out, "seen", "from the left camera", seen)?;
    if let Some(d) = told.disparity_px {
        writeln!(out, "disparity  {d} px (u_L - u_R), {} as f32", d as f32)?;
    }
    if let Some(p) = told.in_other_px {
        writeln!(out, "in right   {:.6}, {:.6} px", p.x, p.y)?;
    }
    told.occluder.as_ref().map_or(Ok(()), |o| write_seen(out, "occluder", "from the point seen", o))
}

fn write_seen(out: &mut dyn Write, title: &str, from: &str, seen: &Seen) -> io::Result<()> {
    let show = |p: DVec3| format!("{:.4}, {:.4}, {:.4}", p.x, p.y, p.z);
    let [instance, triangle] = seen.instance_triangle;
    writeln!(out, "{title:10} {} m east, north, up; {:.4} m {from}", show(seen.point_m), seen.distance_m)?;
    writeln!(
        out,
        "           object {} `{}`, {:?}, material `{}`",
        seen.object, seen.object_path, seen.class, seen.material
    )?;
    writeln!(out, "           instance {instance}, triangle {triangle}, normal {}", show(seen.normal))
}
