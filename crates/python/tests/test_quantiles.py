"""Quantiles of one's own choice."""

import copy
import os
import pickle
import subprocess

import numpy as np
import pytest

import motes

COMMAND = os.environ.get("MOTES_COMMAND")
WALK = motes.Model({"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, 1)"}, "measurement": {"y": "normal(x, 1)"}})
Y = [0.1, None, 0.4, 1.2]
#: Standard normal numbers at 2.5, 10 and 97.5 %.
ASKED, NORMAL = (0.025, 0.1, 0.975), np.array([-1.959964, -1.281552, 1.959964])


def are_normal(quantiles, mean, sd):
    np.testing.assert_allclose(quantiles, mean[..., None] + NORMAL * sd[..., None], rtol=1e-5, atol=1e-5)


def test_filters_smoothers_and_forecasts_have_them():
    settings = {"proposal": "exact", "quantiles": ASKED}
    filtered, smoothed = WALK.filter(Y, **settings, predictive=True), WALK.smooth(Y, **settings)
    forecast = WALK.forecast(Y, 2, **settings)
    assert filtered.probabilities == smoothed.probabilities == forecast.probabilities == list(ASKED)
    assert filtered.quantiles.shape == (4, 1, 3) and forecast.measurement_quantiles.shape == (1, 2, 1, 3)
    are_normal(filtered.quantiles, filtered.mean, filtered.sd)
    are_normal(filtered.predictive_quantiles, filtered.predictive_mean, filtered.predictive_sd)
    are_normal(smoothed.quantiles, smoothed.mean, smoothed.sd)
    are_normal(forecast.quantiles, forecast.mean, forecast.sd)
    are_normal(forecast.measurement_quantiles, forecast.measurement_mean, forecast.measurement_sd)
    online = WALK.online(**settings, predictive=True)
    assert np.isnan(online.quantiles).all() and online.quantiles.shape == (1, 3)
    for row, y in enumerate(Y):
        online.step(y)
        np.testing.assert_allclose(online.quantiles, filtered.quantiles[row])
        np.testing.assert_allclose(online.measurement_quantiles, filtered.predictive_quantiles[row])
    again = pickle.loads(pickle.dumps(online))
    assert again.predict().quantiles.tolist() == online.predict().quantiles.tolist()
    assert "2.5 %  97.5 %" in repr(online) and "2.5 %" in repr(forecast) and "97.5 %" in repr(forecast)


def test_those_of_particles_are_those_of_their_weights():
    levels = np.arange(1, 20) / 20
    found = WALK.filter(Y, quantiles=levels, keep_particles=True, particles=500)
    for row in range(len(Y)):
        order = np.argsort(found.particles[row, :, 0])
        below = np.cumsum(found.weights[row, order])
        # The smallest value below which, itself included, is that share.
        expected = found.particles[row, order, 0][[np.flatnonzero(below >= level - 1e-12)[0] for level in levels]]
        np.testing.assert_array_equal(found.quantiles[row, 0], expected)
    assert (np.diff(found.quantiles[:, 0]) >= 0).all()


def test_tables_name_them():
    pandas = pytest.importorskip("pandas")
    found = WALK.filter(Y, quantiles=[0.025, 0.5, 0.9])
    columns = ["t", "x_mean", "x_sd", "x_q025", "x_q50", "x_q90", "ess", "log_evidence"]
    assert found.to_csv().splitlines()[0] == ",".join(columns)
    frame = found.to_pandas()
    assert list(frame.columns) == columns and frame["x_q025"].tolist() == found.quantiles[:, 0, 0].tolist()
    ahead = WALK.forecast(Y, 2, quantiles=[0.3]).to_pandas()
    assert list(ahead.columns) == ["t", "x_mean", "x_sd", "x_q30", "y_mean", "y_sd", "y_q30"]
    assert isinstance(ahead, pandas.DataFrame)
    for again in (copy.deepcopy(found), pickle.loads(pickle.dumps(found))):
        assert again.to_csv() == found.to_csv() and again.probabilities == found.probabilities
        assert "from the 2.5 % to the 90 % quantile" in again.to_html()


def test_datasets_and_plots_name_them():
    pytest.importorskip("xarray")
    found = WALK.filter(Y, quantiles=[0.1, 0.9])
    data = found.to_xarray()
    assert data["quantile"].values.tolist() == [0.1, 0.9]
    assert data["quantiles"].sel(quantile=0.9).values.reshape(-1).tolist() == found.quantiles[:, 0, 1].tolist()
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot
    (axis,) = found.plot()
    assert axis.get_legend_handles_labels()[1] == ["10 to 90 %", "mean"]
    edges = axis.collections[0].get_paths()[0].vertices[:, 1]
    assert {*found.quantiles[:, 0].reshape(-1).tolist()} <= {*edges.tolist()}
    (axis,) = WALK.forecast(Y, 2, quantiles=[0.025, 0.975]).plot(["x"])
    assert "forecast, 2.5 to 97.5 %" in axis.get_legend_handles_labels()[1]
    (axis,) = WALK.smooth(Y, paths=20, quantiles=0.5).plot()
    assert axis.get_legend_handles_labels()[1] == ["50 %", "mean"]
    matplotlib.pyplot.close("all")


def test_what_cannot_be_quantiles_is_refused_in_a_line():
    expected = "it must be probabilities above 0 and below 1, each above the one before, as in 0.05,0.5,0.95"
    for wrong in ([0.0, 0.5], [0.5, 1.0], [0.5, 0.1], [0.5, 0.5], [], [float("nan")], [-0.1], [5, 95]):
        for call in (WALK.filter, WALK.smooth, lambda y, **more: WALK.forecast(y, 1, **more)):
            with pytest.raises(ValueError) as refused:
                call(Y, quantiles=wrong)
            assert str(refused.value).startswith("quantiles: [") and str(refused.value).endswith(f"; {expected}")
        with pytest.raises(ValueError, match="^quantiles: "):
            WALK.online(quantiles=wrong)
    for wrong in ("half", ["a"], None, [[0.1], [0.2, 0.3]]):
        with pytest.raises(ValueError, match="^quantiles: .*probabilities"):
            WALK.filter(Y, quantiles=wrong)


def test_forecasts_over_the_posterior_have_them(examples):
    model = motes.Model(examples / "fit/nile.toml")
    with pytest.warns(motes.MotesWarning, match="have not converged"):
        fitted = model.fit([1120, 1160, 963, 1210, 1160, 1160, 813, 1230, 1370, 1140], draws=50)
    asked = (0.05, 0.25, 0.5, 0.75, 0.95)
    found = fitted.predict([1120, 1160], 3, proposal="exact", quantiles=asked, draws=20)
    usual = fitted.predict([1120, 1160], 3, proposal="exact", draws=20)
    assert found.quantiles.shape == (1, 3, 1, 5) and found.measurement_quantiles.shape == (1, 3, 1, 5)
    for ours, theirs in ((found.quantiles, usual.quantiles), (found.measurement_quantiles, usual.measurement_quantiles)):
        assert ours[..., [0, 2, 4]].tolist() == theirs.tolist() and (np.diff(ours) > 0).all()
    assert "none, of an average over draws" in repr(found.filtered)


@pytest.mark.skipif(COMMAND is None, reason="MOTES_COMMAND does not name the command motes")
def test_the_same_as_the_command(examples, nile):
    data, asked = examples / "nile.csv", ["--quantiles", "0.025,0.5,0.975"]
    for name, more, call in (
        ("filter", ["--forecast", "2"], lambda **set: nile.forecast(data, 2, **set).filtered),
        ("smooth", [], lambda **set: nile.smooth(data, **set)),
    ):
        command = [COMMAND, name, examples / "nile.toml", data, *asked, *more]
        table = subprocess.run([*map(str, command)], capture_output=True, text=True, check=True).stdout
        assert call(quantiles=(0.025, 0.5, 0.975)).to_csv() == table
