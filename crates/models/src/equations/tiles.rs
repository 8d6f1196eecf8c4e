//! Numbers of particles lent as the scalars that formulas work on.

use bytemuck::{TransparentWrapper, cast_slice_mut};

use super::lanes::Lanes;
use super::scalar::Scalar;
use crate::batch::{LANES, with_scratch};

/// Lends `count` scalars of any value: memory for what a model computes on the way. It is the thread's own and kept, so that asking again allocates
/// nothing.
pub fn with_scalars<S: Scalar, R>(count: usize, work: impl FnOnce(&mut [S]) -> R) -> R {
    with_scratch(count * (size_of::<S>() / size_of::<f64>()), |numbers| work(cast_slice_mut(numbers)))
}

/// The rows of a tile, each a number of every particle.
///
/// # Panics
/// If they are not whole rows.
pub fn rows_of(tile: &[f64]) -> &[Lanes] {
    let (rows, rest) = tile.as_chunks::<LANES>();
    assert!(rest.is_empty(), "a tile has whole rows");
    Lanes::wrap_slice(rows)
}

/// [`rows_of`] a tile that is to be written.
///
/// # Panics
/// As [`rows_of`].
pub fn rows_of_mut(tile: &mut [f64]) -> &mut [Lanes] {
    let (rows, rest) = tile.as_chunks_mut::<LANES>();
    assert!(rest.is_empty(), "a tile has whole rows");
    Lanes::wrap_slice_mut(rows)
}
