"""Models, what is found by them, and what is refused."""

import errno
import os
import re
import signal
import threading
import time

import numpy as np
import pytest

import motes


def test_a_model_of_matrices_is_exact():
    matrices = {"A": [[0.9]], "C": [[1.0]], "Q": [[1.0]], "R": [[0.5]], "m0": [0.0], "P0": [[2.0]]}
    model = motes.linear_gaussian(**matrices)
    y = model.simulate(60, seed=3).measurements[0]
    mean, variance, evidence = 0.0, 2.0, 0.0
    for time_, value in enumerate(y[:, 0]):
        if time_ > 0:
            mean, variance = 0.9 * mean, 0.81 * variance + 1.0
        total = variance + 0.5
        evidence -= 0.5 * (np.log(2 * np.pi * total) + (value - mean) ** 2 / total)
        mean, variance = mean + variance / total * (value - mean), variance * 0.5 / total
    found = model.filter(y, proposal="optimal", particles=20_000)
    assert found.log_evidence == pytest.approx(evidence, abs=0.2)
    assert found.mean[-1, 0] == pytest.approx(mean, abs=0.02)


def test_matrices_may_have_intercepts_inputs_and_no_inverse():
    intercepts = motes.linear_gaussian(
        A=[[0.8]], b=[0.5], Q=[[0.1]], C=[[1.0], [0.5]], d=[0.0, 1.0], R=[[0.04, 0.01], [0.01, 0.09]], m0=[2.5], P0=[[0.3]]
    )
    y = [[2.31, 2.40], [2.62, 2.05], [2.95, 2.51], [np.nan, 2.33], [2.71, 2.60]]
    found = intercepts.filter(y, proposal="exact")
    assert found.log_evidence == pytest.approx(-1.001385, abs=2e-6)
    assert found.mean[-1, 0] == pytest.approx(2.729888, abs=2e-6)

    # One shock moves both coordinates, and the first is measured without error.
    shock = np.array([[1.0], [-0.4]])
    arma = motes.linear_gaussian(
        A=[[0.87, 1.0], [0.0, 0.0]], Q=0.5 * shock @ shock.T, C=[[1.0, 0.0]], R=[[0.0]], m0=[0.0, 0.0], P0=[[2.0, -0.2], [-0.2, 0.08]]
    )
    assert arma.filter([0.41, -0.35, 0.92, np.nan, 1.84, 1.10, 0.27], proposal="exact").log_evidence == pytest.approx(-7.977668, abs=2e-6)

    # Inputs move states and measurements, whose noises are correlated: the joint Gaussian of both rows.
    noises = motes.linear_gaussian(
        A=[[0.9]], B=[[0.5]], Q=[[1.0]], C=[[1.0]], D=[[-0.2]], R=[[0.5]], S=[[0.3]], m0=[1.0], P0=[[2.0]], inputs={"u": "hold"}
    )
    covariance = np.array([[2.5, 1.8], [1.8, 0.81 * 2.0 + 1.0 + 0.5 + 2 * 0.3]])
    off = np.array([0.4 - (1.0 - 0.2 * 2.0), 1.7 - (0.9 + 0.5 * 2.0 - 0.2 * 3.0)])
    expected = -0.5 * (off @ np.linalg.solve(covariance, off) + np.log(np.linalg.det(2 * np.pi * covariance)))
    found = noises.filter({"y0": [0.4, 1.7], "u": [2.0, 3.0]}, proposal="exact").log_evidence
    assert found == pytest.approx(expected, abs=1e-9)


def test_results_have_shapes(tracking):
    drawn = tracking.simulate(20, 3)
    assert drawn.states.shape == (3, 20, 4) and drawn.measurements.shape == (3, 20, 2)
    found = tracking.filter(drawn.measurements, proposal="linearised", particles=200)
    assert found.mean.shape == found.sd.shape == (60, 4) and found.quantiles.shape == (60, 4, 3)
    assert (np.diff(found.quantiles, axis=2) >= 0).all() and found.ess.max() <= 200
    assert tracking.smooth(drawn.measurements, paths=7, particles=100).paths(1).shape == (7, 20, 4)
    forecast = tracking.forecast(drawn.measurements, 5, particles=200)
    assert forecast.mean.shape == (3, 5, 4) and (forecast.sd > 0).all()


def test_online_equals_the_filter_of_one_sequence(growth):
    y = growth.simulate(30, seed=2).measurements[0]
    online, whole = growth.online(particles=500), growth.filter(y, particles=500)
    for at, row in enumerate(y):
        online.step(row)
        assert online.mean.tolist() == whole.mean[at].tolist()
        assert online.log_evidence_increment == whole.log_evidence_increments[at]
    assert online.log_evidence == whole.log_evidence
    assert online.predict().ess is None
    for wrong in ([1.0, 2.0], "x", np.inf):
        with pytest.raises(ValueError):
            online.step(wrong)


def test_learning_and_its_card(growth, tmp_path):
    learned = growth.learn(updates=200, sequences=3)
    assert {"bootstrap", "linearised", "learned"} <= set(learned.card.methods)
    assert learned.validation[-1, 1] > learned.validation[0, 1]
    learned.proposal.save(tmp_path / "p")
    found = growth.compare(proposals=["bootstrap", motes.Proposal.load(tmp_path / "p", growth)], sweep=[10], sequences=2)
    assert list(found.methods) == ["bootstrap", "p", "p, ahead"]
    assert list(growth.compare(proposals="bootstrap", sweep=[10], sequences=2).methods) == ["bootstrap"]
    tuned = growth.learn(growth.simulate(50, 2).measurements, objective="wake", start=learned.proposal, updates=3, sequences=0)
    assert tuned.card is None and "learned further" in tuned.proposal.choice


def test_warnings_are_pythons(examples):
    # Too sure of itself: the filter loses its particles.
    model = motes.Model(examples / "growth.toml", set={"q": 0.001})
    y = motes.Model(examples / "growth.toml").simulate(40, seed=1).measurements[0]
    with pytest.warns(motes.MotesWarning) as warned:
        found = model.filter(y, particles=200)
    assert found.warnings and warned[0].filename == __file__


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        ({"particles": 0}, "particles: 0; it must be an integer from 1 to"),
        ({"proposal": "best"}, "proposal: best; it must be bootstrap, linearised, optimal"),
        ({"proposal": "optimal"}, "proposal optimal: "),
        ({"defensive": 1.0}, "defensive: 1; it must be from 0 to below 1"),
        ({"resample_below": 0.0}, "resample_below: 0; it must be above 0"),
        ({"resampling": "best"}, "resampling: best; it must be multinomial"),
        ({"seed": -1}, "seed: -1; it must be an integer from 0"),
        ({"threads": 0}, "threads: 0; it must be an integer from 1"),
    ],
)
def test_arguments_out_of_range_are_refused_in_a_line(growth, arguments, line):
    with pytest.raises(ValueError, match=line) as refused:
        growth.filter([1.0, 2.0], **arguments)
    assert "\n" not in str(refused.value)


def test_arguments_that_do_not_exist_are_refused(growth):
    for call, known in ((growth.filter, "proposal, particles"), (growth.smooth, "paths, proposal, particles")):
        with pytest.raises(TypeError, match=f"partikels: there is no such argument; there are {known}"):
            call([1.0, 2.0], partikels=10)
    with pytest.raises(TypeError, match="proposal: there is no such argument"):
        growth.compare(proposal="linearised")
    with pytest.raises(ValueError, match="particles: 0"):
        growth.online(particles=0)


def test_models_that_are_none_are_refused_in_a_line(tmp_path):
    walk = {"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, 1)"}, "measurement": {"y": "normal(x, 1)"}}
    cases = [
        ({**walk, "transition": {"x": "normal(z, 1)"}}, "z"),
        ({**walk, "transition": {"x": object()}}, "transition.x"),
        ({**walk, "parameters": {"q": float("inf")}}, "q"),
        ("[initial]\nx = 1", "Model.parse reads a text"),
        ({**walk, "foo": {"x": 1}}, "^model: a model file has no `foo` here"),
    ]
    for source, names in cases:
        with pytest.raises(ValueError, match=names) as refused:
            motes.Model(source)
        assert "\n" not in str(refused.value)
    with pytest.raises(FileNotFoundError, match="nowhere.toml"):
        motes.Model(tmp_path / "nowhere.toml")
    with pytest.raises(ValueError, match="set: q: nan"):
        motes.Model(walk, set={"q": float("nan")})
    with pytest.raises(ValueError, match="^model, Q: it has the smallest eigenvalue -1"):
        motes.linear_gaussian(A=[[1.0]], C=[[1.0]], Q=[[-1.0]], R=[[1.0]], m0=[0.0], P0=[[1.0]])
    with pytest.raises(ValueError, match="A: it has complex numbers"):
        motes.linear_gaussian(A=np.array([[1j]]), C=[[1.0]], Q=[[1.0]], R=[[1.0]], m0=[0.0], P0=[[1.0]])
    with pytest.raises(ValueError, match="A: it has masked entries"):
        masked = np.ma.masked_array([[3.0]], [[True]])
        motes.linear_gaussian(A=masked, C=[[1.0]], Q=[[1.0]], R=[[1.0]], m0=[0.0], P0=[[1.0]])
    with pytest.raises(ValueError, match="Q: an array of shape"):
        motes.linear_gaussian(A=[[1.0]], C=[[1.0]], Q=[1.0], R=[[1.0]], m0=[0.0], P0=[[1.0]])
    with pytest.raises(ValueError, match=r"b: an array of shape \(1, 1\); it must have 1 axes"):
        motes.linear_gaussian(A=[[1.0]], C=[[1.0]], Q=[[1.0]], R=[[1.0]], m0=[0.0], P0=[[1.0]], b=[[1.0]])
    with pytest.raises(ValueError, match=r"D: there is no \[inputs\]"):
        motes.linear_gaussian(A=[[1.0]], C=[[1.0]], Q=[[1.0]], R=[[1.0]], m0=[0.0], P0=[[1.0]], D=[[1.0]])


@pytest.mark.parametrize(
    "read",
    [lambda model, path: motes.Model(path), lambda model, path: model.filter(path), lambda model, path: motes.Proposal.load(path, model)],
    ids=["model", "data", "proposal"],
)
def test_files_that_cannot_be_read_are_the_errors_that_python_has(growth, read, tmp_path):
    with pytest.raises(FileNotFoundError) as refused:
        read(growth, tmp_path / "nowhere")
    assert refused.value.errno == errno.ENOENT and str(tmp_path / "nowhere") in refused.value.filename
    assert "\n" not in str(refused.value)


def test_folders_and_files_without_permission_are_the_errors_that_python_has(growth, tmp_path):
    for read in (motes.Model, growth.filter):
        with pytest.raises(IsADirectoryError) as refused:
            read(tmp_path)
        assert refused.value.errno == errno.EISDIR and refused.value.filename == str(tmp_path)
    secret = tmp_path / "secret"
    secret.write_text("y\n1\n")
    secret.chmod(0)
    if os.access(secret, os.R_OK):
        pytest.skip("who may read everything has no file without permission")
    for read in (motes.Model, growth.filter):
        with pytest.raises(PermissionError):
            read(secret)


WALK = {"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, x)"}, "measurement": {"y": "poisson(exp(x))"}}


@pytest.mark.parametrize(
    ("call", "line"),
    [
        (lambda model: model.filter([1, 2]), r"row 1, t = 1: model, \[transition\] x: sd, `x`, is -"),
        (lambda model: model.filter([1, 2], proposal="optimal"), r"proposal optimal: model, \[measurement\] y: "),
        (lambda model: motes.Model({**WALK, "transition": {"x": "normal(z, 1)"}}), r"model, \[transition\] x: `z` is not known here"),
        (lambda model: motes.Model({**WALK, "transition": {"x": "normal(x, "}}), r"model, \[transition\] x: "),
    ],
)
def test_messages_about_dicts_name_sections_and_keys_and_no_lines(call, line):
    with pytest.raises(ValueError, match=f"^{line}") as refused:
        call(motes.Model(WALK))
    assert re.search(r"\bline\b", str(refused.value)) is None


def test_numbers_may_begin_or_end_with_a_point():
    model = motes.Model({"initial": {"x": "normal(0, .3)"}, "transition": {"x": "normal(x, 5.)"}, "measurement": {"y": "normal(x, 1)"}})
    same = motes.Model({"initial": {"x": "normal(0, 0.3)"}, "transition": {"x": "normal(x, 5)"}, "measurement": {"y": "normal(x, 1)"}})
    assert model.filter([1.0, 2.0]).mean.tolist() == same.filter([1.0, 2.0]).mean.tolist()


def test_the_log_evidence_alone(growth):
    y = growth.simulate(30, 2).measurements
    for settings in ({}, {"proposal": "linearised", "particles": 50, "seed": 3}):
        assert growth.log_evidence(y, **settings) == growth.filter(y, **settings).log_evidence
    with pytest.raises(TypeError, match="check: there is no such argument"):
        growth.log_evidence(y, check=False)


def test_impossible_data_have_no_evidence_and_a_filter_says_so():
    sections = {"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, 1)"}, "measurement": {"y": "uniform(x - w, x + w)"}}
    found = []
    for w in (40.0, 0.1):
        model = motes.Model({"parameters": {"w": 1.0}, **sections}, set={"w": w})
        if w == 40.0:
            found.append(model.log_evidence([0.0, 30.0]))
            continue
        with pytest.warns(motes.MotesWarning, match="^row 1, t = 1: no particle explains the measurement: y is 30, .*; the log-evidence is −∞$") as warned:
            found.append(model.log_evidence([0.0, 30.0]))
        assert warned[0].filename == __file__
        with pytest.raises(ValueError, match="t = 1: no particle explains the measurement"):
            model.filter([0.0, 30.0])
    assert np.isfinite(found[0]) and found[1] == -np.inf


def test_a_proposal_of_another_model_is_refused(growth, tmp_path):
    def of(a, measured="normal(x, 0.5)", **more):
        initial = {"x": "normal(0, 1)", **{name: "normal(0, 1)" for name in more}}
        return motes.Model({"initial": initial, "transition": {"x": f"normal({a}*x, 0.5)", **more}, "measurement": {"y": measured}})

    own = of(0.9)
    proposal = own.learn(updates=5, sequences=0).proposal
    y = own.simulate(10).measurements[0]
    assert np.isfinite(of(0.9).filter(y, proposal=proposal).log_evidence)
    proposal.save(tmp_path / "p")
    words = "this proposal was trained for another system: "
    for other in (of(-0.5), of(0.9, "normal(x^2, 3)"), of(0.9, z="normal(z, 1)")):
        with pytest.raises(ValueError, match=words) as loaded:
            motes.Proposal.load(tmp_path / "p", other)
        for use in (
            lambda: other.filter(y, proposal=proposal),
            lambda: other.log_evidence(y, proposal=proposal),
            lambda: other.smooth(y, proposal=proposal),
            lambda: other.forecast(y, 2, proposal=proposal),
            lambda: other.online(proposal=proposal),
            lambda: other.compare(proposals=[proposal], sequences=2),
            lambda: other.learn(start=proposal, updates=5, sequences=0),
        ):
            with pytest.raises(ValueError, match=words) as refused:
                use()
            # In the words of a folder.
            assert str(refused.value).split(words)[1] == str(loaded.value).split(words)[1]
    start = motes.Proposal.load(tmp_path / "p", of(0.8), to_tune=True)
    assert of(0.8).learn(start=start, updates=5, sequences=0).proposal.choice.endswith("learned further")
    with pytest.raises(ValueError, match="proposal learned: it was learned for a model of formulas"):
        motes.linear_gaussian(A=[[0.9]], C=[[1.0]], Q=[[1.0]], R=[[0.5]], m0=[0.0], P0=[[1.0]]).filter(y, proposal=proposal)


def test_a_failed_filter_says_where(examples):
    counts = motes.Model(examples / "ricker.toml")
    with pytest.raises(ValueError, match="^data, row 1, column .*: -1 is no value of poisson.*: a count is a whole number, 0 or more$"):
        counts.filter([1, -1])
    edges = motes.Model({"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(x, 1)"}, "measurement": {"y": "uniform(x - 1, x + 1)"}})
    with pytest.raises(ValueError, match="^row 1, t = 1: no particle explains the measurement: y is 900, where the particles predict "):
        edges.filter([0.5, 900])
    with pytest.raises(ValueError, match="t = 0: .*: -1 is no value of poisson"):
        counts.online().step([-1])


def test_other_threads_of_python_run_meanwhile(growth):
    y = growth.simulate(200).measurements[0]
    counted = [0]
    done = threading.Event()

    def count():
        while not done.is_set():
            counted[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    growth.filter(y, particles=100_000, threads=1)
    done.set()
    thread.join()
    assert counted[0] > 20


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize(
    "call",
    [
        lambda model: model.learn(updates=10_000_000),
        lambda model: model.filter(np.zeros(1_000_000), particles=10_000),
        lambda model: model.forecast([1.0], 1_000_000, particles=10_000),
        lambda model: model.smooth(np.zeros(100), paths=100_000, particles=10_000),
        lambda model: model.compare(sequences=1000, steps=10_000),
        lambda model: model.log_evidence(np.zeros(1_000_000), particles=10_000),
        lambda model: model.simulate(20_000_000),
    ],
    ids=["learn", "filter", "forecast", "smooth", "compare", "log_evidence", "simulate"],
)
def test_ctrl_c_ends_a_long_call(growth, call):
    threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    started = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        call(growth)
    assert time.monotonic() - started < 5.0


@pytest.mark.skipif(not hasattr(os, "fork"), reason="forks of POSIX")
def test_a_forked_process_has_threads_of_its_own(growth):
    y = growth.simulate(20).measurements[0]
    here = growth.filter(y, threads=2).log_evidence
    child = os.fork()
    if child == 0:
        os._exit(0 if growth.filter(y, threads=2).log_evidence == here else 1)
    for _ in range(100):
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            break
        time.sleep(0.1)
    else:
        os.kill(child, signal.SIGKILL)
        pytest.fail("the child waits for threads that it does not have")
    assert status == 0


def test_pages_and_notebooks(nile, examples, tmp_path):
    found = nile.filter(examples / "nile.csv")
    found.to_html(tmp_path / "nile.html")
    assert "<html" in (tmp_path / "nile.html").read_text()[:200].lower()
    assert "log-evidence" in found._repr_html_() and "log-evidence" in repr(found)
    assert found.to_json()["particles"] == 1000
    assert "level" in repr(nile) and "<pre>" in nile._repr_html_()


def test_plots(nile, examples):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    axes = nile.filter(examples / "nile.csv").plot()
    assert len(axes) == 1 and axes[0].get_ylabel() == "level"


def test_log_evidences_have_standard_errors():
    walk = {"initial": {"x": "normal(0, 1)"}, "transition": {"x": "normal(0.9*x, 1)"}, "measurement": {"y": "normal(x, 1)"}}
    model = motes.Model(walk)
    data = [0.3, 1.2, None, 0.7]
    found, exact = model.filter(data), model.filter(data, proposal="exact")
    assert 0 < found.standard_error < 0.2 and found.standard_error_per_series.tolist() == [found.standard_error]
    assert exact.standard_error == 0 and abs(found.log_evidence - exact.log_evidence) < 4 * found.standard_error
    assert model.filter(data, check=False).standard_error is None
    assert found.to_json()["standard_error"] == found.standard_error
    online = model.online(check=True)
    for measured in data:
        online.step(measured)
    assert online.standard_error == found.standard_error and model.online().standard_error is None


def test_draws_lists_and_known_starts():
    epidemic = motes.Model(
        {
            "parameters": {"rates": [0.9, 0.4], "N": 15},
            "initial": {"I": 2, "S": "N - I"},
            "draws": {
                "infections": "binomial(S, 1 - exp(-rates[0]*I/N))",
                "recoveries": "binomial(I, 1 - exp(-rates[1]))",
            },
            "transition": {"I": "I + infections - recoveries", "S": "S - infections"},
            "measurement": {"cases": "poisson(I + 0.01)"},
        }
    )
    assert epidemic.parameters == {"rates[0]": 0.9, "rates[1]": 0.4, "N": 15}
    for proposal in ["bootstrap", "linearised"]:
        found = epidemic.filter([2, 3, 3, 6, 4, 5, 2], particles=5000, proposal=proposal)
        # By the sum over all numbers of people.
        assert abs(found.log_evidence + 13.400815) < 5 * found.standard_error
    reported = motes.Model(
        {
            "initial": {"x": 0},
            "draws": {"infections": "poisson(1)"},
            "transition": {"x": "x + infections"},
            "measurement": {"y": "poisson(infections + 0.1)"},
        }
    )
    # The first row has no step before it.
    with pytest.raises(ValueError, match="y looks back at the sub-steps since the row before, and there are none"):
        reported.filter([1, 2])
    assert np.isfinite(reported.filter([np.nan, 2], particles=100).log_evidence)
