"""Models, and what is done with them."""

from __future__ import annotations

import copy
import json
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypedDict, TypeVar

import numpy as np

from . import _motes
from ._errors import warn
from ._table import _numbers, _text, data_of, inputs_of
from ._toml import text_of
from .card import Card
from .posterior_fit import PosteriorFit
from .results import Filtered, Forecast, Smoothed, _whole

if TYPE_CHECKING:
    from typing_extensions import Unpack

#: A result of a filter or of a smoother.
Found = TypeVar("Found", Filtered, Smoothed)


class Proposal:
    """A proposal that was learned for a model, and can be used for any sequence of it."""

    def __init__(self, found: _motes.Proposal, model: "Model"):
        self._found, self._model = found, model

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_found": self._model._model.proposal_bytes(self._found)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._found = self._model._model.proposal_of_bytes(state["_found"])

    @staticmethod
    def load(folder: str | os.PathLike[str], model: "Model", *, to_tune: bool = False) -> "Proposal":
        """Reads the proposal that was saved in `folder`; it must have been learned for `model`.

        With `to_tune` the model's parameters may be others: it is then a `start` for `Model.learn`.
        """
        return Proposal(model._model.load_proposal(os.fspath(folder), to_tune), model)

    def save(self, folder: str | os.PathLike[str]) -> None:
        """Writes it into `folder`, replacing a proposal that is there. The command reads it by `--proposal folder`."""
        self._model._model.save_proposal(self._found, os.fspath(folder))

    @property
    def name(self) -> str:
        """What it is called on a card."""
        return self._found.name

    @property
    def choice(self) -> str:
        """What it was chosen as, in a sentence."""
        return self._found.choice

    @property
    def evidence_errors(self) -> dict[str, float]:
        """The root-mean-square error of the log-evidence of simulated sequences with 100 particles, in nats: of designed proposals, of what was learned for filters, and of the potentials
        that `Model.evidence` and `Model.smooth` take."""
        return dict(self._found.evidence_errors)

    def __repr__(self) -> str:
        return f"Proposal {self.name}: {self.choice}, {self._found.updates} updates in {self._found.seconds:.1f} s"


class FilterSettings(TypedDict, total=False):
    """The settings of a filter; what is not given is as in the command."""

    #: `bootstrap`, `linearised`, `optimal`, a `Proposal`, or `exact`, which takes the Kalman filter, or for discrete states the forward algorithm, in the place of particles.
    proposal: str | Proposal
    #: `K`.
    particles: int
    #: The share of particles that is drawn from the transition. If None, 0.1 of a learned proposal, 0.1 of `linearised` where it
    #: draws noise that is not normal, and 0 else.
    defensive: float | None
    #: Resample where the effective sample size is below this share of `particles`; at each step where it is 1.
    resample_below: float
    #: `multinomial`, `systematic`, `stratified` or `residual`.
    resampling: str
    #: All random numbers come from it.
    seed: int
    #: Whether small filters run beside it, and a bootstrap filter beside any other proposal: they give the log-evidence its standard
    #: error, and warn where it cannot be trusted.
    check: bool
    #: Whether each measurement is predicted from those before it: then results have `predictive_mean`, `predictive_sd` and `pit`.
    predictive: bool
    #: All that the machine has if None.
    threads: int | None


class Learned:
    """What came of learning."""

    def __init__(self, proposal: Proposal, validation: list[tuple[int, float]], seconds: float, card: Card | None):
        #: The proposal, with the best weights on validation sequences.
        self.proposal = proposal
        #: What validation of a network for each particle said after so many updates, in nats a step: `(checks, 2)`.
        self.validation = np.array(validation, dtype=float).reshape(-1, 2)
        #: How long learning took.
        self.training_seconds = seconds
        #: The proposal beside designed ones; none where none was asked for.
        self.card = card

    def __repr__(self) -> str:
        return repr(self.proposal) + ("" if self.card is None else f"\n{self.card!r}")

    def _repr_html_(self) -> str:
        return f"<p>{self.proposal!r}</p>" + ("" if self.card is None else self.card._repr_html_())


class Simulated:
    """Series that a model drew."""

    def __init__(
        self,
        states: np.ndarray,
        measurements: np.ndarray,
        time: np.ndarray,
        inputs: dict[str, np.ndarray],
        names: tuple[list[str], list[str]],
        columns: tuple[str, str],
        parameters: dict[str, np.ndarray],
    ):
        #: States, `(S, T, N)`.
        self.states = states
        #: Measurements, `(S, T, M)`: data for `Model.filter`, where the model has no inputs.
        self.measurements = measurements
        #: The times, `(S, T)`.
        self.time = time
        #: The columns that inputs come from, by name, `(S, T)` each.
        self.inputs = inputs
        #: The parameters that were drawn for each series from their priors, by name, `(S,)` each; none where they were not.
        self.parameters = parameters
        self._names, self._columns = names, columns

    def to_pandas(self) -> Any:
        """A data frame of pandas with the columns series, the times, the inputs, the states, the measurements and the parameters that were drawn: data for `Model.filter`."""
        from .results import _module

        pandas = _module("pandas", "to_pandas")
        count, steps, _ = self.states.shape
        columns: dict[str, Any] = {self._columns[0]: np.repeat(np.arange(count), steps), self._columns[1]: self.time.reshape(-1)}
        columns.update({name: values.reshape(-1) for name, values in self.inputs.items()})
        for names, values in zip(self._names, (self.states, self.measurements), strict=True):
            columns.update({name: values[:, :, at].reshape(-1) for at, name in enumerate(names)})
        columns.update({name: np.repeat(values, steps) for name, values in self.parameters.items()})
        return pandas.DataFrame(columns)

    def __repr__(self) -> str:
        return f"Simulated: {self.states.shape[0]} series of {self.states.shape[1]} times"


class OnlineFilter:
    """A filter that takes in measurements as they come."""

    def __init__(self, model: "Model", settings: FilterSettings):
        self._model, self._settings = model, settings
        self._running = _motes.Online(model._model, _options({"check": False, **settings}), 0)
        self._width = len(model.measurements)
        #: The names of the `N` coordinates of a state.
        self.states = model.states
        #: The mean of the state, `(N,)`; NaN before the first step.
        self.mean = np.full(len(self.states), np.nan)
        #: Its standard deviation, `(N,)`.
        self.sd = self.mean.copy()
        #: Its quantiles at 5, 50 and 95 %, `(N, 3)`.
        self.quantiles = np.full((len(self.states), 3), np.nan)
        #: The effective sample size of the last step, in particles.
        self.ess: float | None = None
        #: The estimate of `log p(y_t | y_0 … y_{t−1})` of the last step.
        self.log_evidence_increment: float | None = None
        #: What was expected of the measurement before it was used, `(M,)`, where the filter was made with `predictive=True`; after `predict`, what is expected then.
        self.measurement_mean = np.full(self._width, np.nan)
        #: Its standard deviation, `(M,)`.
        self.measurement_sd = self.measurement_mean.copy()
        #: Its quantiles at 5, 50 and 95 %, `(M, 3)`.
        self.measurement_quantiles = np.full((self._width, 3), np.nan)
        #: Where the measurement lay in that, `P(Y < y) + P(Y = y)/2`, `(M,)`; NaN where it was missing.
        self.pit = self.measurement_mean.copy()

    def step(
        self, measurement: Any, *, time: Any = None, inputs: Mapping[str, float] | None = None
    ) -> "OnlineFilter":
        """Takes in the measurement of the next row, `(M,)`, NaN or None where one is missing; gives itself.

        `time` is the row's where the model names a column of times, `inputs` are the columns that its inputs come from, by name.
        """
        values = np.atleast_1d(_numbers(measurement, None))
        if values.shape != (self._width,):
            raise ValueError(f"measurement: an array of shape {values.shape}; it must be ({self._width},)")
        if np.isinf(values).any():
            raise ValueError(f"measurement: {values}; it must be finite, and NaN where one is missing")
        known = self._running.step(np.ascontiguousarray(values), self._time(time), self._inputs(inputs or {}))
        return self._known(known)

    def predict(self, *, time: Any = None, inputs: Mapping[str, float] | None = None) -> "OnlineFilter":
        """Goes on by a row at which nothing is measured, a gap as the last one ahead where no `time` is given; gives itself."""
        known = None if inputs is None and time is None else self._inputs(inputs or {})
        return self._known(self._running.predict(None if known is None else self._time(time), known))

    def _time(self, time: Any) -> str | None:
        column = self._model._model.time_column
        if (column is None) != (time is None):
            expected = f"the column {column} is that of times" if column else "the model names no column of times"
            raise ValueError(f"time: {time!r}; {expected}")
        return None if time is None else _text(time)

    def _inputs(self, inputs: Mapping[str, float]) -> np.ndarray:
        measured, needed = self._model.measurements, self._model._model.input_columns
        unknown = [name for name in inputs if name not in needed]
        if unknown:
            raise ValueError(f"inputs: {unknown[0]} is none of the model; it has {', '.join(needed) or 'none'}")
        missing = [name for name in needed if name not in inputs and name not in measured]
        if missing:
            raise ValueError(f"inputs: {missing[0]} is missing; each row needs it, NaN where it is not known")
        return np.array([float(inputs.get(name, np.nan)) for name in needed])

    @property
    def log_evidence(self) -> float:
        """The estimate of `log p(y)` of all measurements so far."""
        return self._running.log_evidence

    @property
    def standard_error(self) -> float | None:
        """The standard error of `log_evidence` where the filter was made with `check=True`; none of fewer than 16 particles."""
        return self._running.standard_error

    @property
    def pareto_k(self) -> float | None:
        """The Pareto k of the last step's weights."""
        return self._running.pareto_k

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_running": (self._running.checkpoint(), self._running.has_failed)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        options = _options({"check": False, **self._settings})
        self._running = _motes.Online.resume(self._model._model, options, *state["_running"])

    def __copy__(self) -> "OnlineFilter":
        # One that shared anything with the original would be stepped with it.
        return copy.deepcopy(self)

    def __deepcopy__(self, memo: dict[int, Any]) -> "OnlineFilter":
        made = memo[id(self)] = type(self).__new__(type(self))
        state = self.__getstate__()
        # Model and settings never change and are shared.
        shared = {key: state.pop(key) for key in ("_model", "_settings")}
        made.__setstate__({**copy.deepcopy(state, memo), **shared})
        return made

    def _known(self, known: tuple[Any, ...]) -> "OnlineFilter":
        self.mean, self.sd, quantiles, self.ess, self.log_evidence_increment, expected = known
        self.quantiles = quantiles.reshape(-1, 3)
        # Nothing is expected where nobody asked.
        self.measurement_mean, self.measurement_sd, quantiles, self.pit = (
            values if len(values) > 0 else np.full(size, np.nan)
            for values, size in zip(expected, (self._width, self._width, 3 * self._width, self._width), strict=True)
        )
        self.measurement_quantiles = quantiles.reshape(-1, 3)
        return self


class Model:
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

    def __init__(self, source: str | os.PathLike[str] | Mapping[str, Any], *, set: Mapping[str, float] | None = None):
        pairs = _parameters(set)
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
    def parse(cls, text: str, *, name: str = "model", set: Mapping[str, float] | None = None) -> "Model":
        """The model of the text of a model file."""
        model = cls.__new__(cls)
        model._model = _motes.Model.parse(text, name, _parameters(set), False)
        return model

    def __getstate__(self) -> dict[str, Any]:
        # A file is kept as its text: what it says now, wherever it is read again.
        return {**self.__dict__, "_model": self._model.source}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        if state["_model"] is not None:
            self._model = _motes.Model.parse(*state["_model"])
        else:
            self._model = self._functions.model()

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
        from .results import _escaped

        return f"<pre>{_escaped(repr(self))}</pre>"

    def simulate(
        self, steps: int | None = None, series: int = 1, *, seed: int = 1, inputs: Any = None, prior: bool = False
    ) -> Simulated:
        """Draws `series` series of `steps` rows, or at the times and with the inputs of `inputs`: a file, a data frame, or a dict of columns.

        With `prior`, parameters that have one are drawn anew for each series.

        >>> import motes
        >>> walk = {"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, 1)"}, "measurement": {"y": "normal(x, 1)"}}
        >>> motes.Model(walk).simulate(50, series=3).measurements.shape
        (3, 50, 1)
        """
        if (steps is None) == (inputs is None):
            raise ValueError("steps: either how many rows a series has, or inputs with their times; one of the two is needed")
        along = None if inputs is None else inputs_of(self._model, inputs)
        flat, drawn = self._model.simulate(1 if steps is None else steps, series, seed, along, prior)
        rows = len(flat[2])
        if steps is None:
            steps = rows // series
        shape = (rows // steps, steps)
        columns = self._model.input_columns
        known = flat[3].reshape(*shape, len(columns))
        return Simulated(
            flat[0].reshape(*shape, len(self.states)),
            flat[1].reshape(*shape, len(self.measurements)),
            _whole(flat[2]).reshape(shape),
            {name: known[..., at] for at, name in enumerate(columns) if name not in self.measurements},
            (self.states, self.measurements),
            (self._model.series_column, self._model.time_column or "t"),
            {name: np.array([dict(one)[name] for one in drawn]) for name, _ in (drawn[0] if drawn else [])},
        )

    def check(self, data: Any = None, *, seed: int = 1) -> tuple[list[str], list[str]]:
        """Looks at the model, and at data if there are any: what is as it should be, and what is not.

        Simulations must stay finite, gradients must equal differences, and a filter must get through the data.
        """
        return self._model.check(None if data is None else data_of(self._model, data).found, seed)

    def filter(self, data: Any, **settings: Unpack[FilterSettings]) -> Filtered:
        """Estimates the states of `data`, time by time, with the evidence of each measurement.

        `data` is an array of shape `(T, M)` or `(S, T, M)`, or `(T,)` where `M` is 1; a list of arrays of unequal length;
        a data frame of pandas or polars, or a dict of columns, read as the command reads CSV: columns by the names of the
        measurements, `series`, `t`, and a first column of another name that is carried along; or the path of a CSV file.
        NaN and None are missing.

        `settings` are `proposal`, `particles`, `defensive`, `resample_below`, `resampling`, `seed`, `check`, `predictive` and `threads`;
        `FilterSettings` says what they are. What is not given is as in the command `motes filter`. The same seed gives
        the same bytes there, and on any number of threads.

        Warns with `MotesWarning` where the result cannot be trusted. Raises `ValueError` for bad input.

        >>> import motes
        >>> walk = {"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, 1)"}, "measurement": {"y": "normal(x, 1)"}}
        >>> filtered = motes.Model(walk).filter([0.1, None, 0.4], proposal="optimal")
        >>> filtered.sd.shape, len(filtered.log_evidence_increments)
        ((3, 1), 3)
        """
        return self._filtered(data, _options(settings))

    def log_evidence(self, data: Any, parameters: Any = None, **settings: Unpack[FilterSettings]) -> Any:
        """The estimate of `log p(y)` of all series, and nothing else: what a search over parameters and particle MCMC ask for.

        It is that of `filter` with the same settings, which has no `check` here, to the last bit; what costs time beside it is
        left out. Where no particle explains a measurement, the estimate of the evidence is 0: this gives −∞ and warns with
        `MotesWarning`, which names the row. `filter` raises `ValueError` there.

        >>> import motes
        >>> walk = {"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, 1)"}, "measurement": {"y": "normal(x, 1)"}}
        >>> model = motes.Model(walk)
        >>> model.log_evidence([0.1, None, 0.4]) == model.filter([0.1, None, 0.4]).log_evidence
        True

        With `parameters`, at each of `n` values of them, as an array of shape `(n,)`: a dict of arrays or a data frame by their names, or
        an array of shape `(n, D)` whose columns are the parameters that have a prior, or all if none has one, in the order of the
        model. All have the same random numbers, and all threads are used: that is what an optimiser or a sampler of one's own asks
        for. It is −∞ where no particle explains a measurement, and where there is no such model.

        >>> walk = {"parameters": {"sd": "half_normal(2)"}, **walk, "transition": {"x": "normal(x, sd)"}}
        >>> motes.Model(walk).log_evidence([0.1, None, 0.4], parameters={"sd": [0.5, 1.0, 2.0]}).shape
        (3,)
        """
        rows = data_of(self._model, data)
        if parameters is not None:
            options = _options(settings, check=False, predictive=False)
            names, values = _rows_of(parameters, _motes.free_parameters(self._model) or [name for name, _ in self._model.parameters])
            return _motes.log_evidence_at(self._model, rows.found, options, names, values.reshape(-1))
        found, impossible = self._model.log_evidence(rows.found, _options(settings, check=False, predictive=False))
        if impossible is not None:
            warn(impossible)
        return found

    def forecast(
        self, data: Any, steps: int | None = None, *, inputs: Any = None, **settings: Unpack[FilterSettings]
    ) -> Forecast:
        """Predicts states and measurements of `steps` times after the last measurement of each series, or at the times and with
        the inputs of `inputs`: a file, a data frame, or a dict of columns. Settings are those of `filter`.

        Rows of data with dates in equal steps, in an index of pandas or in the column that is carried along, are followed by
        rows with the dates after them. Where dates are there and it is not known which ones follow, it warns.
        """
        if (steps is None) == (inputs is None):
            raise ValueError("steps: either how many times are predicted, or inputs with their times; one of the two is needed")
        if inputs is None:
            return Forecast(self._filtered(data, _options(settings, forecast=steps)), steps)
        return Forecast(self._filtered(data, _options(settings, ahead=inputs_of(self._model, inputs))))

    def smooth(self, data: Any, *, paths: int = 200, **settings: Unpack[FilterSettings]) -> Smoothed:
        """Estimates the states given all measurements, by `paths` trajectories drawn backwards; settings are those of `filter`."""
        rows = data_of(self._model, data)
        found = self._model.smooth(rows.found, _options(settings, predictive=False), paths)
        return _warned(Smoothed(found, rows, self.states, self.measurements))

    def online(self, **settings: Unpack[FilterSettings]) -> OnlineFilter:
        """A filter that takes in measurements as they come, by `step(y)`; settings are those of `filter`, but
        `check` is false unless it is asked for.

        It has one thread unless others are asked for. A pickle or a copy of it, made at any time, goes on as it would itself, to
        the last bit.

        >>> import motes
        >>> walk = {"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, 1)"}, "measurement": {"y": "normal(x, 1)"}}
        >>> online = motes.Model(walk).online(proposal="optimal")
        >>> online.step(0.3).mean.shape
        (1,)
        """
        return OnlineFilter(self, {"threads": 1, **settings})

    def evidence(
        self,
        data: Any,
        *,
        proposal: str | Proposal | None = None,
        particles: int = 1000,
        runs: int = 4,
        seed: int = 1,
        threads: int | None = None,
    ) -> dict[str, Any]:
        """The log-evidence of recorded data with its standard error, by independent runs: the object that the command prints with `--json`.

        Without a `proposal` the exact answer is taken where there is one, else what small pilots choose; `look-ahead` knows all data before it starts.

        >>> import motes
        >>> walk = {"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, 0.1)"}, "measurement": {"y": "poisson(exp(x))"}}
        >>> motes.Model(walk).evidence([1, 0, 2, 9], particles=50)["proposal"]
        'look-ahead'
        """
        named = None if proposal is None else _proposal(proposal, "proposal")
        rows = data_of(self._model, data)
        found, warning = _motes.evidence(self._model, rows.found, named, particles, runs, seed, threads)
        if warning is not None:
            warn(warning)
        return json.loads(found)

    def fit(
        self,
        data: Any,
        *,
        proposal: str | Proposal | None = None,
        particles: int | None = None,
        chains: int = 4,
        draws: int | None = None,
        budget: float | None = None,
        seed: int = 1,
        threads: int | None = None,
    ) -> PosteriorFit:
        """Draws from the posterior of the parameters that have a prior and no value, by particle Markov chain Monte Carlo.

        Starts, step sizes, the estimator of the likelihood and its number of particles are found. Chains go on until the R-hat of each
        parameter is below 1.01 and its effective sample size 400 at least, or for `draws` each; `budget` ends them after so many seconds.

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
        """
        arguments = {
            "proposal": None if proposal is None else _proposal(proposal, "proposal"),
            "particles": particles,
            "chains": chains,
            "draws": draws,
            "budget": budget,
            "seed": seed,
        }
        rows = data_of(self._model, data)
        fitted = PosteriorFit(_motes.fit(self._model, rows.found, arguments, threads), self)
        for text in fitted.warnings:
            warn(text)
        return fitted

    def with_parameters(self, values: Mapping[str, float]) -> "Model":
        """The same model with other values of parameters."""
        model = type(self).__new__(type(self))
        model.__dict__.update(self.__dict__)
        model._model = _motes.with_parameters(self._model, _parameters(values))
        return model

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
        seed: int = 1,
        threads: int | None = None,
    ) -> Learned:
        """Learns a proposal from sequences that the model draws for itself, and holds it against designed ones.

        `data` are recorded sequences to learn from in addition, or alone by the objectives `wake` and `fivo`. `start` is a
        proposal to learn further. `base`, `head`, `network` and `widths` are chosen if None, and are named as in
        `motes learn`. Where parameters have priors, it is learned over these, and serves the model with any of their
        values, unless there are data, times or inputs, or one of these is asked for. Learning ends after `budget` seconds if one is given. `particles` and `sequences` are those of the
        card; with 0 sequences there is none.
        """
        rows = None if data is None else data_of(self._model, data).found
        arguments = {
            "objective": objective,
            "start": None if start is None else _proposal(start, "start"),
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
        return Learned(Proposal(found, self), validation, seconds, card)

    def compare(
        self,
        data: Any = None,
        *,
        proposals: str | Proposal | Sequence[str | Proposal] = (),
        at: Sequence[int] = (10, 30, 100, 300, 1000, 3000, 10000),
        sequences: int = 20,
        steps: int = 100,
        **settings: Unpack[FilterSettings],
    ) -> Card:
        """The report card of proposals side by side, on simulated sequences or on `data`; all designed ones if none is named.

        `at` are the numbers of particles at which error is held against time. `settings` are those of `filter`, but for
        `proposal` and `check`.
        """
        rows = None if data is None else data_of(self._model, data).found
        asked = [proposals] if isinstance(proposals, (str, Proposal)) else proposals
        named = [_proposal(proposal, "proposals") for proposal in asked]
        options = _options({"particles": 100, **settings}, proposal="bootstrap", predictive=False)
        return Card(self._model.compare(rows, named, options, list(at), sequences, steps))

    def _filtered(self, data: Any, options: _motes.FilterOptions) -> Filtered:
        rows = data_of(self._model, data)
        found = self._model.filter(rows.found, options)
        return _warned(Filtered(found, rows, self.states, self.measurements))


def _rows_of(parameters: Any, names: list[str]) -> tuple[list[str], np.ndarray]:
    """The names of some parameters, and a row of values for each place where the evidence is wanted, `(n, D)`."""
    if hasattr(parameters, "keys") and hasattr(parameters, "__getitem__"):
        names = [str(name) for name in parameters.keys()]
        columns = [np.asarray(parameters[name], dtype=np.float64).reshape(-1) for name in parameters.keys()]
        if len({len(column) for column in columns}) != 1:
            raise ValueError("parameters: there must be as many values of each parameter, at least of one")
        return names, np.ascontiguousarray(np.stack(columns, axis=1))
    values = np.ascontiguousarray(parameters, dtype=np.float64)
    if values.ndim != 2 or values.shape[1] != len(names):
        raise ValueError(f"parameters: shape {values.shape}; it must be (n, {len(names)}) for {', '.join(names)}, or a dict of arrays")
    return names, values


def _parameters(set: Mapping[str, float] | None) -> list[tuple[str, float]]:
    pairs = []
    for name, value in (set or {}).items():
        if isinstance(value, (bool, str)) or not hasattr(value, "__float__") or not np.isfinite(float(value)):
            raise ValueError(f"set: {name}: {value!r}; it must be a finite number")
        pairs.append((str(name), float(value)))
    return pairs


def _proposal(proposal: str | Proposal, argument: str) -> Any:
    if isinstance(proposal, Proposal):
        return proposal._found
    if isinstance(proposal, str):
        return proposal
    raise TypeError(f"{argument}: {type(proposal).__name__}; it must be a name or a Proposal")


def _options(settings: FilterSettings, **more: Any) -> _motes.FilterOptions:
    """The options of a filter; what is not given is as in the command. What `more` says cannot be set."""
    known = [name for name in FilterSettings.__annotations__ if name not in more]
    for name in settings:
        if name not in known:
            raise TypeError(f"{name}: there is no such argument; there are {', '.join(known)}")
    given = {**settings, **more}
    if "proposal" in given:
        given["proposal"] = _proposal(given["proposal"], "proposal")
    return _motes.FilterOptions(**given)


def _warned(found: Found) -> Found:
    """Warns of what there is to warn of in a result."""
    for text in found.warnings:
        warn(text)
    return found
