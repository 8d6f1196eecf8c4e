//! Filters whose particles have the free parameters of their own.

use std::ops::ControlFlow;

use motes_inference::{PerturbedLikelihood, RandomWalk};
use motes_models::Seed;
use motes_smc::PerturbedFilter;

use super::likelihood::ModelLikelihood;
use super::perturbed_model::PerturbedModel;
use super::walk::{Walk, are_uniform, of_uniform};
use crate::error::MotesError;
use crate::evidence::STEPS_AT_ONCE;
use crate::options::ProposalName;

impl ModelLikelihood<'_> {
    /// The model with free parameters of particles.
    ///
    /// # Errors
    /// Why there is none: bootstrap is no estimator of the likelihood, or as [`Model::with_parameters_of_particles`](crate::Model::with_parameters_of_particles).
    pub(super) fn perturbed_model(&self) -> Result<PerturbedModel, String> {
        let estimator = self.proposals.iter().position(|proposal| *proposal == ProposalName::Bootstrap);
        let estimator =
            estimator.ok_or_else(|| format!("the likelihood is estimated by {}", self.proposals[0]))?;
        Ok(PerturbedModel { model: self.model.with_parameters_of_particles(&self.names)?, estimator })
    }
}

impl PerturbedLikelihood for ModelLikelihood<'_> {
    type Error = MotesError;

    fn estimator(&self) -> usize {
        self.perturbed.as_ref().map_or(0, |perturbed| perturbed.estimator)
    }

    /// One series after another: a swarm goes through all of them.
    fn pass(&self, positions: &mut [f64], walk: RandomWalk<'_>, seed: &Seed) -> Result<(), MotesError> {
        let Some(PerturbedModel { model, .. }) = &self.perturbed else { return Ok(()) };
        let rows: usize = self.sequences.iter().map(|sequence| sequence.steps().len()).sum();
        let mut before = 0;
        let mut walking = Walk::new(self.free, positions.len(), seed.child("walk").stream());
        for (number, sequence) in self.sequences.iter().enumerate() {
            let filter = PerturbedFilter {
                model,
                steps: sequence.steps(),
                dimension: self.names.len(),
                parameters: &|positions, values| self.free.write(positions, values),
            };
            let spread = |row: usize| {
                let cooled = walk.spread * walk.cooling.powf((before + row) as f64 / rows as f64);
                move |coordinate: usize| match (model.only_initial()[coordinate], row) {
                    _ if walk.fixed == Some(coordinate) => 0.0,
                    (false, _) => cooled / (rows as f64).sqrt(),
                    (true, 0) => cooled / (self.sequences.len() as f64).sqrt(),
                    (true, _) => 0.0,
                }
            };
            let mut perturb = |row: usize, positions: &mut [f64]| {
                if row.is_multiple_of(STEPS_AT_ONCE) && (self.proceed)().is_break() {
                    return ControlFlow::Break(());
                }
                walking.step(positions, walk.directions, spread(row));
                ControlFlow::Continue(())
            };
            match filter.pass(positions, &mut perturb, &seed.nth(number as u64)) {
                Ok(Some(_)) => {}
                Ok(None) => return Err(MotesError::Interrupted),
                Err(error) => return Err(MotesError::Setting(error.to_string())),
            }
            before += sequence.steps().len();
        }
        Ok(())
    }

    fn steps(&self, v: &[f64]) -> Vec<f64> {
        let of = |(v, is_uniform): (&f64, bool)| if is_uniform { of_uniform(*v) } else { 1.0 };
        v.iter().zip(are_uniform(self.free)).map(of).collect()
    }
}
