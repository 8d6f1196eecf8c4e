"""What weighted particles say: covariances, and expectations of functions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray


def covariances(particles: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """The covariance of each row, `(rows, N, N)`; NaN where one particle has all weight, which says nothing of a spread."""
    mean = np.matmul(weights[:, None, :], particles)
    deviations = particles - mean
    found: NDArray[np.float64] = np.matmul(np.swapaxes(weights[:, :, None] * deviations, 1, 2), deviations)
    found[(weights > 0).sum(axis=1) == 1] = np.nan
    return found


def expectations(
    of: Callable[[NDArray[np.float64]], Any], particles: NDArray[np.float64], weights: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The expectation of a function of the particles of a row, `(K, N)`, whose values are `(K,)` or `(K, …)`: `(rows,)` or `(rows, …)`."""
    found = []
    for states, weight in zip(particles, weights, strict=True):
        values = np.asarray(of(states), dtype=np.float64)
        if values.ndim == 0 or len(values) != len(states):
            expected = f"it must have a number, or an array, for each of {len(states)} particles"
            raise ValueError(f"of: values of shape {values.shape} for states of shape {states.shape}; {expected}")
        # What a particle without weight says is never asked for.
        there = weight > 0
        found.append(np.tensordot(weight[there], values[there], axes=1))
    return np.array(found)
