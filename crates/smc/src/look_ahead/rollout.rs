//! Paths moved by several shares of a policy at once, and the best of them.

use motes_models::batch::{LANES, store};
use motes_models::equations::NoiseSpace;
use motes_models::{ModelError, StateSpaceModel};

use super::path::{Path, Policy};
use super::recorded::RecordedStep;

/// The shares `α` of a move that are tried side by side. The last is the path itself, if the model leads through it.
pub(super) const SHARES: [f64; 8] = [1.0, 0.7, 0.4, 0.2, 0.1, 0.03, 0.003, 0.0];

/// A path that was moved.
pub(super) struct Rollout {
    /// The path, through which the model leads.
    pub(super) path: Path,
    /// `Σ_t log p(y_t | x_t) − ½ |v_t|²` along it; −∞ where no share leads to a number.
    pub(super) objective: f64,
    /// The root mean square of what the whole move changes noise by, whose standard deviation is 1.
    pub(super) change: f64,
}

/// Moves a path by each share of a policy, forwards through the model, and keeps the best.
///
/// # Errors
/// [`ModelError`] if the density of a measurement cannot be had.
pub(super) fn roll<M: StateSpaceModel + ?Sized>(
    model: &M,
    noise_space: &dyn NoiseSpace,
    recorded: &[RecordedStep],
    path: &Path,
    policy: &Policy,
) -> Result<Rollout, ModelError> {
    const COUNT: usize = SHARES.len();
    let n = path.width;
    let most = path.starts.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or(0);
    let [mut before, mut now] = [const { Vec::new() }; 2].map(|_: Vec<f64>| vec![0.0; n * LANES]);
    let (mut noise, mut rows) = (vec![0.0; most * LANES], vec![0.0; COUNT * n]);
    let (mut objectives, mut likelihoods) = ([0.0; COUNT], [0.0; COUNT]);
    let mut squared_change = 0.0;
    let mut states = vec![[0.0; COUNT]; path.len() * n];
    let mut noises = vec![[0.0; COUNT]; path.noise.len()];
    for (index, RecordedStep { step, measurement }) in recorded.iter().enumerate() {
        let (begin, old) = (path.starts[index], path.noise(index));
        let q = old.len();
        for (k, old) in old.iter().enumerate() {
            let (moved, feedback) = (policy.moves[begin + k], &policy.feedback[(begin + k) * n..][..n]);
            for (lane, share) in SHARES.iter().enumerate() {
                let mut v = old + share * moved;
                if let Some(previous) = path.previous(index) {
                    for ((gain, previous), x) in
                        feedback.iter().zip(previous).zip(before.iter().skip(lane).step_by(LANES))
                    {
                        v -= gain * (x - previous);
                    }
                }
                noise[k * LANES + lane] = v;
                noises[begin + k][lane] = v;
                objectives[lane] -= 0.5 * v * v;
            }
            squared_change += (noises[begin + k][0] - old).powi(2);
        }
        let (step, previous) = (step.step(), (index > 0).then_some(before.as_slice()));
        noise_space.tile_linearised(&step, previous, &noise[..q * LANES], COUNT, &mut now, &mut []);
        for i in 0..n {
            states[index * n + i].copy_from_slice(&now[i * LANES..][..COUNT]);
        }
        if measurement.iter().any(Option::is_some) {
            store(&now, n, &mut rows);
            model.log_likelihoods(&step, &rows, measurement, &mut likelihoods)?;
            objectives.iter_mut().zip(likelihoods).for_each(|(sum, likelihood)| *sum += likelihood);
        }
        std::mem::swap(&mut before, &mut now);
    }
    let value = |lane: usize| if objectives[lane].is_nan() { f64::NEG_INFINITY } else { objectives[lane] };
    let best = (0..COUNT).fold(0, |best, lane| if value(lane) > value(best) { lane } else { best });
    let path = Path {
        states: states.iter().map(|lanes| lanes[best]).collect(),
        noise: noises.iter().map(|lanes| lanes[best]).collect(),
        starts: path.starts.clone(),
        width: n,
    };
    let change = (squared_change / path.noise.len().max(1) as f64).sqrt();
    Ok(Rollout { path, objective: value(best), change })
}
