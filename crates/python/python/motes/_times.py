"""What rows stand at along an axis of time: their dates, numbers that increase, or `t`."""

from __future__ import annotations

import datetime
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._ahead import level_of_times
from ._dates import are_dates


@dataclass
class Times:
    """Places of rows along an axis of time."""

    #: Dates, or numbers, `(rows,)`.
    places: NDArray[Any]
    #: What they are called; empty for dates without a name.
    name: str

    @property
    def are_dates(self) -> bool:
        """Whether they are dates."""
        return self.places.dtype.kind == "M"


def times_of(index: Any, carried: tuple[str, list[Any]] | None, t: NDArray[Any], series: NDArray[np.int64]) -> Times:
    """Those of rows with this index of pandas, this column that is carried along, and times `t` in their series.

    Dates go before numbers, and the index before the column. Numbers must increase within each series.
    """
    labelled: list[tuple[str, Any]] = []
    if index is not None and (level := level_of_times(index)) is not None:
        labelled.append(("" if index.names[level] is None else str(index.names[level]), index.get_level_values(level)))
    elif index is not None and index.nlevels == 1 and not _is_default(index):
        labelled.append(("" if index.name is None else str(index.name), index))
    if carried is not None:
        labelled.append(carried)
    for name, labels in labelled:
        if are_dates(labels):
            return Times(_dates(labels), name)
    for name, labels in labelled:
        numbers = _numbers(labels)
        if numbers is not None and _increase(numbers, series):
            return Times(numbers, name)
    return Times(t, "t")


def _is_default(index: Any) -> bool:
    """Whether it only counts rows, as pandas does where nobody gave an index."""
    return type(index).__name__ == "RangeIndex" and index.name is None and index.start == 0 and index.step == 1


def _dates(labels: Any) -> NDArray[np.datetime64]:
    """Dates of any kind as NumPy has them, by the clock of their zone."""
    if hasattr(labels, "to_timestamp"):
        labels = labels.to_timestamp()
    if getattr(labels, "tz", None) is not None:
        labels = labels.tz_localize(None)
    if getattr(getattr(labels, "dtype", None), "kind", None) == "M":
        return np.asarray(labels)
    return np.array([_date(label) for label in labels], dtype="datetime64[us]")


def _date(label: Any) -> Any:
    if isinstance(label, str):
        return datetime.datetime.fromisoformat(label)
    if type(label).__name__ == "Period":
        label = label.start_time
    return label.replace(tzinfo=None) if isinstance(label, datetime.datetime) else label


def _numbers(labels: Any) -> NDArray[np.float64] | NDArray[np.int64] | None:
    """Labels as numbers; None where one is none."""
    if any(isinstance(label, (bool, np.bool_)) for label in labels):
        return None
    try:
        numbers = np.array([float(label) for label in labels])
    except (TypeError, ValueError):
        return None
    if not np.isfinite(numbers).all():
        return None
    whole = numbers.astype(np.int64)
    return whole if np.array_equal(whole, numbers) else numbers


def _increase(numbers: NDArray[Any], series: NDArray[np.int64]) -> bool:
    """Whether they increase from row to row of each series."""
    order = np.argsort(series, kind="stable")
    steps, is_same = np.diff(numbers[order]), np.diff(series[order]) == 0
    return bool((steps[is_same] > 0).all())
