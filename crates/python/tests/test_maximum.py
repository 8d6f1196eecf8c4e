"""The maximum of the likelihood."""

import copy
import json
import os
import pickle
import subprocess
import warnings

import numpy as np
import pytest

import motes

COMMAND = os.environ.get("MOTES_COMMAND")


@pytest.fixture
def model(examples):
    return motes.Model(examples / "fit/nile.toml")


@pytest.fixture
def flows(examples):
    return examples / "nile.csv"


def test_the_maximum_has_intervals(model, flows):
    found = model.fit(flows, method="maximum")
    assert isinstance(found, motes.MaximumFit) and found.parameters == ["measurement_variance", "level_variance"]
    # Durbin and Koopman (2012), section 2.10: 15099 and 1469.1.
    assert found.estimates["measurement_variance"].estimate == pytest.approx(15099, rel=0.01)
    assert found.values["level_variance"] == pytest.approx(1469.1, rel=0.02)
    for name, of in found.estimates.items():
        assert of.low < of.estimate < of.high
        profile = found.profiles[name]
        assert profile.shape[1] == 3 and profile[:, 1].max() <= found.log_likelihood + 1e-3
        assert profile[:, 0].min() <= of.low and profile[:, 0].max() >= of.high
    assert found.level == 0.9 and found.log_likelihood_error == 0.0 and found.warnings == []
    assert found.aic == pytest.approx(4 - 2 * found.log_likelihood)
    at = found.model()
    assert at.parameters == pytest.approx(found.values)
    assert at.filter(flows, proposal="exact").log_evidence == pytest.approx(found.log_likelihood)


def test_it_is_shown_and_copied(model, flows):
    found = model.fit(flows, method="maximum")
    assert "90 % interval from" in repr(found) and f"log-likelihood: {found.log_likelihood:.3f}, exact" in repr(found)
    assert "<pre>" in found._repr_html_()
    for again in (copy.copy(found), copy.deepcopy(found), pickle.loads(pickle.dumps(found))):
        assert again.estimates == found.estimates and repr(again) == repr(found) and again.model().parameters == found.model().parameters
    pytest.importorskip("pandas")
    summary = found.summary()
    assert list(summary.columns) == ["estimate", "low", "high"] and list(summary.index) == found.parameters
    assert summary.loc["level_variance", "low"] == found.estimates["level_variance"].low
    assert model.fit(flows, method="maximum", profile="level_variance").summary()["high"].isna().tolist() == [True, False]


def test_profiles_of_some_parameters_alone(model, flows):
    found = model.fit(flows, method="maximum", profile="level_variance")
    assert found.estimates["level_variance"].low is not None
    assert found.estimates["measurement_variance"].low is None and len(found.profiles["measurement_variance"]) == 0
    with pytest.raises(ValueError, match="^profile width: that is no free parameter; there are measurement_variance, level_variance$"):
        model.fit(flows, method="maximum", profile=["width"])


def test_seeds_and_threads(model):
    y = [1120, 1160, 963, 1210, 1160, 1160, 813, 1230, 1370, 1140]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", motes.MotesWarning)
        one, two = (model.fit(y, method="maximum", particles=30, proposal="bootstrap", threads=threads) for threads in (1, 2))
        other = model.fit(y, method="maximum", particles=30, proposal="bootstrap", seed=2)
    assert one.estimates == two.estimates and one.values != other.values
    assert one.log_likelihood_error > 0


def test_passes_of_iterated_filtering(model):
    y = [1120, 1160, 963, 1210, 1160, 1160, 813, 1230, 1370, 1140]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", motes.MotesWarning)
        found = model.fit(y, method="maximum", proposal="bootstrap", particles=50, passes=3, chains=2)
    assert "by 3 passes of iterated filtering" in repr(found) and found.to_json()["passes"] == 3
    # That of the best search is estimated anew.
    assert len(found.search_log_likelihoods) == 2 and abs(max(found.search_log_likelihoods) - found.log_likelihood) < 1
    assert all(of.low is None for of in found.estimates.values())


def test_what_cannot_be_asked_of_it(model, flows, examples):
    refused = {
        "^method: mode; it must be posterior or maximum$": {"method": "mode"},
        "^draws: the maximum draws nothing": {"method": "maximum", "draws": 100},
        "^budget: the maximum draws nothing": {"method": "maximum", "budget": 3.0},
        "^profile: draws of the posterior have no profiles; take method='maximum'$": {"profile": "level_variance"},
        "^passes: they seek a maximum; take method='maximum'$": {"passes": 3},
        "^passes: 0; it must be": {"method": "maximum", "passes": 0},
        "^passes: iterated filtering takes the bootstrap filter": {"method": "maximum", "passes": 3},
        "^chains: 0; it must be": {"method": "maximum", "chains": 0},
    }
    for line, arguments in refused.items():
        with pytest.raises(ValueError, match=line):
            model.fit(flows, **arguments)
    with pytest.raises(ValueError, match="no parameter of nile has a prior"):
        motes.Model(examples / "nile.toml").fit(flows, method="maximum")


def test_it_warns_where_it_cannot_be_trusted(examples, flows):
    # The data know the product of two parameters, and neither of them.
    model = motes.Model(examples / "fit/product.toml")
    with pytest.warns(motes.MotesWarning):
        found = model.fit(flows, method="maximum")
    assert found.warnings


@pytest.mark.skipif(COMMAND is None, reason="MOTES_COMMAND does not name the command motes")
def test_the_same_as_the_command(model, examples, flows, tmp_path):
    arguments = ["fit", examples / "fit/nile.toml", flows, "-o", tmp_path / "command", "--method", "maximum", "--json"]
    printed = json.loads(subprocess.run([COMMAND, *map(str, arguments)], capture_output=True, text=True, check=True).stdout)
    found = model.fit(flows, method="maximum")
    ours = found.to_json()
    assert {**printed, "seconds": 0} == {**ours, "seconds": 0}
    found.save(tmp_path / "python")
    names = sorted(path.name for path in (tmp_path / "command").iterdir())
    assert names == ["fit.toml", "maximum.csv", "profile.csv", "states.csv", "summary.json"]
    for name in set(names) - {"states.csv"}:
        assert (tmp_path / "command" / name).read_bytes() == (tmp_path / "python" / name).read_bytes(), name
    # The command goes on from there.
    filtered = [COMMAND, "filter", examples / "fit/nile.toml", flows, "--parameters", tmp_path / "python", "-q", "--proposal", "exact"]
    table = subprocess.run([*map(str, filtered)], capture_output=True, text=True, check=True).stdout
    assert found.model().filter(flows, proposal="exact").to_csv() == table


@pytest.mark.skipif(COMMAND is None, reason="MOTES_COMMAND does not name the command motes")
def test_a_posterior_is_written_as_the_command_writes_it(model, examples, flows, tmp_path):
    arguments = ["fit", examples / "fit/nile.toml", flows, "-o", tmp_path / "command", "--draws", "60"]
    subprocess.run([COMMAND, *map(str, arguments)], capture_output=True, check=True)
    with pytest.warns(motes.MotesWarning):
        fitted = model.fit(flows, draws=60)
    copy.deepcopy(fitted).save(tmp_path / "python")
    for name in ("draws.csv", "fit.toml", "summary.json"):
        assert (tmp_path / "command" / name).read_bytes() == (tmp_path / "python" / name).read_bytes(), name
    (tmp_path / "other").mkdir()
    (tmp_path / "other/notes.txt").write_text("mine")
    with pytest.raises(OSError, match="none of a fit"):
        fitted.save(tmp_path / "other")
    assert np.isfinite(fitted.log_evidence).all()
