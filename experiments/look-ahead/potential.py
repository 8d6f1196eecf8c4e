"""Draws what a potential is: which states this measurement makes likely, and which all that follow do, in the growth model on a grid.

    python3 experiments/look-ahead/potential.py docs/figures/potential.svg
"""

import sys

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt
import numpy as np

STEPS, AT = 30, 17
GRID = np.linspace(-30, 30, 1201)


def drift(x, t):
    return x / 2 + 25 * x / (1 + x * x) + 8 * np.cos(1.2 * t)


def normal(x, mean, variance):
    return np.exp(-0.5 * (x - mean) ** 2 / variance) / np.sqrt(2 * np.pi * variance)


def simulated(random):
    x, measured = random.normal(0, np.sqrt(10)), []
    for t in range(STEPS):
        if t > 0:
            x = drift(x, t) + random.normal(0, np.sqrt(10))
        measured.append(x * x / 20 + random.normal())
    return measured


def main(path):
    y = simulated(np.random.default_rng(4))
    width = GRID[1] - GRID[0]
    # moves[t][i, j]: the density of grid point j at t from point i before.
    moves = [None] + [normal(GRID[None, :], drift(GRID, t)[:, None], 10.0) for t in range(1, STEPS)]
    likelihood = [normal(value, GRID**2 / 20, 1.0) for value in y]
    predicted = normal(GRID, 0.0, 10.0)
    for t in range(AT):
        filtered = predicted * likelihood[t]
        predicted = (filtered / filtered.sum()) @ moves[t + 1]
    ahead = likelihood[STEPS - 1]
    for t in range(STEPS - 1, AT, -1):
        ahead = likelihood[t - 1] * (moves[t] @ ahead)
        ahead /= ahead.max()
    plt.rcParams.update({"font.size": 11, "svg.fonttype": "none", "svg.hashsalt": "potential"})
    figure, axis = plt.subplots(figsize=(7.2, 3.0), constrained_layout=True)
    curves = [
        (predicted, "#999999", "predicted: $p(x_t \\mid y_{0:t-1})$"),
        (likelihood[AT], "#0072b2", "now: $p(y_t \\mid x_t)$"),
        (ahead, "#d55e00", "ahead: $p(y_{t:T} \\mid x_t)$"),
    ]
    for values, colour, label in curves:
        scaled = values / (values.sum() * width)
        axis.plot(GRID, scaled, color=colour, label=label, linewidth=1.8)
    axis.set_xlim(-25, 25)
    axis.set_ylim(bottom=0)
    axis.set_xlabel("state $x_t$")
    axis.set_yticks([])
    axis.spines[["left", "top", "right"]].set_visible(False)
    axis.legend(frameon=False, loc="upper right")
    figure.savefig(path, metadata={"Date": None})


main(sys.argv[1])
