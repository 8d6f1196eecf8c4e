"""Distributions that functions of a model return: what may be done with them."""

import numpy as np
import pytest

import motes


def test_counts_can_be_neither_shifted_nor_scaled():
    for moved in (lambda: 1 + motes.poisson(2.0), lambda: motes.bernoulli(0.5) * 2, lambda: -motes.binomial(3, 0.5)):
        with pytest.raises(TypeError, match="counts can be neither"):
            moved()
    one = motes.normal(0.0, 1.0)
    for both in (lambda: one * one, lambda: one + one, lambda: one - one, lambda: one / one):
        with pytest.raises(TypeError, match="normal and normal: a distribution is shifted and scaled by numbers"):
            both()
    with pytest.raises(TypeError, match="normal and None"):
        one + None
    counted = motes.of_functions(
        [one],
        lambda step, x: [motes.normal(x[:, 0], 1.0)],
        lambda step, x: motes.negative_binomial(np.exp(0.01 * x), 3.0),
        states=["x"],
        measurements=["y"],
    )
    assert counted.filter([1, 0, 4], particles=50).log_evidence < 0


def test_shifts_and_factors_add_up():
    one = 3.0 - 2 * (motes.exponential(1.0) + 1.0) / 4
    assert (one.scale, one.shift) == (-0.5, 2.5)
