"""Dates that follow others with equal steps."""

from __future__ import annotations

import datetime
import re
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

#: How dates are written as text.
_TEXT = re.compile(r"\d{4}-\d\d-\d\d([ T]\d\d:\d\d(:\d\d(\.\d+)?)?)?$")


def are_dates(labels: Any) -> bool:
    """Whether labels, an index of pandas or a list, are dates, times or periods."""
    if hasattr(labels, "dtype") and hasattr(labels, "get_level_values"):
        return labels.dtype.kind == "M" or str(labels.dtype).startswith(("datetime64", "period"))
    return len(labels) > 0 and all(_is_date(one) for one in labels)


def _is_date(label: Any) -> bool:
    if isinstance(label, str):
        return _TEXT.match(label) is not None and _parsed(label) is not None
    # Periods of pandas count by themselves.
    is_known = isinstance(label, (datetime.date, np.datetime64)) or type(label).__name__ == "Period"
    return is_known and bool(label == label)


def following(labels: Any, steps: int) -> Any:
    """The `steps` dates after `labels`, of the kind that these are, where their steps are equal; None where they are not.

    Steps are equal if they take the same time, or as many months from the same day on, or if pandas, where it is there,
    infers a frequency. An index of pandas gives an index.
    """
    try:
        return _after_index(labels, steps) if hasattr(labels, "get_level_values") else _after_list(list(labels), steps)
    except TypeError:
        # Dates beside times, or times of a zone beside others without one.
        return None


def like(text: str, last: Any) -> Any:
    """A time that the model has written, of the kind that `last` is; None of other kinds."""
    if isinstance(last, str):
        return text
    if isinstance(last, (int, float, np.integer, np.floating)):
        value = float(text)
        return int(value) if isinstance(last, (int, np.integer)) and value.is_integer() else value
    if isinstance(last, np.datetime64):
        return np.datetime64(text.rstrip("Z")).astype(last.dtype)
    if hasattr(last, "tz_localize"):
        stamp = type(last)(text)
        return stamp if last.tzinfo is None else stamp.tz_convert(last.tzinfo)
    if isinstance(last, datetime.datetime):
        time = datetime.datetime.fromisoformat(text.replace("Z", "+00:00"))
        return time if last.tzinfo is None else time.astimezone(last.tzinfo)
    return datetime.date.fromisoformat(text) if isinstance(last, datetime.date) and "T" not in text else None


def _after_list(labels: list[Any], steps: int) -> list[Any] | None:
    if isinstance(labels[0], str):
        times = [_parsed(label) for label in labels]
        found = None if None in times else _after_times(times, steps)
        return None if found is None else [_written(one, labels[-1]) for one in found]
    if type(labels[0]).__name__ == "Period":
        found = _after_index(__import__("pandas").PeriodIndex(labels), steps)
        return None if found is None else list(found)
    if hasattr(labels[0], "tz_localize"):
        found = _after_index(__import__("pandas").DatetimeIndex(labels), steps)
        return None if found is None else list(found)
    if isinstance(labels[0], np.datetime64):
        found = _after_times([one.astype("datetime64[us]").item() for one in labels], steps)
        return None if found is None else [np.datetime64(one).astype(labels[-1].dtype) for one in found]
    return _after_times(labels, steps)


def _after_index(index: Any, steps: int) -> Any:
    """The part of an index of dates or periods of pandas that would follow it."""
    import pandas

    if isinstance(index, pandas.PeriodIndex):
        places = np.diff(index.asi8)
        if len(places) < 2 or (places != places[0]).any() or places[0] <= 0:
            return None
        step = int(places[0])
        return pandas.PeriodIndex([index[-1] + step * ahead for ahead in range(1, steps + 1)], dtype=index.dtype, name=index.name)
    if index.hasnans or not index.is_monotonic_increasing or not index.is_unique:
        return None
    frequency = index.freq
    if frequency is None and len(index) >= 3:
        with warnings.catch_warnings():
            # Of what later versions return; both are understood.
            warnings.simplefilter("ignore")
            frequency = pandas.infer_freq(index)
    if frequency is None:
        return None
    found = pandas.date_range(index[-1], periods=steps + 1, freq=frequency)[1:]
    return found.rename(index.name)


def _after_times(times: list[Any], steps: int) -> list[Any] | None:
    """The same of dates and times of Python."""
    if len(times) < 3:
        return None
    apart = {b - a for a, b in zip(times, times[1:])}
    if len(apart) == 1 and min(apart) > datetime.timedelta(0):
        step = apart.pop()
        return _or_none(lambda: [times[-1] + ahead * step for ahead in range(1, steps + 1)])
    # Months from the same day and hour on, which all months have.
    months = [12 * one.year + one.month - 1 for one in times]
    apart = {b - a for a, b in zip(months, months[1:])}
    is_same = len({one.replace(year=2000, month=1) for one in times}) == 1 and times[0].day <= 28
    if is_same and len(apart) == 1 and min(apart) > 0:
        step = apart.pop()
        ahead = [months[-1] + step * number for number in range(1, steps + 1)]
        return _or_none(lambda: [times[-1].replace(year=month // 12, month=month % 12 + 1) for month in ahead])
    try:
        import pandas
    except ModuleNotFoundError:
        return None
    found = _or_none(lambda: _after_index(pandas.DatetimeIndex(times), steps))
    if found is None:
        return None
    has_hours = isinstance(times[0], datetime.datetime)
    return [one.to_pydatetime() if has_hours else one.date() for one in found]


def _or_none(found: Callable[[], list[Any]]) -> list[Any] | None:
    """None where the calendar ends before the dates do."""
    try:
        return found()
    except (OverflowError, ValueError):
        return None


def _parsed(text: str) -> datetime.date | None:
    """The date or time that a text writes; None where there is no such day."""
    try:
        return datetime.date.fromisoformat(text) if len(text) == 10 else datetime.datetime.fromisoformat(text)
    except ValueError:
        return None


def _written(time: datetime.date, like: str) -> str:
    """A date or time as text, as another is written."""
    if not isinstance(time, datetime.datetime):
        return time.isoformat()
    return time.isoformat(like[10], "minutes" if len(like) == 16 else "auto")
