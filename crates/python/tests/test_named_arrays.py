"""Results as datasets of xarray, and as draws of ArviZ."""

import numpy as np
import pytest

import motes

TWO = motes.Model(
    {
        "initial": {"x": "normal(0, 1)", "v": "normal(0, 1)"},
        "transition": {"x": "normal(x, 1)", "v": "normal(v, 1)"},
        "measurement": {"y": "normal(x, 1)", "z": "normal(v, 1)"},
    }
)
WALK = motes.Model({"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, 1)"}, "measurement": {"y": "normal(x, 1)"}})


@pytest.fixture
def xarray():
    return pytest.importorskip("xarray")


def test_a_filter(xarray):
    found = TWO.filter(TWO.simulate(5, 3, seed=1).measurements, predictive=True)
    data = found.to_xarray()
    assert dict(data.sizes) == {"series": 3, "time": 5, "state": 2, "quantile": 3, "measurement": 2}
    assert data.state.values.tolist() == ["x", "v"] and data.measurement.values.tolist() == ["y", "z"]
    assert data["quantile"].values.tolist() == [0.05, 0.5, 0.95] and data.time.values.tolist() == [0, 1, 2, 3, 4]
    assert data.series.values.tolist() == ["0", "1", "2"] and "t" not in data.coords
    assert data["mean"].sel(series="1", state="v").values.tolist() == found.mean[5:10, 1].tolist()
    assert data["quantiles"].sel(quantile=0.95, series="2", state="x").values.tolist() == found.quantiles[10:, 0, 2].tolist()
    assert data["residuals"].sel(series="0", measurement="z").values.tolist() == found.residuals[:5, 1].tolist()
    assert data["ess"].values.reshape(-1).tolist() == found.ess.tolist()
    assert data["log_evidence_per_series"].values.tolist() == found.log_evidence_per_series.tolist()
    assert data.attrs["log_evidence"] == found.log_evidence and data.attrs["standard_error"] == found.standard_error
    assert (data.attrs["particles"], data.attrs["seed"]) == (1000, 1)
    assert "pit" not in TWO.filter([[0.0, 0.0]]).to_xarray()


def test_series_of_unequal_length_end_with_nan(xarray):
    found = WALK.filter([np.array([0.1, 0.2, 0.3]), np.array([0.4])])
    data = found.to_xarray()
    assert dict(data.sizes)["time"] == 3 and data.time.values.tolist() == [0, 1, 2]
    assert np.isnan(data["mean"].sel(series="1").values[1:]).all() and np.isnan(data["ess"].sel(series="1").values[1:]).all()
    assert data["mean"].sel(series="0", state="x").values.tolist() == found.mean[:3, 0].tolist()
    assert int(data["measurements"].notnull().sum()) == 4


def test_rows_of_series_need_not_be_together(xarray):
    frame = {"series": ["b", "a", "b"], "y": [1.0, 2.0, 3.0]}
    data = WALK.filter(frame).to_xarray()
    assert data.series.values.tolist() == ["b", "a"]
    np.testing.assert_array_equal(data["measurements"].values[..., 0], [[1.0, 3.0], [2.0, np.nan]])


def test_dates_are_the_coordinate_of_time_where_series_share_them(xarray):
    pandas = pytest.importorskip("pandas")
    dates = pandas.date_range("2024-01-01", periods=4)
    frame = pandas.DataFrame({"series": list("aaaabbb"), "date": [*dates, *dates[:3]], "y": np.arange(7.0)})
    for data in (frame, frame.set_index("date"), frame.set_index(["series", "date"])):
        found = WALK.filter(data).to_xarray()
        assert found.time.values.astype("datetime64[D]").tolist() == [date.date() for date in dates]
        assert found["mean"].sel(series="b", time="2024-01-02").shape == (1,)
        np.testing.assert_array_equal(found["t"].values, [[0, 1, 2, 3], [0, 1, 2, np.nan]])
    # Where they are others in each series, rows are counted, and dates stand beside them.
    later = frame.assign(date=[*dates, *(dates[:3] + pandas.Timedelta(days=9))])
    found = WALK.filter(later).to_xarray()
    assert found.time.values.tolist() == [0, 1, 2, 3] and found["date"].dims == ("series", "time")
    assert found["date"].sel(series="b").values[:3].astype("datetime64[D]").tolist() == [
        date.date() for date in later["date"][4:]
    ]
    assert np.isnat(found["date"].sel(series="b").values[3])


def test_years_are_the_coordinate_of_time(xarray, nile, examples):
    found = nile.filter(examples / "nile.csv", proposal="optimal").to_xarray()
    assert found.time.values[[0, -1]].tolist() == [1871, 1970] and found.sizes["series"] == 1
    ahead = nile.forecast(examples / "nile.csv", 3).to_xarray()
    assert ahead.time.values.tolist() == [1971, 1972, 1973] and ahead["t"].values.tolist() == [[100, 101, 102]]


def test_a_forecast(xarray):
    found = TWO.forecast(TWO.simulate(5, 2, seed=1).measurements, 3)
    data = found.to_xarray()
    assert data["mean"].dims == ("series", "time", "state") and data["mean"].values.tolist() == found.mean.tolist()
    assert data.time.values.tolist() == [5, 6, 7]
    low = data["measurement_quantiles"].sel(quantile=0.05, measurement="z").values
    assert low.tolist() == found.measurement_quantiles[:, :, 1, 0].tolist()
    uneven = WALK.forecast([np.array([0.1, 0.2]), np.array([0.3])], 2).to_xarray()
    assert uneven.time.values.tolist() == [0, 1] and uneven["t"].values.tolist() == [[2, 3], [1, 2]]
    assert WALK.forecast([0.1, 0.2], 0).to_xarray().sizes["time"] == 0


def test_datasets_go_through_files(xarray, tmp_path):
    pytest.importorskip("h5netcdf")
    pytest.importorskip("h5py")
    pandas = pytest.importorskip("pandas")
    y = pandas.Series([0.1, 0.2, 40.0, 0.3], index=pandas.date_range("2024-01-01", periods=4))
    for found in (WALK.filter(y, predictive=True), WALK.smooth(y, check=False), WALK.forecast(y, 2)):
        data = found.to_xarray()
        data.to_netcdf(tmp_path / "found.nc", engine="h5netcdf")
        with xarray.open_dataset(tmp_path / "found.nc", engine="h5netcdf") as again:
            assert again.equals(data)
            assert again.attrs["warnings"] == data.attrs["warnings"]


def test_paths_are_draws_of_arviz(xarray):
    pytest.importorskip("arviz")
    found = TWO.smooth([np.zeros((4, 2)), np.ones((2, 2))], paths=7)
    draws = found.to_arviz()
    x = draws["posterior"]["x"]
    assert x.dims == ("chain", "draw", "series", "time") and x.shape == (1, 7, 2, 4)
    assert x.sel(series="1").values[0, :, :2].tolist() == found.paths(1)[:, :, 0].tolist()
    assert np.isnan(x.sel(series="1").values[0, :, 2:]).all()
    assert draws["observed_data"]["z"].sel(series="0").values.tolist() == [0.0] * 4
    named = motes.Model(
        {"initial": {"draw": "normal(0, 1)"}, "transition": {"draw": "normal(draw, 1)"}, "measurement": {"y": "normal(draw, 1)"}}
    )
    with pytest.raises(ValueError, match="to_arviz: a coordinate of the model is called draw"):
        named.smooth([0.1, 0.2], paths=3).to_arviz()


@pytest.mark.parametrize(("library", "call"), [("xarray", "to_xarray"), ("arviz", "to_arviz")])
def test_what_is_not_there_is_asked_for(monkeypatch, library, call):
    import importlib

    load = importlib.import_module

    def missing(name, *more):
        if name == library:
            raise ModuleNotFoundError(name)
        return load(name, *more)

    monkeypatch.setattr(importlib, "import_module", missing)
    with pytest.raises(ModuleNotFoundError, match=f"{call} needs {library}: pip install {library}"):
        getattr(WALK.smooth([0.1, 0.2], paths=3), call)()
