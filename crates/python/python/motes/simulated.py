"""Series that a model drew."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._display import Display, shapes
from ._optional import module
from ._plots import simulated_panels


class Simulated:
    """Series that a model drew."""

    def __init__(
        self,
        states: NDArray[np.float64],
        measurements: NDArray[np.float64],
        time: NDArray[np.int64] | NDArray[np.float64],
        inputs: dict[str, NDArray[np.float64]],
        names: tuple[list[str], list[str]],
        columns: tuple[str, str],
        parameters: dict[str, NDArray[np.float64]],
        labels: NDArray[np.str_] | None,
        seed: int,
    ):
        #: States, `(S, T, N)`.
        self.states = states
        #: Measurements, `(S, T, M)`: data for `Model.filter`, where the model has no inputs.
        self.measurements = measurements
        #: The times, `(S, T)`.
        self.time = time
        #: The times as the column of `inputs` has them, as dates, `(S, T)`; none where they have no such names.
        self.labels = labels
        #: The columns that inputs come from, by name, `(S, T)` each.
        self.inputs = inputs
        #: The parameters that were drawn for each series from their priors, by name, `(S,)` each; none where they were not.
        self.parameters = parameters
        #: What all its random numbers came from.
        self.seed = seed
        self._names, self._columns = names, columns

    def to_pandas(self) -> Any:
        """A data frame of pandas with the columns series, the times, the inputs, the states, the measurements and the parameters
        that were drawn: data for `Model.filter`."""
        pandas = module("pandas", "to_pandas")
        count, steps, _ = self.states.shape
        columns: dict[str, Any] = {self._columns[0]: np.repeat(np.arange(count), steps), self._columns[1]: (self.time if self.labels is None else self.labels).reshape(-1)}
        columns.update({name: values.reshape(-1) for name, values in self.inputs.items()})
        for names, values in zip(self._names, (self.states, self.measurements), strict=True):
            columns.update({name: values[:, :, at].reshape(-1) for at, name in enumerate(names)})
        columns.update({name: np.repeat(values, steps) for name, values in self.parameters.items()})
        return pandas.DataFrame(columns)

    def plot(self, *, series: int | None = 0, axes: Any = None) -> NDArray[np.object_]:
        """Draws the states of one series as lines and its measurements as points, or of all series if None, a panel for each
        coordinate, by matplotlib; gives the axes."""
        return simulated_panels(self, series, axes)

    def _display(self) -> Display:
        count, steps, _ = self.states.shape
        display = Display(
            f"Simulated: {count} series of {steps} times",
            [shapes(states=self.states, measurements=self.measurements)],
            ["first", "last"] if count == 1 else ["first of series 0", "last"],
        )
        for names, values in zip(self._names, (self.states, self.measurements), strict=True):
            display.add(names, values[0, 0], values[0, -1])
        return display

    def __repr__(self) -> str:
        return self._display().text()

    def _repr_html_(self) -> str:
        return self._display().html()
