"""What the smoother before a filter that looks ahead costs, in particle-steps of a bootstrap filter: instructions, counted by valgrind.

    cargo build --release -p motes && python experiments/look-ahead/smoother.py target/release/motes

A run of K particles over T steps costs a + T(s + K p) instructions where it looks ahead and a + T K b where it does not; further runs share the
smoother. So b and p follow from two numbers of particles, s from two numbers of runs.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MOTES = sys.argv[1]


def instructions(model, data, proposal, particles, runs):
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", MOTES, "evidence", model, data]
    command += ["--proposal", proposal, "--particles", particles, "--runs", runs, "--threads", 1, "--quiet"]
    said = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=True).stderr
    return int(re.search(r"Collected : (\d+)", said)[1])


def row(name, coordinates, model, data, folder):
    rows = Path(data).read_text().splitlines()[:301]
    short = Path(folder) / "short.csv"
    short.write_text("\n".join(rows) + "\n")
    steps = len(rows) - 1
    few, many = 200, 1200
    plain = [instructions(model, short, "bootstrap", count, 1) for count in (few, many)]
    ahead = [instructions(model, short, "look-ahead", count, 1) for count in (few, many)]
    again = (instructions(model, short, "look-ahead", few, 3) - ahead[0]) / 2
    bootstrap, per_particle = (plain[1] - plain[0]) / (many - few) / steps, (ahead[1] - ahead[0]) / (many - few) / steps
    start = plain[0] - few * bootstrap * steps
    smoother = (ahead[0] - again - start) / steps / bootstrap
    print(f"| {name} | {coordinates} | {bootstrap:.0f} | {per_particle / bootstrap:.1f} | {smoother:.0f} |", flush=True)


def main():
    print("| model | coordinates | instructions of a bootstrap particle | one that looks ahead, in these | smoother, in these |")
    print("|---|--:|--:|--:|--:|")
    fit, models = ROOT / "examples/fit", ROOT / "experiments/models"
    with tempfile.TemporaryDirectory() as folder:
        row("whiskers", 1, models / "whiskers/model.toml", models / "whiskers/data.csv", folder)
        row("pound", 1, fit / "pound.toml", fit / "pound.csv", folder)
        row("ricker", 1, fit / "ricker.toml", fit / "ricker.csv", folder)
        row("bearings-only", 4, models / "bearings-only/model.toml", models / "bearings-only/data.csv", folder)
        for n in (6, 10, 20):
            text = (ROOT / "examples/lorenz96.toml").read_text().replace("[10]", f"[{n}]").replace("y[5]", f"y[{n // 2}]")
            model, data = Path(folder) / f"lorenz{n}.toml", Path(folder) / f"lorenz{n}.csv"
            model.write_text(text)
            data.write_text(subprocess.run([MOTES, "simulate", model, "--steps", "20"], capture_output=True, text=True, check=True).stdout)
            row("lorenz96", n, model, data, folder)


main()
