"""A filter that takes in measurements as they come."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _motes
from ._display import Display, shapes
from ._quantiles import percent, probabilities_of
from ._table import numbers_of, text_of_label
from .proposal import named

if TYPE_CHECKING:
    from ._definition import Definition


class OnlineFilter:
    """A filter that takes in measurements as they come."""

    def __init__(self, model: Definition, settings: Mapping[str, Any]):
        self._model, self._settings = model, settings
        self._running = _motes.Online(model._model, self._options(), 0)
        self._width = len(model.measurements)
        #: The names of the `N` coordinates of a state.
        self.states = model.states
        #: The names of the `M` coordinates of a measurement.
        self.measurements = model.measurements
        #: How many rows it went through, by `step` or `predict`.
        self.rows = 0
        #: The mean of the state, `(N,)`; NaN before the first step.
        self.mean: NDArray[np.float64] = np.full(len(self.states), np.nan)
        #: Its standard deviation, `(N,)`.
        self.sd: NDArray[np.float64] = self.mean.copy()
        #: The probabilities of quantiles.
        self.probabilities: list[float] = probabilities_of(settings["quantiles"])
        #: Its quantiles, `(N, Q)`.
        self.quantiles: NDArray[np.float64] = np.full((len(self.states), len(self.probabilities)), np.nan)
        #: The effective sample size of the last step, in particles.
        self.ess: float | None = None
        #: The estimate of `log p(y_t | y_0 … y_{t−1})` of the last step.
        self.log_evidence_increment: float | None = None
        #: What was expected of the measurement before it was used, `(M,)`, where the filter was made with `predictive=True`; after
        #: `predict`, what is expected then.
        self.measurement_mean: NDArray[np.float64] = np.full(self._width, np.nan)
        #: Its standard deviation, `(M,)`.
        self.measurement_sd: NDArray[np.float64] = self.measurement_mean.copy()
        #: Its quantiles, `(M, Q)`.
        self.measurement_quantiles: NDArray[np.float64] = np.full((self._width, len(self.probabilities)), np.nan)
        #: Where the measurement lay in that, `P(Y < y) + P(Y = y)/2`, `(M,)`; NaN where it was missing.
        self.pit: NDArray[np.float64] = self.measurement_mean.copy()

    @property
    def seed(self) -> int:
        """What all its random numbers come from."""
        return int(self._settings["seed"])

    def step(self, measurement: Any, *, time: Any = None, inputs: Mapping[str, float] | None = None) -> OnlineFilter:
        """Takes in the measurement of the next row, `(M,)`, NaN or None where one is missing; gives itself.

        `time` is the row's where the model names a column of times, `inputs` are the columns that its inputs come from, by name.
        """
        values = np.atleast_1d(numbers_of(measurement, None))
        if values.shape != (self._width,):
            raise ValueError(f"measurement: an array of shape {values.shape}; it must be ({self._width},)")
        if np.isinf(values).any():
            raise ValueError(f"measurement: {values}; it must be finite, and NaN where one is missing")
        known = self._running.step(np.ascontiguousarray(values), self._time(time), self._inputs(inputs or {}))
        return self._known(known)

    def predict(self, *, time: Any = None, inputs: Mapping[str, float] | None = None) -> OnlineFilter:
        """Goes on by a row at which nothing is measured, a gap as the last one ahead where no `time` is given; gives itself."""
        known = None if inputs is None and time is None else self._inputs(inputs or {})
        return self._known(self._running.predict(None if known is None else self._time(time), known))

    def _options(self) -> _motes.FilterOptions:
        return _motes.FilterOptions(**{**self._settings, "proposal": named(self._settings["proposal"])})

    def _time(self, time: Any) -> str | None:
        column = self._model._model.time_column
        if (column is None) != (time is None):
            expected = f"the column {column} is that of times" if column else "the model names no column of times"
            raise ValueError(f"time: {time!r}; {expected}")
        return None if time is None else text_of_label(time)

    def _inputs(self, inputs: Mapping[str, float]) -> NDArray[np.float64]:
        measured, needed = self._model.measurements, self._model._model.input_columns
        unknown = [name for name in inputs if name not in needed]
        if unknown:
            raise ValueError(f"inputs: {unknown[0]} is none of the model; it has {', '.join(needed) or 'none'}")
        missing = [name for name in needed if name not in inputs and name not in measured]
        if missing:
            raise ValueError(f"inputs: {missing[0]} is missing; each row needs it, NaN where it is not known")
        return np.array([float(inputs.get(name, np.nan)) for name in needed])

    @property
    def log_evidence(self) -> float:
        """The estimate of `log p(y)` of all measurements so far."""
        return self._running.log_evidence

    @property
    def standard_error(self) -> float | None:
        """The standard error of `log_evidence` where the filter was made with `check=True`; none of fewer than 16 particles."""
        return self._running.standard_error

    @property
    def pareto_k(self) -> float | None:
        """The Pareto k of the last step's weights."""
        return self._running.pareto_k

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_running": (self._running.checkpoint(), self._running.has_failed)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._running = _motes.Online.resume(self._model._model, self._options(), *state["_running"])

    def __copy__(self) -> OnlineFilter:
        # One that shared anything with the original would be stepped with it.
        return copy.deepcopy(self)

    def __deepcopy__(self, memo: dict[int, Any]) -> OnlineFilter:
        made = memo[id(self)] = type(self).__new__(type(self))
        state = self.__getstate__()
        # Model and settings never change and are shared.
        shared = {key: state.pop(key) for key in ("_model", "_settings")}
        made.__setstate__({**copy.deepcopy(state, memo), **shared})
        return made

    def _known(self, known: tuple[Any, ...]) -> OnlineFilter:
        self.mean, self.sd, quantiles, self.ess, self.log_evidence_increment, expected = known
        q = len(self.probabilities)
        self.quantiles = quantiles.reshape(-1, q)
        # Nothing is expected where nobody asked.
        self.measurement_mean, self.measurement_sd, quantiles, self.pit = (
            values if len(values) > 0 else np.full(size, np.nan)
            for values, size in zip(expected, (self._width, self._width, q * self._width, self._width), strict=True)
        )
        self.measurement_quantiles = quantiles.reshape(-1, q)
        self.rows += 1
        return self

    def _display(self) -> Display:
        if self._running.has_failed:
            return Display(f"OnlineFilter of {self._model.name}, which failed after {self.rows} rows")
        known = [f"log-evidence {self.log_evidence:.3f}"]
        if self.ess is not None and not np.isnan(self.ess):
            known.append(f"effective sample size {self.ess:.0f} of {self._settings['particles']}")
        head = f"OnlineFilter of {self._model.name} after {self.rows} row{'' if self.rows == 1 else 's'}: {', '.join(known)}"
        ends = [percent(self.probabilities[0]), percent(self.probabilities[-1])]
        display = Display(head, [shapes(mean=self.mean, quantiles=self.quantiles)], ["mean", "sd", *ends])
        display.add(self.states, self.mean, self.sd, self.quantiles[:, 0], self.quantiles[:, -1])
        if not np.isnan(self.measurement_mean).all():
            expected = [f"{name}, expected" for name in self.measurements]
            quantiles = self.measurement_quantiles
            display.add(expected, self.measurement_mean, self.measurement_sd, quantiles[:, 0], quantiles[:, -1])
        return display

    def __repr__(self) -> str:
        return self._display().text()

    def _repr_html_(self) -> str:
        return self._display().html()
