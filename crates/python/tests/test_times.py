"""Models with times and inputs: data frames, simulations, on-line filters."""

import numpy as np
import pytest

import motes

DRIVEN = {
    "time": {"column": "hours"},
    "inputs": {"u": "hold", "w": {"between": "linear", "simulate": "normal(0, 1)"}},
    "initial": {"x": 0},
    "transition": {"x": "normal(x + u*dt + 0*w, 0.1*sqrt(dt))"},
    "measurement": {"y": "normal(x, 0.2)"},
}

ROWS = {"hours": [0.0, 0.5, 2.0], "u": [1.0, 2.0, 0.0], "w": [0.0, 0.0, 0.0], "y": [0.1, np.nan, 3.4]}


def test_columns_are_times_and_inputs():
    model = motes.Model(DRIVEN)
    filtered = model.filter(ROWS, proposal="exact")
    assert filtered.time.tolist() == [0.0, 0.5, 2.0]
    # The mean of y_2 is 0.5 + 3, with the variances of the walk and of the measurement.
    spread = 0.01 * 2 + 0.04
    expected = -0.5 * (np.log(2 * np.pi * spread) + (3.4 - 3.5) ** 2 / spread)
    assert filtered.log_evidence_increments[2] == pytest.approx(expected, rel=1e-9)
    with pytest.raises(ValueError, match="row 2, column hours: 0.25 comes after 0.5; within a series times increase"):
        model.filter({**ROWS, "hours": [0.0, 0.5, 0.25]})
    with pytest.raises(ValueError, match="there is no column u, which is an input of the model"):
        model.filter({name: values for name, values in ROWS.items() if name != "u"})


def test_rows_one_by_one_are_the_rows_of_a_table():
    model = motes.Model(DRIVEN)
    online = model.online(proposal="exact")
    for hours, u, w, y in zip(*ROWS.values(), strict=True):
        online.step([y], time=hours, inputs={"u": u, "w": w})
    assert online.log_evidence == pytest.approx(model.filter(ROWS, proposal="exact").log_evidence, rel=1e-12)
    with pytest.raises(ValueError, match="inputs: w is missing"):
        online.step([1.0], time=3.0, inputs={"u": 0.0})
    with pytest.raises(ValueError, match="1 comes after 2"):
        online.step([1.0], time=1.0, inputs={"u": 0.0, "w": 0.0})
    assert online.step([3.4], time=3.0, inputs={"u": 0.0, "w": 0.0}).mean[0] == pytest.approx(3.5, abs=0.3)


def test_simulations_take_times_and_inputs():
    pandas = pytest.importorskip("pandas")
    model = motes.Model(DRIVEN)
    with pytest.raises(ValueError, match="the model has the input u"):
        model.simulate(3)
    inputs = {name: values for name, values in ROWS.items() if name != "y"}
    simulated = model.simulate(series=2, inputs=inputs)
    assert simulated.states.shape == (2, 3, 1)
    assert simulated.time.tolist() == [[0.0, 0.5, 2.0]] * 2
    assert simulated.inputs["u"].tolist() == [[1.0, 2.0, 0.0]] * 2
    table = simulated.to_pandas()
    assert list(table.columns) == ["series", "hours", "u", "w", "x", "y"]
    assert isinstance(table, pandas.DataFrame)
    assert np.isfinite(model.filter(table, particles=100).log_evidence)


def test_series_are_told_apart_by_any_column():
    walk = {"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, 0.2)"}, "measurement": {"y": "normal(x, 0.3)"}}
    animals = {"animal": ["a", "a", "b", "b", "b"], "y": [0.9, 1.1, -1.4, -1.2, -1.1]}
    filtered = motes.Model({"series": {"by": "animal"}, **walk}).filter(animals, proposal="exact")
    assert filtered.series_names == ["a", "b"]
    assert filtered.log_evidence == pytest.approx(-3.795256, abs=1e-6)


def test_measurements_are_predicted_one_step_ahead():
    model = motes.Model(DRIVEN)
    plain = model.filter(ROWS, proposal="exact")
    with pytest.raises(ValueError, match="predictive: nobody asked for it"):
        plain.pit
    found = model.filter(ROWS, proposal="exact", predictive=True)
    assert found.predictive_mean[:, 0] == pytest.approx([0.0, 0.5, 3.5])
    assert found.predictive_sd[:, 0] == pytest.approx(np.sqrt([0.04, 0.045, 0.06]))
    assert np.isnan(found.pit[1, 0]) and found.pit[0, 0] == pytest.approx(0.6914625, abs=1e-6)
    assert found.innovations[:, 0] == pytest.approx([0.1, np.nan, -0.1], nan_ok=True)
    assert found.residuals[:, 0] == pytest.approx([0.1 / 0.2, np.nan, -0.1 / np.sqrt(0.06)], nan_ok=True)
    for name in ("innovations", "residuals"):
        with pytest.raises(ValueError, match="predictive: nobody asked for it"):
            getattr(plain, name)
    header = found.to_csv().splitlines()[0].split(",")
    assert header[-3:] == ["y_mean", "y_sd", "y_pit"] and "y_pit" not in plain.to_csv()
    online = model.online(proposal="exact", predictive=True)
    for row, (hours, u, w, y) in enumerate(zip(*ROWS.values(), strict=True)):
        online.step([y], time=hours, inputs={"u": u, "w": w})
        assert online.measurement_mean[0] == found.predictive_mean[row, 0]
        assert np.array_equal(online.pit, found.pit[row], equal_nan=True)
    assert "pit" in found.to_html()
    pandas = pytest.importorskip("pandas")
    table = found.to_pandas()
    assert isinstance(table, pandas.DataFrame) and list(table.columns) == header


def test_forecasts_take_times_and_inputs():
    model = motes.Model(DRIVEN)
    ahead = {"hours": [3.0, 5.0], "u": [0.5, 0.0], "w": [0.0, 0.0]}
    found = model.forecast(ROWS, inputs=ahead, proposal="exact")
    assert found.time.tolist() == [[3.0, 5.0]]
    # The last row says u = 0 for the first gap.
    rise = found.mean[0, :, 0] - found.filtered.mean[-1, 0]
    assert rise == pytest.approx([0.0, 1.0])
    assert found.measurement_mean[0, :, 0] == pytest.approx(found.mean[0, :, 0])
    assert found.measurement_sd[0, :, 0] == pytest.approx(np.sqrt(found.sd[0, :, 0] ** 2 + 0.04))
    assert found.measurement_quantiles.shape == (1, 2, 1, 3)
    lines = [line.split(",") for line in found.to_csv().splitlines()]
    assert lines[0][-5:] == ["y_mean", "y_sd", "y_q05", "y_q50", "y_q95"]
    assert [float(line[0]) for line in lines[1:]] == [3.0, 5.0]
    with pytest.raises(ValueError, match="steps: either how many times are predicted"):
        model.forecast(ROWS)
    with pytest.raises(ValueError, match="5 comes after 6"):
        model.forecast(ROWS, inputs={**ahead, "hours": [6.0, 5.0]})


def test_parameters_are_drawn_from_their_priors():
    walk = {
        "parameters": {"q": "half_normal(1)"},
        "initial": {"x": "normal(0, 1)"},
        "transition": {"x": "normal(x, q)"},
        "measurement": {"y": "normal(x, 1)"},
    }
    drawn = motes.Model(walk).simulate(4, series=3, prior=True)
    assert len(set(drawn.parameters["q"].tolist())) == 3
    assert motes.Model(walk).simulate(4).parameters == {}
    known = {**walk, "parameters": {"q": 1.0}}
    with pytest.raises(ValueError, match="prior: no parameter of the model has a prior"):
        motes.Model(known).simulate(4, prior=True)
    pandas = pytest.importorskip("pandas")
    table = drawn.to_pandas()
    assert isinstance(table, pandas.DataFrame) and table.groupby("series")["q"].nunique().tolist() == [1, 1, 1]


def test_inputs_of_a_missing_measurement_may_be_missing():
    model = motes.Model(
        {
            "inputs": {"tested": "hold"},
            "initial": {"x": "normal(0, 1)"},
            "transition": {"x": "normal(0.9*x, 0.3)"},
            "measurement": {"positive": "binomial(tested, logistic(x))"},
        }
    )
    rows = {"tested": [10.0, np.nan, 20.0], "positive": [6.0, np.nan, 9.0]}
    filled = {**rows, "tested": [10.0, 5.0, 20.0]}
    assert model.filter(rows).log_evidence == model.filter(filled).log_evidence
    assert model.evidence(rows)["log_evidence"] == model.evidence(filled)["log_evidence"]
    with pytest.raises(ValueError, match=r"row 1, column tested: the input tested has no value here, and \[measurement\] needs it"):
        model.filter({**rows, "positive": [6.0, 2.0, 9.0]})


def test_a_file_of_inputs_that_ends_before_the_rows_says_how_far_they_go(tmp_path):
    (tmp_path / "u.csv").write_text("day,u\n0,1\n1,2\n")
    text = '[time]\ncolumn = "day"\n[inputs]\nu = { file = "u.csv", between = "linear" }\n[initial]\nx = 0\n[transition]\nx = "x + u"\n[measurement]\ny = "normal(x, 1)"\n'
    (tmp_path / "m.toml").write_text(text)
    model = motes.Model(tmp_path / "m.toml")
    with pytest.raises(ValueError, match="row 3, column day: .* and 2 is needed, and the rows go on to 7; give it more rows"):
        model.filter({"day": [0.0, 1.0, 2.0, 3.0, 7.0], "y": [1.0] * 5})
