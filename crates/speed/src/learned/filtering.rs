//! Filters with a proposal that is learned once.

use motes_models::equations::Equations;
use motes_models::{Measurements, ModelShape};
use motes_proposals::{Amortised, Backend, load};
use motes_smc::{FilterBank, FilterSettings, ResampleWhen, Resampling};

use super::folder::measurements;
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
        Ok(of_evidences(&found?))
    }

    fn run(&mut self) -> Result<(), String> {
        self.evidence().map(|_| ())
    }
}
