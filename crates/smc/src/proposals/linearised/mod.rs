//! The linearised proposal: one Fisher-scoring step from the predicted state.

mod condition;
mod conditional;
mod factor;

use motes_models::equations::Linearise;
use motes_models::{ModelError, Seed, Simulator, check_dimensions};

pub use condition::LinearisedScratch;
pub use conditional::LinearisedBatch;

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
/// - It also works for counts and heavy tails, whose Fisher information is finite.
/// - An entry that says nothing finite at a particle's `m` is left out for that particle.
/// - Where no location depends on the state, it is the transition, and [`Linearised::sees_measurements`] says so.
/// - A measurement with gaps is used as far as it is there.
#[derive(Debug, Clone)]
pub struct Linearised {
    sees_measurements: bool,
    /// `y_t` of the step that it was prepared for.
    measurement: Vec<Option<f64>>,
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
        check_dimensions(model)?;
        // States that are likely, from a stream of their own: the same model gets the same answer.
        let mut stream = Seed::from_u64(0).child("linearised").stream();
        let (n, m) = (model.state_dim(), model.measurement_dim());
        let (mut state, mut measurement) = (vec![0.0; n], vec![0.0; m]);
        let mut sees_measurements = false;
        for time in 0..PROBES {
            let previous = state.clone();
            match time {
                0 => model.sample_initial(&mut stream, &mut state),
                _ => model.sample_transition(time, &previous, &mut stream, &mut state),
            }
            model.sample_measurement(time, &state, &mut stream, &mut measurement);
            sees_measurements |= condition::depends_on_state(model, time, &state, &measurement);
        }
        Ok(Linearised { sees_measurements, measurement: Vec::new(), prepared: None })
    }

    /// Whether a measurement's location depends on the state. If not, this is the bootstrap proposal.
    pub fn sees_measurements(&self) -> bool {
        self.sees_measurements
    }
}
