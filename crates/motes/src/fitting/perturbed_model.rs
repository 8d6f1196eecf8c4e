//! A model in which each particle has the free parameters of its own.

use motes_formulas::FormulaModel;

/// A model in which each particle has the free parameters of its own, and where its filter stands among others.
pub(super) struct PerturbedModel {
    pub(super) model: FormulaModel,
    /// The place of the bootstrap filter among the estimators of the likelihood.
    pub(super) estimator: usize,
}
