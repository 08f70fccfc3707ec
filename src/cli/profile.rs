//! What `--profile` prints and writes.

use super::output::bytes_text;
use anyhow::{Context as _, bail};
use satseed::pipeline::{Profile, ProfileReport};
use serde::Serialize;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// An account that is asked for, with the open file that it will go to.
pub(crate) struct ProfileFile {
    /// Where the run counts.
    pub(crate) profile: Arc<Profile>,
    path: PathBuf,
    file: File,
}

/// What the file holds.
#[derive(Serialize)]
struct Text<'a> {
    plan: &'a str,
    memory_bound_bytes: u64,
    #[serde(flatten)]
    report: &'a ProfileReport,
}

impl ProfileFile {
    /// Begins to count, with a file that is known to be writable: a run may take a night.
    pub(crate) fn begin(path: &Path, dataset: &Path) -> anyhow::Result<Self> {
        let profile = Profile::begin();
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        if let (Ok(folder), Ok(dataset)) = (folder.canonicalize(), dataset.canonicalize())
            && folder.starts_with(&dataset)
        {
            bail!(
                "the profile `{}` would stand among the files of the dataset, which hold no times: choose a place outside \
                 of `{}`",
                path.display(),
                dataset.display()
            );
        }
        let file = File::create(path).with_context(|| format!("cannot write the profile `{}`", path.display()))?;
        Ok(Self { profile, path: path.to_owned(), file })
    }

    /// Prints the table on stderr and writes the file.
    pub(crate) fn end(mut self, plan_hash: &str, jobs: usize, memory_bound_bytes: u64) -> anyhow::Result<()> {
        let report = self.profile.report(jobs);
        // Whoever closed stderr wants no table.
        let _ = write_table(&mut io::stderr().lock(), &report, memory_bound_bytes);
        let text = Text { plan: plan_hash, memory_bound_bytes, report: &report };
        let mut json = serde_json::to_vec_pretty(&text)?;
        json.push(b'\n');
        self.file.write_all(&json).with_context(|| format!("cannot write the profile `{}`", self.path.display()))
    }
}

fn write_table(out: &mut dyn Write, report: &ProfileReport, memory_bound_bytes: u64) -> io::Result<()> {
    writeln!(
        out,
        "{:<15} {:>6} {:>10} {:>10} {:>6} {:>10} {:>10} {:>13}",
        "stage", "runs", "wall s", "CPU s", "share", "serial s", "M rays", "M rays/CPU s"
    )?;
    let seconds = |s: f64| format!("{s:.2}");
    let mut line = |name: &str, [runs, wall, serial]: [String; 3], cpu_s: f64, rays: u64| {
        let share = 100.0 * cpu_s / report.cpu_s.max(1e-9);
        let millions = rays as f64 / 1e6;
        let (traced, speed) = match rays {
            0 => (String::new(), String::new()),
            _ => (format!("{millions:.2}"), format!("{:.2}", millions / cpu_s.max(1e-9))),
        };
        writeln!(
            out,
            "{name:<15} {runs:>6} {wall:>10} {cpu_s:>10.2} {share:>5.1}% {serial:>10} {traced:>10} {speed:>13}"
        )
    };
    for s in &report.stages {
        let texts = [s.runs.to_string(), seconds(s.wall_s), seconds(s.serial_cpu_s)];
        line(s.stage.words(), texts, s.cpu_s, s.rays)?;
    }
    line("other", [String::new(), String::new(), seconds(report.other_cpu_s)], report.other_cpu_s, 0)?;
    let serial_s = report.stages.iter().map(|s| s.serial_cpu_s).sum::<f64>() + report.other_cpu_s;
    line("whole", [String::new(), seconds(report.wall_s), seconds(serial_s)], report.cpu_s, report.rays)?;
    let k = report.rays_by_kind;
    let [primary, label, sun, sky] = [k.primary, k.label, k.sun, k.sky].map(|n| n as f64 / 1e6);
    writeln!(out, "M rays: {primary:.2} primary, {label:.2} label, {sun:.2} sun, {sky:.2} sky")?;
    let busy = 100.0 * report.cpu_s / (report.wall_s * report.jobs as f64).max(1e-9);
    writeln!(out, "{} threads, busy {busy:.0}% of the time", report.jobs)?;
    if let Some(peak) = report.memory_peak_bytes {
        writeln!(out, "memory peak {} of at most {}", bytes_text(peak), bytes_text(memory_bound_bytes))?;
    }
    Ok(())
}
