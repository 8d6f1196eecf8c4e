"""Rows of series as a rectangle of series and times, with what the times are."""

from __future__ import annotations

from collections.abc import Container
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._times import Times


class Grid:
    """Rows as a rectangle `(S, T)`: series that are shorter than the longest are filled up after their last row."""

    def __init__(self, series: NDArray[np.int64], count: int):
        counts = np.bincount(series, minlength=count)
        order = np.argsort(series, kind="stable")
        self._series = series
        #: The place of each row in its series.
        self._at = np.empty(len(series), dtype=np.int64)
        self._at[order] = np.arange(len(series)) - np.repeat(np.cumsum(counts) - counts, counts)
        self._longest = series == counts.argmax()
        self.shape = count, int(counts.max(initial=0))

    def of(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values of rows, `(rows, …)`, as `(S, T, …)`; NaN after the end of a series, or no date."""
        is_full = len(values) == self.shape[0] * self.shape[1]
        # Integers have nothing for what is not there.
        filled = np.empty((*self.shape, *values.shape[1:]), values.dtype if is_full or values.dtype.kind == "M" else np.float64)
        if not is_full:
            filled[...] = np.datetime64("NaT") if values.dtype.kind == "M" else np.nan
        filled[self._series, self._at] = values
        return filled

    def coordinates(self, times: Times, t: NDArray[Any], taken: Container[str]) -> dict[str, Any]:
        """The coordinate `time`: what rows stand at where that is the same of all series as far as they go, else numbers of rows.

        Beside it are, by series and time, what rows stand at where it is not the same, under a name that is not `taken`; and `t`
        where `time` is something else.
        """
        shared = times.places[self._longest]
        is_shared = bool((times.places == shared[self._at]).all())
        found: dict[str, Any] = {"time": shared if is_shared else np.arange(self.shape[1])}
        if not is_shared and times.name != "t":
            name = "date" if not times.name or times.name in taken else times.name
            found[name] = (("series", "time"), self.of(times.places))
        if not is_shared or times.name != "t":
            found["t"] = (("series", "time"), self.of(t))
        return found
