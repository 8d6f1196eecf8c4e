//! Filters with a proposal that is learned once.

use motes_models::batch::Rows;
use motes_models::equations::Equations;
use motes_models::{Measurements, ModelShape, StateSpaceModel, Step};
use motes_proposals::{Amortised, AmortisedScratch, Backend, load};
use motes_smc::{Conditional, Context, FilterBank, FilterSettings, Proposal, ResampleWhen, Resampling};

use super::folder::{measurements, pairs};
use crate::folder::seed;
use crate::task::{Answer, LearnedTask};
use crate::work::{Work, of_evidences};

/// The share of the transition that the command mixes in.
const DEFENSIVE: f64 = 0.1;

pub(super) struct Filtering<M> {
    model: M,
    measurements: Measurements,
    proposal: Amortised,
    particles: usize,
    passes: usize,
    runs: u64,
}

impl<M: Equations> Filtering<M> {
    pub(super) fn of(model: M, task: &LearnedTask) -> Result<Self, String> {
        let told = |error: motes_proposals::SavedError| error.to_string();
        let proposal = load(&task.folder, &model, &ModelShape::of(&model), Backend::Native.into());
        Ok(Filtering {
            measurements: measurements(&model).map_err(|error| error.to_string())?,
            proposal: proposal.map_err(told)?,
            model,
            particles: task.particles,
            passes: task.check_passes,
            runs: 0,
        })
    }

    /// Minus the mean log-density, at fixed pairs of states, of what filters draw from.
    ///
    /// Evidence would not tell two proposals apart: any that weighs what it draws estimates it.
    fn loss(&mut self) -> Result<f64, String> {
        let told = |error: &dyn std::fmt::Display| error.to_string();
        let [previous, states] = pairs(&self.model).map_err(|error| told(&error))?;
        let (n, y) = (self.model.state_dim(), self.measurements.row(1));
        let count = states.len() / n;
        let (mut of_proposal, mut of_transition) = (vec![0.0; count], vec![0.0; count]);
        let context = Context::new(Step::of_index(1), Some(&previous), count);
        let scratch = &mut AmortisedScratch::default();
        self.proposal
            .condition_batch(&self.model, context, y, &mut (), scratch)
            .map_err(|error| told(&error))?
            .log_density(&states, &mut of_proposal);
        let rows = Some(Rows::all(&previous, n));
        let density = self.model.density().ok_or("the model has no transition density")?;
        density.log_densities(&Step::of_index(1), rows, &states, &mut of_transition);
        let log_mixture = |(q, p): (&f64, &f64)| {
            let (a, b) = (q + (-DEFENSIVE).ln_1p(), p + DEFENSIVE.ln());
            a.max(b) + (-(a - b).abs()).exp().ln_1p()
        };
        Ok(-of_proposal.iter().zip(&of_transition).map(log_mixture).sum::<f64>() / count as f64)
    }

    fn evidence(&mut self) -> Result<f64, String> {
        let settings = FilterSettings {
            resampling: Resampling::Systematic,
            resample_when: ResampleWhen::EssBelow(0.5),
            defensive_weight: Some(DEFENSIVE),
            ..FilterSettings::new(self.particles)
        };
        self.runs += 1;
        let seed = seed().child("learned filter").nth(self.runs);
        let mut bank = FilterBank::new(&self.model, self.proposal.clone(), settings, 1, &seed)
            .map_err(|error| error.to_string())?;
        bank.run(&self.measurements, |_| ()).map_err(|error| error.to_string())?;
        Ok(bank.log_evidence(0))
    }
}

impl<M: Equations> Work for Filtering<M> {
    fn check(&mut self) -> Result<Answer, String> {
        let found: Result<Vec<f64>, String> = (0..self.passes).map(|_| self.evidence()).collect();
        Ok(Answer { loss: Some(self.loss()?), ..of_evidences(&found?) })
    }

    fn run(&mut self) -> Result<(), String> {
        self.evidence().map(|_| ())
    }
}
