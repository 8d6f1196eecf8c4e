"""Filters, smoothers and forecasts of a model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from . import _motes
from ._definition import Definition, parameter_rows
from ._errors import warn
from ._estimates import warned
from ._keywords import checked
from ._quantiles import PROBABILITIES, probabilities_of
from ._seed import seed_of
from ._table import data_of, inputs_of
from .forecast import Forecast, steps_or_inputs
from .online import OnlineFilter
from .proposal import Proposal, named
from .results import Filtered, Smoothed


class Filtering(Definition):
    """A model with its filters, smoothers and forecasts."""

    @checked
    def filter(
        self,
        data: Any,
        *,
        proposal: str | Proposal = "bootstrap",
        particles: int = 1000,
        defensive: float | None = None,
        resample_below: float = 0.5,
        resampling: str = "systematic",
        seed: int | np.random.Generator | None = 1,
        check: bool = True,
        predictive: bool = False,
        quantiles: Sequence[float] = PROBABILITIES,
        keep_particles: bool = False,
        threads: int | None = None,
    ) -> Filtered:
        """Estimates the states of `data`, time by time, with the evidence of each measurement.

        `data` is an array of shape `(T, M)` or `(S, T, M)`, or `(T,)` where `M` is 1, or a list of arrays of unequal length.
        It can also be a data frame of pandas or polars, a dict of columns, or the path of a CSV file. These are read as the
        command reads CSV: columns by the names of the measurements, `series`, `t`, and a first column of another name that is
        carried along. NaN and None are missing.

        - `proposal`: `bootstrap`, `linearised`, `optimal`, a `Proposal`, or `exact`, which takes the Kalman filter, or for discrete
          states the forward algorithm, in the place of particles.
        - `particles`: `K`.
        - `defensive`: the share of particles that is drawn from the transition. If None, 0.1 of a learned proposal, 0.1 of
          `linearised` where it draws noise that is not normal, and 0 else.
        - `resample_below`: resample where the effective sample size is below this share of `particles`; at each step where it is 1.
        - `resampling`: `multinomial`, `systematic`, `stratified` or `residual`.
        - `seed`: all random numbers come from it. A `numpy.random.Generator` gives a draw of 63 bits, and None, as in NumPy, a number
          that is another in each call; results have it as `seed`.
        - `check`: whether small filters run beside it, and a bootstrap filter beside any other proposal: they give the log-evidence its
          standard error, and warn where it cannot be trusted.
        - `predictive`: whether each measurement is predicted from those before it: then results have `predictive_mean`,
          `predictive_sd`, `pit` and `residuals`.
        - `quantiles`: the probabilities of the quantiles that are given, above 0 and below 1, each above the one before.
        - `keep_particles`: whether results have `particles`, `weights`, `covariance` and `expectation(f)`; they take `rows · K · N` numbers.
        - `threads`: all that the machine has if None.

        What is not given is as in the command `motes filter`. The same seed gives the same bytes there, and on any number of
        threads.

        Warns with `MotesWarning` where the result cannot be trusted. Raises `ValueError` for bad input.

        >>> import motes
        >>> walk = {"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, 1)"}, "measurement": {"y": "normal(x, 1)"}}
        >>> filtered = motes.Model(walk).filter([0.1, None, 0.4], proposal="optimal")
        >>> filtered.sd.shape, len(filtered.log_evidence_increments)
        ((3, 1), 3)
        """
        seed = seed_of(seed)
        options = _motes.FilterOptions(
            proposal=named(proposal),
            particles=particles,
            defensive=defensive,
            resample_below=resample_below,
            resampling=resampling,
            seed=seed,
            check=check,
            predictive=predictive,
            quantiles=probabilities_of(quantiles),
            keep_particles=keep_particles,
            threads=threads,
        )
        return self._filtered(data, options, seed)

    @overload
    def log_evidence(
        self,
        data: Any,
        parameters: None = None,
        *,
        proposal: str | Proposal = ...,
        particles: int = ...,
        defensive: float | None = ...,
        resample_below: float = ...,
        resampling: str = ...,
        seed: int | np.random.Generator | None = ...,
        threads: int | None = ...,
    ) -> float: ...

    @overload
    def log_evidence(
        self,
        data: Any,
        parameters: Any,
        *,
        proposal: str | Proposal = ...,
        particles: int = ...,
        defensive: float | None = ...,
        resample_below: float = ...,
        resampling: str = ...,
        seed: int | np.random.Generator | None = ...,
        threads: int | None = ...,
    ) -> NDArray[np.float64]: ...

    @checked
    def log_evidence(
        self,
        data: Any,
        parameters: Any = None,
        *,
        proposal: str | Proposal = "bootstrap",
        particles: int = 1000,
        defensive: float | None = None,
        resample_below: float = 0.5,
        resampling: str = "systematic",
        seed: int | np.random.Generator | None = 1,
        threads: int | None = None,
    ) -> float | NDArray[np.float64]:
        """The estimate of `log p(y)` of all series, and nothing else: what a search over parameters and particle MCMC ask for.

        It is that of `filter` with the same settings, which has no `check` here, to the last bit; what costs time beside it is
        left out. Where no particle explains a measurement, the estimate of the evidence is 0: this gives −∞ and warns with
        `MotesWarning`, which names the row. `filter` raises `ValueError` there.

        >>> import motes
        >>> walk = {"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, 1)"}, "measurement": {"y": "normal(x, 1)"}}
        >>> model = motes.Model(walk)
        >>> model.log_evidence([0.1, None, 0.4]) == model.filter([0.1, None, 0.4]).log_evidence
        True

        With `parameters`, it is that at each of `n` values of them, an array of shape `(n,)`. They are a dict of arrays or a data frame by their names, or
        an array of shape `(n, D)`. Its columns are the parameters that have a prior, or all if none has one, in the order of the
        model. All have the same random numbers, and all threads are used: that is what an optimiser or a sampler of one's own asks
        for. It is −∞ where no particle explains a measurement, and where there is no such model.

        >>> walk = {"parameters": {"sd": "half_normal(2)"}, **walk, "transition": {"x": "normal(x, sd)"}}
        >>> motes.Model(walk).log_evidence([0.1, None, 0.4], parameters={"sd": [0.5, 1.0, 2.0]}).shape
        (3,)
        """
        rows = data_of(self._model, data)
        options = _motes.FilterOptions(
            proposal=named(proposal),
            particles=particles,
            defensive=defensive,
            resample_below=resample_below,
            resampling=resampling,
            seed=seed_of(seed),
            check=False,
            threads=threads,
        )
        if parameters is not None:
            free = _motes.free_parameters(self._model) or [name for name, _ in self._model.parameters]
            names, values = parameter_rows(parameters, free)
            return _motes.log_evidence_at(self._model, rows.found, options, names, values.reshape(-1))
        found, impossible = self._model.log_evidence(rows.found, options)
        if impossible is not None:
            warn(impossible)
        return found

    @checked
    def forecast(
        self,
        data: Any,
        steps: int | None = None,
        *,
        inputs: Any = None,
        proposal: str | Proposal = "bootstrap",
        particles: int = 1000,
        defensive: float | None = None,
        resample_below: float = 0.5,
        resampling: str = "systematic",
        seed: int | np.random.Generator | None = 1,
        check: bool = True,
        predictive: bool = False,
        quantiles: Sequence[float] = PROBABILITIES,
        threads: int | None = None,
    ) -> Forecast:
        """Predicts states and measurements of `steps` times after the last measurement of each series, or at the times and with
        the inputs of `inputs`: a file, a data frame, or a dict of columns. Settings are those of `filter`.

        Rows of data with dates or years in equal steps, in an index of pandas or in the column that is carried along, are followed
        by rows with those after them. Where dates are there and it is not known which ones follow, it warns.
        """
        steps_or_inputs(steps, inputs)
        seed = seed_of(seed)
        options = _motes.FilterOptions(
            proposal=named(proposal),
            particles=particles,
            defensive=defensive,
            resample_below=resample_below,
            resampling=resampling,
            seed=seed,
            check=check,
            predictive=predictive,
            quantiles=probabilities_of(quantiles),
            threads=threads,
            forecast=steps or 0,
            ahead=None if inputs is None else inputs_of(self._model, inputs),
        )
        return Forecast(self._filtered(data, options, seed), steps)

    @checked
    def smooth(
        self,
        data: Any,
        *,
        paths: int = 200,
        proposal: str | Proposal = "bootstrap",
        particles: int = 1000,
        defensive: float | None = None,
        resample_below: float = 0.5,
        resampling: str = "systematic",
        seed: int | np.random.Generator | None = 1,
        check: bool = True,
        quantiles: Sequence[float] = PROBABILITIES,
        threads: int | None = None,
    ) -> Smoothed:
        """Estimates the states given all measurements, by `paths` trajectories drawn backwards; settings are those of `filter`."""
        seed, rows = seed_of(seed), data_of(self._model, data)
        options = _motes.FilterOptions(
            proposal=named(proposal),
            particles=particles,
            defensive=defensive,
            resample_below=resample_below,
            resampling=resampling,
            seed=seed,
            check=check,
            quantiles=probabilities_of(quantiles),
            threads=threads,
        )
        found = self._model.smooth(rows.found, options, paths)
        return warned(Smoothed(found, rows, self.states, self.measurements, seed))

    @checked
    def online(
        self,
        *,
        proposal: str | Proposal = "bootstrap",
        particles: int = 1000,
        defensive: float | None = None,
        resample_below: float = 0.5,
        resampling: str = "systematic",
        seed: int | np.random.Generator | None = 1,
        check: bool = False,
        predictive: bool = False,
        quantiles: Sequence[float] = PROBABILITIES,
        threads: int | None = 1,
    ) -> OnlineFilter:
        """A filter that takes in measurements as they come, by `step(y)`; settings are those of `filter`.

        A pickle or a copy of it, made at any time, goes on as it would itself, to the last bit.

        >>> import motes
        >>> walk = {"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, 1)"}, "measurement": {"y": "normal(x, 1)"}}
        >>> online = motes.Model(walk).online(proposal="optimal")
        >>> online.step(0.3).mean.shape
        (1,)
        """
        settings = {
            "proposal": proposal,
            "particles": particles,
            "defensive": defensive,
            "resample_below": resample_below,
            "resampling": resampling,
            "seed": seed_of(seed),
            "check": check,
            "predictive": predictive,
            "quantiles": probabilities_of(quantiles),
            "threads": threads,
        }
        return OnlineFilter(self, settings)

    def _filtered(self, data: Any, options: _motes.FilterOptions, seed: int) -> Filtered:
        rows = data_of(self._model, data)
        found, kept = _motes.filter(self._model, rows.found, options)
        return warned(Filtered(found, rows, self.states, self.measurements, seed, kept))
