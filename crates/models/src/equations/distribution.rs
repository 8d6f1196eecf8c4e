//! The distributions of one coordinate, as values: which family, with which parameters.

use super::scalar::Scalar;

/// A distribution of one number, whose parameters may depend on the states.
///
/// Any but those of counts can be scaled and then shifted: `exponential(1.0).scaled(3.0).shifted(-3.0)`. Where a parameter is out of range or NaN,
/// densities and draws are NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Distribution<S> {
    /// [`normal`].
    Normal {
        /// Its mean.
        mean: S,
        /// Its standard deviation, above 0.
        sd: S,
    },
    /// [`student_t`].
    StudentT {
        /// Degrees of freedom, above 0.
        df: S,
        /// Its centre.
        location: S,
        /// Its scale, above 0.
        scale: S,
    },
    /// [`laplace`].
    Laplace {
        /// Its centre.
        location: S,
        /// Its scale, above 0.
        scale: S,
    },
    /// `origin + sign·e^z` of a normal `z`: [`log_normal`].
    LogNormal {
        /// The end of its range.
        origin: S,
        /// 1, or −1 where it lies below its origin.
        sign: S,
        /// The mean of `z`.
        location: S,
        /// The standard deviation of `z`, above 0.
        scale: S,
    },
    /// `origin + mean·E` of a standard exponential `E`: [`exponential`].
    Exponential {
        /// The end of its range.
        origin: S,
        /// The distance of its mean from there; below 0 where it lies below its origin.
        mean: S,
    },
    /// `origin + scale·G` of a standard gamma `G`: [`gamma`].
    Gamma {
        /// The end of its range.
        origin: S,
        /// Its shape, above 0.
        shape: S,
        /// Its scale; below 0 where it lies below its origin.
        scale: S,
    },
    /// [`uniform`].
    Uniform {
        /// Its lower end.
        low: S,
        /// Its upper end.
        high: S,
    },
    /// [`poisson`].
    Poisson {
        /// Its mean, at least 0.
        mean: S,
    },
    /// [`negative_binomial`].
    NegativeBinomial {
        /// Its mean, at least 0.
        mean: S,
        /// Its size, above 0.
        size: S,
    },
    /// [`binomial`].
    Binomial {
        /// The number of trials, an integer of at least 0.
        n: S,
        /// The probability of success.
        p: S,
    },
}

/// NaN where `value` is not above 0.
#[inline(always)]
fn above_zero<S: Scalar>(value: S) -> S {
    value.where_positive(value, S::from(f64::NAN))
}

/// 0, or NaN where `value` is NaN.
#[inline(always)]
pub(super) fn zero_or_nan<S: Scalar>(value: S) -> S {
    value.where_positive(S::from(0.0), S::from(0.0))
}

/// `N(mean, sd²)`: `−½ ((x − mean)/sd)² − log sd − ½ log 2π`.
#[inline(always)]
pub fn normal<S: Scalar>(mean: impl Into<S>, sd: impl Into<S>) -> Distribution<S> {
    Distribution::Normal { mean: mean.into(), sd: above_zero(sd.into()) }
}

/// Student's t with `df` degrees of freedom: `z = (x − location)/scale` has the density
/// `Γ((df+1)/2) / (Γ(df/2) √(df π)) · (1 + z²/df)^{−(df+1)/2}`.
#[inline(always)]
pub fn student_t<S: Scalar>(
    df: impl Into<S>,
    location: impl Into<S>,
    scale: impl Into<S>,
) -> Distribution<S> {
    Distribution::StudentT {
        df: above_zero(df.into()),
        location: location.into(),
        scale: above_zero(scale.into()),
    }
}

/// Laplace's distribution: `−|x − location|/scale − log 2 scale`. Its standard deviation is `√2·scale`.
#[inline(always)]
pub fn laplace<S: Scalar>(location: impl Into<S>, scale: impl Into<S>) -> Distribution<S> {
    Distribution::Laplace { location: location.into(), scale: above_zero(scale.into()) }
}

/// That of `e^z` for `z ~ N(location, scale²)`.
#[inline(always)]
pub fn log_normal<S: Scalar>(location: impl Into<S>, scale: impl Into<S>) -> Distribution<S> {
    let (origin, sign) = (S::from(0.0), S::from(1.0));
    Distribution::LogNormal { origin, sign, location: location.into(), scale: above_zero(scale.into()) }
}

/// The exponential distribution: `−x/mean − log mean` for `x ≥ 0`.
#[inline(always)]
pub fn exponential<S: Scalar>(mean: impl Into<S>) -> Distribution<S> {
    Distribution::Exponential { origin: S::from(0.0), mean: above_zero(mean.into()) }
}

/// The gamma distribution with mean `shape·scale`: `(shape − 1) log x − x/scale − log Γ(shape) − shape log scale` for `x > 0`.
#[inline(always)]
pub fn gamma<S: Scalar>(shape: impl Into<S>, scale: impl Into<S>) -> Distribution<S> {
    let (shape, scale) = (above_zero(shape.into()), above_zero(scale.into()));
    Distribution::Gamma { origin: S::from(0.0), shape, scale }
}

/// Uniform on `[low, high]`.
#[inline(always)]
pub fn uniform<S: Scalar>(low: impl Into<S>, high: impl Into<S>) -> Distribution<S> {
    let (low, high): (S, S) = (low.into(), high.into());
    // The width is NaN where the ends are the wrong way round.
    Distribution::Uniform { low, high: low + above_zero(high - low) }
}

/// The number of events where `mean` are expected: `k log mean − mean − log k!` for `k = 0, 1, …`.
#[inline(always)]
pub fn poisson<S: Scalar>(mean: impl Into<S>) -> Distribution<S> {
    Distribution::Poisson { mean: mean.into() }
}

/// Counts with the given mean and the variance `mean + mean²/size`: a Poisson distribution whose mean is a gamma of shape `size`.
#[inline(always)]
pub fn negative_binomial<S: Scalar>(mean: impl Into<S>, size: impl Into<S>) -> Distribution<S> {
    Distribution::NegativeBinomial { mean: mean.into(), size: above_zero(size.into()) }
}

/// The number of successes in `n` trials with probability `p` each.
#[inline(always)]
pub fn binomial<S: Scalar>(n: impl Into<S>, p: impl Into<S>) -> Distribution<S> {
    Distribution::Binomial { n: n.into(), p: p.into() }
}

/// 1 with probability `p`, else 0.
#[inline(always)]
pub fn bernoulli<S: Scalar>(p: impl Into<S>) -> Distribution<S> {
    binomial(1.0, p)
}

impl<S> Distribution<S> {
    /// Whether it is one of counts, which can be neither shifted nor scaled.
    pub fn is_discrete(&self) -> bool {
        matches!(
            self,
            Distribution::Poisson { .. }
                | Distribution::NegativeBinomial { .. }
                | Distribution::Binomial { .. }
        )
    }

    /// The same family with each parameter replaced by what `of` makes of it.
    #[inline(always)]
    pub(super) fn map<T>(&self, of: impl Fn(&S) -> T) -> Distribution<T> {
        match self {
            Distribution::Normal { mean, sd } => Distribution::Normal { mean: of(mean), sd: of(sd) },
            Distribution::StudentT { df, location, scale } => {
                Distribution::StudentT { df: of(df), location: of(location), scale: of(scale) }
            }
            Distribution::Laplace { location, scale } => {
                Distribution::Laplace { location: of(location), scale: of(scale) }
            }
            Distribution::LogNormal { origin, sign, location, scale } => Distribution::LogNormal {
                origin: of(origin),
                sign: of(sign),
                location: of(location),
                scale: of(scale),
            },
            Distribution::Exponential { origin, mean } => {
                Distribution::Exponential { origin: of(origin), mean: of(mean) }
            }
            Distribution::Gamma { origin, shape, scale } => {
                Distribution::Gamma { origin: of(origin), shape: of(shape), scale: of(scale) }
            }
            Distribution::Uniform { low, high } => Distribution::Uniform { low: of(low), high: of(high) },
            Distribution::Poisson { mean } => Distribution::Poisson { mean: of(mean) },
            Distribution::NegativeBinomial { mean, size } => {
                Distribution::NegativeBinomial { mean: of(mean), size: of(size) }
            }
            Distribution::Binomial { n, p } => Distribution::Binomial { n: of(n), p: of(p) },
        }
    }
}

impl<S: Scalar> Distribution<S> {
    /// That of `x + by`. Counts cannot be shifted: a parameter becomes NaN.
    #[inline(always)]
    #[must_use]
    pub fn shifted(self, by: impl Into<S>) -> Self {
        self.affine(by.into(), S::from(1.0))
    }

    /// That of `by·x`. A factor of 0 is out of range, and counts cannot be scaled: a parameter becomes NaN.
    #[inline(always)]
    #[must_use]
    pub fn scaled(self, by: impl Into<S>) -> Self {
        self.affine(S::from(0.0), by.into())
    }

    /// The same with parameters that are NaN where they are out of range: for what was not made by the functions of this module.
    #[inline(always)]
    pub(super) fn guarded(self) -> Self {
        match self {
            Distribution::Normal { mean, sd } => normal(mean, sd),
            Distribution::StudentT { df, location, scale } => student_t(df, location, scale),
            Distribution::Laplace { location, scale } => laplace(location, scale),
            Distribution::LogNormal { origin, sign, location, scale } => {
                Distribution::LogNormal { origin, sign, location, scale: above_zero(scale) }
            }
            Distribution::Exponential { origin, mean } => {
                Distribution::Exponential { origin, mean: above_zero(mean) }
            }
            Distribution::Gamma { origin, shape, scale } => {
                Distribution::Gamma { origin, shape: above_zero(shape), scale: above_zero(scale) }
            }
            Distribution::Uniform { low, high } => uniform(low, high),
            Distribution::Poisson { mean } => poisson(mean),
            Distribution::NegativeBinomial { mean, size } => negative_binomial(mean, size),
            Distribution::Binomial { n, p } => binomial(n, p),
        }
    }

    /// That of `shift + scale·x`.
    #[inline(always)]
    fn affine(self, shift: S, scale: S) -> Self {
        let nan = S::from(f64::NAN);
        // NaN for a scale of 0.
        let size = above_zero(scale.abs());
        match self {
            Distribution::Normal { mean, sd } => {
                Distribution::Normal { mean: mean * scale + shift, sd: sd * size }
            }
            Distribution::StudentT { df, location, scale: own } => {
                Distribution::StudentT { df, location: location * scale + shift, scale: own * size }
            }
            Distribution::Laplace { location, scale: own } => {
                Distribution::Laplace { location: location * scale + shift, scale: own * size }
            }
            Distribution::LogNormal { origin, sign, location, scale: own } => Distribution::LogNormal {
                origin: origin * scale + shift,
                sign: sign * (scale / size),
                location: location + size.ln(),
                scale: own,
            },
            Distribution::Exponential { origin, mean } => Distribution::Exponential {
                origin: origin * scale + shift,
                mean: mean * scale + zero_or_nan(size),
            },
            Distribution::Gamma { origin, shape, scale: own } => Distribution::Gamma {
                origin: origin * scale + shift,
                shape,
                scale: own * scale + zero_or_nan(size),
            },
            Distribution::Uniform { low, high } => {
                let (a, b) = (low * scale + shift, high * scale + shift);
                Distribution::Uniform { low: a.min(b) + zero_or_nan(size), high: a.max(b) }
            }
            Distribution::Poisson { .. } => Distribution::Poisson { mean: nan },
            Distribution::NegativeBinomial { size, .. } => Distribution::NegativeBinomial { mean: nan, size },
            Distribution::Binomial { n, .. } => Distribution::Binomial { n, p: nan },
        }
    }
}
