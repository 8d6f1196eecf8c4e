//! Bugs that are planted, so that a test that no longer sees them is noticed.

use motes_models::equations::{Equations, Linearise};
use motes_models::{Step, Stream};
use motes_smc::{Conditional, Context, LookAhead, LookAheadBatch, LookAheadScratch, Proposal, ProposalError};

/// What is done wrong.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bug {
    /// `Z̃_{t+1}(x_t)` is left out.
    WithoutNext,
    /// `Z̃_{t+2}(x_t)` stands in its place, as where potentials are shifted by a time step.
    Shifted,
    /// `ψ_t(x_t)` stands in the place of `ψ̃_t(v_t; x_{t−1})`.
    AtState,
}

/// A look-ahead proposal with a bug.
#[derive(Clone)]
pub struct Wrong {
    pub ahead: LookAhead,
    pub bug: Bug,
}

/// What it conditions.
pub struct WrongBatch<'a, M: ?Sized> {
    right: LookAheadBatch<'a, M>,
    proposal: &'a Wrong,
    model: &'a M,
    index: usize,
}

impl<M: Equations + Linearise> Proposal<M> for Wrong {
    type Memory = ();
    type Scratch = LookAheadScratch;
    type Conditional<'a>
        = WrongBatch<'a, M>
    where
        M: 'a;

    fn initial_memory(&self, _: usize) {}

    fn looks_ahead(&self) -> bool {
        true
    }

    fn prepare(
        &mut self,
        model: &M,
        step: &Step<'_>,
        measurement: &[Option<f64>],
    ) -> Result<bool, ProposalError> {
        self.ahead.prepare(model, step, measurement)
    }

    fn condition<'a>(
        &'a self,
        model: &'a M,
        context: Context<'a>,
        (): (),
        scratch: &'a mut LookAheadScratch,
    ) -> Result<WrongBatch<'a, M>, ProposalError> {
        let index = context.step.index;
        Ok(WrongBatch {
            right: self.ahead.condition(model, context, (), scratch)?,
            proposal: self,
            model,
            index,
        })
    }
}

impl<M: Equations + Linearise> Conditional for WrongBatch<'_, M> {
    fn sample(&mut self, streams: &mut [Stream], states: &mut [f64], log_density: &mut [f64]) {
        self.right.sample(streams, states, log_density);
    }

    fn log_density(&mut self, states: &[f64], log_density: &mut [f64]) {
        self.right.log_density(states, log_density);
    }

    fn sample_by_noise(
        &mut self,
        share: Option<f64>,
        streams: &mut [Stream],
        states: &mut [f64],
        log_ratios: &mut [f64],
    ) -> bool {
        self.right.sample_by_noise(share, streams, states, log_ratios);
        let (Wrong { ahead, bug }, index, n) = (self.proposal, self.index, self.model.dimensions()[0]);
        let expected = |index: usize| {
            let mut found = vec![0.0; states.len() / n];
            ahead.log_expectations(self.model, index, states, &mut found);
            found
        };
        let next = expected(index + 1);
        let later = expected(index + 2);
        for (at, ratio) in log_ratios.iter_mut().enumerate() {
            match bug {
                Bug::WithoutNext => *ratio -= next[at],
                Bug::Shifted => *ratio += later[at] - next[at],
                // The first one has an expectation of its own, which this is not about.
                Bug::AtState if index == 0 => {}
                Bug::AtState => {
                    *ratio = next[at] - ahead.log_potential(index, &states[at * n..][..n]).unwrap();
                }
            }
        }
        true
    }
}
