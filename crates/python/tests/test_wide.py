"""Frames and arrays with a column for each series are refused with what makes them long, and that does."""

import re

import numpy as np
import pytest

import motes

pandas = pytest.importorskip("pandas")

WALK = {"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, 1)"}, "measurement": {"flow": "normal(x, 1)"}}
FLOWS = np.array([[0.1, 1.1], [0.2, np.nan], [0.3, 1.3]])
DATES = pandas.date_range("2024-01-01", periods=3)
WIDE = pandas.DataFrame({"date": DATES, "A": FLOWS[:, 0], "B": FLOWS[:, 1]})


@pytest.fixture
def walk():
    return motes.Model(WALK)


def refused(model, data):
    with pytest.raises(ValueError) as error:
        model.filter(data)
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.mark.parametrize(
    ("frame", "call"),
    [
        (WIDE, 'df.melt("date", var_name="series", value_name="flow")'),
        (WIDE.set_index("date"), 'df.melt(ignore_index=False, var_name="series", value_name="flow")'),
        (WIDE[["A", "B"]], 'df.melt(var_name="series", value_name="flow")'),
        (WIDE.assign(place="x"), 'df.melt(["date", "place"], var_name="series", value_name="flow")'),
        (
            WIDE.rename(columns={"date": "year"}).assign(year=[1871, 1872, 1873]),
            'df.melt("year", var_name="series", value_name="flow")',
        ),
    ],
)
def test_a_column_for_each_series_is_made_long(walk, frame, call):
    line = refused(walk, frame)
    assert line.startswith("data: there is no column flow, which the model measures; there are ")
    assert line.endswith(f"; where each column is a series, {call} makes rows of them")
    if "place" not in frame:
        found = walk.filter(eval(call, {"df": frame}))
        assert found.series_names == ["A", "B"]
        np.testing.assert_array_equal(found.measurements[:, 0], FLOWS.T.reshape(-1))


def test_frames_of_polars_are_made_long(walk):
    polars = pytest.importorskip("polars")
    frame = polars.DataFrame({"date": [date.date() for date in DATES], "A": FLOWS[:, 0], "B": FLOWS[:, 1]})
    call = 'df.unpivot(index="date", variable_name="series", value_name="flow")'
    assert call in refused(walk, frame)
    assert walk.filter(eval(call, {"df": frame})).series_names == ["A", "B"]


def test_series_are_called_as_the_model_calls_them():
    animals = motes.Model({"series": {"by": "animal"}, **WALK})
    call = 'df.melt("date", var_name="animal", value_name="flow")'
    assert call in refused(animals, WIDE)
    assert animals.filter(eval(call, {"df": WIDE})).series_names == ["A", "B"]


def test_what_is_not_wide_is_refused_as_before(walk):
    two = motes.Model({**WALK, "measurement": {"y": "normal(x, 1)", "z": "normal(x, 1)"}})
    expected = "data: there is no column {}, which the model measures; there are {}"
    assert refused(walk, WIDE[["date", "A"]]) == expected.format("flow", "date, A")
    assert refused(walk, pandas.DataFrame({"a": ["x"], "b": ["y"]})) == expected.format("flow", "a, b")
    assert refused(two, WIDE) == expected.format("y", "date, A, B")
    assert refused(walk, {"A": [0.1], "B": [0.2]}) == expected.format("flow", "A, B")


def test_columns_of_an_array(walk):
    call = "list(y.T)"
    assert refused(walk, FLOWS).endswith(f"; where each column is a series, give {call}")
    found = walk.filter(eval(call, {"y": FLOWS}))
    np.testing.assert_array_equal(found.measurements[:, 0], FLOWS.T.reshape(-1))
    assert refused(walk, FLOWS[:, :1].T).endswith("; y.T is one series")
    assert "list" not in refused(
        motes.Model({**WALK, "measurement": {"y": "normal(x, 1)", "z": "normal(x, 1)"}}), np.zeros((4, 3))
    )


def test_columns_of_two_levels():
    two = motes.Model({**WALK, "measurement": {"y": "normal(x, 1)", "z": "normal(x, 1)"}})
    for names in ([None, None], ["station", "what"]):
        columns = pandas.MultiIndex.from_product([["a", "b"], ["y", "z"]], names=names)
        frame = pandas.DataFrame(np.arange(12.0).reshape(3, 4), index=DATES, columns=columns)
        for data in (frame, frame.swaplevel(axis=1), frame.rename_axis("date")):
            line = refused(two, data)
            call = re.fullmatch(r"data: its columns have 2 levels; (.*) makes series of the other level", line)[1]
            found = two.filter(eval(call, {"df": data}))
            assert found.series_names == ["a", "b"]
            np.testing.assert_array_equal(found.measurements[found.series == 1], frame["b"].to_numpy())
    others = pandas.DataFrame([[1.0, 2.0]], columns=pandas.MultiIndex.from_product([["a"], ["p", "q"]]))
    line = refused(two, others)
    (code,) = re.findall(r"levels; (df.columns = .*) makes one name of each", line)
    exec(code, {"df": others})
    assert list(others.columns) == ["a_p", "a_q"]
