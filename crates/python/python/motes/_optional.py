"""Libraries that only some results need."""

from __future__ import annotations

import importlib
from typing import Any


def module(name: str, wanted_by: str) -> Any:
    """A library, or how to get it, where it is not there."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        library = name.partition(".")[0]
        raise ModuleNotFoundError(f"{wanted_by} needs {library}: pip install {library}") from error
