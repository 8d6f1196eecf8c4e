"""Functions of JAX: compiled, and with the derivatives of what they return."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.experimental
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from .distributions import Distribution
from .step import Step, Values

jax.tree_util.register_pytree_node(
    Distribution,
    lambda one: ((one.parameters, one.scale, one.shift), one.family),
    lambda family, parts: Distribution(family, *parts),
)

jax.tree_util.register_pytree_node(
    Values,
    lambda values: (tuple(values.values()), tuple(values)),
    lambda names, values: Values(dict(zip(names, values, strict=True))),
)

jax.tree_util.register_pytree_node(
    Step,
    lambda step: ((step.index, step.time, step.dt, step.inputs, step.parameters), None),
    lambda _, parts: Step(*parts),
)

Compiled = Callable[[Step, NDArray[np.float64]], Any]


def compiled(function: Callable[[Any, Any], Any], called: str, names: list[str]) -> tuple[Compiled, Compiled]:
    """The function of as many rows as there are, and the same with derivatives along a row's coordinates.

    It is called that in messages, and returns distributions of the coordinates of these names.
    """

    def stated(step: Step, x: Any) -> list[Distribution]:
        return _coordinates(function(step, x), x.shape[0], called, names)

    def sloped(step: Step, x: Any) -> tuple[list[Distribution], list[Distribution]]:
        along = jnp.broadcast_to(jnp.eye(x.shape[1], dtype=x.dtype)[:, None, :], (x.shape[1], *x.shape))
        found: tuple[list[Distribution], list[Distribution]]
        found = jax.vmap(lambda by: jax.jvp(lambda x: stated(step, x), (x,), (by,)), out_axes=(None, 0))(along)
        return found

    return _of_any_length(jax.jit(stated)), _of_any_length(jax.jit(sloped))


def _coordinates(found: Any, particles: int, called: str, names: list[str]) -> list[Distribution]:
    """A distribution for each coordinate, with a parameter for each particle."""
    count, is_single = len(names), isinstance(found, Distribution)
    listed = [found] * count if is_single else found
    if not isinstance(listed, (list, tuple)) or not all(isinstance(one, Distribution) for one in listed):
        raise ValueError(f"{called}: {type(found).__name__}; it must be distributions, as [motes.normal(mean, sd)]")
    if len(listed) != count:
        raise ValueError(f"{called}: {len(listed)} distributions; it must be one for each of {count} coordinates")

    def column(value: Any, at: int) -> Any:
        value = jnp.asarray(value)
        if jnp.iscomplexobj(value):
            raise ValueError(f"{called}: a complex parameter of {names[at]}; it must be real")
        value = value.astype(float)
        try:
            if is_single and count > 1:
                return jnp.broadcast_to(value, (particles, count))[:, at]
            return jnp.broadcast_to(value[:, 0] if value.ndim == 2 and value.shape[1] == 1 else value, (particles,))
        except ValueError:
            wanted = "(K,)" if count == 1 or not is_single else f"(K, {count})"
            shape = tuple("K" if size == particles else size for size in value.shape)
            raise ValueError(
                f"{called}: a parameter of {names[at]}: an array of shape {shape}; it must be a number or {wanted}"
            ) from None

    return [jax.tree_util.tree_map(lambda value, at=at: column(value, at), one) for at, one in enumerate(listed)]


def _of_any_length(function: Callable[[Any, Any], Any]) -> Compiled:
    """Compiled for lengths that are powers of two: each length is compiled by itself, and there would be many."""

    def called(step: Step, x: NDArray[np.float64]) -> Any:
        particles = x.shape[0]
        length = max(32, 1 << (particles - 1).bit_length())
        padded = np.concatenate([x, np.repeat(x[-1:], length - particles, axis=0)])
        with _double_precision():
            found = function(jax.tree_util.tree_map(np.asarray, step), padded)
        # Particles are along the last axis, of parameters as of their derivatives.
        return jax.tree_util.tree_map(lambda value: np.ascontiguousarray(np.asarray(value)[..., :particles]), found)

    return called


def _double_precision() -> Any:
    """Double precision within, by the name that this version of JAX has for it."""
    return jax.enable_x64(True) if hasattr(jax, "enable_x64") else jax.experimental.enable_x64()
