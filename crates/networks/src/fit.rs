//! Whether what a caller hands over fits the networks: asked before anything of it is read or written.

use crate::error::NetworkError;
use crate::networks::{Inputs, Networks};
use crate::precision::Precision;
use crate::values::SliceMut;

/// How errors call the number of some matrices, and the length of one of them.
pub(crate) type Named = [&'static str; 2];

/// Outputs.
pub(crate) const OUTPUTS: Named = ["the number of outputs", "the length of an output"];

/// What particles carry.
pub(crate) const HIDDEN: Named =
    ["the number of matrices of hidden values", "the length of a matrix of hidden values"];

/// Derivatives with respect to outputs.
pub(crate) const D_OUTPUTS: Named =
    ["the number of derivatives of outputs", "the length of the derivative of an output"];

/// Refuses a size that is not the expected one.
pub(crate) fn unless_same(what: &'static str, found: usize, expected: usize) -> Result<(), NetworkError> {
    if found == expected { Ok(()) } else { Err(NetworkError::Shape { what, found, expected }) }
}

/// Refuses matrices of which there are not as many as expected, or of which one has not the expected length.
pub(crate) fn unless_alike(
    [number, length]: Named,
    found: impl ExactSizeIterator<Item = usize>,
    expected: impl ExactSizeIterator<Item = usize>,
) -> Result<(), NetworkError> {
    unless_same(number, found.len(), expected.len())?;
    found.zip(expected).try_for_each(|(found, expected)| unless_same(length, found, expected))
}

/// Refuses inputs that the networks cannot be asked about.
pub(crate) fn check_inputs(networks: &impl Networks, inputs: &Inputs<'_>) -> Result<(), NetworkError> {
    let Inputs { time, width, previous, particles, .. } = *inputs;
    match networks.horizon() {
        Some(horizon) if time >= horizon => return Err(NetworkError::PastHorizon { horizon, time }),
        _ => {}
    }
    if width == 0 {
        return Err(NetworkError::Empty { what: "the width of a state" });
    }
    match previous {
        Some(previous) => {
            unless_same("the length of x_{t−1}", previous.len(), particles.saturating_mul(width))
        }
        None => Ok(()),
    }
}

/// Refuses hidden values that are not those of so many particles, or not in the precision of the weights.
pub(crate) fn check_hidden(
    networks: &impl Networks,
    precision: Precision,
    particles: usize,
    hidden: &[SliceMut<'_>],
) -> Result<(), NetworkError> {
    let widths = networks.hidden_widths();
    let expected = widths.iter().map(|width| particles.saturating_mul(*width));
    unless_alike(HIDDEN, hidden.iter().map(SliceMut::len), expected)?;
    match hidden.iter().map(SliceMut::precision).find(|found| *found != precision) {
        Some(found) => Err(NetworkError::Precision { found, expected: precision }),
        None => Ok(()),
    }
}
