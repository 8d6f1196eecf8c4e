//! One pass along a sequence: draws particles forward in time, then takes the objective's gradient backward.

use motes_models::batch::Rows;
use motes_models::{Measurements, PartialMeasurements, StateGradients, Stream};
use motes_proposals::networks::Inputs;
use motes_proposals::{Learnable, Workspace};
use motes_smc::ProposalError;

use crate::fit::check_fit;
use crate::{GradientFlow, Objective, TrainError};

/// The objective of one batch of particles and its gradient.
pub struct Rollout {
    /// The value of the objective.
    pub objective: f64,
    /// Holds the gradient of the *loss*, minus the objective, with respect to the proposal's weights.
    pub workspace: Workspace,
}

/// Draws `particles` particles along `measurements`, without resampling, and differentiates the objective.
///
/// The derivative of the objective with respect to `x_t` is a sum of three terms. The densities at `x_t` give the first, the
/// transition into `x_{t+1}` gives the second, and every later draw gives the third, through the proposal's networks.
/// `gradient` says how far back the last two reach.
///
/// # Errors
/// [`TrainError::Setting`] or [`TrainError::Model`] for input that does not fit, [`TrainError::Proposal`] if the proposal fails.
pub fn rollout(
    proposal: &dyn Learnable,
    model: &dyn StateGradients,
    measurements: &Measurements,
    objective: Objective,
    gradient: GradientFlow,
    particles: usize,
    stream: &mut Stream,
) -> Result<Rollout, TrainError> {
    gradient.check()?;
    check_fit(proposal, model, measurements, particles)?;
    let workspace = Workspace::new(proposal.parameters());
    let (objective, workspace) = draw_and_differentiate(
        proposal,
        model,
        measurements,
        objective,
        gradient,
        particles,
        stream,
        workspace,
    )
    .map_err(in_step(0, None))?;
    Ok(Rollout { objective, workspace })
}

/// [`rollout`] of input that is known to fit. The workspace comes back with the gradients in it, an error with its time.
#[allow(clippy::too_many_arguments, reason = "the arguments of rollout and the memory")]
pub(crate) fn draw_and_differentiate(
    proposal: &dyn Learnable,
    model: &dyn StateGradients,
    measurements: &Measurements,
    objective: Objective,
    gradient: GradientFlow,
    particles: usize,
    stream: &mut Stream,
    workspace: Workspace,
) -> Result<(f64, Workspace), (usize, ProposalError)> {
    let density = model.density().ok_or((0, ProposalError::NoDensity))?;
    let (n, horizon) = (model.state_dim(), measurements.len());
    let block = particles * n;
    let mut tape = proposal.tape(particles, workspace).map_err(|source| (0, source))?;
    let mut states = vec![0.0; horizon * block];
    let mut log_model = vec![0.0; horizon * particles];
    let needs = objective.needs_log_proposal();
    let mut log_proposal = vec![0.0; if needs { horizon * particles } else { 0 }];
    let (mut noise, mut log_likelihood) = (vec![0.0; block], vec![0.0; particles]);
    let entries = PartialMeasurements::from(measurements);

    for (time, (measurement, entries)) in measurements.rows().zip(entries.rows()).enumerate() {
        let (earlier, now) = states.split_at_mut(time * block);
        let previous = (time > 0).then(|| &earlier[(time - 1) * block..]);
        let now = &mut now[..block];
        let at = time * particles..(time + 1) * particles;
        proposal.fill_noise(stream, &mut noise);
        let inputs = Inputs { time, width: n, previous, measurement, particles };
        let log_density = needs.then(|| &mut log_proposal[at.clone()]);
        tape.draw(&inputs, &noise, now, log_density).map_err(|source| (time, source))?;
        let log_model = &mut log_model[at];
        let step = model.step_of_index(time);
        density.log_densities(&step, previous.map(|rows| Rows::all(rows, n)), now, log_model);
        model
            .log_likelihoods(&step, now, entries, &mut log_likelihood)
            .map_err(|error| (time, ProposalError::Measurement { time, reason: error.to_string() }))?;
        log_model.iter_mut().zip(&log_likelihood).for_each(|(sum, term)| *sum += term);
    }

    let evaluation = objective.evaluate(&log_model, &log_proposal, particles);
    if !evaluation.value.is_finite() {
        // There is no derivative to take; the caller reports the value.
        return Ok((evaluation.value, tape.finish()));
    }

    // What the loss changes by with x_t, from all that came after it.
    let mut carried = vec![0.0; block];
    let (mut d_states, mut d_previous, mut term) = (vec![0.0; block], vec![0.0; block], vec![0.0; block]);
    for time in (0..horizon).rev() {
        let at = time * particles..(time + 1) * particles;
        let weights = &evaluation.d_log_model[at.clone()];
        let now = &states[time * block..(time + 1) * block];
        d_states.copy_from_slice(&carried);
        model.likelihood_gradients(&model.step_of_index(time), now, measurements.row(time), &mut term);
        subtract_weighted(&mut d_states, weights, &term);
        carried.fill(0.0);
        if time == 0 {
            model.initial_gradients(&model.step_of_index(0), now, &mut term);
        } else {
            let previous = &states[(time - 1) * block..time * block];
            model.transition_gradients(&model.step_of_index(time), previous, now, &mut d_previous, &mut term);
            subtract_weighted(&mut carried, weights, &d_previous);
        }
        subtract_weighted(&mut d_states, weights, &term);
        let d_log_density: Option<Vec<f64>> =
            evaluation.d_log_proposal.as_ref().map(|d| d[at].iter().map(|weight| -weight).collect());
        tape.pull_back(&d_states, d_log_density.as_deref(), &mut d_previous)
            .map_err(|source| (time, source))?;
        if gradient.ends_at(time) {
            carried.fill(0.0);
            tape.detach();
        } else {
            carried.iter_mut().zip(&d_previous).for_each(|(sum, d)| *sum += d);
        }
    }
    Ok((evaluation.value, tape.finish()))
}

/// `into −= weight_k · term_k` for each particle `k`.
fn subtract_weighted(into: &mut [f64], weights: &[f64], term: &[f64]) {
    let width = term.len() / weights.len();
    let rows = into.chunks_exact_mut(width).zip(term.chunks_exact(width));
    for ((into, term), weight) in rows.zip(weights) {
        into.iter_mut().zip(term).for_each(|(into, term)| *into -= weight * term);
    }
}

/// Adds to an error of [`rollout`] the training step and the loss of the one before.
pub(crate) fn in_step(step: usize, loss: Option<f64>) -> impl Fn((usize, ProposalError)) -> TrainError {
    move |(time, source)| TrainError::Proposal { step, loss, time, source }
}
