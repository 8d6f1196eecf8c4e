"""The package is typed: mypy finds nothing in it, and knows what is returned."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import motes

pytest.importorskip("mypy")

CODE = """
import numpy as np
import motes

model = motes.Model("x.toml")
filtered = model.filter([0.1], seed=np.random.default_rng(1), defensive=None)
reveal_type(filtered)
reveal_type(filtered.mean)
reveal_type(filtered.residuals)
reveal_type(model.log_evidence([0.1]))
reveal_type(model.log_evidence([0.1], {"q": [1.0]}))
reveal_type(model.fit([0.1]).draws)
reveal_type(model.fit([0.1], method="maximum").estimates["q"].low)
reveal_type(model.filter([0.1], quantiles=[0.5], keep_particles=True).expectation(np.exp))
reveal_type(model.simulate(3).states)
reveal_type(motes.Model.parse("x"))
settings: motes.FilterSettings = {"particles": 3}
reveal_type(model.forecast([0.1], 2, **settings).sd)
model.filter([0.1], particels=3)
model.filter([0.1], particles="3")
model.fit([0.1], method="maximum", draws=100)
"""


def mypy(*arguments, folder):
    # Nothing else that is installed has a say in what is found.
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", folder / "cache", "--config-file", folder / "mypy.ini"]
    done = subprocess.run([*command, *arguments], capture_output=True, text=True, cwd=folder)
    return done.stdout


@pytest.fixture
def folder(tmp_path):
    libraries = ("arviz", "jax", "matplotlib", "pandas", "polars", "xarray")
    sections = "".join(f"[mypy-{name}.*]\nfollow_imports = skip\nignore_missing_imports = True\n" for name in libraries)
    (tmp_path / "mypy.ini").write_text(f"[mypy]\nmypy_path = {Path(motes.__file__).parents[1]}\n{sections}")
    return tmp_path


def test_the_package_is_typed(folder):
    said = mypy("-p", "motes", folder=folder)
    assert said.startswith("Success: no issues found"), said
    (folder / "uses.py").write_text(CODE)
    lines = [line.partition(": ")[2] for line in mypy("uses.py", folder=folder).splitlines()]
    revealed = [line.removeprefix('note: Revealed type is "').rstrip('"') for line in lines if "Revealed" in line]
    # Versions of NumPy write it in different ways.
    array = r"numpy\.ndarray\[.*numpy\.dtype\[numpy\.float[^\]]*\]\]"
    assert [re.sub(array, "array", one).replace("builtins.", "") for one in revealed] == [
        "motes.results.Filtered",
        "array",
        "array",
        "float",
        "array",
        "dict[str, array]",
        "float | None",
        "array",
        "array",
        "motes.model.Model",
        "array",
    ]
    errors = [line for line in lines if line.startswith("error")]
    assert len(errors) == 3 and '"particels"' in errors[0] and 'expected "int"' in errors[1], errors
    assert 'No overload variant of "fit"' in errors[2], errors
