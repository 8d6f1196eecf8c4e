//! Where a bootstrap filter is wrong and does not know it, 32 particles that look ahead are right.

use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
use motes_models::{Seed, Step};
use motes_smc::{Bootstrap, RecordedStep};
use rand::RngExt;

use crate::common::{bias, evidence_by, evidence_of_runs, gaussian_evidence, recorded, settings};
use crate::models::{Counts, Volatility, evidence_on_grid};

/// A slow level.
pub struct Level;

impl Equations for Level {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
        x[0] = draws.draw(normal(0.0, 1.0));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, before: &[S], draws: &mut impl Draws<S>, x: &mut [S]) {
        x[0] = draws.draw(normal(before[0], 0.1));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0], 0.3));
    }
}

/// The sum of a level and a season, whose amplitude hardly moves.
struct Season;

impl Equations for Season {
    fn dimensions(&self) -> [usize; 2] {
        [3, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
        let [level, a, b] = [1.0, 0.3, 0.3].map(|sd| draws.draw(normal(0.0, sd)));
        x[0] = level + a;
        (x[1], x[2]) = (a, b);
    }

    fn has_density(&self) -> bool {
        false
    }

    /// The first coordinate is the sum itself.
    fn transition<S: Scalar>(&self, _: &Step<'_, S>, before: &[S], draws: &mut impl Draws<S>, x: &mut [S]) {
        let (sin, cos) = (std::f64::consts::TAU / 12.0).sin_cos();
        let level = draws.draw(normal(before[0] - before[1], 0.03));
        x[1] = draws.draw(normal(before[1] * cos + before[2] * sin, 1e-6));
        x[2] = draws.draw(normal(before[2] * cos - before[1] * sin, 1e-6));
        x[0] = level + x[1];
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0], 0.08));
    }
}

/// Look-ahead filters of 32 particles are within 0.1.
fn check_look_ahead(model: &impl Equations, rows: &[RecordedStep], exact: f64) {
    for found in evidence_of_runs(model, rows, 32, 5, None) {
        assert!((found - exact).abs() < 0.1, "{found} and {exact}");
    }
}

/// So they are, and bootstrap filters of 1000 are too low by more than 10.
fn check(model: &impl Equations, rows: &[RecordedStep], exact: f64) {
    check_look_ahead(model, rows, exact);
    for found in evidence_by(model, Bootstrap, rows, settings(1000, None), 3, 1) {
        assert!(found < exact - 10.0, "{found} and {exact}");
    }
}

fn noise(count: usize) -> Vec<f64> {
    let mut stream = Seed::from_u64(9).stream();
    (0..count).map(|_| (0..12).map(|_| stream.random::<f64>()).sum::<f64>() - 6.0).collect()
}

/// Measurements of a level that the model does not expect.
pub fn level_that_jumps() -> Vec<RecordedStep> {
    let level = |t: usize| if t < 30 { 0.0 } else { 3.0 };
    recorded(noise(60).iter().enumerate().map(|(t, z)| Some(level(t) + 0.3 * z)))
}

#[test]
fn a_level_that_jumps() {
    let rows = level_that_jumps();
    check(&Level, &rows, gaussian_evidence(&Level, &rows));
}

#[test]
fn an_amplitude_that_hardly_moves() {
    let season = |t: usize| 0.4 * (std::f64::consts::TAU * t as f64 / 12.0).cos();
    let rows = recorded(noise(180).iter().enumerate().map(|(t, z)| Some(season(t) + 0.08 * z)));
    // Bootstrap filters are too low here as well, but by less than 10.
    check_look_ahead(&Season, &rows, gaussian_evidence(&Season, &rows));
}

#[test]
fn a_rate_that_jumps() {
    let model = Counts { sd: 0.05 };
    let rate = |t: usize| if t < 50 { 3.0 } else { 30.0 };
    let counts = noise(100);
    let counts =
        counts.iter().enumerate().map(|(t, z)| Some((rate(t) + rate(t).sqrt() * z).round().max(0.0)));
    let rows = recorded(counts);
    check(&model, &rows, evidence_on_grid(&model, &rows, [-2.0, 6.0], 1200));
}

#[test]
fn returns_of_an_unheard_of_size() {
    let model = Volatility { sd: 0.15 };
    let returns = noise(120);
    let size = |t: usize| if [40, 41, 80].contains(&t) { 9.0 } else { 0.7 };
    let rows = recorded(
        returns.iter().enumerate().map(|(t, z)| Some(size(t) * if size(t) > 1.0 { 1.0 } else { *z })),
    );
    let exact = evidence_on_grid(&model, &rows, [-8.0, 10.0], 1200);
    let runs = evidence_of_runs(&model, &rows, 32, 100, None);
    assert!(bias(&runs, exact).abs() < 4.0, "{}", bias(&runs, exact));
    for found in runs {
        assert!((found - exact).abs() < 1.0, "{found} and {exact}");
    }
}
