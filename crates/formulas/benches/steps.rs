//! What a step costs whose model is read from a file, beside the same model in Rust: `cargo bench -p motes-formulas --bench steps`.

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use motes_formulas::{FileModel, FormulaModel, parse};
use motes_models::batch::Rows;
use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
use motes_models::{Seed, StateGradients, StateSpaceModel, Step};

/// Particles of a call, as many as filters hand over at a time.
const PARTICLES: usize = 1024;

const GROWTH: &str = r#"
[initial]
x = "normal(0, sqrt(5))"
[transition]
x = "normal(x/2 + 25*x/(1 + x^2) + 8*cos(1.2*t), sqrt(10))"
[measurement]
y = "normal(x^2/20, 1)"
"#;

/// [`GROWTH`] by hand.
struct Growth;

impl Equations for Growth {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(0.0, 5.0_f64.sqrt()));
    }

    fn transition<S: Scalar>(&self, step: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        let x = x[0];
        let drift = x / 2.0 + x * 25.0 / (x * x + 1.0) + 8.0 * Scalar::cos(1.2 * step.time);
        state[0] = draws.draw(normal(drift, 10.0_f64.sqrt()));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], measurement: &mut impl Coordinates<S>) {
        measurement.push(normal(x[0] * x[0] / 20.0, 1.0));
    }
}

const LORENZ: &str = r#"
[initial]
x[40] = "normal(0, 3)"
[transition]
x[40] = "normal(x[i] + 0.05*((x[i+1] - x[i-2])*x[i-1] - x[i] + 8), 0.5)"
[measurement]
y[20] = "normal(x[2*i], 1)"
"#;

/// [`LORENZ`] by hand.
struct Lorenz;

impl Equations for Lorenz {
    fn dimensions(&self) -> [usize; 2] {
        [40, 20]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        (0..40).for_each(|i| state[i] = draws.draw(normal(0.0, 3.0)));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        for i in 0..40 {
            let [next, before, last] = [x[(i + 1) % 40], x[(i + 38) % 40], x[(i + 39) % 40]];
            state[i] = draws.draw(normal(x[i] + ((next - before) * last - x[i] + 8.0) * 0.05, 0.5));
        }
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], measurement: &mut impl Coordinates<S>) {
        (0..20).for_each(|i| measurement.push(normal(x[2 * i], 1.0)));
    }
}

fn read(text: &str) -> FormulaModel {
    match parse(text, "model.toml", &[]).expect("a model").model {
        FileModel::Formulas(model) => model,
        FileModel::LinearGaussian(_) => unreachable!("the file has formulas"),
    }
}

/// Each part of a step, for many particles in one call.
fn steps<M: StateSpaceModel + StateGradients>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    name: &str,
    model: &M,
) {
    let (n, m) = (model.state_dim(), model.measurement_dim());
    let mut streams = [Seed::from_u64(1).stream()];
    let mut before = vec![0.0; PARTICLES * n];
    model.sample_states(&Step::of_index(0), None, &mut streams, &mut before);
    let mut states = vec![0.0; PARTICLES * n];
    let (mut densities, measurement) = (vec![0.0; PARTICLES], vec![Some(0.5); m]);
    let mut slopes = [vec![0.0; PARTICLES * n], vec![0.0; PARTICLES * n]];
    group.throughput(Throughput::Elements(PARTICLES as u64));
    group.bench_function(BenchmarkId::new("draw", name), |bencher| {
        bencher.iter(|| {
            model.sample_states(&Step::of_index(7), Some(Rows::all(&before, n)), &mut streams, &mut states)
        });
    });
    group.bench_function(BenchmarkId::new("weigh", name), |bencher| {
        bencher.iter(|| model.log_likelihoods(&Step::of_index(7), &states, &measurement, &mut densities));
    });
    group.bench_function(BenchmarkId::new("log transition", name), |bencher| {
        bencher.iter(|| {
            model.density().unwrap().log_densities(
                &Step::of_index(7),
                Some(Rows::all(&before, n)),
                &states,
                &mut densities,
            )
        });
    });
    group.bench_function(BenchmarkId::new("gradients", name), |bencher| {
        let [a, b] = &mut slopes;
        bencher.iter(|| model.transition_gradients(&Step::of_index(7), &before, &states, a, b));
    });
}

fn growth(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("growth");
    steps(&mut group, "in Rust", &Growth);
    steps(&mut group, "of a file", &read(GROWTH));
}

fn lorenz(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("Lorenz 96, 40 coordinates");
    steps(&mut group, "in Rust", &Lorenz);
    steps(&mut group, "of a file", &read(LORENZ));
}

criterion_group!(benches, growth, lorenz);
criterion_main!(benches);
