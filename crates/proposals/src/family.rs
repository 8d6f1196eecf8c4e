//! What all learned families have in common beside being trained: a name, settings, and a way to make one from them.

use motes_models::{Seed, StateSpaceModel};
use motes_smc::ProposalError;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::gaussian::Sizes;
use crate::{Compute, Learnable};

/// A family of learned proposals, made from settings alone: what an experiment or a saved file names.
pub trait Family: Learnable + Sized {
    /// Its name in configurations and saved files.
    const NAME: &'static str;

    /// Its settings.
    type Config: Serialize + DeserializeOwned + Clone;

    /// Draws initial weights for `model`. A family that is not unrolled over time has no use for `horizon`.
    ///
    /// # Errors
    /// [`ProposalError::Setting`] or [`ProposalError::NoGraph`] for settings or a model that it cannot be made for.
    fn create(
        config: &Self::Config,
        model: &dyn StateSpaceModel,
        horizon: usize,
        compute: Compute,
        seed: &Seed,
    ) -> Result<Self, ProposalError>;

    /// How many numbers its weights are, for states and measurements of the given sizes `(N, M)`; `None` if they cannot be
    /// counted. Nothing is allocated.
    fn count(config: &Self::Config, sizes: (usize, usize), horizon: usize) -> Option<usize>;

    /// The settings it was made from.
    fn config(&self) -> &Self::Config;
}

/// The weights and biases of a cascade of affine maps between the given widths, where each input counts `taps` times.
pub(crate) fn count_affine(widths: &[usize], taps: usize) -> Option<usize> {
    widths.windows(2).try_fold(0_usize, |sum, pair| {
        sum.checked_add(pair[0].checked_mul(taps)?.checked_add(1)?.checked_mul(pair[1])?)
    })
}

fn setting<T>(name: &'static str, value: String, expected: &'static str) -> Result<T, ProposalError> {
    Err(ProposalError::Setting { name, value, expected })
}

pub(crate) fn check_horizon(horizon: usize) -> Result<(), ProposalError> {
    match horizon {
        0 => setting("the horizon T of an unrolled proposal", "0".into(), "at least 1"),
        _ => Ok(()),
    }
}

pub(crate) fn check_widths(name: &'static str, widths: &[usize]) -> Result<(), ProposalError> {
    if widths.is_empty() || widths.contains(&0) {
        return setting(name, format!("{widths:?}"), "one or more, each at least 1");
    }
    Ok(())
}

pub(crate) fn check_count(name: &'static str, count: usize) -> Result<(), ProposalError> {
    match count {
        0 => setting(name, "0".into(), "at least 1"),
        _ => Ok(()),
    }
}

/// Refuses sizes before anything is allocated by them.
pub(crate) fn check_weights(count: Option<usize>) -> Result<(), ProposalError> {
    match count {
        Some(count) if count <= MOST_WEIGHTS => Ok(()),
        Some(count) => setting("the number of weights", count.to_string(), "at most 2³²"),
        None => setting("the number of weights", "beyond counting".into(), "at most 2³²"),
    }
}

const MOST_WEIGHTS: usize = 1 << 32;

pub(crate) fn check_ridge(name: &'static str, ridge: f64) -> Result<(), ProposalError> {
    if !(ridge >= 0.0 && ridge.is_finite()) {
        return setting(name, ridge.to_string(), "at least 0 and finite");
    }
    Ok(())
}

/// `N` and `M` of a model.
pub(crate) fn sizes_of(model: &(impl StateSpaceModel + ?Sized)) -> Result<Sizes, ProposalError> {
    let sizes = Sizes { state_dim: model.state_dim(), measurement_dim: model.measurement_dim() };
    check_count("the model's state dimension N", sizes.state_dim)?;
    check_count("the model's measurement dimension M", sizes.measurement_dim)?;
    Ok(sizes)
}
