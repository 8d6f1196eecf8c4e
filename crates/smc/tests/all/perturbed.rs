//! Filters whose particles have parameters that go a random walk.

use std::ops::ControlFlow;

use faer::mat;
use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
use motes_models::{
    Gaussian, LinearGaussian, Seed, Step, StepRecord, fill_standard_normal, kalman, simulate,
};
use motes_smc::{PerturbedFilter, RecordedStep};

/// A stationary walk that is measured with an offset, which is the parameter of each particle.
struct Offset;

impl Equations for Offset {
    fn dimensions(&self) -> [usize; 2] {
        [2, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, _: &mut impl Draws<S>, x: &mut [S]) {
        x.fill(S::from(f64::NAN));
    }

    fn transition<S: Scalar>(
        &self,
        step: &Step<'_, S>,
        before: &[S],
        draws: &mut impl Draws<S>,
        x: &mut [S],
    ) {
        let mean = if step.index == 0 { S::from(0.0) } else { before[0] * 0.8 };
        let sd = if step.index == 0 { 0.5 } else { 0.3 };
        x[0] = draws.draw(normal(mean, sd));
        x[1] = before[1];
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0] + x[1], 0.2));
    }
}

/// The same with the offset as a coordinate that goes the random walk.
fn joint(walk: f64) -> LinearGaussian {
    let initial = Gaussian::new("P_0", vec![0.0, 0.0], mat![[0.25, 0.0], [0.0, 4.0]]).unwrap();
    let (moves, noise) = (mat![[0.8, 0.0], [0.0, 1.0]], mat![[0.09, 0.0], [0.0, walk * walk]]);
    LinearGaussian::new(initial, moves, noise, mat![[1.0, 1.0]], mat![[0.04]]).unwrap()
}

#[test]
fn a_pass_estimates_the_evidence_of_the_perturbed_model_and_ends_at_its_posterior() {
    const RUNS: u64 = 60;
    const PARTICLES: usize = 500;
    let walk = 0.3;
    let model = joint(walk);
    let measurements = simulate(&model, 12, &mut Seed::from_u64(5).stream()).unwrap().measurements;
    let filtered = kalman::filter(&model, &measurements).unwrap();
    let of_row = |(index, row): (usize, &[f64])| RecordedStep {
        step: StepRecord::of(&Step::of_index(index)),
        measurement: row.iter().copied().map(Some).collect(),
    };
    let steps: Vec<RecordedStep> = measurements.rows().enumerate().map(of_row).collect();
    // A position is half of the offset.
    let parameters = |positions: &[f64], out: &mut [f64]| {
        out.iter_mut().zip(positions).for_each(|(out, v)| *out = 2.0 * v);
    };
    let filter = PerturbedFilter { model: &Offset, steps: &steps, dimension: 1, parameters: &parameters };
    let (mut ratios, mut means) = (Vec::new(), Vec::new());
    for run in 0..RUNS {
        let mut positions = vec![0.0; PARTICLES];
        let mut stream = Seed::from_u64(run).child("walk").stream();
        let mut perturb = |row: usize, positions: &mut [f64]| {
            let mut noise = vec![0.0; PARTICLES];
            fill_standard_normal(&mut stream, &mut noise);
            let sd = if row == 0 { 1.0 } else { 0.5 * walk };
            positions.iter_mut().zip(noise).for_each(|(v, noise)| *v += sd * noise);
            ControlFlow::Continue(())
        };
        let found = filter.pass(&mut positions, &mut perturb, &Seed::from_u64(run)).unwrap();
        ratios.push((found.expect("nobody stops it") - filtered.log_evidence()).exp());
        means.push(2.0 * positions.iter().sum::<f64>() / PARTICLES as f64);
    }
    let within = |values: &[f64], right: f64| {
        let mean = values.iter().sum::<f64>() / RUNS as f64;
        let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (RUNS - 1) as f64;
        let error = (variance / RUNS as f64).sqrt();
        assert!((mean - right).abs() < 4.0 * error, "{mean} ± {error} for {right}");
        error
    };
    assert!(within(&ratios, 1.0) < 0.1);
    let offset = filtered.steps.last().expect("twelve rows").filtered.mean[1];
    assert!(within(&means, offset) < 0.05);
}

#[test]
fn a_row_that_no_particle_explains_ends_no_pass_and_a_pass_can_be_stopped() {
    let row = |index: usize, y: f64| RecordedStep {
        step: StepRecord::of(&Step::of_index(index)),
        measurement: vec![Some(y)],
    };
    let steps = [row(0, 0.1), row(1, 1e200), row(2, 0.2)];
    let parameters = |positions: &[f64], out: &mut [f64]| out.copy_from_slice(positions);
    let filter = PerturbedFilter { model: &Offset, steps: &steps, dimension: 1, parameters: &parameters };
    let (mut positions, mut rows) = (vec![0.5; 64], 0);
    let mut perturb = |_: usize, _: &mut [f64]| {
        rows += 1;
        ControlFlow::Continue(())
    };
    let found = filter.pass(&mut positions, &mut perturb, &Seed::from_u64(1));
    assert_eq!((found, rows), (Ok(Some(f64::NEG_INFINITY)), 3));
    assert!(positions.iter().all(|v| *v == 0.5));
    let stopped = filter.pass(&mut positions, &mut |_, _| ControlFlow::Break(()), &Seed::from_u64(1));
    assert_eq!(stopped, Ok(None));
}
