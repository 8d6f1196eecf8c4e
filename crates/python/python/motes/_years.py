"""Years that follow others with equal steps."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

#: Whole numbers that are years, whatever their column is called.
_EVIDENT = range(1000, 3000)


def is_named_year(name: Any) -> bool:
    """Whether a column or an index is called a year: `year`, `Year`, `water_year`."""
    return bool({"year", "years"} & set(re.split(r"[\W_]+", str(name).lower())))


def are_years(labels: Any, name: Any) -> bool:
    """Whether labels, an index of pandas or a list, are years: whole numbers that are called so, or have four digits."""
    is_named, numbers = is_named_year(name), map(_whole, labels)
    return len(labels) > 0 and all(number is not None and (is_named or number in _EVIDENT) for number in numbers)


def following_years(labels: Any, steps: int) -> list[Any] | None:
    """The `steps` years after `labels`, of the kind that these are, where their steps are equal; None where they are not."""
    numbers = [number for label in labels if (number := _whole(label)) is not None]
    apart = {b - a for a, b in zip(numbers, numbers[1:])}
    if len(numbers) < 3 or len(apart) != 1 or min(apart) <= 0:
        return None
    last, step, kind = numbers[-1], apart.pop(), type(labels[-1])
    return [kind(last + ahead * step) for ahead in range(1, steps + 1)]


def _whole(label: Any) -> int | None:
    """A whole number, or the text of one; None if it is anything else."""
    if isinstance(label, str):
        return int(label) if re.fullmatch(r"-?\d{1,9}", label) else None
    if isinstance(label, (bool, np.bool_)) or not isinstance(label, (int, float, np.integer, np.floating)):
        return None
    return int(label) if np.isfinite(label) and label == int(label) else None
