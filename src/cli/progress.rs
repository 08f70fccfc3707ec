//! How far a run is: pairs, rays a second, time left. On a terminal only.

use super::output::bytes_text;
use indicatif::{ProgressBar, ProgressStyle};
use satseed::pipeline::Event;
use satseed::plan::Estimate;
use std::io::{self, IsTerminal as _, Write as _};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// The progress of one run.
pub(crate) struct Progress {
    bar: ProgressBar,
    /// Since when rays are counted, and how many there were.
    rays: Mutex<(Instant, u64)>,
}

impl Progress {
    /// Tells what the run may take, and begins to count.
    pub(crate) fn new(cost: &Estimate) -> Self {
        let bar = if io::stderr().is_terminal() { ProgressBar::no_length() } else { ProgressBar::hidden() };
        let style = ProgressStyle::with_template("{spinner} [{bar:30}] {pos}/{len} pairs, {eta} left  {msg}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "));
        let progress = Self { bar, rays: Mutex::new((Instant::now(), 0)) };
        let (memory, disk) = (bytes_text(cost.memory_bytes), bytes_text(cost.disk_bytes));
        progress.tell(&format!("memory at most {memory}, disk about {disk}"));
        progress
    }

    /// Takes note of what happened.
    pub(crate) fn report(&self, event: Event<'_>) {
        match event {
            Event::Begun { pairs, standing } => {
                self.bar.set_length(pairs as u64);
                self.bar.set_position(standing as u64);
                self.bar.reset_eta();
                self.bar.enable_steady_tick(Duration::from_millis(200));
                if standing > 0 {
                    self.tell(&format!("{standing} of {pairs} pairs stand already"));
                }
            }
            Event::Scene { name } => {
                tracing::info!("building scene {name}");
                self.bar.set_message(format!("building {name}"));
            }
            Event::Pair { id, rays } => {
                tracing::debug!("recorded {id}");
                self.bar.inc(1);
                if let Ok(mut counted) = self.rays.lock() {
                    counted.1 += rays;
                    let per_second = counted.1 as f64 / counted.0.elapsed().as_secs_f64() / 1e6;
                    let scene = id.split_once('/').map_or(id, |(scene, _)| scene);
                    self.bar.set_message(format!("{scene}, {per_second:.2} M rays/s"));
                }
            }
        }
    }

    /// Takes the bar away, and says how many pairs stand.
    pub(crate) fn end(&self) -> u64 {
        // A bar that is taken away says that all is done.
        let standing = self.bar.position();
        self.bar.finish_and_clear();
        standing
    }

    /// A sentence for a person at a terminal; a log line otherwise.
    pub(crate) fn tell(&self, sentence: &str) {
        if self.bar.is_hidden() {
            tracing::info!("{sentence}");
        } else {
            self.bar.suspend(|| drop(writeln!(io::stderr(), "{sentence}")));
        }
    }

    /// The sentence of a run that was stopped: it is said wherever stderr goes.
    pub(crate) fn stopped(&self, standing: u64) {
        tracing::warn!(
            "stopped at a sample's border, {standing} of {} pairs stand: run the same command again to go on",
            self.bar.length().unwrap_or(0)
        );
    }
}
