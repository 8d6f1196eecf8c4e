"""What is predicted over a posterior, beside distributions that are known."""

from __future__ import annotations

import motes
import numpy as np
import pytest


def model_of(measurement: str) -> motes.Model:
    return motes.Model(
        {
            "parameters": {"a": "normal(0, 1e-3)"},
            "initial": {"x": "normal(a, 1e-6)"},
            "transition": {"x": "normal(a, 1e-6)"},
            "measurement": {"y": measurement},
        }
    )


@pytest.mark.filterwarnings("ignore::motes.MotesWarning")
@pytest.mark.parametrize(
    ("measurement", "right", "tolerance"),
    [
        ("poisson(3*exp(x))", [0, 1, 3, 6, 8], 1),
        ("bernoulli(0.3 + 0*x)", [0, 0, 0, 1, 1], 0),
        ("exponential(exp(x))", [0.01, 0.051, 0.693, 2.996, 4.605], 0.35),
        ("student_t(2, x, 1)", [-6.965, -2.92, 0.0, 2.92, 6.965], 1.3),
    ],
)
def test_quantiles_of_predictions_are_those_of_the_distribution(measurement: str, right: list[float], tolerance: float):
    data = [1, 0, 1, 0, 1] if measurement.startswith("b") else [1, 0, 2, 3, 1]
    model = model_of(measurement)
    found = model.fit(data, draws=30).predict(data, 1, draws=30, quantiles=[0.01, 0.05, 0.5, 0.95, 0.99], particles=4000)
    quantiles = found.measurement_quantiles[0, 0, 0]
    assert np.all(np.abs(quantiles - right) <= tolerance), quantiles
    if measurement[0] in "pb":
        assert np.all(quantiles == np.round(quantiles))


@pytest.mark.filterwarnings("ignore::motes.MotesWarning")
def test_the_columns_of_a_summary_are_in_their_order():
    pytest.importorskip("pandas")
    summary = model_of("normal(x, 1)").fit([1, 0, 2], draws=30).summary()
    assert list(summary.columns) == ["mean", "sd", "q05", "q50", "q95", "rhat", "ess_bulk", "ess_tail", "mcse"]


def test_simulations_along_dates_have_these_dates():
    pandas = pytest.importorskip("pandas")
    model = motes.Model(
        {
            "time": {"column": "day", "unit": "day"},
            "inputs": {"u": "hold"},
            "initial": {"x": "normal(0, 1)"},
            "transition": {"x": "normal(x + u, 1)"},
            "measurement": {"y": "normal(x, 1)"},
        }
    )
    days = ["2024-02-28", "2024-02-29", "2024-03-02"]
    simulated = model.simulate(inputs=pandas.DataFrame({"day": days, "u": [0.0, 1.0, 2.0]}))
    frame = simulated.to_pandas()
    assert list(frame["day"]) == days
    assert model.filter(frame).log_evidence < 0
