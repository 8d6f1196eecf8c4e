"""Seeds: integers, generators of NumPy, and None."""

import copy
import pickle

import numpy as np
import pytest

import motes

WALK = motes.Model(
    {
        "parameters": {"sd": "half_normal(2)"},
        "initial": {"x": "normal(0, 1)"},
        "transition": {"x": "normal(x, sd)"},
        "measurement": {"y": "normal(x, 1)"},
    },
)
PLAIN = motes.Model({"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, 1)"}, "measurement": {"y": "normal(x, 1)"}})
Y = [0.3, 1.2, None, 0.7]


def learned(seed):
    """What a filter finds by a network that was learned."""
    proposal = PLAIN.learn(base="transition", head="gaussian", updates=3, sequences=0, steps=5, seed=seed).proposal
    return PLAIN.filter(Y, proposal=proposal, particles=20).to_csv()


def compared(seed):
    return WALK.compare(proposals="bootstrap", sweep=[10], sequences=2, steps=5, seed=seed).methods["bootstrap"]["e_l"]


CALLS = {
    "simulate": lambda seed: WALK.simulate(5, seed=seed).states.tolist(),
    "check": lambda seed: WALK.check(Y, seed=seed),
    "filter": lambda seed: WALK.filter(Y, seed=seed).to_csv(),
    "smooth": lambda seed: WALK.smooth(Y, seed=seed, particles=50).to_csv(),
    "forecast": lambda seed: WALK.forecast(Y, 3, seed=seed).to_csv(),
    "log_evidence": lambda seed: WALK.log_evidence(Y, seed=seed),
    "online": lambda seed: WALK.online(seed=seed).step(0.4).mean.tolist(),
    "evidence": lambda seed: WALK.evidence(Y, proposal="bootstrap", particles=20, seed=seed)["log_evidence"],
    "fit": lambda seed: WALK.fit(Y, draws=10, chains=2, seed=seed).draws["sd"].tolist(),
    "learn": learned,
    "compare": compared,
}


@pytest.mark.parametrize("name", CALLS)
def test_a_generator_gives_a_draw_of_63_bits(name):
    call = CALLS[name]
    drawn = int(np.random.default_rng(5).integers(2**63))
    generator = np.random.default_rng(5)
    first = call(generator)
    assert first == call(drawn)
    # It moved on by one draw, and by no more.
    assert int(generator.integers(2**63)) == int(np.random.default_rng(5).integers(2**63, size=2)[1])
    if name != "check":
        assert call(drawn + 1) != first


def test_none_is_another_each_time_and_is_told():
    one, other = WALK.filter(Y, seed=None), WALK.filter(Y, seed=None)
    assert one.seed != other.seed and one.to_csv() != other.to_csv()
    assert WALK.filter(Y, seed=one.seed).to_csv() == one.to_csv()
    for found in (
        WALK.simulate(3, seed=None),
        WALK.smooth(Y, seed=None, particles=50),
        WALK.forecast(Y, 2, seed=None),
        WALK.online(seed=None),
        WALK.fit(Y, draws=10, chains=2, seed=None),
        WALK.learn(updates=2, sequences=0, steps=5, seed=None),
    ):
        assert 0 <= found.seed < 2**63 and found.seed != 1
    fitted = WALK.fit(Y, draws=10, chains=2, seed=None)
    predicted = fitted.predict(Y, 2, seed=None, draws=4)
    assert fitted.predict(Y, 2, seed=predicted.seed, draws=4).to_csv() == predicted.to_csv()


def test_a_filter_on_line_keeps_what_it_drew():
    generator = np.random.default_rng(3)
    online = WALK.online(seed=generator).step(0.2)
    generator.integers(10, size=7)
    for again in (copy.deepcopy(online), pickle.loads(pickle.dumps(online))):
        assert again.seed == online.seed
        assert again.step(0.5).mean.tolist() == copy.deepcopy(online).step(0.5).mean.tolist()


def test_integers_of_numpy_are_integers_and_others_are_refused():
    assert WALK.filter(Y, seed=np.int64(7)).to_csv() == WALK.filter(Y, seed=7).to_csv()
    for seed in ("7", 7.0, np.random.RandomState(1)):
        with pytest.raises(TypeError, match=r"seed: \w+; it must be an integer, a numpy.random.Generator, or None"):
            WALK.filter(Y, seed=seed)
