//! The graph proposal: what the paper says of permutations, of reach along edges, and of weights that do not depend on N.

use faer::Mat;
use motes_models::equations::{Coordinates, Draws, Equations, Scalar};
use motes_models::{
    GraphDiffusion, GraphDiffusionConfig, GraphModel, LinearGaussian, ModelShape, Seed, Step, SystemGraph,
};
use motes_proposals::{Adapter, Backend, Compute, Family, Gnn, GnnConfig, Parametric, Precision};
use motes_smc::{Conditional, Context, FilterSettings, ParticleFilter, Proposal, ProposalError};
use motes_tests::{reference, relative_distance, small_gnn, trained_family};

const F64: Compute = Compute { backend: Backend::Native, precision: Precision::F64 };

/// A system whose graph is given; nothing else of it is used here.
struct Graphed(SystemGraph);

impl Equations for Graphed {
    fn dimensions(&self) -> [usize; 2] {
        [self.0.adapter.nrows(), self.0.adapter.ncols()]
    }
    fn initial<S: Scalar>(&self, _: &Step<'_, S>, _: &mut impl Draws<S>, _: &mut [S]) {}
    fn transition<S: Scalar>(&self, _: &Step<'_, S>, _: &[S], _: &mut impl Draws<S>, _: &mut [S]) {}
    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, _: &[S], _: &mut impl Coordinates<S>) {}
}

impl GraphModel for Graphed {
    fn graph(&self) -> SystemGraph {
        self.0.clone()
    }
}

fn graph_of(n: usize) -> SystemGraph {
    let config = GraphDiffusionConfig::new(n);
    GraphDiffusion::random(&config, &mut Seed::from_u64(100).stream()).unwrap().graph()
}

/// A path of `n` nodes, each of which is measured.
fn path(n: usize) -> SystemGraph {
    let shift = Mat::from_fn(n, n, |i, j| if i.abs_diff(j) == 1 { 0.5 } else { 0.0 });
    SystemGraph { shift, adapter: Mat::identity(n, n) }
}

fn gnn(config: &GnnConfig, graph: &SystemGraph) -> Gnn {
    Gnn::create(config, &ModelShape::on_graph(&Graphed(graph.clone())), 2, F64, &Seed::from_u64(101)).unwrap()
}

fn index_of(proposal: &Gnn, name: &str) -> usize {
    proposal.parameters().names().iter().position(|found| found == name).unwrap()
}

/// The means at time 1 of `K` particles, and log q at the given states.
fn means_and_log_q(
    proposal: &mut Gnn,
    graph: &SystemGraph,
    previous: &[f64],
    measurement: &[f64],
    states: &[f64],
) -> (Vec<f64>, Vec<f64>) {
    let (model, n) = (Graphed(graph.clone()), graph.shift.nrows());
    let particles = previous.len() / n;
    let context = Context::new(Step::of_index(1), Some(previous), particles);
    let mut memory = Proposal::<Graphed>::initial_memory(proposal, particles);
    let mut scratch = Default::default();
    let conditional =
        proposal.condition_batch(&model, context, measurement, &mut memory, &mut scratch).unwrap();
    let mut log_density = vec![0.0; particles];
    conditional.log_density(states, &mut log_density);
    (conditional.means().to_vec(), log_density)
}

fn waves(count: usize, rate: f64) -> Vec<f64> {
    (0..count).map(|k| 2.0 * (rate * k as f64 + 1.0).sin()).collect()
}

fn check_permutation(mut proposal: Gnn, mut permuted: Gnn, graph: &SystemGraph, order: &[usize]) {
    let n = order.len();
    let identity: Vec<f64> = (0..n * n).map(|at| f64::from(u8::from(at / n == at % n))).collect();
    // With C = I also the covariance is permuted, so that log q says whether z was.
    for gnn in [&mut proposal, &mut permuted] {
        let mixing = index_of(gnn, "covariance.mixing");
        gnn.parameters_mut().set_host(mixing, &identity).unwrap();
    }
    let permute = |rows: &[f64]| -> Vec<f64> {
        rows.chunks_exact(n).flat_map(|row| order.iter().map(|&from| row[from])).collect()
    };
    let (previous, states) = (waves(3 * n, 0.7), waves(3 * n, 1.9));
    let measurement = waves(graph.adapter.ncols(), 0.3);
    let moved = SystemGraph {
        shift: Mat::from_fn(n, n, |i, j| graph.shift[(order[i], order[j])]),
        adapter: Mat::from_fn(n, measurement.len(), |i, j| graph.adapter[(order[i], j)]),
    };
    let (means, log_q) = means_and_log_q(&mut proposal, graph, &previous, &measurement, &states);
    let (moved_means, moved_log_q) =
        means_and_log_q(&mut permuted, &moved, &permute(&previous), &measurement, &permute(&states));
    assert!(relative_distance(&moved_means, &permute(&means)) < 1e-10, "the means are not permuted");
    assert!(relative_distance(&moved_log_q, &log_q) < 1e-9, "z is not permuted: {moved_log_q:?} {log_q:?}");
}

#[test]
fn permuting_the_nodes_permutes_mean_and_z() {
    let (graph, order) = (graph_of(7), [3, 0, 6, 1, 5, 2, 4]);
    let n = order.len();
    let moved = SystemGraph {
        shift: Mat::from_fn(n, n, |i, j| graph.shift[(order[i], order[j])]),
        adapter: Mat::from_fn(n, graph.adapter.ncols(), |i, j| graph.adapter[(order[i], j)]),
    };
    let config = small_gnn(Adapter::Fixed);
    // The same weights: drawn from the same seed by name.
    check_permutation(gnn(&config, &graph), gnn(&config, &moved), &graph, &order);

    // Trained weights, carried over by name.
    let system =
        GraphDiffusion::random(&GraphDiffusionConfig::new(7), &mut Seed::from_u64(100).stream()).unwrap();
    let trained: Gnn = trained_family(&config, &system, 2, F64);
    let mut permuted = gnn(&config, &moved);
    for index in 0..trained.parameters().len() {
        let values = trained.parameters().host(index);
        permuted.parameters_mut().set_host(index, &values).unwrap();
    }
    check_permutation(trained, permuted, &graph, &order);
}

#[test]
fn a_node_beyond_the_reach_of_the_layers_has_no_influence() {
    let (n, graph) = (12, path(12));
    // Two layers of order 2 reach four edges.
    let config = GnnConfig { features: vec![6], order: 2, ..small_gnn(Adapter::Fixed) };
    let mut proposal = gnn(&config, &graph);
    let (previous, measurement) = (waves(n, 0.7), waves(n, 0.3));
    let mut changed = previous.clone();
    changed[0] += 5.0;
    let mut of =
        |previous: &[f64]| means_and_log_q(&mut proposal, &graph, previous, &measurement, &vec![0.0; n]).0;
    let (before, after) = (of(&previous), of(&changed));
    for node in 0..n {
        let moved = (before[node] - after[node]).abs();
        assert!(if node <= 4 { moved > 1e-9 } else { moved == 0.0 }, "node {node} moved by {moved:e}");
    }
}

#[test]
fn weights_but_for_c_do_not_depend_on_n() {
    let config = small_gnn(Adapter::Fixed);
    let small =
        GraphDiffusion::random(&GraphDiffusionConfig::new(6), &mut Seed::from_u64(1).stream()).unwrap();
    let large =
        GraphDiffusion::random(&GraphDiffusionConfig::new(9), &mut Seed::from_u64(2).stream()).unwrap();
    let trained: Gnn = trained_family(&config, &small, 3, F64);
    let mut other = Gnn::create(&config, &ModelShape::on_graph(&large), 3, F64, &Seed::from_u64(3)).unwrap();
    assert_eq!(trained.parameters().names(), other.parameters().names());
    for index in 0..trained.parameters().len() {
        let values = trained.parameters().host(index);
        let name = trained.parameters().names()[index].clone();
        let result = other.parameters_mut().set_host(index, &values);
        assert_eq!(result.is_ok(), name != "covariance.mixing", "{name}");
    }
    // Without training again it proposes for the larger system.
    let stream = Seed::from_u64(4).stream();
    let mut filter = ParticleFilter::new(&large, other, FilterSettings::new(10), stream).unwrap();
    (0..3).for_each(|_| filter.step(&[1.0; 7]).unwrap());

    // The same networks on two copies of a graph say the same of each copy.
    let (one, n) = (path(4), 4);
    let twice = |matrix: &Mat<f64>| {
        Mat::from_fn(2 * n, 2 * n, |i, j| if i / n == j / n { matrix[(i % n, j % n)] } else { 0.0 })
    };
    let two = SystemGraph { shift: twice(&one.shift), adapter: twice(&one.adapter) };
    let (previous, measurement) = (waves(n, 0.7), waves(n, 0.3));
    let mut alone = gnn(&config, &one);
    let (means, _) = means_and_log_q(&mut alone, &one, &previous, &measurement, &[0.0; 4]);
    let mut both = gnn(&config, &two);
    let repeated = |row: &[f64]| row.repeat(2);
    let (doubled, _) =
        means_and_log_q(&mut both, &two, &repeated(&previous), &repeated(&measurement), &[0.0; 8]);
    assert!(relative_distance(&doubled, &repeated(&means)) < 1e-12);
}

#[test]
fn a_system_without_a_graph_and_settings_that_cannot_be_are_refused() {
    let config = small_gnn(Adapter::Fixed);
    let model: &LinearGaussian = &reference().model;
    let error = Gnn::create(&config, &ModelShape::of(model), 3, F64, &Seed::from_u64(1)).err().unwrap();
    assert_eq!(error, ProposalError::NoGraph);
    assert!(error.to_string().starts_with("the model has no graph"), "{error}");
    let config = GnnConfig { features: vec![4, 0], ..config };
    let error = Gnn::create(&config, &ModelShape::on_graph(&Graphed(path(3))), 3, F64, &Seed::from_u64(1))
        .err()
        .unwrap();
    assert!(error.to_string().contains("[4, 0]"), "{error}");
    let lopsided = SystemGraph { shift: Mat::zeros(4, 3), ..path(3) };
    let error = Gnn::create(
        &small_gnn(Adapter::Fixed),
        &ModelShape::on_graph(&Graphed(lopsided)),
        3,
        F64,
        &Seed::from_u64(1),
    )
    .err()
    .unwrap();
    assert!(matches!(error, ProposalError::Mismatch { .. }), "{error}");
}

#[test]
fn the_number_of_weights_is_what_the_family_says_before_it_allocates_them() {
    for adapter in [Adapter::Fixed, Adapter::Learned] {
        let (config, graph) = (small_gnn(adapter), graph_of(6));
        let gnn = gnn(&config, &graph);
        let found: usize = (0..gnn.parameters().len()).map(|at| gnn.parameters().host(at).len()).sum();
        assert_eq!(
            Gnn::count(&config, &ModelShape::on_graph(&Graphed(graph.clone())), 2),
            Some(found),
            "{adapter:?}"
        );
    }
    let huge = GnnConfig { features: vec![usize::MAX], ..small_gnn(Adapter::Fixed) };
    assert_eq!(Gnn::count(&huge, &ModelShape::on_graph(&Graphed(graph_of(6))), 1), None);
}
