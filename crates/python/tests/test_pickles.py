"""Everything can be pickled and copied, and goes on as the original does."""

import copy
import pickle
import subprocess
import sys

import numpy as np
import pytest

import motes

WALK = {
    "parameters": {"q": 0.5},
    "initial": {"x": "normal(0, 1)"},
    "transition": {"x": "normal(0.9*x, q)"},
    "measurement": {"y": "normal(x, 0.5)"},
}

WAYS = [copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))]


def moved(step, x):
    return [motes.normal(0.9 * x[:, 0], 0.5)]


def measured(step, x):
    return [motes.normal(x[:, 0], 0.5)]


def of_functions(transition=moved):
    return motes.of_functions([motes.normal(0.0, 1.0)], transition, measured, states=["x"], measurements=["y"])


def of_matrices():
    return motes.linear_gaussian(A=[[0.9]], C=[[1.0]], Q=[[1.0]], R=[[0.5]], m0=[0.0], P0=[[1.0]])


@pytest.fixture(params=["file", "dict", "text", "matrices", "functions"])
def model(request, examples):
    return {
        "file": lambda: motes.Model(examples / "growth.toml", set={"q": 5.0}),
        "dict": lambda: motes.Model(WALK, set={"q": 0.6}),
        "text": lambda: motes.Model.parse((examples / "nile.toml").read_text(), name="nile"),
        "matrices": of_matrices,
        "functions": of_functions,
    }[request.param]()


def test_models(model):
    y = model.simulate(20, seed=2).measurements[0]
    expected = model.filter(y, particles=50)
    for way in WAYS:
        again = way(model)
        assert (again.name, again.states, again.measurements) == (model.name, model.states, model.measurements)
        assert again.parameters == model.parameters and repr(again) == repr(model)
        assert again.filter(y, particles=50).mean.tolist() == expected.mean.tolist()


def test_a_model_of_a_file_needs_it_no_more(examples, tmp_path):
    path = tmp_path / "walk.toml"
    path.write_text((examples / "growth.toml").read_text())
    pickled = pickle.dumps(motes.Model(path))
    path.unlink()
    assert pickle.loads(pickled).states == motes.Model(examples / "growth.toml").states


def test_messages_are_those_of_the_original():
    model = motes.Model({**WALK, "transition": {"x": "normal(x, x)"}})
    for way in WAYS:
        with pytest.raises(ValueError, match=r"^row 1, t = 1: model, \[transition\] x: sd"):
            way(model).filter([1.0, 2.0])


def test_functions_that_cannot_be_pickled_are_named():
    model = of_functions(lambda step, x: [motes.normal(x[:, 0], 1.0)])
    with pytest.raises((AttributeError, TypeError, pickle.PicklingError), match="lambda"):
        pickle.dumps(model)
    # Nothing of functions is needed for what was found, nor for copies of a model.
    found = pickle.loads(pickle.dumps(model.filter([0.1, 0.2], particles=20)))
    assert found.mean.shape == (2, 1)
    assert copy.deepcopy(model).filter([0.1, 0.2], particles=20).mean.tolist() == found.mean.tolist()


def test_results(tmp_path):
    pandas = pytest.importorskip("pandas")
    model = motes.Model(WALK)
    data = pandas.Series([0.1, None, 0.4, 0.2], index=pandas.date_range("2024-01-01", periods=4))
    filtered, smoothed = model.filter(data, proposal="linearised"), model.smooth(data, paths=5)
    forecast = model.forecast(data, 3)
    for way in WAYS:
        for found in (filtered, smoothed, forecast.filtered):
            again = way(found)
            assert type(again) is type(found) and repr(again) == repr(found)
            assert again.to_csv() == found.to_csv() and again.to_html() == found.to_html()
            assert again.to_json() == found.to_json() and again.warnings == found.warnings
            assert again.to_pandas().equals(found.to_pandas())
            np.testing.assert_array_equal(again.quantiles, found.quantiles)
            np.testing.assert_array_equal(again.measurements, found.measurements)
        assert way(filtered).ess.tolist() == filtered.ess.tolist()
        assert way(smoothed).paths().tolist() == smoothed.paths().tolist()
        again = way(forecast)
        assert again.to_pandas().equals(forecast.to_pandas()) and again.to_csv() == forecast.to_csv()
        drawn = model.simulate(5, 2)
        assert way(drawn).to_pandas().equals(drawn.to_pandas())


def test_learned_proposals_and_cards():
    model = motes.Model(WALK)
    learned = model.learn(updates=20, sequences=2, particles=20)
    y = model.simulate(20, seed=3).measurements[0]
    expected = model.filter(y, proposal=learned.proposal, particles=50)
    for way in WAYS:
        again = way(learned)
        assert repr(again) == repr(learned) and again.validation.tolist() == learned.validation.tolist()
        assert again.card.figures == learned.card.figures and again.card.to_html() == learned.card.to_html()
        assert model.filter(y, proposal=again.proposal, particles=50).mean.tolist() == expected.mean.tolist()
        # A copy of a copy, and one for the pickled model.
        twice = way(again.proposal)
        assert twice._model.filter(y, proposal=twice, particles=50).mean.tolist() == expected.mean.tolist()


def known(online):
    return (online.mean.tolist(), online.sd.tolist(), online.quantiles.tolist(), online.ess, online.log_evidence, online.pareto_k)


def test_a_stream_goes_on_from_a_checkpoint_to_the_last_bit(model):
    y = [None, *model.simulate(30, seed=4).measurements[0].tolist()]
    for way in WAYS:
        online = model.online(particles=200, seed=5)
        for at, row in enumerate(y):
            row = [np.nan] * len(model.measurements) if row is None else row
            if at in (0, 1, 13):
                again, expected = way(online), way(online)
                for later in y[max(at, 1) : at + 10]:
                    assert known(again.step(later)) == known(expected.step(later))
                before = known(online)
                assert known(again.predict()) == known(expected.predict())
                np.testing.assert_equal(known(online), before)
                assert online.log_evidence == before[4]
            online.step(row)
    assert model.online().__class__ is motes.OnlineFilter


def test_a_copy_shares_nothing_with_the_original():
    model = motes.Model(WALK)
    for way in WAYS:
        online = model.online(proposal="linearised").step(0.3)
        never_copied = model.online(proposal="linearised").step(0.3)
        way(online).step(2.0).mean[0] = 7.0
        assert known(online) == known(never_copied)
        assert known(online.step(0.5)) == known(never_copied.step(0.5))


def test_a_stream_goes_on_in_another_process(tmp_path):
    model = motes.Model(WALK)
    learned = model.learn(updates=5, sequences=0).proposal
    online = model.online(proposal=learned, particles=100).step(0.3).step(None)
    (tmp_path / "checkpoint").write_bytes(pickle.dumps(online))
    script = "import pickle, sys; print(pickle.load(open(sys.argv[1], 'rb')).step(0.7).mean[0].hex())"
    done = subprocess.run([sys.executable, "-c", script, tmp_path / "checkpoint"], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == float(online.step(0.7).mean[0]).hex()


def test_a_filter_that_failed_has_failed():
    model = motes.Model({**WALK, "measurement": {"y": "uniform(x - 0.1, x + 0.1)"}})
    online = model.online()
    with pytest.raises(ValueError, match="no particle explains"):
        online.step(50.0)
    for way in WAYS:
        with pytest.raises(ValueError, match="the filter failed in an earlier step"):
            way(online).step(0.0)


def test_damaged_bytes_are_refused_in_a_line():
    from motes import _motes

    model = motes.Model(WALK)
    online = model.online()
    checkpoint, _ = online.__getstate__()["_running"]
    options = _motes.FilterOptions(check=False)
    for wrong in (b"", checkpoint[:-1], checkpoint[:50] + b"x" + checkpoint[51:]):
        for read in (
            lambda wrong: _motes.Online.resume(model._model, options, wrong, False),
            _motes.Data,
            _motes.Card,
            model._model.proposal_of_bytes,
        ):
            with pytest.raises(ValueError, match="its bytes are not as they were written") as refused:
                read(wrong)
            assert "\n" not in str(refused.value)


def test_joblib():
    joblib = pytest.importorskip("joblib")
    model = motes.Model(WALK)
    series = model.simulate(10, 4, seed=1).measurements
    found = joblib.Parallel(n_jobs=2)(joblib.delayed(model.filter)(one, particles=20, threads=1) for one in series)
    assert [one.log_evidence for one in found] == [model.filter(one, particles=20).log_evidence for one in series]
