"""Models in functions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Union

from . import _motes
from .distributions import Distribution
from .model import Model

#: A distribution for each coordinate, or one whose parameters can be broadcast to `(K, N)`.
Stated = Union[Distribution, Sequence[Distribution]]


def of_functions(
    initial: Stated | Callable[[], Stated],
    transition: Callable[[int, Any], Stated],
    measurement: Callable[[int, Any], Stated],
    *,
    states: Sequence[str],
    measurements: Sequence[str],
    name: str = "functions",
    jax: bool = False,
) -> Model:
    """The model of functions of many particles at a time.

    `transition(t, x)` has the states `x_{t−1}` of `K` particles, an array of shape `(K, N)`, and returns the distributions of
    `x_t`. These are some of a filter's particles, 1024 at most: what it returns for a row must depend on that row alone. `measurement(t, x)` has `x_t` and returns those of `y_t`. `initial` are the distributions of `x_0`, or a function
    without arguments that returns them. A list has a distribution for each coordinate, whose parameters are numbers or
    arrays of shape `(K,)`. A single distribution has parameters that can be broadcast to `(K, N)`. Coordinates are
    independent given `x`.

    Functions of NumPy have no derivatives: such a model has the proposal `bootstrap`, and proposals that are learned by the
    objectives `inclusive` and `wake`. With `jax` the two functions are JAX's and are compiled: the model is linearised and
    differentiated, too. `x` is in double precision and `t` is a traced number. What a function finds outside of itself is
    read when it is compiled.

    `check` simulates 100 times, `learn` as many as its `steps`: a function that knows fewer times raises.

    A filter of such a model has one thread where none are asked for: only one at a time can call a function.

    It can be pickled as far as its functions can: those of a module, by their names.

    What a function raises is raised. One that returns what is no number, or the wrong shape, is a `ValueError` which names
    the function and the time.

    >>> import motes
    >>> model = motes.of_functions(
    ...     [motes.normal(0.0, 1.0)],
    ...     lambda t, x: [motes.normal(0.9 * x[:, 0], 0.5)],
    ...     lambda t, x: [motes.student_t(4.0, x[:, 0], 0.2)],
    ...     states=["x"],
    ...     measurements=["y"],
    ... )
    >>> model.filter([0.3, None, 0.7]).mean.shape
    (3, 1)
    """
    for argument, function in (("transition", transition), ("measurement", measurement)):
        if not callable(function):
            raise TypeError(f"{argument}: {type(function).__name__}; it must be a function")
    names: list[list[str]] = []
    for argument, given in (("states", states), ("measurements", measurements)):
        listed = given if isinstance(given, str) else list(given)
        if isinstance(listed, str) or not all(isinstance(name, str) for name in listed):
            raise TypeError(f"{argument}: {given!r}; it must be a list of names")
        names.append(listed)
    first = initial() if callable(initial) else initial
    model = Model.__new__(Model)
    model._functions = Functions(first, (transition, measurement), (names[0], names[1]), name, jax)
    model._model = model._functions.model()
    return model


@dataclass(frozen=True)
class Functions:
    """What a model in functions is made of: a copy or a pickle of it is made again."""

    initial: Stated
    functions: tuple[Callable[[int, Any], Stated], Callable[[int, Any], Stated]]
    names: tuple[list[str], list[str]]
    name: str
    jax: bool

    def model(self) -> _motes.Model:
        functions, slopes = self.functions, None
        if self.jax:
            from ._jax import compiled

            called = ("transition", "measurement")
            pairs = [compiled(*each) for each in zip(functions, called, self.names, strict=True)]
            functions, slopes = tuple(zip(*pairs, strict=True))
        return _motes.Model.of_functions(self.name, self.names, self.initial, functions, slopes)
