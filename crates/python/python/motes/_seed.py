"""Seeds."""

from __future__ import annotations

import operator
from typing import Any

import numpy as np


def seed_of(seed: Any) -> int:
    """The integer that all random numbers of a call come from.

    It is `seed` itself; or 63 bits drawn from a `numpy.random.Generator`, which moves on; or, if None, 63 bits of the system's
    entropy, others in each call, as NumPy has it.
    """
    if seed is None or isinstance(seed, np.random.Generator):
        return int(np.random.default_rng(seed).integers(2**63))
    try:
        return operator.index(seed)
    except TypeError:
        kind = type(seed).__name__
        raise TypeError(f"seed: {kind}; it must be an integer, a numpy.random.Generator, or None for another each time") from None
