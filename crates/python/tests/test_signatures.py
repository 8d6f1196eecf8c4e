"""Signatures say what can be set, and what is taken where nothing is."""

import inspect
import os
import re
import subprocess

import pytest

import motes

COMMAND = os.environ.get("MOTES_COMMAND")

FILTER = {
    "proposal": "bootstrap",
    "particles": 1000,
    "defensive": None,
    "resample_below": 0.5,
    "resampling": "systematic",
    "seed": 1,
    "check": True,
    "predictive": False,
    "quantiles": (0.05, 0.5, 0.95),
    "threads": None,
}

#: What each call has of a filter's settings: those that it leaves out, and those with another default.
CALLS = {
    "filter": (set(), {}),
    "forecast": (set(), {}),
    "smooth": ({"predictive"}, {}),
    "log_evidence": ({"check", "predictive", "quantiles"}, {}),
    "online": (set(), {"check": False, "threads": 1}),
    "compare": ({"proposal", "check", "predictive", "quantiles"}, {"particles": 100}),
    "predict": ({"check"}, {}),
}


def keywords(call):
    parameters = inspect.signature(call).parameters.values()
    assert not any(one.kind is one.VAR_KEYWORD for one in parameters)
    return {one.name: one.default for one in parameters if one.kind is one.KEYWORD_ONLY}


@pytest.mark.parametrize("name", CALLS)
def test_settings_are_there_with_their_defaults(name):
    left_out, others = CALLS[name]
    found = keywords(getattr(motes.PosteriorFit if name == "predict" else motes.Model, name))
    expected = {setting: default for setting, default in (FILTER | others).items() if setting not in left_out}
    assert {setting: found[setting] for setting in expected} == expected
    assert not left_out & set(found)
    assert set(FILTER) == set(motes.FilterSettings.__annotations__)


def test_what_is_said_is_what_is_taken(growth):
    y = growth.simulate(20, seed=2).measurements[0]
    assert growth.filter(y).to_csv() == growth.filter(y, **FILTER).to_csv()
    assert growth.online(**{**FILTER, "check": False, "threads": 1}).step(y[0]).mean == growth.online().step(y[0]).mean


@pytest.mark.skipif(COMMAND is None, reason="MOTES_COMMAND does not name the command motes")
@pytest.mark.parametrize("name", ["filter", "smooth", "compare", "evidence", "simulate", "fit", "learn"])
def test_defaults_are_those_of_the_command(name):
    text = subprocess.run([COMMAND, name, "--help"], capture_output=True, text=True, check=True).stdout
    stated = dict(re.findall(r"--([a-z-]+) <[^>]*>(?:(?!\n\s*--).)*?\[default: ([^\]]*)\]", text, re.DOTALL))
    assert len(stated) > 1 or name == "simulate"
    found = keywords(getattr(motes.Model, name)) | {
        "series": inspect.signature(motes.Model.simulate).parameters["series"].default
    }
    compared = 0
    for option, default in stated.items():
        if (argument := option.replace("-", "_")) in found:
            ours = found[argument]
            if ours is None:
                assert default == "auto", option
            elif isinstance(ours, tuple):
                assert default == ",".join(map(str, ours)), option
            else:
                assert type(ours)(default) == ours, option
            compared += 1
    assert compared > 0


def test_arguments_that_do_not_exist_are_refused_with_the_nearest(growth):
    refused = {
        lambda: growth.filter([1.0], partikels=3): "partikels: .*did you mean particles?",
        lambda: growth.online(seeds=3): r"seeds: .*; did you mean seed\?$",
        lambda: growth.forecast([1.0], step=3): r"step: .*; did you mean steps\?$",
        lambda: growth.simulate(3, inptus=3): r"inptus: .*; did you mean inputs\?$",
        lambda: growth.fit([1.0], zzz=3): r"zzz: there is no such argument; there are method, .*, threads$",
        lambda: growth.filter(dta=[1.0]): r"dta: .*; did you mean data\?$",
    }
    for call, line in refused.items():
        with pytest.raises(TypeError, match=line) as error:
            call()
        assert "\n" not in str(error.value)
