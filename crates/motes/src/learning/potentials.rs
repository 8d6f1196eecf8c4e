//! Potentials of whole sequences, learned beside a proposal.

use std::ops::ControlFlow;

use motes_models::Seed;
use motes_proposals::{Backend, Family, LearnedPotentials, LearnedPotentialsConfig, Sees};
use motes_smc::RecordedStep;
use motes_train::{LearnObjective, PotentialLearnConfig, TrainError, learn_potentials};

use super::options::LearnOptions;
use crate::data::Data;
use crate::error::MotesError;
use crate::evidence::{
    AHEAD, Contender, EvidenceWorth, NETWORK, NOW, ON_LINE, candidates, counted, fixed_cost, judged,
};
use crate::learned::{LearnedProposal, PotentialNotes, shape_of};
use crate::model::{LearnableModel, Model};
use crate::options::ProposalName;
use crate::simulating::simulate_some;

/// Updates of potentials, each of whole sequences, for one of a network for each particle.
const SHARE: f64 = 0.3;

/// Whether potentials are learned: from simulations, for a model that says how its states are made of noise.
pub(super) fn learns_potentials(model: &dyn LearnableModel, options: &LearnOptions) -> bool {
    options.objective == LearnObjective::Inclusive && model.has_gradients() && model.noise_space().is_some()
}

/// Learns potentials; none where simulated sequences leave the numbers again and again. `proceed` is asked after each update, with how many of how many are done.
///
/// # Errors
/// [`MotesError::Interrupted`] if `proceed` says so, and as [`learn_potentials`].
pub(super) fn potentials(
    model: &dyn LearnableModel,
    options: &LearnOptions,
    seed: &Seed,
    proceed: &mut dyn FnMut(usize, usize) -> ControlFlow<()>,
) -> Result<Option<(LearnedPotentials, PotentialNotes)>, MotesError> {
    let settings = PotentialLearnConfig {
        steps: (options.updates as f64 * SHARE).ceil() as usize,
        horizon: options.steps,
        seconds: options.seconds,
        ..PotentialLearnConfig::new()
    };
    let seed = seed.child("potentials");
    let config = LearnedPotentialsConfig::default();
    let mut potentials = LearnedPotentials::create(
        &config,
        &shape_of(model),
        0,
        Backend::Native.into(),
        &seed.child("weights"),
    )?;
    let mut is_stopped = false;
    let learned = learn_potentials(&mut potentials, model, &settings, &seed, |done, _| {
        let asked = proceed(done, settings.steps);
        is_stopped = asked.is_break();
        asked
    });
    if is_stopped {
        return Err(MotesError::Interrupted);
    }
    match learned {
        // One-step proposals learn from sequences that end early; potentials need whole ones.
        Err(TrainError::Setting { .. }) => Ok(None),
        learned => {
            let learned = learned?;
            let [gain, gain_now] = learned.best_gains();
            let (updates, seconds) = (learned.steps, learned.seconds);
            Ok(Some((
                potentials,
                PotentialNotes { updates, seconds, gain, gain_now, filters: false, worth: vec![] },
            )))
        }
    }
}

/// Sequences by which potentials are judged.
const SEQUENCES: usize = 20;

/// How well the evidence of recorded sequences is estimated with potentials and with designed proposals, on sequences that nothing was learned from.
///
/// # Errors
/// [`MotesError::Interrupted`], and [`MotesError::Simulation`] where no sequence stays finite.
pub(super) fn judge(
    model: &Model,
    learned: LearnedProposal,
    data: Option<&Data>,
    options: &LearnOptions,
    seed: &Seed,
    proceed: &(dyn Fn() -> ControlFlow<()> + Sync),
) -> Result<LearnedProposal, MotesError> {
    let Some(notes) = learned.potential_notes().cloned() else { return Ok(learned) };
    let drawn = simulate_some(model, data, options.steps, SEQUENCES, &seed.child("sequences"))?;
    let recorded = |number: usize| -> Vec<RecordedStep> {
        let mut recorded = Vec::new();
        for (row, measurement) in drawn.rows[number].iter().zip(drawn.series[number].measurements.rows()) {
            let nothing = vec![None; measurement.len()];
            recorded.extend(
                row.steps
                    .iter()
                    .map(|step| RecordedStep { step: step.clone(), measurement: nothing.clone() }),
            );
            if let Some(last) = recorded.last_mut() {
                last.measurement = measurement.iter().copied().map(Some).collect();
            }
        }
        recorded
    };
    let sequences = (0..drawn.series.len()).map(recorded).collect();
    let of_designed = |proposal: ProposalName| Contender {
        name: proposal.to_string(),
        looks_ahead: true,
        work: [fixed_cost(&proposal, model), counted(&proposal)],
        proposal,
    };
    let mut contenders: Vec<Contender> = candidates(model).into_iter().map(of_designed).collect();
    let by = |name: &str, learned: LearnedProposal, looks_ahead: bool, work: [f64; 2]| Contender {
        name: name.into(),
        proposal: ProposalName::Learned(learned),
        looks_ahead,
        work,
    };
    let (ahead, network) = (ProposalName::Learned(learned.clone()), learned.clone().without_potentials());
    let of_network = [0.0, counted(&ProposalName::Learned(network.clone()))];
    contenders.push(by(NETWORK, network, false, of_network));
    contenders.push(by(NOW, learned.clone().filtering_by_potential(true), false, ON_LINE));
    contenders.push(by(AHEAD, learned.clone(), true, [fixed_cost(&ahead, model), counted(&ahead)]));
    let worth = judged(model, &contenders, sequences, &seed.child("runs"), proceed)?;
    let of = |name: &str| worth.iter().find(|worth| worth.proposal == name).map(EvidenceWorth::inefficiency);
    // Who asks for a network of some kind filters with that.
    let is_asked = options.base.is_some() || options.head.is_some() || options.widths.is_some();
    let filters = !is_asked && options.sees == Sees::All && of(NOW) < of(NETWORK);
    let learned = learned.filtering_by_potential(filters);
    let notes = PotentialNotes { worth, filters, ..notes };
    Ok(learned.with_potential_notes(notes))
}
