"""Error of the log-evidence and time of designed and learned proposals on simulated sequences: the table of docs/look-ahead.md.

`python3 compare.py MOTES [RUNS]`, where MOTES is the program; it writes table.md beside itself. It needs nothing but Python's standard library."""

import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
PARTICLES = 100
SERIES = 10
MODELS = [
    ("growth", "examples/growth.toml", 100),
    ("volatility", "examples/volatility.toml", 1000),
    ("whisker counts", "experiments/models/whiskers/model.toml", 3000),
    ("range and bearing", "examples/tracking.toml", 50),
    ("Ricker", "examples/ricker.toml", 50),
    ("Lorenz 96, N = 10", "examples/lorenz96.toml", 50),
    ("bounded noise", "examples/bounded.toml", 100),
]
DESIGNED = ["bootstrap", "linearised", "look-ahead"]


def motes(program, *arguments):
    found = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, check=False)
    if found.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, arguments))}: {found.stderr.strip()}")
    return found.stdout


def figures(program, model, data, proposal, runs):
    """The log-evidence of each sequence, the variance of a run, and the milliseconds of a run of one sequence, smoothers and networks included."""
    asked = ["--proposal", proposal, "--particles", PARTICLES, "--runs", runs, "--threads", 1, "--json", "--quiet"]
    try:
        found = json.loads(motes(program, "evidence", model, data, *asked))
    except RuntimeError:
        return None
    variance = found["variance_per_run"]
    if variance is None or None in found["log_evidence_per_series"]:
        return None
    return found["log_evidence_per_series"], variance / SERIES, 1000 * found["seconds"] / runs / SERIES


def errors(found):
    """The root-mean-square error of log ẑ of each proposal, and its milliseconds. The reference of a sequence is the largest of the log-evidences: that of the mean over runs is too low in
    the mean, by more the more it varies."""
    there = [figures for figures in found.values() if figures]
    reference = [max(logs) for logs in zip(*(logs for logs, _, _ in there))]
    of = {}
    for proposal, figures in found.items():
        if figures:
            logs, variance, milliseconds = figures
            bias = sum((log - best) ** 2 for log, best in zip(logs, reference)) / SERIES
            of[proposal] = math.sqrt(variance + bias), milliseconds
    return of


def number(value):
    return f"{value:.3g}" if value < 1e4 else f"{value:.1e}"


def main():
    program = sys.argv[1]
    runs = int(sys.argv[2]) if len(sys.argv) > 2 else 20
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name, model, steps in MODELS:
            model, data, learned = ROOT / model, Path(folder) / "data.csv", Path(folder) / "learned"
            motes(program, "simulate", model, "--steps", steps, "--series", SERIES, "--seed", 7, "-o", data, "--quiet")
            motes(program, "learn", model, "-o", learned, "--sequences", 0, "--quiet")
            found = {p: figures(program, model, data, p, runs) for p in [*DESIGNED, learned]}
            of = errors(found)
            cells = [f"{number(of[p][0])} ({of[p][1]:.1f})" if p in of else "–" for p in found]
            cost = {p: error * error * milliseconds for p, (error, milliseconds) in of.items()}
            best = min((p for p in DESIGNED if p in cost), key=cost.get)
            gain = f"{number(cost[best] / cost[learned])} (`{best}`)" if learned in cost else "–"
            rows.append([f"{name}, T = {steps}", *cells, gain])
            print(rows[-1], file=sys.stderr)
    header = ["", *(f"`{p}`" for p in DESIGNED), "learned", "gain over the best designed"]
    lines = [header, ["---"] + ["--:"] * 5, *rows]
    text = "".join("| " + " | ".join(line) + " |\n" for line in lines)
    (HERE / "table.md").write_text(text, encoding="utf-8")
    print(text, end="")


if __name__ == "__main__":
    main()
