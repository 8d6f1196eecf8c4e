"""Particles that are kept, and what is computed of them."""

import copy
import pickle

import numpy as np
import pytest

import motes

TWO = motes.Model(
    {
        "initial": {"x": "normal(0, 1)", "v": "normal(0, 1)"},
        "transition": {"x": "normal(x + v, 1)", "v": "normal(v, 0.5)"},
        "measurement": {"y": "normal(x, 1)"},
    }
)
Y = [0.3, None, 1.9, 2.2]


@pytest.fixture(scope="module")
def kept():
    return TWO.filter(Y, particles=3000, keep_particles=True)


def test_they_are_the_filtering_distribution(kept):
    assert kept.particles.shape == (4, 3000, 2) and kept.weights.shape == (4, 3000)
    assert kept.weights.sum(axis=1) == pytest.approx(np.ones(4)) and (kept.weights >= 0).all()
    mean = (kept.weights[:, :, None] * kept.particles).sum(axis=1)
    assert mean == pytest.approx(kept.mean)
    assert 1 / np.square(kept.weights).sum(axis=1) == pytest.approx(kept.ess)
    # Nothing else changes.
    plain = TWO.filter(Y, particles=3000)
    assert plain.to_csv() == kept.to_csv() and kept.particle_count == plain.particle_count == 3000


def test_rows_of_series_stand_in_the_order_of_the_data():
    frame = {"series": list("abab"), "y": [0.1, 5.0, 0.2, 6.0]}
    found = TWO.filter(frame, particles=200, keep_particles=True, check=False)
    mean = (found.weights[:, :, None] * found.particles).sum(axis=1)
    assert mean == pytest.approx(found.mean) and (found.mean[[1, 3], 0] > 1).all() and (found.mean[[0, 2], 0] < 1).all()


def test_covariance(kept):
    assert kept.covariance.shape == (4, 2, 2)
    np.testing.assert_allclose(np.sqrt(np.diagonal(kept.covariance, axis1=1, axis2=2)), kept.sd, rtol=1e-9)
    for row in range(4):
        expected = np.cov(kept.particles[row].T, aweights=kept.weights[row], ddof=0)
        np.testing.assert_allclose(kept.covariance[row], expected, rtol=1e-9)
    # Position and velocity go together after a step.
    assert kept.covariance[2, 0, 1] > 0.1
    # One particle says nothing of a spread.
    assert np.isnan(TWO.filter(Y, particles=1, keep_particles=True, check=False).covariance).all()


def test_expectations(kept):
    np.testing.assert_allclose(kept.expectation(lambda x: x[:, 0]), kept.mean[:, 0])
    np.testing.assert_allclose(kept.expectation(lambda x: x), kept.mean)
    square = kept.expectation(lambda x: x[:, :, None] * x[:, None, :])
    np.testing.assert_allclose(square - kept.mean[:, :, None] * kept.mean[:, None, :], kept.covariance, atol=1e-9)
    above = kept.expectation(lambda x: x[:, 0] > kept.quantiles[-1, 0, 1])
    assert above.shape == (4,) and above[-1] == pytest.approx(0.5, abs=0.01)
    # What is no number where a particle has no weight has no say.
    edges = motes.Model({"initial": {"x": "normal(0, 1)"}, "transition": {"x": "x"}, "measurement": {"y": "uniform(-1, abs(x))"}})
    found = edges.filter([0.2], particles=500, keep_particles=True, check=False)
    assert 0 < (found.weights[0] == 0).sum() < 500
    with np.errstate(invalid="ignore"):
        assert np.isfinite(found.expectation(lambda x: np.log(abs(x[:, 0]) - 0.2))).all()
    for wrong in (lambda x: 1.0, lambda x: x[0], lambda x: x.T):
        with pytest.raises(ValueError, match=r"of: values of shape .*; it must have a number, or an array, for each of 3000 particles$"):
            kept.expectation(wrong)


def test_who_did_not_ask_is_told_how():
    plain = TWO.filter(Y, particles=50)
    for name in ("particles", "weights", "covariance"):
        with pytest.raises(AttributeError, match=rf"^{name}: particles were not kept; filter\(…, keep_particles=True\) keeps them$"):
            getattr(plain, name)
        assert not hasattr(plain, name)
    with pytest.raises(AttributeError, match="keep_particles=True"):
        plain.expectation(lambda x: x)
    with pytest.raises(ValueError, match="^keep_particles: proposal exact has no particles; leave one of the two out$"):
        TWO.filter(Y, proposal="exact", keep_particles=True)


def test_copies_and_pictures_of_them(kept):
    for again in (copy.copy(kept), copy.deepcopy(kept), pickle.loads(pickle.dumps(kept))):
        assert again.particles.tolist() == kept.particles.tolist() and again.weights.tolist() == kept.weights.tolist()
        assert again.covariance.tolist() == kept.covariance.tolist() and repr(again) == repr(kept)


def test_datasets_have_them():
    pytest.importorskip("xarray")
    found = TWO.filter([np.array([0.1, 0.2, 0.3]), np.array([0.4])], particles=20, keep_particles=True, check=False)
    data = found.to_xarray()
    assert dict(data["particles"].sizes) == {"series": 2, "time": 3, "particle": 20, "state": 2}
    assert data["particles"].sel(series="1").values[0].tolist() == found.particles[3].tolist()
    assert np.isnan(data["weights"].sel(series="1").values[1:]).all()
    np.testing.assert_allclose((data["particles"] * data["weights"]).sum("particle", skipna=False), data["mean"])
    assert data.attrs["particles"] == 20 and "particles" not in TWO.filter(Y).to_xarray()
