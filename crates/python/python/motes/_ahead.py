"""The index and the labels of rows that are predicted: dates and years that go on from those of the data."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._dates import are_dates, following, like
from ._errors import warn
from ._years import are_years, following_years, is_named_year

if TYPE_CHECKING:
    from ._estimates import Estimates


def followed(found: Estimates, steps: int, written: list[str] | None) -> tuple[Any, list[Any] | None]:
    """What follows the rows of each series, one series after the other: a part of an index, and of the carried column, which has the
    times that are `written` where the model has a clock.

    None where rows have neither dates nor years. Where dates do not go on with equal steps, nobody knows which ones follow: it
    warns.
    """
    rows = [np.flatnonzero(found.series == number) for number in range(len(found.log_evidence_per_series))]
    index, carried = None, None
    level = None if found._index is None else level_of_times(found._index)
    if level is not None:
        times = found._index.get_level_values(level)
        parts = _parts(times, rows, times.name, "the index", steps)
        index = None if parts is None else _index_of(found._index, level, rows, parts, steps)
    if found._carried is not None:
        name, labels = found._carried
        known = None if written is None else [like(text, labels[-1]) for text in written]
        if known is not None and None not in known:
            return index, known
        # Of a level of the index it was said.
        called = None if level is not None and name in found._levels else f"column {name}"
        parts = _parts(labels, rows, name, called, steps)
        carried = None if parts is None else [one for part in parts for one in part]
    return index, carried


def level_of_times(index: Any) -> int | None:
    """The one level of an index of pandas that has dates, or else years; None if there is none."""
    levels = {number: index.get_level_values(number) for number in range(index.nlevels)}
    of_dates = [number for number, level in levels.items() if are_dates(level)]
    of_years = [number for number, level in levels.items() if are_years(level, level.name)]
    of_times = of_dates or of_years
    return of_times[0] if len(of_times) == 1 else None


def _parts(labels: Any, rows: list[NDArray[np.intp]], name: Any, called: str | None, steps: int) -> list[Any] | None:
    """What follows the labels of each series; None if they are no times, or it is not known of one, which is warned of by what they
    are called."""
    is_index = hasattr(labels, "get_level_values")
    of_series = [labels] if len(rows) == 1 else [labels[at] if is_index else [labels[one] for one in at] for at in rows]
    if are_dates(labels):
        what, parts = "dates", [following(one, steps) for one in of_series]
    elif are_years(labels, name):
        what, parts = "years", [following_years(one, steps) for one in of_series]
    else:
        return None
    if all(part is not None for part in parts):
        return parts
    # Whole numbers of four digits that do not go on like years are none.
    if steps > 0 and called is not None and (what == "dates" or is_named_year(name)):
        warn(f"data, {called}: its {what} do not go on with equal steps, so that the rows of the forecast have none")
    return None


def _index_of(index: Any, level: int, rows: list[NDArray[np.intp]], parts: list[Any], steps: int) -> Any:
    """An index like that of the data, with these times of each series; other levels say what they said in its last row."""
    times = index.get_level_values(level)
    if hasattr(parts[0], "get_level_values"):
        whole = parts[0] if len(parts) == 1 else parts[0].append(parts[1:])
    else:
        import pandas

        whole = pandas.Index([one for part in parts for one in part], name=times.name)
    if index.nlevels == 1:
        return whole
    last = [index[places[-1]] for places in rows]
    levels = [
        whole if number == level else [row[number] for row in last for _ in range(steps)] for number in range(index.nlevels)
    ]
    return type(index).from_arrays(levels, names=index.names)
