"""Bootstrap filters of the growth model, beside `particles` 0.4: `python benchmarks/beside_particles.py`

The model is a file of formulas here and numpy functions there. Both resample systematically below K/2. They take turns,
and the medians of their times are compared. The last line is what the way through Python costs.
"""

from __future__ import annotations

import statistics
import time
from pathlib import Path

import numpy as np
import particles
from particles import distributions as dists
from particles import state_space_models as ssm

import motes

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"
ROUNDS, TIMES = 9, 200


class Growth(ssm.StateSpaceModel):
    """The same model for `particles`."""

    def PX0(self):
        return dists.Normal(scale=np.sqrt(5.0))

    def PX(self, t, xp):
        return dists.Normal(loc=xp / 2 + 25 * xp / (1 + xp**2) + 8 * np.cos(1.2 * t), scale=np.sqrt(10.0))

    def PY(self, t, xp, x):
        return dists.Normal(loc=x**2 / 20, scale=1.0)


def median_seconds(ways: dict, rounds: int = ROUNDS) -> dict[str, float]:
    """Medians of the times of some functions that take turns, after one round that does not count."""
    times: dict[str, list[float]] = {name: [] for name in ways}
    for turn in range(rounds + 1):
        for name, way in ways.items():
            start = time.perf_counter()
            way()
            if turn > 0:
                times[name].append(time.perf_counter() - start)
    return {name: statistics.median(found) for name, found in times.items()}


def of_particles(y: np.ndarray, count: int) -> float:
    model = ssm.Bootstrap(ssm=Growth(), data=y[:, 0])
    found = particles.SMC(fk=model, N=count, resampling="systematic", ESSrmin=0.5)
    found.run()
    return found.logLt


def main() -> None:
    model = motes.Model(EXAMPLES / "growth.toml")
    y = model.simulate(TIMES, seed=1).measurements[0]
    for count in (1_000, 100_000):
        ours, theirs = model.filter(y, particles=count, check=False).log_evidence, of_particles(y, count)
        print(f"K = {count}: log-evidence {ours:.1f} and {theirs:.1f}")
        ways = {f"motes, {threads} thread(s)": _filter(model, y, count, threads) for threads in (1, 2)}
        found = median_seconds({**ways, "particles": lambda count=count: of_particles(y, count)}, 3 if count > 10_000 else ROUNDS)
        for name, seconds in found.items():
            rate = count * TIMES / seconds / 1e6
            print(f"  {name}: {rate:.1f} million particle-steps a second, {found['particles'] / seconds:.1f} times particles")
    _bridge(model, y)


def _filter(model: motes.Model, y: np.ndarray, count: int, threads: int):
    return lambda: model.filter(y, particles=count, threads=threads, check=False)


def _bridge(model: motes.Model, y: np.ndarray) -> None:
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
