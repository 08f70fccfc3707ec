//! `satseed evaluate` through the program: what is measured on constructed cases, what is said of bad predictions.

#![allow(clippy::unwrap_used)]

use satseed::dataset::{
    Dataset, DiskStore, Layer, View,
    formats::{Pixels, Plane},
};
use satseed::evaluate::{Options, Source, evaluate};
use satseed::pipeline::thread_pool;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};
use support::small;

mod support;

/// A dataset of two scenes and three pairs, made once.
struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let recipe = small::recipe(&small::Recipe {
            gsd_m: 0.8,
            size_px: [48, 40],
            acquisition: "baseline_m = [40.0, 90.0]\nazimuth_deg = [20.0]",
            sensor: "worldview3_rgb",
            scenes: &["toronto = { radius_m = 60.0, trees = 0.0, vehicles = 0.0 }"],
        });
        fs::write(folder.path().join("recipe.toml"), recipe).unwrap();
        let bench = Self { folder };
        let made = bench.run(&["generate", "recipe.toml", "--out", "truth", "--quiet"]);
        assert!(made.status.success(), "{}", text(&made.stderr));
        bench
    }

    fn run(&self, args: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_satseed")).current_dir(self.folder.path()).args(args).output().unwrap()
    }

    fn evaluate(&self, predictions: &str, more: &[&str]) -> (Option<i32>, String) {
        let output = self.run(&[&["evaluate", "truth", "--predictions", predictions], more].concat());
        let said = text(&output.stdout) + &text(&output.stderr);
        assert!(!said.contains("panicked"), "{said}");
        (output.status.code(), said)
    }

    fn report(&self, predictions: &str, code: i32) -> serde_json::Value {
        let (ended, said) = self.evaluate(predictions, &["--json", "report.json"]);
        assert_eq!(ended, Some(code), "{said}");
        serde_json::from_str(&fs::read_to_string(self.folder.path().join("report.json")).unwrap()).unwrap()
    }

    /// Ids, true disparities and validity.
    fn truth(&self) -> Vec<(String, Vec<f32>, Vec<u8>)> {
        let store = DiskStore::open(&self.folder.path().join("truth")).unwrap();
        let dataset = Dataset::open(&store).unwrap();
        let one = |record: &satseed::dataset::SampleRecord| {
            let camera = dataset.camera(record).unwrap();
            let plane = |layer| dataset.plane(record, &camera, layer, View::Left).unwrap().pixels;
            let (Pixels::Float(d), Pixels::Gray(v)) = (plane(Layer::Disparity), plane(Layer::Validity)) else {
                panic!("kinds")
            };
            (record.id().to_owned(), d, v)
        };
        dataset.records().iter().map(one).collect()
    }

    /// Writes a prediction for every sample.
    fn predict(&self, predictions: &str, of: impl Fn(usize, f32, u8) -> f32) -> Vec<PathBuf> {
        let write = |(id, d, v): (String, Vec<f32>, Vec<u8>)| {
            let values = d.iter().zip(&v).enumerate().map(|(i, (d, v))| of(i, *d, *v)).collect();
            let path = self.folder.path().join(predictions).join(id + ".tif");
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(&path, Plane { width: 48, height: 40, pixels: Pixels::Float(values) }.encode().unwrap()).unwrap();
            path
        };
        self.truth().into_iter().map(write).collect()
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Predictions whose scores are known without working them out.
#[test]
fn constructed_cases() {
    let bench = Bench::new();
    bench.predict("exact", |_, d, _| d);
    let r = bench.report("exact", 0);
    let count = |value: u8| bench.truth().iter().flat_map(|(_, _, v)| v).filter(|v| **v == value).count();
    let s = &r["total"]["scores"];
    assert!(count(2) > 20 && count(3) > 20, "the scene has something to count");
    assert_eq!(s["noc"]["pixels"], count(1));
    assert_eq!(s["occ"]["pixels"], count(2));
    assert_eq!(s["all"]["pixels"], count(1) + count(2));
    assert_eq!(r["total"]["out_of_frame_pixels"], count(3));
    for set in ["noc", "occ", "all"] {
        assert_eq!((s[set]["epe_px"].as_f64(), s[set]["within_1"].as_f64()), (Some(0.0), Some(1.0)), "{set}");
        assert_eq!((s[set]["bad_1"].as_f64(), s[set]["d1"].as_f64()), (Some(0.0), Some(0.0)), "{set}");
    }
    assert_eq!(r["total"]["boundary"]["see_3_px"].as_f64(), Some(0.0));
    let by: Vec<&String> = r["total"]["by"].as_object().unwrap().keys().collect();
    assert_eq!(by, ["baseline", "boundary_distance", "class", "disparity", "height", "shadow", "slope", "texture"]);
    for (name, breakdown) in r["total"]["by"].as_object().unwrap() {
        let rows = breakdown["rows"].as_array().unwrap();
        let sum: u64 = rows.iter().map(|row| row["all"]["pixels"].as_u64().unwrap()).sum();
        assert_eq!(sum, s["all"]["pixels"].as_u64().unwrap(), "every counted pixel has its place by {name}");
    }
    assert_eq!((r["missing"].as_array().unwrap().len(), r["likely_mistakes"].as_array().unwrap().len()), (0, 0));

    // Two pixels off where both see, four where occluded; out of frame it does not matter what stands there.
    bench.predict("off", |i, d, v| match v {
        1 => d + if i % 2 == 0 { 2.0 } else { -2.0 },
        2 => d + 4.0,
        _ => 1e9,
    });
    let s = bench.report("off", 0)["total"]["scores"].clone();
    let near = |value: &serde_json::Value, x: f64| (value.as_f64().unwrap() - x).abs() < 1e-4;
    assert!(near(&s["noc"]["epe_px"], 2.0) && near(&s["occ"]["epe_px"], 4.0), "{s}");
    assert_eq!((s["noc"]["bad_1"].as_f64(), s["noc"]["bad_3"].as_f64()), (Some(1.0), Some(0.0)));
    assert_eq!((s["occ"]["bad_3"].as_f64(), s["occ"]["within_3"].as_f64()), (Some(1.0), Some(0.0)));

    // Holes: a quarter of the pixels of each kind is not predicted, the others are right.
    bench.predict("holes", |i, d, _| if i % 4 == 0 { f32::NAN } else { d });
    let r = bench.report("holes", 0);
    let s = &r["total"]["scores"]["noc"];
    let holes: usize = bench.truth().iter().map(|(_, _, v)| v.iter().step_by(4).filter(|v| **v == 1).count()).sum();
    let share = holes as f64 / count(1) as f64;
    assert_eq!((s["unpredicted"].as_f64(), s["epe_px"].as_f64()), (Some(share), Some(0.0)));
    assert_eq!((s["bad_3"].as_f64(), s["d1"].as_f64()), (Some(share), Some(share)));
    let (code, said) = bench.evaluate("holes", &["--fail-above", "epe_px=0", "--fail-above", "noc.unpredicted=0.2"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("failed: noc.unpredicted is 0.2") && !said.contains("failed: noc.epe_px"), "{said}");
    assert_eq!(bench.evaluate("holes", &["--fail-above", "epe_px=0"]).0, Some(0));

    // Threads change nothing.
    let store = DiskStore::open(&bench.folder.path().join("truth")).unwrap();
    let dataset = Dataset::open(&store).unwrap();
    let [one, three] = [1, 3].map(|jobs| {
        let folder = bench.folder.path().join("off");
        let run = || evaluate(Source::Dataset(&dataset), &folder, &Options::default(), &|_| {}).unwrap();
        serde_json::to_string(&thread_pool(jobs).unwrap().install(run)).unwrap()
    });
    assert_eq!(one, three);
}

#[test]
fn bad_predictions_are_told_and_counted() {
    let bench = Bench::new();
    let root = bench.folder.path();
    let sentence = |args: &[&str], parts: &[&str]| {
        let output = bench.run(args);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {said}");
        assert!(said.starts_with("error: ") && said.trim_end().lines().count() == 1, "{args:?}: {said}");
        assert!(output.stdout.is_empty());
        for part in parts {
            assert!(said.contains(part), "{args:?}: {said}");
        }
    };
    sentence(&["evaluate", "truth", "--predictions", "nowhere"], &["`nowhere` is no folder"]);
    sentence(&["evaluate", "nowhere", "--predictions", "truth"], &["nowhere"]);
    fs::create_dir(root.join("empty")).unwrap();
    sentence(&["evaluate", "truth", "--predictions", "empty"], &["no prediction for any of the 2 samples", ".pfm"]);
    fs::write(root.join("empty/1.npy"), b"").unwrap();
    sentence(&["evaluate", "truth", "--predictions", "empty"], &["it holds `1.npy` instead"]);
    sentence(&["evaluate", "truth", "--predictions", "empty", "--split", "tset"], &["split `tset`", "it has "]);
    sentence(&["evaluate", "empty", "--predictions", "empty"], &["no `manifest.jsonl`"]);

    let files = bench.predict("bad", |_, d, _| d);
    fs::write(root.join("bad/odd.pfm"), b"").unwrap();
    fs::remove_file(&files[1]).unwrap();
    let r = bench.report("bad", 1);
    assert_eq!((r["missing"].as_array().unwrap().len(), r["evaluated"].as_u64()), (1, Some(1)));
    assert_eq!(r["strangers"][0], "odd.pfm");
    let (_, said) = bench.evaluate("bad", &[]);
    assert!(said.contains("has no prediction") && said.contains("odd.pfm belongs to no sample"), "{said}");

    let unusable = |content: &[u8], extension: &str, part: &str| {
        let path = files[1].with_extension(extension);
        fs::write(&path, content).unwrap();
        let r = bench.report("bad", 1);
        let reason = r["unusable"][0]["reason"].as_str().unwrap().to_owned();
        assert!(reason.contains(part), "{extension}: {reason}");
        assert_eq!((r["evaluated"].as_u64(), r["unusable"].as_array().unwrap().len()), (Some(1), 1));
        fs::remove_file(path).unwrap();
    };
    unusable(b"Pf\n24 20\n-1\n", "pfm", "1/2 of the resolution");
    unusable(b"", "npy", "no NPY");
    unusable(b"", "tif", "cannot be decoded");
    unusable(b"\x89PNG\r\n\x1a\n", "png", "cannot be decoded");
    let nan: Vec<u8> = (0..48 * 40).flat_map(|_| f32::NAN.to_le_bytes()).collect();
    unusable(&[b"Pf\n48 40\n-1\n".as_slice(), &nan].concat(), "pfm", "nothing is predicted");
    let flat =
        root.join("bad").join(files[0].strip_prefix(root.join("bad")).unwrap().to_str().unwrap().replace('/', "__"));
    fs::copy(&files[0], &flat).unwrap();
    fs::copy(&files[0], &files[1]).unwrap();
    let reason = bench.report("bad", 1)["unusable"][0]["reason"].as_str().unwrap().to_owned();
    assert!(reason.contains("several files claim"), "{reason}");
}

/// Whatever stands in a prediction's file, the program ends with 0, 1 or 2, and says why.
#[test]
fn hostile_files_give_a_sentence() {
    let bench = Bench::new();
    let files = bench.predict("hostile", |_, d, _| d);
    let good = fs::read(&files[0]).unwrap();
    let mut draws = blake3::Hasher::new().update(b"hostile").finalize_xof();
    let npy = {
        let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (40, 48), }\n";
        let mut out = b"\x93NUMPY\x01\x00".to_vec();
        out.extend((header.len() as u16).to_le_bytes());
        out.extend(header.bytes());
        out.extend((0..40 * 48 * 4).map(|_| 0_u8));
        out
    };
    for round in 0..60 {
        let (extension, content) = if round % 2 == 0 { ("tif", &good) } else { ("npy", &npy) };
        let mut changed = content.clone();
        let mut word = [0; 8];
        for _ in 0..4 {
            draws.fill(&mut word);
            // Headers and directories more often than pixels.
            let near = u32::from_le_bytes([word[0], word[1], word[2], word[3]]) as usize;
            let at = if word[4] % 2 == 0 { near % 96 } else { near % changed.len() };
            changed[at] = word[5];
        }
        if word[6] % 4 == 0 {
            changed.truncate(near(word, changed.len()));
        }
        let path = files[0].with_extension(extension);
        fs::remove_file(&files[0]).ok();
        fs::write(&path, changed).unwrap();
        let (code, said) = bench.evaluate("hostile", &[]);
        assert!(matches!(code, Some(0..=2)), "{round}: {said}");
        assert!(code != Some(1) || said.contains("cannot be used: "), "{round}: {said}");
        fs::remove_file(path).unwrap();
    }
}

fn near(word: [u8; 8], length: usize) -> usize {
    usize::from(u16::from_le_bytes([word[0], word[1]])) % length
}

/// The report opens without a network, runs nothing, and has a picture of every kind.
#[test]
fn the_report_is_one_file() {
    let bench = Bench::new();
    bench.predict("fair", |i, d, _| if i % 9 == 0 { f32::NAN } else { d + (i % 5) as f32 });
    fs::write(bench.folder.path().join("fair/<script>&.npy"), b"").unwrap();
    let (code, said) = bench.evaluate("fair", &["--report", "report.html"]);
    assert_eq!(code, Some(0), "{said}");
    let page = fs::read_to_string(bench.folder.path().join("report.html")).unwrap();
    // The base64 of a picture may hold any word.
    let mut text = String::new();
    for part in page.split("data:image/png;base64,") {
        text.push_str(if text.is_empty() { part } else { &part[part.find('"').unwrap()..] });
    }
    for foreign in ["http", "<script", "src=\"/", "url(", "@import", "NaN", "inf"] {
        assert!(!text.contains(foreign), "{foreign} stands in the report");
    }
    assert!(page.contains("&lt;script&gt;&amp;.npy belongs to no sample"));
    // Eight break-downs with two plots each, four pictures of each of the two samples.
    assert_eq!((page.matches("<svg").count(), page.matches("<img").count()), (16, 8));
    for tag in ["div", "figure", "svg", "table", "tr", "p", "h2", "details", "text", "span"] {
        let opened = page.matches(&format!("<{tag}>")).count() + page.matches(&format!("<{tag} ")).count();
        assert_eq!(opened, page.matches(&format!("</{tag}>")).count(), "{tag}");
    }
    let (code, said) = bench.evaluate("fair", &["--report", "nowhere/report.html"]);
    assert!(code == Some(2) && said.contains("cannot write nowhere/report.html"), "{said}");
}

/// Other datasets' truth, as they are laid out: the same pair in each, with a hole and a pixel that only the left sees.
#[test]
fn foreign_truth() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    let (width, height) = (24_u32, 16_u32);
    let n = (width * height) as usize;
    let truth = |i: usize| 20.0 + (i % 24) as f32 * 0.5;
    let (hole, hidden) = (30, 31);
    let write = |path: &str, bytes: &[u8]| {
        let path = root.join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    };
    let grey = |value: &dyn Fn(usize) -> u8| {
        Plane { width, height, pixels: Pixels::Gray((0..n).map(value).collect()) }.encode().unwrap()
    };
    let rgb = Plane { width, height, pixels: Pixels::Rgb((0..3 * n).map(|i| (i * 37 % 256) as u8).collect()) };
    let image = rgb.encode().unwrap();
    let tif = |hole_is: f32| {
        let pixels = (0..n).map(|i| if i == hole { hole_is } else { truth(i) }).collect();
        Plane { width, height, pixels: Pixels::Float(pixels) }.encode().unwrap()
    };
    let pfm = |hole_is: f32| {
        let mut out = format!("Pf\n{width} {height}\n-1\n").into_bytes();
        for v in (0..16).rev() {
            for i in v * 24..v * 24 + 24 {
                out.extend((if i == hole { hole_is } else { truth(i) }).to_le_bytes());
            }
        }
        out
    };
    let png16 = |hidden_too: bool| {
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, width, height);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::Sixteen);
        let coded = |i: usize| if i == hole || hidden_too && i == hidden { 0 } else { (truth(i) * 256.0) as u16 };
        let values: Vec<u8> = (0..n).flat_map(|i| coded(i).to_be_bytes()).collect();
        encoder.write_header().unwrap().write_image_data(&values).unwrap();
        out
    };
    let mask = grey(&|i| if i == hole || i == hidden { 128 } else { 255 });
    let tif_image = {
        use tiff_writer::{ImageBuilder, TiffWriter, WriteOptions};
        let mut writer = TiffWriter::new(std::io::Cursor::new(Vec::new()), WriteOptions::default()).unwrap();
        let handle = writer.add_image(ImageBuilder::new(width, height).sample_type::<u16>().strips(height)).unwrap();
        let values: Vec<u16> = (0..n).map(|i| (i * 53 % 2048) as u16).collect();
        writer.write_block(&handle, 0, &values).unwrap();
        writer.finish().unwrap().into_inner()
    };

    write("kitti/training/image_2/000003_10.png", &image);
    write("kitti/training/disp_occ_0/000003_10.png", &png16(false));
    write("kitti/training/disp_noc_0/000003_10.png", &png16(true));
    for (scene, truth) in [
        ("mb/MiddEval3/trainingQ/Vase", "mb/MiddEval3/trainingQ/Vase"),
        ("eth/two_view_training/a_1", "eth/two_view_training_gt/a_1"),
    ] {
        write(&format!("{scene}/im0.png"), &image);
        write(&format!("{truth}/disp0GT.pfm"), &pfm(f32::INFINITY));
        write(&format!("{truth}/mask0nocc.png"), &mask);
    }
    write("us3d/rgb/X_1_2_3_LEFT_RGB.tif", &tif_image);
    write("us3d/truth/X_1_2_3_LEFT_DSP.tif", &tif(-999.0));
    write("whu/test/left/KM_left_7.tiff", &tif_image);
    write("whu/test/disp/KM_disparity_7.tiff", &tif(-999.0));

    for (layout, folder, id, occluded) in [
        ("kitti", "kitti", "000003_10", 1),
        ("middlebury", "mb", "trainingQ/Vase", 1),
        ("eth3d", "eth", "a_1", 1),
        ("us3d", "us3d", "X_1_2_3", 0),
        ("whu", "whu", "test/KM_left_7", 0),
    ] {
        let predicted = Pixels::Float((0..n).map(|i| truth(i) + 0.75).collect());
        write(&format!("{layout}-p/{id}.tif"), &Plane { width, height, pixels: predicted }.encode().unwrap());
        let output = Command::new(env!("CARGO_BIN_EXE_satseed"))
            .current_dir(root)
            .args(["evaluate", folder, "--truth-layout", layout, "--predictions", &format!("{layout}-p")])
            .args(["--json", "report.json", "--report", "report.html"])
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(0), "{layout}: {}", text(&output.stderr));
        let r: serde_json::Value =
            serde_json::from_str(&fs::read_to_string(root.join("report.json")).unwrap()).unwrap();
        let s = &r["total"]["scores"];
        assert_eq!(
            (s["occ"]["pixels"].as_u64(), s["all"]["pixels"].as_u64()),
            (Some(occluded), Some(n as u64 - 1)),
            "{layout}"
        );
        assert_eq!((s["all"]["epe_px"].as_f64(), s["all"]["bias_px"].as_f64()), (Some(0.75), Some(0.75)), "{layout}");
        assert_eq!(r["total"]["nothing_hit_pixels"], 1, "{layout}");
        assert_eq!((&r["each"][0]["id"], &r["regions"][0]["region"]), (&id.into(), &layout.into()));
        let by: Vec<&String> = r["total"]["by"].as_object().unwrap().keys().collect();
        assert_eq!(by, ["boundary_distance", "disparity", "texture"], "{layout}");
        assert_eq!(fs::read_to_string(root.join("report.html")).unwrap().matches("<img").count(), 4);

        // In another layout's folder, and with a truth that is cut short.
        let told = |folder: &str, layout: &str| {
            let args = ["evaluate", folder, "--truth-layout", layout, "--predictions", "kitti-p"];
            let output = Command::new(env!("CARGO_BIN_EXE_satseed")).current_dir(root).args(args).output().unwrap();
            assert_eq!(output.status.code(), Some(2));
            text(&output.stderr)
        };
        assert!(told("kitti-p", layout).contains(&format!("holds nothing in the layout {layout}")));
    }
    write("kitti/training/disp_occ_0/000003_10.png", &png16(false)[..60]);
    let output = Command::new(env!("CARGO_BIN_EXE_satseed"))
        .current_dir(root)
        .args(["evaluate", "kitti", "--truth-layout", "kitti", "--predictions", "kitti-p"])
        .output()
        .unwrap();
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2));
    assert!(said.contains("disp_occ_0/000003_10.png`: it cannot be decoded"), "{said}");
}
