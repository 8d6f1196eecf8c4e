//! Profiles of the likelihood.

use motes_models::Seed;

use super::height::height;
use super::hill::Hill;
use super::interval::{interval, is_low};
use super::point::{Maximum, Profile, ProfilePoint};
use crate::likelihood::{Estimator, EstimatorCost, Likelihood};
use crate::normal_fit::lower_factor;

/// Points of a profile on either side, and how far apart they are in units of the spread.
pub(super) const POINTS: (usize, f64) = (5, 0.6);

/// Where a profile is not low enough by then, points go on, each farther from the one before by a factor, until they are so many.
pub(super) const MOST_POINTS: usize = 24;
pub(super) const LONGER: f64 = 1.4;

/// Positions are no farther from 0: beyond there is as good as nothing of the prior.
pub(super) const FARTHEST: f64 = 5.0;

/// Rounds uphill at each point.
const ROUNDS: usize = 2;

/// Points that are put where the ends of an exact profile seem to be, one after the other, unless one is as near, in units of the spread.
const REFINED: u64 = 3;
const NEAR: f64 = 0.01;

/// The log-likelihood at a point has particles by this factor, and is that of so many estimates.
const ESTIMATES: (usize, usize) = (4, 16);

/// The largest log-likelihood at a value of a coordinate with its standard error, and where the others are there.
type ProfileTop = ((f64, f64), Vec<f64>);

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

/// The profile of coordinate `at`, with the interval of probability `level`: where the profile is at most `δ` below its largest value.
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
    // The largest log-likelihood at a value, and where it is, from others near there.
    let top_at = |value: f64, here: &[f64], seed: &Seed| -> Result<ProfileTop, L::Error> {
        let given = SliceLikelihood { likelihood, at, value };
        let start = height(&given, here, best.estimator, ESTIMATES, &seed.child("start"))?;
        let Some(spread) = &spread else { return Ok((start, here.to_vec())) };
        let mut hill = Hill::new(here.to_vec(), spread.clone());
        for round in 0..ROUNDS {
            hill.climb(&given, best.estimator, &seed.nth(round as u64))?;
        }
        let climbed = height(&given, &hill.centre, best.estimator, ESTIMATES, &seed.child("end"))?;
        Ok(if climbed.0 > start.0 { (climbed, hill.centre) } else { (start, here.to_vec()) })
    };
    let of_best: Vec<f64> = others.iter().map(|i| best.v[*i]).collect();
    // Where the others are at each point.
    let mut places = vec![of_best.clone()];
    let moved = |here: &[f64], by: f64| -> Vec<f64> {
        others.iter().zip(here).map(|(i, v)| v + slope(*i) * by).collect()
    };
    for side in [-1.0, 1.0] {
        // From the maximum outwards: each point begins where the one before it ended.
        let mut here = of_best.clone();
        let (mut distance, mut length) = (0.0, POINTS.1);
        for step in 1..=MOST_POINTS {
            if step > POINTS.0 {
                length *= LONGER;
            }
            let most = (FARTHEST - side * best.v[at]).max(0.0) / sd;
            let before = distance;
            distance = (distance + length).min(most);
            if distance <= before {
                break;
            }
            let value = best.v[at] + side * distance * sd;
            let seed = seed.nth(2 * step as u64 + u64::from(side > 0.0));
            let (top, found_at) = top_at(value, &moved(&here, side * (distance - before) * sd), &seed)?;
            here = found_at;
            found.push(ProfilePoint { v: value, log_likelihood: top.0, standard_error: top.1 });
            places.push(here.clone());
            if !top.0.is_finite() || (step >= POINTS.0 && is_low(best, top, level)) {
                break;
            }
        }
    }
    // Where the likelihood is exact, so are the ends: points come near to them.
    for round in 0..if best.standard_error == 0.0 { REFINED } else { 0 } {
        let Profile { low, high, .. } = interval(found.clone(), best, at, sd, level);
        for (side, end) in [low, high].into_iter().enumerate() {
            let distances = found.iter().map(|point| (point.v - end).abs());
            let nearest = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
            let Some((nearest, _)) = nearest.filter(|(_, distance)| *distance > NEAR * sd) else { continue };
            let here = moved(&places[nearest], end - found[nearest].v);
            let (top, found_at) = top_at(end, &here, &seed.child("ends").nth(2 * round + side as u64))?;
            found.push(ProfilePoint { v: end, log_likelihood: top.0, standard_error: top.1 });
            places.push(found_at);
        }
    }
    Ok(interval(found, best, at, sd, level))
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
    lower_factor(matrix.as_ref())
}
