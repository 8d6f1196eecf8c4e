"""Data of any form, and what is refused of them."""

import warnings

import numpy as np
import pytest

import motes

TWO = {
    "initial": {"x": "normal(0, 1)"},
    "transition": {"x": "normal(x, 1)"},
    "measurement": {"y": "normal(x, 1)", "z": "normal(2*x, 1)"},
}


@pytest.fixture
def two():
    return motes.Model(TWO)


@pytest.fixture
def walk():
    return motes.Model({"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(0.9*x, 0.5)"}, "measurement": {"y": "normal(x, 0.5)"}})


def test_every_form_of_the_same_data_gives_the_same(nile):
    flows = [1120.0, 1160.0, float("nan"), 1210.0]
    forms = [
        flows,
        [1120, 1160, None, 1210],
        np.array(flows),
        np.array(flows)[:, None],
        np.array(flows)[None, :, None],
        np.repeat(np.array(flows), 2)[::2],
        np.asfortranarray(np.array(flows)[:, None]),
        {"flow": flows},
        {"year": ["a", "b", "c", "d"], "flow": flows},
        np.ma.masked_equal(np.array([1120.0, 1160.0, -1.0, 1210.0]), -1.0),
        np.ma.masked_equal(np.array([1120, 1160, -1, 1210]), -1),
    ]
    read_only = np.array(flows)
    read_only.flags.writeable = False
    found = [nile.filter(form).mean.tolist() for form in [*forms, read_only]]
    assert all(one == found[0] for one in found)


def test_whole_numbers_and_single_precision(nile):
    expected = nile.filter([1120.0, 1160.0]).mean.tolist()
    for dtype in ["int32", "int64", "uint16", "float32"]:
        assert nile.filter(np.array([1120, 1160], dtype=dtype)).mean.tolist() == expected


def test_sequences_of_unequal_length(nile):
    found = nile.filter([np.array([1120.0, 1160.0, 1000.0]), np.array([900.0])])
    assert found.series.tolist() == [0, 0, 0, 1] and found.time.tolist() == [0, 1, 2, 0]
    assert found.log_evidence_per_series.shape == (2,)
    assert found.log_evidence == pytest.approx(found.log_evidence_per_series.sum())
    assert nile.filter([[1120.0, 1160.0, 1000.0]][0]).mean.tolist() == found.mean[:3].tolist()


def test_frames_of_pandas(nile, two):
    pandas = pytest.importorskip("pandas")
    index = pandas.date_range("1871-01-01", periods=3, freq="YS")
    frame = pandas.DataFrame({"flow": [1120.0, None, 1000.0]}, index=index)
    found = nile.filter(frame)
    assert (found.to_pandas().index == index).all()
    assert found.to_pandas()["level_mean"].tolist() == found.mean[:, 0].tolist()
    assert list(found.to_pandas().columns) == found.to_csv().splitlines()[0].split(",")
    assert nile.filter(frame["flow"]).mean.tolist() == found.mean.tolist()
    dated = pandas.DataFrame({"date": index, "flow": [1120.0, pandas.NA, 1000.0]})
    assert "1871-01-01,0," in nile.filter(dated).to_csv()
    assert (nile.filter(dated).to_pandas()["date"] == index).all()
    rows = pandas.DataFrame({"series": ["b", "a", "b"], "y": [1.0, 2.0, 3.0], "z": [0.0, 1.0, 2.0], "note": ["", "", ""]})
    with pytest.warns(motes.MotesWarning, match="not used: note"):
        found = two.filter(rows)
    assert found.series_names == ["b", "a"] and found.series.tolist() == [0, 1, 0]
    assert found.to_pandas()["series"].tolist() == ["b", "a", "b"]
    forecast = nile.forecast({"series": [7, 7, 3], "flow": [1120.0, 1160.0, 900.0]}, 2).to_pandas()
    assert forecast["series"].tolist() == [7, 7, 3, 3] and forecast["t"].tolist() == [2, 3, 1, 2]
    assert {"level_mean", "level_q95"} <= set(forecast.columns)


def test_frames_of_polars(nile):
    polars = pytest.importorskip("polars")
    frame = polars.DataFrame({"year": [1871, 1872], "flow": [1120.0, None]})
    found = nile.filter(frame)
    assert found.to_polars()["year"].to_list() == found.to_pandas()["year"].tolist() == [1871, 1872]
    assert found.mean.tolist() == nile.filter([1120.0, None]).mean.tolist()
    several = nile.filter([frame["flow"], polars.Series([900.0, 910.0, 920.0])])
    assert several.series.tolist() == [0, 0, 1, 1, 1] and several.mean[:2].tolist() == found.mean.tolist()


def test_results_repeat_what_columns_said(nile):
    pandas, polars = pytest.importorskip("pandas"), pytest.importorskip("polars")
    flows = [1120.0, 1160.0, 1000.0]
    dates = pandas.date_range("1871-01-01", periods=3, freq="YS")
    columns = {
        "numbers": pandas.Series([3, 1, 2]),
        "dates": pandas.Series(dates),
        "zones": pandas.Series(dates.tz_localize("UTC")),
        "kinds": pandas.Series(["b", "a", "b"], dtype="category"),
        "periods": pandas.Series(dates.to_period("Y")),
    }
    for name, column in columns.items():
        found = nile.filter(pandas.DataFrame({name: column, "flow": flows}).set_axis([5, 5, 6]))
        assert found.to_pandas()[name].tolist() == column.tolist()
        assert found.to_polars().height == 3
    assert nile.filter(pandas.DataFrame({0: dates, "flow": flows})).to_pandas()["0"].tolist() == list(dates)
    years = [1871, 1872, 1873]
    found = nile.filter({"year": years, "flow": flows})
    years[0] = 0
    assert found.to_pandas()["year"].tolist() == found.to_polars()["year"].to_list() == [1871, 1872, 1873]
    once = nile.filter({"series": (name for name in "aab"), "year": {1: 0, 2: 0, 3: 0}.keys(), "flow": flows})
    assert once.to_pandas()[["series", "year"]].values.tolist() == [["a", 1], ["a", 2], ["b", 3]]


def test_levels_of_an_index_are_columns(walk):
    pandas = pytest.importorskip("pandas")
    dates = pandas.date_range("2024-01-01", periods=3)
    frame = pandas.DataFrame({"series": list("aaabbb"), "date": [*dates, *dates], "y": [0.1, 0.2, 0.3, 5.0, 5.1, 5.2]})
    expected = walk.filter(frame)
    assert len(expected.log_evidence_per_series) == 2
    for levels in (["series", "date"], ["date", "series"], ["series"], ["date"]):
        indexed = frame.set_index(levels)
        for data in [indexed, indexed["y"]] if len(levels) == 2 else [indexed]:
            found = walk.filter(data)
            assert found.log_evidence_per_series.tolist() == expected.log_evidence_per_series.tolist(), levels
            assert found.series_names == ["a", "b"] and found.warnings == expected.warnings
            assert "a,2024-01-01,0," in found.to_csv()
            table = found.to_pandas()
            assert (table.index == data.index).all() and not set(levels) & set(table.columns)
            assert table.reset_index()["date"].tolist() == [*dates, *dates]
    by_series = frame.set_index("series")["y"]
    assert walk.filter(by_series).log_evidence_per_series.shape == (2,)
    # A date is carried before what else is an index; one that is no series is asked about.
    station = frame.rename(columns={"series": "station"}).set_index(["station", "date"])
    with pytest.warns(motes.MotesWarning) as said:
        found = walk.filter(station)
    assert "a,0," not in found.to_csv() and "2024-01-01,0," in found.to_csv()
    assert any("column date: it begins again at row 3 (2024-01-01)" in str(one.message) for one in said)


def test_times_that_are_not_one_step_apart_are_warned_of(walk):
    pandas = pytest.importorskip("pandas")
    index = pandas.to_datetime(["2024-01-01", "2024-06-01", "2024-01-01", "2023-01-01"])
    values = [0.1, 0.2, 0.3, 0.4]
    line = (
        "steps of 5, -5 and -12 months; row 2 (2024-01-01) is before row 1 and 1 more; row 2 (2024-01-01) repeats row 0: "
        "rows are taken as consecutive time steps; sort them, and leave one row for each time"
    )
    forms = [
        ("the index", pandas.Series(values, index=index)),
        ("the index", pandas.DataFrame({"y": values}, index=index)),
        ("column date", pandas.Series(values, index=index.rename("date"))),
        ("column date", pandas.DataFrame({"date": index, "y": values})),
        ("column date", {"date": [str(date)[:10] for date in index], "y": values}),
    ]
    for name, form in forms:
        with pytest.warns(motes.MotesWarning):
            found = walk.filter(form)
        assert found.warnings == [f"{name}: {line}"]
    for freq in ["D", "ME", "MS", "B", "h", "QE", "W", "YS"]:
        dates = pandas.date_range("2024-01-31", periods=30, freq=freq)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            found = walk.filter(pandas.Series(np.linspace(0, 1, 30), index=dates))
            assert (found.to_pandas().index == dates).all()
            if freq in ("D", "ME", "QE"):
                walk.filter(pandas.Series(np.linspace(0, 1, 30), index=dates.to_period()))


def test_a_count_that_is_none_is_refused_with_its_row():
    walk = {"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, 1)"}}
    counts = motes.Model({**walk, "measurement": {"y": "poisson(exp(x))"}})
    for value in (-2, 2.5, 0.9999999999):
        line = f"data, row 1, column y: {value} is no value of poisson(exp(x)): a count is a whole number, 0 or more"
        for call in (counts.filter, counts.smooth, counts.compare, counts.learn, counts.check):
            with pytest.raises(ValueError) as refused:
                call([1, value])
            assert str(refused.value) == line


def test_a_lazy_frame_is_refused_in_a_line(walk):
    polars = pytest.importorskip("polars")
    for data in (polars.LazyFrame({"y": [1.0, 2.0]}), [polars.LazyFrame({"y": [1.0]}), np.array([1.0])]):
        with pytest.raises(ValueError, match=r"LazyFrame has no rows yet; call \.collect\(\) first$"):
            walk.filter(data)


def test_a_forecast_of_no_time_is_empty(nile):
    found = nile.forecast([np.array([1120.0]), np.array([900.0, 910.0])], 0)
    assert found.mean.shape == (2, 0, 1) and found.quantiles.shape == (2, 0, 1, 3)


@pytest.mark.parametrize(
    ("data", "line"),
    [
        (np.zeros((3, 1)), r"data: an array of shape \(3, 1\); it must be \(T, 2\) or \(S, T, 2\), a column for each of y, z"),
        (np.zeros(3), r"data: an array of shape \(3,\)"),
        (np.zeros((0, 2)), "data: there are no rows"),
        (np.array([[1.0, 2.0], [np.inf, 0.0]]), "data, row 1, column y: inf is not finite"),
        ({"y": [1.0]}, "data: there is no column z, which the model measures; there are y"),
        ({"y": [1.0], "z": []}, "data: columns have different lengths: 0, 1"),
        ({"y": [], "z": []}, "data: there are no rows"),
        (np.zeros((0, 5, 2)), "data: there are no sequences"),
        ({"series": ["a", None], "y": [1.0, 2.0], "z": [1.0, 2.0]}, "data, row 1, column series: it is missing"),
        ({"series": [1.0, float("nan")], "y": [1.0, 2.0], "z": [1.0, 2.0]}, "data, row 1, column series: it is missing"),
        ({"series": np.array([1, np.nan], np.float32), "y": [1.0, 2.0], "z": [1.0, 2.0]}, "data, row 1, column series: it is missing"),
        ({"series": np.array(["2020", "NaT"], "M8[D]"), "y": [1.0, 2.0], "z": [1.0, 2.0]}, "data, row 1, column series: it is missing"),
        ({"series": np.ma.masked_equal([1, 2], 2), "y": [1.0, 2.0], "z": [1.0, 2.0]}, "data, row 1, column series: it is missing"),
        ({"series": "ab", "y": [1.0, 2.0], "z": [1.0, 2.0]}, "data, column series: 'ab' is no column"),
        ({"y": 1.0, "z": 2.0}, "data, column y: 1.0 is no column"),
        ({"x_mean": [1, 2], "y": [1.0, 2.0], "z": [1.0, 2.0]}, "data, column x_mean: results have a column of that name"),
        ({"y": [1.0, "x"], "z": [1.0, 2.0]}, "data, row 0, column y: .* is no number"),
        ({"y": np.array([1.0, "x"], dtype=object), "z": [1.0, 2.0]}, "data, row 1, column y: 'x' is no number"),
        ({"y": [1j], "z": [1.0]}, "data, row 0, column y: .* is no number"),
        ({"t": [0, 2], "y": [1.0, 2.0], "z": [1.0, 2.0]}, "data, row 1, column t: 2, where 1 is next"),
        ([np.zeros((2, 2)), np.zeros((2, 3))], r"data, sequence 1: an array of shape \(2, 3\); it must be \(T, 2\)"),
        ([np.zeros((2, 2)), np.zeros((0, 2))], "data, sequence 1: there are no rows"),
        ([[1.0, 2.0], [1.0]], "data: rows of different lengths"),
        ([], "data: an array of shape"),
        ("nowhere.csv", "there is no such file: 'nowhere.csv'"),
    ],
)
def test_what_is_no_data_is_refused_in_a_line(two, data, line):
    with pytest.raises((ValueError, OSError), match=line) as refused:
        two.filter(data)
    assert "\n" not in str(refused.value)
