//! The minimum-degeneracy proposal in closed form.

use motes_models::batch::{LANES, TileMatrix, load, particles_by_stream, squared_norms, store, with_scratch};
use motes_models::{AdditiveGaussian, Gaussian, ModelError, Stream, fill_standard_normal, kalman};

use faer::{Mat, MatRef};

use crate::{Conditional, Past, Proposal, ProposalError, RowProposal};

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

/// `f(x_{t−1})` of up to a tile of previous states, or the mean of `x_0`; `tile` is scratch.
fn predict<M: AdditiveGaussian + ?Sized>(
    model: &M,
    past: &Past<'_>,
    first: usize,
    particles: usize,
    tile: &mut [f64],
    predicted: &mut [f64],
) {
    match past.previous {
        None => spread(model.initial().mean(), predicted),
        Some(previous) => {
            let n = model.state_dim();
            load(&previous[first * n..(first + particles) * n], n, tile);
            model.tile_transition_means(past.time, tile, particles, predicted);
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
        with_scratch(2 * n * LANES, |scratch| {
            let (tile, predicted) = scratch.split_at_mut(n * LANES);
            for (at, means) in means.chunks_mut(n * LANES).enumerate() {
                let particles = means.len() / n;
                predict(model, &past, at * LANES, particles, tile, predicted);
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
        past: Past<'_>,
        streams: &mut [Stream],
        states: &mut [f64],
        increments: &mut [f64],
    ) {
        let correction = self.at(past.time);
        let (n, m) = correction.gain.shape();
        for (stream, states) in particles_by_stream(streams, states, n, past.particles) {
            fill_standard_normal(stream, states);
        }
        with_scratch((3 * n + 2 * m) * LANES, |scratch| {
            let (tile, rest) = scratch.split_at_mut(n * LANES);
            let (predicted, rest) = rest.split_at_mut(n * LANES);
            let (drawn, rest) = rest.split_at_mut(n * LANES);
            let (residuals, whitened) = rest.split_at_mut(m * LANES);
            let parts = states.chunks_mut(n * LANES).zip(increments.chunks_mut(LANES));
            for (at, (states, increments)) in parts.enumerate() {
                let particles = increments.len();
                predict(model, &past, at * LANES, particles, tile, predicted);
                correction.correct(predicted, drawn);
                load(states, n, tile);
                correction.posterior.tile_add_deviation(tile, drawn);
                store(drawn, n, states);
                if model.is_gaussian() {
                    // By Bayes' rule p(y|x) p(x|x') / q(x|x',y) is p(y|x'), whatever x was drawn.
                    spread(past.measurement, residuals);
                    correction.measurement_matrix.times_subtract(predicted, residuals);
                    correction.innovation.tile_log_density(residuals, whitened, increments);
                } else {
                    // log q follows from the noise that x was made of.
                    let mut squares = [0.0; LANES];
                    squared_norms(tile, &mut squares);
                    for (increment, square) in increments.iter_mut().zip(squares) {
                        *increment = 0.5 * square - correction.posterior.log_normalizer();
                    }
                }
            }
        });
        if !model.is_gaussian() {
            with_scratch(past.particles, |terms| {
                let mut add = |terms: &[f64]| {
                    increments.iter_mut().zip(terms).for_each(|(increment, term)| *increment += term);
                };
                model.log_likelihoods(past.time, states, past.measurement, terms);
                add(terms);
                match past.previous {
                    None => model.log_initials(states, terms),
                    Some(previous) => model.log_transitions(past.time, previous, states, terms),
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
        for (stream, states) in particles_by_stream(streams, states, n, log_density.len()) {
            fill_standard_normal(stream, states);
        }
        with_scratch(2 * n * LANES, |scratch| {
            let (noise, drawn) = scratch.split_at_mut(n * LANES);
            let rows = states.chunks_mut(n * LANES).zip(self.means.chunks(n * LANES));
            for ((states, means), log_density) in rows.zip(log_density.chunks_mut(LANES)) {
                load(states, n, noise);
                load(means, n, drawn);
                self.deviation.tile_add_deviation(noise, drawn);
                store(drawn, n, states);
                // log q follows from the noise that x was made of.
                let mut squares = [0.0; LANES];
                squared_norms(noise, &mut squares);
                for (log_density, square) in log_density.iter_mut().zip(squares) {
                    *log_density = self.deviation.log_normalizer() - 0.5 * square;
                }
            }
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
