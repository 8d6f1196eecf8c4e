"""How long filters of London measles and of Dacca take, beside those of pypomp, in turns.

`python beside_pypomp.py MOTES [ROUNDS]`, in an environment that has pypomp 1.1.0, after fetch.py. pypomp compiles a filter when it first runs: that run is not
counted. Its gammas and counts come from approximate quantile functions in 32 bits, so evidences may differ."""

import json
import statistics
import subprocess
import sys
import time
from pathlib import Path

import jax
import pypomp
from pypomp.models.measles.uk_measles import UKMeasles

HERE = Path(__file__).parent
PARTICLES = 5000
# The estimate of He, Ionides and King, as in london-measles/model.toml.
LONDON = {
    "R0": 56.8, "sigma": 28.9, "gamma": 30.4, "iota": 2.9, "rho": 0.488, "sigmaSE": 0.0878, "psi": 0.116, "cohort": 0.557,
    "amplitude": 0.554, "mu": 0.02, "alpha": 0.976, "S_0": 0.0297, "E_0": 5.17e-5, "I_0": 5.14e-5, "R_0": 0.97,
}  # fmt: skip


def of_pypomp(model):
    """A filter of pypomp: seconds and log-evidence of each run."""

    def run(seed):
        start = time.perf_counter()
        model.pfilter(J=PARTICLES, key=jax.random.key(seed))
        found = float(model.results()["logLik"].iloc[-1])
        return time.perf_counter() - start, found

    run(0)
    return run


def of_motes(motes, name):
    """A filter of the command, from its start to its end, without the second opinion that others do not have."""

    def run(seed):
        files = [HERE / name / "model.toml", HERE / name / "data.csv"]
        options = ["--particles", str(PARTICLES), "--seed", str(seed), "--no-check", "--json", "-o", "/dev/null"]
        start = time.perf_counter()
        done = subprocess.run([motes, "filter", *files, *options], check=True, capture_output=True, text=True)
        return time.perf_counter() - start, json.loads(done.stdout)["log_evidence"]

    return run


def main():
    motes, rounds = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 5
    london = UKMeasles.pomp("London", pypomp.PompParameters(LONDON), model="001", interp_method="linear")
    for name, model in [("london-measles", london), ("dacca-cholera", pypomp.models.dhaka())]:
        runs = {"motes": of_motes(motes, name), "pypomp": of_pypomp(model)}
        found = {who: [] for who in runs}
        for seed in range(1, rounds + 1):
            for who, run in runs.items():
                found[who].append(run(seed))
        for who, results in found.items():
            seconds, evidences = zip(*results)
            print(f"{name}, {who}: {statistics.median(seconds):.2f} s ({min(seconds):.2f} to {max(seconds):.2f}), "
                  f"log-evidence {statistics.mean(evidences):.1f}")
        ratios = [theirs[0] / ours[0] for ours, theirs in zip(found["motes"], found["pypomp"])]
        print(f"{name}: pypomp takes {statistics.median(ratios):.1f} times as long ({min(ratios):.1f} to {max(ratios):.1f})")


if __name__ == "__main__":
    main()
