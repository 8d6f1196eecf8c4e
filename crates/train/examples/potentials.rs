//! Learns potentials of the growth model and compares evidence with them to evidence by bootstrap: `cargo run --release -p motes-train --example potentials`.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
use motes_models::{ModelShape, Seed, Step, StepRecord, simulate};
use motes_proposals::{Backend, Family, LearnedPotentials, LearnedPotentialsConfig, OnLinePotentials};
use motes_smc::{Bootstrap, FilterBank, FilterSettings, Linearised, LookAhead, Proposal, RecordedStep};
use motes_train::{PathSource, PotentialLearnConfig, learn_potentials};

/// The bimodal growth model (Gordon, Salmond and Smith 1993).
struct Growth;

impl Equations for Growth {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
        x[0] = draws.draw(normal(0.0, 5.0_f64.sqrt()));
    }

    fn transition<S: Scalar>(&self, at: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, now: &mut [S]) {
        let x = x[0];
        let mean = x * 0.5 + x * 25.0 / (x * x + 1.0) + 8.0 * (1.2 * at.index as f64).cos();
        now[0] = draws.draw(normal(mean, 10.0_f64.sqrt()));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0] * x[0] * 0.05, 1.0));
    }
}

/// Returns whose log-variance goes back to its mean.
struct Volatility;

impl Equations for Volatility {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
        x[0] = draws.draw(normal(-1.0, 0.6));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, now: &mut [S]) {
        now[0] = draws.draw(normal(x[0] * 0.95 - 0.05, 0.2));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(0.0, (x[0] * 0.5).exp()));
    }
}

const RUNS: usize = 200;
const PARTICLES: usize = 100;

fn runs<M: Equations, P: Proposal<M, Memory = ()> + Send>(
    model: &M,
    proposal: P,
    rows: &[RecordedStep],
) -> Result<(f64, f64, f64), Box<dyn std::error::Error>> {
    let started = Instant::now();
    let settings = FilterSettings::new(PARTICLES);
    let mut bank = FilterBank::new(model, proposal, settings, RUNS, &Seed::from_u64(3))?.keeping_collapsed();
    for RecordedStep { step, measurement } in rows {
        bank.step_at(&step.step(), measurement)?;
    }
    let seconds = started.elapsed().as_secs_f64() / RUNS as f64;
    let logs: Vec<f64> = (0..RUNS).map(|run| bank.log_evidence(run)).collect();
    let mean = logs.iter().sum::<f64>() / RUNS as f64;
    let variance = logs.iter().map(|log| (log - mean).powi(2)).sum::<f64>() / (RUNS - 1) as f64;
    Ok((mean, variance, seconds))
}

fn study<M: Equations>(name: &str, model: &M, times: usize) -> Result<(), Box<dyn std::error::Error>> {
    let seed = Seed::from_u64(1);
    let shape = ModelShape::of(model);
    let config = LearnedPotentialsConfig::default();
    let mut potentials =
        LearnedPotentials::create(&config, &shape, 0, Backend::Native.into(), &seed.child("weights"))?;
    let settings = PotentialLearnConfig::new();
    let source = PathSource::Model(model);
    let learned = learn_potentials(&mut potentials, source, &settings, &seed.child("learn"), |_, _| {
        ControlFlow::Continue(())
    })?;
    println!("{name}: learned in {:.1} s, {:?}", learned.seconds, learned.validation);
    for sequence in 0..5 {
        let data = simulate(model, times, &mut seed.child("data").nth(sequence).stream())?;
        let rows: Vec<RecordedStep> = data
            .measurements
            .rows()
            .enumerate()
            .map(|(index, row)| RecordedStep {
                step: StepRecord::of(&Step::of_index(index)),
                measurement: row.iter().copied().map(Some).collect(),
            })
            .collect();
        let started = Instant::now();
        let now = OnLinePotentials::proposal(Arc::new(potentials.clone()), model)?;
        let ahead = potentials.look_ahead(model, &rows)?;
        let seconds = started.elapsed().as_secs_f64();
        print!("  networks {:.2} ms;", 1e3 * seconds);
        for (name, (mean, variance, seconds)) in [
            ("ahead", runs(model, ahead, &rows)?),
            ("now", runs(model, now, &rows)?),
            ("designed", runs(model, LookAhead::new(model, &rows)?, &rows)?),
            ("linearised", runs(model, Linearised::new(model)?, &rows)?),
            ("bootstrap", runs(model, Bootstrap, &rows)?),
        ] {
            print!(" {name} {mean:.2} var {variance:.3} {:.2} ms;", 1e3 * seconds);
        }
        println!();
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    study("growth", &Growth, 100)?;
    study("volatility", &Volatility, 1000)
}
