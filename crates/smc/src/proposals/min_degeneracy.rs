//! The minimum-degeneracy proposal in closed form.

use std::ops::Range;

use motes_models::batch::{LANES, Rows, TileMatrix, load, squared_norms, store, with_noise, with_scratch};
use motes_models::{AdditiveGaussian, Gaussian, ModelError, Stream, fill_standard_normal, kalman};

use faer::{Mat, MatRef};

use crate::{Conditional, Past, Proposal, ProposalError, RowPast, RowProposal};

/// `p(x_t | x_{t−1}, y_t)` of a system with additive Gaussian noise and linear measurements (the paper's
/// equation "minDeg", in Doucet, Godsill and Andrieu's closed form).
///
/// `Σ⁻¹ = Σ_v⁻¹ + Cᵀ Σ_w⁻¹ C` and `μ = f(x_{t−1}) + G (y_t − C f(x_{t−1}))` with `G = Σ Cᵀ Σ_w⁻¹`; at `t = 0`
/// the prior's mean and covariance take the place of `f` and `Σ_v`. Among proposals that see only `x_{t−1}` and `y_t`
/// it gives weights of the smallest variance.
#[derive(Debug, Clone)]
#[doc(alias = "optimal proposal")]
pub struct MinDegeneracy {
    first: Correction,
    later: Correction,
    means: Vec<f64>,
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
    /// `G y` of the present step.
    shift: Vec<f64>,
}

impl MinDegeneracy {
    /// Precomputes gains and covariances, which are the same for every particle and every `t ≥ 1`.
    ///
    /// # Errors
    /// [`ModelError::Covariance`] if a posterior covariance is not positive definite in floating point.
    pub fn new(model: &(impl AdditiveGaussian + ?Sized)) -> Result<Self, ModelError> {
        Ok(MinDegeneracy {
            first: Correction::new(model, model.initial().covariance())?,
            later: Correction::new(model, model.transition_covariance())?,
            means: Vec::new(),
        })
    }

    fn at(&self, time: usize) -> &Correction {
        if time == 0 { &self.first } else { &self.later }
    }

    /// Makes everything ready that does not depend on particles.
    fn prepare<M: AdditiveGaussian + ?Sized>(
        &mut self,
        model: &M,
        time: usize,
        measurement: &[f64],
    ) -> Result<(), ProposalError> {
        let correction = if time == 0 { &mut self.first } else { &mut self.later };
        let (n, m) = correction.gain.shape();
        ProposalError::unless_same("the state dimension N", n, model.state_dim())?;
        ProposalError::unless_same("the measurement dimension M", m, measurement.len())?;
        for (i, shift) in correction.shift.iter_mut().enumerate() {
            *shift = measurement.iter().enumerate().map(|(j, value)| correction.gain[(i, j)] * value).sum();
        }
        Ok(())
    }
}

impl Correction {
    fn new(model: &(impl AdditiveGaussian + ?Sized), prior: MatRef<'_, f64>) -> Result<Self, ModelError> {
        let c = model.measurement_matrix();
        let n = c.ncols();
        let kalman::Correction { gain, covariance, innovation } =
            kalman::correction(prior, c, model.measurement_covariance())?;
        let kept = Mat::<f64>::identity(n, n) - &gain * c;
        Ok(Correction {
            posterior: Gaussian::new("the minimum-degeneracy covariance", vec![0.0; n], covariance)?,
            innovation,
            gain,
            kept: TileMatrix::new(kept.as_ref()),
            measurement_matrix: TileMatrix::new(c),
            shift: vec![0.0; n],
        })
    }

    /// The posterior means of a tile of predictions.
    fn correct(&self, predicted: &[f64], means: &mut [f64]) {
        spread(&self.shift, means);
        self.kept.times_add(predicted, means);
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
    time: usize,
    previous: Option<Rows<'_>>,
    particles: Range<usize>,
    tile: &mut [f64],
    predicted: &mut [f64],
) {
    match previous {
        None => spread(model.initial().mean(), predicted),
        Some(previous) => {
            previous.load(particles.start, tile);
            model.tile_transition_means(time, tile, particles.len(), predicted);
        }
    }
}

impl<M: AdditiveGaussian + ?Sized> Proposal<M> for MinDegeneracy {
    type Memory = ();
    type Conditional<'a>
        = Shifted<'a>
    where
        M: 'a;

    fn initial_memory(&self, _particles: usize) {}

    fn condition<'a>(
        &'a mut self,
        model: &'a M,
        past: Past<'a>,
        _memory: &mut (),
    ) -> Result<Shifted<'a>, ProposalError> {
        self.prepare(model, past.time, past.measurement)?;
        let n = model.state_dim();
        let mut means = std::mem::take(&mut self.means);
        means.resize(past.particles * n, 0.0);
        let correction = self.at(past.time);
        let previous = past.previous.map(|states| Rows::all(states, n));
        with_scratch(2 * n * LANES, |scratch| {
            let (tile, predicted) = scratch.split_at_mut(n * LANES);
            for (at, means) in means.chunks_mut(n * LANES).enumerate() {
                let particles = means.len() / n;
                let particles = at * LANES..at * LANES + particles;
                predict(model, past.time, previous, particles, tile, predicted);
                correction.correct(predicted, tile);
                store(tile, n, means);
            }
        });
        self.means = means;
        Ok(Shifted { deviation: &self.at(past.time).posterior, means: &self.means })
    }

    fn by_rows(
        &mut self,
        model: &M,
        time: usize,
        measurement: &[f64],
    ) -> Result<Option<&dyn RowProposal<M>>, ProposalError> {
        self.prepare(model, time, measurement)?;
        Ok(Some(self))
    }
}

impl<M: AdditiveGaussian + ?Sized> RowProposal<M> for MinDegeneracy {
    fn draw(
        &self,
        model: &M,
        past: RowPast<'_>,
        streams: &mut [Stream],
        states: &mut [f64],
        increments: &mut [f64],
    ) {
        let RowPast { time, measurement, previous } = past;
        let correction = self.at(time);
        let (n, m) = correction.gain.shape();
        with_scratch((3 * n + 2 * m) * LANES, |scratch| {
            let (tile, rest) = scratch.split_at_mut(n * LANES);
            let (predicted, rest) = rest.split_at_mut(n * LANES);
            let (drawn, rest) = rest.split_at_mut(n * LANES);
            let (residuals, whitened) = rest.split_at_mut(m * LANES);
            with_noise(streams, n, increments.len(), fill_standard_normal, |particles, noise| {
                predict(model, time, previous, particles.clone(), tile, predicted);
                correction.correct(predicted, drawn);
                correction.posterior.tile_add_deviation(noise, drawn);
                store(drawn, n, &mut states[particles.start * n..particles.end * n]);
                let increments = &mut increments[particles];
                if model.is_gaussian() {
                    // By Bayes' rule p(y|x) p(x|x') / q(x|x',y) is p(y|x'), whatever x was drawn.
                    spread(measurement, residuals);
                    correction.measurement_matrix.times_subtract(predicted, residuals);
                    correction.innovation.tile_log_density(residuals, whitened, increments);
                } else {
                    // log q follows from the noise that x was made of.
                    let mut squares = [0.0; LANES];
                    squared_norms(noise, &mut squares);
                    for (increment, square) in increments.iter_mut().zip(squares) {
                        *increment = 0.5 * square - correction.posterior.log_normalizer();
                    }
                }
            });
        });
        if !model.is_gaussian() {
            with_scratch(increments.len(), |terms| {
                let mut add = |terms: &[f64]| {
                    increments.iter_mut().zip(terms).for_each(|(increment, term)| *increment += term);
                };
                model.log_likelihoods(time, states, measurement, terms);
                add(terms);
                match previous {
                    None => model.log_initials(states, terms),
                    Some(previous) => previous.with_contiguous(|previous| {
                        model.log_transitions(time, previous, states, terms);
                    }),
                }
                add(terms);
            });
        }
    }
}

/// Gaussians of one covariance, each particle with its own mean.
pub struct Shifted<'a> {
    deviation: &'a Gaussian,
    means: &'a [f64],
}

impl Conditional for Shifted<'_> {
    fn sample(&mut self, streams: &mut [Stream], states: &mut [f64], log_density: &mut [f64]) {
        let n = self.deviation.mean().len();
        with_scratch(n * LANES, |drawn| {
            with_noise(streams, n, log_density.len(), fill_standard_normal, |particles, noise| {
                let rows = particles.start * n..particles.end * n;
                load(&self.means[rows.clone()], n, drawn);
                self.deviation.tile_add_deviation(noise, drawn);
                store(drawn, n, &mut states[rows]);
                // log q follows from the noise that x was made of.
                let mut squares = [0.0; LANES];
                squared_norms(noise, &mut squares);
                for (log_density, square) in log_density[particles].iter_mut().zip(squares) {
                    *log_density = self.deviation.log_normalizer() - 0.5 * square;
                }
            });
        });
    }

    fn log_density(&mut self, states: &[f64], log_density: &mut [f64]) {
        let n = self.deviation.mean().len();
        with_scratch(2 * n * LANES, |scratch| {
            let (deviations, whitened) = scratch.split_at_mut(n * LANES);
            let rows = states.chunks(n * LANES).zip(self.means.chunks(n * LANES));
            for ((states, means), log_density) in rows.zip(log_density.chunks_mut(LANES)) {
                load(states, n, deviations);
                load(means, n, whitened);
                for (deviation, mean) in deviations.iter_mut().zip(whitened.iter()) {
                    *deviation -= mean;
                }
                self.deviation.tile_log_density(deviations, whitened, log_density);
            }
        });
    }
}
