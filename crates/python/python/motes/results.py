"""What filters and smoothers found, as arrays."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _arviz, _motes, _xarray
from ._estimates import Estimates
from ._expectations import covariances, expectations
from ._table import Rows


class Filtered(Estimates):
    """What a filter found: states given measurements up to each time."""

    def __init__(
        self,
        found: _motes.Filtered,
        rows: Rows,
        states: list[str],
        measured: list[str],
        seed: int,
        kept: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None,
    ):
        super().__init__(found, rows, states, measured, seed)
        #: The particles of all rows and their weights, flat; None where nobody asked for them.
        self._kept = kept

    def _weighted(self, name: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Particles and weights, for who asked for that."""
        if self._kept is None:
            raise AttributeError(f"{name}: particles were not kept; filter(…, keep_particles=True) keeps them")
        particles, weights = self._kept
        k, n = self.particle_count, len(self.states)
        return particles.reshape(-1, k, n), weights.reshape(-1, k)

    @property
    def particles(self) -> NDArray[np.float64]:
        """The particles of each row, before any are resampled, `(rows, K, N)`, where `keep_particles` asked for them."""
        return self._weighted("particles")[0]

    @property
    def weights(self) -> NDArray[np.float64]:
        """Their weights, `(rows, K)`; the sum of each row is 1."""
        return self._weighted("weights")[1]

    @property
    def covariance(self) -> NDArray[np.float64]:
        """The covariance of the states of each row, `(rows, N, N)`, where `keep_particles` asked for particles; NaN where one of
        them has all weight, which says nothing of a spread."""
        return covariances(*self._weighted("covariance"))

    def expectation(self, of: Callable[[NDArray[np.float64]], Any]) -> NDArray[np.float64]:
        """The expectation of a function of the state in each row, where `keep_particles` asked for particles.

        `of` is called with the particles of one row, `(K, N)`, and gives a number or an array for each, `(K,)` or `(K, …)`; the
        result is `(rows,)` or `(rows, …)`.

        >>> import motes
        >>> walk = {"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, 1)"}, "measurement": {"y": "normal(x, 1)"}}
        >>> filtered = motes.Model(walk).filter([0.1, None, 0.4], keep_particles=True)
        >>> filtered.expectation(lambda x: x[:, 0] > 0).shape    # the probability of a state above 0
        (3,)
        """
        return expectations(of, *self._weighted("expectation"))

    @cached_property
    def ess(self) -> NDArray[np.float64]:
        """The effective sample size of each row before resampling, in particles, `(rows,)`."""
        return self._found.ess()

    @cached_property
    def log_evidence_increments(self) -> NDArray[np.float64]:
        """The estimate of `log p(y_t | y_0 … y_{t−1})` of each row, `(rows,)`; 0 where all is missing."""
        return self._found.log_evidence_increments()

    @property
    def is_predictive(self) -> bool:
        """Whether the filter was asked to be `predictive`."""
        return self._found.is_predictive

    @cached_property
    def _expected(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        mean, sd, quantiles, pit = self._found.predictive()
        if len(mean) == 0:
            raise ValueError("predictive: nobody asked for it; filter(…, predictive=True) does")
        m, q = len(self._measured), len(self.probabilities)
        return mean.reshape(-1, m), sd.reshape(-1, m), quantiles.reshape(-1, m, q), pit.reshape(-1, m)

    @property
    def predictive_mean(self) -> NDArray[np.float64]:
        """What was expected of each measurement given those before it, where the filter was asked to be `predictive`, `(rows, M)`."""
        return self._expected[0]

    @property
    def predictive_sd(self) -> NDArray[np.float64]:
        """Its standard deviation, `(rows, M)`."""
        return self._expected[1]

    @property
    def predictive_quantiles(self) -> NDArray[np.float64]:
        """Its quantiles at the `probabilities`, `(rows, M, Q)`."""
        return self._expected[2]

    @property
    def pit(self) -> NDArray[np.float64]:
        """Where each measurement lies among what was expected, `P(Y < y) + P(Y = y)/2`, `(rows, M)`; NaN where it is missing."""
        return self._expected[3]

    @property
    def innovations(self) -> NDArray[np.float64]:
        """`y_t − E(y_t | y_0 … y_{t−1})`: each measurement less its `predictive_mean`, in its own units, `(rows, M)`; NaN where it
        is missing."""
        return self.measurements - self.predictive_mean

    @property
    def residuals(self) -> NDArray[np.float64]:
        """Standardised: `(y_t − E(y_t | y_0 … y_{t−1})) / sd(y_t | y_0 … y_{t−1})`, the `innovations` over `predictive_sd`,
        `(rows, M)`; NaN where a measurement is missing.

        Where the model is right they have mean 0, standard deviation 1 and no correlation in time. They are normal only where
        what is expected is; of counts and heavy tails `pit` says more.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.innovations / self.predictive_sd

    def to_xarray(self) -> Any:
        """A dataset of xarray: `mean`, `sd` and `quantiles` of states, `measurements`, `ess`, `log_evidence_increments`, what was
        expected of measurements where the filter was `predictive`, `particles` and `weights` where they were kept, and
        `log_evidence_per_series` with its standard error.

        Dimensions are `series`, `time`, `state` or `measurement`, `quantile` and `particle`, with the names of the model. Series that are
        shorter than the longest are NaN after their last row. `time` has the dates of the data, or numbers that increase as years
        do, or `t`. Where these differ between series, `time` counts rows from 0, and they are coordinates of series and time.
        Attributes are `log_evidence`, `standard_error`, `pareto_k`, `particles`, `seed`, `seconds` and `warnings`.
        """
        return _xarray.of_filtered(self)

    def _predicted(self) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
        return (self.predictive_mean, self.predictive_quantiles) if self.is_predictive else None

    def _columns(self, labels: dict[str, list[Any]]) -> dict[str, Any]:
        columns = {**super()._columns(labels), "ess": self.ess, "log_evidence": self.log_evidence_increments}
        if not self.is_predictive:
            return columns
        for at, name in enumerate(self._measured):
            columns[f"{name}_mean"], columns[f"{name}_sd"] = self.predictive_mean[:, at], self.predictive_sd[:, at]
            columns[f"{name}_pit"] = self.pit[:, at]
        return columns


class Smoothed(Estimates):
    """What a smoother found: states given all measurements of their series."""

    def paths(self, series: int = 0) -> NDArray[np.float64]:
        """Trajectories of a series that were drawn given all measurements, `(B, T, N)`."""
        found = self._found.paths(series)
        if found is None:
            raise ValueError(f"series: {series}; there are {len(self.log_evidence_per_series)}")
        count, values = found
        return values.reshape(count, -1, len(self.states))

    def to_xarray(self) -> Any:
        """A dataset of xarray: `mean`, `sd` and `quantiles` of states, `measurements`, and `log_evidence_per_series` with its standard
        error; its dimensions, coordinates and attributes are those of `Filtered.to_xarray`."""
        return _xarray.of_smoothed(self)

    def to_arviz(self) -> Any:
        """The trajectories as ArviZ has draws: the group `posterior` with a variable for each state, of one chain, and the
        measurements in `observed_data`.

        Dimensions after chain and draw are `series` and `time`, as in `to_xarray`.
        """
        return _arviz.of_paths(self)
