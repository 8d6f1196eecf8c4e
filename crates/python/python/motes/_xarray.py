"""Results as datasets of xarray."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._grid import Grid
from ._optional import module
from ._times import Times

if TYPE_CHECKING:
    from ._estimates import Estimates
    from .forecast import Forecast
    from .results import Filtered, Smoothed

_STATE = ("series", "time", "state")
_MEASUREMENT = ("series", "time", "measurement")
_QUANTILE = "quantile"

#: The dimensions of values by their names.
_Values = dict[str, tuple[tuple[str, ...], NDArray[Any]]]


def of_filtered(found: Filtered) -> Any:
    """The dataset of a filter."""
    values = _of_states(found) | {
        "ess": (("series", "time"), found.ess),
        "log_evidence_increments": (("series", "time"), found.log_evidence_increments),
    }
    if found.is_predictive:
        values |= {
            "predictive_mean": (_MEASUREMENT, found.predictive_mean),
            "predictive_sd": (_MEASUREMENT, found.predictive_sd),
            "predictive_quantiles": ((*_MEASUREMENT, _QUANTILE), found.predictive_quantiles),
            "pit": (_MEASUREMENT, found.pit),
            "residuals": (_MEASUREMENT, found.residuals),
        }
    if found._kept is not None:
        values["particles"] = (("series", "time", "particle", "state"), found.particles)
        values["weights"] = (("series", "time", "particle"), found.weights)
    return _of_rows(found, values)


def of_smoothed(found: Smoothed) -> Any:
    """The dataset of a smoother."""
    return _of_rows(found, _of_states(found))


def of_forecast(found: Forecast, times: Times) -> Any:
    """The dataset of what is predicted, whose rows stand at these times."""
    values: _Values = {
        "mean": (_STATE, found.mean),
        "sd": (_STATE, found.sd),
        "quantiles": ((*_STATE, _QUANTILE), found.quantiles),
        "measurement_mean": (_MEASUREMENT, found.measurement_mean),
        "measurement_sd": (_MEASUREMENT, found.measurement_sd),
        "measurement_quantiles": ((*_MEASUREMENT, _QUANTILE), found.measurement_quantiles),
    }
    series, steps, _ = found.mean.shape
    grid = Grid(np.repeat(np.arange(series), steps), series)
    return _dataset(found.filtered, values, grid.coordinates(times, found.time.reshape(-1), values))


def _of_states(found: Estimates) -> _Values:
    return {
        "mean": (_STATE, found.mean),
        "sd": (_STATE, found.sd),
        "quantiles": ((*_STATE, _QUANTILE), found.quantiles),
        "measurements": (_MEASUREMENT, found.measurements),
    }


def _of_rows(found: Estimates, values: _Values) -> Any:
    """The dataset of values of rows."""
    grid = grid_of(found)
    of_series: _Values = {
        "log_evidence_per_series": (("series",), found.log_evidence_per_series),
        "standard_error_per_series": (("series",), found.standard_error_per_series),
    }
    filled = {name: (dimensions, grid.of(of_rows)) for name, (dimensions, of_rows) in values.items()}
    return _dataset(found, filled | of_series, grid.coordinates(found._times, found.time, values))


def grid_of(found: Estimates) -> Grid:
    """The rectangle of its rows."""
    return Grid(found.series, len(found.log_evidence_per_series))


def series_of(found: Estimates) -> NDArray[Any]:
    """The coordinate of series: their names, or their numbers where they have none."""
    labels = np.array(found._series_labels() or range(len(found.log_evidence_per_series)))
    # A file has numbers and texts, and no objects of Python.
    return labels if labels.dtype.kind in "iufUM" else labels.astype(str)


def _dataset(found: Estimates, values: _Values, times: dict[str, Any]) -> Any:
    coordinates = {"series": series_of(found), "state": found.states, "measurement": found._measured}
    names = {**coordinates, _QUANTILE: found.probabilities}
    attributes = {
        "log_evidence": found.log_evidence,
        "standard_error": found.standard_error,
        "pareto_k": found.pareto_k,
        "particles": found.particle_count,
        "seed": found.seed,
        "seconds": found.seconds,
        "warnings": "\n".join(found.collected_warnings),
    }
    # A file has nothing that stands for None.
    known = {name: value for name, value in attributes.items() if value is not None}
    return module("xarray", "to_xarray").Dataset(values, coords={**names, **times}, attrs=known)
