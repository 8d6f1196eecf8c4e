"""Bootstrap filters of the growth model, beside `particles` 0.4: `python benchmarks/beside_particles.py`

The model is numpy functions there, those of crates/formulas/benches/growth_particles.py. Here it is a file of formulas, and
the same functions. Both resample systematically below K/2. They take turns, and medians are compared. The last line is what
the way through Python costs.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

import motes

ROOT = Path(__file__).resolve().parents[3]
ROUNDS, TIMES = 9, 200


def of_particles(y: np.ndarray, count: int) -> float:
    """Millions of particle-steps a second of `particles`, which does not count what it compiles."""
    script = ROOT / "crates/formulas/benches/growth_particles.py"
    data = ",".join(map(repr, y[:, 0].tolist()))
    ran = subprocess.run([sys.executable, script, str(count), data], capture_output=True, text=True, check=True)
    return float(ran.stdout.split()[0])


def ours(model: motes.Model, y: np.ndarray, count: int, threads: int) -> float:
    """The same of a call from Python."""
    start = time.perf_counter()
    model.filter(y, particles=count, threads=threads, check=False)
    return count * len(y) / (time.perf_counter() - start) / 1e6


def in_functions() -> motes.Model:
    """The functions of growth_particles.py."""
    return motes.of_functions(
        [motes.normal(0.0, np.sqrt(5))],
        lambda step, x: [motes.normal(x[:, 0] / 2 + 25 * x[:, 0] / (1 + x[:, 0] ** 2) + 8 * np.cos(1.2 * step.time), np.sqrt(10))],
        lambda step, x: [motes.normal(x[:, 0] ** 2 / 20, 1.0)],
        states=["x"],
        measurements=["y"],
    )


def main() -> None:
    model, functions = motes.Model(ROOT / "examples/growth.toml"), in_functions()
    y = model.simulate(TIMES, seed=1).measurements[0]
    for count in (1_000, 100_000):
        # The first call does not count.
        ours(model, y, count, 2)
        runs = [(model, 1), (model, 2), (functions, 1), (functions, 2)]
        turns = [(of_particles(y, count), *(ours(which, y, count, threads) for which, threads in runs)) for _ in range(ROUNDS)]
        theirs, *medians = (statistics.median(column) for column in zip(*turns, strict=True))
        print(f"K = {count}: millions of particle-steps a second, and times particles")
        print(f"  particles {theirs:.1f}")
        for at, name in ((0, "a file"), (2, "functions")):
            one, two = medians[at : at + 2]
            print(f"  {name}, 1 thread {one:.1f} ({one / theirs:.1f}), 2 threads {two:.1f} ({two / theirs:.1f})")
    bridge(model, y)


def bridge(model: motes.Model, y: np.ndarray) -> None:
    """What a call takes beside the filter itself, which is timed within it."""
    whole, within = [], []
    for _ in range(200):
        start = time.perf_counter()
        found = model.filter(y, particles=1_000, threads=1, check=False)
        _ = found.mean, found.ess
        whole.append(time.perf_counter() - start)
        within.append(found.seconds)
    share = 1 - statistics.median(within) / statistics.median(whole)
    print(f"the way through Python: {100 * share:.1f} % of a call with K = 1000")


if __name__ == "__main__":
    main()
