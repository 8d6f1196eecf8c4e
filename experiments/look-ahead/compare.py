"""Variance of the log-evidence and time of designed proposals on simulated sequences: the table of docs/look-ahead.md.

`python3 compare.py MOTES [RUNS]`, where MOTES is the program; it writes table.md beside itself. It needs nothing but Python's standard library."""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
PARTICLES = 100
SERIES = 10
MODELS = [
    ("whisker counts", "experiments/models/whiskers/model.toml", 500),
    ("volatility", "examples/volatility.toml", 500),
    ("growth", "examples/growth.toml", 100),
    ("Lorenz 96, N = 10", "examples/lorenz96.toml", 50),
]
PROPOSALS = ["bootstrap", "linearised", "look-ahead"]


def motes(program, *arguments):
    found = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, check=False)
    if found.returncode != 0:
        sys.exit(f"{' '.join(map(str, arguments))}: {found.stderr.strip()}")
    return found.stdout


def figures(program, model, data, proposal, runs):
    """Variance of log ẑ of a sequence, and milliseconds of a run of one, smoothers included."""
    asked = ["--proposal", proposal, "--particles", PARTICLES, "--runs", runs, "--threads", 1, "--json", "--quiet"]
    found = json.loads(motes(program, "evidence", model, data, *asked))
    variance = found["variance_per_run"]
    return (None if variance is None else variance / SERIES), 1000 * found["seconds"] / runs / SERIES


def choice(program, model, data):
    """What pilots choose."""
    asked = ["--particles", PARTICLES, "--runs", 1, "--threads", 1, "--json", "--quiet"]
    return json.loads(motes(program, "evidence", model, data, *asked))["proposal"]


def number(value):
    return f"{value:.3g}" if value < 1e4 else f"{value:.1e}"


def main():
    program = sys.argv[1]
    runs = int(sys.argv[2]) if len(sys.argv) > 2 else 20
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name, model, steps in MODELS:
            model, data = ROOT / model, Path(folder) / "data.csv"
            motes(program, "simulate", model, "--steps", steps, "--series", SERIES, "--seed", 7, "-o", data, "--quiet")
            found = {proposal: figures(program, model, data, proposal, runs) for proposal in PROPOSALS}
            of = lambda proposal: found[proposal][0] * found[proposal][1]
            cells = [f"{number(found[p][0])} ({found[p][1]:.1f})" for p in PROPOSALS]
            gain = number(of("bootstrap") / of("look-ahead"))
            rows.append([f"{name}, T = {steps}", *cells, gain, choice(program, model, data)])
            print(rows[-1], file=sys.stderr)
    header = ["", *(f"`{p}`" for p in PROPOSALS), "gain", "pilots choose"]
    lines = [header, ["---"] + ["--:"] * 4 + ["---"], *rows]
    text = "".join("| " + " | ".join(line) + " |\n" for line in lines)
    (HERE / "table.md").write_text(text, encoding="utf-8")
    print(text, end="")


if __name__ == "__main__":
    main()
