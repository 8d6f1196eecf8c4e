//! Iterated filtering of rows whose least squares are known.

use std::convert::Infallible;

use faer::Mat;
use faer::linalg::solvers::Solve;
use motes_inference::{
    Estimator, EstimatorCost, FitError, IteratedSettings, Likelihood, MaximumSearch, MaximumSettings,
    PerturbedLikelihood, RandomWalk,
};
use motes_models::{Seed, fill_standard_normal, fill_uniform};

use crate::known::log_of_noise;

const D: usize = 3;

/// `a_t` and `y_t`.
type Row = ([f64; D], f64);

/// `y_t = a_t v + N(0, s²)`, estimated with a variance of 0.02.
struct Regression {
    rows: Vec<Row>,
    costs: [EstimatorCost; 1],
}

const SD: f64 = 0.7;
const VARIANCE: f64 = 0.02;

impl Regression {
    fn new(count: usize, outlier: f64) -> Self {
        let mut noise = vec![0.0; count * (D + 1)];
        fill_standard_normal(&mut Seed::from_u64(3).stream(), &mut noise);
        let row = |noise: &[f64]| {
            let a = [1.0, noise[0], noise[1]];
            (a, 0.4 * a[0] - 0.9 * a[1] + 1.2 * a[2] + SD * noise[2] + outlier)
        };
        let costs = [EstimatorCost { per_particle: 1.0, fixed: 0.0, is_exact: false }];
        Regression { rows: noise.chunks_exact(D + 1).map(row).collect(), costs }
    }

    fn of_row((a, y): &Row, v: &[f64]) -> f64 {
        let rest = (y - a.iter().zip(v).map(|(a, v)| a * v).sum::<f64>()) / SD;
        -0.5 * rest * rest
    }

    fn exact(&self, v: &[f64]) -> f64 {
        self.rows.iter().map(|row| Self::of_row(row, v)).sum()
    }

    /// The least squares, and the standard error of each coordinate.
    fn least_squares(&self) -> (Vec<f64>, Vec<f64>) {
        let sum = |of: &dyn Fn(&Row) -> f64| self.rows.iter().map(of).sum::<f64>();
        let squares = Mat::from_fn(D, D, |i, j| sum(&|(a, _)| a[i] * a[j]));
        let products = Mat::from_fn(D, 1, |i, _| sum(&|(a, y)| a[i] * y));
        let factor = squares.partial_piv_lu();
        let (at, inverse) = (factor.solve(&products), factor.solve(&Mat::<f64>::identity(D, D)));
        let errors = (0..D).map(|i| SD * inverse[(i, i)].sqrt()).collect();
        ((0..D).map(|i| at[(i, 0)]).collect(), errors)
    }
}

impl Likelihood for Regression {
    type Error = Infallible;

    fn dimension(&self) -> usize {
        D
    }

    fn estimators(&self) -> &[EstimatorCost] {
        &self.costs
    }

    fn log_likelihood(&self, v: &[f64], _: Estimator, seed: &Seed) -> Result<f64, Infallible> {
        Ok(self.exact(v) + log_of_noise(VARIANCE, seed))
    }

    fn perturbed(&self) -> Option<&dyn PerturbedLikelihood<Error = Infallible>> {
        Some(self)
    }
}

impl PerturbedLikelihood for Regression {
    type Error = Infallible;

    fn estimator(&self) -> usize {
        0
    }

    fn pass(&self, positions: &mut [f64], walk: RandomWalk<'_>, seed: &Seed) -> Result<(), Infallible> {
        let (rows, particles) = (self.rows.len() as f64, positions.len() / D);
        let (mut stream, mut noise) = (seed.stream(), vec![0.0; positions.len()]);
        for (number, row) in self.rows.iter().enumerate() {
            let sd = walk.spread * walk.cooling.powf(number as f64 / rows) / rows.sqrt();
            fill_standard_normal(&mut stream, &mut noise);
            for (at, v) in positions.iter_mut().enumerate().filter(|(at, _)| walk.fixed != Some(at % D)) {
                let (first, coordinate) = (at - at % D, at % D);
                let step = |lower: &[f64]| (0..D).map(|j| lower[coordinate * D + j] * noise[first + j]).sum();
                *v += sd * walk.directions.map_or(noise[at], step);
            }
            let weights: Vec<f64> = positions.chunks_exact(D).map(|v| Self::of_row(row, v).exp()).collect();
            let sum: f64 = weights.iter().sum();
            let mut offset = [0.0];
            fill_uniform(&mut stream, &mut offset);
            let (before, mut at, mut below) = (positions.to_vec(), 0, weights[0]);
            for (particle, v) in positions.chunks_exact_mut(D).enumerate() {
                let point = (particle as f64 + offset[0]) * sum / particles as f64;
                while below < point && at + 1 < particles {
                    at += 1;
                    below += weights[at];
                }
                v.copy_from_slice(&before[at * D..][..D]);
            }
        }
        Ok(())
    }
}

fn settings(passes: usize, profiled: Vec<usize>) -> MaximumSettings {
    let iterated = Some(IteratedSettings { particles: 300, passes });
    MaximumSettings { starts: 3, profiled: Some(profiled), iterated, ..MaximumSettings::default() }
}

#[test]
fn swarms_end_at_the_maximum_and_profiles_have_its_width() {
    let line = Regression::new(60, 0.0);
    let (at, errors) = line.least_squares();
    let mut search = MaximumSearch::new(settings(40, vec![0, 2]), 1);
    let mut done = Vec::new();
    while !search.is_done(D) {
        // What is written down between two pieces of work goes on to the same end.
        let mut written = Vec::new();
        ciborium::into_writer(&search, &mut written).expect("it can be written down");
        search = ciborium::from_reader(written.as_slice()).expect("it was written");
        search.advance(&line).expect("nothing can fail");
        done.push(search.progress(D));
    }
    assert_eq!((done.first(), done.last()), (Some(&(1, 48)), Some(&(48, 48))));
    let best = search.best().expect("searches have ended");
    let missing = line.exact(&at) - line.exact(&best.v);
    assert!(missing < 0.2, "{missing} below the top: {best:?} beside {at:?}");
    assert!((best.log_likelihood - line.exact(&best.v)).abs() < 5.0 * best.standard_error, "{best:?}");
    assert_eq!(search.agreeing().count(), 3);
    for (profile, coordinate) in search.profiles().iter().zip([0, 2]) {
        assert_eq!(profile.at, coordinate);
        let ends = [-1.645, 1.645].map(|z| at[coordinate] + z * errors[coordinate]);
        let off = (profile.low - ends[0]).abs().max((profile.high - ends[1]).abs());
        assert!(off < 0.5 * errors[coordinate], "{profile:?} beside {ends:?}");
    }
}

/// A walk without the shape of the likelihood misses 0.06 nats, whatever the number of passes.
#[test]
fn a_second_round_comes_near() {
    let line = Regression::new(60, 0.0);
    let (at, _) = line.least_squares();
    let missing = |passes: usize| {
        let searches = (0..20).map(|seed| {
            let settings = MaximumSettings { starts: 1, ..settings(passes, vec![]) };
            let mut search = MaximumSearch::new(settings, seed);
            while !search.is_done(D) {
                search.advance(&line).expect("nothing can fail");
            }
            line.exact(&at) - line.exact(&search.best().expect("searches have ended").v)
        });
        searches.sum::<f64>() / 20.0
    };
    let [first, few, many] = [1, 10, 40].map(missing);
    assert!(
        first > 0.1 && few < 0.03 && many < 0.015,
        "{first} after 1 pass, {few} after 10, {many} after 40"
    );
}

#[test]
fn rows_that_are_impossible_everywhere_are_said() {
    let line = Regression::new(5, 1e200);
    let mut search = MaximumSearch::new(settings(4, vec![]), 1);
    let mut advance = || search.advance(&line);
    assert_eq!((advance(), advance()), (Ok(()), Ok(())));
    assert!(matches!(advance(), Err(FitError::Impossible(_))));
}

/// Catches a search that goes on for ever.
#[test]
fn iterated_filtering_without_filters_particles_or_passes_is_nothing() {
    let advanced =
        |settings: MaximumSettings| MaximumSearch::new(settings, 1).advance(&Regression::new(5, 0.0));
    let with = |particles, passes| MaximumSettings {
        iterated: Some(IteratedSettings { particles, passes }),
        ..MaximumSettings::default()
    };
    assert_eq!(
        [advanced(with(0, 2)), advanced(with(2, 0))],
        [Err(FitError::Nothing), Err(FitError::Nothing)]
    );
    let mut search = MaximumSearch::new(with(2, 2), 1);
    assert_eq!(search.advance(&crate::known::Line::new(1.0)), Err(FitError::Nothing));
}
