import signal
from pathlib import Path

import pytest

import motes

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"


@pytest.fixture(autouse=True)
def interrupts():
    """SIGINT raises KeyboardInterrupt, also where a shell started the tests in the background and told them to ignore it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def growth():
    return motes.Model(EXAMPLES / "growth.toml")


@pytest.fixture
def nile():
    return motes.Model(EXAMPLES / "nile.toml")


@pytest.fixture
def tracking():
    return motes.Model(EXAMPLES / "tracking.toml")


@pytest.fixture
def examples():
    return EXAMPLES
