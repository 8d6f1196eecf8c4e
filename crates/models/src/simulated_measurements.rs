//! Measurements without end, each sequence drawn when it is asked for.

use rand::Rng;

use crate::{Measurements, ModelError, Seed, Simulator, Stream, simulate_within};

/// Where sequences of measurements come from, one after another.
///
/// What learns takes one of these: it gets measurements, and never the states behind them.
pub trait MeasurementSource {
    /// Draws the next sequence. The same position in the same stream gives the same one.
    ///
    /// # Errors
    /// [`ModelError`] if there is none to be had.
    fn draw(&self, stream: &mut Stream) -> Result<Measurements, ModelError>;
}

/// What is measured in simulations of a model, each of them new. The states are forgotten before anybody sees them.
///
/// ```
/// use faer::mat;
/// use motes_models::{Gaussian, LinearGaussian, MeasurementSource, Seed, SimulatedMeasurements};
///
/// let start = Gaussian::new("P_0", vec![0.0], mat![[1.0]])?;
/// let model = LinearGaussian::new(start, mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[1.0]])?;
/// let source = SimulatedMeasurements::new(&model, 50, 1e6);
/// let mut stream = Seed::from_u64(1).stream();
/// let (first, second) = (source.draw(&mut stream)?, source.draw(&mut stream)?);
/// assert_eq!((first.len(), second.len()), (50, 50));
/// assert_ne!(first, second);
/// # Ok::<(), motes_models::ModelError>(())
/// ```
#[derive(Clone, Copy)]
pub struct SimulatedMeasurements<'a> {
    model: &'a dyn Simulator,
    horizon: usize,
    largest_state: f64,
}

impl<'a> SimulatedMeasurements<'a> {
    /// Sequences of `horizon` times. A simulation with a state coordinate beyond `largest_state` in size is drawn again, as one that overflows.
    pub fn new(model: &'a dyn Simulator, horizon: usize, largest_state: f64) -> Self {
        SimulatedMeasurements { model, horizon, largest_state }
    }
}

impl MeasurementSource for SimulatedMeasurements<'_> {
    /// # Errors
    /// Those of [`simulate_within`].
    fn draw(&self, stream: &mut Stream) -> Result<Measurements, ModelError> {
        let seed = Seed::from_u64(stream.next_u64());
        let (trajectory, _) = simulate_within(self.model, self.horizon, self.largest_state, &seed)?;
        Ok(trajectory.measurements)
    }
}
