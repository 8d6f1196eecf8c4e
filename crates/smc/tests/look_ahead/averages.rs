//! Sites averaged over smoothed states: how well look-ahead filters know the evidence where measurements are skewed.

use motes_models::Step;
use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal, student_t};
use motes_smc::Bootstrap;

use crate::common::{evidence_by, evidence_of_runs, moments, rows, settings};
use crate::models::{Counts, Volatility};

/// The variance of the log-evidence by 50 particles.
fn variance(model: &impl Equations, seed: u64) -> f64 {
    let rows = rows(model, 200, seed);
    moments(&evidence_of_runs(model, &rows, 50, 100, Some(0.0))).1
}

/// Catches sites at the most likely states, by which the variances are 0.097 and 0.018.
#[test]
fn skewed_measurements_leave_little_to_weights() {
    let volatility = variance(&Volatility { sd: 0.3 }, 1);
    assert!(volatility < 0.015, "{volatility}");
    let counts = variance(&Counts { sd: 0.2 }, 2);
    assert!(counts < 0.007, "{counts}");
}

/// A level with outliers.
struct Outliers;

impl Equations for Outliers {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
        x[0] = draws.draw(normal(0.0, 1.0));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, before: &[S], draws: &mut impl Draws<S>, x: &mut [S]) {
        x[0] = draws.draw(normal(before[0], 0.3));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(student_t(3.0, x[0], 0.2));
    }
}

/// Catches a smoother that outliers hold where it begins, and potentials that believe them: the variance is then 0.39.
#[test]
fn outliers_are_passed_by() {
    let mut rows = rows(&Outliers, 100, 3);
    for row in rows.iter_mut().step_by(15) {
        row.measurement = vec![Some(30.0)];
    }
    let (found, variance) = moments(&evidence_of_runs(&Outliers, &rows, 100, 50, None));
    let (right, of_right) = moments(&evidence_by(&Outliers, Bootstrap, &rows, settings(20_000, None), 50, 5));
    let bias = found + 0.5 * variance - right - 0.5 * of_right;
    assert!(variance < 0.1 && bias.abs() < 4.0 * ((variance + of_right) / 50.0).sqrt());
}

/// A square hides the sign of the state, and paths do not converge.
struct Growth;

impl Equations for Growth {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
        x[0] = draws.draw(normal(0.0, 2.2));
    }

    fn transition<S: Scalar>(
        &self,
        step: &Step<'_, S>,
        before: &[S],
        draws: &mut impl Draws<S>,
        x: &mut [S],
    ) {
        let drift = before[0] * 0.5 + before[0] * 25.0 / (before[0] * before[0] + 1.0);
        x[0] = draws.draw(normal(drift + (step.time * 1.2).cos() * 8.0, 3.2));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0] * x[0] * 0.05, 1.0));
    }
}

/// Catches averages over states far from a path: some of these are then off by thousands.
#[test]
fn where_paths_do_not_converge_no_average_is_far_off() {
    for seed in 0..300 {
        let found = evidence_of_runs(&Growth, &rows(&Growth, 100, seed), 30, 1, None)[0];
        assert!(found > -1000.0, "{seed}: {found}");
    }
}
