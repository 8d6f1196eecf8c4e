//! Models whose states are made of draws by a map, each with measurements and their exact log-evidence.

use motes_models::PartialMeasurements;
use motes_models::Step;
use motes_models::equations::{
    Coordinates, Distribution, Draws, Equations, Scalar, binomial, gamma, normal, poisson,
};

/// An epidemic among 15 people by whole numbers, in three sub-steps between two rows; what is counted are infections since the row before.
///
/// `resets` the count after each row, and draws a `shared` number of infections for those who leave S and those who enter I: false plants a bug.
pub(super) struct Epidemic {
    pub(super) resets: bool,
    pub(super) shares: bool,
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
pub(super) struct ConstantVelocity;

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
pub(super) struct WhiteAcceleration {
    pub(super) shares: bool,
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

/// Animals of which each survives a half-year with probability 0.8, and which others join; both half-years lie between two rows.
pub(super) struct Population;

impl Population {
    fn half_year<S: Scalar>(draws: &mut impl Draws<S>, animals: S) -> S {
        let survivors = draws.draw(binomial(animals, 0.8));
        survivors + draws.draw(poisson(1.5))
    }
}

impl Equations for Population {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn has_density(&self) -> bool {
        false
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(poisson(5.0));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        let spring = Self::half_year(draws, x[0]);
        state[0] = Self::half_year(draws, spring);
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(poisson(x[0] * 0.9 + 0.1));
    }
}

/// A backlog of which a fifth is worked off in a step; what comes in is of gamma noise. It starts at 2 exactly.
pub(super) struct Delays;

impl Equations for Delays {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn has_density(&self) -> bool {
        false
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, _: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = S::from(2.0);
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = x[0] * 0.8 + draws.draw(gamma(2.5, 0.3));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0], 0.3));
    }
}

/// A path of six shocks, of which five pass at once, and measurements that bend.
pub(super) struct Shocks;

impl Equations for Shocks {
    fn dimensions(&self) -> [usize; 2] {
        [2, 2]
    }

    fn has_density(&self) -> bool {
        false
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, _: &mut impl Draws<S>, state: &mut [S]) {
        state.copy_from_slice(&[S::from(0.3), S::from(0.0)]);
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        let mut sum = x[0];
        for at in 0..6 {
            let shock = draws.draw(normal(sum * 0.1, 0.5 + 0.1 * f64::from(at)));
            sum = sum * 0.9 + (shock * 0.5).sin();
        }
        state.copy_from_slice(&[sum, x[0]]);
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0] * x[0], 0.5));
        y.push(poisson((x[0] + x[1]).exp()));
    }
}

/// A series with the exact log-evidence of its model.
pub(super) struct Series {
    pub(super) measurements: PartialMeasurements,
    pub(super) log_evidence: f64,
}

impl Series {
    fn new(values: &[Option<f64>], log_evidence: f64) -> Self {
        Series { measurements: PartialMeasurements::new(1, values.to_vec()).unwrap(), log_evidence }
    }
}

/// Of the [`Epidemic`] that resets, with a shared draw: by the sum over all numbers of people.
pub(super) fn cases() -> Series {
    Series::new(&[Some(1.0), Some(2.0), None, Some(4.0), Some(1.0), Some(0.0)], -8.527974)
}

/// Of [`ConstantVelocity`]: by Kalman's filter with matrices of rank 1.
pub(super) fn moves() -> Series {
    Series::new(&[0.22, 0.61, 1.34, 1.60, 2.41, 3.02].map(Some), -3.897144)
}

/// Of [`WhiteAcceleration`] with a shared draw: by Kalman's filter.
pub(super) fn positions() -> Series {
    Series::new(&[0.31, 0.95, 2.10, 2.44, 4.02, 6.61].map(Some), -8.191824)
}

/// Of the [`Population`]: by the sum over all numbers of animals up to 60.
pub(super) fn people() -> Series {
    const MOST: usize = 60;
    let values = [Some(4.0), Some(9.0), None, Some(3.0), Some(12.0)];
    let of_counts = |distribution: Distribution<f64>| -> Vec<f64> {
        (0..=MOST).map(|n| distribution.log_density(n as f64).exp()).collect()
    };
    let joining = of_counts(poisson(1.5));
    let half_year = |animals: &[f64]| {
        let mut after = vec![0.0; MOST + 1];
        for (before, share) in animals.iter().enumerate() {
            let surviving = of_counts(binomial(before as f64, 0.8));
            for survivors in 0..=before {
                for (joining, of_joining) in joining.iter().enumerate().take(MOST + 1 - survivors) {
                    after[survivors + joining] += share * surviving[survivors] * of_joining;
                }
            }
        }
        after
    };
    let mut animals = of_counts(poisson(5.0));
    for (time, value) in values.iter().enumerate() {
        if time > 0 {
            animals = half_year(&half_year(&animals));
        }
        for (n, share) in animals.iter_mut().enumerate() {
            let measured: Distribution<f64> = poisson(0.9 * n as f64 + 0.1);
            *share *= value.map_or(1.0, |y| measured.log_density(y).exp());
        }
    }
    Series::new(&values, animals.iter().sum::<f64>().ln())
}

/// Of [`Delays`]: by quadrature.
pub(super) fn delays() -> Series {
    const POINTS: usize = 2000;
    let values = [None, Some(2.9), Some(1.9), None, Some(3.9)];
    let step = 8.0 / POINTS as f64;
    let grid: Vec<f64> = (0..POINTS).map(|i| (i as f64 + 0.5) * step).collect();
    let coming: Distribution<f64> = gamma(2.5, 0.3);
    let likelihood = |value: &Option<f64>, x: f64| {
        value.map_or(1.0, |y| Distribution::log_density(&normal(x, 0.3), y).exp())
    };
    // What is known exactly at first.
    let start = likelihood(&values[0], 2.0);
    let mut density: Vec<f64> =
        grid.iter().map(|x| start * coming.log_density(x - 1.6).exp() * likelihood(&values[1], *x)).collect();
    for value in &values[2..] {
        let into = |x: f64| {
            let from = |(before, density): (&f64, &f64)| density * coming.log_density(x - 0.8 * before).exp();
            grid.iter().zip(&density).map(from).sum::<f64>() * step * likelihood(value, x)
        };
        density = grid.iter().map(|x| into(*x)).collect();
    }
    Series::new(&values, (density.iter().sum::<f64>() * step).ln())
}

/// A model that says of itself what is not so.
pub(super) struct Untrue {
    pub(super) draws_by_state: bool,
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
