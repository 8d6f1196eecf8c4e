//! Graph filters on blocks of inputs: what loops over nodes and edges find, and derivatives that differences find, by every backend.

use faer::{Mat, mat};
use motes_models::Seed;
use motes_networks::layers::GraphNetwork;
use motes_networks::{
    Activation, Arithmetic, Backend, Compute, Graph, Inference, Inputs, Known, NetworkTape, Networks,
    Outputs, Parameters, Precision, Workspace,
};

const NODES: usize = 3;
const MEASURED: usize = 2;
const STATES: usize = 2;
const HEARD: usize = 1;
const WIDTH: usize = STATES * NODES + HEARD * MEASURED;
const FEATURES: usize = 4;
const PARTICLES: usize = 5;

#[derive(Clone)]
struct OnGraph {
    layers: GraphNetwork,
    graph: Graph,
}

impl Networks for OnGraph {
    fn horizon(&self) -> Option<usize> {
        None
    }

    fn forward<A: Arithmetic>(&self, by: &mut A, _: usize, known: Known<'_, A::Rows>) -> Outputs<A::Rows> {
        let at_nodes = by.blocks_at_nodes(&known.previous, &self.graph, STATES, HEARD);
        let at_nodes = self.layers.forward(by, &self.graph, at_nodes, Activation::Tanh);
        Outputs::new([by.by_particle(&at_nodes, NODES)], [])
    }
}

fn shift() -> Mat<f64> {
    mat![[0.0, 0.7, 0.0], [0.7, 0.0, -0.4], [0.0, -0.4, 0.0]]
}

fn adapter() -> Mat<f64> {
    mat![[1.0, 0.0], [0.5, 0.5], [0.0, 2.0]]
}

fn built(backend: Backend) -> (OnGraph, Parameters) {
    let mut parameters = Parameters::new(Compute { backend, precision: Precision::F64 });
    let features = [STATES + HEARD, FEATURES];
    let layers = GraphNetwork::draw(&mut parameters, "net", &features, 1, &Seed::from_u64(1));
    (OnGraph { layers, graph: Graph::new(shift(), adapter()) }, parameters)
}

fn inputs() -> Vec<f64> {
    (0..PARTICLES * WIDTH).map(|i| (0.37 * i as f64).sin()).collect()
}

fn of(rows: &[f64]) -> Inputs<'_> {
    Inputs { time: 1, width: WIDTH, previous: Some(rows), measurement: &[], particles: PARTICLES }
}

fn outputs(networks: &OnGraph, parameters: &Parameters, rows: &[f64]) -> Vec<f64> {
    let mut found = vec![0.0; PARTICLES * NODES * FEATURES];
    Inference::default().run(networks, parameters, &of(rows), &mut [], &mut [&mut found]).unwrap();
    found
}

/// One layer of order 1, particle by particle and node by node.
fn by_loops(parameters: &Parameters, rows: &[f64]) -> Vec<f64> {
    let (taps, bias) = (parameters.host(0), parameters.host(1));
    let (shift, adapter) = (shift(), adapter());
    let mut found = Vec::new();
    for row in rows.chunks_exact(WIDTH) {
        let at_node = |i: usize| -> [f64; STATES + HEARD] {
            let heard: f64 = (0..MEASURED).map(|k| adapter[(i, k)] * row[STATES * NODES + k]).sum();
            [row[i], row[NODES + i], heard]
        };
        for i in 0..NODES {
            for feature in 0..FEATURES {
                let mut sum = bias[feature];
                for input in 0..STATES + HEARD {
                    let near: f64 = (0..NODES).map(|j| shift[(i, j)] * at_node(j)[input]).sum();
                    sum += at_node(i)[input] * taps[input * FEATURES + feature];
                    sum += near * taps[(STATES + HEARD + input) * FEATURES + feature];
                }
                found.push(sum.tanh());
            }
        }
    }
    found
}

#[test]
fn what_nodes_hear_is_what_loops_over_edges_find() {
    for backend in Backend::built(Precision::F64) {
        let (networks, parameters) = built(backend);
        let expected = by_loops(&parameters, &inputs());
        for (found, expected) in outputs(&networks, &parameters, &inputs()).iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-12, "{backend}: {found} for {expected}");
        }
    }
}

#[test]
fn derivatives_are_those_of_differences() {
    let step = 1e-6;
    for backend in Backend::built(Precision::F64) {
        let (networks, mut parameters) = built(backend);
        let rows = inputs();
        let weight = |at: usize| 1.0 + 0.1 * at as f64;
        let loss = |parameters: &Parameters, rows: &[f64]| -> f64 {
            outputs(&networks, parameters, rows).iter().enumerate().map(|(at, z)| weight(at) * z).sum()
        };
        let workspace = Workspace::new(&parameters);
        let mut tape = NetworkTape::new(&networks, &parameters, PARTICLES, workspace).unwrap();
        let mut found = vec![0.0; PARTICLES * NODES * FEATURES];
        tape.forward(&of(&rows), &mut [&mut found]).unwrap();
        let d: Vec<f64> = (0..found.len()).map(weight).collect();
        let mut d_inputs = vec![0.0; rows.len()];
        tape.backward(&[&d], &mut d_inputs).unwrap();
        let gradients = tape.finish().into_gradients();
        // They do not depend on who asks for what else.
        let mut tape =
            NetworkTape::new(&networks, &parameters, PARTICLES, Workspace::new(&parameters)).unwrap();
        tape.forward(&of(&rows), &mut [&mut found]).unwrap();
        tape.backward_to_weights(&[&d]).unwrap();
        let alone = tape.finish().into_gradients();
        assert!((0..parameters.len()).all(|index| alone.host(index) == gradients.host(index)), "{backend}");
        let near = |found: f64, expected: f64| (found - expected).abs() < 1e-6 * (1.0 + expected.abs());
        for at in 0..rows.len() {
            let at_distance = |by: f64| {
                let mut rows = rows.clone();
                rows[at] += by;
                loss(&parameters, &rows)
            };
            let expected = (at_distance(step) - at_distance(-step)) / (2.0 * step);
            assert!(near(d_inputs[at], expected), "{backend}, input {at}: {} for {expected}", d_inputs[at]);
        }
        for index in 0..parameters.len() {
            let gradient = gradients.host(index).unwrap();
            let values = parameters.host(index);
            for at in 0..values.len() {
                let mut at_distance = |by: f64| {
                    let mut values = values.clone();
                    values[at] += by;
                    parameters.set_host(index, &values).unwrap();
                    loss(&parameters, &rows)
                };
                let expected = (at_distance(step) - at_distance(-step)) / (2.0 * step);
                assert!(near(gradient[at], expected), "{backend}, weight {index}, {at}: {}", gradient[at]);
            }
            parameters.set_host(index, &values).unwrap();
        }
    }
}
