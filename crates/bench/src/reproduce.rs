//! One figure from plan to files: what is missing is run, then tables and figure are made of all that is there.

use crate::config::{Panel, Plan};
use crate::estimate::Estimator;
use crate::outputs::write_outputs;
use crate::progress::duration;
use crate::provenance::Provenance;
use crate::record_units::{Keeper, record_units};
use crate::standing::{Count, PlacedUnit, is_missing, read, wanted};
use crate::store::{Record, Store, StoreError};
use motes_cli::{Interrupt, status};

/// How a run ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RunOutcome {
    /// All units are there.
    Complete {
        /// Units that were run now.
        ran: usize,
        /// Units recorded as failed, whenever they were run.
        failed: usize,
    },
    /// It was stopped; what was finished is kept.
    Interrupted,
}

/// Runs what a plan lacks and writes every output file.
///
/// # Errors
/// [`StoreError`] if the folder is in use or cannot be read or written.
pub fn reproduce(
    plan: &Plan,
    estimator: &Estimator,
    interrupt: &Interrupt,
) -> Result<RunOutcome, StoreError> {
    let mut store = Store::open(&plan.folder)?;
    let wanted = wanted(plan);
    if plan.fresh {
        store.remove(wanted.iter().map(|(_, unit)| unit))?;
    }
    let (there, remarks) = read(plan, &mut store)?;
    remarks.iter().for_each(|remark| status(remark));
    let missing: Vec<PlacedUnit> =
        wanted.iter().filter(|unit| is_missing(plan, &there, unit)).cloned().collect();
    announce(plan, wanted.len(), missing.len());
    if !missing.is_empty() {
        run_missing(plan, &mut store, &missing, estimator, interrupt)?;
    }

    let (records, _) = read(plan, &mut store)?;
    write_outputs(plan, &store, &records)?;
    let count = Count::of(&wanted, &records);
    if count.left() > 0 {
        let fresh = if plan.fresh { ", given without --fresh," } else { "" };
        status(&format!(
            "stopped with {} units left; the same command{fresh} goes on where this one stopped",
            count.left()
        ));
        return Ok(RunOutcome::Interrupted);
    }
    if count.failed > 0 {
        status(&format!(
            "{} of {} units failed; failures.csv says why, --fresh runs them again",
            count.failed,
            wanted.len()
        ));
    }
    Ok(RunOutcome::Complete { ran: missing.len(), failed: count.failed })
}

fn announce(plan: &Plan, wanted: usize, missing: usize) {
    status(&plan.to_string());
    match wanted - missing {
        0 => status(&format!("{missing} units to run on {} threads", plan.jobs)),
        done => status(&format!("{done} units are there, {missing} to run on {} threads", plan.jobs)),
    }
}

/// A process that has the folder to itself.
impl Keeper for Store {
    fn keep(&mut self, record: &Record) -> Result<(), StoreError> {
        self.write(record)
    }
}

fn run_missing(
    plan: &Plan,
    store: &mut Store,
    missing: &[PlacedUnit],
    estimator: &Estimator,
    interrupt: &Interrupt,
) -> Result<(), StoreError> {
    let points: Vec<_> = missing.iter().map(|(point, _)| point.clone()).collect();
    let estimates = estimator.seconds(plan, &points, interrupt);
    let total: f64 = estimates.iter().sum();
    status(&format!("estimated time {}", duration(total / plan.jobs.min(missing.len()) as f64)));
    record_units(missing, &estimates, (plan, &Provenance::here()), interrupt, store)
}

/// How long the paper profile of the whole figure would take on this machine with as many threads, as a person says it;
/// `None` if the experiment has no such profile or the run is being stopped.
pub fn paper_estimate(plan: &Plan, estimator: &Estimator, interrupt: &Interrupt) -> Option<String> {
    let profile = plan.experiment.profiles.get("paper")?.clone();
    let chosen = |panel: &&Panel| profile.panels.as_ref().is_none_or(|names| names.contains(&panel.name));
    let paper = Plan {
        panels: plan.experiment.panels.iter().filter(chosen).cloned().collect(),
        xs: profile.x.clone(),
        methods: plan.experiment.methods.clone(),
        repetitions: profile.repetitions,
        profile,
        ..plan.clone()
    };
    let points = paper.points();
    let total: f64 = estimator.seconds(&paper, &points, interrupt).iter().sum();
    let workers = plan.jobs.min(points.len()).max(1);
    interrupt.check().is_continue().then(|| duration(total / workers as f64))
}
