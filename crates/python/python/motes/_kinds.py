"""Warnings of many series, collected by kind."""

from __future__ import annotations

import re

#: Words that a kind of warning is known by, and what it says of any series.
KINDS = {
    "has more than half of the weight": "at a step one particle has more than half of the weight",
    "the weights have a tail index": "the weights of a step have a tail index (Pareto k) above 0.7",
    "the measurement lies beyond all particles": "a measurement lies beyond all particles",
    "the log-evidence has a standard error of": "the log-evidence has a large standard error",
    "the log-evidence is off by": "the log-evidence is off from the exact one",
    "hardly moves by itself": "the values of a state that hardly moves descend from few particles",
    "on the filter misses mass": "the filter misses mass",
    "paths pass through fewer than": "all paths pass through few particles",
    "forecasts of measurements that need the input": "forecasts need an input that is not known ahead",
}


def collected(warnings: list[str], names: list[str] | None) -> list[str]:
    """The warnings, but one alone of those of a kind that several of the series `names` have: how many do, and what it says of the
    first."""
    found: dict[str, list[tuple[str | None, str]]] = {}
    known = set(names or [])
    for warning in warnings:
        series, text = _parts(warning, known)
        found.setdefault(warning if series is None else _kind(text), []).append((series, warning))
    lines: list[str] = []
    for kind, of_kind in found.items():
        count, (first, line) = len({series for series, _ in of_kind}), of_kind[0]
        if first is None or count == 1:
            lines.extend(warning for _, warning in of_kind)
        else:
            said = f": {KINDS[kind]}" if kind in KINDS else ""
            lines.append(f"{count:,} of {len(known):,} series{said}; the first is {line.removeprefix('series ')}")
    return lines


def _parts(warning: str, names: set[str]) -> tuple[str | None, str]:
    """The series that a warning is about, and what it says; None where it is about no series of these names."""
    if warning.startswith("series "):
        # A name may have a colon of its own.
        for colon in re.finditer(": ", warning):
            name = warning[len("series ") : colon.start()]
            if name in names:
                return name, warning[colon.end() :]
    return None, warning


def _kind(text: str) -> str:
    """The words that its kind is known by; of no known kind, those that are left without numbers and what stands in brackets."""
    for words in KINDS:
        if words in text:
            return words
    return re.sub(r"\d+", "#", re.sub(r"\([^()]*\)", "", text))
