//! What every family draws, against an independent implementation in numpy: `tests/parity/families.py`.

use std::collections::BTreeMap;

use faer::Mat;
use motes_models::{GraphDiffusion, GraphDiffusionConfig, ModelShape, Seed};
use motes_proposals::networks::Inputs;
use motes_proposals::{Backend, Compute, Learnable, Precision, Workspace};
use motes_tests::small_families;
use serde::Deserialize;

const STATE_DIM: usize = 5;
const MEASUREMENT_DIM: usize = 3;
const PARTICLES: usize = 3;
const HORIZON: usize = 2;

/// What the script wrote.
#[derive(Deserialize)]
struct Numbers {
    /// `A` of the system, `N×N`.
    adjacency: Vec<Vec<f64>>,
    /// The steps of each family, by its name.
    families: BTreeMap<String, Vec<Step>>,
}

#[derive(Deserialize)]
struct Step {
    /// `K×N`.
    states: Vec<Vec<f64>>,
    /// `K`.
    log_q: Vec<f64>,
}

fn numbers() -> Numbers {
    serde_json::from_str(include_str!("../../parity/families.json")).unwrap()
}

fn system(adjacency: &[Vec<f64>]) -> GraphDiffusion {
    let adjacency = Mat::from_fn(STATE_DIM, STATE_DIM, |i, j| adjacency[i][j]);
    GraphDiffusion::on_graph(&GraphDiffusionConfig::new(STATE_DIM), adjacency.as_ref()).unwrap()
}

/// Gives every matrix the script's weights: entry `k`, along rows, is `0.4 sin(s + 0.7 k + 0.01 k²)`, with `s`
/// the sum of `(i + 1) bᵢ` over the bytes of its name, modulo 97.
fn set_weights(proposal: &mut dyn Learnable) {
    for index in 0..proposal.parameters().len() {
        let bytes = proposal.parameters().names()[index].bytes().map(u32::from);
        let sum: u32 = (1..).zip(bytes).map(|(place, byte)| place * byte).sum();
        let s = f64::from(sum % 97);
        let [rows, columns] = proposal.parameters().shape(index);
        let values: Vec<f64> =
            (0..rows * columns).map(|k| k as f64).map(|k| 0.4 * (s + 0.7 * k + 0.01 * k * k).sin()).collect();
        proposal.parameters_mut().set_host(index, &values).unwrap();
    }
}

/// The script's noise, `K×N`.
fn noise(family: &str, time: usize) -> Vec<f64> {
    let t = time as f64;
    let uniform = |k: f64| (0.37 * k + 0.11 + 0.29 * t).fract();
    let normal = |k: f64| 1.5 * (2.0 + 1.3 * k + 5.0 * t).sin();
    let entry = |k: usize| if family == "psi" { uniform(k as f64) } else { normal(k as f64) };
    (0..PARTICLES * STATE_DIM).map(entry).collect()
}

/// The script's `y_t`.
fn measurement(time: usize) -> Vec<f64> {
    (0..MEASUREMENT_DIM).map(|j| (1.0 + j as f64 + 2.0 * time as f64).cos()).collect()
}

fn check(label: &str, found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{label}: the number of values");
    for (at, (found, expected)) in found.iter().zip(expected).enumerate() {
        let agrees = (found - expected).abs() <= 1e-9 * expected.abs().max(1.0);
        assert!(agrees, "{label}, entry {at}: {found} here, {expected} in numpy");
    }
}

fn check_family(label: &str, family: &str, proposal: &dyn Learnable, steps: &[Step]) {
    assert_eq!(steps.len(), HORIZON, "{label}: the number of steps");
    let mut tape = proposal.tape(PARTICLES, Workspace::new(proposal.parameters())).unwrap();
    let mut previous: Option<Vec<f64>> = None;
    for (time, step) in steps.iter().enumerate() {
        let measurement = measurement(time);
        let (previous_states, width) = (previous.as_deref(), STATE_DIM);
        let inputs = Inputs {
            time,
            width,
            previous: previous_states,
            measurement: &measurement,
            particles: PARTICLES,
        };
        let (mut states, mut log_q) = (vec![0.0; PARTICLES * STATE_DIM], vec![0.0; PARTICLES]);
        let drawn = tape.draw(&inputs, &noise(family, time), &mut states, Some(&mut log_q));
        assert_eq!(drawn, Ok(()), "{label}, step {time}");
        check(&format!("{label}, step {time}, states"), &states, &step.states.concat());
        check(&format!("{label}, step {time}, log q"), &log_q, &step.log_q);
        previous = Some(states);
    }
}

#[test]
fn two_steps_of_every_family_are_those_of_numpy() {
    let numbers = numbers();
    let system = system(&numbers.adjacency);
    for backend in Backend::built(Precision::F64) {
        let compute = Compute { backend, precision: Precision::F64 };
        let families = small_families(&ModelShape::on_graph(&system), HORIZON, compute, &Seed::from_u64(110));
        let mut names: Vec<&str> = families.iter().map(|(family, _)| family.as_str()).collect();
        names.sort_unstable();
        let known: Vec<&str> = numbers.families.keys().map(String::as_str).collect();
        assert_eq!(names, known, "the script knows every family and no other");
        for (family, mut proposal) in families {
            set_weights(proposal.as_mut());
            let label = format!("{family} on {backend:?}");
            check_family(&label, &family, proposal.as_ref(), &numbers.families[&family]);
        }
    }
}
