//! Profiles by iterated filtering.

use motes_models::Seed;

use super::height::height;
use super::interval::{interval, is_low};
use super::point::{Maximum, Profile, ProfilePoint};
use super::profile::{FARTHEST, LONGER, MOST_POINTS, POINTS};
use super::settings::IteratedSettings;
use super::swarm_shape::mean;
use super::walks::{SPREADS, between};
use crate::likelihood::{Likelihood, PerturbedLikelihood, RandomWalk};
use crate::parallel::map_on_threads;

/// The log-likelihood at a point is that of so many estimates.
const ESTIMATES: (usize, usize) = (2, 12);

/// How far from the maximum the first two points are, in standard deviations of the prior.
const FIRST: f64 = 0.3;

/// Beside a maximum that was found passes are fewer by this factor, and walks shorter.
const SHORTER: usize = 5;

/// The spread that a profile is looked at in, at least and at most.
const WIDTHS: [f64; 2] = [0.02, 1.0];

/// A difference of log-likelihoods that is taken to be there, at least.
const LEAST_DROP: f64 = 0.05;

/// The profile of coordinate `at` of a likelihood with filters for iterated filtering, as [`super::profile::profile`]: two points say how wide it is, and the others are spread over that.
pub(super) fn iterated_profile<L: Likelihood>(
    likelihood: &L,
    perturbed: &dyn PerturbedLikelihood<Error = L::Error>,
    best: &Maximum,
    at: usize,
    (settings, level): (IteratedSettings, f64),
    seed: &Seed,
) -> Result<Profile, L::Error> {
    let points = |distances: Vec<f64>, seed: &Seed| {
        let found = map_on_threads(&distances, |number, distance| {
            let mut v = best.v.clone();
            v[at] += distance;
            let seed = seed.nth(number as u64);
            let here = with_one_fixed(perturbed, &v, at, settings, &seed.child("passes"))?;
            let (log_likelihood, standard_error) =
                height(likelihood, &here, best.estimator, ESTIMATES, &seed.child("height"))?;
            Ok(ProfilePoint { v: v[at], log_likelihood, standard_error })
        });
        found.into_iter().collect::<Result<Vec<ProfilePoint>, L::Error>>()
    };
    let mut found = points(vec![-FIRST, FIRST], &seed.child("first"))?;
    let drops = found.iter().map(|point| best.log_likelihood - point.log_likelihood);
    let drop = drops.fold(f64::INFINITY, f64::min).max(LEAST_DROP);
    let sd = (FIRST / (2.0 * drop).sqrt()).clamp(WIDTHS[0], WIDTHS[1]);
    let reach = POINTS.0 as f64 * POINTS.1 * sd;
    let distances =
        (1..=POINTS.0).flat_map(|step| [-1.0, 1.0].map(|side| side * step as f64 * POINTS.1 * sd));
    found.extend(points(distances.collect(), &seed.child("points"))?);
    found.retain(|point| (point.v - best.v[at]).abs() <= reach * 1.001);
    for side in [-1.0, 1.0] {
        let mut distance = reach;
        for step in POINTS.0..MOST_POINTS {
            let there = found.iter().filter(|point| side * (point.v - best.v[at]) > 0.0);
            let last = there.max_by(|a, b| (side * a.v).total_cmp(&(side * b.v)));
            let is_done = last.is_none_or(|point| {
                side * point.v >= FARTHEST
                    || is_low(best, (point.log_likelihood, point.standard_error), level)
            });
            if is_done {
                break;
            }
            distance = (LONGER * distance).min(FARTHEST - side * best.v[at]);
            let seed = seed.child("farther").nth(2 * step as u64 + u64::from(side > 0.0));
            found.extend(points(vec![side * distance], &seed)?);
        }
    }
    found.push(ProfilePoint {
        v: best.v[at],
        log_likelihood: best.log_likelihood,
        standard_error: best.standard_error,
    });
    Ok(interval(found, best, at, sd, level))
}

/// Where a swarm is after a few short passes that begin at `v` (`D`), with one coordinate that stays as it is.
fn with_one_fixed<E: Send>(
    likelihood: &dyn PerturbedLikelihood<Error = E>,
    v: &[f64],
    fixed: usize,
    settings: IteratedSettings,
    seed: &Seed,
) -> Result<Vec<f64>, E> {
    let mut positions = v.repeat(settings.particles);
    let passes = settings.passes.div_ceil(SHORTER);
    for pass in 0..passes {
        let spreads = SPREADS.map(|spread| spread / SHORTER as f64);
        let walk = RandomWalk { fixed: Some(fixed), ..between(spreads, pass, passes) };
        likelihood.pass(&mut positions, walk, &seed.nth(pass as u64))?;
    }
    Ok(mean(&positions, v.len()))
}
