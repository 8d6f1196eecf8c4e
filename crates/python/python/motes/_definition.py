"""What a model is: where it comes from, its names and its parameters."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _motes
from ._display import preformatted
from ._toml import text_of

if TYPE_CHECKING:
    from typing_extensions import Self

    from .functions import Functions


class Definition:
    """What a model is: where it comes from, its names and its parameters."""

    _model: _motes.Model
    #: What a model in functions is made of.
    _functions: Functions

    def __init__(self, source: str | os.PathLike[str] | Mapping[str, Any], *, set: Mapping[str, float] | None = None):
        pairs = parameter_values(set)
        if isinstance(source, Mapping):
            # The text is nobody's: where in it something stands helps nobody.
            self._model = _motes.Model.parse(text_of(dict(source)), "model", pairs, True)
        elif isinstance(source, str) and "\n" in source and not os.path.exists(source):
            raise ValueError("source: a text of several lines; it must be a path or a dict; Model.parse reads a text")
        elif isinstance(source, (str, os.PathLike)):
            self._model = _motes.Model.read(os.fspath(source), pairs)
        else:
            raise TypeError(f"source: {type(source).__name__}; it must be a path or a dict")

    @classmethod
    def parse(cls, text: str, *, name: str = "model", set: Mapping[str, float] | None = None) -> Self:
        """The model of the text of a model file."""
        model = cls.__new__(cls)
        model._model = _motes.Model.parse(text, name, parameter_values(set), False)
        return model

    def with_parameters(self, values: Mapping[str, float]) -> Self:
        """The same model with other values of parameters."""
        model = type(self).__new__(type(self))
        model.__dict__.update(self.__dict__)
        model._model = _motes.with_parameters(self._model, parameter_values(values))
        return model

    def __getstate__(self) -> dict[str, Any]:
        # A file is kept as its text: what it says now, wherever it is read again.
        return {**self.__dict__, "_model": (self._model.source, self._model.set)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        source, set = state["_model"]
        if source is not None:
            self._model = _motes.Model.parse(*source)
        else:
            self._model = _motes.with_parameters(self._functions.model(), set)

    @property
    def name(self) -> str:
        """What it calls itself."""
        return self._model.name

    @property
    def states(self) -> list[str]:
        """The names of the `N` coordinates of a state."""
        return self._model.states

    @property
    def measurements(self) -> list[str]:
        """The names of the `M` coordinates of a measurement, which are the columns of data."""
        return self._model.measurements

    @property
    def parameters(self) -> dict[str, float]:
        """The parameters with their values."""
        return dict(self._model.parameters)

    @property
    def proposals(self) -> list[str]:
        """The designed proposals that it has."""
        return self._model.proposals

    def __repr__(self) -> str:
        return f"{self.name}\n\n{self._model.describe()}".rstrip()

    def _repr_html_(self) -> str:
        return preformatted(repr(self))


def parameter_values(values: Mapping[str, float] | None) -> list[tuple[str, float]]:
    """Values of parameters, by their names."""
    pairs = []
    for name, value in (values or {}).items():
        if isinstance(value, (bool, str)) or not hasattr(value, "__float__") or not np.isfinite(float(value)):
            raise ValueError(f"set: {name}: {value!r}; it must be a finite number")
        pairs.append((str(name), float(value)))
    return pairs


def parameter_rows(parameters: Any, names: list[str]) -> tuple[list[str], NDArray[np.float64]]:
    """The names of some parameters, and a row of values for each place where the evidence is wanted, `(n, D)`."""
    if hasattr(parameters, "keys") and hasattr(parameters, "__getitem__"):
        keys = list(parameters.keys())
        columns = [np.asarray(parameters[key], dtype=np.float64).reshape(-1) for key in keys]
        if len({len(column) for column in columns}) != 1:
            raise ValueError("parameters: there must be as many values of each parameter, at least of one")
        return [str(key) for key in keys], np.ascontiguousarray(np.stack(columns, axis=1))
    values = np.ascontiguousarray(parameters, dtype=np.float64)
    if values.ndim != 2 or values.shape[1] != len(names):
        raise ValueError(
            f"parameters: shape {values.shape}; it must be (n, {len(names)}) for {', '.join(names)}, or a dict of arrays"
        )
    return names, values
