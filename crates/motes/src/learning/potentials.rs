//! Potentials of whole sequences, learned beside a proposal.

use std::ops::ControlFlow;

use motes_models::{ModelShape, Seed, Trajectory};
use motes_proposals::{Backend, Family, LearnedPotentials, LearnedPotentialsConfig, Sees};
use motes_smc::RecordedStep;
use motes_train::{LearnObjective, PathSource, PotentialLearnConfig, TrainError, learn_potentials};

use super::options::LearnOptions;
use crate::contender::Contender;
use crate::data::Data;
use crate::error::MotesError;
use crate::evidence::{JudgedSequence, LearnedWorth, candidates, judge as judge_evidence};
use crate::filter_source::FilterSource;
use crate::learned::LearnedProposal;
use crate::learned_notes::PotentialNotes;
use crate::model::Model;
use crate::options::ProposalName;
use crate::own_model::LearnableModel;
use crate::recorded::steps_to_row;
use crate::simulating::{SimulatedRow, simulate_some};

/// Updates of potentials, each of whole sequences, for one of a network for each particle.
const SHARE: f64 = 0.3;

/// Whether potentials are learned: from simulations, for a model that says how its states are made of noise.
pub(super) fn learns_potentials(model: &dyn LearnableModel, options: &LearnOptions) -> bool {
    options.objective == LearnObjective::Inclusive && model.has_gradients() && model.noise_space().is_some()
}

/// Learns potentials, or says why there are none: simulated sequences leave the numbers again and again. `proceed` is asked after each update, with how many of how many are done.
///
/// # Errors
/// [`MotesError::Interrupted`] if `proceed` says so, and as [`learn_potentials`].
pub(super) fn potentials<'a>(
    source: PathSource<'a, dyn LearnableModel + 'a>,
    shape: &ModelShape,
    options: &LearnOptions,
    seed: &Seed,
    proceed: &mut dyn FnMut(usize, usize) -> ControlFlow<()>,
) -> Result<Result<(LearnedPotentials, PotentialNotes), String>, MotesError> {
    let settings = PotentialLearnConfig {
        steps: (options.updates as f64 * SHARE).ceil() as usize,
        horizon: options.steps,
        seconds: options.seconds,
        ..PotentialLearnConfig::new()
    };
    let seed = seed.child("potentials");
    let config = LearnedPotentialsConfig::default();
    let mut potentials =
        LearnedPotentials::create(&config, shape, 0, Backend::Native.into(), &seed.child("weights"))?;
    let mut is_stopped = false;
    let learned = learn_potentials(&mut potentials, source, &settings, &seed, |done, _| {
        let asked = proceed(done, settings.steps);
        is_stopped = asked.is_break();
        asked
    });
    if is_stopped {
        return Err(MotesError::Interrupted);
    }
    let learned = match learned {
        // Proposals of a step learn from sequences that end early; potentials need whole ones.
        Err(error @ TrainError::Simulations { .. }) => return Ok(Err(error.to_string())),
        learned => learned?,
    };
    let [gain, gain_now] = learned.best_gains();
    let (updates, seconds) = (learned.steps, learned.seconds);
    let notes = PotentialNotes {
        updates,
        seconds,
        gain,
        gain_now,
        filters: FilterSource::Network,
        worth: None,
        prior: None,
        folder_notes: None,
    };
    Ok(Ok((potentials, notes)))
}

/// Sequences by which potentials are judged.
pub(super) const SEQUENCES: usize = 20;

/// So many sequences of a model at the most, for [`judge`].
///
/// # Errors
/// [`MotesError::Simulation`] where no sequence stays finite.
pub(super) fn judged(
    model: &Model,
    data: Option<&Data>,
    options: &LearnOptions,
    count: usize,
    seed: &Seed,
) -> Result<Vec<JudgedSequence>, MotesError> {
    let drawn = simulate_some(model, data, options.steps, count, seed)?;
    Ok(drawn
        .series
        .iter()
        .zip(&drawn.rows)
        .map(|of_one| JudgedSequence { model: model.clone(), steps: recorded_of(of_one) })
        .collect())
}

/// A simulated series as it is filtered.
fn recorded_of((series, rows): (&Trajectory, &Vec<SimulatedRow>)) -> Vec<RecordedStep> {
    let to_row = |(row, measurement): (&SimulatedRow, &[f64])| {
        let entries: Vec<Option<f64>> = measurement.iter().copied().map(Some).collect();
        steps_to_row(&row.steps, &entries).collect::<Vec<RecordedStep>>()
    };
    rows.iter().zip(series.measurements.rows()).flat_map(to_row).collect()
}

/// How well the evidence of recorded sequences is estimated with potentials and with designed proposals, on sequences that nothing was learned from.
///
/// # Errors
/// [`MotesError::Interrupted`].
pub(super) fn judge(
    model: &Model,
    learned: LearnedProposal,
    sequences: Vec<JudgedSequence>,
    options: &LearnOptions,
    seed: &Seed,
    proceed: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<LearnedProposal, MotesError> {
    let Some(notes) = learned.potential_notes().cloned() else { return Ok(learned) };
    let by = ProposalName::Learned;
    let designed = Contender::of(&candidates(model)).into_iter();
    let per_particle = learned.proposal().map(|_| {
        Contender::on_line(by(learned.clone().without_potentials())).called("learned, per particle")
    });
    let has_network = per_particle.is_some();
    let now =
        Contender::on_line(by(learned.clone().filtering_by(FilterSource::Potential))).called("learned, now");
    let ahead = Contender::ahead(by(learned.clone())).called("learned, ahead");
    let contenders: Vec<Contender> = designed.chain(per_particle).chain([now, ahead]).collect();
    let mut designed = judge_evidence(&contenders, sequences, &seed.child("runs"), proceed)?;
    let (Some(ahead), Some(now)) = (designed.pop(), designed.pop()) else { return Ok(learned) };
    let per_particle = if has_network { designed.pop() } else { None };
    let worth = LearnedWorth { designed, per_particle, now, ahead };
    let filters = if asks_for_network(options) { FilterSource::Network } else { worth.best_filter() };
    Ok(learned.with_potential_notes(PotentialNotes { worth: Some(worth), filters, ..notes }))
}

/// Whether a network of some kind is asked for, by which filters then draw.
pub(super) fn asks_for_network(options: &LearnOptions) -> bool {
    options.start.is_some()
        || options.base.is_some()
        || options.head.is_some()
        || options.widths.is_some()
        || options.sees != Sees::All
        || options.dropout > 0.0
        || options.weight_penalty > 0.0
}
