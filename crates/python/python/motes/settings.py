"""The settings of a filter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypedDict

import numpy as np

from .proposal import Proposal


class FilterSettings(TypedDict, total=False):
    """Settings as a dict, for `model.filter(data, **settings)` and other calls; `Model.filter` says what they are."""

    proposal: str | Proposal
    particles: int
    defensive: float | None
    resample_below: float
    resampling: str
    seed: int | np.random.Generator | None
    check: bool
    predictive: bool
    quantiles: Sequence[float]
    threads: int | None
