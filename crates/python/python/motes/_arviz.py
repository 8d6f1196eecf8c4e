"""Draws as ArviZ has them."""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING, Any

import numpy as np

from ._optional import module
from ._xarray import grid_of, series_of

if TYPE_CHECKING:
    from .results import Smoothed


def of_groups(groups: dict[str, dict[str, Any]], **more: Any) -> Any:
    """Groups of variables, each with chains and draws first where it has draws."""
    arviz = module("arviz", "to_arviz")
    # From version 1 on it takes all groups as one dict, before that each by its name.
    by_name = "posterior" in inspect.signature(arviz.from_dict).parameters
    return arviz.from_dict(**groups, **more) if by_name else arviz.from_dict(groups, **more)


def of_paths(found: Smoothed) -> Any:
    """The trajectories of a smoother as draws of one chain, and what was measured."""
    grid, names = grid_of(found), [*found.states, *found._measured]
    times = grid.coordinates(found._times, found.time, names)
    coordinates = {"series": series_of(found), "time": times["time"]}
    taken = [name for name in names if name in (*coordinates, "chain", "draw")]
    if taken:
        raise ValueError(f"to_arviz: a coordinate of the model is called {taken[0]}, as a dimension of ArviZ is")
    count = len(coordinates["series"])
    paths = np.full((1, len(found.paths(0)), *grid.shape, len(found.states)), np.nan)
    for number in range(count):
        of_series = found.paths(number)
        paths[0, :, number, : of_series.shape[1]] = of_series
    measured = grid.of(found.measurements)
    groups = {
        "posterior": {name: paths[..., at] for at, name in enumerate(found.states)},
        "observed_data": {name: measured[..., at] for at, name in enumerate(found._measured)},
    }
    dimensions = {name: ["series", "time"] for name in names}
    return of_groups(groups, coords=coordinates, dims=dimensions)
