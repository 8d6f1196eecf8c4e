//! What a measurement says of its location, about: a guide for proposals, whose weights are exact anyway.

use super::{Wrapped, circle, shares};
use crate::equations::family::Score;
use crate::equations::quantile::normal;
use crate::equations::scalar::Scalar;

impl<S: Scalar> Wrapped<'_, S> {
    /// What the observation `y` says of the location of what is inside.
    pub(in crate::equations) fn score(&self, y: S) -> Score<S> {
        match *self {
            Wrapped::Plain(distribution) => distribution.score(y),
            Wrapped::VonMises { mu, kappa } => circle::score(mu, kappa, y),
            Wrapped::Rounded(of) => {
                // Rounding adds the variance of a uniform number.
                let score = of.score(y);
                let share = S::from(1.0) / (score.information / 12.0 + 1.0);
                score.times(share)
            }
            Wrapped::Censored { low, high, of } => {
                let score = of.score(y);
                let [below, above] = [beyond(score, -1.0), beyond(score, 1.0)];
                // Below the end, at it, or above: inside it is what it would be without ends.
                let choose = |at_low: S, inside: S, at_high: S| {
                    (y - low).where_positive((high - y).where_positive(inside, at_high), at_low)
                };
                Score {
                    location: score.location,
                    slope: choose(below[0], score.slope, above[0]),
                    information: choose(below[1], score.information, above[1]),
                }
            }
            Wrapped::Truncated { of, .. } => of.score(y),
            Wrapped::ZeroInflated { p, of } => {
                let score = of.score(y);
                let own = (-p + 1.0).ln() + of.log_atom(y);
                let at_zero = share(own, p.ln());
                score.times(y.abs().where_positive(S::from(1.0), at_zero))
            }
            Wrapped::Mixture { weight, first, second } => {
                let log = |weight: S, of: &Wrapped<'_, S>| weight.ln() + of.log_density(y);
                let (one, other) = (log(weight, first), log(-weight + 1.0, second));
                let scores =
                    [first.score(y).times(share(one, other)), second.score(y).times(share(other, one))];
                // Both pull at the location, each with its information.
                let information = scores[0].information + scores[1].information;
                let part = part(scores[0].information, scores[1].information);
                Score {
                    location: weighed(scores[0].location, part) + weighed(scores[1].location, -part + 1.0),
                    slope: scores[0].slope + scores[1].slope,
                    information,
                }
            }
            Wrapped::Floored { floor, of } => of.score(y).times(share(of.log_density(y), floor.ln())),
            // The formula itself is what changes; the square of its derivative stands for the information.
            Wrapped::Categorical(all) => shares::score(all, y),
            Wrapped::LogDensity(formula) => {
                Score { location: formula(y), slope: S::from(1.0), information: S::from(1.0) }
            }
        }
    }
}

impl<S: Scalar> Score<S> {
    /// With the part of slope and information that is due to it: all is 0 where this is 0, whatever it was.
    fn times(self, share: S) -> Self {
        let zero = S::from(0.0);
        let of = |value: S| share.where_positive(value * share, zero);
        Score {
            location: share.where_positive(self.location, zero),
            slope: of(self.slope),
            information: of(self.information),
        }
    }
}

/// A number times a weight, which is 0 where the weight is.
fn weighed<S: Scalar>(value: S, weight: S) -> S {
    weight.where_positive(value * weight, S::from(0.0))
}

/// `a/(a + b)` without derivatives; 0 where there is nothing.
fn part<S: Scalar>(a: S, b: S) -> S {
    S::custom([a, b], |[a, b]| if a > 0.0 { a / (a + b) } else { 0.0 }, |_, _| [0.0; 2])
}

/// `eᵃ/(eᵃ + eᵇ)` without derivatives; 0 where the first is none.
fn share<S: Scalar>(a: S, b: S) -> S {
    let of = |[a, b]: [f64; 2]| {
        if a.is_nan() || a == f64::NEG_INFINITY { 0.0 } else { 1.0 / (1.0 + (b - a).exp()) }
    };
    S::custom([a, b], of, |_, _| [0.0; 2])
}

/// Slope and information where all that is known is that the number lies beyond: `sign` times further out. As if it were normal.
fn beyond<S: Scalar>(score: Score<S>, sign: f64) -> [S; 2] {
    let root = score.information.sqrt();
    // By how many standard deviations the end lies towards that side.
    let z = (score.slope / root * sign).max(S::from(-1e100)).min(S::from(1e100));
    let hazard = S::custom(
        [z],
        // Far out the difference of two large logarithms has no digits.
        |[z]| if z > 1e3 { z + 1.0 / z } else { (normal::log_density(z) - normal::log_upper(z)).exp() },
        |[z], hazard| [hazard * (hazard - z)],
    );
    [root * hazard * sign, score.information * hazard * (hazard - z)]
}
