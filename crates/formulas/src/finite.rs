//! Formulas whose draws have few values: the states that they lead to, one by one.

use motes_models::Step;
use motes_models::equations::branches;
use motes_models::forward::{FiniteSystem, ForwardError};

use crate::model::FormulaModel;

impl FormulaModel {
    /// The model as one of discrete states, if it is: all draws are bernoulli, binomial, categorical or made of these, and all else follows. How many states there are is
    /// found as they are reached.
    pub fn finite_system(&self) -> Option<&dyn FiniteSystem> {
        if self.is_finite() { Some(self) } else { None }
    }
}

impl FiniteSystem for FormulaModel {
    fn branches(
        &self,
        part: &Step<'_>,
        previous: Option<&[f64]>,
        ways: &mut usize,
        take: &mut dyn FnMut(&[f64], f64),
    ) -> Result<(), ForwardError> {
        branches(&self.equations(), part, previous, ways, take)
    }
}
