//! One pair of a scene: two views traced, rendered and labelled.

use super::PipelineError;
use super::contents::{image_pixels, layer_of};
use super::profile::{Meter, Stage};
use super::scene::BuiltScene;
use crate::camera::{Camera, RigSpec, StereoRig};
use crate::dataset::formats::{Pixels, Plane, round_to_256th};
use crate::dataset::{CameraFile, CameraRecord, Identity, Layer, Sample, View};
use crate::labels::{Extra, Validity, View as LabelView, ViewLabels, extract};
use crate::plan::PairSpec;
use crate::recipe::{DisparityPrecision, Label, Labels};
use crate::render::{Exposure, develop, expose};
use glam::DVec3;
use satseed_scene::SeedPath;

/// Traces, renders and labels one pair. Rows run in parallel on the current rayon pool; the result does not depend on it.
///
/// # Errors
/// Where the scene has a hole: a pixel of a labelled view whose ray meets nothing.
pub fn make_sample(scene: &BuiltScene<'_>, pair: &PairSpec) -> Result<Sample, PipelineError> {
    sample(scene, pair, &Meter::default())
}

/// [`make_sample`], with an account of its stages.
pub(super) fn sample(scene: &BuiltScene<'_>, pair: &PairSpec, meter: &Meter) -> Result<Sample, PipelineError> {
    let rig = rig(scene, pair);
    let labels = scene.recipe.labels();
    let mut planes = Vec::new();
    let mut exposures = Vec::new();
    for view in [View::Left, View::Right] {
        if view == View::Left || !labels.write.is_empty() {
            let made = meter.traced(Stage::Labels, &scene.tracer, || {
                let maps = label_maps(scene, &rig, view);
                refuse_hole(&maps, &pair.id, view)?;
                let with_disparity = view == View::Left || labels.has(Label::DisparityRight);
                Ok::<_, PipelineError>(label_planes(maps, labels, with_disparity))
            })?;
            planes.extend(made.into_iter().map(|(layer, plane)| (layer, view, plane)));
        }
        exposures.push(meter.traced(Stage::Render, &scene.tracer, || exposure(scene, pair, &rig, view)));
    }
    let sensor = scene.recipe.sensor().imager;
    let images = meter.traced(Stage::Render, &scene.tracer, || develop(exposures, sensor));
    for (view, image) in [View::Left, View::Right].into_iter().zip(images) {
        let (width, height) = (image.width, image.height);
        planes.push((Layer::Image, view, Plane { width, height, pixels: image_pixels(image) }));
    }
    planes.sort_by_key(|(layer, view, _)| (*layer, *view));
    Ok(Sample { identity: identity(scene, pair, &rig), camera: camera_file(&rig, pair), planes })
}

/// The rig of a pair.
pub fn rig(scene: &BuiltScene<'_>, pair: &PairSpec) -> StereoRig {
    let camera = scene.recipe.camera();
    StereoRig::new(RigSpec {
        altitude_m: camera.altitude_m,
        gsd_m: camera.gsd_m,
        size_px: camera.size_px,
        baseline_m: pair.baseline_m,
        azimuth_rad: pair.azimuth_deg.to_radians(),
        pivot_along_baseline: pair.pivot_along_baseline,
        pivot_m: DVec3::new(0.0, 0.0, scene.tracer.scene().pivot_height_m),
        datum: scene.datum,
    })
}

fn exposure(scene: &BuiltScene<'_>, pair: &PairSpec, rig: &StereoRig, view: View) -> Exposure {
    let camera = match view {
        View::Left => &rig.left,
        View::Right => &rig.right,
    };
    // The noise of an image is keyed by who it is, so it is the same in shards and when one sample is made again.
    let noise = SeedPath::root("sensor", scene.spec.seed).child(&pair.id).child(view.name());
    expose(&scene.tracer, camera, &scene.light, scene.recipe.sensor().settings(), &noise)
}

fn label_maps(scene: &BuiltScene<'_>, rig: &StereoRig, view: View) -> ViewLabels {
    let labels = scene.recipe.labels();
    let extra = Extra {
        elevation: labels.has(Label::Elevation),
        class: labels.has(Label::Class),
        instance: labels.has(Label::Instance),
        normal: labels.has(Label::Normal),
        shadow: labels.has(Label::Shadow),
        edge: labels.has(Label::Edge),
    };
    let label_view = match view {
        View::Left => LabelView::Left,
        View::Right => LabelView::Right,
    };
    extract(&scene.tracer, rig, label_view, &scene.environment, extra)
}

/// A plan refuses frames that see beyond a scene's full detail, and what a sloping ray meets behind that is the ring of
/// terrain around it. So a ray of a planned frame that meets nothing is nobody's wish, and is not written as a label.
fn refuse_hole(maps: &ViewLabels, id: &str, view: View) -> Result<(), PipelineError> {
    let mut holes = (0..maps.validity.len()).filter(|i| maps.validity[*i] == Validity::Miss as u8);
    let Some(first) = holes.next() else { return Ok(()) };
    let pixel = [first as u32 % maps.width, first as u32 / maps.width];
    let others = holes.count();
    Err(PipelineError::Hole { id: id.to_owned(), view: view.name(), pixel, others })
}

fn label_planes(maps: ViewLabels, labels: &Labels, with_disparity: bool) -> Vec<(Layer, Plane)> {
    let (width, height) = (maps.width, maps.height);
    let mut disparity_px = maps.disparity_px;
    if labels.disparity_precision == DisparityPrecision::Px256th {
        for d in &mut disparity_px {
            *d = round_to_256th(*d);
        }
    }
    let normal = |n: Vec<[f32; 3]>| n.into_iter().flatten().map(quantise_unit).collect();
    let mut all = Vec::new();
    if with_disparity {
        all.push((Layer::Disparity, Some(Pixels::Float(disparity_px))));
        all.push((Layer::Validity, Some(Pixels::Gray(maps.validity))));
    }
    all.push((layer_of(Label::Elevation), maps.elevation_m.map(Pixels::Float)));
    all.push((layer_of(Label::Class), maps.class.map(Pixels::Gray)));
    all.push((layer_of(Label::Instance), maps.instance.map(Pixels::Id)));
    all.push((layer_of(Label::Normal), maps.normal.map(|n| Pixels::Vector(normal(n)))));
    all.push((layer_of(Label::Shadow), maps.shadow.map(Pixels::Gray)));
    all.push((layer_of(Label::Edge), maps.edge.map(Pixels::Gray)));
    all.into_iter().filter_map(|(layer, pixels)| Some((layer, Plane { width, height, pixels: pixels? }))).collect()
}

/// A component of a unit vector as the normal label stores it: times 32767, to the nearest.
fn quantise_unit(x: f32) -> i16 {
    (x.clamp(-1.0, 1.0) * 32767.0).round_ties_even() as i16
}

fn identity(scene: &BuiltScene<'_>, pair: &PairSpec, rig: &StereoRig) -> Identity {
    Identity {
        id: pair.id.clone(),
        region: scene.spec.region.name().to_owned(),
        variant: scene.spec.region.variant().to_owned(),
        scene_seed: scene.spec.seed,
        split: pair.split.word().to_owned(),
        scene_params_hash: scene.spec.params_hash.clone(),
        baseline_m: pair.baseline_m,
        azimuth_deg: pair.azimuth_deg,
        convergence_deg: rig.convergence_rad().to_degrees(),
    }
}

fn camera_file(rig: &StereoRig, pair: &PairSpec) -> CameraFile {
    CameraFile {
        left: camera_record(&rig.left),
        right: camera_record(&rig.right),
        baseline_m: rig.spec.baseline_m,
        altitude_m: rig.spec.altitude_m,
        gsd_m: rig.spec.gsd_m,
        azimuth_deg: pair.azimuth_deg,
        convergence_deg: rig.convergence_rad().to_degrees(),
        convergence_at_pivot_deg: rig.convergence_at_pivot_rad().to_degrees(),
        doffs_px: rig.doffs_px(),
        disparity_range_px: None,
    }
}

fn camera_record(camera: &Camera) -> CameraRecord {
    let m = &camera.world_from_camera;
    // A negative zero says nothing to a reader of the file.
    let plain = |x: f64| x + 0.0;
    CameraRecord {
        width_px: camera.width_px,
        height_px: camera.height_px,
        fx_px: camera.fx_px,
        fy_px: camera.fy_px,
        cx_px: camera.cx_px,
        cy_px: camera.cy_px,
        position_m: camera.position_m.to_array().map(plain),
        world_from_camera: std::array::from_fn(|r| [m.x_axis[r], m.y_axis[r], m.z_axis[r]].map(plain)),
        projection: camera.projection().map(|row| row.map(plain)),
    }
}
