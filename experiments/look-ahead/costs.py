"""What proposals cost in particles of a bootstrap filter: instructions, counted by valgrind. `motes` chooses and judges proposals by these (`crates/motes/src/evidence/cost.rs`).

    cargo build --release -p motes && python3 experiments/look-ahead/costs.py target/release/motes

A run of K particles over T steps costs a + T(s + K p) instructions; further runs share what is computed once for a sequence. So p follows from two numbers of particles, and s, which is
a smoother or the networks of a sequence, from two numbers of steps. A filter with what was learned has both again: `now`, and of the growth model `per particle`. `–` stands where
a folder hands out a designed proposal.
"""

import re
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MOTES = sys.argv[1]
MODELS = sys.argv[2:] or ["growth", "ricker", "volatility", "bounded", "tracking", "influenza_flows", "lorenz96"]
TITLES = ["linearised", "look-ahead", "ahead", "now"]
FEW, MANY = 96, 288
SHORT, LONG = 30, 60
ONE_RUN = ("--runs", 1, "--no-check")


def motes(*arguments):
    return subprocess.run([MOTES, *map(str, arguments)], capture_output=True, text=True, check=True).stdout


def instructions(command, model, data, proposal, particles, *more):
    counted = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", MOTES, command, model, data]
    counted += ["--proposal", proposal, "--particles", particles, "--threads", 1, "--quiet", "-o", "/dev/null", *more]
    said = subprocess.run(list(map(str, counted)), capture_output=True, text=True, check=True).stderr
    return int(re.search(r"Collected : (\d+)", said)[1])


def cost(command, model, data, proposal, more):
    """Instructions of a particle at a step, and of a step beside its particles."""
    at = lambda steps, particles: instructions(command, model, data[steps], proposal, particles, *more)
    few, many, longer = at(SHORT, FEW), at(SHORT, MANY), at(LONG, FEW)
    particle = (many - few) / (MANY - FEW) / SHORT
    return particle, (longer - few) / (LONG - SHORT) - FEW * particle


def simulated(model, folder):
    data = {steps: folder / f"{model.stem}-{steps}.csv" for steps in (SHORT, LONG)}
    for steps, file in data.items():
        motes("simulate", model, "--steps", steps, "--seed", 7, "-o", file, "--quiet")
    return data


def row(name, folder):
    model, learned = ROOT / f"examples/{name}.toml", folder / name
    data = simulated(model, folder)
    said = subprocess.run([MOTES, "learn", model, "-o", learned, "--sequences", "0"], capture_output=True, text=True, check=True).stderr
    plain, of_step = cost("evidence", model, data, "bootstrap", ONE_RUN)
    found = {}
    looked_at = [("linearised", "linearised"), ("look-ahead", "look-ahead")]
    # Where these are worse, a folder hands out something else, whose cost is that of others.
    if "potentials of a smoother have less error" not in said:
        looked_at.append(("ahead", learned))
    for title, proposal in looked_at:
        particle, step = cost("evidence", model, data, proposal, ONE_RUN)
        found[title] = particle / plain, (step - of_step) / plain
    if "filters draw by potentials of their step" in said:
        # Filters have estimates, which evidence has not.
        filtered, of_filter = cost("filter", model, data, "bootstrap", ("--no-check",))
        particle, step = cost("filter", model, data, learned, ("--no-check",))
        found["now"] = 1 + (particle - filtered) / plain, (step - of_filter) / plain
    print(f"| {name} | {plain:.0f} | {cells(found)} |", flush=True)
    return found


def cells(found):
    pair = lambda title: "{:.1f} + {:.0f}".format(*found[title]) if title in found else "–"
    return " | ".join(map(pair, TITLES))


def per_particle(folder):
    """A filter with a network for each particle, which a head that is asked for has."""
    model, learned = ROOT / "examples/growth.toml", folder / "network"
    data = simulated(model, folder)
    motes("learn", model, "-o", learned, "--updates", 20, "--sequences", 0, "--head", "mixture", "--quiet")
    plain, _ = cost("evidence", model, data, "bootstrap", ONE_RUN)
    filtered, _ = cost("filter", model, data, "bootstrap", ("--no-check",))
    particle, _ = cost("filter", model, data, learned, ("--no-check",))
    return 1 + (particle - filtered) / plain


def main():
    print("| model | instructions of a bootstrap particle | linearised: a particle + a step, in these | look-ahead | learned, ahead | learned, now |")
    print("|---|--:|--:|--:|--:|--:|")
    with tempfile.TemporaryDirectory() as folder:
        rows = [row(name, Path(folder)) for name in MODELS]
        of = lambda title: [found[title] for found in rows if title in found]
        middle = {title: [statistics.median(pair[at] for pair in of(title)) for at in (0, 1)] for title in TITLES if of(title)}
        print(f"| median | | {cells(middle)} |")
        print(f"\nA network for each particle, growth: {per_particle(Path(folder)):.0f}")


main()
