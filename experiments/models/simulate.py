"""Data of the models whose data no package ships: simulated by `motes` from the model files, with fixed seeds.

`python3 simulate.py MOTES [FOLDER …]`, where MOTES is the program. It needs nothing but Python's standard library."""

import csv
import io
import math
import random
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
SIGHT = 30  # metres, of the robot's laser


def voltages():
    """Both pumps at their operating point of 3 V, with steps at different times; a row each 5 s for half an hour."""
    for row in range(361):
        yield {"time": 5 * row, "v1": 3 + 0.5 * (row // 60 % 2), "v2": 3 - 0.5 * (row // 45 % 2)}


def drive():
    """Once round a circle of 50 m at 3 m/s, and a weaving hand; a row each 0.2 s for 100 s."""
    for row in range(501):
        yield {"time": round(0.2 * row, 1), "speed": 3, "steer": round(0.08 + 0.05 * math.sin(row / 25), 4)}


def nights():
    """120 nights of six seasons of half a year, and errors that depend on the night."""
    stream = random.Random(46)
    days = sorted({365 * season + stream.randrange(180) for season in range(6) for _ in range(21)})
    for day in days:
        yield {"day": round(day + stream.uniform(-0.1, 0.1), 3), "error": round(stream.uniform(0.01, 0.05), 3)}


def surveys():
    """Five years of months, with a few hundred tests each."""
    stream = random.Random(46)
    for month in range(60):
        yield {"day": round(month * 365.25 / 12), "tested": stream.randrange(150, 450)}


def times(name, step, rows):
    return lambda: ({name: round(step * row, 6)} for row in range(rows))


def out_of_sight(row):
    """Empties the cells of landmarks that are too far away."""
    far = [name[6:-1] for name in row if name.startswith("range[") and float(row[name]) > SIGHT]
    return {name: "" if name[-2:-1] in far and "[" in name else cell for name, cell in row.items()}


# Folder, inputs or a number of rows, and the measurements.
MODELS = [
    ("bearings-only", 25, ["bearing"]),
    ("lorenz63", times("time", 0.25, 120), ["x_measured", "y_measured", "z_measured"]),
    ("malaria", surveys, ["positive"]),
    ("nelson-siegel", 348, [f"y[{i}]" for i in range(8)]),
    ("neural-decoding", 100, [f"spikes[{i}]" for i in range(10)]),
    ("quad-tank", voltages, ["y1", "y2"]),
    ("quasar", nights, ["magnitude"]),
    ("robot", drive, [f"{name}[{i}]" for name in ("range", "bearing") for i in range(8)]),
]


def write(path, rows):
    with path.open("w", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


def simulate(motes, folder, source, measurements):
    folder = HERE / folder
    if isinstance(source, int):
        known, options = [{"t": row} for row in range(source)], ["--steps", str(source)]
    else:
        known, inputs = list(source()), folder / "inputs.csv"
        write(inputs, known)
        options = ["--inputs", str(inputs)]
    command = [motes, "simulate", str(folder / "model.toml"), *options, "--seed", "46"]
    drawn = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    drawn = list(csv.DictReader(io.StringIO(drawn)))
    measured = [{name: f"{float(row[name]):.6g}" for name in measurements} for row in drawn]
    rows = [{**first, **row} for first, row in zip(known, measured, strict=True)]
    if folder.name == "robot":
        rows = [out_of_sight(row) for row in rows]
    write(folder / "data.csv", rows)


if __name__ == "__main__":
    motes, *only = sys.argv[1:]
    for model in MODELS:
        if not only or model[0] in only:
            simulate(motes, *model)
            print(model[0])
