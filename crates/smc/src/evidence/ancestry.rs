//! The variance of a filter's log-evidence by the ancestry of its particles.

use std::ops::Deref;

use motes_models::StateSpaceModel;
use serde::{Deserialize, Serialize};

use crate::bank::FilterBank;
use crate::filter::ParticleFilter;
use crate::proposal::Proposal;

/// Steps that a block has at least: errors of a step show in the evidence of about so many later ones.
const BLOCK_STEPS: usize = 16;

/// An estimate of the variance of a filter's log-evidence from the ancestry of its particles, in one run.
///
/// Steps are taken in blocks. A block begins with `K` particles of equal weight, at the start or just after resampling, and ends with the first resampling
/// after 16 steps. With `G_i` the weight of all that descend from particle `i` of its beginning, its part of the variance is
/// `Σ_i (G_i − 1/K)²` (Chan and Lai 2013; Lee and Whiteley 2018). Errors of different blocks are nearly independent, so their parts add up.
///
/// - A block of one step has the variance of the mean weight, `(K Σ W² − 1)/K`. That alone is too small where a state is remembered: what a particle is worth shows
///   in later weights too. For a state with an autocorrelation of 0.99 the standard error would be a third of what it is.
/// - Over a whole sequence all particles come to descend from one, and their ancestry says nothing any more. This is why there are blocks.
/// - It needs particles wherever the target is. A mode without any, or with one by chance, is in no estimate.
/// - It is too small where few particles have all weight. Below some 20 effective ones it is not to be trusted; [`EvidenceCheck`](crate::EvidenceCheck) has
///   small filters beside it for that.
///
/// ```
/// use faer::mat;
/// use motes_models::{Gaussian, LinearGaussian, Seed};
/// use motes_smc::{AncestryVariance, Bootstrap, FilterSettings, ParticleFilter};
///
/// let initial = Gaussian::new("P_0", vec![0.0], mat![[1.0]])?;
/// let model = LinearGaussian::new(initial, mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[1.0]])?;
/// let stream = Seed::from_u64(7).stream();
/// let mut filter = ParticleFilter::new(&model, Bootstrap, FilterSettings::new(1000), stream)?;
/// let mut ancestry = AncestryVariance::default();
/// for measurement in [[0.3], [1.2], [0.7]] {
///     filter.step(&measurement)?;
///     ancestry.step(&filter);
/// }
/// println!("log-evidence {:.2} ± {:.2}", filter.log_evidence(), ancestry.variance().sqrt());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct AncestryVariance {
    /// Steps of the present block.
    steps: usize,
    /// The variance of all blocks before it.
    before: f64,
    /// That of the present block so far.
    present: f64,
    /// Of each particle, the one of the block's beginning that it descends from.
    roots: Vec<usize>,
    /// Room for those of the next step.
    next: Vec<usize>,
    /// `G_i`.
    descendants: Vec<f64>,
}

impl AncestryVariance {
    /// Takes in the step that `filter` has just taken; every step is to be taken in.
    pub fn step<D: Deref<Target: StateSpaceModel>, P: Proposal<D::Target>>(
        &mut self,
        filter: &ParticleFilter<D, P>,
    ) {
        self.step_of_bank(filter.bank(), 0);
    }

    /// The same of one filter of a bank.
    ///
    /// # Panics
    /// If there is no such filter.
    pub fn step_of_bank<D: Deref<Target: StateSpaceModel>, P: Proposal<D::Target>>(
        &mut self,
        bank: &FilterBank<D, P>,
        filter: usize,
    ) {
        let (weights, k) = (bank.weights(filter).normalised(), bank.weights(filter).len());
        let resampled = bank.resampled(filter);
        if self.roots.len() != k || (resampled && self.steps >= BLOCK_STEPS) {
            self.before += self.present;
            self.steps = 0;
            self.roots.clear();
            self.roots.extend(0..k);
            self.next.resize(k, 0);
            self.descendants.resize(k, 0.0);
        } else if resampled {
            let ancestors = &bank.ancestors()[filter * k..(filter + 1) * k];
            for (next, row) in self.next.iter_mut().zip(ancestors) {
                *next = self.roots[row - filter * k];
            }
            std::mem::swap(&mut self.roots, &mut self.next);
        }
        self.descendants.fill(0.0);
        for (root, weight) in self.roots.iter().zip(weights) {
            self.descendants[*root] += weight;
        }
        let equal = 1.0 / k as f64;
        self.present = self.descendants.iter().map(|sum| (sum - equal) * (sum - equal)).sum();
        self.steps += 1;
    }

    /// The estimate of the variance of `log Ẑ` (nats²) after all steps so far.
    pub fn variance(&self) -> f64 {
        self.before + self.present
    }

    /// The variance before the block that the last step belongs to.
    pub(crate) fn variance_before_block(&self) -> f64 {
        self.before
    }

    /// That of the block that the last step belongs to, up to this step.
    pub(crate) fn variance_of_block(&self) -> f64 {
        self.present
    }
}
