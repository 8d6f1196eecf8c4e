//! Proposals held against each other.

use motes::{CompareOptions, Comparison, MotesError, ProposalName, compare};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::call::ForCall;
use crate::card::{Card, Compared};
use crate::work::without_lock;

/// The card of a comparison, on simulated sequences or on `data`.
pub(crate) fn carded(
    call: &ForCall,
    py: Python<'_>,
    data: Option<&motes::Data>,
    options: CompareOptions,
    threads: Option<usize>,
    training_seconds: Option<f64>,
) -> PyResult<Card> {
    let mut names: Vec<&str> = options.proposals.iter().map(ProposalName::as_str).collect();
    names.sort_unstable();
    if let Some(twice) = names.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(PyValueError::new_err(format!("proposals: {}: there are two of that name", twice[0])));
    }
    let (ForCall { model, failure, .. }, threads) = (call, call.threads(threads));
    let compared: Result<Comparison, MotesError> =
        without_lock(py, threads, &failure.stop, || compare(model, data, &options, |_| failure.asked()))?;
    Ok(Card::of(Compared {
        model: model.name().to_string(),
        comparison: failure.or(compared)?,
        options: options.filter,
        training_seconds,
    }))
}
