//! The minimum-degeneracy proposal in closed form.

use std::ops::Range;

use faer::{Mat, MatRef};
use motes_models::batch::{LANES, Rows, TileMatrix, load, squared_norms, store, with_noise, with_scratch};
use motes_models::{AdditiveGaussian, Gaussian, ModelError, Step, Stream, fill_standard_normal, kalman};

use crate::proposal::{Conditional, Context, Proposal};
use crate::proposal_error::ProposalError;

/// `p(x_t | x_{t−1}, y_t)` of a system with additive Gaussian noise and linear measurements (the paper's
/// equation "minDeg", in Doucet, Godsill and Andrieu's closed form).
///
/// `Σ⁻¹ = Σ_v⁻¹ + Cᵀ Σ_w⁻¹ C` and `μ = f(x_{t−1}) + G (y_t − C f(x_{t−1}))` with `G = Σ Cᵀ Σ_w⁻¹`; at `t = 0`
/// the prior's mean and covariance take the place of `f` and `Σ_v`, and where entries of `y_t` are missing, the rows of `C` and `Σ_w` that are
/// there take the place of all. Among proposals that see only `x_{t−1}` and `y_t` it gives weights of the smallest variance.
#[derive(Debug, Clone)]
#[doc(alias = "optimal proposal")]
pub struct MinDegeneracy {
    first: Correction,
    later: Correction,
    /// For the entries of a measurement that are there, where some are missing.
    partial: Option<Partial>,
    /// `G y` of the present step, and what of `y` is there.
    shift: Vec<f64>,
    measurement: Vec<f64>,
    /// Whether the present step is corrected by `partial`.
    has_gaps: bool,
}

/// A correction by some entries of a measurement.
#[derive(Debug, Clone)]
struct Partial {
    is_first: bool,
    /// Which entries are there.
    present: Vec<bool>,
    correction: Correction,
}

/// How a prediction `f` is corrected by a measurement, for one prior covariance: to `(I − G C) f + G y`.
#[derive(Debug, Clone)]
struct Correction {
    posterior: Gaussian,
    /// `N(0, S)` with `S = C Σ_v Cᵀ + Σ_w`: how far measurements lie from their predictions.
    innovation: Gaussian,
    gain: Mat<f64>,
    kept: TileMatrix,
    measurement_matrix: TileMatrix,
}

impl MinDegeneracy {
    /// Precomputes gains and covariances, which are the same for every particle and every `t ≥ 1`.
    ///
    /// # Errors
    /// [`ModelError::Covariance`] if a posterior covariance is not positive definite in floating point.
    pub fn new(model: &(impl AdditiveGaussian + ?Sized)) -> Result<Self, ModelError> {
        let (c, noise) = (model.measurement_matrix(), model.measurement_covariance());
        Ok(MinDegeneracy {
            first: Correction::new(model.initial().covariance(), c, noise)?,
            later: Correction::new(model.transition_covariance(), c, noise)?,
            partial: None,
            shift: Vec::new(),
            measurement: Vec::new(),
            has_gaps: false,
        })
    }

    /// How predictions of a time are corrected in the present step.
    fn at(&self, step: &Step<'_>) -> &Correction {
        match &self.partial {
            Some(partial) if self.has_gaps => &partial.correction,
            _ if step.index == 0 => &self.first,
            _ => &self.later,
        }
    }

    /// Keeps a measurement, and what it shifts every mean by.
    fn take(&mut self, step: &Step<'_>, measurement: impl Iterator<Item = f64>) {
        self.measurement.clear();
        self.measurement.extend(measurement);
        let mut shift = std::mem::take(&mut self.shift);
        let gain = &self.at(step).gain;
        shift.clear();
        shift.resize(gain.nrows(), 0.0);
        for (j, value) in self.measurement.iter().enumerate() {
            shift.iter_mut().zip(gain.col_as_slice(j)).for_each(|(sum, entry)| *sum += entry * value);
        }
        self.shift = shift;
    }

    /// How predictions are corrected by the entries that are there, unless it is known from the step before.
    fn correct_partial<M: AdditiveGaussian + ?Sized>(
        &mut self,
        model: &M,
        time: usize,
        measurement: &[Option<f64>],
    ) -> Result<(), ProposalError> {
        let is_first = time == 0;
        let is_there = |partial: &Partial| {
            let same = measurement.iter().map(Option::is_some).eq(partial.present.iter().copied());
            partial.is_first == is_first && same
        };
        if self.partial.as_ref().is_some_and(is_there) {
            return Ok(());
        }
        let present: Vec<usize> = (0..measurement.len()).filter(|&j| measurement[j].is_some()).collect();
        let (c, noise) = (model.measurement_matrix(), model.measurement_covariance());
        let c = Mat::from_fn(present.len(), model.state_dim(), |i, j| c[(present[i], j)]);
        let noise = Mat::from_fn(present.len(), present.len(), |i, j| noise[(present[i], present[j])]);
        let prior = if is_first { model.initial().covariance() } else { model.transition_covariance() };
        let correction = Correction::new(prior, c.as_ref(), noise.as_ref())
            .map_err(|error| ProposalError::Measurement { time, reason: error.to_string() })?;
        let present = measurement.iter().map(Option::is_some).collect();
        self.partial = Some(Partial { is_first, present, correction });
        Ok(())
    }
}

impl Correction {
    /// That of a prior covariance by a measurement with matrix `C` and noise covariance `Σ_w`.
    fn new(prior: MatRef<'_, f64>, c: MatRef<'_, f64>, noise: MatRef<'_, f64>) -> Result<Self, ModelError> {
        let n = c.ncols();
        let kalman::Correction { gain, covariance, innovation } = kalman::correction(prior, c, noise)?;
        let kept = Mat::<f64>::identity(n, n) - &gain * c;
        Ok(Correction {
            posterior: Gaussian::new("the minimum-degeneracy covariance", vec![0.0; n], covariance)?,
            innovation,
            gain,
            kept: TileMatrix::new(kept.as_ref()),
            measurement_matrix: TileMatrix::new(c),
        })
    }
}

/// Gives every lane of a tile the same vector.
fn spread(vector: &[f64], tile: &mut [f64]) {
    for (row, value) in tile.as_chunks_mut::<LANES>().0.iter_mut().zip(vector) {
        row.fill(*value);
    }
}

/// `f(x_{t−1})` of up to a tile of previous states, from `particles.start` on, or the mean of `x_0`; `tile` is scratch.
fn predict<M: AdditiveGaussian + ?Sized>(
    model: &M,
    step: &Step<'_>,
    previous: Option<Rows<'_>>,
    particles: Range<usize>,
    tile: &mut [f64],
    predicted: &mut [f64],
) {
    match previous {
        None => spread(model.initial().mean(), predicted),
        Some(previous) => {
            previous.load(particles.start, tile);
            model.tile_transition_means(step, tile, particles.len(), predicted);
        }
    }
}

impl<M: AdditiveGaussian + ?Sized> Proposal<M> for MinDegeneracy {
    type Memory = ();
    type Scratch = ();
    type Conditional<'a>
        = Corrected<'a, M>
    where
        M: 'a;

    fn initial_memory(&self, _particles: usize) {}

    fn prepare(
        &mut self,
        model: &M,
        step: &Step<'_>,
        measurement: &[Option<f64>],
    ) -> Result<bool, ProposalError> {
        let (n, m) = self.later.gain.shape();
        ProposalError::unless_same("the state dimension N", n, model.state_dim())?;
        ProposalError::unless_same("the measurement dimension M", m, measurement.len())?;
        if measurement.iter().all(Option::is_none) {
            // Nothing to be corrected by: that is the transition.
            return Ok(false);
        }
        self.has_gaps = measurement.iter().any(Option::is_none);
        if self.has_gaps {
            self.correct_partial(model, step.index, measurement)?;
        }
        self.take(step, measurement.iter().copied().flatten());
        Ok(true)
    }

    fn condition<'a>(
        &'a self,
        model: &'a M,
        context: Context<'a>,
        (): (),
        (): &'a mut (),
    ) -> Result<Corrected<'a, M>, ProposalError> {
        let correction = self.at(&context.step);
        if self.shift.len() != correction.gain.nrows() {
            return Err(ProposalError::NotPrepared { time: context.step.index });
        }
        Ok(Corrected { model, correction, proposal: self, context })
    }
}

/// Gaussians of one covariance, each particle with its own mean.
pub struct Corrected<'a, M: ?Sized> {
    model: &'a M,
    proposal: &'a MinDegeneracy,
    correction: &'a Correction,
    context: Context<'a>,
}

impl<M: AdditiveGaussian + ?Sized> Corrected<'_, M> {
    /// The predictions and posterior means of a tile of particles; `tile` is scratch.
    fn means(&self, particles: Range<usize>, tile: &mut [f64], predicted: &mut [f64], means: &mut [f64]) {
        predict(self.model, &self.context.step, self.context.previous, particles, tile, predicted);
        spread(&self.proposal.shift, means);
        self.correction.kept.times_add(predicted, means);
    }

    /// Draws all particles, and shows `weigh` which were drawn, their noise, their predictions, and scratch of `rows` tile rows.
    fn draw(
        &self,
        streams: &mut [Stream],
        states: &mut [f64],
        particles: usize,
        rows: usize,
        mut weigh: impl FnMut(Range<usize>, &mut [f64], &[f64], &mut [f64]),
    ) {
        let n = self.correction.gain.nrows();
        // One piece for all: pieces that begin alike in their pages would push each other out of the nearest cache.
        with_scratch((3 * n + rows) * LANES, |scratch| {
            let (tile, rest) = scratch.split_at_mut(n * LANES);
            let (predicted, rest) = rest.split_at_mut(n * LANES);
            let (drawn, of_weights) = rest.split_at_mut(n * LANES);
            with_noise(streams, n, particles, fill_standard_normal, |particles, noise| {
                self.means(particles.clone(), tile, predicted, drawn);
                self.correction.posterior.tile_add_deviation(noise, drawn);
                store(drawn, n, &mut states[particles.start * n..particles.end * n]);
                weigh(particles, noise, predicted, of_weights);
            });
        });
    }
}

impl<M: AdditiveGaussian + ?Sized> Conditional for Corrected<'_, M> {
    fn sample(&mut self, streams: &mut [Stream], states: &mut [f64], log_density: &mut [f64]) {
        let log_normalizer = self.correction.posterior.log_normalizer();
        self.draw(streams, states, log_density.len(), 0, |particles, noise, _, _| {
            // log q follows from the noise that x was made of.
            let mut squares = [0.0; LANES];
            squared_norms(noise, &mut squares);
            for (log_density, square) in log_density[particles].iter_mut().zip(squares) {
                *log_density = log_normalizer - 0.5 * square;
            }
        });
    }

    fn sample_weighted(
        &mut self,
        streams: &mut [Stream],
        states: &mut [f64],
        log_weights: &mut [f64],
    ) -> bool {
        if !self.model.is_gaussian() {
            return false;
        }
        let m = self.correction.gain.ncols();
        self.draw(streams, states, log_weights.len(), 2 * m, |particles, _, predicted, scratch| {
            let (residuals, whitened) = scratch.split_at_mut(m * LANES);
            // By Bayes' rule p(y|x) p(x|x') / q(x|x',y) is p(y|x'), whatever x was drawn.
            spread(&self.proposal.measurement, residuals);
            self.correction.measurement_matrix.times_subtract(predicted, residuals);
            self.correction.innovation.tile_log_density(residuals, whitened, &mut log_weights[particles]);
        });
        true
    }

    fn log_density(&mut self, states: &[f64], log_density: &mut [f64]) {
        let n = self.correction.gain.nrows();
        with_scratch(4 * n * LANES, |scratch| {
            let (tile, rest) = scratch.split_at_mut(n * LANES);
            let (predicted, rest) = rest.split_at_mut(n * LANES);
            let (deviations, means) = rest.split_at_mut(n * LANES);
            let blocks = states.chunks(n * LANES).zip(log_density.chunks_mut(LANES));
            for (block, (states, log_density)) in blocks.enumerate() {
                let first = block * LANES;
                self.means(first..first + log_density.len(), tile, predicted, means);
                load(states, n, deviations);
                deviations.iter_mut().zip(means.iter()).for_each(|(deviation, mean)| *deviation -= mean);
                self.correction.posterior.tile_log_density(deviations, means, log_density);
            }
        });
    }
}
