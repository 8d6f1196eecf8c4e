"""Particle filters of cuthbert: its generic particle filter, compiled once over the whole sequence."""

import math

import jax
import jax.numpy as jnp
import numpy as np
from cuthbert import filter as run_filter
from cuthbert.smc import particle_filter
from cuthbertlib import resampling as library
from cuthbertlib.resampling.multinomial import _sorted_uniforms
from jax import random

from problem import LOG_TAU

jax.config.update("jax_enable_x64", True)


def counted_systematic(key, logits, positions, n):
    """Systematic resampling inside the compiled program, where the library's calls back into Python."""
    ends = jnp.cumsum(jnp.exp(logits - logits.max()))
    # The points (u + i) / n that lie below the end of each particle's interval.
    below = jnp.ceil(ends * (n / ends[-1]) - random.uniform(key)).astype(int)
    steps = jnp.zeros(n, int).at[jnp.clip(below, 0, n)].add(1, mode="drop")
    chosen = jnp.clip(jnp.cumsum(steps), 0, n - 1)
    return chosen, jnp.zeros(n), positions[chosen]


def searched_multinomial(key, logits, positions, n):
    """Multinomial resampling inside the compiled program, its ancestors in order."""
    ends = jnp.cumsum(jnp.exp(logits - logits.max()))
    points = _sorted_uniforms(key, n) * ends[-1]
    # The points below each end, then the ends below each point, by counting.
    below = jnp.searchsorted(points, ends, method="scan_unrolled").astype(int)
    steps = jnp.zeros(n, int).at[below].add(1, mode="drop")
    chosen = jnp.clip(jnp.cumsum(steps), 0, n - 1)
    return chosen, jnp.zeros(n), positions[chosen]


RESAMPLING = {
    ("systematic", "compiled"): counted_systematic,
    ("multinomial", "compiled"): searched_multinomial,
    ("systematic", "library"): library.systematic.resampling,
    ("multinomial", "library"): library.multinomial.resampling,
}


def of_residual(whitened, log_scale):
    """The log density of a normal vector from its whitened deviation."""
    return -0.5 * jnp.sum(whitened * whitened) - log_scale - whitened.shape[-1] * 0.5 * LOG_TAU


def functions(problem, method, weights):
    """The first draw and its log weight, later draws and their log weights, and what each time brings along."""
    a, c, sigma, y = problem.a, problem.c, problem.sigma, problem.measurements
    log_sigma = math.log(sigma)

    def log_likelihood(x, y):
        return of_residual((y - c @ x) / sigma, problem.m * log_sigma)

    if method == "bootstrap":
        return (
            lambda key: 1.0 + random.normal(key, (problem.n,)),
            lambda x: log_likelihood(x, y[0]),
            lambda key, xp, known: a @ xp + sigma * random.normal(key, (problem.n,)),
            lambda xp, x, known: log_likelihood(x, known["y"]),
            {"y": y[1:]},
        )

    first, later = problem.first(), problem.later()
    log_scale, log_scale_of_first = (-r.log_normalizer - problem.n * 0.5 * LOG_TAU for r in (later, first))
    log_scale_of_y, log_scale_of_first_y = (
        -r.log_normalizer_of_y - problem.m * 0.5 * LOG_TAU for r in (later, first)
    )
    known = {
        "y": y[1:],
        "offset": np.array([later.offset(row) for row in y[1:]]).reshape(-1, problem.n),
        "whitened": y[1:] @ later.whiten.T,
    }

    def draw_first(key):
        return first.offset(y[0]) + first.lower @ random.normal(key, (problem.n,))

    def draw(key, xp, known):
        mean = later.step @ xp + known["offset"]
        return mean + later.lower @ random.normal(key, (problem.n,))

    def weigh_first(x):
        whitened = first.inverse_lower @ (x - first.offset(y[0]))
        log_q = of_residual(whitened, log_scale_of_first)
        return of_residual(x - 1.0, 0.0) + log_likelihood(x, y[0]) - log_q

    def weigh(xp, x, known):
        whitened = later.inverse_lower @ (x - later.step @ xp - known["offset"])
        log_transition = of_residual((x - a @ xp) / sigma, problem.n * log_sigma)
        return log_transition + log_likelihood(x, known["y"]) - of_residual(whitened, log_scale)

    if weights == "densities":
        return draw_first, weigh_first, draw, weigh, known

    def weigh_first_by_prediction(x):
        return of_residual(first.whiten @ y[0] - first.whitened_shift, log_scale_of_first_y)

    def weigh_by_prediction(xp, x, known):
        return of_residual(known["whitened"] - later.whitened_step @ xp, log_scale_of_y)

    return draw_first, weigh_first_by_prediction, draw, weigh_by_prediction, known


def build(problem, task):
    """A function that makes one pass of each filter and returns their log evidence."""
    count = task["particles"]
    draw_first, weigh_first, draw, weigh, known = functions(
        problem, task["method"], task.get("weights", "closed-form")
    )
    scheme = RESAMPLING[task["resampling"], task.get("ancestors", "compiled")]
    chain = particle_filter.build_filter(
        draw_first, draw, weigh, count, library.ess_decorator(scheme, 1.0 / 3.0)
    )
    known = jax.tree.map(jnp.asarray, known)

    def once(key):
        key_of_first, key_of_rest = random.split(key)
        start = chain.init_prepare(key=key_of_first)
        log_weights = jax.vmap(weigh_first)(start.particles)
        start = start._replace(
            log_weights=log_weights,
            log_normalizing_constant=jax.nn.logsumexp(log_weights) - math.log(count),
        )
        return run_filter(chain, known, start, key=key_of_rest).log_normalizing_constant[-1]

    if task["filters"] == 1:
        passes = jax.jit(lambda key: once(key)[None])
    else:
        passes = jax.jit(lambda key: jax.vmap(once)(random.split(key, task["filters"])))
    keys = fresh_keys(random.key(task["seed"]))
    return lambda: np.asarray(passes(next(keys)))


def fresh_keys(key):
    """A fresh key for each pass, made before it is asked for."""
    while True:
        fresh = random.split(key, 1000)
        key = fresh[0]
        yield from list(fresh[1:])
