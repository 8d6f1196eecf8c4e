"""Models in functions."""

import signal
import threading
import time
import traceback

import numpy as np
import pytest

import motes


def initial():
    return [motes.normal(0.0, np.sqrt(5))]


def transition(step, x):
    x = x[:, 0]
    return [motes.normal(x / 2 + 25 * x / (1 + x**2) + 8 * np.cos(1.2 * step.time), np.sqrt(10))]


def measurement(step, x):
    return [motes.normal(x[:, 0] ** 2 / 20, 1.0)]


def of(initial=initial, transition=transition, measurement=measurement, states=("x",), measurements=("y",), **more):
    return motes.of_functions(initial, transition, measurement, states=states, measurements=measurements, **more)


@pytest.fixture
def functions():
    return of()


@pytest.fixture
def y(growth):
    values = growth.simulate(60, seed=3).measurements[0]
    values[7] = np.nan
    return values


def walk(step, x):
    """A walk in two coordinates with noise of one side, as a list."""
    return [motes.normal(x[:, 0] + 0.1 * x[:, 1], 0.5), 0.9 * x[:, 1] + motes.exponential(0.2)]


def seen(step, x):
    return motes.student_t(4.0, x, [0.5, 0.25])


def of_walk(**more):
    return of([motes.normal(0.0, 1.0), motes.laplace(0.0, 1.0)], walk, seen, ["a", "b"], ["y", "z"], **more)


WALK = {
    "initial": {"a": "normal(0, 1)", "b": "laplace(0, 1)"},
    "transition": {"a": "normal(a + 0.1*b, 0.5)", "b": "0.9*b + exponential(0.2)"},
    "measurement": {"y": "student_t(4, a, 0.5)", "z": "student_t(4, b, 0.25)"},
}


def test_the_same_numbers_as_a_file(growth, functions, y):
    for threads in (1, 2):
        ours = functions.filter(y, particles=3000, threads=threads)
        theirs = growth.filter(y, particles=3000)
        # The cosine of NumPy may differ in the last bit.
        np.testing.assert_allclose(ours.log_evidence, theirs.log_evidence, rtol=1e-9)
        np.testing.assert_allclose(ours.mean, theirs.mean, rtol=1e-6, atol=1e-9)


def test_lists_and_arrays_of_coordinates_are_the_same():
    functions, file = of_walk(), motes.Model(WALK)
    drawn = functions.simulate(20, series=2, seed=4)
    np.testing.assert_array_equal(drawn.states, file.simulate(20, series=2, seed=4).states)
    y = list(drawn.measurements)
    ours, theirs = (model.filter(y, particles=1500, seed=2) for model in (functions, file))
    assert ours.log_evidence == theirs.log_evidence
    np.testing.assert_array_equal(ours.quantiles, theirs.quantiles)
    smoothed = functions.smooth(y, particles=200, paths=20)
    np.testing.assert_array_equal(smoothed.mean, file.smooth(y, particles=200, paths=20).mean)
    online = functions.online(particles=1500, seed=2)
    np.testing.assert_array_equal([online.step(row).mean for row in y[0]], ours.mean[: len(y[0])])
    assert functions.forecast(y, 3).mean.shape == file.forecast(y, 3).mean.shape


def test_shapes_that_are_broadcast():
    shapes = {
        "a number": lambda x: motes.normal(x, 0.5),
        "of a coordinate": lambda x: motes.normal(x, np.array([0.5, 0.5])),
        "of a row": lambda x: motes.normal(x, np.full((len(x), 1), 0.5)),
        "of all": lambda x: motes.normal(np.asfortranarray(x), np.full(x.shape, 0.5)),
        "integers": lambda x: motes.normal(x, np.float32(0.5) * np.ones((1, 2), dtype=np.int32)),
        "a list": lambda x: [motes.normal(x[:, 0], 0.5), motes.normal(x[:, 1:], [0.5])],
        "read-only": lambda x: motes.normal(np.broadcast_to(x, x.shape), 0.5),
    }
    found = [
        of([motes.normal(0.0, 1.0)] * 2, lambda step, x, stated=stated: stated(x), lambda step, x: motes.normal(x[:, 0], 1.0), ["a", "b"])
        .filter([0.3, 0.1, 0.4], particles=50)
        .log_evidence
        for stated in shapes.values()
    ]
    assert len(set(found)) == 1


def test_a_proposal_is_learned_without_derivatives(functions, y, tmp_path):
    assert functions.proposals == ["bootstrap"]
    learned = functions.learn(updates=600, sequences=3, steps=50)
    assert learned.card is not None and "learned" in repr(learned)
    bootstrap, ours = functions.filter(y, particles=200), functions.filter(y, particles=200, proposal=learned.proposal)
    assert ours.ess.mean() > 1.2 * bootstrap.ess.mean()
    learned.proposal.save(tmp_path / "growth")
    again = functions.filter(y, particles=200, proposal=motes.Proposal.load(tmp_path / "growth", functions))
    assert again.log_evidence == ours.log_evidence
    tuned = functions.learn([y], objective="wake", start=learned.proposal, updates=20, sequences=0)
    assert tuned.proposal.choice.endswith("learned further")


@pytest.mark.parametrize(
    "asked",
    [
        lambda model, y: model.filter(y, proposal="linearised"),
        lambda model, y: model.learn(base="linearised"),
        lambda model, y: model.learn([y], objective="fivo", updates=5, head="gaussian"),
    ],
)
def test_what_takes_derivatives_is_refused_without_them(functions, y, asked):
    with pytest.raises(ValueError, match="no derivatives"):
        asked(functions, y)


def test_a_model_is_checked(functions, y):
    right, wrong = functions.check(y)
    assert not wrong
    assert any("gradients: the model has none" in line for line in right)


def raising(step, x):
    if step.index == 5:
        return [motes.normal({}["nothing"], 1.0)]
    return [motes.normal(x[:, 0], 1.0)]


@pytest.mark.parametrize(
    "asked",
    [
        lambda model: model.filter(np.zeros(10)),
        lambda model: model.smooth(np.zeros(10)),
        lambda model: model.simulate(10),
        lambda model: model.compare(np.zeros(10), sweep=[10], particles=10),
        lambda model: model.learn(updates=10, steps=10),
        lambda model: model.check(),
    ],
)
@pytest.mark.parametrize("which", ["transition", "measurement"])
def test_what_a_function_raises_is_raised_with_its_traceback(asked, which):
    with pytest.raises(KeyError, match="nothing") as caught:
        asked(of(**{which: raising}))
    frames = traceback.extract_tb(caught.value.__traceback__)
    assert any(frame.name == "raising" for frame in frames)
    notes = getattr(caught.value, "__notes__", [f"in {which}, t = 5"])
    assert notes == [f"in {which}, t = 5"]


def test_a_filter_on_line_says_what_its_functions_raise():
    online = of(transition=raising).online(particles=10)
    for _ in range(5):
        online.step(0.0)
    with pytest.raises(KeyError, match="nothing"):
        online.step(0.0)


def late(what):
    """Right up to t = 2."""
    return lambda step, x: what(x) if step.index == 2 else [motes.normal(x[:, 0], 1.0)]


@pytest.mark.parametrize(
    ("what", "message"),
    [
        (lambda x: [motes.normal(np.where(np.arange(len(x)) == 3, np.nan, 0.0), 1.0)], "mean of x: NaN in row 3; it must be a finite number"),
        (lambda x: [motes.normal(x[:, 0], 0.0)], "sd of x: 0; it must be above 0"),
        (lambda x: [motes.normal(x[:, 0], np.inf)], "sd of x: inf; it must be above 0"),
        (lambda x: [motes.uniform(1.0, np.zeros(len(x)))], "high of x: 0 in row 0; it must be above low, which is 1"),
        (lambda x: [motes.normal(x[:7, 0], 1.0)], r"mean of x: an array of shape \(7,\); it must be a number or \(20,\)"),
        (lambda x: [motes.normal(x.T, 1.0)], r"mean of x: an array of shape \(1, 20\)"),
        (lambda x: [motes.normal("far", 1.0)], "mean of x: str; it must be a number or an array of numbers"),
        (lambda x: [motes.normal(x[:, 0] + 1j, 1.0)], "mean of x: ndarray; it must be a number or an array of numbers"),
        (lambda x: [motes.normal(x[:, 0], 1.0)] * 2, "2 distributions; it must be one for each of 1 coordinates"),
        (lambda x: x, "x: ndarray; it must be a distribution"),
        (lambda x: None, "x: NoneType; it must be a distribution"),
        (lambda x: [motes.poisson(1.0)], "x: poisson; states that are known, follow or are counts have no density: density=False allows them"),
        (lambda x: [0.0 * motes.normal(x[:, 0], 1.0)], "the factor of x: 0; it must be finite and not 0"),
        (lambda x: [motes.laplace(0.0, 1.0) + np.full(len(x), np.nan)], "the shift of x: NaN in row 0; it must be finite"),
    ],
)
def test_what_is_wrong_is_said_with_the_function_and_the_time(what, message):
    with np.errstate(all="ignore"), pytest.raises(ValueError, match=f"^transition, t = 2: {message}"):
        of(transition=late(what)).filter(np.zeros(5), particles=20)


def test_what_is_wrong_at_first():
    with pytest.raises(ValueError, match="^initial: sd of x: -1; it must be above 0"):
        of([motes.normal(0.0, -1.0)])
    with pytest.raises(ValueError, match="^initial: mean of x: an array of shape"):
        of([motes.normal(np.zeros(3), 1.0)])
    with pytest.raises(TypeError, match="transition: NoneType; it must be a function"):
        of(transition=None)
    with pytest.raises(TypeError, match="states: 'x'; it must be a list of names"):
        of(states="x")
    with pytest.raises(ValueError, match="x: there are two coordinates of that name"):
        of(measurements=["x"])
    with pytest.raises(ValueError, match="measurements: 0 names"):
        of(measurements=[])
    for name in ("t", "series", " ", "y\n", ""):
        with pytest.raises(ValueError, match="names a coordinate; it must be a word"):
            of(measurements=[name])


class TestJax:
    @pytest.fixture(autouse=True)
    def jnp(self):
        return pytest.importorskip("jax.numpy")

    @pytest.fixture
    def model(self, jnp):
        def of_growth(step, x):
            return [motes.normal(x[:, 0] / 2 + 25 * x[:, 0] / (1 + x[:, 0] ** 2) + 8 * jnp.cos(1.2 * step.time), jnp.sqrt(10.0))]

        return of(transition=of_growth, jax=True)

    def test_it_is_linearised_as_a_file_is(self, model, growth, y):
        assert model.proposals == ["bootstrap", "linearised"]
        for proposal in ("bootstrap", "linearised"):
            ours, theirs = (one.filter(y, proposal=proposal, particles=500) for one in (model, growth))
            np.testing.assert_allclose(ours.log_evidence, theirs.log_evidence, rtol=1e-6)
            np.testing.assert_allclose(ours.ess, theirs.ess, rtol=1e-4)

    def test_its_gradients_are_right(self, model, y):
        right, wrong = model.check(y)
        assert not wrong
        assert any("central differences" in line for line in right)

    def test_a_proposal_is_learned_around_what_is_linearised(self, model, y):
        learned = model.learn(updates=100, steps=30, base="linearised", head="gaussian", sequences=0)
        assert "around linearised" in learned.proposal.choice
        assert np.isfinite(model.filter(y, proposal=learned.proposal, particles=100).log_evidence)
        tuned = model.learn([y], objective="fivo", start=learned.proposal, updates=5, sequences=0)
        assert tuned.proposal.choice.endswith("learned further")

    def test_several_coordinates_in_one_distribution(self, jnp):
        def turned(step, x):
            return motes.normal(x @ jnp.array([[0.9, 0.1], [-0.1, 0.9]]).T, jnp.array([0.5, 0.25]))

        def seen(step, x):
            return [motes.poisson(jnp.exp(0.3 * x[:, 0])), motes.normal(x[:, 0] * x[:, 1], 0.5)]

        ours = of([motes.normal(0.0, 1.0)] * 2, turned, seen, ["a", "b"], ["y", "z"], jax=True)
        theirs = motes.Model(
            {
                "initial": {"a": "normal(0, 1)", "b": "normal(0, 1)"},
                "transition": {"a": "normal(0.9*a + 0.1*b, 0.5)", "b": "normal(0.9*b - 0.1*a, 0.25)"},
                "measurement": {"y": "poisson(exp(0.3*a))", "z": "normal(a*b, 0.5)"},
            }
        )
        y = theirs.simulate(30, seed=2).measurements[0]
        found = [model.filter(y, proposal="linearised", particles=300) for model in (ours, theirs)]
        np.testing.assert_allclose(found[0].mean, found[1].mean, rtol=1e-5, atol=1e-6)
        assert not ours.check(y)[1]

    def test_what_a_function_raises_is_raised(self):
        with pytest.raises(KeyError, match="nothing"):
            of(measurement=lambda step, x: {}["nothing"], jax=True).filter([0.0])

    @pytest.mark.parametrize(
        ("what", "message"),
        [
            (lambda x: [motes.normal(x[:7, 0], 1.0)], r"a parameter of x: an array of shape \(7,\); it must be a number or \(K,\)"),
            (lambda x: [motes.normal(x[:, 0] + 1j, 1.0)], "a complex parameter of x; it must be real"),
            (lambda x: [motes.normal(x[:, 0], 1.0)] * 2, "2 distributions; it must be one for each of 1 coordinates"),
            (lambda x: x, ".*; it must be distributions"),
            (lambda x: None, "NoneType; it must be distributions"),
        ],
    )
    def test_what_is_wrong_is_said(self, what, message):
        with pytest.raises(ValueError, match=f"^transition: {message}"):
            of(transition=lambda step, x: what(x), jax=True).filter(np.zeros(5), particles=20)

    def test_a_function_without_derivatives_is_not_taken_for_a_flat_one(self, jnp):
        import jax

        def opaque(step, x):
            return [motes.normal(jax.pure_callback(np.asarray, jax.ShapeDtypeStruct(x.shape[:1], x.dtype), x[:, 0]), 1.0)]

        model = of(transition=lambda step, x: [motes.normal(x[:, 0], 1.0)], measurement=opaque, jax=True)
        assert np.isfinite(model.filter([0.3, 0.1], particles=20).log_evidence)
        with pytest.raises(ValueError, match="JVP"):
            model.filter([0.3, 0.1], particles=20, proposal="linearised")


def within(inner):
    """A model whose measurement calls motes."""

    def nested(step, x):
        inner()
        return [motes.normal(x[:, 0], 1.0)]

    return of(measurement=nested)


@pytest.mark.parametrize("threads", [1, 2])
def test_a_function_may_call_motes(functions, threads):
    inner = lambda: (functions.filter([0.1], particles=10, threads=1), functions.simulate(3))  # noqa: E731
    assert np.isfinite(within(inner).filter([0.1, 0.2], particles=30, threads=threads).log_evidence)


def test_a_filter_on_line_is_one_callers_at_a_time():
    said = []
    online = within(lambda: said.append(asked())).online(particles=10)

    def asked():
        with pytest.raises(RuntimeError, match="the filter is in a step") as caught:
            _ = online.log_evidence
        return str(caught.value)

    online.step(0.0)
    assert said and np.isfinite(online.log_evidence)


def test_a_filter_on_line_that_failed_says_so():
    online = of(transition=raising).online(particles=10)
    with pytest.raises(KeyError):
        for _ in range(10):
            online.step(0.0)
    with pytest.raises(ValueError, match="the filter failed in an earlier step"):
        online.step(0.0)


@pytest.mark.parametrize(
    "asked",
    [
        lambda model: model.simulate(1000),
        lambda model: model.filter(np.zeros(500), particles=10),
        lambda model: model.forecast(np.zeros(3), 1000, particles=10),
        lambda model: model.compare(np.zeros(500), sweep=[10], particles=10),
        lambda model: model.learn(),
    ],
)
def test_a_call_of_slow_functions_can_be_ended(asked):
    def slow(step, x):
        time.sleep(0.02)
        return [motes.normal(x[:, 0], 1.0)]

    timer = threading.Timer(0.5, signal.raise_signal, [signal.SIGINT])
    timer.start()
    start = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        asked(of(transition=slow))
    assert time.perf_counter() - start < 3.0


def test_simulations_that_overflow_are_left_out_as_a_files_are():
    file = motes.Model({"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x + 0.01*x^3, 1)"}, "measurement": {"y": "normal(x, 1)"}})
    functions = of(
        [motes.normal(0.0, 1.0)],
        lambda step, x: [motes.normal(x[:, 0] + 0.01 * x[:, 0] ** 3, 1.0)],
        lambda step, x: [motes.normal(x[:, 0], 1.0)],
    )
    with np.errstate(all="ignore"):
        # Formulas say besides which of them it was.
        found, expected = (one.check()[1] for one in (functions, file))
        assert [problem.split(": ")[:2] for problem in found] == [problem.split(": ")[:2] for problem in expected]
        ours, theirs = (one.learn(updates=20, steps=50, sequences=0, base="transition") for one in (functions, file))
    assert ours.proposal.choice == theirs.proposal.choice


def test_bounds_that_overflow_end_a_simulation():
    def runs_away(step, x):
        ahead = x[:, 0] + x[:, 0] ** 3
        return [motes.uniform(ahead - 1.0, ahead + 1.0)]

    with np.errstate(all="ignore"):
        problems = of([motes.normal(9.0, 1.0)], runs_away, lambda step, x: [motes.normal(x[:, 0], 1.0)]).check()[1]
    assert any("series run to numbers that are not finite" in problem for problem in problems)


def test_functions_that_end_with_the_data():
    inputs = np.linspace(0.0, 1.0, 6)
    model = of(
        [motes.normal(0.0, 1.0)],
        lambda step, x: [motes.normal(0.9 * x[:, 0] + inputs[step.index], 1.0)],
        lambda step, x: [motes.normal(x[:, 0], 0.5)],
    )
    learned = model.learn(updates=30, steps=6, sequences=0)
    assert np.isfinite(model.filter(np.zeros(6), particles=50, proposal=learned.proposal).log_evidence)


def test_noise_that_vanishes_where_no_particle_is():
    model = of([motes.normal(0.0, 1.0)], lambda step, x: [motes.normal(0.0 * x[:, 0], 1.0)], lambda step, x: [motes.normal(0.0, np.abs(x[:, 0]))])
    assert model.learn(updates=30, steps=10, sequences=0).proposal is not None


def test_particles_that_are_not_aligned_and_known_starts():
    def unaligned(values):
        moved = np.zeros(8 * len(values) + 1, dtype="u1")[1:].view("f8")
        moved[:] = values
        return moved

    one = of(transition=lambda step, x: [motes.normal(unaligned(0.5 * x[:, 0]), 1.0)])
    two = of(transition=lambda step, x: [motes.normal(0.5 * x[:, 0], 1.0)])
    assert one.filter([0.1, 0.2], particles=40).log_evidence == two.filter([0.1, 0.2], particles=40).log_evidence


def test_a_known_start_is_the_same_on_any_number_of_threads():
    model = of([motes.normal(1.0, 1e-20)])
    proposal = model.learn(updates=20, steps=10, sequences=0).proposal
    found = {model.filter([0.5, 0.2], particles=8202, proposal=proposal, threads=threads).log_evidence for threads in [1] + [2] * 8}
    assert len(found) == 1
