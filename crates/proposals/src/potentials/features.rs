//! What the networks see of a step: its measurement, and what the model does and finds likely around the middle of all states.

use motes_models::batch::{LANES, load};
use motes_models::equations::NoiseSpace;
use motes_models::{OwnModel, Step};
use motes_smc::ProposalError;

/// Features stay within this many spreads: a network extrapolates badly.
const LARGEST: f64 = 10.0;

/// How many features there are of each entry of a measurement: its value, one that tells small values apart, and whether it is there.
const OF_ENTRY: usize = 3;

/// Where the model is asked beside the middle of all states, along each coordinate, in spreads of that.
const ALONG: [f64; 4] = [-2.0, -1.0, 1.0, 2.0];

/// How many points take no longer than the middle alone, the first of them, when a model is asked for derivatives.
const WITH_DERIVATIVES: usize = 8;

/// How many features there are of each coordinate of a state: where it goes without noise from the middle of all states, where points on either side go relative to that, how much
/// noise is added, and how likely the measurement is on either side.
const OF_COORDINATE: usize = 2 + 2 * ALONG.len();

/// How many features a step has; how likely the measurement is in the middle is one more.
pub(super) fn count(n: usize, m: usize) -> usize {
    OF_ENTRY * m + OF_COORDINATE * n + 1
}

/// What networks see of a step, and memory for it.
///
/// They see the model and not its parameters: a few states around the middle of all, where it moves them without noise, and how likely the measurement is there.
#[derive(Debug, Clone, Default)]
pub struct StepFeatures {
    /// The middle of all states, and on either side of it (`(4N + 1)×N`).
    points: Vec<f64>,
    /// Where they go, alike.
    images: Vec<f64>,
    /// What all sequences share.
    values: Vec<f64>,
    log_likelihoods: Vec<f64>,
    tile: TileMemory,
}

/// Some points side by side, as a model takes them.
#[derive(Debug, Clone, Default)]
struct TileMemory {
    previous: Vec<f64>,
    noise: Vec<f64>,
    states: Vec<f64>,
    jacobian: Vec<f64>,
}

fn within(value: f64) -> f64 {
    if value.is_finite() { value.clamp(-LARGEST, LARGEST) } else { 0.0 }
}

impl StepFeatures {
    /// Puts points around the middle of all states.
    fn place(&mut self, [middles, spreads]: &[Vec<f64>; 2]) {
        self.points.clear();
        self.points.extend_from_slice(middles);
        for (i, spread) in spreads.iter().enumerate() {
            for side in ALONG {
                self.points.extend_from_slice(middles);
                let at = self.points.len() - middles.len() + i;
                self.points[at] += side * spread;
            }
        }
    }

    /// Asks the model where it moves the points, or where it starts.
    pub(super) fn ask(&mut self, noise_space: &dyn NoiseSpace, step: &Step<'_>, state: &[Vec<f64>; 2]) {
        self.place(state);
        let [middles, spreads] = state;
        let StepFeatures { points, images, values, tile, .. } = self;
        let TileMemory { previous, noise, states, jacobian } = tile;
        let n = middles.len();
        let q = noise_space.draws(step).len();
        noise.clear();
        noise.resize(q * LANES, 0.0);
        previous.resize(n * LANES, 0.0);
        states.resize(n * LANES, 0.0);
        images.clear();
        jacobian.resize(n * q * LANES, 0.0);
        let (with_derivatives, others) = points.split_at(points.len().min(WITH_DERIVATIVES * n));
        for rows in [with_derivatives].into_iter().chain(others.chunks(n * LANES)) {
            let count = rows.len() / n;
            load(rows, n, previous);
            let before = (step.index > 0).then_some(previous.as_slice());
            match images.is_empty() {
                true => noise_space.tile_linearised(step, before, noise, count, states, jacobian),
                false => noise_space.tile_states(step, before, noise, states),
            }
            let of_state = |lane| (0..n).map(move |i| (lane, i));
            images.extend((0..count).flat_map(of_state).map(|(lane, i)| states[i * LANES + lane]));
        }
        values.clear();
        for i in 0..n {
            let of_noise = jacobian[i * q * LANES..][..q * LANES].iter().step_by(LANES);
            let size = of_noise.map(|entry| entry * entry).sum::<f64>().sqrt() / spreads[i];
            values.push(within((images[i] - middles[i]) / spreads[i]));
            values.push(within((size + 1e-3).ln()));
            let of_coordinate = (0..ALONG.len()).map(|side| images[(1 + i * ALONG.len() + side) * n + i]);
            values.extend(of_coordinate.map(|image| within((image - images[i]) / spreads[i])));
        }
    }

    /// Appends the features of the step that was asked for, of a sequence with this measurement (`M`).
    ///
    /// # Errors
    /// [`ProposalError::Measurement`] if the model cannot weigh it.
    pub(super) fn append<M: OwnModel + ?Sized>(
        &mut self,
        model: &M,
        step: &Step<'_>,
        measurement: &[Option<f64>],
        [middles, spreads]: &[Vec<f64>; 2],
        features: &mut Vec<f64>,
    ) -> Result<(), ProposalError> {
        for ((entry, middle), spread) in measurement.iter().zip(middles).zip(spreads) {
            let value = entry.map_or(0.0, |entry| (entry - middle) / spread);
            features.push(within(value));
            features.push(within((10.0 * value).asinh() / 3.0));
            features.push(f64::from(u8::from(entry.is_some())));
        }
        features.extend_from_slice(&self.values);
        let logs = &mut self.log_likelihoods;
        logs.resize(self.points.len() / model.state_dim(), 0.0);
        model
            .log_likelihoods(step, &self.points, measurement, logs)
            .map_err(|error| ProposalError::Measurement { time: step.index, reason: error.to_string() })?;
        let of = |log: &f64| if log.is_nan() { f64::NEG_INFINITY } else { log.min(f64::MAX) };
        let most = logs.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
        // Where no point is possible, none is likelier than another.
        let below = |log: f64| if most == log { 0.0 } else { ((most - log).asinh() / 3.0).min(LARGEST) };
        features.extend(logs.iter().map(of).map(below));
        Ok(())
    }
}
