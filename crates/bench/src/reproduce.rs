//! One figure from plan to files: what is missing is run, then tables and figure are made of all that is there.

use std::collections::BTreeSet;
use std::path::PathBuf;

use crate::checkpoint::{self, Checkpoints};
use crate::config::{Panel, Plan, Point};
use crate::estimate::Estimator;
use crate::evaluate::Evaluator;
use crate::figure::{figure, series_figure};
use crate::manifest::{manifest, processors, revisions};
use crate::progress::{Progress, duration};
use crate::provenance::Provenance;
use crate::runner::{Event, run};
use crate::store::{Contents, Outcome, Record, Store, StoreError};
use crate::tables::{
    failures_csv, markdown, redrawn, series_csv, sort, summarise, summary_csv, timings_csv, units_csv,
};
use crate::unit::UnitConfig;
use crate::unit_error::UnitError;
use motes_cli::{Interrupt, result, status};

/// How a run ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Finished {
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
pub fn reproduce(plan: &Plan, estimator: &Estimator, interrupt: &Interrupt) -> Result<Finished, StoreError> {
    let mut store = Store::open(&plan.folder)?;
    let wanted: Vec<(Point, UnitConfig)> = plan
        .points()
        .into_iter()
        .filter_map(|point| UnitConfig::at(plan, &point).map(|unit| (point, unit)))
        .collect();
    if plan.fresh {
        store.remove(wanted.iter().map(|(_, unit)| unit))?;
    }
    let (there, remarks) = read(plan, &mut store)?;
    remarks.iter().for_each(|remark| status(remark));
    let models = plan.save_models.then(|| plan.folder.join("models"));
    let is_there = |(point, unit): &(Point, UnitConfig)| {
        let has_model = models
            .as_ref()
            .is_none_or(|models| !unit.method.method().is_learned() || models.join(unit.key()).exists());
        let recorded = there.iter().find(|record| record.is_of(point, unit));
        recorded.is_some_and(|record| has_model || matches!(record.outcome, Outcome::Failed(_)))
    };
    let missing: Vec<&(Point, UnitConfig)> = wanted.iter().filter(|wanted| !is_there(wanted)).collect();
    announce(plan, wanted.len(), missing.len());
    if !missing.is_empty() {
        run_missing(plan, &mut store, &missing, (models.clone(), estimator), interrupt)?;
    }

    let (records, _) = read(plan, &mut store)?;
    write_outputs(plan, &store, &records)?;
    let recorded =
        |(point, unit): &(Point, UnitConfig)| records.iter().find(|record| record.is_of(point, unit));
    let left = wanted.iter().filter(|wanted| recorded(wanted).is_none()).count();
    if left > 0 {
        let fresh = if plan.fresh { ", given without --fresh," } else { "" };
        status(&format!(
            "stopped with {left} units left; the same command{fresh} goes on where this one stopped"
        ));
        return Ok(Finished::Interrupted);
    }
    let has_failed = |record: &&Record| matches!(record.outcome, Outcome::Failed(_));
    let failed = wanted.iter().filter_map(recorded).filter(has_failed).count();
    if failed > 0 {
        status(&format!(
            "{failed} of {} units failed; failures.csv says why, --fresh runs them again",
            wanted.len()
        ));
    }
    Ok(Finished::Complete { ran: missing.len(), failed })
}

/// The folder's units that belong to this plan's configuration, sorted, and remarks on the others, which are left alone.
fn read(plan: &Plan, store: &mut Store) -> Result<(Vec<Record>, Vec<String>), StoreError> {
    let Contents { mut records, damaged, torn, foreign } = store.read()?;
    let mut remarks = Vec::new();
    for (count, what) in [(damaged, "damaged units"), (torn, "lines that a killed run had begun")] {
        if count > 0 {
            let path = store.damaged();
            remarks.push(format!(
                "{what} set aside in {}: {count}; what is missing is computed again",
                path.display()
            ));
        }
    }
    let all = records.len() + foreign;
    let mut differences = BTreeSet::new();
    if foreign > 0 {
        differences.insert("they were written by another version of this program".to_string());
    }
    records.retain(|record| {
        let expected = UnitConfig::at(plan, &record.point);
        let belongs = expected.as_ref() == Some(&record.config);
        if !belongs {
            differences.insert(differs(&record.config, expected.as_ref()));
        }
        belongs
    });
    if !differences.is_empty() {
        let (others, folder) = (all - records.len(), store.folder().display());
        let differences: Vec<String> = differences.into_iter().collect();
        remarks.push(format!(
            "{others} units in {folder} are of another run and not used: {}",
            differences.join("; ")
        ));
    }
    sort(plan, &mut records);
    Ok((records, remarks))
}

/// The first setting in which a stored unit differs from what this run would do.
fn differs(found: &UnitConfig, expected: Option<&UnitConfig>) -> String {
    let Some(expected) = expected else { return "this experiment has no such panel or method".into() };
    let json = |unit: &UnitConfig| serde_json::to_value(unit).unwrap_or_default();
    first_difference("", &json(found), &json(expected)).unwrap_or_else(|| "they differ".into())
}

fn first_difference(path: &str, found: &serde_json::Value, expected: &serde_json::Value) -> Option<String> {
    match (found.as_object(), expected.as_object()) {
        (Some(found), Some(expected)) => {
            let absent = serde_json::Value::Null;
            found.keys().chain(expected.keys()).find_map(|key| {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                let side = |side: &serde_json::Map<_, _>| side.get(key).cloned().unwrap_or(absent.clone());
                first_difference(&path, &side(found), &side(expected))
            })
        }
        _ => (found != expected).then(|| format!("{path} is {found} there and {expected} here")),
    }
}

fn announce(plan: &Plan, wanted: usize, missing: usize) {
    status(&plan.to_string());
    match wanted - missing {
        0 => status(&format!("{missing} units to run on {} threads", plan.jobs)),
        done => status(&format!("{done} units are there, {missing} to run on {} threads", plan.jobs)),
    }
}

fn run_missing(
    plan: &Plan,
    store: &mut Store,
    missing: &[&(Point, UnitConfig)],
    (models, estimator): (Option<PathBuf>, &Estimator),
    interrupt: &Interrupt,
) -> Result<(), StoreError> {
    let points: Vec<Point> = missing.iter().map(|(point, _)| point.clone()).collect();
    let units: Vec<UnitConfig> = missing.iter().map(|(_, unit)| unit.clone()).collect();
    let estimates = estimator.seconds(plan, &points, interrupt);
    let total: f64 = estimates.iter().sum();
    status(&format!("estimated time {}", duration(total / plan.jobs.min(units.len()) as f64)));
    let here = Provenance::here();
    let checkpoints = Checkpoints { folder: checkpoint::folder(store.folder()), provenance: here.clone() };
    let evaluator = Evaluator::new(models).with_checkpoints(checkpoints).keeping(plan.learned.clone());
    let mut progress = Progress::start(units.len(), total);
    let name = |point: &Point| {
        format!("{} x = {} {} repetition {}", point.panel, point.x, point.method.name(), point.repetition)
    };
    let evaluate = |unit: &UnitConfig, interrupt: &Interrupt| evaluator.evaluate(unit, interrupt);
    run(&units, plan.jobs, interrupt, &evaluate, |event| {
        match event {
            Event::Started(index) => progress.started(&name(&points[index])),
            Event::Ended(_, Err(UnitError::Interrupted)) => {}
            Event::Ended(_, Err(UnitError::NotKept(reason))) => return Err(StoreError::Model(reason)),
            Event::Ended(index, result) => {
                let (outcome, earlier, timings, series) = match result {
                    Ok(found) => {
                        (Outcome::Metrics(found.metrics), found.earlier, found.timings, found.series)
                    }
                    Err(error) => (Outcome::Failed(error.to_string()), vec![], vec![], None),
                };
                let Provenance { revision, processor } = here.after(&earlier);
                let record = Record {
                    point: points[index].clone(),
                    config: units[index].clone(),
                    revision,
                    processor: Some(processor),
                    outcome,
                    timings,
                    series,
                };
                store.write(&record)?;
                let failure = match &record.outcome {
                    Outcome::Failed(reason) => Some(reason.as_str()),
                    Outcome::Metrics(_) => None,
                };
                progress.ended(&name(&points[index]), estimates[index], failure);
            }
        }
        Ok::<(), StoreError>(())
    })?;
    progress.finish();
    Ok(())
}

fn write_outputs(plan: &Plan, store: &Store, records: &[Record]) -> Result<(), StoreError> {
    let figure_name = &plan.figure;
    let rows = summarise(records);
    let (axis, title) = (plan.experiment.axis.symbol(), &plan.experiment.title);
    let title = format!("{title} ({figure_name}, profile {})", plan.profile_name);
    let mut table = markdown(&title, axis, &rows, &plan.experiment.printed);
    if let Some(note) = redrawn(records) {
        table += &format!("\n{note}\n");
    }
    store.write_file("units.csv", &units_csv(figure_name, records))?;
    store.write_file("timings.csv", &timings_csv(figure_name, records))?;
    store.write_file("failures.csv", &failures_csv(figure_name, records))?;
    store.write_file("summary.csv", &summary_csv(figure_name, &rows))?;
    store.write_file("table.md", &table)?;
    store.write_file("manifest.json", &manifest(plan, records))?;
    if !rows.is_empty() {
        let svg = match &plan.experiment.series {
            None => figure(plan, &title, &rows),
            Some(shown) => series_figure(shown, &title, records),
        };
        store.write_file("figure.svg", &svg.map_err(|error| StoreError::Figure(error.to_string()))?)?;
    }
    if plan.experiment.series.is_some() {
        store.write_file("series.csv", &series_csv(figure_name, records))?;
    }
    let of =
        [(revisions(records).len(), "source revisions"), (processors(records).len(), "kinds of processors")];
    for (count, kind) in of.into_iter().filter(|(count, _)| *count > 1) {
        status(&format!("these units are of {count} {kind}; manifest.json lists them"));
    }
    result(&table);
    result(&format!("written to {}", store.folder().display()));
    Ok(())
}

/// How long the paper profile of the whole figure would take on this machine with as many threads, as a person says it;
/// `None` if the experiment has no such profile or the run is being stopped.
pub fn paper_estimate(plan: &Plan, estimator: &Estimator, interrupt: &Interrupt) -> Option<String> {
    let profile = plan.experiment.profiles.get("paper")?.clone();
    let chosen = |panel: &&Panel| profile.panels.as_ref().is_none_or(|names| names.contains(&panel.name));
    let paper = Plan {
        panels: plan.experiment.panels.iter().filter(chosen).cloned().collect(),
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
