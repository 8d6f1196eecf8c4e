"""Models."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, Literal, cast, overload

import numpy as np

from . import _motes
from ._errors import warn
from ._estimates import whole
from ._filtering import Filtering
from ._keywords import checked
from ._seed import seed_of
from ._table import data_of, inputs_of
from .card import Card
from .maximum_fit import MaximumFit
from .posterior_fit import PosteriorFit
from .proposal import Learned, Proposal, named
from .simulated import Simulated


class Model(Filtering):
    """A state-space model.

    `source` is a model file, or a dict with its sections. `set` gives parameters other values.

    >>> import motes
    >>> model = motes.Model({
    ...     "parameters": {"q": 1.0},
    ...     "initial": {"x": "normal(0, 1)"},
    ...     "transition": {"x": "normal(0.9*x, sqrt(q))"},
    ...     "measurement": {"y": "normal(0, exp(x/2))"},
    ... }, set={"q": 0.5})
    >>> model.parameters
    {'q': 0.5}
    """

    @checked
    def simulate(
        self,
        steps: int | None = None,
        series: int = 1,
        *,
        seed: int | np.random.Generator | None = 1,
        inputs: Any = None,
        prior: bool = False,
    ) -> Simulated:
        """Draws `series` series of `steps` rows, or at the times and with the inputs of `inputs`: a file, a data frame, or a dict
        of columns.

        With `prior`, parameters that have one are drawn anew for each series. `seed` is that of `filter`.

        >>> import motes
        >>> walk = {"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, 1)"}, "measurement": {"y": "normal(x, 1)"}}
        >>> motes.Model(walk).simulate(50, series=3).measurements.shape
        (3, 50, 1)
        """
        if (steps is None) == (inputs is None):
            raise ValueError("steps: either how many rows a series has, or inputs with their times; one of the two is needed")
        seed = seed_of(seed)
        along = None if inputs is None else inputs_of(self._model, inputs)
        flat, drawn, labels = self._model.simulate(1 if steps is None else steps, series, seed, along, prior)
        rows = len(flat[2])
        if steps is None:
            steps = rows // series
        shape = (rows // steps, steps)
        columns = self._model.input_columns
        known = flat[3].reshape(*shape, len(columns))
        return Simulated(
            flat[0].reshape(*shape, len(self.states)),
            flat[1].reshape(*shape, len(self.measurements)),
            whole(flat[2]).reshape(shape),
            {name: known[..., at] for at, name in enumerate(columns) if name not in self.measurements},
            (self.states, self.measurements),
            (self._model.series_column, self._model.time_column or "t"),
            {name: np.array([dict(one)[name] for one in drawn]) for name, _ in (drawn[0] if drawn else [])},
            None if labels is None else np.array(labels).reshape(shape),
            seed,
        )

    @checked
    def check(self, data: Any = None, *, seed: int | np.random.Generator | None = 1) -> tuple[list[str], list[str]]:
        """Looks at the model, and at data if there are any: what is as it should be, and what is not.

        Simulations must stay finite, gradients must equal differences, and a filter must get through the data.
        """
        return self._model.check(None if data is None else data_of(self._model, data).found, seed_of(seed))

    @checked
    def evidence(
        self,
        data: Any,
        *,
        proposal: str | Proposal | None = None,
        particles: int = 1000,
        runs: int = 4,
        seed: int | np.random.Generator | None = 1,
        threads: int | None = None,
    ) -> dict[str, Any]:
        """The log-evidence of recorded data with its standard error, by independent runs: the object that the command prints with `--json`.

        Without a `proposal` the exact answer is taken where there is one, else what small pilots choose; `look-ahead` knows all data
        before it starts. One filter of each other proposal runs beside, to see whether it finds more.

        >>> import motes
        >>> walk = {"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, 0.1)"}, "measurement": {"y": "poisson(exp(x))"}}
        >>> motes.Model(walk).evidence([1, 0, 2, 9], particles=50)["proposal"]
        'look-ahead'
        """
        chosen = None if proposal is None else named(proposal)
        rows = data_of(self._model, data)
        found, warnings = _motes.evidence(self._model, rows.found, chosen, particles, runs, seed_of(seed), threads)
        for warning in warnings:
            warn(warning)
        return cast("dict[str, Any]", json.loads(found))

    @overload
    def fit(
        self,
        data: Any,
        *,
        method: Literal["posterior"] = ...,
        proposal: str | Proposal | None = ...,
        particles: int | None = ...,
        chains: int = ...,
        draws: int | None = ...,
        budget: float | None = ...,
        seed: int | np.random.Generator | None = ...,
        threads: int | None = ...,
    ) -> PosteriorFit: ...

    @overload
    def fit(
        self,
        data: Any,
        *,
        method: Literal["maximum"],
        proposal: str | Proposal | None = ...,
        particles: int | None = ...,
        chains: int = ...,
        profile: str | Sequence[str] = ...,
        passes: int | None = ...,
        seed: int | np.random.Generator | None = ...,
        threads: int | None = ...,
    ) -> MaximumFit: ...

    @checked
    def fit(
        self,
        data: Any,
        *,
        method: Literal["posterior", "maximum"] = "posterior",
        proposal: str | Proposal | None = None,
        particles: int | None = None,
        chains: int = 4,
        draws: int | None = None,
        profile: str | Sequence[str] = (),
        passes: int | None = None,
        budget: float | None = None,
        seed: int | np.random.Generator | None = 1,
        threads: int | None = None,
    ) -> PosteriorFit | MaximumFit:
        """Draws from the posterior of the parameters that have a prior and no value, by particle Markov chain Monte Carlo; by the
        `method` `maximum`, finds where the likelihood is largest.

        Starts, step sizes, the estimator of the likelihood and its number of particles are found. Chains go on until the R-hat of each
        parameter is below 1.01 and its effective sample size 400 at least, or for `draws` each; `budget` ends them after so many seconds.
        Of the maximum, `chains` is the number of searches, and `profile` names the parameters whose profiles and intervals are sought,
        all if none are named. The maximum of 8 parameters or more is sought by iterated filtering, with 100 `passes` through the data if no
        number is given, and profiles only where they are named; with `passes` that of fewer parameters, too.

        >>> import motes
        >>> model = motes.Model({
        ...     "parameters": {"sd": "half_normal(2)"},
        ...     "initial": {"x": "normal(0, 1)"},
        ...     "transition": {"x": "normal(x, sd)"},
        ...     "measurement": {"y": "normal(x, 1)"},
        ... })
        >>> fitted = model.fit([0.3, 1.2, 0.7, 2.4, 1.8], draws=100)
        >>> fitted.draws["sd"].shape
        (4, 100)
        >>> model.fit([0.3, 1.2, 0.7, 2.4, 1.8], method="maximum").parameters
        ['sd']
        """
        profiles = [profile] if isinstance(profile, str) else list(profile)
        if method not in ("posterior", "maximum"):
            raise ValueError(f"method: {method}; it must be posterior or maximum")
        if method == "posterior" and profiles:
            raise ValueError("profile: draws of the posterior have no profiles; take method='maximum'")
        if method == "posterior" and passes is not None:
            raise ValueError("passes: they seek a maximum; take method='maximum'")
        if method == "maximum" and (draws is not None or budget is not None):
            name = "budget" if draws is None else "draws"
            raise ValueError(f"{name}: the maximum draws nothing; leave draws and budget out, chains is its number of searches")
        seed = seed_of(seed)
        arguments = {
            "proposal": None if proposal is None else named(proposal),
            "particles": particles,
            "chains": chains,
            "draws": draws,
            "profile": profiles,
            "passes": passes,
            "budget": budget,
            "seed": seed,
        }
        rows = data_of(self._model, data)
        found: PosteriorFit | MaximumFit
        if method == "maximum":
            found = MaximumFit(_motes.maximise(self._model, rows.found, arguments, threads), self, seed)
        else:
            found = PosteriorFit(_motes.fit(self._model, rows.found, arguments, threads), self, seed)
        for text in found.warnings:
            warn(text)
        return found

    @checked
    def learn(
        self,
        data: Any = None,
        *,
        updates: int = 5000,
        steps: int = 100,
        objective: str = "inclusive",
        start: Proposal | None = None,
        base: str | None = None,
        head: str | None = None,
        network: str = "connected",
        widths: Sequence[int] | None = None,
        dropout: float = 0.0,
        penalty: float = 0.0,
        budget: float | None = None,
        particles: int = 100,
        sequences: int = 20,
        seed: int | np.random.Generator | None = 1,
        threads: int | None = None,
    ) -> Learned:
        """Learns a proposal from sequences that the model draws for itself, and holds it against designed ones.

        `data` are recorded sequences to learn from in addition, or alone by the objectives `wake` and `fivo`. `start` is a
        proposal to learn further. `base`, `head`, `network` and `widths` are chosen if None, and are named as in
        `motes learn`. Where parameters have priors, it is learned over these, and serves the model with any of their
        values, unless there are data, times or inputs, or one of these is asked for. Learning ends after `budget` seconds if one is
        given. `particles` and `sequences` are those of the card; with 0 sequences there is none.
        """
        rows = None if data is None else data_of(self._model, data).found
        seed = seed_of(seed)
        arguments = {
            "objective": objective,
            "start": None if start is None else named(start, "start"),
            "dropout": dropout,
            "penalty": penalty,
            "updates": updates,
            "budget": budget,
            "steps": steps,
            "base": base,
            "head": head,
            "network": network,
            "widths": None if widths is None else list(widths),
            "seed": seed,
        }
        found, validation, warnings, seconds = self._model.learn(rows, arguments, threads)
        for warning in warnings:
            warn(warning)
        if found.worse_than is not None:
            warn(f"it did worse than {found.worse_than} on sequences of the model; take proposal={found.worse_than!r}")
        card = None
        if sequences != 0:
            card = Card(self._model.card(found, particles, sequences, steps, seed, threads, seconds))
        return Learned(Proposal(found, self), validation, seconds, card, seed)

    @checked
    def compare(
        self,
        data: Any = None,
        *,
        proposals: str | Proposal | Sequence[str | Proposal] = (),
        sweep: Sequence[int] = (10, 30, 100, 300, 1000, 3000, 10000),
        sequences: int = 20,
        steps: int = 100,
        particles: int = 100,
        defensive: float | None = None,
        resample_below: float = 0.5,
        resampling: str = "systematic",
        seed: int | np.random.Generator | None = 1,
        threads: int | None = None,
    ) -> Card:
        """The report card of proposals side by side, on simulated sequences or on `data`; all designed ones if none is named.

        `sweep` are the numbers of particles at which error is held against time, `particles` is that of everything else. The other
        settings are those of `filter`.
        """
        rows = None if data is None else data_of(self._model, data).found
        asked = [proposals] if isinstance(proposals, (str, Proposal)) else proposals
        options = _motes.FilterOptions(
            particles=particles,
            defensive=defensive,
            resample_below=resample_below,
            resampling=resampling,
            seed=seed_of(seed),
            threads=threads,
        )
        chosen = [named(proposal, "proposals") for proposal in asked]
        return Card(self._model.compare(rows, chosen, options, list(sweep), sequences, steps))
