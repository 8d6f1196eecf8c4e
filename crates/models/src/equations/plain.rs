//! Numbers without derivatives, which those with derivatives are made of.

use super::lanes::Lanes;
use super::scalar::{Scalar, digamma};

/// A number without derivatives: what a [`Dual`](super::Dual) is made of.
pub trait Plain: Scalar {
    /// `ψ(x) = d log Γ(x) / dx` for `x > 0`, NaN elsewhere.
    #[must_use]
    fn digamma(self) -> Self;

    /// The derivatives of a function of a few numbers, given its value: [`Scalar::custom`].
    fn slopes<const K: usize>(
        arguments: [Self; K],
        value: Self,
        slopes: impl Fn([f64; K], f64) -> [f64; K],
    ) -> [Self; K];
}

impl Plain for f64 {
    fn digamma(self) -> f64 {
        digamma(self)
    }

    fn slopes<const K: usize>(
        arguments: [f64; K],
        value: f64,
        slopes: impl Fn([f64; K], f64) -> [f64; K],
    ) -> [f64; K] {
        slopes(arguments, value)
    }
}

impl<const W: usize> Plain for Lanes<W> {
    fn digamma(self) -> Self {
        Lanes(self.0.map(digamma))
    }

    fn slopes<const K: usize>(
        arguments: [Self; K],
        value: Self,
        slopes: impl Fn([f64; K], f64) -> [f64; K],
    ) -> [Self; K] {
        let mut found = [Lanes::from(0.0); K];
        for lane in 0..W {
            let of_lane = slopes(arguments.map(|argument| argument.0[lane]), value.0[lane]);
            found.iter_mut().zip(of_lane).for_each(|(found, slope)| found.0[lane] = slope);
        }
        found
    }
}
