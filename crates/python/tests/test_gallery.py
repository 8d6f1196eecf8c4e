"""Scripts of the gallery."""

import subprocess
import sys
from pathlib import Path

import pytest

GALLERY = Path(__file__).resolve().parents[1] / "gallery"


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_many_series_are_the_same_in_several_processes():
    pytest.importorskip("joblib")
    pytest.importorskip("dask.distributed")
    done = subprocess.run([sys.executable, GALLERY / "many_series.py", "16"], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0].startswith("log-evidence of 16 series: ")
    killed = int(lines[1].removeprefix("killed one of two workers with ").partition(" ")[0])
    # It was at work.
    assert 1 <= killed < 16
    assert lines[2] == "the same bytes from one process, joblib and Dask"
