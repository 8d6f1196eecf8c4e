//! What a filter expects to be measured: one step ahead, and where its particles are.

use std::f64::consts::{PI, TAU};
use std::ops::Deref;

use motes_models::{Marginal, Seed, Simulator, Step, Stream, duplicate};
use rand::Rng;
use serde::{Deserialize, Serialize};

use crate::error::FilterError;
use crate::filter::ParticleFilter;
use crate::proposal::Proposal;
use crate::weights::LogWeights;

/// What is expected of one entry of a measurement, given what was measured before.
///
/// Angles are turned to within half a turn of their mean direction, which is their mean.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Predictive {
    /// Its mean; NaN where there is none, or where the entry cannot be drawn.
    pub mean: f64,
    /// Its standard deviation; NaN where it is infinite, or cannot be told from one particle.
    pub sd: f64,
    /// Its quantiles at the probabilities that were asked for; NaN where they cannot be told from one particle.
    pub quantiles: Vec<f64>,
    /// `P(Y < y) + ½ P(Y = y)` of what was measured, the middle of its probability integral transform; none where nothing was measured, or nobody can tell.
    pub pit: Option<f64>,
}

impl<D, P> ParticleFilter<D, P>
where
    D: Deref<Target: Simulator> + Clone,
    P: Proposal<D::Target, Memory: Clone> + Clone,
{
    /// `p(y_t | y_{0:t−1})` of each of the `M` entries of the measurement that comes next, and where it lies in that: of the particles, drawn by the transition. Its
    /// quantiles are at these `probabilities`. The filter stays as it is.
    ///
    /// # Errors
    /// As [`ParticleFilter::step_at`] without a measurement.
    pub fn measurement_ahead(
        &self,
        step: &Step<'_>,
        measurement: &[Option<f64>],
        probabilities: &[f64],
    ) -> Result<Vec<Predictive>, FilterError> {
        let mut ahead = self.clone();
        ahead.step_at(step, &vec![None; measurement.len()])?;
        Ok(ahead.measurement(step, measurement, probabilities))
    }
}

impl<D: Deref<Target: Simulator>, P: Proposal<D::Target>> ParticleFilter<D, P> {
    /// What would be measured where the particles are, at the end of a step: `p(y_t | y_{0:s})` after the last measurement `y_s`.
    ///
    /// Means and variances are those of the model's distributions, as far as these have formulas; quantiles, at these `probabilities`, are those of a draw for each
    /// particle.
    pub fn measurement(
        &self,
        step: &Step<'_>,
        measurement: &[Option<f64>],
        probabilities: &[f64],
    ) -> Vec<Predictive> {
        // Of numbers that the filter draws later, too: what is made of them here changes nothing there.
        let mut copy = duplicate(&self.bank.streams()[0]);
        let mut stream = Seed::from_u64(copy.next_u64()).child("measurement").stream();
        let weighted = (self.particles(), self.weights());
        Predictive::of_states(&*self.bank.model, step, weighted, (measurement, probabilities), &mut stream)
    }
}

impl Predictive {
    /// What would be measured at weighted states (`K×N`), at the end of a step: that of each entry of the measurement (`M`). One number of each is drawn, for quantiles at these
    /// probabilities.
    pub fn of_states<M: Simulator + ?Sized>(
        model: &M,
        step: &Step<'_>,
        (states, weights): (&[f64], &LogWeights),
        (measurement, probabilities): (&[Option<f64>], &[f64]),
        stream: &mut Stream,
    ) -> Vec<Self> {
        let m = measurement.len();
        let mut marginals = vec![Marginal::of_draw(f64::NAN, None); weights.len() * m];
        model.marginals(step, states, measurement, stream, &mut marginals);
        let of_entry = |entry: usize| {
            let marginals: Vec<Marginal> = marginals.iter().skip(entry).step_by(m).copied().collect();
            Predictive::of_marginals(weights, marginals, measurement[entry], probabilities)
        };
        (0..m).map(of_entry).collect()
    }

    /// That of an entry from what is expected of it at each of `K` weighted particles, and where it lies if it was measured; with quantiles at these probabilities.
    pub fn of_marginals(
        weights: &LogWeights,
        mut marginals: Vec<Marginal>,
        measured: Option<f64>,
        probabilities: &[f64],
    ) -> Self {
        if marginals.iter().any(|marginal| marginal.is_angle) {
            let turned = turned(weights, &mut marginals, measured);
            let mut found = Predictive::of_numbers(weights, &marginals, measured, probabilities);
            found.mean = turned;
            return found;
        }
        Predictive::of_numbers(weights, &marginals, measured, probabilities)
    }

    fn of_numbers(
        weights: &LogWeights,
        marginals: &[Marginal],
        measured: Option<f64>,
        probabilities: &[f64],
    ) -> Self {
        let mean = mean(weights, marginals, |marginal| marginal.mean);
        let spread =
            |marginal: &Marginal| marginal.variance + (marginal.mean - mean) * (marginal.mean - mean);
        let variance = self::mean(weights, marginals, spread);
        let weighed = || weights.normalised().iter().zip(marginals).filter(|(weight, _)| **weight > 0.0);
        let is_alone = weighed().count() == 1;
        let quantiles = match is_alone || weighed().any(|(_, marginal)| marginal.drawn.is_nan()) {
            true => vec![f64::NAN; probabilities.len()],
            false => weights.quantiles(marginals.iter().map(|marginal| marginal.drawn), probabilities),
        };
        let pit = self::mean(weights, marginals, |marginal| marginal.below + 0.5 * marginal.at);
        Predictive {
            mean,
            sd: if is_alone && variance == 0.0 { f64::NAN } else { variance.sqrt() },
            quantiles,
            pit: measured.map(|_| pit.clamp(0.0, 1.0)).filter(|pit| !pit.is_nan()),
        }
    }
}

/// `Σ_k W_k f_k` over particles with a weight.
fn mean(weights: &LogWeights, marginals: &[Marginal], of: impl Fn(&Marginal) -> f64) -> f64 {
    let weighed = weights.normalised().iter().zip(marginals).filter(|(weight, _)| **weight > 0.0);
    weighed.map(|(weight, marginal)| weight * of(marginal)).sum()
}

/// Turns angles to within half a turn of their mean direction, which it gives, and leaves what draws say of them.
fn turned(weights: &LogWeights, marginals: &mut [Marginal], measured: Option<f64>) -> f64 {
    let [sine, cosine] = [f64::sin, f64::cos].map(|of| mean(weights, marginals, |one| of(one.drawn)));
    let middle = sine.atan2(cosine);
    // In (−π, π] of the middle.
    let turn = |angle: f64| middle + PI - (middle + PI - angle).rem_euclid(TAU);
    for marginal in marginals {
        *marginal = Marginal::of_draw(turn(marginal.drawn), measured.map(turn));
    }
    middle
}
