"""Plots by matplotlib: a panel for each state and measurement, one below the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._optional import module
from ._times import Times

if TYPE_CHECKING:
    from .simulated import Simulated


@dataclass
class Band:
    """A mean within its quantiles along an axis of time."""

    across: NDArray[Any]
    mean: NDArray[np.float64]
    #: From the lowest to the highest, `(rows, Q)`.
    quantiles: NDArray[np.float64]
    called: tuple[str, str]
    colour: str
    #: Whether it begins with rows before which little is known.
    begins: bool = True

    @property
    def settled(self) -> NDArray[np.float64]:
        """Its edges without those first rows."""
        first = max(1, len(self.across) // 20) if self.begins else 0
        return self.quantiles[first:, [0, -1]].reshape(-1)


@dataclass
class Panel:
    """What is drawn of one coordinate."""

    name: str
    across: Times
    bands: list[Band] = field(default_factory=list)
    #: What was measured at the places of the first band.
    points: NDArray[np.float64] | None = None

    def draw(self, axis: Any) -> None:
        """Draws it on an axis of matplotlib."""
        for band in self.bands:
            low, high = band.quantiles[:, 0], band.quantiles[:, -1]
            axis.fill_between(band.across, low, high, alpha=0.25, linewidth=0, color=band.colour, label=band.called[0])
            # A line of one row is no line.
            marker = "." if len(band.across) == 1 else None
            axis.plot(band.across, band.mean, color=band.colour, linewidth=1.2, marker=marker, label=band.called[1])
        if self.points is not None:
            draw_points(axis, self.across.places, self.points, "measured")
        axis.set_ylabel(self.name)
        if (limits := self._limits()) is not None:
            axis.set_ylim(*limits)

    def _limits(self) -> tuple[float, float] | None:
        """Limits that first rows leave whose bands are so wide that they would flatten all else; None where none are."""
        points = np.empty(0) if self.points is None else self.points
        all_edges = np.concatenate([band.quantiles[:, [0, -1]].reshape(-1) for band in self.bands] or [points])
        settled = np.concatenate([*(band.settled for band in self.bands), points[np.isfinite(points)]])
        if len(settled) == 0 or not np.isfinite(settled).all() or not np.isfinite(all_edges).all():
            return None
        low, high = settled.min(), settled.max()
        is_flattened = all_edges.max() - all_edges.min() > 2 * (high - low) > 0
        margin = 0.1 * (high - low)
        return (low - margin, high + margin) if is_flattened else None


def draw_points(axis: Any, across: NDArray[Any], values: NDArray[np.float64], called: str | None, alpha: float = 1.0) -> None:
    """Draws measurements, smaller where there are many."""
    size = 4.0 if len(values) <= 150 else 2.5
    axis.plot(across, values, "o", color="0.2", alpha=alpha, markersize=size, markeredgewidth=0, zorder=3, label=called)


def draw(panels: list[Panel], axes: Any) -> NDArray[np.object_]:
    """Draws panels below each other, on these axes or on new ones; gives the axes."""
    if not panels:
        raise ValueError("states: none, and no measurements; a plot needs one of either")
    drawn = stacked(len(panels), axes)
    for panel, axis in zip(panels, drawn, strict=True):
        panel.draw(axis)
    # Above a panel it covers nothing; axes of somebody else may have a title there.
    legends(drawn, {"loc": "best"} if axes is not None else {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "ncols": 5})
    finish(drawn, panels[0].across)
    return drawn


def stacked(count: int, axes: Any) -> NDArray[np.object_]:
    """So many axes below each other: those that are given, or those of a new figure."""
    if axes is None:
        pyplot = module("matplotlib.pyplot", "plot")
        size = (8.0, 0.8 + 2.1 * count)
        figure, axes = pyplot.subplots(count, 1, sharex=True, squeeze=False, figsize=size, layout="constrained")
        figure.align_ylabels(axes)
        for axis in np.ravel(axes):
            axis.spines[["top", "right"]].set_visible(False)
    given: NDArray[np.object_] = np.ravel(axes)
    if len(given) != count:
        raise ValueError(f"axes: {len(given)}; there must be one for each of {count} panels")
    return given


def legends(axes: NDArray[np.object_], place: dict[str, Any]) -> None:
    """A legend for each panel that shows what no panel above it does."""
    known: set[str] = set()
    for axis in axes:
        labels = set(axis.get_legend_handles_labels()[1])
        if labels - known:
            axis.legend(frameon=False, fontsize="small", **place)
        known |= labels


def finish(axes: NDArray[np.object_], across: Times) -> None:
    """Names the axis of time, and writes dates on it as briefly as they can be told apart."""
    axes[-1].set_xlabel(across.name)
    if across.are_dates:
        dates = module("matplotlib.dates", "plot")
        for axis in axes:
            locator = dates.AutoDateLocator()
            axis.xaxis.set_major_locator(locator)
            axis.xaxis.set_major_formatter(dates.ConciseDateFormatter(locator))


def shown(argument: str, asked: Sequence[str] | None, names: list[str], is_default: bool) -> list[int]:
    """The numbers of the coordinates that are drawn: those that are asked for by name, or all by default."""
    if asked is None:
        return list(range(len(names))) if is_default else []
    for name in asked:
        if name not in names:
            raise ValueError(f"{argument}: {name}; it must be one of {', '.join(names)}")
    return [names.index(name) for name in asked]


def simulated_panels(drawn: Simulated, series: int | None, axes: Any) -> NDArray[np.object_]:
    """Draws simulated states as lines, and measurements as points; those of all series if None."""
    count = len(drawn.states)
    if series is not None and not 0 <= series < count:
        raise ValueError(f"series: {series}; there are {count}")
    numbers = range(count) if series is None else [series]
    # Where many lie over each other, each is fainter.
    faint = max(0.1, 1.0 / np.sqrt(len(numbers)))
    states, measured = drawn._names
    panels = stacked(len(states) + len(measured), axes)
    for at, (name, axis) in enumerate(zip([*states, *measured], panels, strict=True)):
        for number in numbers:
            across = drawn.time[number]
            if at < len(states):
                axis.plot(across, drawn.states[number, :, at], color="C0", alpha=faint, linewidth=1.2)
            else:
                draw_points(axis, across, drawn.measurements[number, :, at - len(states)], None, faint)
        axis.set_ylabel(name)
    panels[-1].set_xlabel(drawn._columns[1])
    return panels
