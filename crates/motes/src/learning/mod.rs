//! Learning a proposal for a model, once.

mod choice;
mod names;
mod options;
mod outcome;
mod over_prior;
mod potentials;
mod sub_steps;
mod worth;

use std::ops::ControlFlow;

use motes_models::{PartialMeasurements, Seed};
use motes_proposals::{Amortised, Backend, Base, Family, HeadConfig};
use motes_train::{LearnConfig, LearnObjective, PathSource, TrainError, check_recorded, learn as train};

pub use names::{base_named, head_named, network_named};
pub use options::LearnOptions;
pub use outcome::LearnOutcome;
pub use over_prior::learns_over_prior;

use crate::data::Data;
use crate::error::MotesError;
use crate::learned::{LearnedProposal, learnable, shape_of};
use crate::learned_notes::Notes;
use crate::model::Model;
use crate::own_model::{LearnableModel, draws_transitions_alone};
use crate::simulating::{check_draws, schedule};
use choice::{Choice, choose};
use over_prior::{PriorLearning, prior_of};
use potentials::{SEQUENCES, asks_for_network, judge, judged, learns_potentials, potentials};
use sub_steps::check_sub_steps;
use worth::worse_than;

/// Learning ends where after such a share of its updates nothing was better than the base.
const PATIENCE: f64 = 0.3;

/// Learns a proposal for `model`. Where parameters have priors and no other value, potentials are learned over these, and serve the model with any parameters. Otherwise, or where that fails,
/// a proposal is learned for the values that the model has, by the objective of `options`: from sequences that the model draws for itself and in addition from the series of `data`, or from
/// these alone. `proceed` is asked after each update, with how many of how many are done.
///
/// ```
/// use motes::{FilterOptions, LearnOptions, Model, ProposalName, learn};
/// use std::ops::ControlFlow;
///
/// let text = r#"
///     [initial]
///     x = "normal(0, 1)"
///     [transition]
///     x = "normal(0.9*x, 1)"
///     [measurement]
///     y = "normal(0, exp(x/2))"
/// "#;
/// let model = Model::parse(text, "volatility", &[])?;
/// let options = LearnOptions { updates: 100, ..LearnOptions::default() };
/// let learned = learn(&model, None, &options, |_, _| ControlFlow::Continue(()))?;
/// # assert!(learned.warnings().is_empty());
/// let filter = FilterOptions { proposal: ProposalName::Learned(learned.proposal), ..FilterOptions::default() };
/// # assert!(filter.defensive_share() <= 0.1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`MotesError`] for an option out of range, an objective without the data or the head that it needs, a model that has nothing to learn, and one whose
/// simulations all overflow; for a start that was learned for another model, too.
pub fn learn(
    model: &Model,
    data: Option<&Data>,
    options: &LearnOptions,
    mut proceed: impl FnMut(usize, usize) -> ControlFlow<()>,
) -> Result<LearnOutcome, MotesError> {
    learn_until(model, data, options, &mut proceed)
}

/// [`learn`], compiled once whatever asks.
fn learn_until(
    model: &Model,
    data: Option<&Data>,
    options: &LearnOptions,
    proceed: &mut dyn FnMut(usize, usize) -> ControlFlow<()>,
) -> Result<LearnOutcome, MotesError> {
    // It learns from simulations.
    check_draws(model)?;
    if let Some(reason) = model.measured_exactly() {
        return Err(MotesError::Setting(format!("{reason}; take --proposal exact, which needs no learning")));
    }
    let started = std::time::Instant::now();
    let seed = Seed::from_u64(options.seed).child("learn");
    let schedule = schedule(model, data, options.steps, &seed)?;
    schedule.as_ref().map_or(Ok(()), |schedule| check_sub_steps(learnable(model)?, schedule))?;
    let scheduled = schedule.and_then(|schedule| model.along(schedule));
    let simulated = scheduled.as_ref().unwrap_or(model);
    let learnable = learnable(simulated)?;
    if let Some(reason) = draws_transitions_alone(learnable) {
        return Err(MotesError::Setting(format!(
            "{reason}: there is nothing to learn; take --proposal bootstrap"
        )));
    }
    let settings = LearnConfig {
        objective: options.objective,
        continues: options.start.is_some(),
        dropout: options.dropout,
        weight_penalty: options.weight_penalty,
        steps: options.updates,
        horizon: options.steps,
        seconds: options.seconds,
        // Where the base is the optimum there is nothing to wait for. Figures of recorded data are too noisy to tell.
        patience: (options.objective == LearnObjective::Inclusive)
            .then(|| (PATIENCE * options.updates as f64).ceil() as usize),
        ..LearnConfig::new()
    };
    // Data of a model with times or inputs say what these are; steps of recorded measurements have their own.
    let recorded = match (data, &scheduled) {
        (Some(data), None) => recorded(model, data)?,
        _ => vec![],
    };
    check_recorded(learnable, &recorded)?;
    if !learnable.has_gradients() {
        let asked = match (options.base, options.objective) {
            (Some(Base::Linearised), _) => Some("base linearised"),
            (_, LearnObjective::Fivo) => Some("objective fivo"),
            _ => None,
        };
        if let Some(asked) = asked {
            return Err(MotesError::Setting(format!("{asked}: the model has no derivatives")));
        }
    }
    if options.objective.needs_recorded() && recorded.is_empty() {
        return Err(TrainError::NoRecorded { objective: options.objective.to_string() }.into());
    }
    if options.objective == LearnObjective::Fivo && matches!(options.head, Some(HeadConfig::Mixture { .. })) {
        return Err(TrainError::Draws.into());
    }
    let has_potentials = learns_potentials(learnable, options);
    let (mut not_over_prior, mut no_potentials) = (None, None);
    if let Some(prior) = prior_of(model, data, options) {
        match (PriorLearning { model, prior, options, seed: &seed }).learn(started, proceed)? {
            Ok(learned) => return Ok(learned),
            Err(reason) => not_over_prior = Some(reason),
        }
    }
    // A bar of three parts, choosing and twice as long training; then one of potentials.
    let parts = if has_potentials { 4 } else { 3 };
    let (reason, mut proposal) = match &options.start {
        Some(start) => {
            start.check_model(simulated).map_err(|error| MotesError::Setting(format!("start: {error}")))?;
            let Some(proposal) = start.proposal() else {
                let reason =
                    "start: it holds potentials alone, learned over a prior, which are not learned further";
                return Err(MotesError::Setting(reason.into()));
            };
            (format!("{}, learned further", start.name()), proposal.clone())
        }
        None => {
            let Choice { config, reason } =
                choose(learnable, options, &settings, &seed, |done, total| proceed(done, parts * total))?;
            let (shape, compute) = (shape_of(learnable), Backend::Native.into());
            (reason, Amortised::create(&config, &shape, 0, compute, &seed.child("weights"))?)
        }
    };
    let mut is_stopped = false;
    let history = train(&mut proposal, learnable, &recorded, &settings, &seed, |done, _| {
        let asked = proceed(settings.steps + 2 * done, parts * settings.steps);
        is_stopped = asked.is_break();
        asked
    })?;
    if is_stopped {
        return Err(MotesError::Interrupted);
    }
    let notes = Notes { choice: reason, updates: history.steps, seconds: history.seconds, worse_than: None };
    let mut learned = LearnedProposal::new("learned".into(), Some(proposal), notes, learnable);
    if has_potentials {
        let mut tell = |done, total| proceed(3 * total + done, 4 * total);
        match potentials(PathSource::Model(learnable), &shape_of(learnable), options, &seed, &mut tell)? {
            Ok((found, notes)) => {
                learned = learned.with_potentials(found, notes);
                let seed = seed.child("recorded worth");
                let sequences = judged(model, data, options, SEQUENCES, &seed.child("sequences"))?;
                learned = judge(model, learned, sequences, options, &seed, &mut || proceed(1, 1))?;
            }
            Err(reason) => no_potentials = Some(reason),
        }
    }
    let is_chosen = learned.potential_notes().is_some() && !asks_for_network(options);
    let worse_than = match is_chosen {
        true => None,
        false => worse_than(model, &learned, data, options, &seed.child("worth"))?,
    };
    let training_seconds = started.elapsed().as_secs_f64();
    let notes = Notes { worse_than, seconds: training_seconds, ..learned.notes().clone() };
    let (proposal, history) = (learned.with_notes(notes), Some(history));
    Ok(LearnOutcome { proposal, history, not_over_prior, no_potentials, training_seconds })
}

/// The measurements of each series.
fn recorded(model: &Model, data: &Data) -> Result<Vec<PartialMeasurements>, MotesError> {
    let width = model.measurements().len();
    let of_series = |places: Vec<usize>| {
        let rows = places.iter().flat_map(|at| data.rows[*at].measurement.iter().copied());
        Ok(PartialMeasurements::new(width, rows.collect())?)
    };
    data.by_series().into_iter().map(of_series).collect()
}
