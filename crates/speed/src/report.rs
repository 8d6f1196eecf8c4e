//! What was measured, as JSON and as a table.

use std::fmt::Write;
use std::path::Path;

use serde::Serialize;

use crate::drive::{Entry, Growth, Outcome};
use crate::error::SpeedError;
use crate::peak::Peak;
use crate::workloads::Kind;

/// A report that grows.
#[derive(Serialize)]
pub(crate) struct Report {
    rounds: u64,
    cores: usize,
    processor: String,
    /// What the machine can do at most.
    peak: Peak,
    work: Vec<Line>,
    growth: Vec<Exponent>,
}

/// The exponent with which the time of filters grows with one size.
#[derive(Serialize)]
struct Exponent {
    #[serde(flatten)]
    of: Growth,
    /// Fitted in each round: least, median and greatest.
    exponent: [f64; 3],
}

#[derive(Serialize)]
struct Line {
    name: String,
    kind: Kind,
    ours: Entry,
    peers: Vec<Entry>,
    /// Before each round of training, floating-point operations a second of the largest product on two threads.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    peaks: Vec<f64>,
    /// Against each peer: peer's seconds by ours, of each round; least, median and greatest.
    ratios: Vec<(String, [f64; 3])>,
}

/// The paper's number of steps.
const TRAINING: f64 = 200.0;

impl Report {
    pub(crate) fn new(rounds: u64, peak: Peak) -> Self {
        let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let model = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
        Report {
            rounds,
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            processor: model.map_or("unknown".into(), |(_, name)| name.into()),
            peak,
            work: Vec::new(),
            growth: Vec::new(),
        }
    }

    pub(crate) fn add_growth(&mut self, of: Growth) {
        let of_round = |seconds: &Vec<f64>| {
            let points = of.values.iter().zip(seconds).map(|(&value, &seconds)| (value as f64, seconds));
            exponent(&points.collect::<Vec<_>>())
        };
        if let Some(exponent) = spread(of.seconds.iter().map(of_round)) {
            self.growth.push(Exponent { of, exponent });
        }
    }

    pub(crate) fn add(&mut self, Outcome { workload, ours, peers, peaks }: Outcome) {
        let ratio = |peer: &Entry| {
            let each = peer.seconds.iter().zip(&ours.seconds);
            // As much work from every process of either side.
            let of =
                |(theirs, mine): (&f64, &f64)| theirs / peer.processes as f64 * ours.processes as f64 / mine;
            Some((peer.name.clone(), spread(each.map(of))?))
        };
        let ratios = peers.iter().filter_map(ratio).collect();
        self.work.push(Line { name: workload.name, kind: workload.kind, ours, peers, peaks, ratios });
    }

    pub(crate) fn write(&self, folder: &Path) -> Result<(), SpeedError> {
        let text = serde_json::to_string_pretty(self).unwrap_or_default();
        for (name, text) in [("speed.json", text + "\n"), ("speed.md", self.table())] {
            let path = folder.join(name);
            std::fs::write(&path, text).map_err(SpeedError::system(&path))?;
        }
        Ok(())
    }

    /// Up to six tables: filters, draws, training, learning once, filters with what was learned once, growth.
    pub(crate) fn table(&self) -> String {
        let mut text = String::new();
        let giga = |rate: f64| rate / 1e9;
        let _ = writeln!(
            text,
            "{} ({} cores), medians of {} rounds in turns. Largest f32 matrix product: {:.0} GFLOP/s on one thread, {:.0} on two; \
             memory: {:.0} GB/s and {:.0}.",
            self.processor,
            self.cores,
            self.rounds,
            giga(self.peak.product.one_thread),
            giga(self.peak.product.two_threads),
            giga(self.peak.memory.one_thread),
            giga(self.peak.memory.two_threads)
        );
        let is_filter = |line: &Line| matches!(line.kind, Kind::Filter { .. });
        let filters = self.libraries(is_filter);
        let training = self.libraries(|line| matches!(line.kind, Kind::Train { .. }));
        let drawing = self.libraries(|line| matches!(line.kind, Kind::Draws { .. }));
        let of_drawing = ["draws, on one thread", "million a second"];
        let of_filters = ["filter", "million particle-steps a second", "memory, MB"];
        let of_training = ["training", "ms a step", "trainings an hour", "of the peak", "memory of both, MB"];
        let learning = self.libraries(|line| matches!(line.kind, Kind::Learn { .. }));
        let learned = self.libraries(|line| matches!(line.kind, Kind::Learned { .. }));
        let of_learning = ["learning once", "steps a second", "networks, of the peak", "memory, MB"];
        let of_learned = [
            "filter with a learned proposal",
            "million particle-steps a second",
            "networks, of the peak",
            "memory, MB",
        ];
        let of_growth = ["filter", "sizes", "time grows with the power"];
        for (columns, libraries, rows) in [
            (of_filters.as_slice(), &filters, self.filters(&filters)),
            (of_drawing.as_slice(), &drawing, self.drawing(&drawing)),
            (of_training.as_slice(), &training, self.training(&training)),
            (of_learning.as_slice(), &learning, self.learning(&learning)),
            (of_learned.as_slice(), &learned, self.learned(&learned)),
            (of_growth.as_slice(), &Vec::new(), self.growth()),
        ] {
            if !rows.is_empty() {
                let times = libraries.iter().map(|library| format!("times {library}"));
                let names: Vec<String> =
                    columns.iter().map(|name| (*name).to_string()).chain(times).collect();
                let rules = format!("---|{}", "---:|".repeat(names.len() - 1));
                let _ = writeln!(text, "\n| {} |\n|{rules}\n{}", names.join(" | "), rows.trim_end());
            }
        }
        text
    }

    /// The other libraries that were asked to do some of the work, in order.
    fn libraries(&self, some: impl Fn(&Line) -> bool) -> Vec<String> {
        let mut libraries: Vec<String> = Vec::new();
        for peer in self.work.iter().filter(|line| some(line)).flat_map(|line| &line.peers) {
            let library = library(&peer.name);
            if !libraries.iter().any(|known| known == library) {
                libraries.push(library.into());
            }
        }
        libraries
    }

    fn filters(&self, libraries: &[String]) -> String {
        let mut text = String::new();
        for line in &self.work {
            if let Kind::Filter { particle_steps } = line.kind {
                let rate = particle_steps / median(&line.ours.seconds) / 1e6;
                let name = line.name.trim_start_matches("filter ");
                let memory = memory(&line.ours);
                let _ = writeln!(text, "| {name} | {rate:.1} | {memory} |{}", versus(line, libraries));
            }
        }
        text
    }

    fn drawing(&self, libraries: &[String]) -> String {
        let mut text = String::new();
        for line in &self.work {
            if let Kind::Draws { draws } = line.kind {
                let rate = draws as f64 / median(&line.ours.seconds) / 1e6;
                let name = line.name.trim_start_matches("draws ");
                let _ = writeln!(text, "| {name} | {rate:.1} |{}", versus(line, libraries));
            }
        }
        text
    }

    fn training(&self, libraries: &[String]) -> String {
        let mut text = String::new();
        for line in &self.work {
            if let Kind::Train { steps, operations } = line.kind {
                let (step, processes) =
                    (median(&line.ours.seconds) / steps as f64, line.ours.processes as f64);
                let trainings = 3600.0 / (step * TRAINING) * processes;
                let rates =
                    line.ours.seconds.iter().map(|seconds| operations * steps as f64 * processes / seconds);
                let of_peak = spread(rates.zip(&line.peaks).map(|(rate, peak)| 100.0 * rate / peak));
                let of_peak = match of_peak {
                    Some([least, middle, greatest]) if operations > 0.0 => {
                        format!("{middle:.0} % ({least:.0} to {greatest:.0})")
                    }
                    _ => "–".into(),
                };
                let name = line.name.trim_start_matches("train ");
                let _ = writeln!(
                    text,
                    "| {name} | {:.1} | {trainings:.0} | {of_peak} | {} |{}",
                    1e3 * step,
                    memory(&line.ours),
                    versus(line, libraries)
                );
            }
        }
        text
    }

    /// What the largest product reaches on so many threads.
    fn peak(&self, threads: usize) -> f64 {
        let product = &self.peak.product;
        if threads == 1 { product.one_thread } else { product.two_threads }
    }

    fn learning(&self, libraries: &[String]) -> String {
        let mut text = String::new();
        for line in &self.work {
            if let Kind::Learn { steps, operations, threads } = line.kind {
                let rate = steps as f64 / median(&line.ours.seconds);
                let _ = writeln!(
                    text,
                    "| {} | {rate:.0} | {:.0} % | {} |{}",
                    line.name.trim_start_matches("learn "),
                    100.0 * operations * rate / self.peak(threads),
                    memory(&line.ours),
                    versus(line, libraries)
                );
            }
        }
        text
    }

    fn learned(&self, libraries: &[String]) -> String {
        let mut text = String::new();
        for line in &self.work {
            if let Kind::Learned { particle_steps, operations, threads } = line.kind {
                let seconds = median(&line.ours.seconds);
                let _ = writeln!(
                    text,
                    "| {} | {:.2} | {:.0} % | {} |{}",
                    line.name.trim_start_matches("learned "),
                    particle_steps / seconds / 1e6,
                    100.0 * operations / seconds / self.peak(threads),
                    memory(&line.ours),
                    versus(line, libraries)
                );
            }
        }
        text
    }

    fn growth(&self) -> String {
        let mut text = String::new();
        for Exponent { of: Growth { method, size, values, .. }, exponent: [least, middle, greatest] } in
            &self.growth
        {
            let values = values.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
            let _ = writeln!(
                text,
                "| {method} | {size} = {values} | {middle:.2} ({least:.2} to {greatest:.2}) |"
            );
        }
        text
    }
}

/// The slope of the logarithms, by least squares.
fn exponent(points: &[(f64, f64)]) -> f64 {
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(&|point| point.0.ln()), mean(&|point| point.1.ln()));
    mean(&|point| (point.0.ln() - x) * (point.1.ln() - y)) / mean(&|point| (point.0.ln() - x).powi(2))
}

/// Which library it is of whose arrangements this is one.
fn library(peer: &str) -> &str {
    peer.split_once(", ").map_or(peer, |(library, _)| library)
}

/// A cell for each library: the ratio to the arrangement in which it does best.
fn versus(line: &Line, libraries: &[String]) -> String {
    let cell = |wanted: &String| {
        let of_library = |name: &str| library(name) == wanted.as_str();
        let ratios = line.ratios.iter().filter(|(name, _)| of_library(name)).map(|(_, ratio)| ratio);
        match ratios.min_by(|a, b| a[1].total_cmp(&b[1])) {
            Some([least, middle, greatest]) => format!(" {middle:.1} ({least:.1} to {greatest:.1}) |"),
            None => " – |".to_string(),
        }
    };
    libraries.iter().map(cell).collect()
}

fn memory(entry: &Entry) -> String {
    entry.peak_memory.map_or("–".into(), |bytes| format!("{:.0}", bytes as f64 / 1e6))
}

/// Least, median and greatest, if there are any.
fn spread(values: impl Iterator<Item = f64>) -> Option<[f64; 3]> {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    Some([*sorted.first()?, middle(&sorted), *sorted.last()?])
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    middle(&sorted)
}

/// Of sorted values.
fn middle(sorted: &[f64]) -> f64 {
    match (sorted.get((sorted.len().max(1) - 1) / 2), sorted.get(sorted.len() / 2)) {
        (Some(lower), Some(upper)) => 0.5 * (lower + upper),
        _ => f64::NAN,
    }
}
