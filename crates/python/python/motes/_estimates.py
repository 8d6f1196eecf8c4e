"""What filters and smoothers have in common: estimates of the states, row by row."""

from __future__ import annotations

import json
from functools import cached_property
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from . import _motes
from ._display import Display
from ._errors import warn
from ._frames import pandas_frame, polars_frame
from ._kinds import collected
from ._plots import Band, Panel, draw, shown
from ._quantiles import between
from ._table import Rows
from ._times import Times, times_of

#: The result of a filter or of a smoother.
Found = TypeVar("Found", bound="Estimates")


class Estimates:
    """Estimates of the states, row by row in the order of the data."""

    def __init__(self, found: _motes.Filtered, rows: Rows, states: list[str], measured: list[str], seed: int):
        self._found, self._data, self._index, self._labels = found, rows.found, rows.index, rows.labels
        self._levels = rows.levels
        #: The names of the `N` coordinates of a state.
        self.states = states
        self._measured = measured
        #: What all random numbers came from.
        self.seed = seed

    def __getstate__(self) -> dict[str, Any]:
        # What was computed of the rest is computed again.
        of_rest = [name for name in self.__dict__ if isinstance(getattr(type(self), name, None), cached_property)]
        return {name: value for name, value in self.__dict__.items() if name not in of_rest}

    @cached_property
    def _arrays(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        n, (mean, sd, quantiles) = len(self.states), self._found.states()
        return mean.reshape(-1, n), sd.reshape(-1, n), quantiles.reshape(-1, n, len(self.probabilities))

    @property
    def mean(self) -> NDArray[np.float64]:
        """Means of the states, `(rows, N)`."""
        return self._arrays[0]

    @property
    def sd(self) -> NDArray[np.float64]:
        """Standard deviations of the states, `(rows, N)`."""
        return self._arrays[1]

    @property
    def quantiles(self) -> NDArray[np.float64]:
        """Quantiles of the states at the `Q` `probabilities`, `(rows, N, Q)`."""
        return self._arrays[2]

    @cached_property
    def probabilities(self) -> list[float]:
        """The probabilities of quantiles: those that were asked for, or 0.05, 0.5 and 0.95."""
        return [probability for _, probability in self._found.quantiles]

    @cached_property
    def time(self) -> NDArray[np.int64] | NDArray[np.float64]:
        """The time of each row in its series, `(rows,)`."""
        return whole(self._data.time)

    @cached_property
    def series(self) -> NDArray[np.int64]:
        """The number of the series of each row, `(rows,)`."""
        return self._data.series

    @property
    def series_names(self) -> list[str] | None:
        """The names of the series; none where there is one without a name."""
        return self._data.series_names

    @cached_property
    def measurements(self) -> NDArray[np.float64]:
        """What was measured, `(rows, M)`; NaN where it is missing."""
        return self._data.measurements.reshape(-1, len(self._measured))

    @property
    def log_evidence(self) -> float:
        """The estimate of `log p(y)` of all series."""
        return self._found.log_evidence

    @cached_property
    def log_evidence_per_series(self) -> NDArray[np.float64]:
        """That of each series, `(S,)`."""
        return self._found.log_evidence_per_series()

    @property
    def standard_error(self) -> float | None:
        """The standard error of `log_evidence`; 0 where it is exact, none without `check` or with fewer than 16 particles."""
        return self._found.standard_error

    @cached_property
    def standard_error_per_series(self) -> NDArray[np.float64]:
        """That of each series, `(S,)`; NaN where there is none."""
        return self._found.standard_error_per_series()

    @property
    def pareto_k(self) -> float | None:
        """The largest Pareto k of a step's weights, less its sampling error; above 0.7 they cannot be trusted."""
        return self._found.pareto_k

    @property
    def warnings(self) -> list[str]:
        """Reasons not to trust the estimates, of each series by itself."""
        return self._found.warnings

    @cached_property
    def collected_warnings(self) -> list[str]:
        """The same as it is warned of: one line for each kind, which says how many series it is about."""
        return collected(self.warnings, self.series_names)

    @property
    def particle_count(self) -> int:
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
        return cast("dict[str, Any]", json.loads(self._found.json()))

    @property
    def _carried(self) -> tuple[str, list[Any]] | None:
        """The name of the column that is carried along, and what it said before it became text."""
        if self._data.carried is None:
            return None
        name, texts = self._data.carried
        return name, self._labels.get(name, texts)

    @cached_property
    def _times(self) -> Times:
        return times_of(self._index, self._carried, self.time, self.series)

    def _series_labels(self) -> list[Any]:
        """What each series is called where it comes from; nothing where there is one without a name."""
        labels = self._labels.get(self._data.series_column or "", None)
        if labels is None:
            return list(self.series_names or [])
        return [labels[at] for at in np.unique(self.series, return_index=True)[1].tolist()]

    def _columns(self, labels: dict[str, list[Any]]) -> dict[str, Any]:
        """The columns of the command's table, but for forecasts; with `labels` for what was text there."""
        columns: dict[str, Any] = {}
        if self.series_names is not None and self._data.series_column is not None:
            names, name = self.series_names, self._data.series_column
            columns[name] = labels.get(name, [names[number] for number in self.series])
        if self._data.carried is not None:
            name, texts = self._data.carried
            columns[name] = labels.get(name, texts)
        columns["t"] = self.time
        return {**columns, **self._figures(self.states, self.mean, self.sd, self.quantiles)}

    def _figures(
        self, names: list[str], mean: NDArray[np.float64], sd: NDArray[np.float64], quantiles: NDArray[np.float64]
    ) -> dict[str, NDArray[np.float64]]:
        """The columns of states, or of measurements, from `(rows, N)`, `(rows, N)` and `(rows, N, Q)`."""
        columns = {}
        for at, name in enumerate(names):
            columns[f"{name}_mean"], columns[f"{name}_sd"] = mean[:, at], sd[:, at]
            for quantile, (called, _) in enumerate(self._found.quantiles):
                columns[f"{name}_{called}"] = quantiles[:, at, quantile]
        return columns

    def to_pandas(self) -> Any:
        """A data frame of pandas with a row for each row of the data, and its index where it had one."""
        return pandas_frame(self._columns(self._labels), self._index, self._levels)

    def to_polars(self) -> Any:
        """A data frame of polars with a row for each row of the data."""
        return polars_frame(lambda: self._columns(self._labels), lambda: self._columns({}))

    def to_html(self, path: Any = None) -> str:
        """The report, one HTML page that needs nothing else; written to `path` if there is one."""
        page = self._found.html(f"{type(self).__name__}.to_html()")
        if path is not None:
            _motes.write(path, page)
        return page

    def plot(
        self, states: list[str] | None = None, *, measurements: list[str] | None = None, series: int | str = 0, axes: Any = None
    ) -> NDArray[np.object_]:
        """Draws one series, which is named or counted from 0, by matplotlib; gives the axes, one below the other.

        Each state has a panel with its mean and a band from the lowest to the highest quantile, over dates or years where the data have them. Each
        measurement has one with the data as points and, where a filter was asked to be `predictive`, the band in which it was
        expected. Without names there are all states, and all measurements where they were predicted.
        """
        are_predicted = states is None and self._predicted() is not None
        measured = shown("measurements", measurements, self._measured, are_predicted)
        drawn = shown("states", states, self.states, measurements is None or states is not None)
        return draw(self._panels(drawn, measured, self._number_of(series), self._times), axes)

    def _number_of(self, series: int | str) -> int:
        """The number of a series that is named or counted."""
        count, names = len(self.log_evidence_per_series), self.series_names or []
        if isinstance(series, str) and series in names:
            return names.index(series)
        if isinstance(series, str) or not 0 <= series < count:
            raise ValueError(f"series: {series}; there are {count}" + (f", {names[0]} the first" if names else ""))
        return series

    def _predicted(self) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
        """Means, and quantiles, in which measurements were expected; None where they were not."""
        return None

    def _panels(self, states: list[int], measurements: list[int], number: int, times: Times) -> list[Panel]:
        """The panels of these coordinates of one series, over times of all rows."""
        rows = np.flatnonzero(self.series == number)
        across = Times(times.places[rows], times.name)
        panels, predicted, band = [], self._predicted(), between(self.probabilities)
        for at in states:
            called = (band, "mean")
            panels.append(
                Panel(self.states[at], across, [Band(across.places, self.mean[rows, at], self.quantiles[rows, at], called, "C0")])
            )
        for at in measurements:
            panel = Panel(self._measured[at], across, points=self.measurements[rows, at])
            if predicted is not None:
                called, (mean, quantiles) = (f"expected, {band}", "expected"), predicted
                panel.bands.append(Band(across.places, mean[rows, at], quantiles[rows, at], called, "C0"))
            panels.append(panel)
        return panels

    def _text(self) -> str:
        # Figures come first; of warnings there are as many as series, and more.
        figures = self._found.text().partition("\nwarning: ")[0].rstrip()
        return "\n".join([figures, *(f"warning: {warning}" for warning in self.collected_warnings)])

    def __repr__(self) -> str:
        return f"{type(self).__name__}\n{self._text()}"

    def _repr_html_(self) -> str:
        return Display(type(self).__name__, self._text().splitlines()).html()


def warned(found: Found) -> Found:
    """Warns of what there is to warn of in a result."""
    for text in found.collected_warnings:
        warn(text)
    return found


def whole(times: NDArray[np.float64]) -> NDArray[np.int64] | NDArray[np.float64]:
    """Times as integers, where all of them are."""
    integers = times.astype(np.int64)
    return integers if np.array_equal(integers, times) else times
