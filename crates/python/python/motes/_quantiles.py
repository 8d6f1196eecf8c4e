"""Which quantiles are given of each number that is estimated."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

#: Their probabilities where nobody asks for others.
PROBABILITIES = (0.05, 0.5, 0.95)


def probabilities_of(quantiles: Any) -> list[float]:
    """The probabilities that are asked for, as numbers."""
    try:
        found: list[float] = np.asarray(quantiles, dtype=np.float64).reshape(-1).tolist()
    except (TypeError, ValueError):
        raise ValueError(f"quantiles: {quantiles!r}; they must be probabilities, as in {PROBABILITIES}") from None
    return found


def percent(probability: float) -> str:
    """A probability in percent: `2.5 %`."""
    return f"{100 * probability:.10g} %"


def between(probabilities: Sequence[float]) -> str:
    """From the lowest to the highest, which is what a band is: `5 to 95 %`."""
    low, high = probabilities[0], probabilities[-1]
    return percent(low) if low == high else f"{100 * low:.10g} to {percent(high)}"
