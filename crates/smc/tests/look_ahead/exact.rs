//! Where all is linear and Gaussian, looking ahead gives the evidence without error.

use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
use motes_models::{Step, StepRecord};
use motes_smc::RecordedStep;

use crate::common::{evidence_of_runs, gaussian_evidence, moments, recorded};

/// A position without noise of its own, moved by a velocity that is reduced by a half within a unit of time; the position is measured. Where it starts is known.
struct DampedMotion {
    start_is_known: bool,
}

impl Equations for DampedMotion {
    fn dimensions(&self) -> [usize; 2] {
        [2, 1]
    }

    fn has_density(&self) -> bool {
        false
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
        x[0] = if self.start_is_known { S::from(1.5) } else { draws.draw(normal(1.0, 2.0)) };
        x[1] = draws.draw(normal(0.3, 0.5));
    }

    fn transition<S: Scalar>(&self, at: &Step<'_, S>, before: &[S], draws: &mut impl Draws<S>, x: &mut [S]) {
        x[0] = before[0] + before[1] * at.length;
        x[1] = draws.draw(normal(before[1] * 0.5_f64.powf(at.length), 0.4 * at.length.sqrt()));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0], 0.3));
    }
}

/// Two coordinates that are draws of their own, of which the first is measured.
struct Plain;

impl Equations for Plain {
    fn dimensions(&self) -> [usize; 2] {
        [2, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
        x[0] = draws.draw(normal(100.0, 2.0));
        x[1] = draws.draw(normal(0.0, 1.0));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, now: &mut [S]) {
        now[0] = draws.draw(normal(x[0] + x[1], 0.1));
        now[1] = draws.draw(normal(x[1] * 0.95, 0.2));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0], 0.5));
    }
}

/// The variance of the log-evidence is below 1e-20, and its mean that of the joint Gaussian.
fn check(model: &impl Equations, rows: &[RecordedStep]) {
    let found = evidence_of_runs(model, rows, 50, 20, None);
    let (mean, variance) = moments(&found);
    let exact = gaussian_evidence(model, rows);
    assert!(variance < 1e-20, "variance {variance:e}");
    assert!((mean - exact).abs() < 1e-8, "{mean} and {exact}");
}

#[test]
fn coordinates_that_are_draws() {
    let mut rows = recorded((0..40).map(|t| Some(100.0 + f64::from(t) * 0.7)));
    rows[7].measurement[0] = None;
    rows[8].measurement[0] = None;
    rows[39].measurement[0] = None;
    check(&Plain, &rows);
}

#[test]
fn a_coordinate_without_noise() {
    for start_is_known in [false, true] {
        let mut rows = recorded((0..40).map(|t| Some((f64::from(t) * 0.4).sin())));
        rows[0].measurement[0] = None;
        rows[20].measurement[0] = None;
        check(&DampedMotion { start_is_known }, &rows);
    }
}

/// Steps of unequal lengths, some cut into sub-steps, some at the time of the row before.
#[test]
fn irregular_times_and_sub_steps() {
    let lengths = [0.5, 1.0, 0.0, 0.25, 2.0, 3.0, 0.1, 0.0, 1.0, 0.7];
    let sub_steps = [1, 2, 0, 1, 4, 1, 1, 0, 3, 1];
    let (mut rows, mut time) = (recorded([Some(1.2)].into_iter()), 0.0);
    for (at, (length, sub_steps)) in lengths.into_iter().zip(sub_steps).enumerate() {
        time += length;
        let step = Step { time, length, sub_steps, ..Step::of_index(at + 1) };
        let measurement = vec![(at != 4).then_some(1.0 + 0.2 * (at as f64).cos())];
        rows.push(RecordedStep { step: StepRecord::of(&step), measurement });
    }
    for start_is_known in [false, true] {
        check(&DampedMotion { start_is_known }, &rows);
    }
}
