"""What is warned with."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path


class MotesWarning(UserWarning):
    """A result that cannot be trusted, and what to do."""


def warn(text: str) -> None:
    """Warns whoever called this package."""
    here, depth, frame = Path(__file__).parent, 1, sys._getframe()
    while frame.f_back is not None and here in Path(frame.f_code.co_filename).parents:
        frame, depth = frame.f_back, depth + 1
    warnings.warn(text, MotesWarning, stacklevel=depth)
