"""Linear Gaussian models by their matrices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .model import Model

#: The names of vectors; all others are matrices.
_VECTORS = ("m0", "b", "d")


def linear_gaussian(
    *,
    A: Any,
    C: Any,
    Q: Any,
    R: Any,
    m0: Any,
    P0: Any,
    b: Any = None,
    d: Any = None,
    B: Any = None,
    D: Any = None,
    S: Any = None,
    inputs: Mapping[str, Any] | None = None,
    states: Sequence[str] | None = None,
    measurements: Sequence[str] | None = None,
    name: str = "linear Gaussian",
) -> Model:
    """The model `x_0 ~ N(m0, P0)`, `x_t = A x_{t−1} + b + B u_t + v_t`, `y_t = C x_t + d + D u_t + w_t`, with `v_t ~ N(0, Q)` and `w_t ~ N(0, R)`.

    Its proposal `exact` is the Kalman filter; `optimal` is exact, too, where there is no more than `A`, `C`, `Q` and `R` with inverses. `A`, `Q` and `P0` are `(N, N)`,
    `C` is `(M, N)`, `R` is `(M, M)`, `m0` is `(N,)`. Covariances are positive semi-definite.

    The others may be left out. `b`, `(N,)`, and `d`, `(M,)`, are intercepts. `S`, `(N, M)`, is the covariance of `v_t` and `w_t`, where `v_t` leads into `x_t`. `B`, `(N, U)`, and
    `D`, `(M, U)`, have a column for each of `inputs`, which says for each name how the column of the data is read, as `[inputs]` of a model file.

    >>> import motes
    >>> model = motes.linear_gaussian(A=[[0.9]], C=[[1.0]], Q=[[1.0]], R=[[0.5]], m0=[0.0], P0=[[1.0]])
    >>> model.states, model.measurements
    (['x0'], ['y0'])
    >>> level = motes.linear_gaussian(
    ...     A=[[1.0]], C=[[1.0]], Q=[[0.1]], R=[[0.5]], m0=[0.0], P0=[[1.0]], d=[3.0], D=[[0.7]], inputs={"u": "next"}
    ... )
    >>> round(level.filter({"y0": [3.1, 3.9, 2.8], "u": [0.0, 1.0, 0.0]}, proposal="exact").log_evidence, 6)
    -2.910901
    """
    given = {"A": A, "C": C, "Q": Q, "R": R, "m0": m0, "P0": P0, "b": b, "d": d, "B": B, "D": D, "S": S}
    arrays = {key: _array(key, value) for key, value in given.items() if value is not None}
    text: dict[str, Any] = {key: value.tolist() for key, value in arrays.items()}
    named = {
        "states": list(states) if states is not None else [f"x{at}" for at in range(arrays["A"].shape[0])],
        "measurements": list(measurements) if measurements is not None else [f"y{at}" for at in range(arrays["C"].shape[0])],
    }
    if inputs is not None:
        text["inputs"] = dict(inputs)
    return Model({"name": name, "kind": "linear-gaussian", **named, **text})


def _array(key: str, value: Any) -> NDArray[np.float64]:
    """A vector or matrix of numbers."""
    try:
        if np.iscomplexobj(value):
            raise TypeError("it has complex numbers")
        if np.ma.is_masked(value):
            raise TypeError("it has masked entries")
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{key}: {error}; it must be an array of numbers") from None
    expected = 1 if key in _VECTORS else 2
    if array.ndim != expected:
        raise ValueError(f"{key}: an array of shape {array.shape}; it must have {expected} axes")
    return array
