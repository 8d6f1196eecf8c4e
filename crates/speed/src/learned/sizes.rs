//! The sizes of the work.

/// Times of a filter.
pub(crate) const HORIZON: usize = 100;

/// Rows of a gradient step, as `motes learn` takes them.
pub(crate) const ROWS: usize = 800;
