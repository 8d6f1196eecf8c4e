"""What the functions of a model are told of a step."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

__all__ = ["Step", "Values"]


class Values(Mapping[str, Any]):
    """Numbers by their names, `values["a"]` or `values.a`; a parameter that is a list is an array."""

    __slots__ = ("_values",)
    _values: dict[str, Any]

    def __init__(self, values: Mapping[str, Any]):
        object.__setattr__(self, "_values", dict(values))

    def __getitem__(self, name: str) -> Any:
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __getattr__(self, name: str) -> Any:
        # Whoever copies an object asks one that has nothing yet.
        if name.startswith("__") or name == "_values" or name not in self._values:
            there = "" if name.startswith("_") else f"; there are {', '.join(self._values) or 'none'}"
            raise AttributeError(f"{name}: there is no input or parameter of that name{there}")
        return self._values[name]

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"{name}: inputs and parameters are given to functions, which do not change them")

    def __reduce__(self) -> tuple[type[Values], tuple[dict[str, Any]]]:
        return Values, (self._values,)

    def __repr__(self) -> str:
        return f"Values({self._values!r})"


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """The step to `x_t`, or in a model whose steps have sub-steps one of these.

    `measurement` is given its end, where inputs are those of the row.
    """

    #: How many steps are before it: 0 for the first row.
    index: int
    #: The time at its end: 0, 1, 2, … unless the model has times.
    time: float
    #: How long it is: 1 unless the model has times.
    dt: float
    #: The inputs of the model.
    inputs: Values
    #: The parameters of the model.
    parameters: Values


def _parameters(pairs: list[tuple[str, float]]) -> Values:
    """Parameters, of which entries of lists are called `a[0]` or `a[0,1]`."""
    found: dict[str, Any] = {}
    entries: dict[str, dict[tuple[int, ...], float]] = {}
    for name, value in pairs:
        base, bracket, indices = name.partition("[")
        if bracket:
            found.setdefault(base, None)
            entries.setdefault(base, {})[tuple(map(int, indices.rstrip("]").split(",")))] = value
        else:
            found[name] = value
    for base, of_list in entries.items():
        array = np.empty(tuple(size + 1 for size in max(of_list)))
        for at, value in of_list.items():
            array[at] = value
        array.flags.writeable = False
        found[base] = array
    return Values(found)


def _steps(names: list[str], parameters: Values) -> Callable[[int, float, float, list[float]], Step]:
    """What makes steps with inputs of these names."""

    def step(index: int, time: float, dt: float, inputs: list[float]) -> Step:
        return Step(index, time, dt, Values(dict(zip(names, inputs, strict=True))), parameters)

    return step
