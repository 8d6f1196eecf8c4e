"""Linear Gaussian models from matrices."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .model import Model


def linear_gaussian(
    *,
    A: Any,
    C: Any,
    Q: Any,
    R: Any,
    m0: Any,
    P0: Any,
    states: Sequence[str] | None = None,
    measurements: Sequence[str] | None = None,
    name: str = "linear Gaussian",
) -> Model:
    """The model `x_0 ~ N(m0, P0)`, `x_t = A x_{t−1} + N(0, Q)`, `y_t = C x_t + N(0, R)`.

    Its proposal `optimal` is exact. `A`, `Q` and `P0` are `(N, N)`, `C` is `(M, N)`, `R` is `(M, M)`, `m0` is `(N,)`.

    >>> import motes
    >>> model = motes.linear_gaussian(A=[[0.9]], C=[[1.0]], Q=[[1.0]], R=[[0.5]], m0=[0.0], P0=[[1.0]])
    >>> model.states, model.measurements
    (['x0'], ['y0'])
    """
    given = {"A": A, "C": C, "Q": Q, "R": R, "m0": m0, "P0": P0}
    arrays = {}
    for key, value in given.items():
        try:
            if np.iscomplexobj(value):
                raise TypeError("it has complex numbers")
            if np.ma.is_masked(value):
                raise TypeError("it has masked entries")
            arrays[key] = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise ValueError(f"{key}: {error}; it must be an array of numbers") from None
        expected = 1 if key == "m0" else 2
        if arrays[key].ndim != expected:
            raise ValueError(f"{key}: an array of shape {arrays[key].shape}; it must have {expected} axes")
    text = {key: value.tolist() for key, value in arrays.items()}
    named = {
        "states": list(states) if states is not None else [f"x{at}" for at in range(arrays["A"].shape[0])],
        "measurements": list(measurements) if measurements is not None else [f"y{at}" for at in range(arrays["C"].shape[0])],
    }
    return Model({"name": name, "kind": "linear-gaussian", **named, **text})
