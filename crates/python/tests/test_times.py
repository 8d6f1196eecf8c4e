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
