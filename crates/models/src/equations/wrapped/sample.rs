//! Drawing from what is made of other distributions.

use rand::RngExt;

use super::{Wrapped, circle, shares};
use crate::Stream;
use crate::equations::quantile::normal;
use crate::equations::scalar::Scalar;

/// Draws that may lie outside before one is given up.
const MOST_TRIES: usize = 100_000;

impl<S: Scalar> Wrapped<'_, S> {
    /// A draw, with the numbers that `of` takes of parameters; NaN where one is out of range, and of what cannot be drawn.
    pub(in crate::equations) fn sample(&self, of: &impl Fn(&S) -> f64, stream: &mut Stream) -> f64 {
        match self {
            Wrapped::Plain(distribution) => distribution.map(of).sample(stream),
            Wrapped::VonMises { mu, kappa } => circle::sample(of(mu), of(kappa), stream),
            Wrapped::Rounded(inner) => rounded(inner.sample(of, stream)),
            Wrapped::Censored { low, high, of: inner } => {
                censored(inner.sample(of, stream), of(low), of(high))
            }
            Wrapped::Truncated { low, high, of: inner } => {
                let (low, high) = (of(low), of(high));
                match inner.noise_within(of, low, high) {
                    Some(ends) => inner.value_at(of, normal_within(ends, stream)),
                    None => {
                        let mut tries = (0..MOST_TRIES).map(|_| inner.sample(of, stream));
                        tries.find(|drawn| (low..=high).contains(drawn)).unwrap_or(f64::NAN)
                    }
                }
            }
            Wrapped::ZeroInflated { p, of: inner } => {
                if is_first(of(p), stream) {
                    0.0
                } else {
                    inner.sample(of, stream)
                }
            }
            Wrapped::Mixture { weight, first, second } => {
                if is_first(of(weight), stream) {
                    first.sample(of, stream)
                } else {
                    second.sample(of, stream)
                }
            }
            Wrapped::Floored { of: inner, .. } => {
                let drawn = inner.sample(of, stream);
                if drawn.is_nan() { inner.without_spread(of) } else { drawn }
            }
            Wrapped::Categorical(all) => shares::sample(all, of, stream),
            Wrapped::LogDensity(_) => f64::NAN,
        }
    }

    /// The one number of a distribution whose standard deviation is 0, which only a floor takes.
    fn without_spread(&self, of: &impl Fn(&S) -> f64) -> f64 {
        match self {
            Wrapped::Plain(distribution) => {
                let [mean, _] = distribution.map(of).mean_and_variance();
                mean
            }
            Wrapped::Rounded(inner) => rounded(inner.without_spread(of)),
            Wrapped::Censored { low, high, of: inner } => {
                censored(inner.without_spread(of), of(low), of(high))
            }
            _ => f64::NAN,
        }
    }

    /// The normal numbers that become what lies in `[low, high]`, where each of them becomes something and larger ones nothing smaller.
    fn noise_within(&self, of: &impl Fn(&S) -> f64, low: f64, high: f64) -> Option<[f64; 2]> {
        match self {
            Wrapped::Plain(distribution) if !distribution.is_discrete() => {
                let distribution = distribution.map(of);
                Some([distribution.to_normal(low), distribution.to_normal(high)])
            }
            Wrapped::Rounded(inner) => inner.noise_within(of, low.ceil() - 0.5, high.floor() + 0.5),
            Wrapped::Plain(distribution) => {
                let distribution = distribution.map(of);
                let end = |last: f64| {
                    let nothing = f64::NEG_INFINITY;
                    let below = distribution.log_mass(nothing, last);
                    if below < -std::f64::consts::LN_2 {
                        -normal::from_log_upper(below)
                    } else {
                        normal::from_log_upper(distribution.log_mass(last, f64::INFINITY))
                    }
                };
                Some([end(low.ceil() - 1.0), end(high.floor())])
            }
            _ => None,
        }
    }

    /// What a normal number becomes, for what [`Wrapped::noise_within`] knows.
    fn value_at(&self, of: &impl Fn(&S) -> f64, v: f64) -> f64 {
        match self {
            Wrapped::Plain(distribution) => distribution.map(of).from_normal(v),
            Wrapped::Rounded(inner) => rounded(inner.value_at(of, v)),
            _ => f64::NAN,
        }
    }
}

/// The integer `y` with `x` in `(y − ½, y + ½]`.
fn rounded(x: f64) -> f64 {
    let down = x.floor();
    if x - down > 0.5 { down + 1.0 } else { down }
}

fn censored(x: f64, low: f64, high: f64) -> f64 {
    if low < high { Scalar::min(Scalar::max(x, low), high) } else { f64::NAN }
}

/// Whether it is what has this probability; NaN never is, and makes nothing of what follows.
fn is_first(probability: f64, stream: &mut Stream) -> bool {
    stream.random::<f64>() < probability
}

/// A standard normal number between two ends, by its distribution function, from the nearer tail.
fn normal_within([low, high]: [f64; 2], stream: &mut Stream) -> f64 {
    if low.partial_cmp(&high) != Some(std::cmp::Ordering::Less) {
        return f64::NAN;
    }
    if low < 0.0 && -low > high {
        return -normal_within([-high, -low], stream);
    }
    let (below, above) = (normal::log_upper(low), normal::log_upper(high));
    // Above 0, so that what is drawn lies inside.
    let share = 1.0 - stream.random::<f64>();
    let log = below + (share + (1.0 - share) * (above - below).exp()).ln();
    Scalar::min(Scalar::max(normal::from_log_upper(log), low), high)
}
