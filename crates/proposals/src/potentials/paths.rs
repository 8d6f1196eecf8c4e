//! Sequences to learn from, in the units of the networks.

use motes_models::batch::{LANES, load};
use motes_models::equations::NoiseSpace;
use motes_models::{OwnModel, OwnStep};
use motes_smc::ProposalError;

use super::features::StepFeatures;
use super::standards::PotentialStandards;

/// Sequences that a model drew for itself, side by side, as networks learn from them.
#[derive(Debug, Clone, Default)]
pub struct PathBatch {
    /// `S`.
    pub(super) sequences: usize,
    /// `T`.
    pub(super) steps: usize,
    /// What networks see, `T×S×F`.
    pub(super) features: Vec<f64>,
    /// In spreads of the state: `x_t` (`T×S×N`), `g(x_{t−1}, 0)` (`T×S×N`), and `J Jᵀ` of its derivatives along the noise (`T×S×N×N`).
    pub(super) states: Vec<f64>,
    pub(super) centres: Vec<f64>,
    pub(super) spreads: Vec<f64>,
}

impl PathBatch {
    /// `S`, the number of sequences.
    pub fn sequences(&self) -> usize {
        self.sequences
    }

    /// `T`, the number of their steps.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// Sequences of several batches side by side; none if these have different numbers of steps.
    pub fn beside(batches: &[PathBatch]) -> Option<Self> {
        let steps = batches.first().map_or(0, PathBatch::steps);
        if batches.iter().any(|batch| batch.steps != steps) {
            return None;
        }
        let woven = |of: fn(&PathBatch) -> &Vec<f64>| -> Vec<f64> {
            let of_step = |step: usize, values: &'_ [f64]| {
                let width = values.len() / steps;
                step * width..(step + 1) * width
            };
            let at = |step: usize| batches.iter().flat_map(move |batch| &of(batch)[of_step(step, of(batch))]);
            (0..steps).flat_map(at).copied().collect()
        };
        Some(PathBatch {
            sequences: batches.iter().map(PathBatch::sequences).sum(),
            steps,
            features: woven(|batch| &batch.features),
            states: woven(|batch| &batch.states),
            centres: woven(|batch| &batch.centres),
            spreads: woven(|batch| &batch.spreads),
        })
    }

    /// Adds the next step of all sequences. `is_missing` says of each sequence whether its measurement is to be left out; the networks then do not see it.
    ///
    /// # Errors
    /// [`ProposalError::NoNoise`] for a model without a map of noise, and [`ProposalError::Measurement`] if it cannot weigh a measurement of its own.
    pub fn add<M: OwnModel + ?Sized>(
        &mut self,
        model: &M,
        step: &OwnStep<'_>,
        is_missing: impl Fn(usize) -> bool,
        standards: &PotentialStandards,
        features: &mut StepFeatures,
    ) -> Result<(), ProposalError> {
        let noise_space = model.noise_space().ok_or(ProposalError::NoNoise)?;
        let (n, m) = (model.state_dim(), model.measurement_dim());
        self.sequences = step.states.len() / n;
        self.steps += 1;
        features.ask(noise_space, &step.step, &standards.state);
        let mut entries = vec![None; m];
        for sequence in 0..self.sequences {
            let row = &step.measurements[sequence * m..][..m];
            let is_missing = is_missing(sequence);
            entries.iter_mut().zip(row).for_each(|(entry, value)| *entry = (!is_missing).then_some(*value));
            features.append(model, &step.step, &entries, &standards.measurement, &mut self.features)?;
        }
        let [middles, scales] = &standards.state;
        for row in step.states.chunks_exact(n) {
            self.states.extend(row.iter().zip(middles).zip(scales).map(|((x, middle), s)| (x - middle) / s));
        }
        self.add_maps(noise_space, step, n, standards);
        Ok(())
    }

    /// The map of noise of each sequence, linearised where there is none.
    fn add_maps(
        &mut self,
        noise_space: &dyn NoiseSpace,
        step: &OwnStep<'_>,
        n: usize,
        PotentialStandards { state: [middles, scales], .. }: &PotentialStandards,
    ) {
        let q = noise_space.draws(&step.step).len();
        let (noise, mut previous) = (vec![0.0; q * LANES], vec![0.0; n * LANES]);
        let (mut states, mut jacobian) = (vec![0.0; n * LANES], vec![0.0; n * q * LANES]);
        for first in (0..self.sequences).step_by(LANES) {
            let count = LANES.min(self.sequences - first);
            let before = step.previous.map(|rows| {
                load(&rows[first * n..(first + count) * n], n, &mut previous);
                previous.as_slice()
            });
            noise_space.tile_linearised(&step.step, before, &noise, count, &mut states, &mut jacobian);
            for lane in 0..count {
                for i in 0..n {
                    self.centres.push((states[i * LANES + lane] - middles[i]) / scales[i]);
                }
                let entry = |i: usize, k: usize| {
                    let entry = jacobian[(i * q + k) * LANES + lane] / scales[i];
                    if entry.is_finite() { entry } else { 0.0 }
                };
                for i in 0..n {
                    for j in 0..n {
                        self.spreads.push((0..q).map(|k| entry(i, k) * entry(j, k)).sum());
                    }
                }
            }
        }
    }
}
