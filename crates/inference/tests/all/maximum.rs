//! Maxima that are known.

use motes_inference::{Estimator, EstimatorCost, FitError, Likelihood, MaximumSearch, MaximumSettings};
use motes_models::{Seed, fill_uniform};

use crate::known::{EXACT, Half, Line};

fn found<L: Likelihood<Error = std::convert::Infallible>>(
    line: &L,
    settings: MaximumSettings,
    seed: u64,
) -> MaximumSearch {
    let mut search = MaximumSearch::new(settings, seed);
    while !search.is_done(2) {
        search.advance(line).expect("nothing can fail");
    }
    search
}

/// The least squares of [`Line`], and the standard errors of both coordinates.
fn least_squares(line: &Line) -> ([f64; 2], [f64; 2]) {
    let sum = |of: &dyn Fn(&[f64; 3]) -> f64| line.rows.iter().map(of).sum::<f64>();
    let (aa, ab, bb) = (sum(&|r| r[0] * r[0]), sum(&|r| r[0] * r[1]), sum(&|r| r[1] * r[1]));
    let (ay, by) = (sum(&|r| r[0] * r[2]), sum(&|r| r[1] * r[2]));
    let determinant = aa * bb - ab * ab;
    let at = [(bb * ay - ab * by) / determinant, (aa * by - ab * ay) / determinant];
    (at, [bb, aa].map(|other| line.sd * (other / determinant).sqrt()))
}

#[test]
fn an_exact_likelihood_has_its_maximum_and_its_intervals_found_from_every_start() {
    let line = Line::new(0.0);
    let (at, errors) = least_squares(&line);
    for seed in 0..5 {
        let search = found(&line, MaximumSettings::default(), seed);
        let best = search.best().expect("searches have ended");
        assert_eq!((search.agreeing().count(), search.searches()), (4, 4));
        assert_eq!(best.standard_error, 0.0);
        assert!(line.exact(&at) - best.log_likelihood < 1e-6, "{best:?} beside {at:?}");
        for (i, interval) in search.profiles().iter().enumerate() {
            // 1.645 standard errors to either side.
            let expected = [at[i] - 1.645 * errors[i], at[i] + 1.645 * errors[i]];
            let off = (interval.low - expected[0]).abs().max((interval.high - expected[1]).abs());
            assert!(off < 0.03 * errors[i], "{interval:?} beside {expected:?}");
        }
    }
}

#[test]
fn noise_of_the_likelihood_makes_intervals_wider_and_moves_the_maximum_little() {
    let line = Line::new(60.0);
    let (at, errors) = least_squares(&line);
    for seed in 0..5 {
        let search = found(&line, MaximumSettings::default(), seed);
        let best = search.best().expect("searches have ended");
        assert!(search.agreeing().count() >= 3, "{}", search.agreeing().count());
        assert!(line.exact(&at) - line.exact(&best.v) < 0.2, "{best:?} beside {at:?}");
        let off = (best.log_likelihood - line.exact(&best.v)).abs();
        assert!(off < 4.0 * best.standard_error && best.standard_error < 0.2, "{best:?}");
        for (i, interval) in search.profiles().iter().enumerate() {
            let half = 0.5 * (interval.high - interval.low) / errors[i];
            assert!((1.3..2.6).contains(&half), "{interval:?}: {half} standard errors");
            assert!(interval.low < at[i] && at[i] < interval.high, "{interval:?} beside {at:?}");
        }
    }
}

/// Catches a log-likelihood by which a search is the best of many: it has luck in it.
#[test]
fn the_log_likelihood_of_the_best_search_is_not_too_high() {
    let line = Line::new(60.0);
    let settings = MaximumSettings { starts: 8, profiled: Some(vec![]), ..MaximumSettings::default() };
    let off = (0..30).map(|seed| {
        let search = found(&line, settings.clone(), seed);
        let best = search.best().expect("searches have ended");
        (best.log_likelihood - line.exact(&best.v)) / best.standard_error
    });
    let mean = off.sum::<f64>() / 30.0;
    assert!(mean.abs() < 0.6, "{mean} standard errors in the mean");
}

/// [`Line`] with filters that miss the mass now and then, as they do of real models: one estimate of twenty is far too low.
struct Rough(Line);

impl Likelihood for Rough {
    type Error = std::convert::Infallible;

    fn dimension(&self) -> usize {
        self.0.dimension()
    }

    fn estimators(&self) -> &[EstimatorCost] {
        self.0.estimators()
    }

    fn log_likelihood(&self, v: &[f64], estimator: Estimator, seed: &Seed) -> Result<f64, Self::Error> {
        let mut uniform = [0.0];
        fill_uniform(&mut seed.child("misses").stream(), &mut uniform);
        let misses = uniform[0] < 0.05;
        let found = self.0.log_likelihood(v, estimator, seed)?;
        Ok(if misses { found - 100.0 } else { found })
    }
}

/// Catches quadratics that a few estimates tilt, and profiles that are read off such quadratics.
#[test]
fn estimates_that_are_far_too_low_do_not_move_intervals() {
    let line = Rough(Line::new(60.0));
    let (at, errors) = least_squares(&line.0);
    for seed in 0..5 {
        let search = found(&line, MaximumSettings::default(), seed);
        let best = search.best().expect("searches have ended");
        assert!(line.0.exact(&at) - line.0.exact(&best.v) < 0.2, "{best:?} beside {at:?}");
        for (i, interval) in search.profiles().iter().enumerate() {
            let half = 0.5 * (interval.high - interval.low) / errors[i];
            assert!((1.3..2.6).contains(&half), "{interval:?}: {half} standard errors");
            assert!(interval.low < best.v[i] && best.v[i] < interval.high, "{interval:?} beside {best:?}");
            // A point is what the likelihood is there, but for what it is below its profile.
            let top =
                interval.points.iter().map(|point| point.log_likelihood).fold(f64::NEG_INFINITY, f64::max);
            assert!((top - line.0.exact(&at)).abs() < 1.0, "{interval:?}");
        }
    }
}

#[test]
fn what_is_impossible_is_said() {
    let half = Half { above: 9.0, costs: vec![EXACT] };
    let mut search = MaximumSearch::new(MaximumSettings::default(), 1);
    let impossible = search.advance(&half);
    assert!(matches!(&impossible, Err(FitError::Impossible(draw)) if draw.v[0] < 9.0), "{impossible:?}");
    let mut none = MaximumSearch::new(MaximumSettings { starts: 0, ..MaximumSettings::default() }, 1);
    assert_eq!(none.advance(&half), Err(FitError::Nothing));
}

/// An exact log-likelihood of one coordinate.
struct Curve(fn(f64) -> f64);

impl Likelihood for Curve {
    type Error = std::convert::Infallible;

    fn dimension(&self) -> usize {
        1
    }

    fn estimators(&self) -> &[EstimatorCost] {
        &[EXACT]
    }

    fn log_likelihood(&self, v: &[f64], _: Estimator, _: &Seed) -> Result<f64, Self::Error> {
        Ok(self.0(v[0]))
    }
}

/// Catches ends that a parabola would have, and ends where points stop.
#[test]
fn intervals_end_where_the_profile_is_low_enough() {
    let interval = |curve: fn(f64) -> f64, seed: u64| {
        let mut search = MaximumSearch::new(MaximumSettings::default(), seed);
        while !search.is_done(1) {
            search.advance(&Curve(curve)).expect("nothing can fail");
        }
        let profile = &search.profiles()[0];
        [profile.low, profile.high]
    };
    for seed in 0..4 {
        // e^u − u − 1 = 1.3528 with u = 2v, at −2.2470 and 1.2938.
        let [low, high] = interval(|v| 2.0 * v - (2.0 * v).exp(), seed);
        assert!((low + 1.1235).abs() < 0.01 && (high - 0.6469).abs() < 0.01, "{low} to {high}");
        // Flat on one side, where it ends with the prior; ln(1 + e^2v) = 1.3528 at 0.5275.
        let [low, high] = interval(|v| -(2.0 * v).exp().ln_1p(), seed);
        assert!(low < -4.5 && (high - 0.5275).abs() < 0.03, "{low} to {high}");
        // Impossible above 1.
        let [low, high] = interval(|v| if v < 1.0 { -0.02 * v * v } else { f64::NEG_INFINITY }, seed);
        assert!(low < -4.5 && (0.95..1.5).contains(&high), "{low} to {high}");
    }
}
