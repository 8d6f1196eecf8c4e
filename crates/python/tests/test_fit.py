"""Parameters from data."""

import csv
import json
import os
import pickle
import subprocess

import numpy as np
import pytest

import motes

COMMAND = os.environ.get("MOTES_COMMAND")
FLOWS = [1120, 1160, 963, 1210, 1160, 1160, 813, 1230, 1370, 1140]


@pytest.fixture
def model(examples):
    return motes.Model(examples / "fit/nile.toml")


def fitted_of(model, **more):
    with pytest.warns(motes.MotesWarning, match="have not converged"):
        return model.fit(FLOWS, draws=50, **more)


def test_draws_have_names_and_shapes(model):
    fitted = fitted_of(model)
    assert fitted.parameters == ["measurement_variance", "level_variance"]
    assert fitted.draws["level_variance"].shape == fitted.log_evidence.shape == (4, 50)
    assert fitted.mean["level_variance"] == pytest.approx(fitted.draws["level_variance"].mean())
    assert "ESS bulk" in repr(fitted) and "<pre>" in fitted._repr_html_()
    found = fitted.to_json()
    assert set(found["parameters"]["level_variance"]) >= {"mean", "sd", "q05", "q50", "q95", "rhat", "ess_bulk", "ess_tail", "mcse"}
    assert pickle.loads(pickle.dumps(fitted)).draws["level_variance"].tolist() == fitted.draws["level_variance"].tolist()


def test_a_model_at_what_was_found(model):
    fitted = fitted_of(model)
    at_mean = model.with_parameters(fitted.mean)
    assert at_mean.parameters == pytest.approx(fitted.mean)
    assert np.isfinite(at_mean.filter(FLOWS, proposal="exact").log_evidence)
    models = fitted.models(10)
    values = [one.parameters["level_variance"] for one in models]
    assert len(set(values)) > 3 and set(values) <= set(fitted.draws["level_variance"].reshape(-1).tolist())
    # The model itself is as it was, and a copy goes through a pickle.
    assert model.parameters["level_variance"] != at_mean.parameters["level_variance"]
    assert pickle.loads(pickle.dumps(at_mean)).parameters == at_mean.parameters


def test_seeds_and_threads(model):
    one, two, other = fitted_of(model, threads=1), fitted_of(model, threads=2), fitted_of(model, seed=2)
    assert one.draws["level_variance"].tolist() == two.draws["level_variance"].tolist()
    assert one.draws["level_variance"].tolist() != other.draws["level_variance"].tolist()


def test_what_cannot_be_fitted(model, examples):
    with pytest.raises(ValueError, match="no parameter of nile has a prior"):
        motes.Model(examples / "nile.toml").fit(FLOWS)
    with pytest.raises(ValueError, match="draws: 3; it must be"):
        model.fit(FLOWS, draws=3)
    with pytest.raises(ValueError, match="budget: 0"):
        model.fit(FLOWS, budget=0)
    with pytest.raises(ValueError, match="nothing"):
        model.with_parameters({"nothing": 1.0})


def test_evidence(nile, examples):
    found = nile.evidence(examples / "nile.csv")
    assert found["proposal"] == "exact" and found["standard_error"] == 0.0
    counts = motes.Model({
        "initial": {"x": "normal(0, 1)"},
        "transition": {"x": "normal(x, 0.1)"},
        "measurement": {"y": "poisson(exp(x))"},
    })
    ahead, blind = counts.evidence([1, 0, 2, 9]), counts.evidence([1, 0, 2, 9], proposal="bootstrap", particles=20_000)
    assert ahead["proposal"] == "look-ahead"
    errors = np.hypot(ahead["standard_error"], blind["standard_error"])
    assert abs(ahead["log_evidence"] - blind["log_evidence"]) < 4 * errors + 0.02
    assert ahead["standard_error"] < blind["standard_error"]
    with pytest.raises(ValueError, match="runs: 0"):
        counts.evidence([1], runs=0)


@pytest.mark.skipif(COMMAND is None, reason="MOTES_COMMAND does not name the command motes")
def test_the_same_as_the_command(model, examples, tmp_path):
    data = examples / "nile.csv"
    arguments = ["fit", examples / "fit/nile.toml", data, "-o", tmp_path / "fit", "--draws", "60", "--json"]
    printed = subprocess.run([COMMAND, *map(str, arguments)], capture_output=True, text=True, check=True).stdout
    with pytest.warns(motes.MotesWarning):
        fitted = model.fit(data, draws=60)
    assert json.loads(printed)["parameters"] == fitted.to_json()["parameters"]
    with open(tmp_path / "fit/draws.csv") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["level_variance"]) for row in rows] == fitted.draws["level_variance"].reshape(-1).tolist()


def test_a_forecast_knows_how_unsure_parameters_are(model):
    fitted = fitted_of(model)
    over = fitted.predict(FLOWS, 5, proposal="exact", draws=40)
    at_mean = model.with_parameters(fitted.mean).forecast(FLOWS, 5, proposal="exact")
    assert over.mean.shape == (1, 5, 1) and over.measurement_quantiles.shape == (1, 5, 1, 3)
    # The variance of a mixture is at least the mean of those that are mixed.
    each = [one.forecast(FLOWS, 5, proposal="exact").sd for one in fitted.models(40)]
    assert (over.sd**2 >= np.mean(np.square(each), axis=0) - 1e-9).all()
    assert over.mean == pytest.approx(at_mean.mean, rel=0.1)
    assert len(over.to_pandas()) == 5
    with pytest.raises(ValueError, match="steps"):
        fitted.predict(FLOWS)
    with pytest.raises(TypeError, match="check"):
        fitted.predict(FLOWS, 2, check=True)


def test_log_evidence_at_many_parameters(model):
    values = {"measurement_variance": [15000.0, 9000.0], "level_variance": [1500.0, 1000.0]}
    found = model.log_evidence(FLOWS, parameters=values, particles=50)
    one_by_one = [
        model.with_parameters({name: of[at] for name, of in values.items()}).log_evidence(FLOWS, particles=50) for at in range(2)
    ]
    assert found.tolist() == one_by_one
    matrix = np.array(list(values.values())).T
    assert model.log_evidence(FLOWS, parameters=matrix, particles=50).tolist() == one_by_one
    # A negative variance gives no data.
    assert model.log_evidence(FLOWS, parameters={"level_variance": [-1.0]}, particles=50).tolist() == [-np.inf]
    with pytest.raises(ValueError, match=r"shape \(2, 1\); it must be \(n, 2\)"):
        model.log_evidence(FLOWS, parameters=matrix[:, :1])
    with pytest.raises(ValueError, match="there is no width; there are measurement_variance, level_variance"):
        model.log_evidence(FLOWS, parameters={"width": [1.0]})
    with pytest.raises(ValueError, match="as many values"):
        model.log_evidence(FLOWS, parameters={"level_variance": [1.0], "measurement_variance": [1.0, 2.0]})
