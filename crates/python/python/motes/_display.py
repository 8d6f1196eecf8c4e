"""How results are shown in a terminal and in a notebook."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

#: So many coordinates have a row each; of more, the first have.
MOST_ROWS = 12


def escaped(text: str) -> str:
    """A text within HTML."""
    return text.replace("&", "&amp;").replace("<", "&lt;")


def preformatted(text: str) -> str:
    """A text as it is, in HTML."""
    return f"<pre>{escaped(text)}</pre>"


@dataclass
class Display:
    """A line that says what it is, more lines, and a table with a row of figures for each coordinate."""

    head: str
    lines: Sequence[str] = ()
    columns: Sequence[str] = ()
    rows: list[tuple[str, list[str]]] = field(default_factory=list)

    def add(self, names: Sequence[str], *columns: NDArray[np.float64]) -> None:
        """Adds a row for each name, with its entry of each column."""
        self.rows.extend((name, [f"{value:.4g}" for value in values]) for name, *values in zip(names, *columns, strict=True))

    def text(self) -> str:
        """All of it for a terminal, with aligned columns."""
        cells = [["", *self.columns], *([name, *figures] for name, figures in self.rows[:MOST_ROWS])] if self.rows else []
        widths = [max(len(row[at]) for row in cells) for at in range(len(self.columns) + 1)] if cells else []
        table = [
            "  ".join([row[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True))])
            for row in cells
        ]
        return "\n".join([self.head, *self.lines, *(line.rstrip() for line in table), *self._more()])

    def html(self) -> str:
        """All of it for a notebook."""
        lines = "".join(f"<li>{escaped(line)}</li>" for line in [*self.lines, *self._more()])
        listed = f"<ul>{lines}</ul>" if lines else ""
        if not self.rows:
            return f"<b>{escaped(self.head)}</b>{listed}"
        header = "".join(f"<th>{escaped(column)}</th>" for column in ["", *self.columns])
        body = "".join(
            f"<tr><th>{escaped(name)}</th>{''.join(f'<td>{figure}</td>' for figure in figures)}</tr>"
            for name, figures in self.rows[:MOST_ROWS]
        )
        table = f"<table><thead><tr>{header}</tr></thead><tbody>{body}</tbody></table>"
        return f"<b>{escaped(self.head)}</b>{listed}{table}"

    def _more(self) -> list[str]:
        more = len(self.rows) - MOST_ROWS
        return [f"and {more} more"] if more > 0 else []


def shapes(**arrays: NDArray[np.float64]) -> str:
    """Arrays by name with their shapes: `states (3, 50, 1), measurements (3, 50, 1)`."""
    return ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
