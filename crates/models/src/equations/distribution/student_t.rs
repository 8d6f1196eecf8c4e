//! Student's t.

use std::f64::consts::PI;

use crate::equations::draw::{Needs, Rejection, Source, StandardGamma};
use crate::equations::family::{Family, Score, above_zero, first_large, parameters};
use crate::equations::quantile::{Quantile, student, transported};
use crate::equations::scalar::Scalar;
use crate::gaussian::LN_2PI;

parameters! {
    /// The parameters of [`student_t`](super::distributions::student_t).
    StudentT {
        /// Degrees of freedom, above 0.
        df,
        /// Its centre.
        location,
        /// Its scale, above 0.
        scale,
    }
}

impl<S: Scalar> StudentT<S> {
    #[inline(always)]
    pub(super) fn new(df: S, location: S, scale: S) -> Self {
        StudentT { df, location, scale }.guarded()
    }
}

impl<S: Scalar> Family<S> for StudentT<S> {
    const NEEDS: Needs = Needs::NORMAL.plus(StandardGamma::NEEDS);

    #[inline(always)]
    fn guarded(self) -> Self {
        StudentT { df: above_zero(self.df), location: self.location, scale: above_zero(self.scale) }
    }

    #[inline(always)]
    fn affine(self, shift: S, scale: S, size: S) -> Self {
        StudentT { df: self.df, location: self.location * scale + shift, scale: self.scale * size }
    }

    #[inline(always)]
    fn log_density(self, x: S, _: impl FnOnce() -> S) -> S {
        let StudentT { df, location, scale } = self;
        let z = (x - location) / scale;
        let half = (df + 1.0) * 0.5;
        let square = z * z;
        let density = half.ln_gamma()
            - (df * 0.5).ln_gamma()
            - (df * PI).ln() * 0.5
            - scale.ln()
            - half * (square / df + 1.0).ln();
        // Logarithms of many degrees of freedom cancel each other; there it is nearly normal.
        let normal = -square * 0.5 - scale.ln() - 0.5 * LN_2PI;
        let nearly = normal + (square * (square - 2.0) - 1.0) * 0.25 / df;
        (df - first_large(square)).where_positive(nearly, density)
    }

    #[inline(always)]
    fn draw(self, source: &mut impl Source<S>) -> S {
        let normal = source.normal();
        // χ²(df) is twice a gamma of half its degrees of freedom.
        let half = self.df * 0.5;
        let factor = (half / source.by::<StandardGamma>(half, half)).sqrt();
        self.location + self.scale * normal * factor
    }

    #[inline(always)]
    fn moments(self) -> [S; 2] {
        let square = self.scale * self.scale;
        let beyond = self.df - 2.0;
        [self.location, beyond.where_positive(square * self.df / beyond, square)]
    }

    #[inline(always)]
    fn score(self, y: S) -> Score<S> {
        let StudentT { df, location, scale } = self;
        let (rest, square) = (y - location, scale * scale);
        // That of the normal distribution of this slope, far out: an outlier says next to nothing.
        let pull = (df + 1.0) / (df * square + rest * rest);
        Score { location, slope: pull * rest, information: pull.min((df + 1.0) / ((df + 3.0) * square)) }
    }

    #[inline(always)]
    fn spread(self) -> Option<[S; 2]> {
        Some([self.scale.ln(), self.df * 2.0 / (self.df + 3.0)])
    }

    fn to_normal(self, x: S) -> S {
        let z = (x - self.location) / self.scale;
        let density = |[z, df]: [f64; 2]| StudentT { df, location: 0.0, scale: 1.0 }.log_density(z, || z);
        transported([z, self.df], |[z, df]| student::to_normal(df, z), density)
    }
}

impl Quantile for StudentT<f64> {
    fn transport(self, v: f64) -> [f64; 2] {
        let [t, log_slope] = student::from_normal(self.df, v);
        [self.location + self.scale * t, log_slope + Scalar::ln(self.scale)]
    }
}
