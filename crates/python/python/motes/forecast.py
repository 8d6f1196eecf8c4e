"""What is predicted after the last measurement of each series."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _motes, _xarray
from ._ahead import followed, level_of_times
from ._display import Display, shapes
from ._estimates import whole
from ._frames import pandas_frame, polars_frame
from ._plots import Band, draw, shown
from ._quantiles import between, percent
from ._table import text_of_label
from ._times import Times, times_of
from .results import Filtered


class Forecast:
    """What is predicted after the last measurement of each series: states and measurements.

    Where rows of the data have dates or years with equal steps, as an index of pandas or in the column that is carried along, its
    rows have those that follow.
    """

    def __init__(self, filtered: Filtered, steps: int | None = None):
        n, (mean, sd, quantiles) = len(filtered.states), filtered._found.forecasts()
        counts = sorted(set(filtered._found.forecast_counts()))
        has_inputs = steps is None
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
        self.mean: NDArray[np.float64] = mean.reshape(series, steps, n)
        #: Standard deviations, `(S, steps, N)`.
        self.sd: NDArray[np.float64] = sd.reshape(series, steps, n)
        #: The probabilities of quantiles.
        self.probabilities = filtered.probabilities
        #: Quantiles, `(S, steps, N, Q)`.
        self.quantiles: NDArray[np.float64] = quantiles.reshape(series, steps, n, len(self.probabilities))
        #: The names of the `M` coordinates of a measurement.
        self.measurements = filtered._measured
        m, (mean, sd, quantiles, _) = len(self.measurements), filtered._found.forecast_measurements()
        #: Means of the measurements, `(S, steps, M)`.
        self.measurement_mean: NDArray[np.float64] = mean.reshape(series, steps, m)
        #: Their standard deviations, `(S, steps, M)`.
        self.measurement_sd: NDArray[np.float64] = sd.reshape(series, steps, m)
        #: Their quantiles, `(S, steps, M, Q)`.
        self.measurement_quantiles: NDArray[np.float64] = quantiles.reshape(series, steps, m, len(self.probabilities))
        #: The times, which go on from the last measurement, `(S, steps)`.
        self.time = whole(filtered._found.forecast_times()).reshape(series, steps)
        written = filtered._found.forecast_labels()
        self._index: Any = None
        #: What stands in the column that is carried along.
        self._ahead: list[Any] | None = None
        if has_inputs and written and filtered._carried is not None:
            self._ahead = list(written)
        else:
            self._index, self._ahead = followed(filtered, steps, written)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_times"}

    @property
    def seed(self) -> int:
        """What all random numbers came from."""
        return self.filtered.seed

    @cached_property
    def _times(self) -> tuple[Times, Times]:
        """Where rows of the data and those that are predicted stand along one axis, `(rows,)` and `(S·steps,)`."""
        series, steps, _ = self.mean.shape
        carried = None
        if self._ahead is not None and self.filtered._carried is not None:
            carried = self.filtered._carried[0], self._ahead
        t, numbers = self.time.reshape(-1), np.repeat(np.arange(series), steps)
        known, ahead = self.filtered._times, times_of(self._index, carried, t, numbers)
        if (known.name, known.are_dates) != (ahead.name, ahead.are_dates):
            known, ahead = Times(self.filtered.time, "t"), Times(t, "t")
        return known, ahead

    def _columns(self, labels: list[Any] | None) -> dict[str, Any]:
        """The columns of its table, with `labels` in the column that is carried along."""
        steps, n, m, q = self.mean.shape[1], len(self.states), len(self.measurements), len(self.probabilities)
        columns: dict[str, Any] = {}
        if self.filtered.series_names is not None and self.filtered._data.series_column is not None:
            columns[self.filtered._data.series_column] = [label for label in self.filtered._series_labels() for _ in range(steps)]
        if labels is not None and self.filtered._carried is not None:
            columns[self.filtered._carried[0]] = labels
        columns["t"] = self.time.reshape(-1)
        expected = (
            self.measurement_mean.reshape(-1, m),
            self.measurement_sd.reshape(-1, m),
            self.measurement_quantiles.reshape(-1, m, q),
        )
        known = self.mean.reshape(-1, n), self.sd.reshape(-1, n), self.quantiles.reshape(-1, n, q)
        figures = self.filtered._figures
        return columns | figures(self.states, *known) | figures(self.measurements, *expected)

    def to_pandas(self) -> Any:
        """A data frame of pandas with a row for each time of each series, and the dates or years that follow those of the data."""
        levels = self.filtered._levels if self._index is not None else []
        return pandas_frame(self._columns(self._ahead), self._index, levels)

    def to_polars(self) -> Any:
        """A data frame of polars with a row for each time of each series, and the dates or years that follow those of the data."""
        texts = self._ahead and [text_of_label(label) for label in self._ahead]
        return polars_frame(lambda: self._columns(self._ahead), lambda: self._columns(texts))

    def to_xarray(self) -> Any:
        """A dataset of xarray: `mean`, `sd` and `quantiles` of states, and the same of measurements as `measurement_mean` and so on.

        Dimensions are `series`, `time`, `state` or `measurement`, and `quantile`. `time` has the dates or years that follow those
        of the data, or `t`, where they are the same of all series; else it counts steps from 0, and they are coordinates of
        series and time. Attributes are those of `Filtered.to_xarray`.
        """
        return _xarray.of_forecast(self, self._times[1])

    def to_csv(self) -> str:
        """Its table as text, with the dates or years that follow those of the data in the place of the column that is carried along."""
        labels = None
        if self._ahead is not None and self.filtered._carried is not None:
            labels = (self.filtered._carried[0], [text_of_label(label) for label in self._ahead])
        elif self._index is not None:
            # Levels beside the times are the series, which has a column of its own.
            level = level_of_times(self._index)
            times = self._index.get_level_values(level)
            labels = (str(times.name or "date"), [text_of_label(label) for label in times])
        return self.filtered._found.forecast_csv(labels)

    def to_html(self, path: Any = None) -> str:
        """The report of the filter with what is predicted, one HTML page that needs nothing else; written to `path` if there is one."""
        page = self.filtered._found.html("Forecast.to_html()")
        if path is not None:
            _motes.write(path, page)
        return page

    def plot(
        self, states: list[str] | None = None, *, measurements: list[str] | None = None, series: int | str = 0, axes: Any = None
    ) -> NDArray[np.object_]:
        """Draws one series as `Filtered.plot` does, and after it the means and bands that are predicted; gives the axes.

        Without names there are all states and all measurements.
        """
        number = self.filtered._number_of(series)
        measured = shown("measurements", measurements, self.measurements, states is None)
        drawn = shown("states", states, self.states, measurements is None)
        known, ahead = self._times
        panels = self.filtered._panels(drawn, measured, number, known)
        steps = self.mean.shape[1]
        across = ahead.places[number * steps : (number + 1) * steps]
        of_states = [(self.mean[number, :, at], self.quantiles[number, :, at]) for at in drawn]
        of_measurements = [(self.measurement_mean[number, :, at], self.measurement_quantiles[number, :, at]) for at in measured]
        band = between(self.probabilities)
        for panel, (mean, quantiles) in zip(panels, [*of_states, *of_measurements], strict=True):
            panel.bands.append(Band(across, mean, quantiles, (f"forecast, {band}", "forecast"), "C1", begins=False))
        return draw(panels, axes)

    def _display(self) -> Display:
        series, steps, _ = self.mean.shape
        display = Display(
            f"Forecast of {steps} times for {series} series",
            [shapes(mean=self.mean, measurement_mean=self.measurement_mean)],
            ["mean", "sd", percent(self.probabilities[0]), percent(self.probabilities[-1])],
        )
        if steps == 0:
            return display
        places = self._times[1].places.reshape(series, steps)
        last = np.datetime_as_string(places[0, -1], "auto") if self._times[1].are_dates else places[0, -1]
        of_first = f" of series {self.filtered._series_labels()[0]}" if self.filtered.series_names else ""
        display.lines = [*display.lines, f"the last time{of_first}, {self._times[1].name or 'date'} = {last}:"]
        for names, mean, sd, quantiles in (
            (self.states, self.mean, self.sd, self.quantiles),
            (self.measurements, self.measurement_mean, self.measurement_sd, self.measurement_quantiles),
        ):
            display.add(names, mean[0, -1], sd[0, -1], quantiles[0, -1, :, 0], quantiles[0, -1, :, -1])
        return display

    def __repr__(self) -> str:
        return self._display().text()

    def _repr_html_(self) -> str:
        return self._display().html()


def steps_or_inputs(steps: int | None, inputs: Any) -> None:
    """Refuses both of them, and neither."""
    if (steps is None) == (inputs is None):
        raise ValueError("steps: either how many times are predicted, or inputs with their times; one of the two is needed")
