//! A model of one's own and measurements from a CSV file: trains a recurrent proposal, saves it, loads it and filters with it.
//!
//! The first half of the measurements trains, all of them are filtered. The proposal is one for the sequence that it was trained
//! on. On other sequences of this system it loses to plain bootstrap, which also costs less, and a defensive share does not change that.
//!
//! `cargo run --release -p motes-train --example spring [measurements.csv [folder]]`

use std::ops::ControlFlow;
use std::path::PathBuf;

use motes_models::{
    Measurements, ModelShape, Noise, Seed, Simulator, StateGradients, StateSpaceModel, Stream,
    check_gradients,
};
use motes_proposals::{Backend, Family, Rnn, RnnConfig, load, save};
use motes_smc::{Bootstrap, FilterSettings, ParticleFilter, Proposal, WeightReport};
use motes_train::{AdamConfig, Objective, TrainConfig, train};

/// A mass on a soft spring, pushed about at random: `x' = x + Δ v`, `v' = v − Δ (k tanh x + f v)`; `x` is measured.
struct Spring;

const STEP: f64 = 0.2;
const STIFFNESS: f64 = 4.0;
const FRICTION: f64 = 0.5;
/// Standard deviations of what pushes displacement and speed, and of the measurement.
const SIGMA: [f64; 3] = [0.2, 0.4, 0.1];

fn moved(previous: &[f64]) -> [f64; 2] {
    let (x, v) = (previous[0], previous[1]);
    [x + STEP * v, v - STEP * (STIFFNESS * x.tanh() + FRICTION * v)]
}

impl StateSpaceModel for Spring {
    fn state_dim(&self) -> usize {
        2
    }

    fn measurement_dim(&self) -> usize {
        1
    }

    fn sample_initial(&self, stream: &mut Stream, state: &mut [f64]) {
        state.fill_with(|| Noise::Gaussian.sample(1.0, stream));
    }

    fn sample_transition(&self, _time: usize, previous: &[f64], stream: &mut Stream, state: &mut [f64]) {
        let mean = moved(previous);
        for i in 0..2 {
            state[i] = mean[i] + Noise::Gaussian.sample(SIGMA[i], stream);
        }
    }

    fn log_initial(&self, state: &[f64]) -> f64 {
        state.iter().map(|value| Noise::Gaussian.log_density(1.0, *value)).sum()
    }

    fn log_transition(&self, _time: usize, previous: &[f64], state: &[f64]) -> f64 {
        let mean = moved(previous);
        (0..2).map(|i| Noise::Gaussian.log_density(SIGMA[i], state[i] - mean[i])).sum()
    }

    fn log_likelihood(&self, _time: usize, state: &[f64], measurement: &[f64]) -> f64 {
        Noise::Gaussian.log_density(SIGMA[2], measurement[0] - state[0])
    }
}

/// What training asks for beside the densities: their derivatives with respect to the states, a particle in each row.
impl StateGradients for Spring {
    fn initial_gradients(&self, states: &[f64], d_states: &mut [f64]) {
        d_states.iter_mut().zip(states).for_each(|(d, value)| *d = Noise::Gaussian.gradient(1.0, *value));
    }

    fn transition_gradients(
        &self,
        _time: usize,
        previous: &[f64],
        states: &[f64],
        d_previous: &mut [f64],
        d_states: &mut [f64],
    ) {
        for row in (0..states.len()).step_by(2) {
            let (from, mean) = (&previous[row..row + 2], moved(&previous[row..row + 2]));
            let slope = |i: usize| Noise::Gaussian.gradient(SIGMA[i], states[row + i] - mean[i]);
            let (of_x, of_v) = (slope(0), slope(1));
            d_states[row..row + 2].copy_from_slice(&[of_x, of_v]);
            d_previous[row] = -of_x + of_v * STEP * STIFFNESS / from[0].cosh().powi(2);
            d_previous[row + 1] = -of_x * STEP - of_v * (1.0 - STEP * FRICTION);
        }
    }

    fn likelihood_gradients(&self, _time: usize, states: &[f64], measurement: &[f64], d_states: &mut [f64]) {
        for (state, d) in states.chunks_exact(2).zip(d_states.chunks_exact_mut(2)) {
            let slope = Noise::Gaussian.gradient(SIGMA[2], measurement[0] - state[0]);
            d.copy_from_slice(&[-slope, 0.0]);
        }
    }
}

/// What drawing measurements asks for, so that the gradients above can be checked.
impl Simulator for Spring {
    fn sample_measurement(&self, _time: usize, state: &[f64], stream: &mut Stream, measurement: &mut [f64]) {
        measurement[0] = state[0] + Noise::Gaussian.sample(SIGMA[2], stream);
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let file = arguments.next().unwrap_or(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/spring.csv").into());
    let scratch = tempfile::tempdir()?;
    let folder = arguments.next().unwrap_or(scratch.path().join("rnn"));

    let values: Vec<f64> = csv::Reader::from_path(file)?
        .deserialize::<(f64,)>()
        .map(|row| row.map(|(value,)| value))
        .collect::<Result<_, _>>()?;
    let logged = Measurements::new(1, values[..values.len() / 2].to_vec())?;

    let seed = Seed::from_u64(1);
    // A gradient that is wrong makes no error in training, only a worse proposal.
    check_gradients(&Spring, 20, 1e-5, &mut seed.child("gradients").stream())?;
    let config = RnnConfig { hidden: 16, ridge: 1e-3, ..RnnConfig::paper() };
    let shape = ModelShape::of(&Spring);
    let mut rnn = Rnn::create(&config, &shape, 0, Backend::Native.into(), &seed.child("weights"))?;
    let adam = AdamConfig { learning_rate: 1e-2, ..AdamConfig::paper() };
    // With the entropy in the objective the proposal keeps as much variance as the posterior has.
    let training = TrainConfig { objective: Objective::Elbo, steps: 400, adam, ..TrainConfig::paper(8) };
    let mut stream = seed.child("training").stream();
    train(&mut rnn, &Spring, &logged, &training, &mut stream, |step, loss| {
        if step % 100 == 0 {
            println!("step {step:3}: loss {loss:8.2}");
        }
        ControlFlow::Continue(())
    })?;
    save(&folder, &rnn, &Spring, &shape, &training)?;

    // The same sequence, and how it went on. A share of the transition bounds the weights; it does not make the proposal a good one.
    let rnn: Rnn = load(&folder, &Spring, &shape, Backend::Native.into())?;
    let all = Measurements::new(1, values)?;
    let settings = FilterSettings::new(100);
    let defensive = FilterSettings { defensive_weight: Some(0.1), ..settings };
    println!("rnn:       {}", filtered(rnn, defensive, &all, &seed)?);
    println!("bootstrap: {}", filtered(Bootstrap, settings, &all, &seed)?);
    Ok(())
}

/// Filters and says how that went.
fn filtered(
    proposal: impl Proposal<Spring>,
    settings: FilterSettings,
    measurements: &Measurements,
    seed: &Seed,
) -> Result<String, Box<dyn std::error::Error>> {
    let stream = seed.child("filter").stream();
    let mut filter = ParticleFilter::new(&Spring, proposal, settings, stream)?;
    let mut report = WeightReport::default();
    for measurement in measurements.rows() {
        filter.step(measurement)?;
        report.add(&filter.diagnosis());
    }
    let (log_evidence, mean) = (filter.log_evidence(), filter.mean());
    let (x, v) = (mean[0], mean[1]);
    Ok(format!("log-evidence {log_evidence:.2}, at last x = {x:.2}, v = {v:.2}; {report}"))
}
