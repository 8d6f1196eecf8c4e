"""Parameters that were found from data."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from . import _arviz, _motes, _posterior_plots
from ._display import preformatted
from ._estimates import warned
from ._keywords import checked
from ._quantiles import PROBABILITIES, probabilities_of
from ._optional import module
from ._seed import seed_of
from ._table import data_of, inputs_of
from .forecast import Forecast, steps_or_inputs
from .proposal import Proposal, named
from .results import Filtered

if TYPE_CHECKING:
    from .model import Model


#: The columns of a summary, in order.
_FIGURES = ["mean", "sd", "q05", "q50", "q95", "rhat", "ess_bulk", "ess_tail", "mcse"]


class PosteriorFit:
    """The posterior of a model's parameters, by draws."""

    def __init__(self, found: _motes.PosteriorFit, model: Model, seed: int):
        self._found, self._model = found, model
        #: What all random numbers came from.
        self.seed = seed

    @property
    def parameters(self) -> list[str]:
        """The names of the `D` parameters."""
        return self._found.names

    @cached_property
    def _values(self) -> NDArray[np.float64]:
        return self._found.values().reshape(self._found.chains, -1, len(self.parameters))

    @property
    def draws(self) -> dict[str, NDArray[np.float64]]:
        """The draws of each parameter by its name, `(chains, draws)`."""
        return {name: self._values[:, :, at] for at, name in enumerate(self.parameters)}

    @cached_property
    def log_evidence(self) -> NDArray[np.float64]:
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
        return cast("dict[str, Any]", json.loads(self._found.json()))

    def summary(self) -> Any:
        """A data frame of pandas with a row for each parameter: mean, sd, quantiles, R-hat, effective sample sizes, Monte Carlo error."""
        pandas = module("pandas", "summary")
        frame = pandas.DataFrame.from_dict(self.to_json()["parameters"], orient="index")
        first = [name for name in _FIGURES if name in frame]
        return frame[first + [name for name in frame if name not in first]]

    def to_arviz(self) -> Any:
        """The draws as ArviZ has them: the group `posterior`, and the log-likelihoods in `sample_stats`."""
        return _arviz.of_groups({"posterior": self.draws, "sample_stats": {"log_evidence": self.log_evidence}})

    def plot(self, parameters: list[str] | None = None, *, traces: bool = False, axes: Any = None) -> NDArray[np.object_]:
        """Draws the posterior of each parameter beside its prior, by matplotlib; gives the axes, one for each.

        The prior is that of draws from it. With `traces` there are the draws of each chain in their order instead.
        """
        if traces:
            return _posterior_plots.traces(self._chosen(parameters), axes)
        return _posterior_plots.marginals(self._chosen(parameters), self._prior_draws(), axes)

    def _chosen(self, parameters: list[str] | None) -> dict[str, NDArray[np.float64]]:
        draws = self.draws
        for name in parameters or []:
            if name not in draws:
                raise ValueError(f"parameters: {name}; it must be one of {', '.join(draws)}")
        return {name: draws[name] for name in (draws if parameters is None else parameters)}

    def _prior_draws(self) -> dict[str, NDArray[np.float64]]:
        """Draws of the parameters from their priors."""
        drawn = _motes.prior_draws(self._model._model, _posterior_plots.PRIOR_DRAWS)
        columns = list(zip(*drawn, strict=True))
        return {column[0][0]: np.array([value for _, value in column]) for column in columns}

    @checked
    def predict(
        self,
        data: Any,
        steps: int | None = None,
        *,
        inputs: Any = None,
        draws: int = 100,
        proposal: str | Proposal = "bootstrap",
        particles: int = 1000,
        defensive: float | None = None,
        resample_below: float = 0.5,
        resampling: str = "systematic",
        seed: int | np.random.Generator | None = 1,
        predictive: bool = False,
        quantiles: Sequence[float] = PROBABILITIES,
        threads: int | None = None,
    ) -> Forecast:
        """Predicts states and measurements of `steps` times after the last measurement of each series, or at the times and with the
        inputs of `inputs`, with parameters drawn from the posterior: bands include their uncertainty.

        It is an average over `draws` draws, evenly spread; the other settings are those of `Model.filter`, of each of them. An average
        has no log-evidence.
        """
        steps_or_inputs(steps, inputs)
        seed, rows = seed_of(seed), data_of(self._model._model, data)
        options = _motes.FilterOptions(
            proposal=named(proposal),
            particles=particles,
            defensive=defensive,
            resample_below=resample_below,
            resampling=resampling,
            seed=seed,
            check=False,
            predictive=predictive,
            quantiles=probabilities_of(quantiles),
            threads=threads,
            forecast=steps or 0,
            ahead=None if inputs is None else inputs_of(self._model._model, inputs),
        )
        found = _motes.filter_over(self._model._model, self._found, rows.found, options, draws)
        return Forecast(warned(Filtered(found, rows, self._model.states, self._model.measurements, seed)), steps)

    def models(self, count: int) -> list[Model]:
        """The model at `count` draws, evenly spread over all of them."""
        flat = self._values.reshape(-1, len(self.parameters))
        places = (2 * np.arange(count) + 1) * len(flat) // (2 * count)
        return [self._model.with_parameters(dict(zip(self.parameters, flat[at].tolist(), strict=True))) for at in places]

    def save(self, folder: str | os.PathLike[str]) -> None:
        """Writes the folder that the command writes, for `motes filter --parameters` and others."""
        self._found.save(os.fspath(folder))

    def __getstate__(self) -> dict[str, Any]:
        return {"_found": self._found, "_model": self._model, "seed": self.seed}

    def __repr__(self) -> str:
        return self._found.text().rstrip()

    def _repr_html_(self) -> str:
        return preformatted(self._found.text())
