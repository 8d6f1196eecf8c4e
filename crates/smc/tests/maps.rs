//! Models whose states are made of draws by a map: counts, draws that coordinates share, coordinates without noise, sub-steps. Evidence against exact values.

use motes_models::equations::{Coordinates, Draws, Equations, Scalar, binomial, normal, poisson};
use motes_models::{ModelError, PartialMeasurements, Seed, StateSpaceModel, Step, check_model};
use motes_smc::{
    Bootstrap, FilterBank, FilterError, FilterHistory, FilterSettings, Linearised, ParticleFilter,
    ProposalError, backward_simulation,
};

/// An epidemic among 15 people by whole numbers, in three sub-steps between two rows; what is counted are infections since the row before.
///
/// `resets` the count after each row, and draws a `shared` number of infections for those who leave S and those who enter I: false plants a bug.
struct Epidemic {
    resets: bool,
    shares: bool,
}

impl Epidemic {
    fn three_days<S: Scalar>(&self, draws: &mut impl Draws<S>, state: &mut [S]) {
        for _ in 0..3 {
            let risk = -(state[1] * (-0.3 / 15.0)).exp() + 1.0;
            let infections = draws.draw(binomial(state[0], risk));
            let entering = if self.shares { infections } else { draws.draw(binomial(state[0], risk)) };
            let recoveries = draws.draw(binomial(state[1], 1.0 - (-0.15_f64).exp()));
            state[0] = state[0] - infections;
            state[1] = state[1] + entering - recoveries;
            state[2] = state[2] + infections;
        }
    }
}

impl Equations for Epidemic {
    fn dimensions(&self) -> [usize; 2] {
        [3, 1]
    }

    fn has_density(&self) -> bool {
        false
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state.copy_from_slice(&[13.0, 2.0, 0.0].map(S::from));
        self.three_days(draws, state);
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        state.copy_from_slice(x);
        if self.resets {
            state[2] = S::from(0.0);
        }
        self.three_days(draws, state);
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(poisson(x[2] + 0.01));
    }
}

/// A position that moves by exactly the speed of before.
struct ConstantVelocity;

impl Equations for ConstantVelocity {
    fn dimensions(&self) -> [usize; 2] {
        [2, 1]
    }

    fn has_density(&self) -> bool {
        false
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(0.0, 1.0));
        state[1] = draws.draw(normal(0.5, 0.5));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = x[0] + x[1];
        state[1] = draws.draw(normal(x[1], 0.1));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0], 0.4));
    }
}

/// White noise of acceleration, of which position and speed have their shares.
struct WhiteAcceleration {
    shares: bool,
}

impl Equations for WhiteAcceleration {
    fn dimensions(&self) -> [usize; 2] {
        [2, 1]
    }

    fn has_density(&self) -> bool {
        false
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state.fill_with(|| draws.draw(normal(0.0, 1.0)));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        let [first, second] = [0, 1].map(|_| draws.draw(normal(0.0, 1.0)));
        let of_speed = if self.shares { first } else { draws.draw(normal(0.0, 1.0)) };
        state[0] = x[0] + x[1] + first * (0.3_f64 / 3.0).sqrt();
        state[1] = x[1] + (of_speed * (3.0_f64.sqrt() / 2.0) + second * 0.5) * 0.3_f64.sqrt();
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0], 0.5));
    }
}

fn measured(values: &[Option<f64>]) -> PartialMeasurements {
    PartialMeasurements::new(1, values.to_vec()).unwrap()
}

const CASES: [Option<f64>; 6] = [Some(1.0), Some(2.0), None, Some(4.0), Some(1.0), Some(0.0)];

/// By the sum over all numbers of people.
const OF_CASES: f64 = -8.527974;

/// Filters whose evidences are averaged.
const FILTERS: usize = 4000;

/// How far the mean of `ẑ / z` is from 1, in standard errors: it is unbiased with any number of particles.
fn score(model: &impl StateSpaceModel, measurements: &PartialMeasurements, exact: f64) -> f64 {
    check_model(model).unwrap();
    let settings = FilterSettings::new(200);
    let mut bank = FilterBank::new(model, Bootstrap, settings, FILTERS, &Seed::from_u64(11)).unwrap();
    bank.run_partial(measurements, |_| {}).unwrap();
    let ratios: Vec<f64> = (0..FILTERS).map(|filter| (bank.log_evidence(filter) - exact).exp()).collect();
    let mean = ratios.iter().sum::<f64>() / FILTERS as f64;
    let variance = ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum::<f64>() / (FILTERS - 1) as f64;
    (mean - 1.0) / (variance / FILTERS as f64).sqrt()
}

#[test]
fn the_evidence_of_counts_with_sub_steps_is_unbiased() {
    let of = |resets, shares| score(&Epidemic { resets, shares }, &measured(&CASES), OF_CASES);
    let (right, kept, twice) = (of(true, true), of(false, true), of(true, false));
    println!("counts: z = {right:.1}, without reset {kept:.1}, infections drawn twice {twice:.1}");
    assert!(right.abs() < 4.0 && kept.abs() > 8.0 && twice.abs() > 8.0);
}

/// By Kalman's filter with matrices of rank 1.
#[test]
fn the_evidence_of_a_coordinate_without_noise_is_unbiased() {
    let values = [0.22, 0.61, 1.34, 1.60, 2.41, 3.02].map(Some);
    let found = score(&ConstantVelocity, &measured(&values), -3.897144);
    assert!(found.abs() < 4.0, "z = {found:.1}");
}

#[test]
fn the_evidence_of_a_shared_draw_is_unbiased() {
    let values = [0.31, 0.95, 2.10, 2.44, 4.02, 6.61].map(Some);
    let [right, apart] =
        [true, false].map(|shares| score(&WhiteAcceleration { shares }, &measured(&values), -8.191824));
    println!("shared draw: z = {right:.1}, drawn twice {apart:.1}");
    assert!(right.abs() < 4.0 && apart.abs() > 6.0);
}

#[test]
fn proposals_of_states_are_refused_by_name() {
    let mut bank = {
        let proposal = Linearised::new(&ConstantVelocity).unwrap();
        let settings = FilterSettings::new(50);
        ParticleFilter::new(&ConstantVelocity, proposal, settings, Seed::from_u64(1).stream()).unwrap()
    };
    let said = bank.step(&[0.2]).unwrap_err();
    assert!(matches!(said, FilterError::Proposal { step: 0, source: ProposalError::NoDensity }), "{said}");
}

/// Backward simulation has nothing to draw by: paths are those of the filter's ancestors, and their means the smoothed ones.
#[test]
fn smoothed_paths_follow_ancestors() {
    let values = [0.22, 0.61, 1.34, 1.60, 2.41, 3.02].map(Some);
    let settings = FilterSettings::new(20_000);
    let mut filter =
        ParticleFilter::new(&ConstantVelocity, Bootstrap, settings, Seed::from_u64(2).stream()).unwrap();
    let mut history = FilterHistory::default();
    for row in measured(&values).rows() {
        filter.step_partial(row).unwrap();
        history.record(&filter).unwrap();
    }
    let paths = backward_simulation(&ConstantVelocity, &history, 20_000, &Seed::from_u64(3)).unwrap();
    assert!(paths.follow_ancestors());
    for path in (0..paths.len()).step_by(100) {
        let path = paths.path(path);
        let moves = path.windows(4).step_by(2);
        assert!(moves.clone().count() == 5 && moves.clone().all(|pair| pair[2] == pair[0] + pair[1]));
    }
    // The smoothed mean of the last time is the filtered one.
    let mean = (0..paths.len()).map(|path| paths.path(path)[10]).sum::<f64>() / paths.len() as f64;
    assert!((mean - 2.949163).abs() < 0.02, "{mean}");
}

/// A model that says of itself what is not so.
struct Untrue {
    draws_by_state: bool,
}

impl Equations for Untrue {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn has_density(&self) -> bool {
        !self.draws_by_state
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(0.0, 1.0));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = x[0] + draws.draw(normal(0.0, 1.0));
        // Of one number; many side by side say nothing of a sign.
        if self.draws_by_state && format!("{:?}", x[0]).starts_with('-') {
            state[0] = state[0] + draws.draw(normal(0.0, 1.0));
        }
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0], 1.0));
    }
}

#[test]
fn what_a_model_says_wrongly_of_itself_is_refused() {
    let said = |draws_by_state| match check_model(&Untrue { draws_by_state }) {
        Err(ModelError::Parameter { name, .. }) => name,
        other => panic!("{other:?}"),
    };
    assert_eq!(said(false), "the state");
    assert_eq!(said(true), "the number of draws of a step");
}
