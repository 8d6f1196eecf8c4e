//! Uniform noise in the paper's linear system: how near a proposal that is learned once comes to the optimum.
//!
//! The optimum `p(x_t | x_{t−1}, y_t)` is uniform where both noises may be: between two bounds for each coordinate that is measured alone, in a strip of
//! a square for two that are measured together. Its weight is the volume of that, `p(y_t | x_{t−1})`. Nothing of the project's own filters is in it.

use std::path::Path;

use motes_models::{GraphDiffusion, GraphDiffusionConfig, Measurements, Noise, Seed, Stream, simulate};
use rand::RngExt as _;
use rand_distr::{Distribution, StandardNormal};

const TIMES: usize = 12;
const PARTICLES: usize = 50;
const SEQUENCES: usize = 20;
const FILTERS: usize = 20;
/// Coordinates that are only measured together with another one.
const TOGETHER: usize = 2;
/// The spectral norm of `[I_M, I_{M×2}]`, by which measurements are divided.
const NORM: f64 = std::f64::consts::SQRT_2;

/// `x_t = A x_{t−1} + v_t`, `√2 y_t = [I_M, I_{M×2}] x_t + √2 w_t`, both noises uniform between `±half`.
struct System {
    neighbours: Vec<Vec<(usize, f64)>>,
    half: f64,
}

impl System {
    fn of(system: &GraphDiffusion, config: &GraphDiffusionConfig) -> Self {
        let adjacency = system.adjacency();
        let row =
            |i| (0..adjacency.ncols()).map(|j| (j, adjacency[(i, j)])).filter(|(_, a)| *a != 0.0).collect();
        let variance = config.state_dim as f64 / 10_f64.powf(config.snr_db / 10.0);
        System { neighbours: (0..adjacency.nrows()).map(row).collect(), half: (3.0 * variance).sqrt() }
    }

    /// Draws the next state of a particle, and returns `p(y_t | x_{t−1})` but for a constant; nothing is drawn where that is 0.
    fn step(&self, previous: &[f64], y: &[f64], stream: &mut Stream, state: &mut [f64]) -> f64 {
        let (n, half) = (previous.len(), self.half);
        let measured = n - TOGETHER;
        let mean_of = |i: usize| self.neighbours[i].iter().map(|(j, a)| a * previous[*j]).sum::<f64>();
        let mut share = 1.0;
        for i in 0..measured {
            let (mean, seen) = (mean_of(i), NORM * y[i]);
            if i < TOGETHER {
                // Of noises in the square, those whose sum is in a strip.
                let other = mean_of(measured + i);
                let [low, high] = [-1.0, 1.0].map(|side| seen + side * NORM * half - mean - other);
                let [low, high] = [low, high].map(|sum| share_below(sum / half));
                share *= (high - low).max(0.0);
                if share == 0.0 {
                    return 0.0;
                }
                let sum = half * sum_at(low + (high - low) * stream.random::<f64>());
                let [from, to] = [(sum - half).max(-half), (sum + half).min(half)];
                let first = from + (to - from) * stream.random::<f64>();
                (state[i], state[measured + i]) = (mean + first, other + sum - first);
            } else {
                let low = (mean - half).max(seen - NORM * half);
                let high = (mean + half).min(seen + NORM * half);
                share *= ((high - low) / (2.0 * half)).max(0.0);
                if share == 0.0 {
                    return 0.0;
                }
                state[i] = low + (high - low) * stream.random::<f64>();
            }
        }
        share
    }

    /// The mean effective sample size of a filter, resampled below a third; 0 if it loses all weight.
    fn effective_sample_size(&self, measurements: &Measurements, stream: &mut Stream) -> f64 {
        let n = self.neighbours.len();
        let mut states: Vec<Vec<f64>> = (0..PARTICLES)
            .map(|_| (0..n).map(|_| 1.0 + Distribution::<f64>::sample(&StandardNormal, stream)).collect())
            .collect();
        let mut weights = vec![1.0; PARTICLES];
        let mut sum = 0.0;
        for (time, y) in measurements.rows().enumerate() {
            for (state, weight) in states.iter_mut().zip(&mut weights) {
                if time == 0 {
                    // Normal, and next to never so far out that the measurement says anything.
                    *weight = f64::from(u8::from(self.is_possible(state, y)));
                } else {
                    let previous = state.clone();
                    *weight *= self.step(&previous, y, stream, state);
                }
            }
            let total: f64 = weights.iter().sum();
            if total == 0.0 {
                return 0.0;
            }
            weights.iter_mut().for_each(|weight| *weight /= total);
            let size = 1.0 / weights.iter().map(|weight| weight * weight).sum::<f64>();
            sum += size / TIMES as f64;
            if size < PARTICLES as f64 / 3.0 {
                let drawn: Vec<Vec<f64>> = (0..PARTICLES)
                    .map(|_| {
                        let mut left = stream.random::<f64>();
                        let at = weights.iter().position(|weight| {
                            left -= weight;
                            left < 0.0
                        });
                        states[at.unwrap_or(PARTICLES - 1)].clone()
                    })
                    .collect();
                (states, weights) = (drawn, vec![1.0; PARTICLES]);
            }
        }
        sum
    }

    fn is_possible(&self, state: &[f64], y: &[f64]) -> bool {
        let measured = y.len();
        (0..measured).all(|i| {
            let other = if i < TOGETHER { state[measured + i] } else { 0.0 };
            (NORM * y[i] - state[i] - other).abs() <= NORM * self.half
        })
    }
}

/// How probable it is that the sum of two numbers, uniform between ±1, is below `sum`.
fn share_below(sum: f64) -> f64 {
    let sum = sum.clamp(-2.0, 2.0);
    if sum < 0.0 { (2.0 + sum).powi(2) / 8.0 } else { 1.0 - (2.0 - sum).powi(2) / 8.0 }
}

/// The inverse of [`share_below`].
fn sum_at(share: f64) -> f64 {
    if share < 0.5 { (8.0 * share).sqrt() - 2.0 } else { 2.0 - (8.0 * (1.0 - share)).sqrt() }
}

/// The committed mean over the sequences of the effective particles of a method, out of 50.
fn committed(n: usize, method: &str) -> f64 {
    let file =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments/reference/heldout-fig6/paper/units.csv");
    let start = format!("heldout-fig6,N{n}-exact,{method},{PARTICLES},");
    let text = std::fs::read_to_string(file).unwrap();
    let values: Vec<f64> = text
        .lines()
        .filter(|line| line.starts_with(&start))
        .filter_map(|line| line.split_once(",ess,"))
        .map(|(_, value)| value.parse().unwrap())
        .collect();
    assert_eq!(values.len(), SEQUENCES);
    values.iter().sum::<f64>() / SEQUENCES as f64
}

#[test]
fn what_is_learned_once_is_below_the_optimum_and_above_design() {
    for n in [10, 25, 50] {
        // The system and the sequences of the committed results.
        let seed = Seed::from_u64(1).child("held-out").nth(n as u64);
        let config = GraphDiffusionConfig { noise: Noise::Uniform, ..GraphDiffusionConfig::new(n) };
        let model = GraphDiffusion::random(&config, &mut seed.child("graph").stream()).unwrap();
        let system = System::of(&model, &config);
        let mut stream = Seed::from_u64(11).nth(n as u64).stream();
        let mut sum = 0.0;
        for sequence in 0..SEQUENCES {
            let drawn = &mut seed.nth(sequence as u64).child("trajectory").stream();
            let measurements = simulate(&model, TIMES, drawn).unwrap().measurements;
            let sizes = (0..FILTERS).map(|_| system.effective_sample_size(&measurements, &mut stream));
            sum += sizes.sum::<f64>();
        }
        let optimum = sum / (SEQUENCES * FILTERS) as f64;
        let (learned, designed) = (committed(n, "gnn"), committed(n, "min-degeneracy"));
        println!(
            "N = {n}: effective particles of {PARTICLES}: optimum {optimum:.2}, gnn {learned:.2}, min-degeneracy {designed:.2}"
        );
        assert!(learned < 1.05 * optimum, "{learned} of {optimum}");
        assert!(learned > 0.2 * optimum && learned > 10.0 * designed, "{learned} of {optimum}, {designed}");
    }
}
