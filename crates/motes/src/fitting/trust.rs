//! Whether a fit can be trusted.

use motes_inference::{Maximum, MaximumSearch, ParameterSummary, Profile};
use motes_models::equations::Scalar;

use super::free::FreeParameters;
use crate::priors::rounded;
use crate::warning::Warning;

/// What R̂ is to be below, and effective sample sizes at least.
const GATES: (f64, f64) = (1.01, 400.0);

/// A posterior whose mean lies further out in the prior than this, in standard deviations of a normal distribution, lies at its edge.
const EDGE: f64 = 3.0;

/// A posterior that is as wide as the prior, and in the same place: the data say nothing.
const SAME: (f64, f64) = (0.95, 0.1);

/// Farther from the prior than this is another distribution: 400 independent draws of the prior are as far in one of 350 times.
const FAR: f64 = 0.09;

/// Draws are piled up at an end of a uniform prior where their median is in that part of it, and so many of them are as near to the end as a tenth of that: of a density that falls to 0 at the end there are fewer.
const PILE: (f64, f64) = (0.25, 0.035);

/// Differences of log-likelihoods that say something.
const MORE: f64 = 0.5;

/// An end of an interval is that near to the estimate where it should not be, as a share of the width.
const AT_END: f64 = 0.02;

/// A place lies outside of an interval where it is so far beyond, as a share of the width.
const OUTSIDE: f64 = 0.25;

/// Below this share of possible draws from the prior it is worth a word.
const MOSTLY_POSSIBLE: f64 = 0.95;

fn warning(text: String) -> Warning {
    Warning { series: None, text }
}

/// Where a budget ended draws.
pub(super) fn of_budget(is_ended: bool) -> Option<Warning> {
    is_ended.then(|| {
        warning("--budget ended it: the same command with more seconds goes on from there".to_string())
    })
}

/// Where searches were ended before they were done.
pub(super) fn of_work(search: &MaximumSearch, dimension: usize) -> Option<Warning> {
    let (done, all) = search.progress(dimension);
    let share = 100.0 * done as f64 / all as f64;
    (done < all).then(|| {
        warning(format!(
            "--budget ended it with {share:.0} % of its work done: searches and profiles that had not ended are not in it; the same command with more seconds goes on from there"
        ))
    })
}

/// Where chains have not converged; the worst parameter is named.
pub(super) fn of_chains(names: &[String], summaries: &[ParameterSummary]) -> Option<Warning> {
    let worst = |figure: fn(&ParameterSummary) -> f64| {
        let of_all = names.iter().zip(summaries).map(|(name, summary)| (name, figure(summary)));
        of_all.max_by(|a, b| a.1.total_cmp(&b.1))
    };
    let (rhat_of, rhat) = worst(|summary| if summary.rhat.is_nan() { f64::INFINITY } else { summary.rhat })?;
    let (ess_of, fewest) = worst(|summary| {
        let least = summary.ess_bulk.min(summary.ess_tail);
        if least.is_nan() { 0.0 } else { -least }
    })?;
    let size = -fewest;
    let mut faults = Vec::new();
    if rhat >= GATES.0 {
        faults.push(match rhat.is_finite() {
            true => format!("R̂ of {rhat_of} is {rhat:.3}, not below {}", GATES.0),
            false => format!("chains of {rhat_of} stand still"),
        });
    }
    if size < GATES.1 {
        faults.push(format!("{ess_of} has an effective sample size of {size:.0}, below {}", GATES.1));
    }
    let faults = faults.join(", and ");
    (!faults.is_empty())
        .then(|| warning(format!("the chains have not converged: {faults}; take more --draws")))
}

/// What each parameter's place in its prior says: `positions` are its draws as standard normal numbers, were they drawn from the prior.
pub(super) fn of_prior(name: &str, prior: &str, positions: &[f64]) -> Option<Warning> {
    let n = positions.len() as f64;
    let mean = positions.iter().sum::<f64>() / n;
    let sd = (positions.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
    if mean.abs() > EDGE {
        let side = if mean > 0.0 { "upper" } else { "lower" };
        return Some(warning(format!(
            "{name} lies at the {side} edge of its prior {prior}: the prior and the data disagree; widen it, unless its values end there, or look at the model"
        )));
    }
    (sd > SAME.0 && mean.abs() < SAME.1 && distance(positions) < FAR)
        .then(|| warning(format!("the data say nothing about {name}: its posterior is its prior {prior}")))
}

/// The largest distance between the distribution functions of draws and of the prior.
fn distance(positions: &[f64]) -> f64 {
    let mut below: Vec<f64> = positions.iter().map(|v| Scalar::normal_cdf(*v)).collect();
    below.sort_by(f64::total_cmp);
    let n = below.len() as f64;
    let off = |(at, p): (usize, &f64)| (p - at as f64 / n).abs().max((p - (at + 1) as f64 / n).abs());
    below.iter().enumerate().map(off).fold(0.0, f64::max)
}

/// Draws of a parameter, as shares of its uniform prior, that are piled up at one of its ends.
fn of_end(name: &str, prior: &str, positions: &[f64]) -> Option<Warning> {
    let piled = |side: f64| {
        let mut rest: Vec<f64> = positions.iter().map(|v| Scalar::normal_cdf(-side * v)).collect();
        rest.sort_by(f64::total_cmp);
        let median = *rest.get(rest.len() / 2)?;
        let near = rest.iter().take_while(|rest| **rest < 0.1 * median).count();
        (median < PILE.0 && near as f64 > PILE.1 * rest.len() as f64).then_some(if side > 0.0 {
            "upper"
        } else {
            "lower"
        })
    };
    let side = piled(1.0).or_else(|| piled(-1.0))?;
    Some(warning(format!(
        "draws of {name} are piled up at the {side} end of its prior {prior}, which cuts off what the data say: widen it, or look at the model"
    )))
}

/// Where searches came as high as the best one at other values, outside of the interval of a parameter.
pub(super) fn of_places<'m>(
    names: &[String],
    value: &dyn Fn(&Maximum, usize) -> f64,
    best: &Maximum,
    agreeing: impl Iterator<Item = &'m Maximum>,
    profiles: &[Profile],
) -> Option<Warning> {
    let is_outside = |found: &Maximum, profile: &Profile| {
        let (v, width) = (found.v[profile.at], profile.high - profile.low);
        v < profile.low - OUTSIDE * width || v > profile.high + OUTSIDE * width
    };
    agreeing.into_iter().find_map(|found| {
        let at = profiles.iter().find(|profile| is_outside(found, profile))?.at;
        let (one, other) = (rounded(value(best, at)), rounded(value(found, at)));
        Some(warning(format!(
            "there are several maxima: searches came as high where {} is {one} and where it is {other}; the intervals are those of the first alone; take a narrower prior for the one that is meant",
            names[at]
        )))
    })
}

/// Where fewer than half of the searches came as high as the best one.
pub(super) fn of_starts(agreeing: usize, searches: usize) -> Option<Warning> {
    if searches == 1 {
        let text = "one search says nothing of other maxima: take more --chains";
        return Some(warning(text.to_string()));
    }
    (2 * agreeing < searches || agreeing < 2).then(|| {
        warning(format!(
            "{agreeing} of {searches} searches came as high as the best one: there may be higher maxima; take more --chains, or narrower priors"
        ))
    })
}

/// What a profile says against a maximum or an interval: that there is more elsewhere, that the likelihood is flat, or that the interval ends at the estimate.
pub(super) fn of_profile(name: &str, profile: &Profile, best: &Maximum) -> Option<Warning> {
    let points = profile.points.iter();
    let top = points.clone().max_by(|a, b| a.log_likelihood.total_cmp(&b.log_likelihood))?;
    let lowest = points.map(|point| point.log_likelihood).fold(f64::INFINITY, f64::min);
    let more = top.log_likelihood - best.log_likelihood;
    let error = top.standard_error.hypot(best.standard_error);
    if more > MORE.max(3.0 * error) {
        return Some(warning(format!(
            "the profile of {name} finds {more:.1} more than the searches did: the maximum and all intervals are in doubt; take more --chains, or more --particles"
        )));
    }
    if top.log_likelihood - lowest < MORE.max(3.0 * error) {
        return Some(warning(format!(
            "the data say next to nothing of {name}: the likelihood is flat along it"
        )));
    }
    let (width, at) = (profile.high - profile.low, best.v[profile.at]);
    let nearest = (profile.high - at).min(at - profile.low);
    (nearest < AT_END * width).then(|| {
        warning(format!(
            "the interval of {name} ends at its estimate: it is not to be trusted; take more --particles"
        ))
    })
}

/// The share of draws from the prior at which the data are impossible, if it is large.
pub(super) fn of_possible(possible: f64, reason: impl FnOnce() -> Option<String>) -> Option<Warning> {
    let share = 100.0 * (1.0 - possible);
    (possible < MOSTLY_POSSIBLE).then(|| {
        let reason = reason().map_or(String::new(), |reason| format!("; the first time: {reason}"));
        warning(format!("at {share:.0} % of draws from the prior the likelihood is 0{reason}"))
    })
}

/// Warnings of each free parameter; `positions` are its draws as [`of_prior`] takes them.
pub(super) fn of_priors(free: &FreeParameters, positions: &dyn Fn(usize) -> Vec<f64>) -> Vec<Warning> {
    let mut found = Vec::new();
    let mut at = 0;
    for prior in free.priors() {
        for name in prior.entries() {
            // A share of a dirichlet has no number of its own.
            if prior.entries().len() == 1 {
                let positions = positions(at);
                let of_end = || of_end(name, prior.text(), &positions).filter(|_| prior.is_uniform());
                found.extend(of_prior(name, prior.text(), &positions).or_else(of_end));
            }
            at += 1;
        }
    }
    found
}
