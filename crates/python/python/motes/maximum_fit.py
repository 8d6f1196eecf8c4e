"""The maximum of a likelihood."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from . import _motes
from ._display import preformatted
from ._optional import module

if TYPE_CHECKING:
    from .model import Model


@dataclass(frozen=True)
class MaximumParameter:
    """A parameter at the maximum of the likelihood, with the interval of its profile."""

    #: Its value at the maximum.
    estimate: float
    #: The lower end of the interval; None where its profile was not sought.
    low: float | None
    #: The upper end.
    high: float | None


class MaximumFit:
    """The maximum of the likelihood over a model's parameters, with intervals by its profile."""

    def __init__(self, found: _motes.MaximumFit, model: Model, seed: int):
        self._found, self._model = found, model
        #: What all random numbers came from.
        self.seed = seed

    @cached_property
    def estimates(self) -> dict[str, MaximumParameter]:
        """Each of the `D` parameters by its name: `.estimate`, and its interval from `.low` to `.high`."""
        return {name: MaximumParameter(estimate, low, high) for name, estimate, low, high in self._found.parameters()}

    @property
    def parameters(self) -> list[str]:
        """The names of the `D` parameters."""
        return list(self.estimates)

    @property
    def values(self) -> dict[str, float]:
        """The value of each parameter at the maximum: values for `Model.with_parameters`."""
        return {name: found.estimate for name, found in self.estimates.items()}

    @property
    def level(self) -> float:
        """The probability of the intervals."""
        return cast("float", self.to_json()["level"])

    @property
    def log_likelihood(self) -> float:
        """The log-likelihood at the maximum."""
        return cast("float", self.to_json()["log_likelihood"])

    @property
    def log_likelihood_error(self) -> float:
        """Its standard error; 0 where it is exact."""
        return cast("float", self.to_json()["log_likelihood_error"])

    @property
    def search_log_likelihoods(self) -> list[float]:
        """The log-likelihood where each search ended, in their order."""
        return cast("list[float]", self.to_json()["search_log_likelihoods"])

    @property
    def aic(self) -> float:
        """Akaike's information criterion, `2 D − 2 log L`."""
        return cast("float", self.to_json()["aic"])

    @cached_property
    def profiles(self) -> dict[str, NDArray[np.float64]]:
        """The points of the profile of each parameter, `(points, 3)`: its value, the largest log-likelihood over all others, and the
        standard error of that; no points where it was not sought."""
        return {name: points.reshape(-1, 3) for name, points in zip(self.parameters, self._found.profiles(), strict=True)}

    @property
    def warnings(self) -> list[str]:
        """Reasons not to trust it."""
        return self._found.warnings

    def to_json(self) -> dict[str, Any]:
        """The object that the command prints with `--json`."""
        return cast("dict[str, Any]", json.loads(self._found.json()))

    def summary(self) -> Any:
        """A data frame of pandas with a row for each parameter: `estimate`, `low` and `high`, NaN where its profile was
        not sought."""
        names = ("estimate", "low", "high")
        columns = {name: np.array([getattr(found, name) for found in self.estimates.values()], dtype=np.float64) for name in names}
        return module("pandas", "summary").DataFrame(columns, index=self.parameters)

    def model(self) -> Model:
        """The model with its parameters at the maximum."""
        return self._model.with_parameters(self.values)

    def save(self, folder: str | os.PathLike[str]) -> None:
        """Writes the folder that the command writes, for `motes filter --parameters` and others."""
        self._found.save(os.fspath(folder))

    def __getstate__(self) -> dict[str, Any]:
        return {"_found": self._found, "_model": self._model, "seed": self.seed}

    def __repr__(self) -> str:
        return self._found.text().rstrip()

    def _repr_html_(self) -> str:
        return preformatted(self._found.text())
