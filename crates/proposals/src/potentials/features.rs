//! What the networks see of a step: its measurement, and where the model moves a state in the middle.

use motes_models::batch::{LANES, load};
use motes_models::equations::NoiseSpace;
use motes_models::{OwnModel, OwnStep, Step};

use super::standards::PotentialStandards;

/// Features stay within this many spreads: a network extrapolates badly.
const LARGEST: f64 = 10.0;

/// How many features there are of each entry of a measurement: its value, one that tells small values apart, and whether it is there.
const OF_ENTRY: usize = 3;

/// How many there are of each coordinate of a state: where it goes without noise from the middle of all states, and how much noise is added.
const OF_COORDINATE: usize = 2;

/// How many features a step has.
pub(super) fn count(n: usize, m: usize) -> usize {
    OF_ENTRY * m + OF_COORDINATE * n
}

/// The features of a step that are the same for all sequences.
#[derive(Debug, Clone, Default)]
pub struct StepFeatures {
    values: Vec<f64>,
    noise: Vec<f64>,
    previous: Vec<f64>,
    states: Vec<f64>,
    jacobian: Vec<f64>,
}

fn within(value: f64) -> f64 {
    if value.is_finite() { value.clamp(-LARGEST, LARGEST) } else { 0.0 }
}

impl StepFeatures {
    /// Asks the model where it moves the middle of all states, or where it starts; two numbers for each of `N` coordinates.
    fn ask(&mut self, noise_space: &dyn NoiseSpace, step: &Step<'_>, [middles, spreads]: &[Vec<f64>; 2]) {
        let StepFeatures { values, noise, previous, states, jacobian } = self;
        let n = middles.len();
        let q = noise_space.draws(step).len();
        noise.clear();
        noise.resize(q * LANES, 0.0);
        previous.clear();
        previous.extend(middles.iter().flat_map(|middle| [*middle; LANES]));
        states.resize(n * LANES, 0.0);
        jacobian.clear();
        jacobian.resize(n * q * LANES, 0.0);
        let before = (step.index > 0).then_some(previous.as_slice());
        noise_space.tile_linearised(step, before, noise, 1, states, jacobian);
        values.clear();
        for i in 0..n {
            let of_noise = jacobian[i * q * LANES..][..q * LANES].iter().step_by(LANES);
            let size = of_noise.map(|entry| entry * entry).sum::<f64>().sqrt() / spreads[i];
            values.push(within((states[i * LANES] - middles[i]) / spreads[i]));
            values.push(within((size + 1e-3).ln()));
        }
    }

    /// Appends the features of a step of a sequence with this measurement (`M`).
    fn append(
        &self,
        measurement: &[Option<f64>],
        [middles, spreads]: &[Vec<f64>; 2],
        features: &mut Vec<f64>,
    ) {
        for ((entry, middle), spread) in measurement.iter().zip(middles).zip(spreads) {
            let value = entry.map_or(0.0, |entry| (entry - middle) / spread);
            features.push(within(value));
            features.push(within((10.0 * value).asinh() / 3.0));
            features.push(f64::from(u8::from(entry.is_some())));
        }
        features.extend_from_slice(&self.values);
    }

    /// Appends the features of a step, for a sequence that is recorded.
    pub(super) fn of_recorded(
        &mut self,
        noise_space: &dyn NoiseSpace,
        step: &Step<'_>,
        measurement: &[Option<f64>],
        standards: &PotentialStandards,
        features: &mut Vec<f64>,
    ) {
        self.ask(noise_space, step, &standards.state);
        self.append(measurement, &standards.measurement, features);
    }
}

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

    /// Adds the next step of all sequences. `is_missing` says of each sequence whether its measurement is to be left out; the networks then do not see it.
    ///
    /// Nothing is added of a model without a map of noise.
    pub fn add<M: OwnModel + ?Sized>(
        &mut self,
        model: &M,
        step: &OwnStep<'_>,
        is_missing: impl Fn(usize) -> bool,
        standards: &PotentialStandards,
        features: &mut StepFeatures,
    ) {
        let Some(noise_space) = model.noise_space() else { return };
        let (n, m) = (model.state_dim(), model.measurement_dim());
        self.sequences = step.states.len() / n;
        self.steps += 1;
        features.ask(noise_space, &step.step, &standards.state);
        let mut entries = vec![None; m];
        for sequence in 0..self.sequences {
            let row = &step.measurements[sequence * m..][..m];
            let is_missing = is_missing(sequence);
            entries.iter_mut().zip(row).for_each(|(entry, value)| *entry = (!is_missing).then_some(*value));
            features.append(&entries, &standards.measurement, &mut self.features);
        }
        let [middles, scales] = &standards.state;
        for row in step.states.chunks_exact(n) {
            self.states.extend(row.iter().zip(middles).zip(scales).map(|((x, middle), s)| (x - middle) / s));
        }
        self.add_maps(noise_space, step, n, standards);
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
