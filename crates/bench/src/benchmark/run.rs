//! One benchmark from plan to files: proposals are learned, compared, and written down.

use std::path::PathBuf;

use motes::output::{card_json, error_figure};
use motes::{CompareOptions, FilterOptions, LearnedProposal, MotesError, ProposalName, compare, on_threads};
use motes_cli::{Interrupt, result, status};
use serde_json::{Value, json};
use thiserror::Error;

use super::file::{Benchmark, BenchmarkProfile};
use super::plan::BenchmarkPlan;
use super::recorded::{Parts, parts};
use super::{learning, tables};
use crate::durable;
use crate::key::key_of;
use crate::progress::Progress;
use crate::provenance::Provenance;

/// The version of what a benchmark's file means: raised whenever the same file gives other numbers than before.
const FORMAT: u32 = 2;

/// The version of how references are made, raised whenever they are made otherwise.
const REFERENCES: u32 = 5;

/// The whole result.
const CARD: &str = "card.json";

/// Why a benchmark has no result.
#[derive(Debug, Error)]
pub enum BenchmarkError {
    /// It cannot be run, or failed.
    #[error("{name}: {source}")]
    Failed {
        /// The benchmark.
        name: String,
        /// What failed.
        source: Box<MotesError>,
    },
    /// A file of results cannot be read or written.
    #[error("{path}: {source}", path = path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The figure cannot be drawn.
    #[error("{name}: the figure cannot be drawn: {reason}")]
    Figure {
        /// The benchmark.
        name: String,
        /// Why not.
        reason: String,
    },
}

impl BenchmarkError {
    /// Whether it was stopped.
    pub fn is_interrupted(&self) -> bool {
        matches!(self, BenchmarkError::Failed { source, .. } if matches!(**source, MotesError::Interrupted))
    }

    /// 3 where input or output failed, 1 for every other failure.
    pub fn exit_status(&self) -> u8 {
        match self {
            BenchmarkError::File { .. } => 3,
            BenchmarkError::Failed { .. } | BenchmarkError::Figure { .. } => 1,
        }
    }
}

/// Runs a benchmark, unless the same one was finished before, and writes card.json, table.md and figure.svg.
///
/// Proposals and references are kept as they are made: a run that is stopped goes on with those that are there.
///
/// # Errors
/// [`BenchmarkError`] if it fails, is stopped or cannot be written down.
pub fn run_benchmark(plan: &BenchmarkPlan, interrupt: &Interrupt) -> Result<(), BenchmarkError> {
    status(&plan.to_string());
    let card = plan.folder.join(CARD);
    let key = key(plan);
    let written =
        std::fs::read_to_string(&card).ok().and_then(|text| serde_json::from_str::<Value>(&text).ok());
    if !plan.fresh && written.is_some_and(|written| written["key"] == key.as_str()) {
        result(&format!("{} was run before; --fresh runs it again", card.display()));
        return Ok(());
    }
    let failed = |source| BenchmarkError::Failed { name: plan.name.clone(), source: Box::new(source) };
    let model = plan.model(&Default::default()).map_err(failed)?;
    let recorded = parts(plan, &model).map_err(failed)?;
    let earlier = recorded.as_ref().map(|parts| &parts.earlier);
    let work = || -> Result<_, MotesError> {
        let learned = learning::proposals(plan, &learning_key(plan), &model, earlier, interrupt)?;
        let options = options(plan, &learned)?;
        let later = recorded.as_ref().map(|Parts { later, .. }| later);
        let (mut progress, mut share) = (None::<Progress>, 0.0);
        let comparison = compare(&model, later, &options, |compared| {
            // Before the first filter there are simulations, of which nothing is said.
            if compared.filters > 0 {
                let progress = progress.get_or_insert_with(|| Progress::start(compared.of, 1.0));
                progress.ended("filter", compared.share - share, None);
                share = compared.share;
            }
            interrupt.check()
        });
        progress.into_iter().for_each(Progress::finish);
        Ok((learned, comparison?))
    };
    let done = on_threads(Some(plan.jobs), work).map_err(failed)?;
    let (learned, comparison) = done.map_err(failed)?;
    let training: serde_json::Map<String, Value> =
        learned.iter().map(|one| (one.name().to_string(), json!(one.notes().seconds))).collect();
    let Provenance { revision, processor } = Provenance::here();
    let card_value: Value = serde_json::from_str(&card_json(&comparison, None)).unwrap_or_default();
    let whole = json!({
        "key": key,
        "benchmark": plan.name,
        "profile": plan.profile_name,
        "configuration": plan.benchmark,
        "seed": plan.seed,
        "revision": revision,
        "processor": processor,
        "training_seconds": training,
        "card": card_value,
    });
    let table = tables::table(plan, &learned, &comparison);
    write(plan, "table.md", &table)?;
    if !comparison.equal_time.points.is_empty() {
        let figure = error_figure(&comparison.equal_time);
        let figure = figure
            .map_err(|error| BenchmarkError::Figure { name: plan.name.clone(), reason: error.to_string() })?;
        write(plan, "figure.svg", &figure)?;
    }
    // Last: what it says is finished is.
    let text = serde_json::to_string_pretty(&whole).unwrap_or_default() + "\n";
    write(plan, CARD, &text)?;
    result(&table);
    result(&format!("written to {}", plan.folder.display()));
    Ok(())
}

/// A hash of all that the result depends on but for the machine, and of what is printed with it.
fn key(plan: &BenchmarkPlan) -> String {
    // The file of the other profiles is no part of it.
    let benchmark = Benchmark { profiles: std::collections::BTreeMap::new(), ..plan.benchmark.clone() };
    key_of(&(reference_key(plan), benchmark, &plan.profile))
}

/// A hash of all that learned proposals depend on.
fn learning_key(plan: &BenchmarkPlan) -> String {
    let Benchmark { set, learned, recorded, model, .. } = &plan.benchmark;
    let text = |file: &std::path::Path| std::fs::read_to_string(plan.home.join(file)).unwrap_or_default();
    let data = recorded.as_ref().and_then(|recorded| recorded.data.as_deref()).map(text);
    let BenchmarkProfile { updates, further_updates, times, .. } = plan.profile;
    key_of(&(FORMAT, plan.seed, set, learned, recorded, text(model), data, [updates, further_updates, times]))
}

/// A hash of all that references depend on: learned proposals are among those that they are made with.
fn reference_key(plan: &BenchmarkPlan) -> String {
    let BenchmarkProfile { reference_particles, reference_filters, reference_error, .. } = plan.profile;
    let settings = (reference_particles, reference_filters, reference_error);
    key_of(&(REFERENCES, learning_key(plan), settings, plan.benchmark.resample_below))
}

fn options(plan: &BenchmarkPlan, learned: &[LearnedProposal]) -> Result<CompareOptions, MotesError> {
    let (benchmark, profile) = (&plan.benchmark, &plan.profile);
    let named =
        benchmark.designed.iter().map(|name| name.parse::<ProposalName>().map_err(MotesError::Setting));
    let mut proposals: Vec<ProposalName> = named.collect::<Result<_, _>>()?;
    proposals.extend(learned.iter().cloned().map(ProposalName::Learned));
    Ok(CompareOptions {
        proposals,
        inputs: None,
        filter: FilterOptions {
            particles: profile.particles,
            resample_below: benchmark.resample_below,
            defensive: benchmark.defensive,
            seed: plan.seed,
            ..FilterOptions::default()
        },
        particles: profile.equal_time.clone(),
        sequences: profile.sequences,
        steps: profile.times,
        particles_up_to: None,
        reference_particles: profile.reference_particles,
        reference_filters: profile.reference_filters,
        reference_error: profile.reference_error,
        references: Some(plan.folder.join("references").join(reference_key(plan))),
        timed_threads: 1,
    })
}

fn write(plan: &BenchmarkPlan, name: &str, text: &str) -> Result<(), BenchmarkError> {
    let path = plan.folder.join(name);
    durable::write(&path, &[text.as_bytes()]).map_err(|source| BenchmarkError::File { path, source })
}
