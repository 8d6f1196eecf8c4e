"""Forecasts: their dates, tables, pages and plots."""

import datetime
import warnings

import numpy as np
import pytest

import motes

pandas = pytest.importorskip("pandas")


@pytest.fixture
def walk():
    return motes.Model(
        {"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, 1)"}, "measurement": {"y": "normal(2*x, 1)"}}
    )


@pytest.fixture(autouse=True)
def no_other_warnings():
    with warnings.catch_warnings():
        warnings.simplefilter("error", motes.MotesWarning)
        yield


@pytest.mark.parametrize("frequency", ["D", "h", "B", "W", "MS", "ME", "QS", "YS", "2D", "90min"])
def test_an_index_of_dates_goes_on(walk, frequency):
    whole = pandas.date_range("2024-01-31", periods=10, freq=frequency, name="when")
    # With and without what it says of its own steps.
    for index in (whole[:7], pandas.DatetimeIndex(list(whole[:7]), name="when")):
        found = walk.forecast(pandas.Series(np.arange(7.0), index=index), 3)
        assert found.to_pandas().index.equals(whole[7:]) and found.to_pandas().index.name == "when"
        assert found.to_pandas()["t"].tolist() == [7, 8, 9]


def test_zones_and_periods_go_on(walk):
    for index in (
        pandas.date_range("2024-03-28", periods=8, freq="D", tz="Europe/Berlin"),
        pandas.period_range("2024-01", periods=8, freq="M"),
    ):
        found = walk.forecast(pandas.Series(np.arange(5.0), index=index[:5]), 3).to_pandas()
        assert list(found.index) == list(index[5:])


@pytest.mark.parametrize(
    "dates",
    [
        ["2024-01-01", "2024-06-01", "2024-06-03", "2024-06-04"],
        ["2024-01-01", "2024-01-01", "2024-01-01", "2024-01-01"],
        ["2024-01-04", "2024-01-03", "2024-01-02", "2024-01-01"],
    ],
)
def test_dates_that_do_not_go_on_are_left_out_with_a_warning(walk, dates):
    y = [0.1, 0.2, 0.3, 0.4]
    series = pandas.Series(y, index=pandas.to_datetime(dates))
    with pytest.warns(motes.MotesWarning) as warned:
        found = walk.forecast(series, 2).to_pandas()
    assert any("data, the index: its dates do not go on with equal steps" in str(one.message) for one in warned)
    assert found.index.tolist() == [0, 1] and "date" not in found
    with pytest.warns(motes.MotesWarning) as warned:
        found = walk.forecast({"date": dates, "y": y}, 2)
    assert any("data, column date: its dates do not go on" in str(one.message) for one in warned)
    assert "date" not in found.to_pandas() and found.to_csv().startswith("t,x_mean")


def test_a_column_of_dates_goes_on(walk):
    days = [datetime.date(2024, 2, 27) + datetime.timedelta(days) for days in range(6)]
    forms = {
        "dates": days,
        "times": [datetime.datetime(day.year, day.month, day.day, 12) for day in days],
        "pandas": list(pandas.to_datetime(days)),
        "numpy": list(np.array(days, dtype="datetime64[D]")),
        "text": [str(day) for day in days],
        "text with times": [f"{day} 06:30" for day in days],
    }
    for name, whole in forms.items():
        found = walk.forecast({"date": whole[:4], "y": [0.1, 0.2, 0.3, 0.4]}, 2)
        assert list(found.to_pandas()["date"]) == whole[4:], name
        assert found.to_csv().splitlines()[0].startswith("date,t,x_mean,x_sd"), name
    assert found.to_csv().splitlines()[1].startswith("2024-03-02 06:30,4,")


def test_months_of_a_column_go_on(walk):
    months = [datetime.date(2023, month, 15) for month in (9, 10, 11, 12)]
    found = walk.forecast({"date": months, "y": [0.1, 0.2, 0.3, 0.4]}, 2).to_pandas()
    assert found["date"].tolist() == [datetime.date(2024, 1, 15), datetime.date(2024, 2, 15)]


def test_frames_of_polars_go_on(walk):
    polars = pytest.importorskip("polars")
    days = [datetime.date(2024, 1, day) for day in range(1, 7)]
    found = walk.forecast(polars.DataFrame({"date": days[:4], "y": [0.1, 0.2, 0.3, 0.4]}), 2).to_polars()
    assert found["date"].to_list() == days[4:] and found.schema["date"] == polars.Date
    assert found.columns[:3] == ["date", "t", "x_mean"]


def test_each_series_goes_on_by_itself(walk):
    first, second = pandas.date_range("2024-01-01", periods=5), pandas.date_range("2020-01-01", periods=6, freq="MS")
    frame = pandas.DataFrame(
        {"series": [*"aaa", *"bbbb"], "date": [*first[:3], *second[:4]], "y": np.arange(7.0)}
    )
    found = walk.forecast(frame, 2).to_pandas()
    assert found["series"].tolist() == ["a", "a", "b", "b"]
    assert found["date"].tolist() == [*first[3:], *second[4:]]
    found = walk.forecast(frame.set_index("date"), 2).to_pandas()
    assert found.index.tolist() == [*first[3:], *second[4:]] and found["series"].tolist() == ["a", "a", "b", "b"]


def test_what_has_no_dates_has_none(walk):
    assert walk.forecast([0.1, 0.2, 0.3], 2).to_pandas().index.tolist() == [0, 1]
    series = pandas.Series([0.1, 0.2, 0.3], index=[10, 20, 30])
    assert walk.forecast(series, 2).to_pandas().index.tolist() == [0, 1]
    for labels in ([1203, 1410, 1411], [True, False, True], ["a", "b", "c"], [1.5, 2.5, 3.5], [1990, 1991, None]):
        assert walk.forecast({"sensor": labels, "y": [0.1, 0.2, 0.3]}, 2).to_csv().startswith("t,x_mean")


def test_years_go_on(walk, nile, examples):
    found = nile.forecast(examples / "nile.csv", 2)
    assert [line.split(",")[0] for line in found.to_csv().splitlines()] == ["year", "1971", "1972"]
    forms = {
        "integers": ([1871, 1872, 1873], [1874, 1875]),
        "every fourth": ([1896, 1900, 1904], [1908, 1912]),
        "numpy": (list(np.array([1871, 1872, 1873])), [1874, 1875]),
        "floats": ([1871.0, 1872.0, 1873.0], [1874.0, 1875.0]),
        "text": (["1871", "1872", "1873"], ["1874", "1875"]),
    }
    for name, (years, expected) in forms.items():
        table = walk.forecast({"season": years, "y": [0.1, 0.2, 0.3]}, 2).to_pandas()
        assert table["season"].tolist() == expected and table["t"].tolist() == [3, 4], name
    for index in (pandas.Index([1871, 1872, 1873], name="when"), pandas.RangeIndex(1871, 1874)):
        found = walk.forecast(pandas.Series([0.1, 0.2, 0.3], index=index), 2)
        assert found.to_pandas().index.tolist() == [1874, 1875] and found.to_pandas().index.name == index.name
        assert found.to_csv().splitlines()[1].startswith("1874,3,")
    polars = pytest.importorskip("polars")
    found = walk.forecast(polars.DataFrame({"year": [5, 6, 7], "y": [0.1, 0.2, 0.3]}), 2).to_polars()
    assert found["year"].to_list() == [8, 9] and found.schema["year"] == polars.Int64


def test_years_that_do_not_go_on_are_left_out_with_a_warning(walk):
    with pytest.warns(motes.MotesWarning) as warned:
        found = walk.forecast({"year": [1871, 1872, 1874], "y": [0.1, 0.2, 0.3]}, 2)
    assert any("data, column year: its years do not go on with equal steps" in str(one.message) for one in warned)
    assert "year" not in found.to_pandas()


def test_years_of_each_series_go_on_by_themselves(walk):
    frame = pandas.DataFrame({"series": [*"aaa", *"bbb"], "year": [1990, 1991, 1992, 2000, 2002, 2004], "y": np.arange(6.0)})
    expected = [("a", 1993), ("a", 1994), ("b", 2006), ("b", 2008)]
    for data in (frame, frame.set_index("year"), frame.set_index(["series", "year"])):
        found = walk.forecast(data, 2).to_pandas()
        # An index is no column at the same time.
        found = found.reset_index() if data is not frame else found
        assert list(found[["series", "year"]].itertuples(index=False, name=None)) == expected


def test_tables_say_the_same(walk):
    series = pandas.Series([0.1, 0.2, 0.3], index=pandas.date_range("2024-01-01", periods=3))
    found = walk.forecast(series, 2)
    rows = [line.split(",") for line in found.to_csv().splitlines()]
    assert rows[0][:3] == ["date", "t", "x_mean"] and [row[0] for row in rows[1:]] == ["2024-01-04", "2024-01-05"]
    assert [float(row[2]) for row in rows[1:]] == found.mean[0, :, 0].tolist()
    assert found.time.tolist() == [[3, 4]]


def test_pages_and_plots(walk, tmp_path):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    series = pandas.Series([0.1, 0.2, 0.3], index=pandas.date_range("2024-01-01", periods=3))
    found = walk.forecast(series, 2)
    assert "forecast" in found.to_html(tmp_path / "page.html") and (tmp_path / "page.html").exists()
    axis, _ = found.plot()
    assert [label for label in axis.get_legend_handles_labels()[1]] == ["5 to 95 %", "mean", "forecast, 5 to 95 %", "forecast"]
    (axis,) = walk.forecast([[0.1, 0.2], [0.3, 0.4]][0], 2).plot(["x"])
    assert axis.get_xlabel() == "t"
    with pytest.raises(ValueError, match="series: 3"):
        found.plot(series=3)


def test_times_of_a_clock_go_on_as_the_model_has_them():
    def model(unit):
        clock = {"time": {"column": "date", "unit": unit}, "initial": {"x": "t"}, "transition": {"x": "t"}}
        return motes.Model({**clock, "measurement": {"y": "normal(x, 1)"}})

    def dates(unit, labels):
        data = {"date": labels, "y": [None] * len(labels)}
        ahead = model(unit).forecast(data, 2, particles=2)
        return list(ahead.to_pandas()["date"])

    # A year after 2024-01-01 is 366 days later.
    years = ["2022-01-01", "2023-01-01", "2024-01-01"]
    following = ["2025-01-01", "2026-01-01"]
    assert dates("year", years) == following
    assert dates("year", [datetime.date.fromisoformat(one) for one in years]) == [datetime.date.fromisoformat(one) for one in following]
    assert dates("year", list(pandas.to_datetime(years))) == list(pandas.to_datetime(following))
    assert dates("week", ["2024-01-01", "2024-01-08"]) == ["2024-01-15", "2024-01-22"]
    zoned = [pandas.Timestamp("2024-03-30T12:00+01:00"), pandas.Timestamp("2024-03-31T12:00+01:00")]
    assert dates("day", zoned) == [zoned[-1] + pandas.Timedelta(days=1), zoned[-1] + pandas.Timedelta(days=2)]


def test_rows_of_a_whole_period_are_taken_from_where_the_data_end():
    driven = motes.Model(
        {"inputs": {"u": "next"}, "initial": {"x": 0}, "transition": {"x": "x + u"}, "measurement": {"y": "normal(x, 0.1)"}}
    )
    data = {"u": [100.0, 1.0, 2.0], "y": [0.0, 1.0, 3.0]}
    whole = {"t": [0, 1, 2, 3, 4], "u": [100.0, 1.0, 2.0, 10.0, 20.0]}
    found = driven.forecast(data, proposal="exact", inputs=whole)
    assert found.to_csv() == driven.forecast(data, proposal="exact", inputs={"u": [10.0, 20.0]}).to_csv()
    assert found.to_csv().splitlines()[-1].startswith("4,33,")
    with pytest.raises(ValueError, match="inputs: a table has no row at t = 3"):
        driven.forecast(data, proposal="exact", inputs={"t": [4], "u": [20.0]})
