//! The transform: forth and back, its density, and its determinant against the dense Jacobian.

use faer::{Mat, MatRef};
use motes_models::{GraphDiffusion, GraphDiffusionConfig, ModelShape, Seed, Step};
use motes_proposals::networks::Inputs;
use motes_proposals::{
    Backend, Compute, Family, Learnable, Parametric, Precision, Psi, PsiConfig, PsiScratch, Workspace,
};
use motes_smc::{Conditional, Context, Proposal, ProposalError};
use motes_tests::trained_family;
use rand::RngExt;

const F64: Compute = Compute { backend: Backend::Native, precision: Precision::F64 };

fn system(n: usize) -> GraphDiffusion {
    let config = GraphDiffusionConfig {
        measurement_dim: n.div_ceil(2),
        neighbours: 1,
        ..GraphDiffusionConfig::new(n)
    };
    let adjacency = Mat::from_fn(n, n, |i, j| if i.abs_diff(j) == 1 { 0.5 } else { 0.1 });
    GraphDiffusion::on_graph(&config, adjacency.as_ref()).unwrap()
}

fn psi(n: usize, layers: usize) -> Psi {
    Psi::create(
        &PsiConfig { layers, ridge: 0.0, ..PsiConfig::paper() },
        &ModelShape::of(&system(n)),
        2,
        F64,
        &Seed::from_u64(90),
    )
    .unwrap()
}

fn uniform(count: usize, seed: u64) -> Vec<f64> {
    let mut stream = Seed::from_u64(seed).stream();
    (0..count).map(|_| stream.random()).collect()
}

/// A random orthogonal matrix times `scale`, row-major.
fn orthogonal(n: usize, seed: u64, scale: f64) -> Vec<f64> {
    let values: Vec<f64> = uniform(n * n, seed).iter().map(|u| u - 0.5).collect();
    let q = MatRef::from_row_major_slice(&values, n, n).qr().compute_Q();
    (0..n * n).map(|at| scale * q[(at / n, at % n)]).collect()
}

/// Every square matrix orthogonal times 0.9: well conditioned.
fn well_conditioned(n: usize) -> Psi {
    let mut psi = psi(n, 9);
    for index in 0..psi.parameters().len() {
        let name = psi.parameters().names()[index].clone();
        if name.ends_with("weight") || name.ends_with("noise") {
            psi.parameters_mut().set_host(index, &orthogonal(n, 91 + index as u64, 0.9)).unwrap();
        }
    }
    psi
}

struct Drawn {
    noise: Vec<f64>,
    states: Vec<f64>,
    along: Vec<f64>,
}

fn inputs<'a>(n: usize, previous: &'a [f64], measurement: &'a [f64]) -> Inputs<'a> {
    Inputs { time: 1, width: n, previous: Some(previous), measurement, particles: previous.len() / n }
}

/// The same for a filter.
fn context<'a>(inputs: &Inputs<'a>) -> Context<'a> {
    Context::new(Step::of_index(inputs.time), inputs.previous, inputs.particles)
}

/// Draws through the tape, which takes the noise that it is given.
fn draw(psi: &Psi, inputs: &Inputs<'_>, n: usize, seed: u64) -> Drawn {
    let noise = uniform(inputs.particles * n, seed);
    let (mut states, mut along) = (vec![0.0; noise.len()], vec![0.0; inputs.particles]);
    psi.tape(inputs.particles, Workspace::new(psi.parameters()))
        .unwrap()
        .draw(inputs, &noise, &mut states, Some(&mut along))
        .unwrap();
    Drawn { noise, states, along }
}

#[test]
fn back_and_forth_for_well_conditioned_weights() {
    for n in [1, 2, 5, 10] {
        let psi = well_conditioned(n);
        let (previous, measurement) = (uniform(20 * n, 92), uniform(n.div_ceil(2), 93));
        let inputs = inputs(n, &previous, &measurement);
        let Drawn { noise, states, along } = draw(&psi, &inputs, n, 94);
        let (mut back, mut at) = (vec![0.0; noise.len()], vec![0.0; 20]);
        psi.inverse(&inputs, &states, &mut back, &mut at).unwrap();
        let error = noise.iter().zip(&back).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error < 1e-8, "N = {n}: the noise comes back with an error of {error:e}");
        for (along, at) in along.iter().zip(&at) {
            assert!((along - at).abs() < 1e-8 * along.abs().max(1.0), "N = {n}: {along} and {at}");
        }
    }
}

/// The matrix of that name, row-major.
fn named(psi: &Psi, name: &str) -> Vec<f64> {
    let index = psi.parameters().names().iter().position(|found| found == name).unwrap();
    psi.parameters().host(index)
}

/// The transform and its dense Jacobian `∂x/∂u`, from the paper's formula with plain loops.
fn by_hand(
    psi: &Psi,
    layers: usize,
    ridge: f64,
    noise: &[f64],
    previous: &[f64],
    measurement: &[f64],
) -> (Vec<f64>, Mat<f64>) {
    let n = noise.len();
    let product = |values: &[f64], name: &str, ridge: f64| -> Vec<f64> {
        let matrix = named(psi, name);
        let entry = |i: usize, j: usize| matrix[i * n + j] + if i == j { ridge } else { 0.0 };
        (0..n).map(|j| values.iter().enumerate().map(|(i, v)| v * entry(i, j)).sum()).collect()
    };
    let times = |jacobian: &Mat<f64>, name: &str| {
        let matrix = named(psi, name);
        let square = Mat::from_fn(n, n, |i, j| matrix[i * n + j] + if i == j { ridge } else { 0.0 });
        square.transpose() * jacobian
    };
    let add = |a: Vec<f64>, b: Vec<f64>| -> Vec<f64> { a.iter().zip(&b).map(|(a, b)| a + b).collect() };
    let mut values = product(noise, "psi.1.noise", ridge);
    values = add(values, product(previous, "psi.1.previous", 0.0));
    values = add(values, product(measurement, "psi.1.measurement", 0.0));
    let mut jacobian = times(&Mat::identity(n, n), "psi.1.noise");
    for layer in 0..layers {
        for (i, value) in values.iter_mut().enumerate() {
            let slope = 1.0 - value.tanh().powi(2);
            *value = value.tanh();
            (0..n).for_each(|j| jacobian[(i, j)] *= slope);
        }
        let name = format!("psi.1.{layer}.weight");
        values = add(product(&values, &name, ridge), named(psi, &format!("psi.1.{layer}.bias")));
        jacobian = times(&jacobian, &name);
    }
    (values, jacobian)
}

fn check_log_q(psi: &Psi, n: usize, layers: usize, ridge: f64, tolerance: f64) {
    let (previous, measurement) = (uniform(3 * n, 95), uniform(n.div_ceil(2), 96));
    let Drawn { noise, states, along } = draw(psi, &inputs(n, &previous, &measurement), n, 97);
    for (row, found) in along.iter().enumerate() {
        let at = row * n..(row + 1) * n;
        let (state, jacobian) =
            by_hand(psi, layers, ridge, &noise[at.clone()], &previous[at.clone()], &measurement);
        for (found, expected) in states[at].iter().zip(&state) {
            assert!((found - expected).abs() < 1e-12);
        }
        let log_det: f64 = jacobian.singular_values().unwrap().iter().map(|value| value.ln()).sum();
        assert!((found + log_det).abs() < tolerance * log_det.abs().max(1.0), "{found} for {}", -log_det);
    }
}

#[test]
fn log_q_is_that_of_the_dense_jacobian() {
    for n in [1, 3, 8] {
        check_log_q(&well_conditioned(n), n, 9, 0.0, 1e-9);
        // As initialised the dense Jacobian is badly conditioned, which the product of factors is not.
        check_log_q(&psi(n, 3), n, 3, 0.0, 1e-9);
    }
}

#[test]
fn log_q_of_a_trained_transform_is_that_of_the_dense_jacobian() {
    let config = PsiConfig { layers: 3, ..PsiConfig::paper() };
    let psi = trained_family::<Psi>(&config, &system(4), 2, F64);
    check_log_q(&psi, 4, 3, 1e-3, 1e-9);
}

/// The integral of the density over a box around its image, by the midpoint rule with `count` points a side.
fn integral(psi: &mut Psi, n: usize, count: usize) -> f64 {
    let system = system(n);
    let measurement = vec![-0.2; n.div_ceil(2)];
    let drawn = draw(psi, &inputs(n, &vec![0.3; 2000 * n], &measurement), n, 99);
    let sides: Vec<(f64, f64)> = (0..n)
        .map(|d| {
            let values = drawn.states.iter().skip(d).step_by(n);
            let low = values.clone().copied().fold(f64::INFINITY, f64::min);
            let high = values.copied().fold(f64::NEG_INFINITY, f64::max);
            (low - 0.1 * (high - low), high + 0.1 * (high - low))
        })
        .collect();
    let steps: Vec<f64> = sides.iter().map(|(low, high)| (high - low) / count as f64).collect();
    let total = count.pow(n as u32);
    let coordinate =
        |at: usize, d: usize| sides[d].0 + steps[d] * ((at / count.pow(d as u32) % count) as f64 + 0.5);
    let states: Vec<f64> =
        (0..total).flat_map(|at| (0..n).map(move |d| (at, d))).map(|(at, d)| coordinate(at, d)).collect();
    let previous = vec![0.3; total * n];
    let mut log_density = vec![0.0; total];
    let inputs = inputs(n, &previous, &measurement);
    psi.condition_batch(&system, context(&inputs), &measurement, &mut (), &mut PsiScratch::default())
        .unwrap()
        .log_density(&states, &mut log_density);
    let outside = log_density.iter().filter(|value| **value == f64::NEG_INFINITY).count();
    assert!(outside > total / 10, "the grid does not reach beyond the image");
    steps.iter().product::<f64>() * log_density.iter().map(|value| value.exp()).sum::<f64>()
}

#[test]
fn the_density_integrates_to_one() {
    let found = integral(&mut psi(1, 2), 1, 100_000);
    assert!((found - 1.0).abs() < 1e-4, "one dimension: {found}");
    let found = integral(&mut well_conditioned(2), 2, 1000);
    assert!((found - 1.0).abs() < 1e-3, "two dimensions: {found}");
    // As initialised the image is a sliver, of which a grid sees the edges less sharply.
    let found = integral(&mut psi(2, 3), 2, 1000);
    assert!((found - 1.0).abs() < 1e-2, "two dimensions, as initialised: {found}");
}

#[test]
fn outside_the_image_the_density_is_zero_and_where_it_cannot_be_told_the_error_is_typed() {
    let system = system(2);
    let mut psi = well_conditioned(2);
    let (previous, measurement) = ([0.1, 0.2], [0.5]);
    let inputs = inputs(2, &previous, &measurement);
    let mut log_density = [0.0];
    psi.condition_batch(&system, context(&inputs), &measurement, &mut (), &mut PsiScratch::default())
        .unwrap()
        .log_density(&[50.0, 0.0], &mut log_density);
    assert_eq!(log_density[0], f64::NEG_INFINITY);

    // So large a first matrix saturates tanh: what was drawn cannot be found again.
    let index = psi.parameters().names().iter().position(|name| name == "psi.1.noise").unwrap();
    psi.parameters_mut().set_host(index, &[200.0, 0.0, 0.0, 200.0]).unwrap();
    let Drawn { states, along, .. } = draw(&psi, &inputs, 2, 98);
    assert!(along[0].is_finite());
    let (mut noise, mut log_density) = ([0.0; 2], [0.0]);
    let error = psi.inverse(&inputs, &states, &mut noise, &mut log_density).unwrap_err();
    assert!(matches!(error, ProposalError::Numerical { particle: 0, .. }), "{error}");

    psi.parameters_mut().set_host(index, &[1.0, 2.0, 2.0, 4.0]).unwrap();
    let error = psi
        .condition_batch(&system, context(&inputs), &measurement, &mut (), &mut PsiScratch::default())
        .err()
        .unwrap();
    assert!(matches!(error, ProposalError::Singular { time: 1, .. }), "{error}");
    assert!(error.to_string().starts_with("the matrix psi.1.noise at time 1 is singular"), "{error}");
}

#[test]
fn badly_conditioned_transforms_come_back_as_well_as_their_condition_allows_or_not_at_all() {
    let n = 6;
    let mut told = 0;
    for seed in 0..20 {
        let config = PsiConfig::paper();
        let psi =
            Psi::create(&config, &ModelShape::of(&system(n)), 2, F64, &Seed::from_u64(900 + seed)).unwrap();
        let (previous, measurement) = (uniform(n, 92), uniform(n.div_ceil(2), 93));
        let inputs = inputs(n, &previous, &measurement);
        let Drawn { noise, states, .. } = draw(&psi, &inputs, n, 94);
        let (_, jacobian) = by_hand(&psi, 9, 1e-3, &noise, &previous, &measurement);
        let values = jacobian.singular_values().unwrap();
        let condition = values[0] / values[n - 1];
        let (mut back, mut at) = (vec![0.0; n], [0.0]);
        if psi.inverse(&inputs, &states, &mut back, &mut at).is_ok() && at[0].is_finite() {
            let error = noise.iter().zip(&back).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // The state is recovered relative to its size, which the biases make larger than the largest singular value.
            let size = states.iter().map(|x| x * x).sum::<f64>().sqrt().max(values[0]) / values[0];
            let bound = 1e3 * f64::EPSILON * condition * size;
            assert!(error < bound, "seed {seed}: error {error:e} for a condition number of {condition:e}");
            told += 1;
        }
    }
    assert!(told >= 10, "only {told} of 20 came back at all");
}

#[test]
fn settings_that_cannot_be_are_refused() {
    let new = |layers, ridge, horizon| {
        Psi::create(
            &PsiConfig { layers, ridge, ..PsiConfig::paper() },
            &ModelShape::of(&system(3)),
            horizon,
            F64,
            &Seed::from_u64(1),
        )
        .err()
    };
    let told = |error: Option<ProposalError>| error.unwrap().to_string();
    assert_eq!(
        told(new(9, -1e-3, 2)),
        "the ridge of the transform is -0.001; it must be at least 0 and finite"
    );
    assert!(told(new(0, 1e-3, 2)).contains("layers"));
    assert!(told(new(9, 1e-3, 0)).contains("horizon"));
    let mut psi = psi(3, 2);
    let past = Context::new(Step::of_index(2), Some(&[0.0; 3]), 1);
    let error =
        psi.condition_batch(&system(3), past, &[0.0; 2], &mut (), &mut PsiScratch::default()).err().unwrap();
    assert_eq!(error, ProposalError::PastHorizon { horizon: 2, time: 2 });
}
