//! Bugs of particle-filter code that looks right, planted on purpose: tests that no longer catch them are noticed.

use motes_models::{Seed, StateSpaceModel, Step, Stream};
use motes_proposals::{GaussianScratch, Hidden, HiddenRows, Rnn};
use motes_smc::{Context, LogWeights, ParticleMemory, Proposal, ProposalError, ResampleWhen, Resampling};
use rand::RngExt;
use rand_distr::StandardNormal;

use crate::{PARTICLES, RUNS, ScalarGaussian, reference, score};

/// What is wrong with the filter of [`plain_filter_scores`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bug {
    /// Nothing: the control.
    Nothing,
    /// The evidence grows by the mean of the new weights, whatever the weights before were.
    EvidenceWithoutPreviousWeights,
    /// Weights at `t = 0` lack the density of `x_0`.
    NoInitialDensity,
    /// After resampling the weights stay as they are, those of whatever particle had the number before.
    WeightsNotReset,
    /// After resampling particles keep the weights that they were drawn by, and so count twice.
    WeightsKept,
}

/// The scores of evidence and mean, as [`crate::evidence_scores`] has them, of a filter written as plainly as can be with a bug in it:
/// the reference problem, particles drawn from [`ScalarGaussian::wide`].
pub fn plain_filter_scores(bug: Bug, when: ResampleWhen) -> [f64; 2] {
    let (reference, k) = (reference(), PARTICLES);
    let (model, variance) = (&reference.model, ScalarGaussian::wide().variance);
    let run = |stream: &mut Stream| {
        let (mut states, mut increments) = (vec![0.0; k], vec![0.0; k]);
        let (mut weights, mut ancestors) = (LogWeights::uniform(k), vec![0; k]);
        let (mut log_evidence, mut mean) = (0.0, 0.0);
        for (time, measurement) in reference.measurements.rows().enumerate() {
            for (state, increment) in states.iter_mut().zip(&mut increments) {
                let previous = *state;
                let predicted = if time == 0 { 0.0 } else { 0.9 * previous };
                let epsilon: f64 = stream.sample(StandardNormal);
                *state = 0.5 * (predicted + measurement[0]) + variance.sqrt() * epsilon;
                let log_q = -0.5 * (epsilon * epsilon + (std::f64::consts::TAU * variance).ln());
                let log_prior = match time {
                    0 if bug == Bug::NoInitialDensity => 0.0,
                    0 => model.density().unwrap().log_density(&Step::of_index(0), None, &[*state]),
                    _ => model.density().unwrap().log_density(
                        &Step::of_index(time),
                        Some(&[previous]),
                        &[*state],
                    ),
                };
                *increment = model.log_likelihood(&Step::of_index(time), &[*state], measurement).unwrap()
                    + log_prior
                    - log_q;
            }
            let log_sum = weights.update(&increments).unwrap();
            log_evidence += match bug {
                Bug::EvidenceWithoutPreviousWeights => {
                    (increments.iter().map(|log| log.exp()).sum::<f64>() / k as f64).ln()
                }
                _ => log_sum,
            };
            mean = states.iter().zip(weights.normalised()).map(|(x, weight)| x * weight).sum();
            if when.is_due(weights.effective_sample_size(), k) {
                Resampling::Multinomial.draw(weights.normalised(), stream, &mut ancestors);
                states = ancestors.iter().map(|&ancestor| states[ancestor]).collect();
                match bug {
                    Bug::WeightsNotReset => {}
                    Bug::WeightsKept => {
                        let kept: Vec<f64> =
                            ancestors.iter().map(|&ancestor| weights.log()[ancestor]).collect();
                        weights.reset();
                        weights.update(&kept).unwrap();
                    }
                    _ => weights.reset(),
                }
            }
        }
        let ratio = (log_evidence - reference.log_evidence).exp();
        (ratio, ratio * mean)
    };
    let (ratios, products): (Vec<f64>, Vec<f64>) =
        Seed::from_u64(24).streams(RUNS).iter_mut().map(run).unzip();
    [score(&ratios, 1.0), score(&products, reference.last_mean)]
}

/// Systematic resampling whose one offset is fixed in the middle.
pub fn systematic_with_a_fixed_offset(weights: &[f64], ancestors: &mut [usize]) {
    let (count, mut at, mut sum) = (ancestors.len() as f64, 0, weights[0]);
    for (k, ancestor) in ancestors.iter_mut().enumerate() {
        while (k as f64 + 0.5) / count > sum && at + 1 < weights.len() {
            at += 1;
            sum += weights[at];
        }
        *ancestor = at;
    }
}

/// A recurrent proposal whose memory stays where it is when particles are resampled.
#[derive(Clone)]
pub struct Forgetful(pub Rnn);

/// The memory of a [`Forgetful`] proposal.
pub struct Stuck(pub Hidden);

impl ParticleMemory for Stuck {
    type Rows<'a> = HiddenRows<'a>;

    fn rows(&mut self) -> HiddenRows<'_> {
        self.0.rows()
    }

    fn resample(&mut self, _ancestors: &[usize]) {}

    fn is_laid_out_as(&self, other: &Stuck) -> bool {
        self.0.is_laid_out_as(&other.0)
    }
}

impl<M: StateSpaceModel + ?Sized> Proposal<M> for Forgetful {
    type Memory = Stuck;
    type Scratch = GaussianScratch;
    type Conditional<'a>
        = <Rnn as Proposal<M>>::Conditional<'a>
    where
        M: 'a;

    fn initial_memory(&self, particles: usize) -> Stuck {
        Stuck(Proposal::<M>::initial_memory(&self.0, particles))
    }

    fn prepare(
        &mut self,
        model: &M,
        step: &Step<'_>,
        measurement: &[Option<f64>],
    ) -> Result<bool, ProposalError> {
        self.0.prepare(model, step, measurement)
    }

    fn condition<'a>(
        &'a self,
        model: &'a M,
        context: Context<'a>,
        memory: HiddenRows<'_>,
        scratch: &'a mut GaussianScratch,
    ) -> Result<Self::Conditional<'a>, ProposalError> {
        self.0.condition(model, context, memory, scratch)
    }
}
