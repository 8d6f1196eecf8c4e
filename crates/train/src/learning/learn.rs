//! Learning once: what all objectives begin with.

use std::ops::ControlFlow;
use std::time::Instant;

use motes_models::{ModelError, OwnModel, PartialMeasurements, Seed, StateGradients};
use motes_proposals::Amortised;

use super::course::Learned;
use super::held_out::HeldOut;
use super::objective::LearnObjective;
use super::rows::whole;
use super::settings::LearnConfig;
use super::{fivo, inclusive, wake};
use crate::dropout::Dropout;
use crate::{Adam, TrainError};

/// Sequences that inputs are standardised by, and their times.
const STANDARDISING: usize = 64;

/// Learns `proposal` for `model`, by one of three objectives.
///
/// **Inclusive**, from steps that the model draws for itself, fresh ones in each gradient step.
/// It maximises `E log[(1 − α) q(x_t | x_{t−1}, y_t) + α p(x_t | x_{t−1})]`, which is the inclusive Kullback–Leibler divergence from
/// `p(x_t | x_{t−1}, y_t)` but for its sign and a constant. Validation sequences come from a seed of their own, and their gain is the figure.
/// `recorded` measurements, any number of series of any lengths, add where a filter with the present weights says that the states were.
///
/// **Wake**, the same objective over what a filter on `recorded` series with the present (averaged) weights finds likely, `x_{t−1}` and `x_t` of particles that are
/// drawn by their weights (Gu, Ghahramani and Turner 2015). Nothing is simulated but what inputs are standardised by.
///
/// **Fivo**, the filter's own log-evidence `Σ_t log Σ_k W_{t−1}^k w_t^k` on `recorded` series (Maddison et al. 2017, Le et al. 2018, Naesseth et al. 2018). With
/// `W̃_t^k` the normalised weights after time `t`, and `u` the reparametrised draw in units of the base, a time adds
/// `Σ_k (W̃_t^k)² ∂/∂u[log p(x_t | x_{t−1}) + log p(y_t | x_t) − log q(x_t | x_{t−1}, y_t)] · ∂u/∂θ`:
/// derivatives along the path alone, where the square stands for the score of `log q` (Tucker et al. 2019). With the weight itself in the place of its square
/// (Roeder et al. 2017) several particles would make it biased.
/// - The window is one time: `W_{t−1}` and `x_{t−1}` are taken as given. What a draw does to later times is left out, and so is the derivative of drawing
///   ancestors, whose variance is large. Given the past, the gradient of a time's term is unbiased; that of the whole sum is not.
/// - The filter has no defensive share: a particle that the transition drew has no gradient, and the bound would be that of another filter.
/// - It takes a head whose draws have derivatives: a Gaussian, a kernel or a flow.
/// - A step of learning takes as many times of a running filter as have `rows` particles; the filter goes on with the new weights.
///
/// For the last two, one series in four is held out, or the last quarter of the times of the only one. The log-evidence of filters on those is the figure.
///
/// The weights with the best figure are kept; the weights that came in are among the candidates. A step whose loss or gradient is not finite ends learning,
/// and the best weights so far are kept. Nobody's states are seen: only measurements come in.
///
/// Where a look at validation finds most rows at the floor, which has no slope, learning goes back to the best weights so far, with steps a quarter as long.
///
/// `observe` is shown the step and the last figure of validation, and ends learning early by breaking.
///
/// The same seed gives the same weights, unless there is a budget in seconds.
///
/// # Errors
/// - [`TrainError::Setting`], [`TrainError::NoHiddenUnits`] or [`TrainError::Model`] for bad input, and for a model all of whose sequences overflow.
/// - [`TrainError::NoRecorded`] if the objective learns from recorded series and there are none, [`TrainError::Recorded`] for series that cannot be learned from.
/// - [`TrainError::Draws`] if the objective is fivo and draws of the head have no derivatives.
/// - [`TrainError::Networks`] if the proposal fails.
pub fn learn<M: OwnModel + StateGradients + ?Sized>(
    proposal: &mut Amortised,
    model: &M,
    recorded: &[PartialMeasurements],
    config: &LearnConfig,
    seed: &Seed,
    observe: impl FnMut(usize, f64) -> ControlFlow<()>,
) -> Result<Learned, TrainError> {
    config.check()?;
    check_recorded(model, recorded)?;
    // Refused before anything is computed.
    Adam::new(&config.adam)?;
    Dropout::new(config.dropout, proposal)?;
    if config.objective.needs_recorded() && recorded.is_empty() {
        return Err(TrainError::NoRecorded { objective: config.objective.to_string() });
    }
    if config.objective == LearnObjective::Fivo && !proposal.has_differentiable_draws() {
        return Err(TrainError::Draws);
    }
    let started = Instant::now();
    if !config.continues {
        standardise(proposal, model, config, &seed.child("inputs"))?;
    }
    match config.objective {
        LearnObjective::Inclusive => {
            inclusive::learn(proposal, model, recorded, config, seed, started, observe)
        }
        LearnObjective::Wake => {
            wake::learn(proposal, model, &HeldOut::of(recorded)?, config, seed, started, observe)
        }
        LearnObjective::Fivo => {
            fivo::learn(proposal, model, &HeldOut::of(recorded)?, config, seed, started, observe)
        }
    }
}

/// Refuses series that no step can be learned from: what takes long asks before it begins.
///
/// # Errors
/// - [`TrainError::Model`] if there are any, and the states of the model have no density: what a filter draws does not tell which noise it was made of.
/// - [`TrainError::Recorded`] for one that is too short, has another number of columns or no measurement.
pub fn check_recorded(
    model: &(impl OwnModel + ?Sized),
    recorded: &[PartialMeasurements],
) -> Result<(), TrainError> {
    if model.noise_without_density().is_some() && !recorded.is_empty() {
        return Err(TrainError::Model(ModelError::Parameter {
            name: "what is learned from",
            value: "recorded data".into(),
            expected: "simulations alone, for a model whose states have no density",
        }));
    }
    let width = model.measurement_dim();
    for (number, series) in recorded.iter().enumerate() {
        if series.width() != width {
            let reason = format!("series {number} has {} columns instead of {width}", series.width());
            return Err(TrainError::Recorded { reason });
        }
        if series.len() < 2 {
            let reason = format!("series {number} has {} times; a step takes two", series.len());
            return Err(TrainError::Recorded { reason });
        }
        if series.rows().all(|row| row.iter().all(Option::is_none)) {
            let reason = format!("all measurements of series {number} are missing");
            return Err(TrainError::Recorded { reason });
        }
    }
    Ok(())
}

/// Brings the inputs of the networks to units in which the model's own steps are of size 1.
fn standardise(
    proposal: &mut Amortised,
    model: &(impl OwnModel + ?Sized),
    config: &LearnConfig,
    seed: &Seed,
) -> Result<(), TrainError> {
    let mut windows = whole(model, STANDARDISING, config, seed)?;
    proposal.fit_inputs(model, |add| {
        for steps in &mut windows {
            for _ in 0..config.horizon {
                match steps.advance() {
                    Some(step) => add(&step)?,
                    None => break,
                }
            }
        }
        Ok(())
    })?;
    Ok(())
}
