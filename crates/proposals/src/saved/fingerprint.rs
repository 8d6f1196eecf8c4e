//! What tells one system from another: its densities at points that are drawn from it by a fixed stream.

use std::slice::from_mut;

use motes_models::batch::Rows;
use motes_models::{Seed, StateSpaceModel, Step, SystemGraph};
use rand::RngExt;
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A named number of a system's fingerprint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    /// What it is.
    name: String,
    /// Its value.
    value: f64,
}

/// What tells a system from others by its densities: two are the same system where all numbers agree.
///
/// Dimensions, log densities at a few points of the first three times, projections of the points, and projections of the graph: a
/// change of a parameter changes some of them, unless it shows at later times alone. Where noise is added, the density of a state that was
/// drawn is that of its noise, wherever it was drawn around: only the state itself tells that.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Fingerprint(Vec<Entry>);

/// A system is another one than that with which something was made.
#[derive(Debug, Clone, PartialEq, Error)]
#[error(
    "this proposal was trained for another system: {what} is {found} there and {expected} in the model given"
)]
pub struct OtherSystem {
    /// The first number that differs.
    pub what: String,
    /// Its value for the system that something was made with.
    pub found: f64,
    /// Its value for the model given.
    pub expected: f64,
}

impl Fingerprint {
    /// That of a model, and of the graph that networks compute along if they do.
    pub fn of(model: &dyn StateSpaceModel, graph: Option<&SystemGraph>) -> Self {
        Fingerprint(fingerprint(model, graph))
    }

    /// That of all models with so many coordinates: as much of a fingerprint as it begins with.
    pub(super) fn of_sizes(state_dim: usize, measurement_dim: usize) -> Self {
        Fingerprint(sizes(state_dim, measurement_dim))
    }

    /// How many numbers there are.
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// Holds a fingerprint that was kept against that of a model that is given, as far as both go.
    ///
    /// # Errors
    /// [`OtherSystem`] with the first number that differs by more than processors may round.
    pub fn check(&self, given: &Fingerprint) -> Result<(), OtherSystem> {
        for (Entry { name: known, value: found }, Entry { name, value: expected }) in
            self.0.iter().zip(&given.0)
        {
            let scale = found.abs().max(expected.abs());
            let is_near = scale.is_finite() && (found - expected).abs() <= TOLERANCE * scale;
            // A density may be none: of a model that ran away it is so whenever it is asked.
            let is_same = found == expected || is_near || (found.is_nan() && expected.is_nan());
            if known != name || !is_same {
                return Err(OtherSystem { what: name.clone(), found: *found, expected: *expected });
            }
        }
        Ok(())
    }
}

/// Room for the last bits, in which processors may differ.
const TOLERANCE: f64 = 1e-9;

fn fingerprint(model: &dyn StateSpaceModel, graph: Option<&SystemGraph>) -> Vec<Entry> {
    let (n, m) = (model.state_dim(), model.measurement_dim());
    let mut stream = Seed::from_u64(0).child("fingerprint").stream();
    let mut weights = Seed::from_u64(0).child("fingerprint projections").stream();
    let mut projection = |values: &[f64]| -> f64 {
        values.iter().map(|value| value * weights.sample::<f64, _>(StandardNormal)).sum()
    };
    let mut entries = sizes(n, m);
    let (mut previous, mut state, mut measurement) = (vec![0.0; n], vec![0.0; n], vec![0.0; m]);
    let log_density = |step: &Step<'_>, previous: Option<&[f64]>, state: &[f64]| {
        Some(model.density()?.log_density(step, previous, state))
    };
    // Inputs that are not known are 1: what a model makes of them tells it from others.
    let ones = vec![1.0; model.input_dim()];
    let step_of_index = |index: usize| {
        let own = model.step_of_index(index);
        let is_known = own.inputs.len() == ones.len() && own.inputs.iter().all(|input| input.is_finite());
        let inputs = if is_known { own.inputs } else { &ones };
        Step { inputs, parameters: own.parameters, ..Step::of_index(index) }
    };
    let start = step_of_index(0);
    model.sample_states(&start, None, from_mut(&mut stream), &mut previous);
    let log = log_density(&start, None, &previous);
    entries.extend(log.map(|log| entry("log p(x_0) at a fixed point", log)));
    entries.push(entry("a fixed projection of a fixed draw of x_0", projection(&previous)));
    for time in 1..=2 {
        let step = step_of_index(time);
        model.sample_states(&step, Some(Rows::all(&previous, n)), from_mut(&mut stream), &mut state);
        let name = format!("log p(x_{time} | x_{}) at a fixed point", time - 1);
        entries.extend(log_density(&step, Some(&previous), &state).map(|log| entry(&name, log)));
        entries.push(entry(&format!("a fixed projection of a fixed draw of x_{time}"), projection(&state)));
        // Noise with bounds may exclude most measurements: several sizes, so that some are inside.
        for scale in [0.1, 1.0, 10.0] {
            measurement.fill_with(|| scale * stream.sample::<f64, _>(StandardNormal));
            // What cannot be had is NaN.
            let log = model.log_likelihood(&step, &state, &measurement).unwrap_or(f64::NAN);
            entries.push(entry(&format!("log p(y_{time} | x_{time}) at a fixed point of size {scale}"), log));
        }
        previous.copy_from_slice(&state);
    }
    // Along which edges a graph network computes is the system's too.
    entries.push(entry("the number of graphs", f64::from(u8::from(graph.is_some()))));
    if let Some(graph) = graph {
        for (name, matrix) in
            [("the graph's matrix S", &graph.shift), ("the graph's adapter", &graph.adapter)]
        {
            let mut sum = 0.0;
            for j in 0..matrix.ncols() {
                for i in 0..matrix.nrows() {
                    sum += matrix[(i, j)] * stream.sample::<f64, _>(StandardNormal);
                }
            }
            entries.push(entry(&format!("a fixed projection of {name}"), sum));
        }
    }
    entries
}

/// The numbers of coordinates, with which a fingerprint begins.
fn sizes(state_dim: usize, measurement_dim: usize) -> Vec<Entry> {
    vec![
        entry("the state dimension N", state_dim as f64),
        entry("the measurement dimension M", measurement_dim as f64),
    ]
}

fn entry(name: &str, value: f64) -> Entry {
    Entry { name: name.into(), value }
}
