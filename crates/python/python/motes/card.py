"""The report card of proposals."""

from __future__ import annotations

import json
from functools import cached_property
from typing import Any, cast

from . import _motes
from ._display import preformatted
from ._optional import module


class Card:
    """Proposals side by side: effective particles, errors against a reference, coverage, and error at equal time."""

    def __init__(self, found: _motes.Card):
        self._found = found

    @cached_property
    def figures(self) -> dict[str, Any]:
        """All figures, as the command prints them with `--json`."""
        return cast("dict[str, Any]", json.loads(self._found.json()))

    @property
    def methods(self) -> dict[str, dict[str, Any]]:
        """The figures of each proposal by its name."""
        return cast("dict[str, dict[str, Any]]", self.figures["methods"])

    def to_pandas(self) -> Any:
        """A data frame of pandas with a row for each proposal."""
        pandas = module("pandas", "to_pandas")
        of = {name: {key: value for key, value in found.items() if key != "half_widths"} for name, found in self.methods.items()}
        return pandas.DataFrame.from_dict(of, orient="index")

    def to_html(self, path: Any = None) -> str:
        """The card with its figure, one HTML page that needs nothing else; written to `path` if there is one."""
        page = self._found.html()
        if path is not None:
            _motes.write(path, page)
        return page

    def __repr__(self) -> str:
        return self._found.text().rstrip()

    def _repr_html_(self) -> str:
        return preformatted(self._found.text())
