//! What the forward algorithm asks of a model.

use super::error::ForwardError;
use crate::{StateSpaceModel, Step};

/// How much is looked at, for exact answers to take no longer than they are worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// States at one time.
    pub states: usize,
    /// Ways from the states of one time to those of the next.
    pub ways: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Limits { states: 4096, ways: 1 << 20 }
    }
}

/// A model of whose draws each has few values.
pub trait FiniteSystem: StateSpaceModel {
    /// Gives `take` each state (`N`) that a sub-step leads to from `previous` (`N`), or each `x_0` where there is none, with its probability. A state that several draws
    /// lead to is given several times. Each way is one less of `ways`.
    ///
    /// # Errors
    /// [`ForwardError::TooManyWays`] where none is left, [`ForwardError::NotDiscrete`].
    fn branches(
        &self,
        part: &Step<'_>,
        previous: Option<&[f64]>,
        ways: &mut usize,
        take: &mut dyn FnMut(&[f64], f64),
    ) -> Result<(), ForwardError>;
}
