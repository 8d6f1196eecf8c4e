"""Warnings of many series are collected by kind."""

import re
import warnings
from pathlib import Path

import numpy as np
import pytest

import motes
from motes._kinds import KINDS, collected

WALK = motes.Model(
    {"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, 0.3)"}, "measurement": {"y": "normal(x, 0.3)"}}
)


def with_outliers(count, where):
    """Series of which those in `where` have an outlier."""
    y = WALK.simulate(12, count, seed=1).measurements.copy()
    y[where, 6] += 30
    return {"series": np.repeat([f"s{number}" for number in range(count)], 12), "y": y.reshape(-1)}


def said_by(call):
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        found = call()
    assert all(one.category is motes.MotesWarning and one.filename == __file__ for one in said)
    return found, [str(one.message) for one in said]


def test_each_kind_is_warned_of_once():
    data = with_outliers(60, slice(2, None))
    found, said = said_by(lambda: WALK.filter(data, particles=200))
    assert len(found.warnings) > 3 * 58 and len(said) < 8
    (outliers,) = [line for line in said if "beyond all particles" in line]
    assert outliers.startswith("58 of 60 series: a measurement lies beyond all particles; the first is s2: at t = 6 (y = ")
    # The words of the first series stand there as they are.
    first = next(line for line in found.warnings if "beyond all particles" in line)
    assert first.startswith("series s2: ") and outliers.endswith(first.removeprefix("series "))
    assert said == found.collected_warnings
    for text in (repr(found), found._repr_html_()):
        assert text.count("warning: ") == len(said) and text.count("\n") < 20
    assert len(found.to_json()["warnings"]) == len(found.warnings)


def test_smoothers_and_forecasts_warn_likewise():
    data = with_outliers(20, slice(None))
    for call in (lambda: WALK.smooth(data, particles=100), lambda: WALK.forecast(data, 2, particles=100)):
        _, said = said_by(call)
        assert any(
            line.startswith("20 of 20 series: a measurement lies beyond all particles; the first is s0: ") for line in said
        )
        assert len(said) < 10


def test_a_single_series_keeps_its_words():
    found, said = said_by(lambda: WALK.filter(with_outliers(20, slice(4, 5)), particles=200))
    (outlier,) = [line for line in said if "beyond all particles" in line]
    assert outlier.startswith("series s4: at t = 6 (y = ") and outlier in found.warnings
    y = with_outliers(1, slice(None))["y"]
    found, said = said_by(lambda: WALK.filter(y, particles=200))
    assert said == found.warnings and all(line.startswith(("at t = ", "the log-evidence", "state x")) for line in said)


def test_series_are_counted_and_not_lines():
    names = ["a", "b: c", "d"]
    texts = [
        "series a: state x hardly moves by itself, and so on",
        "series a: state z hardly moves by itself, and so on",
        "series b: c: state x hardly moves by itself, and so on",
        "the step of [time] is long",
    ]
    kind = KINDS["hardly moves by itself"]
    line = f"2 of 3 series: {kind}; the first is a: state x hardly moves by itself, and so on"
    assert collected(texts, names) == [line, texts[3]]
    assert collected(texts[:2], names) == texts[:2]
    assert collected(["the same"] * 2, None) == ["the same"] * 2


def test_a_kind_that_is_not_known_is_known_by_its_words():
    texts = [f"series {name}: at t = {t} (y = {t}.5) a thing is {t} wide" for name, t in (("a", 3), ("b", 14))]
    assert collected(texts, ["a", "b", "c"]) == ["2 of 3 series; the first is a: at t = 3 (y = 3.5) a thing is 3 wide"]
    other = "series c: at t = 3 (y = 3.5) another thing is 3 wide"
    assert collected([*texts, other], ["a", "b", "c"])[1] == other


def test_many_series_have_their_thousands_apart():
    names = [f"s{number}" for number in range(2000)]
    texts = [f"series {name}: from t = 3 on the filter misses mass: much" for name in names[4:]]
    assert collected(texts, names)[0].startswith("1,996 of 2,000 series: the filter misses mass; the first is s4: from t = 3 on")


def test_kinds_are_known_by_words_that_are_still_said():
    crates = Path(__file__).resolve().parents[2]
    if not (crates / "motes/src").is_dir():
        pytest.skip("the core's source is not here")
    texts = [path.read_text() for crate in ("motes", "smc") for path in (crates / crate / "src").rglob("*.rs")]
    # A text goes on over the lines of its source.
    said = "\n".join(re.sub(r"\\\n\s*", "", text) for text in texts)
    assert [words for words in KINDS if words not in said] == []
