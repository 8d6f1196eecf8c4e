"""What filters and smoothers found, as arrays."""

from __future__ import annotations

import json
from functools import cached_property
from typing import Any

import numpy as np

from . import _motes
from ._table import Rows

#: The probabilities of the quantiles.
PROBABILITIES = (0.05, 0.5, 0.95)


class _Estimates:
    """Estimates of the states, row by row in the order of the data."""

    def __init__(self, found: _motes.Filtered, rows: Rows, states: list[str], measured: list[str]):
        self._found, self._data, self._index, self._labels = found, rows.found, rows.index, rows.labels
        self._levels = rows.levels
        #: The names of the `N` coordinates of a state.
        self.states = states
        self._measured = measured

    @cached_property
    def _arrays(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        n, (mean, sd, quantiles) = len(self.states), self._found.states()
        return mean.reshape(-1, n), sd.reshape(-1, n), quantiles.reshape(-1, n, 3)

    @property
    def mean(self) -> np.ndarray:
        """Means of the states, `(rows, N)`."""
        return self._arrays[0]

    @property
    def sd(self) -> np.ndarray:
        """Standard deviations of the states, `(rows, N)`."""
        return self._arrays[1]

    @property
    def quantiles(self) -> np.ndarray:
        """Quantiles of the states at 5, 50 and 95 %, `(rows, N, 3)`."""
        return self._arrays[2]

    @cached_property
    def time(self) -> np.ndarray:
        """The time of each row in its series, `(rows,)`."""
        return self._data.time

    @cached_property
    def series(self) -> np.ndarray:
        """The number of the series of each row, `(rows,)`."""
        return self._data.series

    @property
    def series_names(self) -> list[str] | None:
        """The names of the series; none where there is one without a name."""
        return self._data.series_names

    @cached_property
    def measurements(self) -> np.ndarray:
        """What was measured, `(rows, M)`; NaN where it is missing."""
        return self._data.measurements.reshape(-1, len(self._measured))

    @property
    def log_evidence(self) -> float:
        """The estimate of `log p(y)` of all series."""
        return self._found.log_evidence

    @cached_property
    def log_evidence_per_series(self) -> np.ndarray:
        """That of each series, `(S,)`."""
        return self._found.log_evidence_per_series()

    @property
    def pareto_k(self) -> float | None:
        """The Pareto k of all steps' weights; above 0.7 they cannot be trusted."""
        return self._found.pareto_k

    @property
    def warnings(self) -> list[str]:
        """Reasons not to trust the estimates."""
        return self._found.warnings

    @property
    def particles(self) -> int:
        """`K`."""
        return self._found.particles

    @property
    def seconds(self) -> float:
        """How long it took."""
        return self._found.seconds

    def to_csv(self) -> str:
        """The table that the command writes."""
        return self._found.csv()

    def to_json(self) -> dict[str, Any]:
        """The object that the command prints with `--json`."""
        return json.loads(self._found.json())

    def _series_labels(self) -> list[Any]:
        """What each series is called where it comes from."""
        labels = self._labels.get("series", None)
        if labels is None:
            return self.series_names or []
        return [labels[at] for at in np.unique(self.series, return_index=True)[1].tolist()]

    def _columns(self, labels: dict[str, list[Any]]) -> dict[str, Any]:
        """The columns of the command's table, but for forecasts; with `labels` for what was text there."""
        columns: dict[str, Any] = {}
        if self.series_names is not None:
            names = self.series_names
            columns["series"] = labels.get("series", [names[number] for number in self.series])
        if self._data.carried is not None:
            name, texts = self._data.carried
            columns[name] = labels.get(name, texts)
        columns["t"] = self.time
        return {**columns, **_of_states(self.states, self.mean, self.sd, self.quantiles)}

    def to_pandas(self) -> Any:
        """A data frame of pandas with a row for each row of the data, and its index where it had one."""
        columns = self._columns(self._labels)
        for level in self._levels:
            # The index has it.
            columns.pop(level, None)
        return _module("pandas", "to_pandas").DataFrame(columns, index=self._index)

    def to_polars(self) -> Any:
        """A data frame of polars with a row for each row of the data."""
        polars = _module("polars", "to_polars")
        try:
            return polars.DataFrame(self._columns(self._labels))
        except TypeError:
            # Labels of a kind that only pandas has: as the command's table has them.
            return polars.DataFrame(self._columns({}))

    def to_html(self, path: Any = None) -> str:
        """The report, one HTML page that needs nothing else; written to `path` if there is one."""
        page = self._found.html(f"{type(self).__name__}.to_html()")
        if path is not None:
            _motes.write(path, page)
        return page

    def plot(self, states: list[str] | None = None, *, series: int = 0, axes: Any = None) -> Any:
        """Draws means with bands from 5 to 95 % of one series by matplotlib, below each other; gives the axes."""
        pyplot = _module("matplotlib.pyplot", "plot")
        shown = self.states if states is None else states
        for name in shown:
            if name not in self.states:
                raise ValueError(f"states: {name}; it must be one of {', '.join(self.states)}")
        rows = np.flatnonzero(self.series == series)
        if len(rows) == 0:
            raise ValueError(f"series: {series}; there are {len(self.log_evidence_per_series)}")
        if axes is None:
            _, axes = pyplot.subplots(len(shown), 1, sharex=True, squeeze=False, figsize=(8, 2.4 * len(shown)))
        axes = np.ravel(axes)
        # Levels of an index have no place on one axis.
        has_index = self._index is not None and getattr(self._index, "nlevels", 1) == 1
        across = self._index[rows] if has_index else self.time[rows]
        for axis, name in zip(axes, shown, strict=True):
            at = self.states.index(name)
            low, high = self.quantiles[rows, at, 0], self.quantiles[rows, at, 2]
            axis.fill_between(across, low, high, alpha=0.25, linewidth=0, label="5 to 95 %")
            axis.plot(across, self.mean[rows, at], label="mean")
            axis.set_ylabel(name)
        axes[0].legend(loc="best", frameon=False)
        axes[-1].set_xlabel("" if has_index else "t")
        return axes

    def __repr__(self) -> str:
        return f"{type(self).__name__}\n{self._found.text()}".rstrip()

    def _repr_html_(self) -> str:
        lines = "".join(f"<li>{_escaped(line)}</li>" for line in self._found.text().splitlines())
        return f"<b>{type(self).__name__}</b><ul>{lines}</ul>"


class Filtered(_Estimates):
    """What a filter found: states given measurements up to each time."""

    @cached_property
    def ess(self) -> np.ndarray:
        """The effective sample size of each row before resampling, in particles, `(rows,)`."""
        return self._found.ess()

    @cached_property
    def log_evidence_increments(self) -> np.ndarray:
        """The estimate of `log p(y_t | y_0 … y_{t−1})` of each row, `(rows,)`; 0 where all is missing."""
        return self._found.log_evidence_increments()

    def _columns(self, labels: dict[str, list[Any]]) -> dict[str, Any]:
        return {**super()._columns(labels), "ess": self.ess, "log_evidence": self.log_evidence_increments}


class Smoothed(_Estimates):
    """What a smoother found: states given all measurements of their series."""

    def paths(self, series: int = 0) -> np.ndarray:
        """Trajectories of a series that were drawn given all measurements, `(B, T, N)`."""
        found = self._found.paths(series)
        if found is None:
            raise ValueError(f"series: {series}; there are {len(self.log_evidence_per_series)}")
        count, values = found
        return values.reshape(count, -1, len(self.states))


class Forecast:
    """What is predicted after the last measurement of each series."""

    def __init__(self, filtered: Filtered, steps: int):
        n, (mean, sd, quantiles) = len(filtered.states), filtered._found.forecasts()
        series = len(filtered.log_evidence_per_series)
        #: The filter up to the last measurement.
        self.filtered = filtered
        #: The names of the `N` coordinates of a state.
        self.states = filtered.states
        #: Means, `(S, steps, N)`.
        self.mean = mean.reshape(series, steps, n)
        #: Standard deviations, `(S, steps, N)`.
        self.sd = sd.reshape(series, steps, n)
        #: Quantiles at 5, 50 and 95 %, `(S, steps, N, 3)`.
        self.quantiles = quantiles.reshape(series, steps, n, 3)

    def to_pandas(self) -> Any:
        """A data frame of pandas with a row for each time: `t` goes on from the last measurement."""
        series, steps, _ = self.mean.shape
        lengths = np.bincount(self.filtered.series, minlength=series)
        columns: dict[str, Any] = {}
        if self.filtered.series_names is not None:
            columns["series"] = [label for label in self.filtered._series_labels() for _ in range(steps)]
        columns["t"] = (lengths[:, None] + np.arange(steps)).reshape(-1)
        n = len(self.states)
        columns |= _of_states(self.states, self.mean.reshape(-1, n), self.sd.reshape(-1, n), self.quantiles.reshape(-1, n, 3))
        return _module("pandas", "to_pandas").DataFrame(columns)

    def __repr__(self) -> str:
        return f"Forecast of {self.mean.shape[1]} times for {self.mean.shape[0]} series"


def _of_states(states: list[str], mean: np.ndarray, sd: np.ndarray, quantiles: np.ndarray) -> dict[str, np.ndarray]:
    """The columns of the states, from `(rows, N)`, `(rows, N)` and `(rows, N, 3)`."""
    columns = {}
    for at, state in enumerate(states):
        columns[f"{state}_mean"], columns[f"{state}_sd"] = mean[:, at], sd[:, at]
        for quantile, name in enumerate(("q05", "q50", "q95")):
            columns[f"{state}_{name}"] = quantiles[:, at, quantile]
    return columns


def _module(name: str, wanted_by: str) -> Any:
    """A library that nothing else needs."""
    import importlib

    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        library = name.partition(".")[0]
        raise ModuleNotFoundError(f"{wanted_by} needs {library}: pip install {library}") from error


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;")
