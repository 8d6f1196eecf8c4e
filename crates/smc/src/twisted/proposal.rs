//! What a twisted filter draws from.

use motes_models::batch::LANES;
use motes_models::equations::Linearise;
use motes_models::{StateSpaceModel, Step};

use super::model::TwistedModel;
use crate::proposal::{Context, Proposal};
use crate::proposal_error::ProposalError;
use crate::proposals::{LinearisedScratch, PrecisionBatch};

/// `q_t(x_t | x_{t−1}) ∝ N(x_t; m, P) φ_t(x_t)`, with `m` and `P` the mean and the variances of `p(x_t | x_{t−1})`.
pub(super) struct TwistedProposal;

impl<'m, M: Linearise + ?Sized> Proposal<TwistedModel<'m, M>> for TwistedProposal {
    type Memory = ();
    type Scratch = LinearisedScratch;
    type Conditional<'a>
        = PrecisionBatch<'a>
    where
        TwistedModel<'m, M>: 'a;

    fn initial_memory(&self, _particles: usize) {}

    fn prepare(
        &mut self,
        model: &TwistedModel<'m, M>,
        step: &Step<'_>,
        _measurement: &[f64],
    ) -> Result<(), ProposalError> {
        let horizon = model.functions.len();
        let function = model
            .functions
            .get(step.index)
            .ok_or(ProposalError::PastHorizon { horizon, time: step.index })?;
        ProposalError::unless_same("the state dimension N", function.centre.len(), model.state_dim())
    }

    fn condition<'a>(
        &'a self,
        twisted: &'a TwistedModel<'m, M>,
        context: Context<'a>,
        (): (),
        scratch: &'a mut LinearisedScratch,
    ) -> Result<PrecisionBatch<'a>, ProposalError> {
        let (step, n) = (context.step, twisted.model.state_dim());
        let function = &twisted.functions[step.index];
        let (tiles, triangle) = (context.particles.div_ceil(LANES), n * (n + 1) / 2);
        let LinearisedScratch { means, factors, tile, .. } = &mut *scratch;
        means.resize(tiles * n * LANES, 0.0);
        factors.resize(tiles * triangle * LANES, 0.0);
        // Lanes without a particle are computed, too: with numbers that are no danger.
        tile.clear();
        tile.resize(2 * n * LANES, 0.0);
        let (previous, variances) = tile.split_at_mut(n * LANES);
        if let Some(rows) = context.previous {
            twisted.model.foresee(&step, rows);
        }
        let places = means.chunks_exact_mut(n * LANES).zip(factors.chunks_exact_mut(triangle * LANES));
        for (number, (mean, lower)) in places.enumerate() {
            let before = context.previous.map(|rows| {
                rows.load(number * LANES, previous);
                &*previous
            });
            function.times_transition(twisted.model, &step, before, mean, lower, variances);
        }
        Ok(PrecisionBatch { width: n, gaussians: scratch })
    }
}
