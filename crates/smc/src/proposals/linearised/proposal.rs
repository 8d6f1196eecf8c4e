//! The proposal itself: prepared by a measurement, conditioned block by block.

use std::slice::from_mut;

use motes_models::batch::{LANES, Rows, by_widest_vectors};
use motes_models::equations::{Lanes, Linearise};
use motes_models::{ModelError, Seed, Simulator, Step, check_model};

use super::batch::{LinearisedBatch, Of};
use super::noise::NoiseBatch;
use super::scoring::{depends_on_noise, depends_on_state, score};
use super::scratch::{LinearisedScratch, lanes};
use crate::proposal::{Context, Proposal};
use crate::proposal_error::ProposalError;
use crate::proposals::noise_share::noise_share;

/// `q(x_t | x_{t−1}, y_t) = N(m + Λ⁻¹ g, Λ⁻¹)`: a Gaussian by one Fisher-scoring step from the predicted state.
///
/// With `m` and `P` the mean and the variances of `p(x_t | x_{t−1})`, and for each entry of the measurement `J_j = ∂θ_j/∂x_t`, the slope `s_j = ∂ log p(y_j | θ_j)/∂θ_j`
/// and the Fisher information `I_j` of its location `θ_j`, all at `m`:
///
/// - `Λ = P⁻¹ + Σ_j I_j J_j J_jᵀ`
/// - `g = Σ_j s_j J_j`
///
/// Where noise is Gaussian this is a step of the extended Kalman filter. Where the measurement is linear in `x_t` too, with constant noise, it is the
/// optimal proposal `p(x_t | x_{t−1}, y_t)`.
///
/// - It also works for counts and heavy tails, whose Fisher information is finite. Far out in a heavy tail `I_j` is smaller ([`Score`](motes_models::equations::Score)).
/// - An entry that says nothing finite at a particle's `m` is left out for that particle.
/// - Where no location depends on the state (or, below, on the noise of the step), it is the transition, and [`Linearised::sees_measurements`] says so.
/// - A measurement with gaps is used as far as it is there.
/// - Of a model whose states have no density it is the same of the noise `v_t ~ N(0, I)` that states are made of ([`NoiseSpace`](motes_models::equations::NoiseSpace)):
///   `m = 0`, `P = I`, `J_j = ∂θ_j/∂v_t`, and a draw that is not normal is taken to be `mean + sd·v`. Particles weigh `p(y_t | x_t) N(v_t; 0, I) / q(v_t)`. Where some draws
///   are not normal, `q` has a share of 0.1 of `N(0, I)` unless the filter says another ([`noise_share`](crate::noise_share)).
#[derive(Debug, Clone)]
pub struct Linearised {
    sees_measurements: bool,
    /// What is Gaussian in the step that it was prepared for.
    of: Of,
    /// `y_t` of the step that it was prepared for, the same for all particles of a tile.
    measurement: Vec<Option<Lanes>>,
    prepared: Option<usize>,
}

/// States at which it is looked whether a location depends on them.
const PROBES: usize = 4;

impl Linearised {
    /// The proposal for `model`.
    ///
    /// # Errors
    /// [`ModelError::Parameter`] if the model has no states or no measurements.
    pub fn new(model: &(impl Linearise + Simulator + ?Sized)) -> Result<Self, ModelError> {
        check_model(model)?;
        // States that are likely, from a stream of their own: the same model gets the same answer.
        let mut stream = Seed::from_u64(0).child("linearised").stream();
        let (n, m) = (model.state_dim(), model.measurement_dim());
        let (mut state, mut measurement) = (vec![0.0; n], vec![0.0; m]);
        let mut sees_measurements = false;
        let noise = model.noise_without_density();
        for step in (0..PROBES).map(|index| model.step_of_index(index)) {
            let before = state.clone();
            let previous = (step.index > 0).then(|| Rows::all(&before, n));
            model.sample_states(&step, previous, from_mut(&mut stream), &mut state);
            model.sample_measurements(&step, &state, from_mut(&mut stream), &mut measurement);
            // Where the model does not know its inputs, it may.
            sees_measurements |= state.iter().any(|value| value.is_nan());
            sees_measurements |= match noise {
                None => depends_on_state(model, &step, &state, &measurement),
                Some(noise) => {
                    let draws = noise.draws(&step).len();
                    let previous = (step.index > 0).then_some(before.as_slice());
                    depends_on_noise(noise, &step, previous, draws, &measurement)
                }
            };
        }
        Ok(Linearised { sees_measurements, of: Of::Transition, measurement: Vec::new(), prepared: None })
    }

    /// What is Gaussian in a step.
    fn gaussians_of(&self, model: &(impl Linearise + ?Sized), step: &Step<'_>) -> Of {
        match model.noise_without_density() {
            _ if !self.sees_measurements => Of::Transition,
            None => Of::States,
            Some(noise) => {
                let draws = noise.draws(step);
                match draws.len() {
                    0 => Of::Transition,
                    count => Of::Noise { draws: count, share: noise_share(&draws) },
                }
            }
        }
    }

    /// Whether a measurement's location depends on the state, or on the noise that is drawn. If not, this is the bootstrap proposal.
    pub fn sees_measurements(&self) -> bool {
        self.sees_measurements
    }
}

impl<M: Linearise + ?Sized> Proposal<M> for Linearised {
    type Memory = ();
    type Scratch = LinearisedScratch;
    type Conditional<'a>
        = LinearisedBatch<'a, M>
    where
        M: 'a;

    fn initial_memory(&self, _particles: usize) {}

    fn prepare(
        &mut self,
        model: &M,
        step: &Step<'_>,
        measurement: &[Option<f64>],
    ) -> Result<bool, ProposalError> {
        ProposalError::unless_same(
            "the measurement dimension M",
            model.measurement_dim(),
            measurement.len(),
        )?;
        self.measurement.clear();
        self.measurement.extend(measurement.iter().map(|entry| entry.map(Lanes::from)));
        self.prepared = Some(step.index);
        self.of = self.gaussians_of(model, step);
        Ok(measurement.iter().any(Option::is_some))
    }

    fn condition<'a>(
        &'a self,
        model: &'a M,
        context: Context<'a>,
        (): (),
        scratch: &'a mut LinearisedScratch,
    ) -> Result<LinearisedBatch<'a, M>, ProposalError> {
        let step = context.step;
        if self.prepared != Some(step.index) {
            return Err(ProposalError::NotPrepared { time: step.index });
        }
        let of = self.of;
        if let (Of::Noise { draws, .. }, Some(noise)) = (of, model.noise_space()) {
            NoiseBatch { model: noise, context, states: model.state_dim(), draws, scratch: &mut *scratch }
                .condition(&self.measurement);
        }
        let (n, m) = (model.state_dim(), self.measurement.len());
        let (tiles, triangle) = (context.particles.div_ceil(LANES), n * (n + 1) / 2);
        if of == Of::States {
            let LinearisedScratch { means, factors, tile, .. } = &mut *scratch;
            means.resize(tiles * n * LANES, 0.0);
            factors.resize(tiles * triangle * LANES, 0.0);
            // Lanes without a particle are computed, too: with numbers that are no danger.
            tile.clear();
            tile.resize((2 * n + (2 + n) * m) * LANES, 0.0);
            let (previous, rest) = tile.split_at_mut(n * LANES);
            let (variances, rest) = rest.split_at_mut(n * LANES);
            let (slopes, rest) = rest.split_at_mut(m * LANES);
            let (information, jacobian) = rest.split_at_mut(m * LANES);
            if let Some(previous) = context.previous {
                model.foresee(&step, previous);
            }
            let places = means.chunks_exact_mut(n * LANES).zip(factors.chunks_exact_mut(triangle * LANES));
            for (number, (mean, lower)) in places.enumerate() {
                let before = context.previous.map(|rows| {
                    rows.load(number * LANES, previous);
                    &*previous
                });
                model.tile_moments(&step, before, mean, variances);
                model.tile_scores(&step, mean, &self.measurement, slopes, information, jacobian);
                by_widest_vectors(
                    #[inline(always)]
                    || {
                        score(
                            lanes(mean),
                            lanes(variances),
                            lanes(slopes),
                            lanes(information),
                            lanes(jacobian),
                            lanes(lower),
                        );
                    },
                );
            }
        }
        Ok(LinearisedBatch { model, context, scratch, of })
    }
}
