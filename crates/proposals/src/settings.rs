//! Settings and sizes that families are made from: what is refused, and how many weights they lead to.

use motes_models::ModelShape;
use motes_networks::{Compute, Graph, NetworkError};
use motes_smc::ProposalError;

/// An error of the networks as one of the proposal.
pub(crate) fn of_networks(error: NetworkError) -> ProposalError {
    match error {
        NetworkError::Weights { found, expected } => {
            ProposalError::Mismatch { what: "the number of weights", found, expected }
        }
        // What was handed over has the sizes of the model; the networks are the proposal's.
        NetworkError::Shape { what, found, expected } => {
            ProposalError::Mismatch { what, found: expected, expected: found }
        }
        NetworkError::PastHorizon { horizon, time } => ProposalError::PastHorizon { horizon, time },
        NetworkError::Empty { what } => {
            ProposalError::Setting { name: what, value: "0".into(), expected: "at least 1" }
        }
        NetworkError::Precision { found, .. } => ProposalError::Setting {
            name: "the precision of hidden values",
            value: format!("{found:?}"),
            expected: "that of the weights",
        },
        NetworkError::Workspace => ProposalError::Setting {
            name: "the workspace of a recording",
            value: "of other weights".into(),
            expected: "one for the weights of the proposal",
        },
        NetworkError::NotBuilt { .. } | NetworkError::Backend { .. } => {
            ProposalError::Backend { reason: error.to_string() }
        }
    }
}

/// Refuses a backend that was not compiled.
pub(crate) fn check_compute(compute: Compute) -> Result<(), ProposalError> {
    compute.backend.check().map_err(of_networks)
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

/// Refuses a model without states or measurements.
pub(crate) fn check_shape(shape: &ModelShape) -> Result<(), ProposalError> {
    check_count("the model's state dimension N", shape.state_dim)?;
    check_count("the model's measurement dimension M", shape.measurement_dim)
}

/// The graph of a model, of its sizes.
///
/// # Errors
/// [`ProposalError::NoGraph`] if the model has none, [`ProposalError::Mismatch`] for a graph of other sizes.
pub(crate) fn graph_of(shape: &ModelShape) -> Result<Graph, ProposalError> {
    let &ModelShape { state_dim: n, measurement_dim: m, .. } = shape;
    let graph = shape.graph.as_ref().ok_or(ProposalError::NoGraph)?;
    for (what, found, expected) in [
        ("the rows of the graph's matrix", graph.shift.nrows(), n),
        ("the columns of the graph's matrix", graph.shift.ncols(), n),
        ("the rows of the graph's adapter", graph.adapter.nrows(), n),
        ("the columns of the graph's adapter", graph.adapter.ncols(), m),
    ] {
        ProposalError::unless_same(what, found, expected)?;
    }
    Ok(Graph::new(graph.shift.clone(), graph.adapter.clone()))
}
