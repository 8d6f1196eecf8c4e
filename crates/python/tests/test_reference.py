"""The reference page is what the package says of itself: run this file to write it anew."""

import inspect
import re
from functools import cached_property
from pathlib import Path

import motes

PAGE = Path(__file__).resolve().parents[3] / "docs/python-reference.md"

HEAD = """# Python reference

All that `import motes` has, as the package says it. [Python](../crates/python/README.md) says how it goes together.
"""

#: Lines up to which a signature stands in one.
WIDTH = 100


def parameter_of(one):
    """A parameter as it is written."""
    text = {one.VAR_POSITIONAL: "*", one.VAR_KEYWORD: "**"}.get(one.kind, "") + one.name
    if one.annotation is one.empty:
        return text if one.default is one.empty else f"{text}={one.default!r}"
    return f"{text}: {one.annotation}" + ("" if one.default is one.empty else f" = {one.default!r}")


def signature_of(name, call):
    """How it is called, in one line or with a line for each argument."""
    found = inspect.signature(call)
    parts, has_star = [], False
    for one in found.parameters.values():
        if one.name in ("self", "cls"):
            continue
        if one.kind is one.KEYWORD_ONLY and not has_star:
            parts.append("*")
        has_star |= one.kind in (one.KEYWORD_ONLY, one.VAR_POSITIONAL)
        parts.append(parameter_of(one))
    # Of a class it is itself.
    is_said = found.return_annotation not in (found.empty, None, "None")
    result = f" -> {found.return_annotation}" if is_said else ""
    line = f"{name}({', '.join(parts)}){result}"
    if len(line) <= WIDTH:
        return line
    return f"{name}(\n" + "".join(f"    {part},\n" for part in parts) + f"){result}"


def block(text, language="text"):
    """A block of code."""
    return f"```{language}\n{text}\n```\n"


def prose_of(text):
    """What is said of something, its examples as blocks of code."""
    parts = []
    for part in re.split(r"\n\s*\n", inspect.cleandoc(text or "")):
        before, prompt, code = part.partition(">>> ")
        parts += [before.rstrip() + "\n"] if before.strip() else []
        parts += [block(prompt + code, "pycon")] if prompt else []
    return "\n".join(parts)


def attributes_of(cls):
    """What instances have from the start, with what is said of it above."""
    found = {}
    for base in reversed(cls.__mro__[:-1]):
        source = inspect.getsource(base) if base.__module__.startswith("motes") else ""
        for said, name in re.findall(r"((?:^ *#: .*\n)+) *(?:self\.)?([a-z]\w*)(?::| =)", source, re.MULTILINE):
            found[name] = " ".join(line.strip().removeprefix("#: ") for line in said.splitlines())
    return found


def members_of(cls):
    """Methods and properties, those of bases that are ours, too, in the order of the source."""
    found = {}
    for base in reversed(cls.__mro__[:-1]):
        if base.__module__.startswith("motes"):
            found |= {name: one for name, one in vars(base).items() if not name.startswith("_")}
    kinds = (property, cached_property, classmethod, staticmethod)
    return {name: one for name, one in found.items() if inspect.isroutine(one) or isinstance(one, kinds)}


def section_of(name, thing):
    parts = [f"## {name}\n"]
    if not inspect.isclass(thing):
        return "\n".join([*parts, block(signature_of(name, thing)), prose_of(thing.__doc__)])
    if thing is motes.Model:
        parts.append(block(signature_of(name, thing)))
    parts.append(prose_of(thing.__doc__))
    if thing is motes.FilterSettings:
        parts.append(block("\n".join(re.findall(r"^ +(\w+: .*)", inspect.getsource(thing), re.MULTILINE))))
    listed = [f"- `{attribute}`: {said}" for attribute, said in attributes_of(thing).items()]
    calls = []
    for member, found in members_of(thing).items():
        if isinstance(found, (property, cached_property)):
            listed.append(f"- `{member}`: " + " ".join(inspect.cleandoc(found.__doc__ or "").split()))
        else:
            calls += [f"### {name}.{member}\n", block(signature_of(f"{name}.{member}", getattr(thing, member)))]
            calls.append(prose_of(inspect.getdoc(getattr(thing, member))))
    return "\n".join([*parts, *(["\n".join(listed) + "\n"] if listed else []), *calls])


def page():
    names = sorted((name for name in motes.__all__ if name != "__version__"), key=lambda name: (name.islower(), name.lower()))
    return "\n".join([HEAD, *(section_of(name, getattr(motes, name)) for name in names)])


def test_the_page_is_what_the_package_says():
    assert PAGE.read_text(encoding="utf-8") == page(), f"{PAGE.name} is not what the package says of itself; run {Path(__file__).name} to write it anew"


def test_everything_public_is_said_to_be_something():
    for name in motes.__all__:
        thing = getattr(motes, name)
        assert thing.__doc__, name
        for member in members_of(thing) if inspect.isclass(thing) else ():
            assert inspect.getdoc(getattr(thing, member)), f"{name}.{member}"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
