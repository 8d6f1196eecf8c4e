//! The files that say what is learned once and what it is learned from: weights, measurements, and rows of gradient steps.

use std::path::Path;

use motes_models::equations::Equations;
use motes_models::{Measurements, ModelError, ModelShape, OwnSteps, fill_standard_normal, simulate};
use motes_proposals::{Amortised, Backend, Examples, Family, Parametric, Stage, save};
use motes_train::LearnConfig;
use serde::Serialize;

use super::models::{Growth, Tracking, config};
use super::sizes::{HORIZON, ROWS};
use crate::error::{SpeedError, prepare};
use crate::folder::seed;

/// Batches of rows; gradient steps take one after the other, again and again.
const BATCHES: usize = 16;

/// Sequences that inputs are standardised by.
const STANDARDISING: usize = 64;

/// The scale of the outputs' weights. They would begin at 0, where the proposal is its base and hidden layers have no gradient:
/// nothing would show that networks are equal.
const SCALE: f64 = 0.05;

/// What others read beside the weights and the rows.
#[derive(Serialize)]
struct Problem {
    model: String,
    measurements: Vec<Vec<f64>>,
    /// Rows of a gradient step.
    rows: usize,
}

/// Writes what a model's work is done with.
pub(crate) fn write(folder: &Path, model: &str) -> Result<(), SpeedError> {
    match model {
        "growth" => write_for(folder, model, &Growth),
        _ => write_for(folder, model, &Tracking),
    }
}

fn write_for(folder: &Path, name: &str, model: &impl Equations) -> Result<(), SpeedError> {
    if folder.exists() {
        std::fs::remove_dir_all(folder).map_err(SpeedError::system(folder))?;
    }
    let proposal = proposal(name, model)?;
    save(folder, &proposal, model, &ModelShape::of(model), &LearnConfig::new()).map_err(prepare)?;
    let put = |name: &str, bytes: Vec<u8>| {
        let path = folder.join(name);
        std::fs::write(&path, bytes).map_err(SpeedError::system(&path))
    };
    let measurements = measurements(model).map_err(prepare)?.rows().map(<[f64]>::to_vec).collect();
    let problem = Problem { model: name.into(), measurements, rows: ROWS };
    put("problem.json", serde_json::to_vec(&problem).map_err(prepare)?)?;
    let rows = rows(&proposal, model).map_err(prepare)?;
    let bytes = |values: &[f64]| values.iter().flat_map(|value| value.to_le_bytes()).collect();
    let [previous, states] = pairs(model).map_err(prepare)?;
    put("previous.f64", bytes(&previous))?;
    put("states.f64", bytes(&states))?;
    put("inputs.f64", bytes(rows.inputs()))?;
    put("units.f64", bytes(rows.units()))?;
    put("log_transition.f64", bytes(rows.log_transition()))
}

/// The measurements that filters run along.
pub(super) fn measurements(model: &impl Equations) -> Result<Measurements, ModelError> {
    Ok(simulate(model, HORIZON, &mut seed().child("learned").stream())?.measurements)
}

/// A proposal whose weights are all drawn at random, with inputs in standard units.
fn proposal(name: &str, model: &impl Equations) -> Result<Amortised, SpeedError> {
    let (shape, weights) = (ModelShape::of(model), seed().child("weights"));
    let mut proposal =
        Amortised::create(&config(name), &shape, 0, Backend::Native.into(), &weights).map_err(prepare)?;
    let mut steps = OwnSteps::new(model, STANDARDISING, &seed().child("inputs")).map_err(prepare)?;
    let standardised = proposal.fit_inputs(model, |add| {
        for _ in 0..HORIZON {
            match steps.advance() {
                Some(step) => add(&step)?,
                None => break,
            }
        }
        Ok(())
    });
    standardised.map_err(prepare)?;
    let mut stream = seed().child("outputs").stream();
    let parameters = proposal.parameters_mut();
    for index in 0..parameters.len() {
        let name = &parameters.names()[index];
        if name.ends_with("outputs.weight") || name.ends_with("outputs.linear") {
            let mut values = parameters.host(index);
            fill_standard_normal(&mut stream, &mut values);
            values.iter_mut().for_each(|value| *value *= SCALE);
            parameters.set_host(index, &values).map_err(prepare)?;
        }
    }
    Ok(proposal)
}

/// States at the times 0 and 1 of some sequences: what filters show the density of their proposal at.
pub(super) fn pairs(model: &impl Equations) -> Result<[Vec<f64>; 2], ModelError> {
    let mut steps = OwnSteps::new(model, ROWS, &seed().child("pairs"))?;
    Ok([(); 2].map(|()| steps.advance().map_or(Vec::new(), |step| step.states.to_vec())))
}

/// Rows of all batches for the network of later times, each a step of a sequence of its own at some time.
fn rows(proposal: &Amortised, model: &impl Equations) -> Result<Stage, ModelError> {
    let mut examples = Examples::default();
    let sequences = (BATCHES * ROWS).div_ceil(HORIZON - 1);
    let mut steps = OwnSteps::new(model, sequences, &seed().child("rows"))?;
    for _ in 0..HORIZON {
        match steps.advance() {
            Some(step) => proposal.encode(model, &step, &mut examples)?,
            None => break,
        }
    }
    // Rows of one time lie side by side: dealt out so that every batch has some of all times.
    let (later, mut dealt) = (examples.later, Stage::default());
    let picked: Vec<usize> = (0..BATCHES * ROWS).map(|row| row % ROWS * BATCHES + row / ROWS).collect();
    dealt.pick(&later, &picked);
    Ok(dealt)
}

/// The rows of each batch.
pub(super) fn batches(proposal: &Amortised, model: &impl Equations) -> Result<Vec<Stage>, ModelError> {
    let all = rows(proposal, model)?;
    Ok((0..BATCHES)
        .map(|batch| {
            let mut stage = Stage::default();
            stage.pick(&all, &(batch * ROWS..(batch + 1) * ROWS).collect::<Vec<_>>());
            stage
        })
        .collect())
}
