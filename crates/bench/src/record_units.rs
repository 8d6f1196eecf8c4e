//! Units evaluated, and a record made of each.

use crate::checkpoint::{self, Checkpoints};
use crate::config::{Plan, Point};
use crate::evaluate::Evaluator;
use crate::progress::Progress;
use crate::provenance::Provenance;
use crate::runner::{Event, run};
use crate::standing::PlacedUnit;
use crate::store::{Outcome, Record, StoreError};
use crate::unit_error::UnitError;
use motes_cli::Interrupt;

/// Who is told of units as they begin, and keeps their records as they end.
pub(crate) trait Keeper {
    /// A unit has begun.
    fn started(&mut self, _name: &str) {}

    /// Keeps the record of a unit that has ended.
    fn keep(&mut self, record: &Record) -> Result<(), StoreError>;
}

/// What a person calls a unit.
pub(crate) fn name(point: &Point) -> String {
    format!("{} x = {} {} repetition {}", point.panel, point.x, point.method.name(), point.repetition)
}

/// Evaluates units of a plan on its threads; `estimates` are the seconds of each. Ends early if the interrupt is raised.
///
/// # Errors
/// What the keeper says, or a trained proposal that could not be kept.
pub(crate) fn record_units(
    wanted: &[PlacedUnit],
    estimates: &[f64],
    (plan, here): (&Plan, &Provenance),
    interrupt: &Interrupt,
    keeper: &mut dyn Keeper,
) -> Result<(), StoreError> {
    let checkpoints = Checkpoints { folder: checkpoint::folder(&plan.folder), provenance: here.clone() };
    let evaluator = Evaluator::new(plan.models()).with_checkpoints(checkpoints).keeping(plan.learned.clone());
    let units: Vec<_> = wanted.iter().map(|(_, unit)| unit.clone()).collect();
    let mut progress = Progress::start(units.len(), estimates.iter().sum());
    let evaluate = |unit: &_, interrupt: &Interrupt| evaluator.evaluate(unit, interrupt);
    run(&units, plan.jobs, interrupt, &evaluate, |event| {
        match event {
            Event::Started(index) => {
                let name = name(&wanted[index].0);
                progress.started(&name);
                keeper.started(&name);
            }
            Event::Ended(_, Err(UnitError::Interrupted)) => {}
            Event::Ended(_, Err(UnitError::NotKept(reason))) => return Err(StoreError::Model(reason)),
            Event::Ended(index, result) => {
                let (point, config) = wanted[index].clone();
                let (outcome, earlier, timings, series) = match result {
                    Ok(found) => {
                        (Outcome::Metrics(found.metrics), found.earlier, found.timings, found.series)
                    }
                    Err(error) => (Outcome::Failed(error.to_string()), vec![], vec![], None),
                };
                let Provenance { revision, processor } = here.after(&earlier);
                let processor = Some(processor);
                let record = Record { point, config, revision, processor, outcome, timings, series };
                keeper.keep(&record)?;
                let failure = match &record.outcome {
                    Outcome::Failed(reason) => Some(reason.as_str()),
                    Outcome::Metrics(_) => None,
                };
                progress.ended(&name(&record.point), estimates[index], failure);
            }
        }
        Ok(())
    })?;
    progress.finish();
    Ok(())
}
