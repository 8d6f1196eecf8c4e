//! What is learned where nothing is said: a few candidates by the model's kind, and a short look at each of them.

use std::fmt::Write;

use motes_models::{ModelShape, Seed};
use motes_proposals::{Amortised, AmortisedConfig, Backend, Base, Covariance, Family, HeadConfig, Sees};
use motes_smc::Linearised;
use motes_train::{LearnConfig, LearnObjective, learn};

use super::options::LearnOptions;
use crate::error::MotesError;
use crate::learned::shape_of;
use crate::own_model::LearnableModel;

/// With more coordinates particles share the correlations of one Gaussian, and components of a mixture have none beside those of the base: a network that
/// emits so many numbers for each particle is not learned in seconds.
const MOST_COORDINATES_IN_FULL: usize = 12;

/// The share of the updates that each candidate is tried with.
const PILOT: f64 = 0.1;

/// What there is to choose from.
fn candidates(
    model: &dyn LearnableModel,
    options: &LearnOptions,
) -> Result<Vec<AmortisedConfig>, MotesError> {
    let shape = ModelShape::of(model);
    let n = shape.draws.map_or(shape.state_dim, |[initial, later]| initial.max(later));
    let bases = match options.base {
        Some(base) => vec![base],
        None if Linearised::new(model)?.sees_measurements() => vec![Base::Linearised, Base::Transition],
        None => vec![Base::Transition],
    };
    let [covariance, of_components] = match n <= MOST_COORDINATES_IN_FULL {
        true => [Covariance::Full; 2],
        false => [Covariance::Shared, Covariance::Diagonal],
    };
    let heads = match options.head {
        Some(head) => vec![head],
        // A mixture's draws have no derivatives.
        None if options.objective == LearnObjective::Fivo => {
            vec![HeadConfig::Gaussian { covariance }, HeadConfig::Flow { pieces: 8, covariance }]
        }
        None if n <= 2 => vec![HeadConfig::Mixture { components: 5, covariance }],
        None => vec![
            HeadConfig::Gaussian { covariance },
            HeadConfig::Mixture { components: 3, covariance: of_components },
        ],
    };
    let sees = options.sees;
    let widths = options.widths.clone().unwrap_or_else(|| match sees {
        Sees::All => vec![64, 64],
        // Each node has as many.
        Sees::Graph { .. } => vec![16, 16],
    });
    let sub_steps = model.step_of_index(1).sub_steps.max(1);
    let with = |(base, head)| AmortisedConfig { widths: widths.clone(), sees, base, head, sub_steps };
    Ok(bases.into_iter().flat_map(|base| heads.iter().map(move |head| (base, *head))).map(with).collect())
}

/// What was chosen, and why.
pub(super) struct Choice {
    pub(super) config: AmortisedConfig,
    /// In a sentence.
    pub(super) reason: String,
}

/// Chooses by the gain on validation sequences after a short training of each candidate.
pub(super) fn choose(
    model: &dyn LearnableModel,
    options: &LearnOptions,
    settings: &LearnConfig,
    seed: &Seed,
    mut proceed: impl FnMut(usize, usize) -> std::ops::ControlFlow<()>,
) -> Result<Choice, MotesError> {
    let mut candidates = candidates(model, options)?;
    if candidates.len() == 1 {
        let config = candidates.remove(0);
        let reason = format!("{}, the only one to choose from", name(&config));
        return Ok(Choice { config, reason });
    }
    let steps = ((settings.steps as f64 * PILOT) as usize).max(1);
    let seconds = settings.seconds.map(|seconds| seconds * PILOT);
    // By what the model draws for itself, whatever follows: data may be few.
    let objective = LearnObjective::Inclusive;
    let pilot = LearnConfig { objective, steps, validate_every: steps, patience: None, seconds, ..*settings };
    let count = candidates.len();
    let mut gains = Vec::new();
    for (number, config) in candidates.iter().enumerate() {
        let shape = shape_of(model);
        let mut proposal =
            Amortised::create(config, &shape, 0, Backend::Native.into(), &seed.child("weights"))?;
        let found = learn(&mut proposal, model, &[], &pilot, &seed.child("pilot"), |step, _| {
            proceed(number * steps + step, count * steps)
        })?;
        gains.push(found.best_gain());
    }
    if proceed(count * steps, count * steps).is_break() {
        return Err(MotesError::Interrupted);
    }
    // The first of equals: what is simpler stands before what is not.
    let best =
        (0..count).fold(0, |best, at| if gains[at] > gains[best] + LEAST_DIFFERENCE { at } else { best });
    let mut reason =
        format!("{}, by the gain over the transition after {steps} updates:", name(&candidates[best]));
    for (at, (config, gain)) in candidates.iter().zip(&gains).enumerate() {
        let comma = if at > 0 { "," } else { "" };
        let _ = write!(reason, "{comma} {} {gain:.3}", name(config));
    }
    Ok(Choice { config: candidates.swap_remove(best), reason: reason + " nats a step" })
}

/// A gain that is larger by less is no reason for what is less simple.
const LEAST_DIFFERENCE: f64 = 1e-3;

/// What a configuration is called.
fn name(config: &AmortisedConfig) -> String {
    let base = match config.base {
        Base::Transition => "the transition",
        Base::Linearised => "linearised",
    };
    let head = match config.head {
        HeadConfig::Gaussian { .. } => "one Gaussian".to_string(),
        HeadConfig::Kernel => "a kernel".to_string(),
        HeadConfig::Mixture { components, .. } => format!("a mixture of {components}"),
        HeadConfig::Flow { pieces, .. } => format!("a flow of {pieces} pieces"),
    };
    let along = match config.sees {
        Sees::All => String::new(),
        Sees::Graph { order } => format!(", by graph filters of order {order}"),
    };
    format!("{head} around {base}{along}")
}
