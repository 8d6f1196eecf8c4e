//! What gradients cost that nobody wrote by hand: `cargo bench -p motes-models --bench duals`.
//!
//! The gradient of a log-likelihood in the state, for 1024 particles in one call: by hand, by [`StateGradients`] of a model that is stated once, and by
//! `num-dual`, particle by particle. All three give the same numbers, which is checked first.

use std::hint::black_box;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
use motes_models::{Seed, StateGradients, StateSpaceModel, Step};
use num_dual::{DualNum, DualSVec64, gradient};

const PARTICLES: usize = 1024;

/// The growth model.
struct Growth;

impl Equations for Growth {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    #[inline(always)]
    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(0.0, 5.0_f64.sqrt()));
    }

    #[inline(always)]
    fn transition<S: Scalar>(&self, step: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        let x = x[0];
        let drift = x / 2.0 + x * 25.0 / (x * x + 1.0) + 8.0 * (1.2 * step.time).cos();
        state[0] = draws.draw(normal(drift, 10.0_f64.sqrt()));
    }

    #[inline(always)]
    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], measurement: &mut impl Coordinates<S>) {
        measurement.push(normal(x[0] * x[0] / 20.0, 1.0));
    }
}

/// A target in the plane that is seen by distance and direction.
struct Target;

impl Equations for Target {
    fn dimensions(&self) -> [usize; 2] {
        [4, 2]
    }

    #[inline(always)]
    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        let starts = [(5.0, 1.0), (5.0, 1.0), (0.2, 0.1), (-0.1, 0.1)];
        for (state, (mean, sd)) in state.iter_mut().zip(starts) {
            *state = draws.draw(normal(mean, sd));
        }
    }

    #[inline(always)]
    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        (0..2).for_each(|i| state[i] = draws.draw(normal(x[i] + x[i + 2], 0.05)));
        (2..4).for_each(|i| state[i] = draws.draw(normal(x[i], 0.05)));
    }

    #[inline(always)]
    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal((x[0] * x[0] + x[1] * x[1]).sqrt(), 0.1));
        y.push(normal(x[1].atan2(x[0]), 0.02));
    }
}

/// What the growth model's likelihood comes from, up to a constant.
fn growth_exponent<const N: usize>([x]: [DualSVec64<N>; 1], y: &[f64]) -> DualSVec64<N> {
    let z = x * x / 20.0 - y[0];
    z * z * -0.5
}

fn growth_by_hand(states: &[f64], y: &[f64], slopes: &mut [f64]) {
    for (x, slope) in states.iter().zip(slopes) {
        *slope = (y[0] - x * x / 20.0) * x / 10.0;
    }
}

/// What the target's likelihood comes from, up to a constant.
fn target_exponent<const N: usize>([a, b, _, _]: [DualSVec64<N>; 4], y: &[f64]) -> DualSVec64<N> {
    let distance = ((a * a + b * b).sqrt() - y[0]) / 0.1;
    let direction = (b.atan2(a) - y[1]) / 0.02;
    (distance * distance + direction * direction) * -0.5
}

fn target_by_hand(states: &[f64], y: &[f64], slopes: &mut [f64]) {
    for (x, slope) in states.chunks_exact(4).zip(slopes.chunks_exact_mut(4)) {
        let square = x[0] * x[0] + x[1] * x[1];
        let distance = square.sqrt();
        let by_distance = (y[0] - distance) / (0.1 * 0.1) / distance;
        let by_direction = (y[1] - x[1].atan2(x[0])) / (0.02 * 0.02) / square;
        slope[0] = by_distance * x[0] - by_direction * x[1];
        slope[1] = by_distance * x[1] + by_direction * x[0];
        slope[2..].fill(0.0);
    }
}

/// Particle by particle with numbers that carry `N` derivatives.
fn by_num_dual<const N: usize>(
    states: &[f64],
    slopes: &mut [f64],
    exponent: impl Fn([DualSVec64<N>; N]) -> DualSVec64<N>,
) {
    let (states, slopes) = (states.as_chunks::<N>().0, slopes.as_chunks_mut::<N>().0);
    for (state, slope) in states.iter().zip(slopes) {
        let (_, found) = gradient(|x: nalgebra::SVector<_, N>| exponent(x.into()), &(*state).into());
        *slope = found.into();
    }
}

/// Times the three ways.
fn ways<M: StateSpaceModel + StateGradients>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    model: &M,
    measurement: &[f64],
    by_hand: impl Fn(&[f64], &[f64], &mut [f64]),
    by_num_dual: impl Fn(&[f64], &[f64], &mut [f64]),
) {
    let n = model.state_dim();
    let mut states = vec![0.0; PARTICLES * n];
    model.sample_states(&Step::of_index(0), None, &mut [Seed::from_u64(1).stream()], &mut states);
    let [mut hand, mut stated, mut peer] =
        [const { Vec::new() }; 3].map(|_: Vec<f64>| vec![0.0; PARTICLES * n]);
    by_hand(&states, measurement, &mut hand);
    model.likelihood_gradients(&Step::of_index(3), &states, measurement, &mut stated);
    by_num_dual(&states, measurement, &mut peer);
    for ((hand, stated), peer) in hand.iter().zip(&stated).zip(&peer) {
        let allowed = 1e-9 * (1.0 + hand.abs());
        assert!((hand - stated).abs() < allowed && (hand - peer).abs() < allowed, "{hand} {stated} {peer}");
    }
    group.throughput(Throughput::Elements(PARTICLES as u64));
    group.bench_function("by hand", |bencher| {
        bencher.iter(|| by_hand(black_box(&states), measurement, &mut hand));
    });
    group.bench_function("stated once", |bencher| {
        bencher.iter(|| {
            model.likelihood_gradients(&Step::of_index(3), black_box(&states), measurement, &mut stated)
        });
    });
    group.bench_function("num-dual", |bencher| {
        bencher.iter(|| by_num_dual(black_box(&states), measurement, &mut peer));
    });
}

fn duals(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("growth");
    ways(&mut group, &Growth, &[0.7], growth_by_hand, |states, y, slopes| {
        by_num_dual(states, slopes, |x| growth_exponent(x, y));
    });
    group.finish();
    let mut group = criterion.benchmark_group("range and bearing");
    ways(&mut group, &Target, &[7.0, 0.8], target_by_hand, |states, y, slopes| {
        by_num_dual(states, slopes, |x| target_exponent(x, y));
    });
}

criterion_group!(benches, duals);
criterion_main!(benches);
