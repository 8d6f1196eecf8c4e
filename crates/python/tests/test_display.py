"""What results look like in a terminal and in a notebook."""

import copy

import numpy as np
import pytest

import motes

WALK = motes.Model(
    {
        "name": "a < b",
        "initial": {"x": "normal(0, 1)", "v": "normal(0, 1)"},
        "transition": {"x": "normal(x, 1)", "v": "normal(v, 1)"},
        "measurement": {"y": "normal(x, 1)"},
    }
)


def rows(text):
    """The rows of a table by their names."""
    return {line.split("  ")[0]: line.split()[1:] for line in text.splitlines()}


def test_a_filter_on_line():
    online = WALK.online(predictive=True, particles=200)
    assert repr(online).startswith("OnlineFilter of a < b after 0 rows: log-evidence 0.000\n")
    online.step(0.3).step(0.7)
    text = repr(online)
    head = f"OnlineFilter of a < b after 2 rows: log-evidence {online.log_evidence:.3f}, effective sample size {online.ess:.0f} of 200"
    assert text.splitlines()[0] == head and text.splitlines()[1] == "mean (2,), quantiles (2, 3)"
    expected = [f"{value:.4g}" for value in (online.mean[1], online.sd[1], online.quantiles[1, 0], online.quantiles[1, 2])]
    assert rows(text)["v"] == expected
    assert f"{online.measurement_mean[0]:.4g}" in text and "y, expected" in text
    assert f"<td>{expected[0]}</td>" in online._repr_html_() and "a &lt; b" in online._repr_html_()
    assert repr(copy.deepcopy(online)) == text and online.rows == 2
    assert repr(online.predict()).startswith("OnlineFilter of a < b after 3 rows: log-evidence")
    assert "expected" not in repr(WALK.online().step(0.3)) and "after 1 row:" in repr(WALK.online().step(0.3))
    with pytest.raises(ValueError):
        edges = motes.Model({"initial": {"x": 0}, "transition": {"x": "x"}, "measurement": {"y": "uniform(x - 1, x + 1)"}})
        failed = edges.online()
        failed.step(9.0)
    assert repr(failed) == "OnlineFilter of model, which failed after 0 rows"


def test_a_forecast():
    found = WALK.forecast({"series": list("aab"), "y": [0.1, 0.2, 0.3]}, 3)
    lines = repr(found).splitlines()
    assert lines[0] == "Forecast of 3 times for 2 series" and lines[1] == "mean (2, 3, 2), measurement_mean (2, 3, 1)"
    assert lines[2] == "the last time of series a, t = 4:"
    assert set(rows(repr(found))) >= {"x", "v", "y"}
    assert rows(repr(found))["y"][0] == f"{found.measurement_mean[0, -1, 0]:.4g}"
    html = found._repr_html_()
    assert html.count("<tr>") == 4 and f"<td>{found.mean[0, -1, 0]:.4g}</td>" in html
    assert "year = 1873:" in repr(WALK.forecast({"year": [1869, 1870, 1871], "y": [0.1, 0.2, 0.3]}, 2))
    dates = np.arange("2024-01-01", "2024-01-05", dtype="datetime64[D]")
    assert "when = 2024-01-06:" in repr(WALK.forecast({"when": dates, "y": np.zeros(4)}, 2))
    assert repr(WALK.forecast([0.1], 0)).splitlines()[0] == "Forecast of 0 times for 1 series"


def test_a_simulation():
    drawn = WALK.simulate(7, 2, seed=3)
    assert repr(drawn).splitlines()[:2] == ["Simulated: 2 series of 7 times", "states (2, 7, 2), measurements (2, 7, 1)"]
    for name, values in (("v", drawn.states[0, :, 1]), ("y", drawn.measurements[0, :, 0])):
        assert rows(repr(drawn))[name] == [f"{values[0]:.4g}", f"{values[-1]:.4g}"]
        assert f"<th>{name}</th>" in drawn._repr_html_()


def test_many_coordinates_are_cut():
    size = 30
    large = motes.linear_gaussian(
        A=np.eye(size), C=np.eye(size)[:1], Q=np.eye(size), R=[[1.0]], m0=np.zeros(size), P0=np.eye(size), measurements=["y"]
    )
    for shown in (large.simulate(3), large.forecast([0.1, 0.2], 2, particles=20), large.online(particles=20).step(0.1)):
        assert len(repr(shown).splitlines()) < 20
        assert "more" in repr(shown).splitlines()[-1] and "more</li>" in shown._repr_html_()


def test_a_filter_says_why_it_has_no_standard_error():
    y = [0.1, 0.2, 0.3]
    assert "log-evidence: " in repr(WALK.filter(y)) and " ± " in repr(WALK.filter(y))
    unasked = repr(WALK.filter(y, check=False)).splitlines()[1]
    assert unasked.startswith("log-evidence: ") and unasked.endswith(" (its standard error was not asked for)")
    assert repr(WALK.smooth(y, paths=5, check=False)).splitlines()[1] == unasked
    assert "(too few particles for a standard error)" in repr(WALK.filter(y, particles=8))
    exact = WALK.filter(y, proposal="exact")
    assert repr(exact).splitlines()[1].endswith(", exact") and repr(copy.copy(exact)) == repr(exact)
    assert "not asked for" in WALK.filter(y, check=False).to_html() and "too few" not in WALK.filter(y, check=False).to_html()
