"""The same model, data and seed give the same bytes here as in the command."""

import json
import os
import subprocess
from pathlib import Path

import pytest

import motes

COMMAND = os.environ.get("MOTES_COMMAND")
pytestmark = pytest.mark.skipif(COMMAND is None, reason="MOTES_COMMAND does not name the command motes")


def run(*arguments):
    return subprocess.run([COMMAND, *map(str, arguments)], capture_output=True, text=True, check=True).stdout


@pytest.mark.parametrize("proposal", ["bootstrap", "linearised"])
@pytest.mark.parametrize("threads", [1, 2])
def test_filter(examples, nile, proposal, threads):
    settings = ["--proposal", proposal, "--particles", "3000", "--seed", "7", "--threads", "2"]
    data = examples / "nile.csv"
    table = run("filter", examples / "nile.toml", data, *settings)
    found = nile.filter(data, proposal=proposal, particles=3000, seed=7, threads=threads)
    assert found.to_csv() == table
    summary = json.loads(run("filter", examples / "nile.toml", data, *settings, "--json"))
    assert found.log_evidence == summary["log_evidence"]
    assert found.ess.mean() == pytest.approx(summary["ess_mean"])


def test_smoother_and_forecast(examples, nile):
    data = examples / "nile.csv"
    table = run("smooth", examples / "nile.toml", data, "--paths", "30")
    assert nile.smooth(data, paths=30).to_csv() == table
    table = run("filter", examples / "nile.toml", data, "--forecast", "5")
    assert nile.forecast(data, 5).filtered.to_csv() == table


def test_a_proposal_goes_from_the_command_to_python_and_back(examples, growth, tmp_path: Path):
    model = examples / "growth.toml"
    run("learn", model, "-o", tmp_path / "p", "--updates", "60", "--sequences", "0", "--seed", "3")
    learned = growth.learn(updates=60, sequences=0, seed=3)
    learned.proposal.save(tmp_path / "q")
    assert (tmp_path / "p/weights.safetensors").read_bytes() == (tmp_path / "q/weights.safetensors").read_bytes()
    run("simulate", model, "--steps", "40", "-o", tmp_path / "d.csv")
    table = run("filter", model, tmp_path / "d.csv", "--proposal", tmp_path / "q", "--particles", "300")
    loaded = motes.Proposal.load(tmp_path / "p", growth)
    assert growth.filter(tmp_path / "d.csv", proposal=loaded, particles=300).to_csv() == table


def test_simulations(examples, growth):
    table = run("simulate", examples / "growth.toml", "--steps", "30", "--series", "2", "--seed", "5")
    rows = [line.split(",") for line in table.splitlines()[1:]]
    drawn = growth.simulate(30, 2, seed=5)
    assert [float(row[2]) for row in rows] == drawn.states.reshape(-1).tolist()
    assert [float(row[3]) for row in rows] == drawn.measurements.reshape(-1).tolist()
