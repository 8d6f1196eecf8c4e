"""Data frames of results."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ._optional import module


def pandas_frame(columns: dict[str, Any], index: Any, levels: list[str]) -> Any:
    """A data frame of pandas; columns that are levels of its index stand there alone."""
    for level in levels:
        columns.pop(level, None)
    return module("pandas", "to_pandas").DataFrame(columns, index=index)


def polars_frame(columns: Callable[[], dict[str, Any]], as_text: Callable[[], dict[str, Any]]) -> Any:
    """A data frame of polars; with the columns `as_text` where labels are of a kind that only pandas has."""
    polars = module("polars", "to_polars")
    try:
        return polars.DataFrame(columns())
    except TypeError:
        return polars.DataFrame(as_text())
