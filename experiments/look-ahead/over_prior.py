"""At how many draws of a prior looking ahead pays: variance of the log-evidence times seconds of one thread, against the best of `bootstrap` and `linearised`.

    cargo build --release -p motes && python3 experiments/look-ahead/over_prior.py target/release/motes MODEL STEPS DRAWS [FOLDER]

Each draw has parameters of its own from the priors of MODEL, a sequence of STEPS simulated with these, and 20 runs of each proposal with each number of particles. A proposal counts at its best
number. Seconds are those of one run, with all that is computed once for a sequence. FOLDER is one that `learn` wrote. `auto` has 1,000 particles, and its pilots count.
"""

import csv
import io
import json
import statistics
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

MOTES, MODEL, STEPS, DRAWS, *FOLDER = sys.argv[1:]
RUNS = 20
ONE_STEP = {"bootstrap": (100, 1000, 3000), "linearised": (100, 1000, 3000)}
AHEAD = {name: (30, 100, 1000) for name in ("look-ahead", *FOLDER)}


def motes(*arguments):
    return subprocess.run([MOTES, *map(str, arguments)], capture_output=True, text=True)


def evidence(file, parameters, proposal, particles, runs, *more):
    given = [part for name, value in parameters.items() for part in ("--set", f"{name}={value}")]
    said = motes("evidence", MODEL, file, *given, "--proposal", proposal, "--particles", particles,
                 "--runs", runs, "--threads", 1, "--json", *more)
    return json.loads(said.stdout.splitlines()[0]) if said.returncode == 0 else None


def variance_and_seconds(file, parameters, proposal, particles):
    """Of a run; none where a run collapsed or the model does not allow the proposal."""
    many = evidence(file, parameters, proposal, particles, RUNS, "--no-check")
    if many is None or many["variance_per_run"] is None:
        return None
    seconds = [evidence(file, parameters, proposal, particles, 1, "--no-check")["seconds"] for _ in range(3)]
    return many["variance_per_run"], statistics.median(seconds)


def of_draw(seed, folder):
    table = motes("simulate", MODEL, "--steps", STEPS, "--prior", "--seed", seed).stdout
    rows = list(csv.DictReader(io.StringIO(table)))
    model = tomllib.loads(Path(MODEL).read_text())
    measured = list(model["measurement"])
    free = [name for name, value in model["parameters"].items() if isinstance(value, str) and name in rows[0]]
    file = folder / "data.csv"
    file.write_text("\n".join([",".join(measured), *(",".join(row[name] for name in measured) for row in rows)]) + "\n")
    parameters = {name: rows[0][name] for name in free}
    found = {
        name: {k: variance_and_seconds(file, parameters, name, k) for k in counts} for name, counts in (ONE_STEP | AHEAD).items()
    }
    best = {name: min((v * s for v, s in filter(None, at.values())), default=float("inf")) for name, at in found.items()}
    chosen = evidence(file, parameters, "auto", 1000, 1)
    variance, _ = found.get(chosen["proposal"], {}).get(1000) or (float("nan"), None)
    designed = min(best[name] for name in ONE_STEP)
    ratios = {name: designed / best[name] for name in AHEAD}
    ratios["auto"] = min(best[name] for name in (*ONE_STEP, "look-ahead")) / (variance * chosen["seconds"])
    print(seed, {name: f"{float(value):.3g}" for name, value in parameters.items()}, chosen["proposal"],
          {Path(name).name: f"{ratio:.3g}" for name, ratio in ratios.items()}, flush=True)
    return ratios


with tempfile.TemporaryDirectory() as folder:
    all_ratios = [of_draw(seed, Path(folder)) for seed in range(1, int(DRAWS) + 1)]
for name in AHEAD:
    ratios = sorted(each[name] for each in all_ratios)
    share = sum(ratio >= 10 for ratio in ratios) / len(ratios)
    print(f"{Path(name).name}: at least 10 times the best of one step at {share:.0%} of draws; median {statistics.median(ratios):.3g}, least {ratios[0]:.3g}")
ratios = sorted(each["auto"] for each in all_ratios)
share = sum(ratio >= 1 / 1.3 for ratio in ratios) / len(ratios)
print(f"auto, 1,000 particles: at most 1.3 times the best designed at {share:.0%} of draws; median {1 / statistics.median(ratios):.3g} times, most {1 / ratios[0]:.3g}")
