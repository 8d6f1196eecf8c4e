//! What training asks of a proposal: draw with a tape running, then pull derivatives back along it.

use motes_models::Stream;
use motes_networks::{Inputs, Workspace};
use motes_smc::ProposalError;

use crate::family::Parametric;

/// A proposal whose weights can be learned by reparametrised samples.
///
/// A draw is a deterministic function of weights, past and noise, `x_t = x(θ, x_{t−1}, y_t; ε)`, and so is `log q` of it.
/// Training needs the derivative of any scalar of states and log densities with respect to `θ`; a [`Tape`] gives it
/// in reverse mode. The scalar itself, and all derivatives of model densities, stay outside: no states ever enter here but
/// those that the proposal drew.
pub trait Learnable: Parametric {
    /// Fills `noise` (`K×N`) with what a draw of `K` particles is reparametrised by.
    fn fill_noise(&self, stream: &mut Stream, noise: &mut [f64]);

    /// Starts recording `particles` particles at `t = 0`, with the memory of a recording that is over.
    ///
    /// # Errors
    /// [`ProposalError::Backend`] if what computes the networks cannot be had.
    fn tape(&self, particles: usize, workspace: Workspace) -> Result<Box<dyn Tape + '_>, ProposalError>;
}

/// A recording of one batch of particles from `t = 0` on.
pub trait Tape {
    /// Draws `x_t` of each of `K` particles from `noise` (`K×N`) into `states` (`K×N`), with `log q` in `log_density` (`K`) if that
    /// is of interest: it takes determinants.
    ///
    /// # Errors
    /// [`ProposalError`] as in [`motes_smc::Proposal`]; what only a density can fail at, as a singular matrix, if it is asked for.
    fn draw(
        &mut self,
        inputs: &Inputs<'_>,
        noise: &[f64],
        states: &mut [f64],
        log_density: Option<&mut [f64]>,
    ) -> Result<(), ProposalError>;

    /// Undoes the last draw that is not yet undone: takes the derivatives of the scalar with respect to its `states`
    /// (`K×N`) and `log_density` (`K`; none if they are all zero), adds to the gradients of the weights, and writes the derivative with respect to
    /// `x_{t−1}` into `d_previous` (`K×N`; zeros at `t = 0`).
    ///
    /// # Errors
    /// [`ProposalError::Backend`] if the backend failed.
    ///
    /// # Panics
    /// If no draw is left; perhaps if there is a derivative with respect to a log density that the draw was not asked for, or of the wrong
    /// length.
    fn pull_back(
        &mut self,
        d_states: &[f64],
        d_log_density: Option<&[f64]>,
        d_previous: &mut [f64],
    ) -> Result<(), ProposalError>;

    /// Forgets what the draws undone so far would carry into earlier ones through the particles' memory: with a zero
    /// derivative of the states, nothing then flows back past this point.
    fn detach(&mut self);

    /// Ends the recording; the workspace then holds the gradients.
    fn finish(self: Box<Self>) -> Workspace;
}
