"""Data that have a column for each series, and what makes them long."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _motes
from ._dates import are_dates


def of_frame(model: _motes.Model, frame: Any) -> str:
    """What makes a frame long whose columns are series of the one thing that the model measures; empty if it is no such frame."""
    if len(model.measurements) != 1:
        return ""
    keys, (measured,) = list(frame.columns), model.measurements
    others = {measured, model.series_column, model.time_column, *model.input_columns}
    of_series = [key for at, key in enumerate(keys) if str(key) not in others and _are_values(frame[key], at == 0)]
    if measured in map(str, keys) or len(of_series) < 2:
        return ""
    kept = [key for key in keys if key not in of_series]
    by = _quoted(kept[0]) if len(kept) == 1 else f"[{', '.join(map(_quoted, kept))}]"
    series, value = _quoted(model.series_column), _quoted(measured)
    if hasattr(frame, "unpivot"):
        kept_by = f"index={by}, " if kept else ""
        call = f"df.unpivot({kept_by}variable_name={series}, value_name={value})"
    else:
        # What counts rows alone need not be kept.
        has_index = type(frame.index).__name__ != "RangeIndex"
        kept_by = f"{by}, " if kept else "ignore_index=False, " if has_index else ""
        call = f"df.melt({kept_by}var_name={series}, value_name={value})"
    return f"; where each column is a series, {call} makes rows of them"


def refuse_levels(model: _motes.Model, columns: Any) -> None:
    """Refuses columns of several levels, and says what makes one of them."""
    levels = getattr(columns, "nlevels", 1)
    if levels == 1:
        return
    measured = set(model.measurements)
    of_measurements = [at for at in range(levels) if measured <= {str(name) for name in columns.get_level_values(at)}]
    if levels == 2 and len(of_measurements) == 1:
        other = 1 - of_measurements[0]
        name = columns.names[other]
        level, series = other if name is None else _quoted(name), _quoted(model.series_column)
        stacked = f"df.stack({level}).rename_axis([*df.index.names, {series}])"
        how = f"{stacked} makes series of the other level"
    else:
        how = 'df.columns = ["_".join(map(str, names)) for names in df.columns] makes one name of each'
    raise ValueError(f"data: its columns have {levels} levels; {how}")


def of_array(values: NDArray[np.float64], width: int) -> str:
    """How an array is given whose columns are series of the one thing that the model measures; empty if it is no such array."""
    if width != 1 or values.ndim != 2 or values.shape[1] == 0:
        return ""
    return "; y.T is one series" if values.shape[0] == 1 else "; where each column is a series, give list(y.T)"


def _quoted(name: Any) -> str:
    """A name as Python code."""
    return json.dumps(name, ensure_ascii=False) if isinstance(name, str) else repr(name)


def _are_values(column: Any, is_first: bool) -> bool:
    """Whether a column has what was measured: numbers, and not dates, or whole numbers before all others that count rows."""
    values = column.to_numpy()
    if values.dtype.kind not in "fiu" or are_dates(column):
        return False
    counts = is_first and values.dtype.kind in "iu" and len(values) > 1 and (np.diff(values) > 0).all()
    return not counts
