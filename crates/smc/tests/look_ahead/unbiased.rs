//! The evidence is unbiased, whatever the model and the potentials; what is planted is not.

use motes_models::equations::Equations;
use motes_smc::{LookAhead, RecordedStep};

use crate::common::{bias, evidence_by, rows, settings};
use crate::models::{Counts, Store, Volatility, evidence_on_grid};
use crate::planted::{Bug, Wrong};

const RUNS: usize = 4000;
const PARTICLES: usize = 8;

/// By how many standard errors the evidence is off, with potentials of `of`.
fn off<M: Equations, O: Equations>(
    model: &M,
    of: &O,
    rows: &[RecordedStep],
    exact: f64,
    share: Option<f64>,
) -> f64 {
    let ahead = LookAhead::new(of, rows).unwrap();
    bias(&evidence_by(model, ahead, rows, settings(PARTICLES, share), RUNS, 5), exact)
}

/// The same with a bug.
fn off_with<M: Equations>(model: &M, rows: &[RecordedStep], exact: f64, bug: Bug) -> f64 {
    let wrong = Wrong { ahead: LookAhead::new(model, rows).unwrap(), bug };
    bias(&evidence_by(model, wrong, rows, settings(PARTICLES, Some(0.0)), RUNS, 5), exact)
}

#[test]
fn of_counts() {
    let model = Counts { sd: 0.3 };
    let rows = rows(&model, 15, 1);
    let exact = evidence_on_grid(&model, &rows, [-6.0, 8.0], 1500);
    for share in [None, Some(0.3)] {
        let off = off(&model, &model, &rows, exact, share);
        assert!(off.abs() < 4.0, "share {share:?}: {off}");
    }
}

#[test]
fn of_volatility() {
    let model = Volatility { sd: 0.6 };
    let rows = rows(&model, 15, 2);
    let exact = evidence_on_grid(&model, &rows, [-10.0, 10.0], 1500);
    for share in [None, Some(0.3)] {
        let off = off(&model, &model, &rows, exact, share);
        assert!(off.abs() < 4.0, "share {share:?}: {off}");
    }
}

#[test]
fn where_states_are_not_linear_in_their_noise() {
    let model = Store { sd: 0.6 };
    let rows = rows(&model, 12, 3);
    let exact = evidence_on_grid(&model, &rows, [0.0, 16.0], 6000);
    for share in [None, Some(0.0), Some(0.4)] {
        let off = off(&model, &model, &rows, exact, share);
        assert!(off.abs() < 4.0, "share {share:?}: {off}");
    }
}

/// Of another model: too wide, so that weights have a variance.
#[test]
fn with_wrong_potentials() {
    let model = Counts { sd: 0.3 };
    let rows = rows(&model, 12, 4);
    let exact = evidence_on_grid(&model, &rows, [-6.0, 8.0], 1500);
    let off = off(&model, &Counts { sd: 1.0 }, &rows, exact, Some(0.3));
    assert!(off.abs() < 4.0, "{off}");
}

/// Of few steps: after many, weights without `Z̃` vary so much that no mean can be trusted.
#[test]
fn the_expectation_of_the_next_step_left_out_is_seen() {
    let model = Counts { sd: 0.3 };
    let rows = rows(&model, 3, 1);
    let exact = evidence_on_grid(&model, &rows, [-6.0, 8.0], 1500);
    let right = off(&model, &model, &rows, exact, Some(0.0));
    assert!(right.abs() < 4.0, "{right}");
    let off = off_with(&model, &rows, exact, Bug::WithoutNext);
    assert!(off.abs() > 4.0, "{off}");
}

/// Expectations of other times cancel nearly, so that a few thousand runs may show no bias: the variance tells.
#[test]
fn potentials_shifted_by_a_step_are_seen() {
    let model = Counts { sd: 0.3 };
    let rows = rows(&model, 15, 1);
    let exact = evidence_on_grid(&model, &rows, [-6.0, 8.0], 1500);
    let logs = |shifted: bool| {
        let ahead = LookAhead::new(&model, &rows).unwrap();
        match shifted {
            false => evidence_by(&model, ahead, &rows, settings(PARTICLES, Some(0.0)), RUNS, 5),
            true => {
                let wrong = Wrong { ahead, bug: Bug::Shifted };
                evidence_by(&model, wrong, &rows, settings(PARTICLES, Some(0.0)), RUNS, 5)
            }
        }
    };
    let variance = |logs: &[f64]| {
        let mean = logs.iter().sum::<f64>() / logs.len() as f64;
        logs.iter().map(|log| (log - mean).powi(2)).sum::<f64>() / logs.len() as f64
    };
    let [right, shifted] = [false, true].map(logs);
    assert!(bias(&right, exact).abs() < 4.0, "{}", bias(&right, exact));
    assert!(variance(&shifted) > 5.0 * variance(&right), "{} and {}", variance(&shifted), variance(&right));
}

#[test]
fn the_potential_of_the_state_instead_of_the_line_is_seen() {
    let model = Store { sd: 0.6 };
    let rows = rows(&model, 12, 3);
    let exact = evidence_on_grid(&model, &rows, [0.0, 16.0], 6000);
    let off = off_with(&model, &rows, exact, Bug::AtState);
    assert!(off.abs() > 4.0, "{off}");
}
