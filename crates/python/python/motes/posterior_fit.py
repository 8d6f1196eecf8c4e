"""Parameters that were found from data."""

from __future__ import annotations

import inspect
import json
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _motes
from ._table import data_of, inputs_of
from .results import Filtered, Forecast, _escaped, _module

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .model import FilterSettings, Model


class PosteriorFit:
    """The posterior of a model's parameters, by draws."""

    def __init__(self, found: _motes.PosteriorFit, model: "Model"):
        self._found, self._model = found, model

    @property
    def parameters(self) -> list[str]:
        """The names of the `D` parameters."""
        return self._found.names

    @cached_property
    def _values(self) -> np.ndarray:
        return self._found.values().reshape(self._found.chains, -1, len(self.parameters))

    @property
    def draws(self) -> dict[str, np.ndarray]:
        """The draws of each parameter by its name, `(chains, draws)`."""
        return {name: self._values[:, :, at] for at, name in enumerate(self.parameters)}

    @cached_property
    def log_evidence(self) -> np.ndarray:
        """The estimate of the log-likelihood at each draw, `(chains, draws)`."""
        return self._found.log_evidence().reshape(self._found.chains, -1)

    @property
    def mean(self) -> dict[str, float]:
        """The mean of each parameter: values for `Model.with_parameters`."""
        return {name: found["mean"] for name, found in self.to_json()["parameters"].items()}

    @property
    def warnings(self) -> list[str]:
        """Reasons not to trust it."""
        return self._found.warnings

    def to_json(self) -> dict[str, Any]:
        """The object that the command prints with `--json`."""
        return json.loads(self._found.json())

    def summary(self) -> Any:
        """A data frame of pandas with a row for each parameter: mean, sd, quantiles, R-hat, effective sample sizes, Monte Carlo error."""
        pandas = _module("pandas", "summary")
        return pandas.DataFrame.from_dict(self.to_json()["parameters"], orient="index")

    def to_arviz(self) -> Any:
        """The draws as ArviZ has them: the group `posterior`, and the log-likelihoods in `sample_stats`."""
        arviz = _module("arviz", "to_arviz")
        groups = {"posterior": self.draws, "sample_stats": {"log_evidence": self.log_evidence}}
        # From version 1 on it takes all groups as one dict, before that each by its name.
        by_name = "posterior" in inspect.signature(arviz.from_dict).parameters
        return arviz.from_dict(**groups) if by_name else arviz.from_dict(groups)

    def predict(
        self, data: Any, steps: int | None = None, *, inputs: Any = None, draws: int = 100, **settings: "Unpack[FilterSettings]"
    ) -> Forecast:
        """Predicts states and measurements of `steps` times after the last measurement of each series, or at the times and with the
        inputs of `inputs`, with parameters drawn from the posterior: bands know how unsure they are.

        It is an average over `draws` draws, evenly spread; `settings` are those of `Model.filter`, of each of them. An average has no
        log-evidence.
        """
        from .model import _options, _warned

        if (steps is None) == (inputs is None):
            raise ValueError("steps: either how many times are predicted, or inputs with their times; one of the two is needed")
        ahead = {"forecast": steps} if inputs is None else {"ahead": inputs_of(self._model._model, inputs)}
        rows = data_of(self._model._model, data)
        options = _options(settings, check=False, **ahead)
        found = _motes.filter_over(self._model._model, self._found, rows.found, options, draws)
        return Forecast(_warned(Filtered(found, rows, self._model.states, self._model.measurements)), steps)

    def models(self, count: int) -> list["Model"]:
        """The model at `count` draws, evenly spread over all of them."""
        flat = self._values.reshape(-1, len(self.parameters))
        places = (2 * np.arange(count) + 1) * len(flat) // (2 * count)
        return [self._model.with_parameters(dict(zip(self.parameters, flat[at].tolist(), strict=True))) for at in places]

    def __getstate__(self) -> dict[str, Any]:
        return {"_found": self._found, "_model": self._model}

    def __repr__(self) -> str:
        return self._found.text().rstrip()

    def _repr_html_(self) -> str:
        return f"<pre>{_escaped(self._found.text())}</pre>"
