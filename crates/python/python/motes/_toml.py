"""A dict as the text of a model file."""

from __future__ import annotations

import json
from typing import Any


def text_of(model: dict[str, Any]) -> str:
    """The text, in the order of the dict: a model's coordinates are in the order in which they are stated."""
    plain = {key: value for key, value in model.items() if not isinstance(value, dict)}
    lines = [f"{_key(key)} = {_value(value, key)}" for key, value in plain.items()]
    for section, table in model.items():
        if isinstance(table, dict):
            lines.append(f"[{_key(section)}]")
            lines.extend(f"{_key(key)} = {_value(value, f'{section}.{key}')}" for key, value in table.items())
    return "\n".join(lines) + "\n"


def _key(key: Any) -> str:
    return json.dumps(str(key), ensure_ascii=False)


def _value(value: Any, key: str) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        # Words of TOML for what is not finite; the model's reader refuses them by name.
        return {"inf": "inf", "-inf": "-inf", "nan": "nan"}.get(repr(value), repr(value))
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_key(name)} = {_value(one, f'{key}.{name}')}" for name, one in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(one, key) for one in value) + "]"
    raise ValueError(f"model: {key}: {value!r} is no text, number, or list or dict of them")
