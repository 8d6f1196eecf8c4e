//! What a single filter is between two steps, to be written down and gone on from.

use std::ops::Deref;

use motes_models::StateSpaceModel;
use serde::{Deserialize, Serialize};

use crate::bank::{BankSnapshot, FilterBank, FilterSettings};
use crate::error::FilterError;
use crate::filter::ParticleFilter;
use crate::proposal::Proposal;

/// What a [`ParticleFilter`] is between two steps, but for its model and its proposal, as [`BankSnapshot`] of a bank.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct FilterSnapshot<Memory> {
    bank: BankSnapshot<Memory>,
    mean: Vec<f64>,
}

impl<Memory> FilterSnapshot<Memory> {
    /// The settings of the filter.
    pub fn settings(&self) -> &FilterSettings {
        self.bank.settings()
    }

    /// How many steps had been taken.
    pub fn time(&self) -> usize {
        self.bank.time()
    }
}

impl<D: Deref<Target: StateSpaceModel>, P: Proposal<D::Target, Memory: Clone>> ParticleFilter<D, P> {
    /// What the filter is now, to be written down by serde; a filter that is restored from it goes on as this one does, to the last bit.
    ///
    /// ```
    /// use faer::mat;
    /// use motes_models::{Gaussian, LinearGaussian, Seed};
    /// use motes_smc::{Bootstrap, FilterSettings, FilterSnapshot, ParticleFilter};
    ///
    /// let initial = Gaussian::new("P_0", vec![0.0], mat![[1.0]])?;
    /// let model = LinearGaussian::new(initial, mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[1.0]])?;
    /// let stream = Seed::from_u64(7).stream();
    /// let mut filter = ParticleFilter::new(&model, Bootstrap, FilterSettings::new(1000), stream)?;
    /// filter.step(&[0.3])?;
    ///
    /// let mut bytes = Vec::new();
    /// ciborium::into_writer(&filter.snapshot(), &mut bytes)?;
    /// let snapshot: FilterSnapshot<()> = ciborium::from_reader(&bytes[..])?;
    /// let mut again = ParticleFilter::restore(&model, Bootstrap, snapshot)?;
    /// filter.step(&[1.2])?;
    /// again.step(&[1.2])?;
    /// assert_eq!(again.particles(), filter.particles());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn snapshot(&self) -> FilterSnapshot<P::Memory> {
        FilterSnapshot { bank: self.bank.snapshot(), mean: self.mean.clone() }
    }
}

impl<D: Deref<Target: StateSpaceModel>, P: Proposal<D::Target>> ParticleFilter<D, P> {
    /// The filter that a snapshot was taken of, with the model and the proposal that it had.
    ///
    /// # Errors
    /// As [`FilterBank::restore`]; [`FilterError::Setting`] for the snapshot of a bank of several filters.
    pub fn restore(model: D, proposal: P, snapshot: FilterSnapshot<P::Memory>) -> Result<Self, FilterError> {
        let FilterSnapshot { bank, mean } = snapshot;
        let refused =
            |name, value: usize, expected| FilterError::Setting { name, value: value.to_string(), expected };
        if mean.len() != model.state_dim() {
            return Err(refused(
                "the number of means in a snapshot",
                mean.len(),
                "the model's state dimension",
            ));
        }
        let bank = FilterBank::restore(model, proposal, bank)?;
        match bank.filters() {
            1 => Ok(ParticleFilter { bank, mean }),
            several => Err(refused("the number of filters in a snapshot", several, "1")),
        }
    }
}
