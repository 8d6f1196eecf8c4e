//! A filter of the twisted model over its whole sequence.

use motes_models::Stream;
use motes_models::equations::Linearise;

use super::model::TwistedModel;
use super::proposal::TwistedProposal;
use crate::bank::FilterSettings;
use crate::error::FilterError;
use crate::filter::ParticleFilter;
use crate::resampling::{ResampleWhen, Resampling};

/// How twisted filters resample, and those that they are learned from.
pub(super) fn settings(particles: usize) -> FilterSettings {
    FilterSettings {
        particles,
        resampling: Resampling::Systematic,
        resample_when: ResampleWhen::EssBelow(0.5),
        // The transition density of a twisted model is not that of its draws.
        defensive_weight: None,
    }
}

/// A filter of that type.
pub(super) type TwistedFilter<'a, M> = ParticleFilter<&'a TwistedModel<'a, M>, TwistedProposal>;

/// Steps a filter through the whole sequence, and shows it to `observe` after each step; the log-evidence.
pub(super) fn run<'a, M: Linearise + ?Sized, E: From<FilterError>>(
    twisted: &'a TwistedModel<'a, M>,
    particles: usize,
    stream: Stream,
    mut observe: impl FnMut(&TwistedFilter<'a, M>) -> Result<(), E>,
) -> Result<f64, E> {
    let mut filter = ParticleFilter::new(twisted, TwistedProposal, settings(particles), stream)?;
    // The model knows what was measured.
    let unread = vec![0.0; twisted.measurements.width()];
    for _ in 0..twisted.measurements.len() {
        filter.step(&unread)?;
        observe(&filter)?;
    }
    Ok(filter.log_evidence())
}
