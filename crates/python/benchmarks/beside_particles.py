"""Bootstrap filters of the growth model, beside `particles` 0.4: `python benchmarks/beside_particles.py`

The model is a file of formulas here and numpy functions there, those of crates/formulas/benches/growth_particles.py. Both
resample systematically below K/2. They take turns, and medians are compared. The last line is what the way through Python
costs.
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


def main() -> None:
    model = motes.Model(ROOT / "examples/growth.toml")
    y = model.simulate(TIMES, seed=1).measurements[0]
    for count in (1_000, 100_000):
        # The first call does not count.
        ours(model, y, count, 2)
        turns = [(of_particles(y, count), ours(model, y, count, 1), ours(model, y, count, 2)) for _ in range(ROUNDS)]
        theirs, one, two = (statistics.median(column) for column in zip(*turns, strict=True))
        print(f"K = {count}: millions of particle-steps a second, and times particles")
        print(f"  particles {theirs:.1f}")
        print(f"  motes, 1 thread {one:.1f} ({one / theirs:.1f}), 2 threads {two:.1f} ({two / theirs:.1f})")
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
