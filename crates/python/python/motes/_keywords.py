"""Arguments that do not exist are refused with those that there are."""

from __future__ import annotations

import difflib
import functools
import inspect
from collections.abc import Callable
from typing import ParamSpec, TypeVar

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


def checked(call: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """The same function, which names what it knows, and what may have been meant, where an argument does not exist."""
    parameters = inspect.signature(call).parameters.values()
    known = [one.name for one in parameters if one.name != "self"]
    by_name = [one.name for one in parameters if one.kind is one.KEYWORD_ONLY]

    @functools.wraps(call)
    def checking(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        unknown = [name for name in kwargs if name not in known]
        if unknown:
            near = difflib.get_close_matches(unknown[0], known, 1)
            meant = f"; did you mean {near[0]}?" if near else ""
            raise TypeError(f"{unknown[0]}: there is no such argument; there are {', '.join(by_name)}{meant}")
        return call(*args, **kwargs)

    return checking
