"""Plots of a posterior by matplotlib: its marginals beside the priors, and the traces of its chains."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._optional import module

#: Draws that stand for the priors.
PRIOR_DRAWS = 10_000

#: Parameters beside each other.
_ACROSS = 3

_Draws = dict[str, NDArray[np.float64]]


def marginals(draws: _Draws, priors: _Draws, axes: Any) -> NDArray[np.object_]:
    """A histogram of the draws of each parameter, with its mean, within that of its prior."""
    panels = _grid(len(draws), axes, _ACROSS, (3.2, 2.4))
    for (name, of_chains), axis in zip(draws.items(), panels, strict=True):
        values = of_chains.reshape(-1)
        low, high = np.quantile(values, [0.001, 0.999])
        margin = 0.15 * (high - low) or abs(low) or 1.0
        # No parameter gets a side that none of its prior's draws are on.
        least = priors[name].min() if name in priors else -np.inf
        # Few draws are no shape in many bins.
        count = min(40, max(12, round(np.sqrt(len(values)))))
        bins = np.linspace(max(low - margin, min(least, low)), high + margin, count + 1)
        axis.hist(values, bins, density=True, color="C0", alpha=0.4, label="posterior")
        axis.axvline(values.mean(), color="C0", linewidth=1.2, label="mean")
        if name in priors:
            inside, _ = np.histogram(priors[name], bins)
            density = inside / (len(priors[name]) * np.diff(bins))
            axis.stairs(density, bins, baseline=None, color="0.4", linewidth=1.0, label="prior")
        axis.set(xlabel=name, yticks=[], xlim=(bins[0], bins[-1]))
        axis.spines["left"].set_visible(False)
    panels[0].legend(loc="best", frameon=False, fontsize="small")
    return panels


def traces(draws: _Draws, axes: Any) -> NDArray[np.object_]:
    """The draws of each parameter in their order, a line for each chain."""
    panels = _grid(len(draws), axes, 1, (8.0, 1.8))
    for (name, of_chains), axis in zip(draws.items(), panels, strict=True):
        for number, chain in enumerate(of_chains):
            axis.plot(chain, linewidth=0.7, alpha=0.8, label=f"chain {number}")
        axis.set(xlim=(0, of_chains.shape[1] - 1))
        axis.set_title(name, loc="left", fontsize="medium")
    panels[0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, frameon=False, fontsize="small")
    panels[-1].set_xlabel("draw")
    return panels


def _grid(count: int, axes: Any, across: int, size: tuple[float, float]) -> NDArray[np.object_]:
    """Axes for so many parameters: those that are given, or those of a new figure with so many beside each other."""
    if axes is not None:
        given: NDArray[np.object_] = np.ravel(axes)
        if len(given) != count:
            raise ValueError(f"axes: {len(given)}; there must be one for each of {count} parameters")
        return given
    pyplot = module("matplotlib.pyplot", "plot")
    columns = min(count, across)
    rows = -(-count // columns)
    _, made = pyplot.subplots(
        rows, columns, squeeze=False, figsize=(size[0] * columns, size[1] * rows), layout="constrained", sharex=across == 1
    )
    for axis in made.flat:
        axis.spines[["top", "right"]].set_visible(False)
    for axis in made.flat[count:]:
        axis.remove()
    first: NDArray[np.object_] = np.ravel(made)[:count]
    return first
