//! Small fixed pieces of work whose instructions are counted: a guard against slow code that no clock disturbs.

use std::ops::ControlFlow;
use std::path::Path;
use std::process::{Command, Stdio};

use motes_models::{GraphDiffusion, ModelShape};
use motes_proposals::{Backend, Family, Fcnn, FcnnConfig, Gnn, GnnConfig, Learnable};
use motes_smc::{Bootstrap, FilterBank, FilterSettings, MinDegeneracy, Proposal};
use motes_train::{TrainConfig, train};

use crate::error::SpeedError;
use crate::error::prepare;
use crate::folder::{DIMENSION, seed, system, trajectory};
use motes_cli::{one_of, result, status};

/// The names of the small pieces of work.
pub(crate) const SMALL_WORK: [&str; 4] =
    ["filter-bootstrap", "bank-min-degeneracy", "train-fcnn", "train-gnn"];

/// How far a count may be from the expected one, relative to it: libraries of the system choose their instructions by processor.
const MARGIN: f64 = 0.1;

/// Does one of [`SMALL_WORK`].
///
/// # Errors
/// [`SpeedError::Prepare`] if there is none of that name.
pub(crate) fn small_work(name: &str) -> Result<(), SpeedError> {
    let system = system(DIMENSION)?;
    match name {
        "filter-bootstrap" => filter(&system, Bootstrap, 2000, 1),
        "bank-min-degeneracy" => filter(&system, MinDegeneracy::new(&system).map_err(prepare)?, 20, 100),
        "train-fcnn" => {
            let config = FcnnConfig { widths: vec![64, 128], ..FcnnConfig::paper() };
            let (compute, weights) = (Backend::Native.into(), seed().child("weights"));
            learn(
                &system,
                &mut Fcnn::create(&config, &ModelShape::of(&system), 4, compute, &weights)
                    .map_err(prepare)?,
            )
        }
        "train-gnn" => {
            let config = GnnConfig { features: vec![32, 64], ..GnnConfig::paper() };
            let (compute, weights) = (Backend::Native.into(), seed().child("weights"));
            learn(
                &system,
                &mut Gnn::create(&config, &ModelShape::on_graph(&system), 4, compute, &weights)
                    .map_err(prepare)?,
            )
        }
        other => Err(prepare(format!("small work {other}: {}", one_of(other, SMALL_WORK)))),
    }
}

fn filter(
    system: &GraphDiffusion,
    proposal: impl Proposal<GraphDiffusion>,
    particles: usize,
    filters: usize,
) -> Result<(), SpeedError> {
    let measurements = trajectory(system, 10)?.measurements;
    let settings = FilterSettings::new(particles);
    let mut bank =
        FilterBank::new(system, proposal, settings, filters, &seed().child("filter")).map_err(prepare)?;
    measurements.rows().try_for_each(|measurement| bank.step(measurement)).map_err(prepare)
}

fn learn(system: &GraphDiffusion, proposal: &mut dyn Learnable) -> Result<(), SpeedError> {
    let measurements = trajectory(system, 4)?.measurements;
    let config = TrainConfig { steps: 5, ..TrainConfig::paper(10) };
    let (mut stream, proceed) = (seed().child("training").stream(), |_, _| ControlFlow::Continue(()));
    train(proposal, system, &measurements, &config, &mut stream, proceed).map(|_| ()).map_err(prepare)
}

/// Counts the instructions of each small piece of work under valgrind, and holds them against the file `expectation`, or writes
/// that file; whether all are as expected comes back. Where there is no valgrind nothing is counted, and said so.
///
/// # Errors
/// [`SpeedError`] if valgrind or the file cannot be used.
pub(crate) fn count_instructions(expectation: &Path, update: bool) -> Result<bool, SpeedError> {
    if Command::new("valgrind").arg("--version").stdout(Stdio::null()).status().is_err() {
        status("instructions were not counted: there is no valgrind");
        return Ok(!update);
    }
    let mut found = Vec::new();
    for name in SMALL_WORK {
        found.push((name, count(name)?));
    }
    if update {
        let lines: String = found.iter().map(|(name, count)| format!("{name} = {count}\n")).collect();
        std::fs::write(expectation, lines).map_err(SpeedError::system(expectation))?;
        result(&format!("{} counts written to {}", found.len(), expectation.display()));
        return Ok(true);
    }
    let text = std::fs::read_to_string(expectation).map_err(SpeedError::system(expectation))?;
    let expected: std::collections::BTreeMap<String, f64> = toml::from_str(&text).map_err(prepare)?;
    let mut fine = true;
    for (name, count) in found {
        let ratio = expected.get(name).map_or(f64::NAN, |expected| count as f64 / expected);
        let right = (ratio - 1.0).abs() <= MARGIN;
        fine &= right;
        let verdict = if right { "as expected" } else { "NOT as expected" };
        result(&format!("{name}: {count} instructions, {ratio:.3} times the expected number: {verdict}"));
    }
    Ok(fine)
}

fn count(name: &str) -> Result<u64, SpeedError> {
    let program = std::env::current_exe().map_err(SpeedError::system("this program"))?;
    let mut command = Command::new("valgrind");
    command.args(["--tool=callgrind", "--callgrind-out-file=/dev/null"]).arg(program).args(["work", name]);
    let output = command.output().map_err(SpeedError::system("valgrind"))?;
    let text = String::from_utf8_lossy(&output.stderr);
    let line = text.lines().find_map(|line| line.split_once("Collected : "));
    match line.and_then(|(_, count)| count.trim().parse().ok()) {
        Some(count) if output.status.success() => Ok(count),
        _ => Err(SpeedError::Worker {
            who: format!("valgrind of {name}"),
            reason: text.lines().last().unwrap_or("it said nothing").into(),
        }),
    }
}
