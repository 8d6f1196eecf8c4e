//! Noise with bounds: how near a learned proposal comes to the optimum, and how much there is to gain over designed ones at all.
//!
//! The optimum `p(x_t | x_{t−1}, y_t)` is a normal density cut off at the bounds here. It is drawn from by rejection, and its weight is
//! `p(y_t | x_{t−1})`, by the error function: nothing of the project's own filters is in it.

use std::ops::ControlFlow;
use std::path::Path;

use motes::{
    CompareOptions, FilterOptions, LearnOptions, Model, ProposalName, compare, learn, models::Seed,
    models::Stream, simulate,
};
use rand::RngExt as _;
use special::Error as _;

const A: f64 = 0.9;
const WIDTH: f64 = 1.0;
const SD: f64 = 0.5;

const SEQUENCES: usize = 20;
const TIMES: usize = 100;
const PARTICLES: usize = 100;

/// Draws from `N(y, SD²)` between two bounds.
fn cut_off(y: f64, [low, high]: [f64; 2], stream: &mut Stream) -> f64 {
    let nearest = y.clamp(low, high);
    loop {
        let x = low + (high - low) * stream.random::<f64>();
        let log_ratio = ((y - nearest).powi(2) - (y - x).powi(2)) / (2.0 * SD * SD);
        if stream.random::<f64>() < log_ratio.exp() {
            return x;
        }
    }
}

/// `∫ N(y; x, SD²) dx` between two bounds.
fn mass(y: f64, [low, high]: [f64; 2]) -> f64 {
    let to = |x: f64| ((x - y) / (SD * std::f64::consts::SQRT_2)).error();
    0.5 * (to(high) - to(low))
}

/// The mean of ESS/K of a filter with the optimum, resampled where it is below one half.
fn of_optimum(measurements: &[f64], stream: &mut Stream) -> f64 {
    let mut states = vec![0.0; PARTICLES];
    let mut weights = vec![1.0 / PARTICLES as f64; PARTICLES];
    let mut sum = 0.0;
    for (time, &y) in measurements.iter().enumerate() {
        for (state, weight) in states.iter_mut().zip(&mut weights) {
            let half = if time == 0 { WIDTH / (1.0 - A) } else { WIDTH };
            let bounds = [A * *state - half, A * *state + half];
            *weight *= mass(y, bounds);
            *state = cut_off(y, bounds, stream);
        }
        let total: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|weight| *weight /= total);
        let size = 1.0 / weights.iter().map(|weight| weight * weight).sum::<f64>();
        sum += size / PARTICLES as f64;
        if size < 0.5 * PARTICLES as f64 {
            let start: f64 = stream.random();
            let (mut cumulated, mut at, before) = (weights[0], 0, states.clone());
            for (number, state) in states.iter_mut().enumerate() {
                let point = (start + number as f64) / PARTICLES as f64;
                while cumulated < point && at + 1 < PARTICLES {
                    at += 1;
                    cumulated += weights[at];
                }
                *state = before[at];
            }
            weights.fill(1.0 / PARTICLES as f64);
        }
    }
    sum / measurements.len() as f64
}

#[test]
fn a_learned_proposal_is_near_the_optimum_which_is_near_the_designed_ones() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/bounded.toml");
    let model = Model::read(&file, &[]).unwrap();
    let go_on = |_| ControlFlow::Continue(());
    // A network, which learns what only the optimum has.
    let network = LearnOptions { widths: Some(vec![64, 64]), ..LearnOptions::default() };
    let learned = learn(&model, None, &network, |_, _| ControlFlow::Continue(())).unwrap();
    let filter = FilterOptions { particles: PARTICLES, defensive: Some(0.0), ..FilterOptions::default() };
    let options = CompareOptions {
        proposals: vec![
            ProposalName::Bootstrap,
            ProposalName::Linearised,
            ProposalName::Learned(learned.proposal.clone()),
        ],
        filter,
        particles: vec![],
        particles_up_to: None,
        reference_particles: 1000,
        ..CompareOptions::of_learned(&model, learned.proposal, PARTICLES, 1)
    };
    let found = compare(&model, None, &options, go_on).unwrap();
    let [bootstrap, linearised, learned] =
        [0, 1, 2].map(|at: usize| found.cards[at].1.ess_fraction.unwrap().mean);
    let drawn = simulate(&model, TIMES, SEQUENCES, 1, |_| ControlFlow::Continue(())).unwrap();
    let mut stream = Seed::from_u64(11).stream();
    let optimum: f64 =
        drawn.series.iter().map(|one| of_optimum(one.measurements.values(), &mut stream)).sum::<f64>()
            / SEQUENCES as f64;
    println!(
        "ESS/K: bootstrap {bootstrap:.3}, linearised {linearised:.3}, learned {learned:.3}, optimum {optimum:.3}"
    );
    assert!(learned > 0.95 * optimum && learned < 1.02 * optimum, "{learned} of {optimum}");
    assert!(
        optimum < 1.5 * linearised.max(bootstrap),
        "there is more to gain: {optimum}, {linearised}, {bootstrap}"
    );
}
