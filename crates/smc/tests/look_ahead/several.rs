//! Potentials that are sums of several quadratics, and that came from elsewhere.

use motes_models::equations::Equations;
use motes_models::{Seed, Step, StepRecord};
use motes_smc::{Bootstrap, LookAhead, LookAheadError, PotentialComponent, RecordedStep};
use rand::RngExt;

use crate::common::{bias, evidence_by, moments, rows, settings};
use crate::models::{Counts, Store, Volatility, evidence_on_grid};
use crate::planted::{Bug, Wrong};

const RUNS: usize = 4000;
const PARTICLES: usize = 8;

/// Two quadratics and a flat one at each step, around the smoothed path but wrong on purpose.
fn potentials(model: &impl Equations, rows: &[RecordedStep], seed: u64) -> Vec<Vec<PotentialComponent>> {
    let mut stream = Seed::from_u64(seed).stream();
    let path: Vec<f64> = LookAhead::new(model, rows).unwrap().path().map(|state| state[0]).collect();
    let mut quadratic = |centre: f64| PotentialComponent {
        log_weight: stream.random_range(-1.0..1.0),
        centre: vec![centre + stream.random_range(-0.5..0.5)],
        root: vec![stream.random_range(0.5..2.0)],
    };
    let flat = PotentialComponent { log_weight: -1.0, centre: vec![0.0], root: vec![] };
    path.into_iter().map(|x| vec![quadratic(x), quadratic(x), flat.clone()]).collect()
}

fn off(model: &impl Equations, rows: &[RecordedStep], range: [f64; 2], share: Option<f64>) -> f64 {
    let exact = evidence_on_grid(model, rows, range, 3000);
    let ahead = LookAhead::from_potentials(model, rows, &potentials(model, rows, 6)).unwrap();
    bias(&evidence_by(model, ahead, rows, settings(PARTICLES, share), RUNS, 5), exact)
}

#[test]
fn the_evidence_of_counts_is_unbiased() {
    let model = Counts { sd: 0.3 };
    for share in [None, Some(0.3)] {
        let off = off(&model, &rows(&model, 15, 1), [-6.0, 8.0], share);
        assert!(off.abs() < 4.0, "share {share:?}: {off}");
    }
}

#[test]
fn the_evidence_of_volatility_is_unbiased() {
    let model = Volatility { sd: 0.6 };
    let off = off(&model, &rows(&model, 15, 2), [-10.0, 10.0], None);
    assert!(off.abs() < 4.0, "{off}");
}

#[test]
fn the_evidence_is_unbiased_where_states_are_not_linear_in_their_noise() {
    let model = Store { sd: 0.6 };
    for share in [None, Some(0.0)] {
        let off = off(&model, &rows(&model, 12, 3), [0.0, 16.0], share);
        assert!(off.abs() < 4.0, "share {share:?}: {off}");
    }
}

/// Catches a step without noise, to which each of several quadratics has nothing to say: two rows of one time.
#[test]
fn two_rows_of_one_time_are_two_measurements_of_one_state() {
    let model = Counts { sd: 0.3 };
    let mut rows = rows(&model, 6, 1);
    rows[2].step = StepRecord::of(&Step { length: 0.0, sub_steps: 0, ..Step::of_index(2) });
    let ahead = LookAhead::from_potentials(&model, &rows, &potentials(&model, &rows, 6)).unwrap();
    let mean = |logs: &[f64]| {
        let (mean, variance) = moments(&logs.iter().map(|log| log.exp()).collect::<Vec<f64>>());
        (mean, variance / logs.len() as f64)
    };
    let (found, error) = mean(&evidence_by(&model, ahead, &rows, settings(64, None), 400, 5));
    let (right, its_error) = mean(&evidence_by(&model, Bootstrap, &rows, settings(2000, None), 400, 7));
    assert!((found - right).abs() < 4.0 * (error + its_error).sqrt(), "{found} {right}");
}

#[test]
fn what_is_planted_shows() {
    let model = Counts { sd: 0.3 };
    let rows = rows(&model, 15, 1);
    let exact = evidence_on_grid(&model, &rows, [-6.0, 8.0], 3000);
    let ahead = LookAhead::from_potentials(&model, &rows, &potentials(&model, &rows, 6)).unwrap();
    let wrong = Wrong { ahead, bug: Bug::WithoutNext };
    let off = bias(&evidence_by(&model, wrong, &rows, settings(PARTICLES, Some(0.0)), RUNS, 5), exact);
    assert!(off.abs() > 10.0, "{off}");
}

/// A quadratic that is written as two halves of itself says the same: weights and draws of the sum are those of one.
#[test]
fn two_halves_are_as_good_as_the_whole() {
    let model = Counts { sd: 0.3 };
    let rows = rows(&model, 40, 4);
    let designed = LookAhead::new(&model, &rows).unwrap();
    let near = |state: f64, index: usize| designed.log_potential(index, &[state]).unwrap();
    // −½ (x − r)² A + b (x − r) by its values, as a square: centre r + b/A.
    let of_step = |(index, x): (usize, f64)| {
        let (above, below, middle) = (near(x + 0.1, index), near(x - 0.1, index), near(x, index));
        let curvature = (2.0 * middle - above - below) / 0.01;
        let slope = (above - below) / 0.2;
        (x + slope / curvature, curvature.sqrt())
    };
    let quadratics: Vec<(f64, f64)> =
        designed.path().map(|state| state[0]).enumerate().map(of_step).collect();
    let by = |halves: usize| {
        let potentials: Vec<Vec<PotentialComponent>> = quadratics
            .iter()
            .map(|(centre, root)| {
                let one = PotentialComponent {
                    log_weight: -(halves as f64).ln(),
                    centre: vec![*centre],
                    root: vec![*root],
                };
                vec![one; halves]
            })
            .collect();
        let ahead = LookAhead::from_potentials(&model, &rows, &potentials).unwrap();
        moments(&evidence_by(&model, ahead, &rows, settings(32, None), 200, 5))
    };
    let designed = moments(&evidence_by(&model, designed.clone(), &rows, settings(32, None), 200, 5));
    for (mean, variance) in [by(1), by(2), by(3)] {
        assert!((mean - designed.0).abs() < 0.02, "{mean} beside {}", designed.0);
        assert!(
            variance < 2.0 * designed.1 && designed.1 < 2.0 * variance,
            "{variance} beside {}",
            designed.1
        );
    }
}

#[test]
fn potentials_that_do_not_fit_are_refused() {
    let model = Counts { sd: 0.3 };
    let rows = rows(&model, 3, 4);
    let good = potentials(&model, &rows, 1);
    let refused = |change: fn(&mut Vec<Vec<PotentialComponent>>)| {
        let mut potentials = good.clone();
        change(&mut potentials);
        LookAhead::from_potentials(&model, &rows, &potentials).unwrap_err()
    };
    assert!(matches!(refused(|all| drop(all.pop())), LookAheadError::Step { .. }));
    assert!(matches!(refused(|all| all[1].clear()), LookAheadError::Step { index: 1, .. }));
    assert!(matches!(refused(|all| all[2][0].centre.push(0.0)), LookAheadError::Step { index: 2, .. }));
    assert!(matches!(refused(|all| all[2][0].root[0] = f64::NAN), LookAheadError::Potential { index: 2 }));
    assert!(matches!(
        refused(|all| all[0][1].log_weight = f64::INFINITY),
        LookAheadError::Potential { index: 0 }
    ));
}
