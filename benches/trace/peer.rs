//! Our side of `benches/peers`: the scene and the rays as plain arrays, then tracing on demand.

use crate::build;
use crate::families::{Family, Frame};
use crate::scenes::Subject;
use satseed_scene::Scene;
use satseed_tracer::Tracer;
use serde_json::json;
use std::fs::File;
use std::io::{self, BufRead, BufWriter, Write};
use std::path::Path;

/// Writes scene, rays and answers into a folder, then traces the families that standard input names and prints a line of
/// JSON for each.
pub(crate) fn serve(subject: Subject, share: u32, folder: &Path) {
    let scene = subject.build();
    let (tracer, built) = build(&scene);
    let frame = Frame::new(&tracer, share);
    export_scene(&scene, folder).expect("the folder can be written");
    for (name, family) in Family::ALL {
        export_family(&frame, &tracer, name, family, folder).expect("the folder can be written");
    }
    let camera = frame.camera();
    println!(
        "{}",
        json!({ "build": built, "camera_m": camera.position_m.to_array(), "focal_px": camera.fx_px,
        "centre_px": [camera.cx_px, camera.cy_px] })
    );
    for line in io::stdin().lock().lines() {
        let line = line.expect("standard input can be read");
        let family = Family::ALL.iter().find(|(name, _)| *name == line).expect("a family").1;
        let (rays, met, cpu) = frame.trace(&tracer, family);
        println!("{}", json!({ "rays": rays, "met": met, "cpu_s": cpu.as_secs_f64() }));
        io::stdout().flush().expect("standard output can be written");
    }
}

/// Vertices and triangles of all meshes one after the other, with where each mesh begins and how long it is; the mesh and
/// the columns of the transform of every instance.
fn export_scene(scene: &Scene, folder: &Path) -> io::Result<()> {
    let vertices: Vec<f32> = scene.meshes.iter().flat_map(|m| m.positions_m.iter().flatten().copied()).collect();
    let triangles: Vec<u32> = scene.meshes.iter().flat_map(|m| m.triangles.iter().flatten().copied()).collect();
    let (mut ranges, mut vertex, mut triangle) = (Vec::new(), 0, 0);
    for m in &scene.meshes {
        let (vertices, triangles) = (m.positions_m.len() as u32, m.triangles.len() as u32);
        ranges.extend([vertex, vertices, triangle, triangles]);
        vertex += vertices;
        triangle += triangles;
    }
    let meshes: Vec<u32> = scene.instances.iter().map(|i| i.mesh).collect();
    let columns = |i: &satseed_scene::Instance| i.world_from_object.to_cols_array().map(|x| x as f32);
    let transforms: Vec<f32> = scene.instances.iter().flat_map(columns).collect();
    npy(&folder.join("vertices.npy"), "<f4", 3, vertices.iter().map(|x| x.to_le_bytes()))?;
    npy(&folder.join("triangles.npy"), "<u4", 3, triangles.iter().map(|x| x.to_le_bytes()))?;
    npy(&folder.join("ranges.npy"), "<u4", 4, ranges.iter().map(|x| x.to_le_bytes()))?;
    npy(&folder.join("meshes.npy"), "<u4", 1, meshes.iter().map(|x| x.to_le_bytes()))?;
    npy(&folder.join("transforms.npy"), "<f4", 12, transforms.iter().map(|x| x.to_le_bytes()))
}

fn export_family(frame: &Frame, tracer: &Tracer, name: &str, family: Family, folder: &Path) -> io::Result<()> {
    let (mut rays, mut answers) = (Vec::new(), Vec::new());
    for batch in frame.batches(family) {
        rays.extend(batch.plain(tracer).into_iter().flatten());
        answers.extend(batch.answers(tracer));
    }
    let kind = if family.is_closest() { "closest" } else { "any" };
    npy(&folder.join(format!("{name}-{kind}.npy")), "<f4", 8, rays.iter().map(|x: &f32| x.to_le_bytes()))?;
    npy(&folder.join(format!("{name}-answers.npy")), "<f4", 1, answers.iter().map(|x: &f32| x.to_le_bytes()))
}

/// Writes an array of four-byte numbers of some columns, as NumPy's format 1.0 says.
fn npy(path: &Path, dtype: &str, columns: usize, values: impl ExactSizeIterator<Item = [u8; 4]>) -> io::Result<()> {
    let shape = match columns {
        1 => format!("({},)", values.len()),
        _ => format!("({}, {columns})", values.len() / columns),
    };
    let header = format!("{{'descr': '{dtype}', 'fortran_order': False, 'shape': {shape}, }}");
    // The header ends with a line break at a multiple of 64 bytes.
    let length = (10 + header.len() + 1).next_multiple_of(64) - 10;
    let mut out = BufWriter::new(File::create(path)?);
    out.write_all(b"\x93NUMPY\x01\x00")?;
    out.write_all(&(length as u16).to_le_bytes())?;
    out.write_all(format!("{header:<width$}\n", width = length - 1).as_bytes())?;
    for value in values {
        out.write_all(&value)?;
    }
    out.flush()
}
