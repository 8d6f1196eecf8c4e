//! Distributions as transports of a standard normal number: `x = T(v) = F⁻¹(Φ(v))`.

pub(super) mod count;
pub(super) mod gamma;
mod guided;
pub(super) mod near_normal;
pub(super) mod normal;
mod root;
mod scaled_tail;
pub(super) mod student;

pub(super) use count::Count;
pub(super) use guided::{GuidedNoise, guided};
pub(super) use root::root;

use super::family::Family;
use super::scalar::Scalar;

/// What a family is asked with plain numbers.
pub(super) trait Quantile: Family<f64> {
    /// `T(v)` and `log T′(v)`; NaN for counts.
    fn transport(self, v: f64) -> [f64; 2] {
        self.formula(v).unwrap_or([f64::NAN; 2])
    }

    /// `T(v)`: of counts the smallest whose distribution function reaches `Φ(v)`.
    fn value_at(self, v: f64) -> f64 {
        self.transport(v)[0]
    }

    /// The ends of where it can lie, infinite ones, too.
    fn ends(self) -> [f64; 2] {
        [f64::NEG_INFINITY, f64::INFINITY]
    }
}

/// The ends of what lies above its origin, or below it where `sign` is negative.
pub(super) fn beyond(origin: f64, sign: f64) -> [f64; 2] {
    if sign > 0.0 { [origin, f64::INFINITY] } else { [f64::NEG_INFINITY, origin] }
}

/// −1 below 0, else 1; NaN where it is NaN.
pub(super) fn sign_of<S: Scalar>(value: S) -> S {
    (-value).where_positive(S::from(-1.0), S::from(1.0))
}

/// The standard normal quantile that `of` gives for a standardised number and the shapes of its distribution, whose log density there is `log_density`.
///
/// Its derivative in the number is a ratio of densities. For those in shapes there is no formula; they are differences.
pub(super) fn transported<S: Scalar, const K: usize>(
    arguments: [S; K],
    of: impl Fn([f64; K]) -> f64,
    log_density: impl Fn([f64; K]) -> f64,
) -> S {
    S::custom(arguments, &of, |at, v| {
        let mut slopes = [0.0; K];
        // Beyond the ends of the range nothing changes.
        if v.is_finite() {
            slopes[0] = (log_density(at) - normal::log_density(v)).exp();
            for (which, slope) in slopes.iter_mut().enumerate().skip(1) {
                *slope = difference(at, which, &of);
            }
        }
        slopes
    })
}

/// `log(Φ(high) − Φ(low))`; −∞ where `high` is not above `low`.
pub(super) fn normal_mass<S: Scalar>(ends: [S; 2]) -> S {
    let of =
        |[low, high]: [f64; 2]| if low >= high { f64::NEG_INFINITY } else { normal::log_mass(low, high) };
    S::custom(ends, of, |ends, mass| {
        // No end changes anything where it is infinite, or where there is no mass.
        let at = |v: f64| {
            if v.is_finite() && mass.is_finite() { (normal::log_density(v) - mass).exp() } else { 0.0 }
        };
        [-at(ends[0]), at(ends[1])]
    })
}

/// The derivative of a smooth function of positive numbers along one of them, by differences of the fourth order.
pub(super) fn difference<const K: usize>(at: [f64; K], which: usize, of: impl Fn([f64; K]) -> f64) -> f64 {
    let step = 1e-3 * at[which];
    let moved = |steps: f64| {
        let mut moved = at;
        moved[which] += steps * step;
        of(moved)
    };
    (8.0 * (moved(1.0) - moved(-1.0)) - (moved(2.0) - moved(-2.0))) / (12.0 * step)
}
