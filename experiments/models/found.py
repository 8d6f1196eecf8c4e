"""What `motes filter` finds of these models, beside what is right: `python3 found.py MOTES [MODEL…]`, after fetch.py.

Each line has the log-evidence with its standard error, and what is right with that of its own, where it has one."""

import json
import math
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
PARTICLES = ["--particles", "5000"]
EXACT = ["--proposal", "exact"]
RETURNS = ["leverage/model.toml", "../../examples/returns.csv"]

#: Model, options, what is right and its standard error; the files where they are not those of the folder.
MODELS = [
    ("london-measles", PARTICLES, -3801.9, 0.3, None),
    ("dacca-cholera", PARTICLES, -3748.15, 0.3, None),
    ("blowflies", ["--particles", "20000"], -1465.7, 0.2, None),
    ("bsflu", ["--particles", "30000"], -174.0, 1.0, None),
    ("ricker", PARTICLES, -139.05027, 0.0, None),
    ("ricker", [*PARTICLES, "--set", "log_r=3.802", "--set", "sigma=0.192", "--set", "phi=10.20"], -137.17901, 0.0, None),
    ("parus", PARTICLES, -157.23408, 0.0, None),
    ("sir-incidence", PARTICLES, -244.36, 0.04, None),
    ("leverage", PARTICLES, -2149.09344, 0.0, RETURNS),
    ("federal-funds", EXACT, -508.63592, 0.0, None),
    ("arma", EXACT, -135.35131, 0.0, None),
    ("arma", EXACT, -135.35131, 0.0, ["arma/matrices.toml", "arma/data.csv"]),
    ("co2", EXACT, -177.11742, 0.0, None),
    ("seatbelts", EXACT, 202.10439, 0.0, None),
    ("nelson-siegel", EXACT, 908.05672, 0.0, None),
    ("quasar", EXACT, 186.78112, 0.0, None),
    ("fishery", PARTICLES, -68.26981, 0.0, None),
    ("whiskers", PARTICLES, -3103.92404, 0.0, None),
    ("whiskers", [*PARTICLES, "--set", "rho=0.9982", "--set", "var=0.1007"], -3080.21947, 0.0, None),
]


def main():
    motes, wanted = sys.argv[1], sys.argv[2:]
    for name, options, right, error, files in MODELS:
        files = files or [f"{name}/model.toml", f"{name}/data.csv"]
        if (wanted and name not in wanted) or not (HERE / files[1]).exists():
            continue
        command = ["filter", *files, *options]
        done = subprocess.run([motes, *command, "--json", "--quiet"], check=True, capture_output=True, text=True, cwd=HERE)
        found = json.loads(done.stdout)
        own = found["standard_error"] or 0.0
        both = math.hypot(own, error)
        off = f", {abs(found['log_evidence'] - right) / both:.1f} standard errors off" if both > 0 else ""
        print(f"motes {' '.join(command)}: {found['log_evidence']:.5f} ± {own:.2g}, right {right} ± {error}{off}", flush=True)


if __name__ == "__main__":
    main()
