"""Data of any form as rows of measurements."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from decimal import Decimal
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _motes, _wide
from ._errors import warn


@dataclass
class Rows:
    """Rows of measurements, and what else their owner gave with them."""

    found: _motes.Data
    #: The index of the rows, of a frame of pandas.
    index: Any = None
    #: What columns that results repeat said before they became text, by their names.
    labels: dict[str, list[Any]] = field(default_factory=dict)
    #: The names of those columns that are levels of the index.
    levels: list[str] = field(default_factory=list)


def data_of(model: _motes.Model, data: Any) -> Rows:
    """The rows of `data`."""
    if isinstance(data, (str, os.PathLike)):
        rows = Rows(model.open(os.fspath(data)))
    elif _is_frame(data):
        rows = _of_frame(model, data)
    elif _is_series_of_pandas(data) and len(model.measurements) == 1:
        rows = _of_columns(model, [(model.measurements[0], lambda: data)], data.index)
    elif isinstance(data, (list, tuple)) and len(data) > 0 and all(_is_sequence(one) for one in data):
        rows = Rows(_of_sequences(model, list(data)))
    else:
        rows = Rows(_of_array(model, data))
    if rows.found.ignored:
        warn(f"data: columns that are not used: {', '.join(rows.found.ignored)}")
    return rows


def _is_frame(data: Any) -> bool:
    """Whether it has columns by name: a frame of pandas or polars, or a dict of columns."""
    if type(data).__name__ == "LazyFrame":
        raise ValueError("data: a LazyFrame has no rows yet; call .collect() first")
    return isinstance(data, dict) or (hasattr(data, "columns") and hasattr(data, "__getitem__"))


def _is_sequence(data: Any) -> bool:
    """Whether it is a sequence among others, and no number or row: an array or a frame of its own."""
    # Series of polars have no `ndim`.
    return _is_frame(data) or hasattr(data, "to_numpy") or getattr(data, "ndim", 0) >= 1


def _is_series_of_pandas(data: Any) -> bool:
    return hasattr(data, "to_numpy") and hasattr(getattr(data, "index", None), "get_level_values")


def _levels(index: Any) -> tuple[dict[str, Any], Any]:
    """The levels of an index of pandas that have names, dates first, and the dates of a level without one."""
    if not hasattr(index, "get_level_values"):
        return {}, None
    levels = [(name, index.get_level_values(number)) for number, name in enumerate(index.names)]
    named = [(str(name), values) for name, values in levels if name is not None]
    dates = [values for name, values in levels if name is None and _is_dated(values)]
    return dict(sorted(named, key=lambda level: not _is_dated(level[1]))), (dates[0] if dates else None)


def _is_dated(values: Any) -> bool:
    """Whether labels of an index are dates."""
    kind = getattr(getattr(values, "dtype", None), "kind", None)
    return kind == "M" or type(values).__name__ == "PeriodIndex" or (len(values) > 0 and hasattr(values[0], "isoformat"))


def _of_frame(model: _motes.Model, frame: Any) -> Rows:
    if isinstance(frame, dict):
        return _of_columns(model, _taken(frame, frame), None)
    _wide.refuse_levels(model, frame.columns)
    return _of_columns(model, _taken(frame, frame.columns), getattr(frame, "index", None), partial(_wide.of_frame, model, frame))


#: A column by its name, taken out where it is used.
_Column = tuple[str, Callable[[], Any]]


def _taken(frame: Any, keys: Any) -> list[_Column]:
    """Its columns by name."""
    return [(str(key), partial(frame.__getitem__, key)) for key in keys]


def _known(values: Any) -> Any:
    """Values that are there already."""
    return values


def _of_columns(model: _motes.Model, columns: list[_Column], index: Any, remedy: Callable[[], str] = str) -> Rows:
    """The rows of columns. Levels of an index of pandas that have names are columns, too, before the others.

    Where those that the model needs are not there, the error ends with a remedy.
    """
    named, dates = _levels(index)
    known = {name for name, _ in columns}
    levels = {name: values for name, values in named.items() if name not in known}
    taken: list[_Column] = [*((name, partial(_known, values)) for name, values in levels.items()), *columns]
    names = [name for name, _ in taken]
    try:
        measured, (series, time, clock, carried), inputs, _ = model.columns(names)
    except ValueError as error:
        raise ValueError(f"{error}{remedy()}") from None
    needed = [*measured, series, time, clock, carried, *inputs]
    used = {at: _column(taken[at][1](), names[at]) for at in needed if at is not None}
    values_of = [numbers_of(used[at], names[at]) for at in measured]
    known_inputs = [numbers_of(used[at], names[at]) for at in inputs]
    lengths = {len(column) for column in [*values_of, *known_inputs]}
    if len(lengths) > 1:
        raise ValueError(f"data: columns have different lengths: {', '.join(map(str, sorted(lengths)))}")
    values = np.stack(values_of, axis=1) if values_of else np.empty((0, 0))
    times = None if time is None else numbers_of(used[time], names[time]).tolist()
    labels = {names[at]: list(used[at]) for at in (series, clock, carried) if at is not None}
    for row, value in enumerate(labels.get(model.series_column, [])):
        if _is_missing(value):
            raise ValueError(f"data, row {row}, column {model.series_column}: it is missing; each row must say which series it belongs to")
    texts = [None if at is None else [text_of_label(value) for value in labels[names[at]]] for at in (series, carried, clock)]
    index_texts = None if dates is None else [text_of_label(value) for value in dates]
    found = model.data(names, values.reshape(-1), texts[0], times, texts[1], index_texts, texts[2], _flat(known_inputs))
    return Rows(found, index, labels, list(levels))


def inputs_of(model: _motes.Model, data: Any) -> _motes.Data:
    """Times and inputs of rows: of a file, or of columns by name."""
    if isinstance(data, (str, os.PathLike)):
        return _motes.open_inputs(model, os.fspath(data))
    if not _is_frame(data):
        raise ValueError(f"inputs: {type(data).__name__}; they are a file, a data frame, or a dict of columns")
    taken = _taken(data, data if isinstance(data, dict) else data.columns)
    names = [name for name, _ in taken]
    series, time, clock, inputs = _motes.columns_of_inputs(model, names)
    used = {at: _column(taken[at][1](), names[at]) for at in [series, time, clock, *inputs] if at is not None}
    lengths = {len(column) for column in used.values()}
    if len(lengths) != 1:
        raise ValueError(f"inputs: columns have different lengths: {', '.join(map(str, sorted(lengths)))}")
    of_series, of_clock = (None if at is None else [text_of_label(value) for value in used[at]] for at in (series, clock))
    times = None if time is None else numbers_of(used[time], names[time]).tolist()
    # A measurement that is an input of later steps need not be there.
    (count,) = lengths
    values = _flat([np.full(count, np.nan) if at is None else numbers_of(used[at], names[at]) for at in inputs])
    return _motes.inputs_of_table(model, names, count, of_series, times, of_clock, values)


def _flat(columns: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Columns of numbers, row by row."""
    return np.stack(columns, axis=1).reshape(-1) if columns else np.empty(0)


def _column(values: Any, name: str) -> Any:
    """A column of a frame; what can be gone through only once becomes a list."""
    if isinstance(values, (str, bytes)) or not hasattr(values, "__iter__") or getattr(values, "ndim", 1) == 0:
        raise ValueError(f"data, column {name}: {values!r} is no column; it must be an array or a list")
    return values if hasattr(values, "__len__") and hasattr(values, "__getitem__") else list(values)


def _of_array(model: _motes.Model, data: Any) -> _motes.Data:
    names, width = model.measurements, len(model.measurements)
    values = numbers_of(data, names[0] if width == 1 else None)
    if values.ndim == 1 and width == 1:
        values = values[:, None]
    if values.ndim == 3 and values.shape[2] == width:
        return _of_sequences(model, list(values))
    if values.ndim != 2 or values.shape[1] != width:
        expected = f"(T, {width})" + (" or (T,)" if width == 1 else "") + f" or (S, T, {width})"
        raise ValueError(
            f"data: an array of shape {values.shape}; it must be {expected}, a column for each of {', '.join(names)}"
            f"{_wide.of_array(values, width)}"
        )
    return model.data(names, np.ascontiguousarray(values).reshape(-1), None, None, None)


def _of_sequences(model: _motes.Model, sequences: list[Any]) -> _motes.Data:
    names, width = model.measurements, len(model.measurements)
    if not sequences:
        raise ValueError("data: there are no sequences")
    values, series = [], []
    for number, sequence in enumerate(sequences):
        try:
            one = _one_sequence(model, sequence, names, width)
        except ValueError as error:
            raise ValueError(f"data, sequence {number}{str(error).removeprefix('data')}") from None
        if len(one) == 0:
            raise ValueError(f"data, sequence {number}: there are no rows")
        values.append(one)
        series.extend([str(number)] * len(one))
    return model.data([model.series_column, *names], np.concatenate(values).reshape(-1), series, None, None)


def _one_sequence(model: _motes.Model, sequence: Any, names: list[str], width: int) -> NDArray[np.float64]:
    if _is_frame(sequence):
        return _of_frame(model, sequence).found.measurements.reshape(-1, width)
    one = numbers_of(sequence, names[0] if width == 1 else None)
    if one.ndim == 1 and width == 1:
        one = one[:, None]
    if one.ndim != 2 or one.shape[1] != width:
        raise ValueError(f"data: an array of shape {one.shape}; it must be (T, {width})")
    return one


def numbers_of(values: Any, column: str | None) -> NDArray[np.float64]:
    """An array of 64-bit numbers, NaN where one is missing; errors name row and column."""
    if hasattr(values, "to_numpy"):
        values = values.to_numpy()
    if isinstance(values, np.ma.MaskedArray):
        values = np.ma.filled(values.astype(np.float64 if values.dtype.kind in "fiub" else object), np.nan)
    try:
        array = np.asarray(values)
    except ValueError:
        raise ValueError("data: rows of different lengths; give sequences of unequal length as a list of arrays") from None
    if array.dtype.kind in "fiub":
        return array.astype(np.float64)
    if array.dtype.kind != "O":
        if array.size == 0:
            return array.astype(np.float64)
        at = tuple(0 for _ in array.shape)
        raise ValueError(f"{_place(at, column)}: {array[at]!r} is no number; a measurement that is missing is NaN or None")
    found = np.empty(array.shape)
    for at in np.ndindex(array.shape):
        found[at] = _number(array[at], at, column)
    return found


def _number(value: Any, at: tuple[int, ...], column: str | None) -> float:
    if _is_missing(value):
        return np.nan
    if isinstance(value, (str, bytes)) or not hasattr(value, "__float__"):
        raise ValueError(f"{_place(at, column)}: {value!r} is no number; a measurement that is missing is NaN or None")
    try:
        return float(value)
    except (OverflowError, TypeError, ValueError) as error:
        raise ValueError(f"{_place(at, column)}: {value!r}: {error}") from None


#: What may say that it is no number or no time by being unequal to itself.
_UNEQUAL = (float, np.floating, np.datetime64, np.timedelta64, Decimal)


def _is_missing(value: Any) -> bool:
    """Whether it stands for nothing: None, NaN, what is masked, or what pandas has for them."""
    if value is None or value is np.ma.masked or type(value).__name__ in ("NAType", "NaTType"):
        return True
    return isinstance(value, _UNEQUAL) and bool(value != value)


def _place(at: tuple[int, ...], column: str | None) -> str:
    row = f"data, row {at[0]}" if at else "data"
    if column is not None:
        return f"{row}, column {column}"
    return row + (f", column {at[-1]}" if len(at) > 1 else "")


def text_of_label(value: Any) -> str:
    """A label as the command would read it: dates without a time that is midnight."""
    text = str(value)
    return text.removesuffix(" 00:00:00") if hasattr(value, "isoformat") else text
