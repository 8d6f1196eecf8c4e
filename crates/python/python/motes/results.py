"""What filters and smoothers found, as arrays."""

from __future__ import annotations

import json
from functools import cached_property
from typing import Any

import numpy as np

from . import _motes
from ._dates import are_dates, following
from ._errors import warn
from ._table import Rows, _text

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

    def __getstate__(self) -> dict[str, Any]:
        # What was computed of the rest is computed again.
        of_rest = [name for name in self.__dict__ if isinstance(getattr(type(self), name, None), cached_property)]
        return {name: value for name, value in self.__dict__.items() if name not in of_rest}

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
        return _whole(self._data.time)

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
    def standard_error(self) -> float | None:
        """The standard error of `log_evidence`; 0 where it is exact, none without `check` or with fewer than 16 particles."""
        return self._found.standard_error

    @cached_property
    def standard_error_per_series(self) -> np.ndarray:
        """That of each series, `(S,)`; NaN where there is none."""
        return self._found.standard_error_per_series()

    @property
    def pareto_k(self) -> float | None:
        """The largest Pareto k of a step's weights, less its sampling error; above 0.7 they cannot be trusted."""
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
        labels = self._labels.get(self._data.series_column, None)
        if labels is None:
            return self.series_names or []
        return [labels[at] for at in np.unique(self.series, return_index=True)[1].tolist()]

    def _followed(self, steps: int) -> tuple[Any, list[Any] | None]:
        """What follows the rows of each series, one series after the other: a part of an index, and of the carried column.

        None where rows have no dates. Where dates do not go on with equal steps, nobody knows which ones follow: it warns.
        """
        rows = [np.flatnonzero(self.series == number) for number in range(len(self.log_evidence_per_series))]
        index = None
        dates = None if self._index is None else _dates_of(self._index)
        if dates is not None:
            parts = [following(dates if len(rows) == 1 else dates[at], steps) for at in rows]
            if any(part is None for part in parts):
                _warn_of("the index", steps)
            else:
                index = _index_of(self._index, rows, parts, steps)
        carried = None
        if self._data.carried is not None:
            name, texts = self._data.carried
            labels = self._labels.get(name, texts)
            if are_dates(labels):
                found = [following([labels[at] for at in places], steps) for places in rows]
                if any(part is None for part in found):
                    _warn_of(f"column {name}", steps)
                else:
                    carried = [one for part in found for one in part]
        return index, carried

    def _columns(self, labels: dict[str, list[Any]]) -> dict[str, Any]:
        """The columns of the command's table, but for forecasts; with `labels` for what was text there."""
        columns: dict[str, Any] = {}
        if self.series_names is not None:
            names = self.series_names
            name = self._data.series_column
            columns[name] = labels.get(name, [names[number] for number in self.series])
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
        # Levels of an index have no place on one axis.
        has_index = self._index is not None and getattr(self._index, "nlevels", 1) == 1
        return self._plotted(states, series, axes, has_index)

    def _plotted(self, states: list[str] | None, series: int, axes: Any, has_index: bool) -> Any:
        """The same, over the index of the data or over times."""
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

    @cached_property
    def _expected(self) -> tuple[np.ndarray, ...]:
        mean, sd, quantiles, pit = self._found.predictive()
        if len(mean) == 0:
            raise ValueError("predictive: nobody asked for it; filter(…, predictive=True) does")
        m = len(self._measured)
        return mean.reshape(-1, m), sd.reshape(-1, m), quantiles.reshape(-1, m, 3), pit.reshape(-1, m)

    @property
    def predictive_mean(self) -> np.ndarray:
        """What was expected of each measurement given those before it, where the filter was asked to be `predictive`, `(rows, M)`."""
        return self._expected[0]

    @property
    def predictive_sd(self) -> np.ndarray:
        """Its standard deviation, `(rows, M)`."""
        return self._expected[1]

    @property
    def predictive_quantiles(self) -> np.ndarray:
        """Its quantiles at 5, 50 and 95 %, `(rows, M, 3)`."""
        return self._expected[2]

    @property
    def pit(self) -> np.ndarray:
        """Where each measurement lies among what was expected, `P(Y < y) + P(Y = y)/2`, `(rows, M)`; NaN where it is missing."""
        return self._expected[3]

    def _columns(self, labels: dict[str, list[Any]]) -> dict[str, Any]:
        columns = {**super()._columns(labels), "ess": self.ess, "log_evidence": self.log_evidence_increments}
        if not self._found.is_predictive:
            return columns
        for at, name in enumerate(self._measured):
            columns[f"{name}_mean"], columns[f"{name}_sd"] = self.predictive_mean[:, at], self.predictive_sd[:, at]
            columns[f"{name}_pit"] = self.pit[:, at]
        return columns


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
    """What is predicted after the last measurement of each series: states and measurements.

    Where rows of the data have dates with equal steps, as an index of pandas or in the column that is carried along, its
    rows have those that follow.
    """

    def __init__(self, filtered: Filtered, steps: int | None = None):
        n, (mean, sd, quantiles) = len(filtered.states), filtered._found.forecasts()
        counts = sorted(set(filtered._found.forecast_counts()))
        if steps is None:
            if len(counts) > 1:
                said = ", ".join(map(str, counts))
                raise ValueError(f"inputs: series have {said} rows ahead; a forecast has as many of each")
            steps = counts[0]
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
        #: The names of the `M` coordinates of a measurement.
        self.measurements = filtered._measured
        m, (mean, sd, quantiles, _) = len(self.measurements), filtered._found.forecast_measurements()
        #: Means of the measurements, `(S, steps, M)`.
        self.measurement_mean = mean.reshape(series, steps, m)
        #: Their standard deviations, `(S, steps, M)`.
        self.measurement_sd = sd.reshape(series, steps, m)
        #: Their quantiles at 5, 50 and 95 %, `(S, steps, M, 3)`.
        self.measurement_quantiles = quantiles.reshape(series, steps, m, 3)
        #: The times, which go on from the last measurement, `(S, steps)`.
        self.time = _whole(filtered._found.forecast_times()).reshape(series, steps)
        written = filtered._found.forecast_labels()
        if written and filtered._data.carried is not None:
            self._index, self._carried = None, written
        else:
            self._index, self._carried = filtered._followed(steps)

    def _columns(self, labels: list[Any] | None) -> dict[str, Any]:
        """The columns of its table, with `labels` in the column that is carried along."""
        series, steps, n = self.mean.shape
        columns: dict[str, Any] = {}
        if self.filtered.series_names is not None:
            columns[self.filtered._data.series_column] = [label for label in self.filtered._series_labels() for _ in range(steps)]
        if labels is not None:
            columns[self.filtered._data.carried[0]] = labels
        columns["t"] = self.time.reshape(-1)
        m = len(self.measurements)
        expected = (
            self.measurement_mean.reshape(-1, m),
            self.measurement_sd.reshape(-1, m),
            self.measurement_quantiles.reshape(-1, m, 3),
        )
        return (
            columns
            | _of_states(self.states, self.mean.reshape(-1, n), self.sd.reshape(-1, n), self.quantiles.reshape(-1, n, 3))
            | _of_states(self.measurements, *expected)
        )

    def to_pandas(self) -> Any:
        """A data frame of pandas with a row for each time of each series, and the dates that follow those of the data."""
        return _module("pandas", "to_pandas").DataFrame(self._columns(self._carried), index=self._index)

    def to_polars(self) -> Any:
        """A data frame of polars with a row for each time of each series, and the dates that follow those of the data."""
        polars = _module("polars", "to_polars")
        try:
            return polars.DataFrame(self._columns(self._carried))
        except TypeError:
            # Dates of a kind that only pandas has.
            labels = None if self._carried is None else [_text(label) for label in self._carried]
            return polars.DataFrame(self._columns(labels))

    def to_csv(self) -> str:
        """Its table as text, with the dates that follow those of the data in the place of the column that is carried along."""
        labels = None
        if self._carried is not None:
            labels = (self.filtered._data.carried[0], [_text(label) for label in self._carried])
        elif self._index is not None:
            # Levels beside the dates are the series, which has a column of its own.
            dates = _dates_of(self._index)
            labels = (str(dates.name or "date"), [_text(label) for label in dates])
        return self.filtered._found.forecast_csv(labels)

    def to_html(self, path: Any = None) -> str:
        """The report of the filter with what is predicted, one HTML page that needs nothing else; written to `path` if there is one."""
        page = self.filtered._found.html("Forecast.to_html()")
        if path is not None:
            _motes.write(path, page)
        return page

    def plot(self, states: list[str] | None = None, *, series: int = 0, axes: Any = None) -> Any:
        """Draws the filter's means and bands of one series, and behind them those that are predicted; gives the axes."""
        steps = self.mean.shape[1]
        ahead = None if self._index is None else self._index[series * steps : (series + 1) * steps]
        has_dates = ahead is not None and getattr(ahead, "nlevels", 1) == 1
        axes = self.filtered._plotted(states, series, axes, has_dates)
        across = ahead if has_dates else self.time[series]
        for axis, name in zip(axes, self.states if states is None else states, strict=True):
            at = self.states.index(name)
            low, high = self.quantiles[series, :, at, 0], self.quantiles[series, :, at, 2]
            axis.fill_between(across, low, high, alpha=0.25, linewidth=0, color="C1", label="forecast, 5 to 95 %")
            axis.plot(across, self.mean[series, :, at], color="C1", label="forecast")
        axes[0].legend(loc="best", frameon=False)
        return axes

    def __repr__(self) -> str:
        return f"Forecast of {self.mean.shape[1]} times for {self.mean.shape[0]} series"


def _warn_of(what: str, steps: int) -> None:
    if steps > 0:
        warn(f"data, {what}: its dates do not go on with equal steps, so that the rows of the forecast have none")


def _dates_of(index: Any) -> Any:
    """The dates of an index of pandas: itself, or the one level that has them; None if there are none."""
    levels = [index.get_level_values(level) for level in range(index.nlevels)]
    dates = [level for level in levels if are_dates(level)]
    return dates[0] if len(dates) == 1 else None


def _index_of(index: Any, rows: list[np.ndarray], dates: list[Any], steps: int) -> Any:
    """An index like that of the data, with these dates of each series; other levels say what they said in its last row."""
    whole = dates[0] if len(dates) == 1 else dates[0].append(dates[1:])
    if index.nlevels == 1:
        return whole
    last = [index[places[-1]] for places in rows]
    levels = [
        whole if are_dates(index.get_level_values(level)) else [row[level] for row in last for _ in range(steps)]
        for level in range(index.nlevels)
    ]
    return type(index).from_arrays(levels, names=index.names)


def _whole(times: np.ndarray) -> np.ndarray:
    """Times as integers, where all of them are."""
    whole = times.astype(np.int64)
    return whole if np.array_equal(whole, times) else times


def _of_states(states: list[str], mean: np.ndarray, sd: np.ndarray, quantiles: np.ndarray) -> dict[str, np.ndarray]:
    """The columns of states, or of measurements, from `(rows, N)`, `(rows, N)` and `(rows, N, 3)`."""
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
