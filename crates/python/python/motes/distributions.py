"""Distributions that functions of a model return.

Parameters are numbers, or arrays with one for each particle. A distribution can be shifted and scaled: `x + exponential(1)`
is one, and `2 * laplace(0, 1)`. Counts can be neither.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

__all__ = [
    "Distribution",
    "bernoulli",
    "beta",
    "binomial",
    "exponential",
    "gamma",
    "known",
    "laplace",
    "log_normal",
    "negative_binomial",
    "normal",
    "poisson",
    "student_t",
    "uniform",
]


@dataclass(frozen=True, slots=True, eq=False)
class Distribution:
    """`shift + scale·z` for `z` of a family, for many particles at a time; without a shift or a scale where they are None."""

    #: The name of the function that made it.
    family: str
    parameters: tuple[Any, ...]
    scale: Any = None
    shift: Any = None

    #: Arrays leave sums with a distribution to it.
    __array_ufunc__ = None

    def __add__(self, by: Any) -> Distribution:
        self._check(by)
        return replace(self, shift=by if self.shift is None else self.shift + by)

    __radd__ = __add__

    def __sub__(self, by: Any) -> Distribution:
        shifted: Distribution = self + -by
        return shifted

    def __rsub__(self, by: Any) -> Distribution:
        shifted: Distribution = -self + by
        return shifted

    def __mul__(self, by: Any) -> Distribution:
        self._check(by)
        scale = by if self.scale is None else self.scale * by
        return replace(self, scale=scale, shift=None if self.shift is None else self.shift * by)

    __rmul__ = __mul__

    def __truediv__(self, by: Any) -> Distribution:
        self._check(by)
        scaled: Distribution = self * (1.0 / by)
        return scaled

    def __neg__(self) -> Distribution:
        return self * -1.0

    def _check(self, by: Any) -> None:
        """Refuses what cannot be shifted or scaled, and what it cannot be shifted or scaled by."""
        if isinstance(by, Distribution):
            raise TypeError(f"{self.family} and {by.family}: a distribution is shifted and scaled by numbers, not by another")
        if by is None:
            raise TypeError(f"{self.family} and None: a distribution is shifted and scaled by numbers")
        if self.family == "known":
            raise TypeError("known: a known value is neither shifted nor scaled; compute with the value itself")
        if self.family in ("poisson", "negative_binomial", "binomial", "bernoulli"):
            raise TypeError(f"{self.family}: counts can be neither shifted nor scaled")


def normal(mean: Any, sd: Any) -> Distribution:
    """The normal distribution; `sd` is above 0."""
    return Distribution("normal", (mean, sd))


def student_t(df: Any, location: Any, scale: Any) -> Distribution:
    """Student's t with `df` degrees of freedom, for noise with outliers; `df` and `scale` are above 0."""
    return Distribution("student_t", (df, location, scale))


def laplace(location: Any, scale: Any) -> Distribution:
    """Laplace's distribution, whose standard deviation is √2·scale; `scale` is above 0."""
    return Distribution("laplace", (location, scale))


def log_normal(location: Any, scale: Any) -> Distribution:
    """That of `e^z` for a normal `z` with this mean and standard deviation; `scale` is above 0."""
    return Distribution("log_normal", (location, scale))


def exponential(mean: Any) -> Distribution:
    """The exponential distribution; `mean` is above 0."""
    return Distribution("exponential", (mean,))


def gamma(shape: Any, scale: Any) -> Distribution:
    """The gamma distribution with mean shape·scale; both are above 0."""
    return Distribution("gamma", (shape, scale))


def beta(a: Any, b: Any) -> Distribution:
    """The beta distribution between 0 and 1, with mean a/(a + b); both are above 0."""
    return Distribution("beta", (a, b))


def uniform(low: Any, high: Any) -> Distribution:
    """All numbers from `low` to `high` alike."""
    return Distribution("uniform", (low, high))


def poisson(mean: Any) -> Distribution:
    """Counts of events, where `mean` are expected, at least 0."""
    return Distribution("poisson", (mean,))


def negative_binomial(mean: Any, size: Any) -> Distribution:
    """Counts with the variance mean + mean²/size; `mean` is at least 0, `size` above 0."""
    return Distribution("negative_binomial", (mean, size))


def binomial(n: Any, p: Any) -> Distribution:
    """Successes in `n` trials, an integer of at least 0, with probability `p` each."""
    return Distribution("binomial", (n, p))


def bernoulli(p: Any) -> Distribution:
    """1 with probability `p`, else 0."""
    return Distribution("bernoulli", (p,))


def known(value: Any) -> Distribution:
    """A coordinate of a state that is not drawn: known at the start, or following from the state before."""
    return Distribution("known", (value,))
