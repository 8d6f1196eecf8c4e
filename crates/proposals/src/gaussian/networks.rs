//! What tells the Gaussian families apart: their networks.

use motes_smc::{Past, ProposalError};

use crate::Gradients;
use crate::arithmetic::Arithmetic;
use crate::workspace::Workspace;

/// The networks of one Gaussian family: from what a particle knows to a mean and a representation.
///
/// This is all that tells the families apart; covariance, sampling, densities and derivatives are
/// [`super::GaussianProposal`]'s, and how the networks are computed is the backend's.
pub trait Networks: Clone {
    /// How many times there are networks for; `None` if any number.
    fn horizon(&self) -> Option<usize>;

    /// The widths of what a particle carries from step to step; none for a Markov family.
    fn hidden_widths(&self) -> Vec<usize> {
        Vec::new()
    }

    /// Emits the parameters of `R` particles' distributions at time `t`.
    fn forward<A: Arithmetic>(
        &self,
        arithmetic: &mut A,
        time: usize,
        known: Known<'_, A::Rows>,
    ) -> Emission<A::Rows>;
}

/// What the networks see of `R` particles.
pub struct Known<'a, Rows> {
    /// `x_{t−1}`, `R×N`; zeros at `t = 0`.
    pub previous: Rows,
    /// `y_t`, `1×M`.
    pub measurement: Rows,
    /// What the particles carry, `R×width` each.
    pub hidden: &'a [Rows],
}

/// What the networks say of `R` particles.
pub struct Emission<Rows> {
    /// `μ_t`, `R×N`.
    pub means: Rows,
    /// `z_t`, `R×N`.
    pub representations: Rows,
    /// What the particles carry on, in the order of [`Networks::hidden_widths`].
    pub hidden: Vec<Rows>,
}

/// Networks computed forward along a sequence with derivatives to come, by one backend.
pub(crate) trait NetworkTape {
    /// Computes means and representations (`R×N` each) of particles of `width` coordinates.
    fn forward(
        &mut self,
        past: &Past<'_>,
        width: usize,
        means: &mut [f64],
        representations: &mut [f64],
    ) -> Result<(), ProposalError>;

    /// Undoes the last step that is not yet undone; `d_previous` (`R×N`) means nothing at `t = 0`.
    fn backward(
        &mut self,
        d_means: &[f64],
        d_representations: &[f64],
        d_previous: &mut [f64],
    ) -> Result<(), ProposalError>;

    /// Forgets what would flow into earlier steps through what the particles carry.
    fn cut(&mut self);

    /// The gradients gathered so far, some of which may still wait for [`NetworkTape::finish`].
    fn gradients(&mut self) -> &mut Gradients;

    fn finish(self: Box<Self>) -> Workspace;
}
