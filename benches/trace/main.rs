//! What building, rays, pairs and datasets cost: `cargo bench --bench trace -- [FILTER...]`.
//!
//! A case is a kind and a subject: `primary/toronto`, `build/field-10M`, `pair/canyon`. Those whose name holds one of the
//! filters are run; `--list` names all. Rounds alternate between the kinds of a subject, and medians are told: of
//! processor time, for other programs lengthen the time on the wall. `--json FILE` writes every round.
//!
//! `--peer SUBJECT --export FOLDER` is for `benches/peers/compare.py`.
#![allow(clippy::print_stdout, missing_docs)]

mod clock;
mod families;
mod peer;
mod runs;
mod scenes;

use clap::Parser;
use clock::{load, median, process_cpu, processor};
use families::{Family, Frame};
use satseed::pipeline::thread_pool;
use satseed_scene::Scene;
use satseed_tracer::Tracer;
use scenes::{SUBJECTS, Subject};
use serde_json::{Value, json};
use std::path::PathBuf;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

#[derive(Parser)]
struct Args {
    /// Parts of the names of cases; none for all.
    filters: Vec<String>,
    /// Times that each case is run.
    #[arg(long, default_value_t = 5)]
    rounds: usize,
    /// Threads that trace.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// One in so many rows of a frame is traced.
    #[arg(long, default_value_t = 2)]
    share: u32,
    /// Names the cases.
    #[arg(long)]
    list: bool,
    /// Where to write the results.
    #[arg(long)]
    json: Option<PathBuf>,
    /// Traces the families of this subject that standard input names, line by line.
    #[arg(long, requires = "export")]
    peer: Option<String>,
    /// Where the peer's scene and rays are written.
    #[arg(long)]
    export: Option<PathBuf>,
    /// What cargo says to every bench.
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() {
    let args = Args::parse();
    if let (Some(name), Some(folder)) = (&args.peer, &args.export) {
        let subject = SUBJECTS.iter().find(|(n, _)| n == name).expect("--list names the subjects").1;
        return thread_pool(1).expect("threads").install(|| peer::serve(subject, args.share, folder));
    }
    let mut results = Vec::new();
    let wanted = |case: &str| args.filters.is_empty() || args.filters.iter().any(|f| case.contains(f.as_str()));
    let begun = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let load_before = load();
    for (name, subject) in SUBJECTS {
        let is_wanted = |kind: &str| wanted(&format!("{kind}/{name}"));
        let families: Vec<_> = Family::ALL.into_iter().filter(|(kind, _)| is_wanted(kind)).collect();
        if args.list {
            println!("build/{name}");
            for (kind, _) in &Family::ALL {
                println!("{kind}/{name}");
            }
        } else if is_wanted("build") || !families.is_empty() {
            let pool = thread_pool(args.threads).expect("threads");
            results.extend(pool.install(|| of_subject(name, subject, &families, &args)));
        }
    }
    for (name, run) in runs::ALL {
        if args.list {
            println!("{name}");
        } else if wanted(name) {
            results.push(run.measure(name, args.threads));
        }
    }
    if let Some(file) = &args.json {
        let all = json!({
            "unix_time": begun,
            "processor": processor(),
            "load": [load_before, load()],
            "threads": args.threads,
            "rounds": args.rounds,
            "results": results,
        });
        let text = serde_json::to_string_pretty(&all).expect("numbers and words");
        std::fs::write(file, text + "\n").expect("the results can be written");
    }
}

/// Builds a subject's trees, and traces families with the threads of the current pool.
fn of_subject(name: &str, subject: Subject, families: &[(&str, Family)], args: &Args) -> Vec<Value> {
    let scene = subject.build();
    let (tracer, built) = build(&scene);
    println!("build/{name}: {built}");
    let mut results = vec![json!({ "case": format!("build/{name}"), "build": built })];
    if families.is_empty() {
        return results;
    }
    let frame = Frame::new(&tracer, args.share);
    let mut speeds = vec![Vec::new(); families.len()];
    let mut walls = vec![Vec::new(); families.len()];
    let mut counts = vec![(0, 0); families.len()];
    for _ in 0..args.rounds {
        for (k, (_, family)) in families.iter().enumerate() {
            let begun = Instant::now();
            let (rays, met, cpu) = frame.trace(&tracer, *family);
            walls[k].push(begun.elapsed().as_secs_f64());
            speeds[k].push(rays as f64 / cpu.as_secs_f64() / 1e6);
            counts[k] = (rays, met);
        }
    }
    for (k, (kind, _)) in families.iter().enumerate() {
        let (rays, met) = counts[k];
        let speed = median(speeds[k].clone());
        println!("{kind}/{name}: {speed:.2} M rays a CPU second ({rays} rays, {met} met something)");
        results.push(json!({
            "case": format!("{kind}/{name}"),
            "rays": rays,
            "met": met,
            "mrays_per_cpu_s": speed,
            "rounds_mrays_per_cpu_s": speeds[k],
            "rounds_wall_s": walls[k],
        }));
    }
    results
}

/// The tracer of a scene, and what it took to build.
fn build(scene: &Scene) -> (Tracer<'_>, Value) {
    let (begun, before) = (Instant::now(), process_cpu());
    let tracer = Tracer::new(scene);
    let (held, placed) = scene.triangle_counts();
    let built = json!({
        "wall_s": begun.elapsed().as_secs_f64(),
        "cpu_s": process_cpu().saturating_sub(before).as_secs_f64(),
        "tree_bytes": tracer.bytes(),
        "triangles_held": held,
        "triangles_placed": placed,
        "instances": scene.instances.len(),
    });
    (tracer, built)
}
