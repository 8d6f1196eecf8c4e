//! Bugs planted into a proposal of noise, which the statistic of the evidence catches.

use motes_models::equations::{Distribution, Draws, Equations, Scalar, normal};
use motes_models::{Step, Stream};
use motes_smc::{
    Conditional, Context, FilterSettings, Proposal, ProposalError, particles_by_stream, weigh_with_share,
};
use rand::RngExt;
use rand_distr::StandardNormal;

use super::models::{Delays, Population, Series, delays, people};
use super::score::score;

/// What is done wrongly.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Bug {
    Nothing,
    /// Densities of what is drawn, without the slope of its transport.
    NoSlope,
    /// The density of `v` under the proposal alone.
    NoPrior,
    /// A count weighs by the proposal's density of its noise instead of its mass.
    DensityForMass,
    /// Each draw chooses from the mixture for itself, where the weight is that of one choice for all.
    ShareOfEachDraw,
}

/// Each draw's noise is from `N(0.8, 0.8²)`, whatever was measured, with a share of 0.3 of `N(0, 1)`.
#[derive(Clone)]
struct ShiftedNoise {
    bug: Bug,
}

const MEAN: f64 = 0.8;
const SD: f64 = 0.8;
const SHARE: f64 = 0.3;

fn log_normal_density(v: f64, mean: f64, sd: f64) -> f64 {
    Distribution::log_density(&normal(mean, sd), v)
}

/// The end of the noise that is transported to counts of at most `n`, by halves.
fn end(distribution: &Distribution<f64>, n: f64) -> f64 {
    let (mut low, mut high) = (-9.0, 9.0);
    for _ in 0..45 {
        let middle = 0.5 * (low + high);
        *(if distribution.from_normal(middle) <= n { &mut low } else { &mut high }) = middle;
    }
    0.5 * (low + high)
}

/// Draws for one particle, and adds up `log q/p`.
struct OneParticle<'a> {
    bug: Bug,
    is_from_prior: bool,
    stream: &'a mut Stream,
    log_ratio: f64,
}

impl Draws<f64> for OneParticle<'_> {
    fn draw(&mut self, distribution: Distribution<f64>) -> f64 {
        if self.bug == Bug::ShareOfEachDraw {
            self.is_from_prior = self.stream.random::<f64>() < SHARE;
        }
        let z: f64 = self.stream.sample(StandardNormal);
        let v = if self.is_from_prior { z } else { MEAN + SD * z };
        let value = distribution.from_normal(v);
        let of_proposal = log_normal_density(v, MEAN, SD);
        self.log_ratio += match (self.bug, distribution.is_discrete()) {
            (Bug::DensityForMass, true) => of_proposal - distribution.log_density(value),
            (_, true) => {
                let ends = [value - 1.0, value].map(|n| (end(&distribution, n) - MEAN) / SD);
                (ends[1].normal_cdf() - ends[0].normal_cdf()).ln() - distribution.log_density(value)
            }
            (Bug::NoSlope, false) => of_proposal - distribution.log_density(value),
            (Bug::NoPrior, false) => of_proposal,
            (_, false) => of_proposal - log_normal_density(v, 0.0, 1.0),
        };
        value
    }
}

/// A block of particles.
struct ShiftedBatch<'a, M> {
    model: &'a M,
    context: Context<'a>,
    bug: Bug,
}

impl<M: Equations> Conditional for ShiftedBatch<'_, M> {
    fn sample(&mut self, _: &mut [Stream], _: &mut [f64], _: &mut [f64]) {
        unreachable!("it draws by noise");
    }

    fn log_density(&mut self, _: &[f64], _: &mut [f64]) {
        unreachable!("it draws by noise");
    }

    fn sample_by_noise(
        &mut self,
        _: Option<f64>,
        streams: &mut [Stream],
        states: &mut [f64],
        log_ratios: &mut [f64],
    ) -> bool {
        let (n, each) = (self.model.dimensions()[0], log_ratios.len() / streams.len());
        let mut previous = vec![0.0; states.len()];
        if let Some(rows) = self.context.previous {
            (0..log_ratios.len()).for_each(|row| previous[row * n..][..n].copy_from_slice(rows.row(row)));
        }
        let is_start = self.context.previous.is_none();
        let mut row = 0;
        for (stream, log_ratios) in particles_by_stream(streams, log_ratios, 1, each * streams.len()) {
            for log_ratio in log_ratios {
                let is_from_prior = stream.random::<f64>() < SHARE;
                let mut draws = OneParticle { bug: self.bug, is_from_prior, stream, log_ratio: 0.0 };
                let (before, state) = (&previous[row * n..][..n], &mut states[row * n..][..n]);
                match is_start {
                    true => self.model.initial(&self.context.step, &mut draws, state),
                    false => self.model.transition(&self.context.step, before, &mut draws, state),
                }
                *log_ratio = draws.log_ratio;
                row += 1;
            }
        }
        weigh_with_share(log_ratios, SHARE);
        true
    }
}

impl<M: Equations> Proposal<M> for ShiftedNoise {
    type Memory = ();
    type Scratch = ();
    type Conditional<'a>
        = ShiftedBatch<'a, M>
    where
        M: 'a;

    fn initial_memory(&self, _: usize) {}

    fn prepare(&mut self, _: &M, _: &Step<'_>, _: &[Option<f64>]) -> Result<bool, ProposalError> {
        Ok(true)
    }

    fn condition<'a>(
        &'a self,
        model: &'a M,
        context: Context<'a>,
        (): (),
        (): &'a mut (),
    ) -> Result<ShiftedBatch<'a, M>, ProposalError> {
        Ok(ShiftedBatch { model, context, bug: self.bug })
    }
}

fn scored<M: Equations>(bug: Bug, model: &M, series: &Series) -> f64 {
    let z = score(model, &ShiftedNoise { bug }, FilterSettings::new(20), series);
    println!("planted: {bug:?}: z = {z:.1}");
    z.abs()
}

#[test]
fn without_a_bug_it_is_unbiased() {
    assert!(scored(Bug::Nothing, &Delays, &delays()) < 4.0);
    assert!(scored(Bug::Nothing, &Population, &people()) < 4.0);
}

#[test]
fn a_slope_of_the_transport_that_is_left_out_is_caught() {
    assert!(scored(Bug::NoSlope, &Delays, &delays()) > 8.0);
}

#[test]
fn a_density_of_the_noise_that_is_left_out_is_caught() {
    assert!(scored(Bug::NoPrior, &Delays, &delays()) > 8.0);
}

#[test]
fn a_count_that_weighs_by_a_density_is_caught() {
    assert!(scored(Bug::DensityForMass, &Population, &people()) > 8.0);
}

#[test]
fn a_share_of_each_draw_is_caught() {
    assert!(scored(Bug::ShareOfEachDraw, &Population, &people()) > 8.0);
}
