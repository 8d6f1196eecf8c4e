//! A model of one's own and measurements from a CSV file: trains a recurrent proposal, saves it, loads it and filters with it.
//!
//! The first half of the measurements trains, all of them are filtered. The proposal is one for the sequence that it was trained
//! on. On other sequences of this system it loses to plain bootstrap, which also costs less, and a defensive share does not change that.
//!
//! `cargo run --release -p motes-train --example spring [measurements.csv [folder]]`

use std::ops::ControlFlow;
use std::path::PathBuf;

use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
use motes_models::{Measurements, ModelShape, Seed, Step};
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

impl Equations for Spring {
    fn dimensions(&self) -> [usize; 2] {
        [2, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        (0..2).for_each(|i| state[i] = draws.draw(normal(0.0, 1.0)));
    }

    fn transition<S: Scalar>(
        &self,
        _step: &Step<'_, S>,
        previous: &[S],
        draws: &mut impl Draws<S>,
        state: &mut [S],
    ) {
        let (x, v) = (previous[0], previous[1]);
        state[0] = draws.draw(normal(x + v * STEP, SIGMA[0]));
        state[1] = draws.draw(normal(v - (x.tanh() * STIFFNESS + v * FRICTION) * STEP, SIGMA[1]));
    }

    fn measurement<S: Scalar>(
        &self,
        _step: &Step<'_, S>,
        state: &[S],
        measurement: &mut impl Coordinates<S>,
    ) {
        measurement.push(normal(state[0], SIGMA[2]));
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
