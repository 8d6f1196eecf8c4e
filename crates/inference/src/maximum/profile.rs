//! Intervals by profiles of the likelihood, wider by what its estimates do not tell (Ionides, Breto, Park, Smith and King, 2017).

use motes_models::Seed;
use motes_models::equations::normal_quantile;
use serde::{Deserialize, Serialize};

use super::height::height;
use super::hill::Hill;
use super::point::Maximum;
use super::quadratic::Quadratic;
use crate::likelihood::{Estimator, EstimatorCost, Likelihood};

/// Points of a profile on either side, and how far apart they are in units of the spread.
pub(super) const POINTS: (i32, f64) = (5, 0.6);

/// Rounds uphill at each point.
const ROUNDS: usize = 2;

/// The log-likelihood at a point has particles by this factor, and is that of so many estimates.
const ESTIMATES: (usize, usize) = (4, 16);

/// The largest log-likelihood that there is where one coordinate of positions is given, as a function of that coordinate, and the interval that follows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    /// Which coordinate it is.
    pub at: usize,
    /// The lower end of its interval.
    pub low: f64,
    /// The upper end.
    pub high: f64,
    /// What was found, in the order of the coordinate.
    pub points: Vec<ProfilePoint>,
}

/// A point of a profile.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ProfilePoint {
    /// The coordinate.
    pub v: f64,
    /// The largest log-likelihood over the others that was found: of estimates the logarithm of their mean.
    pub log_likelihood: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// A likelihood with one of its parameters given.
struct SliceLikelihood<'a, L> {
    likelihood: &'a L,
    at: usize,
    value: f64,
}

impl<L> SliceLikelihood<'_, L> {
    fn all(&self, rest: &[f64]) -> Vec<f64> {
        let mut v = rest.to_vec();
        v.insert(self.at, self.value);
        v
    }
}

impl<L: Likelihood> Likelihood for SliceLikelihood<'_, L> {
    type Error = L::Error;

    fn dimension(&self) -> usize {
        self.likelihood.dimension() - 1
    }

    fn estimators(&self) -> &[EstimatorCost] {
        self.likelihood.estimators()
    }

    fn log_likelihood(&self, v: &[f64], estimator: Estimator, seed: &Seed) -> Result<f64, L::Error> {
        self.likelihood.log_likelihood(&self.all(v), estimator, seed)
    }
}

/// The profile of coordinate `at`, with the interval of probability `level`: where the profile is at most `δ` below its largest value, with `δ` from the curvature of a quadratic that is
/// like the profile and from how surely it is known.
pub(super) fn profile<L: Likelihood>(
    likelihood: &L,
    best: &Maximum,
    at: usize,
    level: f64,
    seed: &Seed,
) -> Result<Profile, L::Error> {
    let d = best.v.len();
    let row = &best.spread[at * d..(at + 1) * d];
    let sd = row.iter().map(|value| value * value).sum::<f64>().sqrt();
    // Covariances of the others with this one: where they go as it goes.
    let slope =
        |i: usize| (0..d).map(|k| best.spread[i * d + k] * best.spread[at * d + k]).sum::<f64>() / (sd * sd);
    let others: Vec<usize> = (0..d).filter(|i| *i != at).collect();
    let mut found = vec![ProfilePoint {
        v: best.v[at],
        log_likelihood: best.log_likelihood,
        standard_error: best.standard_error,
    }];
    let spread = if others.is_empty() { None } else { conditional(best, at, &others) };
    for side in [-1, 1] {
        // From the maximum outwards: each point begins where the one before it ended.
        let mut here: Vec<f64> = others.iter().map(|i| best.v[*i]).collect();
        for step in 1..=POINTS.0 {
            let value = best.v[at] + f64::from(side * step) * POINTS.1 * sd;
            let moved = |(i, v): (&usize, &f64)| v + slope(*i) * f64::from(side) * POINTS.1 * sd;
            here = others.iter().zip(&here).map(moved).collect();
            let given = SliceLikelihood { likelihood, at, value };
            let seed = seed.nth((side * step + POINTS.0) as u64);
            let mut top = height(&given, &here, best.estimator, ESTIMATES, &seed.child("start"))?;
            if let Some(spread) = &spread {
                let mut hill = Hill::new(here.clone(), spread.clone());
                for round in 0..ROUNDS {
                    hill.climb(&given, best.estimator, &seed.nth(round as u64))?;
                }
                let climbed = height(&given, &hill.centre, best.estimator, ESTIMATES, &seed.child("end"))?;
                if climbed.0 > top.0 {
                    (top, here) = (climbed, hill.centre);
                }
            }
            if top.0.is_finite() {
                found.push(ProfilePoint { v: value, log_likelihood: top.0, standard_error: top.1 });
            }
        }
    }
    Ok(interval(found, best.v[at], at, sd, level))
}

/// The interval that follows from points of the profile of coordinate `at`, which are [`POINTS`] apart in units of `sd`.
pub(super) fn interval(mut found: Vec<ProfilePoint>, top_at: f64, at: usize, sd: f64, level: f64) -> Profile {
    found.sort_by(|a, b| a.v.total_cmp(&b.v));
    let weighted = |point: &ProfilePoint| {
        let error = point.standard_error;
        (vec![(point.v - top_at) / sd], point.log_likelihood, 1.0 / (error * error + 0.05))
    };
    let mut points: Vec<(Vec<f64>, f64, f64)> = found.iter().map(weighted).collect();
    let around = |u: f64| top_at + u * sd;
    let z = normal_quantile(0.5 + 0.5 * level);
    let end = f64::from(POINTS.0) * POINTS.1;
    // Weights as they would be of a profile that is known at its top above all.
    let top = points.iter().map(|(_, height, _)| *height).fold(f64::NEG_INFINITY, f64::max);
    for (_, height, weight) in &mut points {
        *weight *= (-0.25 * (top - *height)).exp();
    }
    let Some(fitted) = Quadratic::fit(&points) else {
        return Profile { at, low: around(-end), high: around(end), points: found };
    };
    let curvature = (-fitted.curvature[(0, 0)]).max(1e-3);
    let centre = (fitted.b[0] / curvature).clamp(-end, end);
    // How far the top itself may lie from where it was found.
    let error = fitted.slope_error_at(&[centre], 0) / curvature;
    let delta = 0.5 * z * z * (1.0 + curvature * error * error);
    let reach =
        |side: f64| centre + side * reach(&points, fitted.at(&[centre]), centre, side, delta).min(end);
    Profile { at, low: around(reach(-1.0)), high: around(reach(1.0)), points: found }
}

/// How far from `centre` the profile is `δ` below its top on one side: by `√(top − height) = αt + βt²`, which is a line where the profile is a parabola.
fn reach(points: &[(Vec<f64>, f64, f64)], top: f64, centre: f64, side: f64, delta: f64) -> f64 {
    let there = points.iter().map(|(u, height, weight)| (side * (u[0] - centre), *height, *weight));
    let [mut tt, mut ttt, mut tttt, mut tr, mut ttr] = [0.0; 5];
    for (t, height, weight) in there.filter(|(t, ..)| *t > 0.0) {
        let root = (top - height).max(0.0).sqrt();
        tt += weight * t * t;
        ttt += weight * t.powi(3);
        tttt += weight * t.powi(4);
        tr += weight * t * root;
        ttr += weight * t * t * root;
    }
    let determinant = tt * tttt - ttt * ttt;
    let (alpha, beta) = match determinant > 1e-9 * tt * tttt {
        true => ((tr * tttt - ttr * ttt) / determinant, (ttr * tt - tr * ttt) / determinant),
        false => (tr / tt, 0.0),
    };
    let level = delta.sqrt();
    // The first of the roots of `βt² + αt = level`, in the form that loses no digits.
    let inside = alpha * alpha + 4.0 * beta * level;
    let found = 2.0 * level / (alpha + inside.max(0.0).sqrt());
    if found.is_finite() && found > 0.0 && inside >= 0.0 { found } else { f64::INFINITY }
}

/// The spread of the others where coordinate `at` is given: `L'` of `Σ_oo − Σ_oa Σ_ao / Σ_aa`, row after row.
fn conditional(best: &Maximum, at: usize, others: &[usize]) -> Option<Vec<f64>> {
    let d = best.v.len();
    let covariance =
        |i: usize, j: usize| (0..d).map(|k| best.spread[i * d + k] * best.spread[j * d + k]).sum::<f64>();
    let n = others.len();
    let matrix = faer::Mat::from_fn(n, n, |i, j| {
        covariance(others[i], others[j])
            - covariance(others[i], at) * covariance(others[j], at) / covariance(at, at)
    });
    let factor = matrix.llt(faer::Side::Lower).ok()?;
    let lower = factor.L();
    Some(
        (0..n * n)
            .map(|place| if place % n <= place / n { lower[(place / n, place % n)] } else { 0.0 })
            .collect(),
    )
}
