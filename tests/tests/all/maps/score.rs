//! Whether evidence is unbiased: the mean of `ẑ / z` over many filters, in standard errors from 1.

use motes_models::{Seed, StateSpaceModel, check_model};
use motes_smc::{FilterBank, FilterSettings, Proposal};

use super::models::Series;

/// Filters whose evidences are averaged.
pub(super) const FILTERS: usize = 2000;

/// How far the mean is from 1: it is 1 with any number of particles.
pub(super) fn score<M: StateSpaceModel, P: Proposal<M, Memory: Send> + Clone + Send>(
    model: &M,
    proposal: &P,
    settings: FilterSettings,
    Series { measurements, log_evidence }: &Series,
) -> f64 {
    check_model(model).unwrap();
    let seed = Seed::from_u64(11);
    let mut bank = FilterBank::new(model, proposal.clone(), settings, FILTERS, &seed).unwrap();
    for (index, row) in measurements.rows().enumerate() {
        bank.step_at(&model.step_of_index(index), row).unwrap();
    }
    let ratio = |filter| (bank.log_evidence(filter) - log_evidence).exp();
    let ratios: Vec<f64> = (0..FILTERS).map(ratio).collect();
    let mean = ratios.iter().sum::<f64>() / FILTERS as f64;
    let variance = ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum::<f64>() / (FILTERS - 1) as f64;
    (mean - 1.0) / (variance / FILTERS as f64).sqrt()
}
