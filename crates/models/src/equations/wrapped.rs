//! Distributions of measurements that are made of others: rounded, censored, mixed.

mod circle;
mod logs;
mod mass;
mod sample;
mod score;
mod shares;

use super::distribution::Distribution;
use super::scalar::Scalar;
use logs::{log_sum, log_sum_of};

/// A distribution of an entry of a measurement that no single family gives.
///
/// It may have *atoms*: numbers of which each has a probability of its own. There `log p` is the logarithm of this probability, elsewhere that of a density.
#[derive(Clone, Copy)]
pub enum Wrapped<'a, S> {
    /// That of a family.
    Plain(Distribution<S>),
    /// An angle: `κ cos(y − μ) − log 2π I₀(κ)` for any real `y`, over one turn.
    VonMises {
        /// Where it is most likely.
        mu: S,
        /// How concentrated it is, at least 0.
        kappa: S,
    },
    /// The nearest integer: `y` where the number lies in `(y − ½, y + ½]`.
    Rounded(&'a Wrapped<'a, S>),
    /// The number itself between `low` and `high`, and these for what lies beyond.
    Censored {
        /// The lower end, perhaps −∞.
        low: S,
        /// The upper end, perhaps +∞.
        high: S,
        /// What is censored.
        of: &'a Wrapped<'a, S>,
    },
    /// Given that it lies in `[low, high]`.
    Truncated {
        /// The lower end, perhaps −∞.
        low: S,
        /// The upper end, perhaps +∞.
        high: S,
        /// What is truncated.
        of: &'a Wrapped<'a, S>,
    },
    /// 0 with probability `p`, else the other.
    ZeroInflated {
        /// The probability.
        p: S,
        /// The other.
        of: &'a Wrapped<'a, S>,
    },
    /// The first with probability `weight`, else the second.
    Mixture {
        /// The weight of the first.
        weight: S,
        /// The first.
        first: &'a Wrapped<'a, S>,
        /// The second.
        second: &'a Wrapped<'a, S>,
    },
    /// Its density is larger by `floor`, which is all of it where a parameter is out of range. It is drawn as it is without.
    Floored {
        /// What is added, above 0.
        floor: S,
        /// What is drawn.
        of: &'a Wrapped<'a, S>,
    },
    /// 0, 1, … with these probabilities, which add up to 1 up to a millionth.
    Categorical(&'a [S]),
    /// A log density that is a formula of `y`. It cannot be drawn from: what is drawn is NaN.
    LogDensity(&'a dyn Fn(S) -> S),
}

impl<S: Scalar> Wrapped<'_, S> {
    /// `log p(y)`; −∞ outside the support, NaN where a parameter is out of range.
    pub fn log_density(&self, y: S) -> S {
        let nothing = S::from(f64::NEG_INFINITY);
        match *self {
            Wrapped::Plain(distribution) => distribution.log_density(y),
            Wrapped::VonMises { mu, kappa } => circle::log_density(mu, kappa, y),
            Wrapped::Categorical(shares) => shares::log_density(shares, y),
            Wrapped::LogDensity(formula) => formula(y),
            Wrapped::Rounded(of) => {
                let off = (y - y.floor()).abs();
                off.where_positive(nothing, of.log_mass(y - 0.5, y + 0.5))
            }
            Wrapped::Censored { low, high, of } => {
                self.at_ends([low, high], of, y, of.log_density(y)) + in_order(low, high)
            }
            Wrapped::Truncated { low, high, of } => {
                let inside = of.log_density(y) - of.log_mass(of.before(low), high);
                let depth = (y - low).min(high - y);
                (-depth).where_positive(nothing, inside) + in_order(low, high)
            }
            Wrapped::ZeroInflated { p, of } => {
                let other = (-p + 1.0).ln();
                let at_zero = log_sum(p.ln(), other + of.log_atom(y));
                y.abs().where_positive(other + of.log_density(y), at_zero)
            }
            Wrapped::Mixture { weight, first, second } => {
                let logs = [weight.ln(), (-weight + 1.0).ln()];
                let density = log_sum(logs[0] + first.log_density(y), logs[1] + second.log_density(y));
                if !self.has_atoms() || self.is_of_integers() {
                    return density;
                }
                // A probability is more than any density.
                let atom = log_sum(logs[0] + first.log_atom(y), logs[1] + second.log_atom(y));
                (atom + f64::MAX).where_positive(atom, density)
            }
            Wrapped::Floored { floor, of } => floored(of.log_density(y), floor),
        }
    }

    /// The log probability of `y` itself; −∞ where it is no atom.
    fn log_atom(&self, y: S) -> S {
        match *self {
            _ if self.is_of_integers() => self.log_density(y),
            Wrapped::Censored { low, high, of } => self.at_ends([low, high], of, y, of.log_atom(y)),
            Wrapped::Truncated { low, high, of } => of.log_atom(y) - of.log_mass(of.before(low), high),
            Wrapped::ZeroInflated { p, of } => {
                let others = (-p + 1.0).ln() + of.log_atom(y);
                y.abs().where_positive(others, log_sum(p.ln(), others))
            }
            Wrapped::Mixture { weight, first, second } => {
                log_sum(weight.ln() + first.log_atom(y), (-weight + 1.0).ln() + second.log_atom(y))
            }
            Wrapped::Floored { of, .. } => of.log_atom(y),
            _ => S::from(f64::NEG_INFINITY),
        }
    }

    /// What is censored: `between` inside, and at the ends the mass beyond.
    fn at_ends(&self, [low, high]: [S; 2], of: &Wrapped<'_, S>, y: S, between: S) -> S {
        let (nothing, everything) = (S::from(f64::NEG_INFINITY), S::from(f64::INFINITY));
        let at_low = (low - y).where_positive(nothing, of.log_mass(nothing, low));
        let at_high = (y - high).where_positive(nothing, of.log_mass(of.before(high), everything));
        (y - low).where_positive((high - y).where_positive(between, at_high), at_low)
    }

    /// Whether there may be numbers with a probability of their own.
    fn has_atoms(&self) -> bool {
        match *self {
            Wrapped::Plain(distribution) => distribution.is_discrete(),
            Wrapped::VonMises { .. } | Wrapped::LogDensity(_) => false,
            Wrapped::Rounded(_)
            | Wrapped::Categorical(_)
            | Wrapped::Censored { .. }
            | Wrapped::ZeroInflated { .. } => true,
            Wrapped::Truncated { of, .. } | Wrapped::Floored { of, .. } => of.has_atoms(),
            Wrapped::Mixture { first, second, .. } => first.has_atoms() || second.has_atoms(),
        }
    }

    /// Whether all that it gives are integers.
    fn is_of_integers(&self) -> bool {
        match *self {
            Wrapped::Plain(distribution) => distribution.is_discrete(),
            Wrapped::VonMises { .. } | Wrapped::LogDensity(_) => false,
            Wrapped::Rounded(_) | Wrapped::Categorical(_) => true,
            // The ends may be any numbers.
            Wrapped::Censored { .. } => false,
            Wrapped::Truncated { of, .. }
            | Wrapped::ZeroInflated { of, .. }
            | Wrapped::Floored { of, .. } => of.is_of_integers(),
            Wrapped::Mixture { first, second, .. } => first.is_of_integers() && second.is_of_integers(),
        }
    }

    /// What is so little below `low` that all from `low` on lies above it.
    fn before(&self, low: S) -> S {
        match *self {
            Wrapped::Censored { of, .. } => of.before(low),
            _ if self.is_of_integers() => -(-low).floor() - 1.0,
            _ => low,
        }
    }
}

/// 0, or NaN where `low` is not below `high`.
fn in_order<S: Scalar>(low: S, high: S) -> S {
    let zero = S::from(0.0);
    (high - low).where_positive(zero, S::from(f64::NAN))
}

/// `log(e^density + floor)`, and the logarithm of the floor where there is no density.
fn floored<S: Scalar>(density: S, floor: S) -> S {
    S::custom(
        [density, floor],
        |[density, floor]| {
            let floor = Scalar::ln(floor);
            if density.is_nan() { floor } else { log_sum_of(density, floor) }
        },
        |[density, floor], sum| {
            let share = (density - sum).exp();
            [if share.is_nan() { 0.0 } else { share }, (Scalar::ln(floor) - sum).exp() / floor]
        },
    )
}
