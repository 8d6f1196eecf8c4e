//! Filters whose particles have parameters of their own that are perturbed at each row, as iterated filtering takes them.

use std::ops::ControlFlow;

use motes_models::batch::Rows;
use motes_models::{ModelError, Seed, StateSpaceModel, Stream};

use crate::look_ahead::RecordedStep;
use crate::resampling::Resampling;
use crate::weights::{LogWeights, WeightFault};

/// What perturbs positions (`K×D`) before the step of that number, or says to stop.
pub type Perturbation<'p> = dyn FnMut(usize, &mut [f64]) -> ControlFlow<()> + 'p;

/// A bootstrap filter of a recorded sequence whose particles have parameters of their own, which are perturbed from row to row (Ionides, Nguyen, Atchadé, Stoev and King, 2015).
///
/// Parameters are made of positions in `ℝᴰ`, and it is these that are perturbed. A particle that explains the data is resampled with its parameters, so that a swarm of them goes uphill.
pub struct PerturbedFilter<'a> {
    /// The model, whose states (`N`) end with the `D` parameters. `x_0` is made by a step of index 0 from rows that end with them.
    pub model: &'a dyn StateSpaceModel,
    /// The sequence.
    pub steps: &'a [RecordedStep],
    /// `D`.
    pub dimension: usize,
    /// Writes the parameters (`K×D`) of positions (`K×D`).
    pub parameters: &'a (dyn Fn(&[f64], &mut [f64]) + Sync),
}

impl PerturbedFilter<'_> {
    /// Takes a swarm of positions (`K×D`) through the sequence. `perturb` is given the number of each step and the positions before it. What is returned is the
    /// log-evidence of the perturbed model, −∞ where no particle explains a row, after which all go on; none where `perturb` said to stop.
    ///
    /// # Errors
    /// [`ModelError`] if a measurement cannot be weighed.
    ///
    /// # Panics
    /// If the swarm has not `D` numbers for each of one particle or more.
    pub fn pass(
        &self,
        positions: &mut [f64],
        perturb: &mut Perturbation<'_>,
        seed: &Seed,
    ) -> Result<Option<f64>, ModelError> {
        let (d, n) = (self.dimension, self.model.state_dim());
        assert!(!positions.is_empty() && positions.len().is_multiple_of(d), "{d} numbers for each particle");
        let particles = positions.len() / d;
        let mut swarm = Swarm::new(particles, [n, d]);
        let mut streams = [seed.child("states").stream()];
        let mut resampling = seed.child("ancestors").stream();
        let mut increments = vec![0.0; particles];
        let mut log_evidence = 0.0;
        for (row, RecordedStep { step, measurement }) in self.steps.iter().enumerate() {
            swarm.resample(positions, &mut resampling);
            if perturb(row, positions).is_break() {
                return Ok(None);
            }
            (self.parameters)(positions, &mut swarm.parameters);
            swarm.write_parameters();
            let step = step.step();
            let before = Rows::all(&swarm.states, n);
            self.model.sample_states(&step, Some(before), &mut streams, &mut swarm.next);
            std::mem::swap(&mut swarm.states, &mut swarm.next);
            if measurement.iter().any(Option::is_some) {
                self.model.log_likelihoods(&step, &swarm.states, measurement, &mut increments)?;
                // At parameters that make no number of it the data are impossible.
                let impossible = increments.iter_mut().filter(|value| value.is_nan());
                impossible.for_each(|value| *value = f64::NEG_INFINITY);
                log_evidence += swarm.weigh(&increments);
            }
        }
        swarm.resample(positions, &mut resampling);
        Ok(Some(log_evidence))
    }
}

/// The particles of a pass.
struct Swarm {
    dimensions: [usize; 2],
    /// `K×N`, those of the row before where a step begins.
    states: Vec<f64>,
    /// `K×N`.
    next: Vec<f64>,
    /// `K×D`.
    parameters: Vec<f64>,
    weights: LogWeights,
    is_weighed: bool,
    ancestors: Vec<usize>,
    moved: Vec<f64>,
}

impl Swarm {
    fn new(particles: usize, [n, d]: [usize; 2]) -> Self {
        Swarm {
            dimensions: [n, d],
            states: vec![0.0; particles * n],
            next: vec![0.0; particles * n],
            parameters: vec![0.0; particles * d],
            weights: LogWeights::uniform(particles),
            is_weighed: false,
            ancestors: vec![0; particles],
            moved: vec![0.0; particles * d],
        }
    }

    /// Multiplies weights by likelihoods; where none is left, all are equal, and the sum is −∞.
    fn weigh(&mut self, increments: &[f64]) -> f64 {
        self.is_weighed = true;
        match self.weights.update(increments) {
            Ok(sum) => sum,
            Err(WeightFault::AllZero | WeightFault::NotANumber { .. }) => {
                self.weights = LogWeights::uniform(self.ancestors.len());
                self.is_weighed = false;
                f64::NEG_INFINITY
            }
        }
    }

    /// Draws ancestors, with their positions; nothing where weights are equal.
    fn resample(&mut self, positions: &mut [f64], stream: &mut Stream) {
        if !std::mem::take(&mut self.is_weighed) {
            return;
        }
        let [n, d] = self.dimensions;
        Resampling::Systematic.draw(self.weights.normalised(), stream, &mut self.ancestors);
        self.weights.reset();
        for (particle, ancestor) in self.ancestors.iter().enumerate() {
            self.next[particle * n..][..n].copy_from_slice(&self.states[ancestor * n..][..n]);
            self.moved[particle * d..][..d].copy_from_slice(&positions[ancestor * d..][..d]);
        }
        std::mem::swap(&mut self.states, &mut self.next);
        positions.copy_from_slice(&self.moved);
    }

    /// Writes parameters to the ends of rows.
    fn write_parameters(&mut self) {
        let [n, d] = self.dimensions;
        let rows = self.states.chunks_exact_mut(n).zip(self.parameters.chunks_exact(d));
        rows.for_each(|(row, parameters)| row[n - d..].copy_from_slice(parameters));
    }
}
