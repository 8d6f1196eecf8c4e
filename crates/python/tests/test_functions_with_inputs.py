"""Models in functions with times, inputs and parameters, and with states that are known, follow or are counts."""

import copy
import pickle
import warnings

import numpy as np
import pytest

import motes

FRAME = {
    "inputs": {"pump": "hold"},
    "parameters": {"leak": "log_normal(log(0.2), 0.5)", "sd": [0.3, 0.2]},
    "series": {"by": "tank"},
}
WHOLE = {"column": "hour"}
IN_PARTS = {"column": "hour", "step": 0.5}


def of_dict(time):
    return motes.Model(
        {
            "time": time,
            **FRAME,
            "initial": {"x": "normal(1, 0.5)"},
            "transition": {"x": "normal(x + (pump - leak*x)*dt, sd[0]*sqrt(dt))"},
            "measurement": {"y": "normal(x*x/2 + pump + t/100, sd[1])"},
        }
    )


def initial(parameters):
    return [motes.normal(1.0, parameters.sd[0] / 0.6)]


def transition(step, x):
    x, (pump, leak) = x[:, 0], (step.inputs["pump"], step.parameters["leak"])
    return [motes.normal(x + (pump - leak * x) * step.dt, step.parameters.sd[0] * step.dt**0.5)]


def measurement(step, x):
    return [motes.normal(x[:, 0] * x[:, 0] / 2 + step.inputs.pump + step.time / 100, step.parameters.sd[1])]


def of(time, **more):
    arguments = {"states": ["x"], "measurements": ["y"], "time": time, **FRAME, **more}
    return motes.of_functions(initial, transition, measurement, **arguments)


@pytest.fixture
def data():
    rows = np.arange(12)
    hours = rows + (rows**2 % 7) / 10
    y = 0.5 + (rows * 5 % 4) / 4
    y[4] = np.nan
    both = {"hour": np.tile(hours, 2), "pump": np.tile(rows % 3 / 5, 2), "y": np.tile(y, 2)}
    return {"tank": np.repeat(["a", "b"], 12).tolist(), **both}


@pytest.fixture(autouse=True)
def quiet():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", motes.MotesWarning)
        yield


def test_the_same_as_a_dict(data):
    functions, theirs = of(WHOLE), of_dict(WHOLE)
    assert functions.parameters == theirs.parameters and "with the prior" in repr(functions)
    ahead = {"tank": ["a", "b"], "hour": [15.0, 15.5], "pump": [0.1, 0.2]}
    for asked in (
        lambda model: model.filter(data, particles=500, predictive=True).mean,
        lambda model: model.smooth(data, particles=200, paths=20).mean,
        lambda model: model.simulate(inputs=data, seed=2).measurements,
        lambda model: model.forecast(data, inputs=ahead, particles=200).mean,
        lambda model: model.log_evidence(data, {"leak": [0.1, 0.4]}, particles=200),
        lambda model: model.log_evidence(data, particles=200),
        lambda model: model.with_parameters({"leak": 0.7, "sd[1]": 0.4}).log_evidence(data, particles=200),
    ):
        np.testing.assert_allclose(asked(functions), asked(theirs), rtol=1e-9, atol=1e-12)


def test_parameters_are_fitted(data):
    settings = {"proposal": "bootstrap", "particles": 40, "chains": 2, "draws": 20}
    ours, theirs = (model.fit(data, **settings) for model in (of(WHOLE), of_dict(WHOLE)))
    np.testing.assert_allclose(ours.draws["leak"], theirs.draws["leak"], rtol=1e-7)
    assert len(ours.models(3)) == 3 and ours.models(3)[0].filter(data, particles=20).mean.shape[-1] == 1


def test_a_step_in_parts(data):
    functions, theirs = of(IN_PARTS), of_dict(IN_PARTS)
    assert functions.proposals == ["bootstrap"]
    ours = functions.filter(data, particles=4000)
    exact = theirs.filter(data, particles=40_000, proposal="linearised").log_evidence
    assert np.all(np.abs(np.sum(ours.log_evidence) - np.sum(exact)) < 0.3)
    assert np.isfinite(functions.smooth(data, particles=500, paths=10).mean[:, -1]).all()
    with pytest.raises(ValueError, match="proposal linearised: states have no density.*take proposal bootstrap"):
        functions.filter(data, proposal="linearised")
    with pytest.raises(ValueError, match="nothing to learn"):
        functions.learn(data, updates=5)


def test_a_proposal_is_learned_along_data(data):
    learned = of(WHOLE).learn(data, updates=30, steps=12, sequences=0)
    found = of(WHOLE).filter(data, particles=100, proposal=learned.proposal)
    assert np.isfinite(found.log_evidence).all()


def test_an_online_filter_takes_times_and_inputs(data):
    ours, theirs = (model.online(particles=300) for model in (of(WHOLE), of_dict(WHOLE)))
    for hour, pump, y in ((0.0, 0.1, 1.0), (1.5, 0.3, None), (2.0, 0.0, 1.4)):
        step = {"time": hour, "inputs": {"pump": pump}}
        np.testing.assert_allclose(ours.step(y, **step).mean, theirs.step(y, **step).mean, rtol=1e-9)


def test_pickles_keep_parameters(data):
    model = of(WHOLE).with_parameters({"leak": 0.6})
    expected = model.filter(data, particles=50).mean
    for again in (copy.copy(model), copy.deepcopy(model), pickle.loads(pickle.dumps(model))):
        assert again.parameters["leak"] == 0.6
        np.testing.assert_array_equal(again.filter(data, particles=50).mean, expected)


def test_what_functions_are_told():
    told = []

    def tells(step, x):
        told.append(step)
        return [motes.normal(x[:, 0], 1.0)]

    arguments = {"states": ["x"], "measurements": ["y"], "parameters": {"a": [[1, 2], [3, 4]], "q": 2.0}, "inputs": {"u": "next"}}
    model = motes.of_functions([motes.normal(0.0, 1.0)], tells, measurement_of_nothing, **arguments)
    model.filter({"u": [0.5, 0.25], "y": [0.0, 1.0]}, particles=10)
    (step,) = {one.index: one for one in told}.values()
    assert (step.index, step.time, step.dt, dict(step.inputs)) == (1, 1.0, 1.0, {"u": 0.25})
    assert step.parameters["a"].tolist() == [[1, 2], [3, 4]] and step.parameters.q == 2.0 and set(step.parameters) == {"a", "q"}
    for change in (lambda: setattr(step, "dt", 2.0), lambda: setattr(step.inputs, "u", 2.0)):
        with pytest.raises(AttributeError):
            change()
    with pytest.raises(ValueError, match="read-only"):
        step.parameters["a"][0, 0] = 5
    with pytest.raises(AttributeError, match="v: there is no input or parameter of that name; there are u"):
        _ = step.inputs.v
    assert copy.deepcopy(step.inputs).u == 0.25 and pickle.loads(pickle.dumps(step)).time == 1.0


def measurement_of_nothing(step, x):
    return [motes.normal(x[:, 0], 1.0)]


def test_what_is_wrong_is_said(data):
    with pytest.raises(TypeError, match="time: str; it must be a dict, as this section of a model file"):
        of("hour")
    with pytest.raises(ValueError, match=r"functions, \[inputs\] pump"):
        of(WHOLE, inputs={"pump": "before"})
    with pytest.raises(ValueError, match="`x` stands in the coordinates, too"):
        of(WHOLE, parameters={"x": 1.0})
    with pytest.raises(ValueError, match="did you mean `column`"):
        of({"colunm": "hour"})
    with pytest.raises(ValueError, match="did you mean `leak`"):
        of(WHOLE).with_parameters({"leek": 1.0})
    with pytest.raises(ValueError, match="column pump: the input pump has no value here, and measurement needs it"):
        of(WHOLE).filter({**data, "pump": [None] * 24})
    with pytest.raises(ValueError, match="initial: sd of x: -0.5; it must be above 0"):
        of(WHOLE, parameters={"leak": 0.1, "sd": [-0.3, 0.2]})
    with pytest.raises(ValueError, match="initial: sd of x: -0.5"):
        of(WHOLE).with_parameters({"sd[0]": -0.3})


def moved(step, x):
    """A position that follows from a velocity."""
    return [motes.known(x[:, 0] + x[:, 1] * step.dt), motes.normal(x[:, 1], 0.3)]


def test_a_known_start_and_a_coordinate_that_follows():
    arguments = {"states": ["p", "v"], "measurements": ["y"], "density": False}
    model = motes.of_functions([motes.known(0.0), motes.normal(1.0, 0.5)], moved, lambda step, x: [motes.normal(x[:, 0], 0.5)], **arguments)
    theirs = motes.Model(
        {
            "initial": {"p": 0, "v": "normal(1, 0.5)"},
            "transition": {"p": "p + v", "v": "normal(v, 0.3)"},
            "measurement": {"y": "normal(p, 0.5)"},
        }
    )
    assert model.proposals == ["bootstrap"]
    simulated = model.simulate(15, seed=4)
    assert (simulated.states[0, 0, 0], np.ptp(np.diff(simulated.states[0, :, 0]) - simulated.states[0, :-1, 1]) < 1e-12) == (0.0, True)
    y = theirs.simulate(15, seed=4).measurements[0]
    found, exact = model.filter(y, particles=20_000), theirs.filter(y, proposal="exact")
    assert abs(found.log_evidence - exact.log_evidence) < 4 * max(found.standard_error, 0.02)
    np.testing.assert_allclose(found.mean, exact.mean, atol=0.1)
    assert model.smooth(y, particles=2000, paths=50).mean.shape == (15, 2)
    assert any("bootstrap alone" in line for line in model.check(y)[0])


def test_counts_of_states():
    """How many of fifty are left."""
    model = motes.of_functions(
        [motes.known(50)],
        lambda step, x: [motes.binomial(x[:, 0], step.parameters.stay)],
        lambda step, x: [motes.poisson(x[:, 0] + 0.1)],
        states=["n"],
        measurements=["y"],
        parameters={"stay": "uniform(0, 1)"},
        density=False,
    ).with_parameters({"stay": 0.9})
    theirs = motes.Model(
        {
            "parameters": {"stay": 0.9},
            "initial": {"n": 50},
            "transition": {"n": "binomial(n, stay)"},
            "measurement": {"y": "poisson(n + 0.1)"},
        }
    )
    y = theirs.simulate(12, seed=4).measurements[0]
    found, exact = model.filter(y, particles=20_000), theirs.filter(y, proposal="exact")
    assert abs(found.log_evidence - exact.log_evidence) < 4 * max(found.standard_error, 0.02)
    states = model.simulate(12, series=3).states
    assert np.all(states == np.round(states)) and np.all(np.diff(states, axis=1) <= 0)


@pytest.mark.parametrize("wrong", [lambda x: motes.known(x[:, 0]), lambda x: motes.binomial(3, 0.5)])
def test_without_density_is_asked_for(wrong):
    model = motes.of_functions([motes.normal(0.0, 1.0)], lambda step, x: [wrong(x)], measurement_of_nothing, states=["x"], measurements=["y"])
    with pytest.raises(ValueError, match="x: (known|binomial); states that are known, follow or are counts have no density: density=False"):
        model.filter([0.0, 1.0], particles=10)


def test_a_measurement_is_not_known():
    model = motes.of_functions([motes.normal(0.0, 1.0)], moved, lambda step, x: [motes.known(x[:, 0])], states=["x"], measurements=["y"])
    with pytest.raises(ValueError, match="y: known; a measurement has a distribution"):
        model.filter([0.0], particles=10)
    with pytest.raises(TypeError, match="neither shifted nor scaled"):
        motes.known(1.0) + 1.0


class TestJax:
    @pytest.fixture(autouse=True)
    def jnp(self):
        return pytest.importorskip("jax.numpy")

    def test_it_is_linearised_as_a_dict_is(self, data):
        ours, theirs = of(WHOLE, jax=True), of_dict(WHOLE)
        assert ours.proposals == ["bootstrap", "linearised"]
        for proposal in ("bootstrap", "linearised"):
            found, expected = (model.filter(data, proposal=proposal, particles=300).mean for model in (ours, theirs))
            np.testing.assert_allclose(found, expected, rtol=1e-6)
        right, wrong = ours.check(data)
        assert not wrong and any("central differences" in line for line in right)

    def test_parts_and_parameters(self, data):
        model = of(IN_PARTS, jax=True)
        found = model.log_evidence(data, {"leak": [0.1, 0.4]}, particles=100)
        assert np.isfinite(found).all() and found[0] != found[1]
        with pytest.raises(ValueError, match="states have no density"):
            model.filter(data, proposal="linearised")
