"""Models in functions."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Union

from . import _motes
from ._toml import text_of
from .distributions import Distribution
from .model import Model
from .step import Step, Values

#: A distribution for each coordinate, or one whose parameters can be broadcast to `(K, N)`.
Stated = Union[Distribution, Sequence[Distribution]]


def of_functions(
    initial: Stated | Callable[[], Stated] | Callable[[Values], Stated],
    transition: Callable[[Step, Any], Stated],
    measurement: Callable[[Step, Any], Stated],
    *,
    states: Sequence[str],
    measurements: Sequence[str],
    time: Mapping[str, Any] | None = None,
    inputs: Mapping[str, Any] | None = None,
    parameters: Mapping[str, Any] | None = None,
    series: Mapping[str, Any] | None = None,
    density: bool = True,
    name: str = "functions",
    jax: bool = False,
) -> Model:
    """The model of functions of many particles at a time.

    `transition(step, x)` has the states `x_{t−1}` of `K` particles, an array of shape `(K, N)`, and returns the distributions of
    `x_t`. These are some of a filter's particles, 1024 at most: what it returns for a row must depend on that row alone. `measurement(step, x)` has `x_t` and returns those of `y_t`. `initial` are the distributions of `x_0`, or a function
    without arguments, or of `parameters`, that returns them. A list has a distribution for each coordinate, whose parameters are numbers or
    arrays of shape `(K,)`. A single distribution has parameters that can be broadcast to `(K, N)`. Coordinates are
    independent given `x`.

    A `step` is a `motes.Step`: it has `index`, `time`, `dt`, and `inputs` and `parameters` by their names. `time`, `inputs`, `parameters` and `series` are these sections of a
    model file as dicts: `time={"column": "day", "unit": "day", "step": 0.5}`, `inputs={"dose": "hold"}`, `parameters={"q": "half_normal(1)"}`. A parameter with a prior is
    fitted by `fit`. An input has a value at each row and in each step, whatever the functions use, and files of inputs are relative to the working directory.

    With `density=False` states can be counts, as `motes.binomial(n, p)`, and `motes.known(value)`: known at the start, or following from those before without noise. Such a model has the
    proposal `bootstrap` alone, as one whose steps have sub-steps, and `smooth` follows its ancestors.

    Functions of NumPy have no derivatives: such a model has the proposal `bootstrap`, and proposals that are learned by the
    objectives `inclusive` and `wake`. With `jax` the two functions are JAX's and are compiled: the model is linearised and
    differentiated, too. `x` is in double precision, and the numbers of `step` are traced. What a function finds outside of itself is
    read when it is compiled.

    `check` simulates 100 times, `learn` as many as its `steps`: a function that knows fewer times raises.

    A filter of such a model has one thread where none are asked for: only one at a time can call a function.

    It can be pickled as far as its functions can: those of a module, by their names.

    What a function raises is raised. One that returns what is no number, or the wrong shape, is a `ValueError` which names
    the function and the time.

    >>> import motes
    >>> model = motes.of_functions(
    ...     [motes.normal(0.0, 1.0)],
    ...     lambda step, x: [motes.normal(0.9 * x[:, 0], step.parameters.q)],
    ...     lambda step, x: [motes.student_t(4.0, x[:, 0], 0.2)],
    ...     states=["x"],
    ...     measurements=["y"],
    ...     parameters={"q": "half_normal(1)"},
    ... )
    >>> model.filter([0.3, None, 0.7]).mean.shape
    (3, 1)
    >>> round(model.with_parameters({"q": 0.5}).parameters["q"], 1)
    0.5
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
    sections = {}
    for argument, section in (("time", time), ("inputs", inputs), ("parameters", parameters), ("series", series)):
        if section is not None and not isinstance(section, Mapping):
            raise TypeError(f"{argument}: {type(section).__name__}; it must be a dict, as this section of a model file")
        sections[argument] = dict(section or {})
    text = text_of({name: section for name, section in sections.items() if section})
    frame = Frame(names[0], names[1], [str(name) for name in sections["inputs"]], text, bool(density))
    model = Model.__new__(Model)
    model._functions = Functions(_of_parameters(initial), (transition, measurement), frame, name, jax)
    model._model = model._functions.model()
    return model


def _of_parameters(initial: Any) -> Any:
    """What is stated of the first state, or a function of parameters that does."""
    if not callable(initial):
        return initial
    try:
        arguments = inspect.signature(initial).parameters.values()
    except (TypeError, ValueError):
        return initial()
    kinds = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    takes_one = any(one.kind in kinds and one.default is one.empty for one in arguments)
    return initial if takes_one else initial()


@dataclass(frozen=True)
class Frame:
    """What a model in functions has beside them."""

    states: list[str]
    measurements: list[str]
    #: The names of inputs, in order.
    inputs: list[str]
    #: Times, inputs, parameters and series, as the text of a model file.
    sections: str
    density: bool


@dataclass(frozen=True)
class Functions:
    """What a model in functions is made of: a copy or a pickle of it is made again."""

    initial: Stated | Callable[[Values], Stated]
    functions: tuple[Callable[[Step, Any], Stated], Callable[[Step, Any], Stated]]
    frame: Frame
    name: str
    jax: bool

    def model(self) -> _motes.Model:
        functions: tuple[Callable[..., Any], Callable[..., Any]] = self.functions
        slopes = None
        if self.jax:
            from ._jax import compiled

            called, names = ("transition", "measurement"), (self.frame.states, self.frame.measurements)
            pairs = [compiled(*each) for each in zip(self.functions, called, names, strict=True)]
            functions, slopes = (pairs[0][0], pairs[1][0]), (pairs[0][1], pairs[1][1])
        return _motes.of_functions(self.name, vars(self.frame), self.initial, functions, slopes)
