//! Whether a measurement is one that the model could have made from where the particles are.

use std::slice::from_mut;

use motes_models::{ModelError, Simulator, Step, Stream};
use rand::RngExt;
use serde::{Deserialize, Serialize};

use crate::weights::LogWeights;

/// Measurements that are drawn to see what is usual.
const DRAWS: usize = 100;

/// After so many draws that are no likelier than the measurement at the heaviest particle, the measurement is a usual one.
const NO_LIKELIER: usize = 3;

/// A measurement is deep by as many times one nat and one standard deviation as its log-density at the best particle is below the usual one, less these.
const USUAL_DEPTH: f64 = 0.5;

/// Depths of so many consecutive steps are added up: several measurements on the same side say what one alone does not.
const STEPS: usize = 5;

/// The sum from which on measurements lie beyond all particles.
const BEYOND: f64 = 4.5;

/// A measurement that is less likely at all particles than those that the model draws from them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Surprise {
    pub(super) step: usize,
    /// The largest `log p(y_t | x_t)` of a particle.
    pub(super) best: f64,
    /// The mean of `log p(y' | x_t)` over `y'` that the model draws from the particles.
    pub(super) usual: f64,
    depth: f64,
}

/// The measurements so far that no particle explains, and the worst of them.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Surprises {
    pub(super) count: usize,
    pub(super) worst: Option<Surprise>,
    /// The deep measurements of the last steps that are not among these.
    recent: Vec<Surprise>,
    #[serde(skip)]
    log_likelihoods: Vec<f64>,
}

impl Surprises {
    /// Looks at a measurement (`M` entries, some of which may be missing) from particles (`K×N`) with these weights.
    ///
    /// # Errors
    /// [`ModelError`] if densities of measurements with gaps cannot be had.
    pub(super) fn step(
        &mut self,
        model: &(impl Simulator + ?Sized),
        step: &Step<'_>,
        (particles, weights): (&[f64], &LogWeights),
        measurement: &[Option<f64>],
        stream: &mut Stream,
    ) -> Result<(), ModelError> {
        if measurement.iter().all(Option::is_none) {
            return Ok(());
        }
        let (width, mut density) = (model.state_dim(), [0.0]);
        let state = |particle: usize| &particles[particle * width..(particle + 1) * width];
        let by_weight = |a: &usize, b: &usize| weights.log()[*a].total_cmp(&weights.log()[*b]);
        let heaviest = (0..weights.len()).max_by(by_weight).unwrap_or_default();
        model.log_likelihoods(step, state(heaviest), measurement, &mut density)?;
        let at_heaviest = density[0];
        let (mut drawn, mut there) = (vec![0.0; measurement.len()], Vec::with_capacity(measurement.len()));
        let mut of_draws = [0.0; DRAWS];
        let (mut particle, mut reached) = (0, weights.normalised()[0]);
        let mut no_likelier = 0;
        let offset: f64 = stream.random();
        for (number, of_draw) in of_draws.iter_mut().enumerate() {
            let point = (number as f64 + offset) / DRAWS as f64;
            while reached < point && particle + 1 < weights.len() {
                particle += 1;
                reached += weights.normalised()[particle];
            }
            model.sample_measurements(step, state(particle), from_mut(&mut *stream), &mut drawn);
            there.clear();
            there.extend(measurement.iter().zip(&drawn).map(|(there, drawn)| there.map(|_| *drawn)));
            model.log_likelihoods(step, state(particle), &there, &mut density)?;
            // Most measurements are usual ones, and found to be after a few draws.
            no_likelier += usize::from(density[0] <= at_heaviest);
            if no_likelier == NO_LIKELIER {
                return Ok(());
            }
            *of_draw = density[0];
        }
        self.log_likelihoods.resize(weights.len(), 0.0);
        model.log_likelihoods(step, particles, measurement, &mut self.log_likelihoods)?;
        let best = self.log_likelihoods.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let usual = of_draws.iter().sum::<f64>() / DRAWS as f64;
        let variance = of_draws.iter().map(|log| (log - usual).powi(2)).sum::<f64>() / (DRAWS - 1) as f64;
        let depth = (usual - best) / (1.0 + variance.sqrt()) - USUAL_DEPTH;
        if depth > 0.0 {
            self.take_in(Surprise { step: step.index, best, usual, depth });
        }
        Ok(())
    }

    /// Adds up the depths of the last steps; from a sum that is too large on, all of them are surprises.
    fn take_in(&mut self, deep: Surprise) {
        self.recent.retain(|before| before.step + STEPS > deep.step);
        self.recent.push(deep);
        if self.recent.iter().map(|one| one.depth).sum::<f64>() <= BEYOND {
            return;
        }
        self.count += self.recent.len();
        let all = self.recent.drain(..).chain(self.worst);
        self.worst = all.max_by(|a, b| (a.usual - a.best).total_cmp(&(b.usual - b.best)));
    }
}
