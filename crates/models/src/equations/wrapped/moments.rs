//! Mean, variance and distribution function of what is made of other distributions, where there are formulas.

use super::{Wrapped, shares};

impl Wrapped<'_, f64> {
    /// Mean and variance; none where draws must say so. NaN where there is no mean, or no variance.
    pub(in crate::equations) fn moments(&self) -> Option<[f64; 2]> {
        match *self {
            Wrapped::Plain(distribution) => Some(distribution.mean_and_variance()),
            // What is added to the density has no part in what is measured.
            Wrapped::Floored { of, .. } => of.moments(),
            Wrapped::ZeroInflated { p, of } => Some(mixed(p, [0.0, 0.0], of.moments()?)),
            Wrapped::Mixture { weight, first, second } => {
                Some(mixed(weight, first.moments()?, second.moments()?))
            }
            Wrapped::Categorical(shares) => Some(shares::moments(shares)),
            Wrapped::VonMises { .. }
            | Wrapped::Rounded(_)
            | Wrapped::Censored { .. }
            | Wrapped::Truncated { .. }
            | Wrapped::LogDensity(_) => None,
        }
        // Where a parameter is out of range a draw may still be a number.
        .filter(|moments| !moments[0].is_nan() || matches!(self, Wrapped::Plain(_)))
    }

    /// `P(Y < y)` and `P(Y = y)`; none where there is no distribution function.
    pub(in crate::equations) fn place(&self, y: f64) -> Option<[f64; 2]> {
        match *self {
            Wrapped::Plain(distribution) => Some(distribution.place(y)),
            Wrapped::Floored { of, .. } => of.place(y),
            Wrapped::Categorical(shares) => Some(shares::place(shares, y)),
            _ => {
                let (at, up_to) = (self.log_atom(y).exp(), self.log_mass(f64::NEG_INFINITY, y).exp());
                let place = [(up_to - at).max(0.0), at];
                (!up_to.is_nan() && !at.is_nan()).then_some(place)
            }
        }
    }

    /// Whether it is an angle, or partly one.
    pub(in crate::equations) fn is_angle(&self) -> bool {
        match *self {
            Wrapped::VonMises { .. } => true,
            Wrapped::Plain(_) | Wrapped::Categorical(_) | Wrapped::LogDensity(_) => false,
            Wrapped::Rounded(of)
            | Wrapped::Censored { of, .. }
            | Wrapped::Truncated { of, .. }
            | Wrapped::ZeroInflated { of, .. }
            | Wrapped::Floored { of, .. } => of.is_angle(),
            Wrapped::Mixture { first, second, .. } => first.is_angle() || second.is_angle(),
        }
    }
}

/// Mean and variance of the first with a probability, else of the second.
fn mixed(probability: f64, first: [f64; 2], second: [f64; 2]) -> [f64; 2] {
    let shares = [probability, 1.0 - probability];
    // What has no share has no part in it, whatever its moments are.
    let weighed = |of: [f64; 2]| {
        let products = [shares[0] * of[0], shares[1] * of[1]];
        (0..2).filter(|at| shares[*at] != 0.0).map(|at| products[at]).sum::<f64>()
    };
    let mean = weighed([first[0], second[0]]);
    let spread = |[mean_of, variance]: [f64; 2]| variance + (mean_of - mean) * (mean_of - mean);
    [mean, weighed([spread(first), spread(second)])]
}
