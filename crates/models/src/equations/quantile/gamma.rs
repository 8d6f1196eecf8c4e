//! The gamma distribution as a transport of a standard normal number.
//!
//! All is said in `u = log z`, whose density `e^{a·u − eᵘ}/Γ(a)` is log-concave whatever the shape `a` is.

use statrs::function::gamma::{checked_gamma_lr, checked_gamma_ur};

use super::normal;
use super::root::root;
use crate::equations::scalar::Scalar;

/// From this shape on, the Cornish–Fisher expansion has all digits that are asked for.
const LARGE: f64 = 1e5;

/// Beyond this the expansion is given up for the cube root, which grows for any number.
const OUTSIDE: f64 = 40.0;

/// Below this `u` the lower tail is `e^{a·u}/Γ(a+1)` to the last digit.
const LOW: f64 = -37.0;

/// `log` of the density of `u`.
fn log_density(shape: f64, u: f64) -> f64 {
    shape * u - u.exp() - Scalar::ln_gamma(shape)
}

/// `log P(U < u)`.
fn log_lower(shape: f64, u: f64) -> f64 {
    if u < LOW {
        return shape * u - Scalar::ln_gamma(shape + 1.0);
    }
    let z = u.exp();
    let tail = checked_gamma_lr(shape, z).unwrap_or(f64::NAN);
    // Where it is too small for a number, its series as a geometric one.
    let leading = || log_density(shape, u) - shape.ln() - (-z / (shape + 1.0)).ln_1p();
    if tail > f64::MIN_POSITIVE || z >= shape { tail.ln() } else { leading() }
}

/// `log P(U > u)`.
fn log_upper(shape: f64, u: f64) -> f64 {
    if u < LOW {
        return (-log_lower(shape, u).exp()).ln_1p();
    }
    let z = u.exp();
    let tail = checked_gamma_ur(shape, z).unwrap_or(f64::NAN);
    // Where it is too small for a number, the first part of its continued fraction.
    let leading = || log_density(shape, u) - (z + 1.0 - shape).ln();
    if tail > f64::MIN_POSITIVE || z <= shape { tail.ln() } else { leading() }
}

/// `z` and `dz/dv` by the expansion in `1/√shape` (Goldberg and Levine, 1946).
fn expansion(shape: f64, v: f64) -> [f64; 2] {
    let (w, root) = (v * v, shape.sqrt());
    let by = 1.0 / root;
    let value = (w - 1.0) / 3.0
        + by * ((w - 7.0) * v / 36.0
            + by * (-((3.0 * w + 7.0) * w - 16.0) / 810.0
                + by * (((9.0 * w + 256.0) * w - 433.0) * v / 38880.0
                    + by * (((12.0 * w - 243.0) * w - 923.0) * w + 1472.0) / 204120.0)));
    let slope = v * 2.0 / 3.0
        + by * ((3.0 * w - 7.0) / 36.0
            + by * (-(12.0 * w + 14.0) * v / 810.0
                + by * (((45.0 * w + 768.0) * w - 433.0) / 38880.0
                    + by * ((72.0 * w - 972.0) * w - 1846.0) * v / 204120.0)));
    [shape + root * v + value, root + slope]
}

/// `∛(z/shape)` of `v`, about: Wilson's and Hilferty's approximation.
fn cube_root(shape: f64, v: f64) -> f64 {
    1.0 - 1.0 / (9.0 * shape) + v / (3.0 * shape.sqrt())
}

/// `v` of `z`, by the same approximation.
fn from_cube_root(shape: f64, z: f64) -> f64 {
    ((z / shape).cbrt() - 1.0 + 1.0 / (9.0 * shape)) * 3.0 * shape.sqrt()
}

/// `log z` and `log dz/dv` for a large shape.
fn of_large(shape: f64, v: f64) -> [f64; 2] {
    if v.abs() < OUTSIDE {
        return expansion(shape, v).map(f64::ln);
    }
    // Further down z is no number any more.
    let log = cube_root(shape, v).max(1e-100).ln();
    [shape.ln() + 3.0 * log, 0.5 * shape.ln() + 2.0 * log]
}

/// Where the search for `u` begins.
fn start(shape: f64, v: f64, log: f64) -> f64 {
    let cube_root = cube_root(shape, v);
    let cube = if cube_root > 0.0 { shape.ln() + 3.0 * cube_root.ln() } else { f64::NEG_INFINITY };
    if v < 0.0 {
        // The tail is below e^{a·u}/Γ(a+1), so that u is not below this.
        let least = (log + Scalar::ln_gamma(shape + 1.0)) / shape;
        if shape < 1.0 { least } else { cube.max(least) }
    } else if shape < 1.0 {
        // The tail is below e^{−z}/Γ(a) where z is above 1, so that z is not above this.
        (-log - Scalar::ln_gamma(shape)).max(1.0).ln()
    } else {
        cube
    }
}

/// Of the standard gamma `z` of a standard normal `v`: `log z`, and `log dz/dv`; NaN for a shape that is out of range.
pub(in crate::equations) fn from_normal(shape: f64, v: f64) -> [f64; 2] {
    if !(shape > 0.0 && shape < f64::INFINITY) || v.is_nan() {
        return [f64::NAN; 2];
    }
    if shape >= LARGE {
        return of_large(shape, v);
    }
    let log = normal::log_upper(v.abs());
    if log == f64::NEG_INFINITY {
        return [log.copysign(v), f64::INFINITY];
    }
    let (start, unit) = (start(shape, v, log), 1.0 / (1.0 + shape.sqrt()));
    let u = if v < 0.0 && start < LOW {
        start
    } else if v < 0.0 {
        root(start, unit, |u| {
            let tail = log_lower(shape, u);
            let hazard = (log_density(shape, u) - tail).exp();
            [tail - log, hazard, shape - u.exp() - hazard]
        })
    } else {
        root(start, unit, |u| {
            let tail = log_upper(shape, u);
            let hazard = (log_density(shape, u) - tail).exp();
            [tail - log, -hazard, shape - u.exp() + hazard]
        })
    };
    [u, normal::log_density(v) - log_density(shape, u) + u]
}

/// The standard normal `v` of a standard gamma `z`; −∞ where it is not above 0.
pub(in crate::equations) fn to_normal(shape: f64, z: f64) -> f64 {
    if !(shape > 0.0 && shape < f64::INFINITY) || z.is_nan() {
        return f64::NAN;
    }
    if z <= 0.0 {
        return f64::NEG_INFINITY;
    }
    if z == f64::INFINITY {
        return z;
    }
    if shape >= LARGE {
        let start = from_cube_root(shape, z);
        let refined = |v: f64| {
            let [value, slope] = expansion(shape, v);
            [value - z, slope, 0.0]
        };
        return if start.abs() < OUTSIDE { root(start, 1.0, refined) } else { start };
    }
    let u = z.ln();
    let lower = log_lower(shape, u);
    if lower < -std::f64::consts::LN_2 {
        -normal::from_log_upper(lower)
    } else {
        normal::from_log_upper(log_upper(shape, u))
    }
}
