"""Plots: which panels there are, and what is drawn in them."""

import datetime

import numpy as np
import pytest

import motes

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402

WALK = motes.Model(
    {"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, 1)"}, "measurement": {"y": "normal(2*x, 1)"}}
)
TWO = motes.Model(
    {
        "initial": {"x": "normal(0, 1)", "v": "normal(0, 1)"},
        "transition": {"x": "normal(x, 1)", "v": "normal(v, 1)"},
        "measurement": {"y": "normal(x, 1)", "z": "normal(v, 1)"},
    }
)
Y = [0.1, 0.2, None, 0.4, 0.3]


@pytest.fixture(autouse=True)
def closed():
    yield
    plt.close("all")


def names(axes):
    return [axis.get_ylabel() for axis in axes]


def points(axis):
    """What is drawn as points, by place."""
    (line,) = [line for line in axis.get_lines() if line.get_marker() == "o"]
    return line.get_xdata(), line.get_ydata()


def labels(axis):
    axis.figure.canvas.draw()
    return [label.get_text() for label in axis.get_xticklabels()]


def test_measurements_have_panels_where_they_were_predicted():
    y = TWO.simulate(6, seed=1).measurements[0]
    plain, predictive = TWO.filter(y), TWO.filter(y, predictive=True)
    assert names(plain.plot()) == ["x", "v"]
    assert names(predictive.plot()) == names(TWO.forecast(y, 2).plot()) == ["x", "v", "y", "z"]
    assert names(predictive.plot(["v"])) == ["v"] and names(predictive.plot(measurements=["z"])) == ["z"]
    assert names(plain.plot(["v"], measurements=["z", "y"])) == ["v", "z", "y"]
    assert names(TWO.smooth(y, paths=20).plot(measurements=["z"])) == ["z"]


def test_data_are_points_within_what_was_expected():
    found = WALK.filter(Y, predictive=True)
    _, measured = found.plot()
    across, values = points(measured)
    np.testing.assert_array_equal(values, found.measurements[:, 0])
    assert across.tolist() == [0, 1, 2, 3, 4]
    (band,) = measured.collections
    edges = band.get_paths()[0].vertices
    assert {round(edge, 9) for edge in edges[:, 1]} >= {round(low, 9) for low in found.predictive_quantiles[:, 0, 0]}
    _, measured = WALK.forecast(Y, 3).plot()
    assert points(measured)[0].tolist() == [0, 1, 2, 3, 4] and len(measured.collections) == 1
    _, measured = WALK.forecast(Y, 3, predictive=True).plot()
    assert len(measured.collections) == 2


def test_an_axis_has_the_dates_of_a_column_as_of_an_index():
    pandas = pytest.importorskip("pandas")
    polars = pytest.importorskip("polars")
    days = pandas.date_range("2024-03-01", periods=5)
    y = [0.1, 0.2, 0.5, 0.4, 0.3]
    forms = [
        pandas.Series(y, index=days),
        pandas.DataFrame({"date": days, "y": y}),
        pandas.DataFrame({"date": days, "y": y}).set_index("date"),
        pandas.DataFrame({"date": days.tz_localize("Asia/Tokyo"), "y": y}),
        pandas.Series(y, index=days.to_period("D")),
        {"date": [str(day)[:10] for day in days], "y": y},
        {"date": list(days.to_period("D")), "y": y},
        {"date": [day.date() for day in days], "y": y},
        polars.DataFrame({"date": [day.date() for day in days], "y": y}),
    ]
    for data in forms:
        axis, measured = WALK.forecast(data, 3).plot()
        assert points(measured)[0].astype("datetime64[D]").tolist() == [day.date() for day in days]
        for one in (axis, measured):
            low, high = (matplotlib.dates.num2date(edge).date() for edge in one.get_xlim())
            assert low < datetime.date(2024, 3, 1) and high > datetime.date(2024, 3, 7)
        assert "Mar" in labels(measured)
        plt.close("all")


def test_years_stand_on_the_axis_and_rows_where_it_is_not_known_what_follows(nile, examples):
    axis, _ = nile.forecast(examples / "nile.csv", 10).plot()
    assert axis.get_lines()[-1].get_xdata().tolist() == list(range(1971, 1981))
    assert nile.filter(examples / "nile.csv").plot()[0].get_xlabel() == "year"
    weeks = {"week": [7, 8, 9, 10], "y": [0.1, 0.2, 0.3, 0.4]}
    (axis,) = WALK.filter(weeks).plot()
    assert axis.get_lines()[0].get_xdata().tolist() == [7, 8, 9, 10] and axis.get_xlabel() == "week"
    _, axis = WALK.forecast(weeks, 2).plot()
    assert [line.get_xdata().tolist() for line in axis.get_lines()] == [[4, 5], [0, 1, 2, 3]] and axis.get_xlabel() == "t"
    (axis,) = WALK.filter({"place": ["b", "a", "c"], "y": [0.1, 0.2, 0.3]}).plot()
    assert axis.get_lines()[0].get_xdata().tolist() == [0, 1, 2] and axis.get_xlabel() == "t"


def test_series_are_counted_or_named():
    found = WALK.filter({"series": list("aabb"), "y": [1.0, 2.0, 3.0, 4.0]})
    for series in (1, "b"):
        (axis,) = found.plot(measurements=["y"], series=series)
        assert points(axis)[1].tolist() == [3.0, 4.0]
    for series in (2, -1, "c"):
        with pytest.raises(ValueError, match=f"series: {series}; there are 2, a the first"):
            found.plot(series=series)


def test_what_cannot_be_drawn_is_refused_in_a_line():
    found = WALK.filter(Y)
    for asked, line in (
        ({"states": ["z"]}, "states: z; it must be one of x"),
        ({"measurements": ["x"]}, "measurements: x; it must be one of y"),
        ({"states": [], "measurements": []}, "states: none, and no measurements"),
        ({"axes": plt.subplots(2)[1]}, "axes: 2; there must be one for each of 1 panels"),
    ):
        with pytest.raises(ValueError, match=line):
            found.plot(**asked)


def test_a_first_row_that_nobody_knows_flattens_no_panel(nile, examples):
    _, flow = nile.filter(examples / "nile.csv", predictive=True).plot()
    low, high = flow.get_ylim()
    assert 0 < low < 456 and 1370 < high < 2000
    # A gap and a forecast are whole, however wide.
    y = [*WALK.simulate(20, seed=1).measurements[0, :, 0], *[None] * 40, 0.3, 0.2]
    axis, _ = WALK.forecast(y, 1, particles=5000).plot()
    assert axis.get_ylim()[1] > WALK.filter(y, particles=5000).quantiles[:, 0, 2].max()
    _, measured = nile.forecast(examples / "nile.csv", 200, predictive=True).plot()
    ahead = nile.forecast(examples / "nile.csv", 200).measurement_quantiles
    assert measured.get_ylim()[0] < ahead.min() and measured.get_ylim()[1] > ahead.max()
    (axis,) = WALK.filter(Y).plot()
    assert axis.get_ylim()[0] < WALK.filter(Y).quantiles[:, 0, 0].min()


def test_axes_of_somebody_else_are_drawn_on():
    _, (left, right) = plt.subplots(1, 2)
    assert WALK.filter(Y, predictive=True).plot(axes=[left, right]).tolist() == [left, right]
    assert len(left.get_lines()) == 1 and len(right.get_lines()) == 2
    _, alone = plt.subplots()
    assert WALK.smooth(Y, paths=20).plot(axes=alone).tolist() == [alone]


def test_simulations():
    drawn = TWO.simulate(9, series=4, seed=1)
    axes = drawn.plot(series=2)
    assert names(axes) == ["x", "v", "y", "z"] and axes[-1].get_xlabel() == "t"
    assert axes[1].get_lines()[0].get_ydata().tolist() == drawn.states[2, :, 1].tolist()
    assert points(axes[2])[1].tolist() == drawn.measurements[2, :, 0].tolist()
    assert [len(axis.get_lines()) for axis in drawn.plot(series=None)] == [4] * 4
    with pytest.raises(ValueError, match="series: 4; there are 4"):
        drawn.plot(series=4)


def fitted(**more):
    model = {
        "parameters": {"sd": "uniform(0.5, 3)", "w": "log_normal(0, 0.5)"},
        "initial": {"x": "normal(0, 1)"},
        "transition": {"x": "normal(x, sd)"},
        "measurement": {"y": "normal(x, w)"},
    }
    return motes.Model({**model, **more}).fit([0.3, 1.2, 0.7, 2.4, 1.8], draws=100)


@pytest.mark.filterwarnings("ignore::motes.MotesWarning")
def test_posteriors_stand_beside_priors():
    found = fitted()
    axes = found.plot()
    assert [axis.get_xlabel() for axis in axes] == ["sd", "w"]
    for axis, name in zip(axes, ("sd", "w"), strict=True):
        (mean,) = axis.get_lines()
        assert mean.get_xdata()[0] == pytest.approx(found.draws[name].mean())
        heights = np.array([bar.get_height() for bar in axis.patches if hasattr(bar, "get_height")])
        assert heights.max() > 0
    (prior,) = [patch for patch in axes[0].patches if hasattr(patch, "get_data")]
    density, edges, _ = prior.get_data()
    inside = (edges[:-1] > 0.55) & (edges[1:] < 2.95)
    assert density[inside] == pytest.approx(np.full(inside.sum(), 0.4), rel=0.5) and density[inside].mean() == pytest.approx(
        0.4, rel=0.1
    )
    # No bin lies where the prior has nothing.
    assert edges[0] >= 0.5
    (axis,) = found.plot(["w"])
    assert axis.get_xlabel() == "w"
    with pytest.raises(ValueError, match="parameters: q; it must be one of sd, w"):
        found.plot(["q"])


@pytest.mark.filterwarnings("ignore::motes.MotesWarning")
def test_chains_have_traces():
    found = fitted()
    axes = found.plot(traces=True)
    assert [axis.get_title(loc="left") for axis in axes] == ["sd", "w"]
    assert [line.get_ydata().tolist() for line in axes[1].get_lines()] == found.draws["w"].tolist()


@pytest.mark.filterwarnings("ignore::motes.MotesWarning")
def test_posteriors_of_models_with_inputs_stand_beside_their_priors():
    model = motes.Model(
        {
            "parameters": {"b": "normal(0, 1)"},
            "inputs": {"u": "hold"},
            "initial": {"x": "normal(0, 1)"},
            "transition": {"x": "normal(x + b*u, 1)"},
            "measurement": {"y": "normal(x, 1)"},
        }
    )
    found = model.fit({"u": [0.0, 1.0, 0.5], "y": [0.1, 0.9, 0.3]}, draws=50)
    (axis,) = found.plot()
    assert set(axis.get_legend_handles_labels()[1]) == {"mean", "posterior", "prior"}
