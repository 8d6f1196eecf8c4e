"""A particle filter with a proposal that is learned once, in JAX: the whole sequence is one compiled scan."""

import math

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax, random

from once_heads import head_of, log_sum_exp
from once_models import MODELS, log_likelihood
from once_networks import pairs_of, problem_of, theta_of_columns, theta_of_rows, weights_of

DEFENSIVE, ENOUGH, LARGEST_INPUT = 0.1, 0.5, 10.0
LOG_HEAD, LOG_SAFE = math.log1p(-DEFENSIVE), math.log(DEFENSIVE)


def base(model, y, centres, slopes):
    """b, the rows of the triangle L over the coordinates that are seen, and the innovations.

    `crates/proposals/src/amortised/units.rs` with `base/`: one Fisher-scoring step in units of the noise, or the transition. All other
    coordinates have b = 0 and a row of the identity.
    """
    seen = model.seen if model.linearised else 0
    jacobian = [[entry * slopes[i] for i, entry in enumerate(row)] for row in model.jacobian(centres)]
    residuals = [y[j] - found for j, found in enumerate(model.locations(centres))]
    information = [scale**-2 for scale in model.scales]
    innovations, scores = [], []
    for row, residual, known in zip(jacobian, residuals, information):
        score, spread = residual * known, sum(entry * entry for entry in row)
        found = score / jnp.sqrt(known * (known * spread + 1.0))
        innovations.append(jnp.where(jnp.isfinite(found), found, 0.0))
        scores.append(score)
    lower = [[None] * seen for _ in range(seen)]
    shift = [sum(row[i] * score for row, score in zip(jacobian, scores)) for i in range(seen)]
    for j in range(seen):
        for i in range(j, seen):
            entry = sum(known * row[i] * row[j] for row, known in zip(jacobian, information))
            entry = entry + (1.0 if i == j else 0.0) - sum(lower[i][k] * lower[j][k] for k in range(j))
            lower[i][j] = jnp.sqrt(entry) if i == j else entry / lower[j][j]
    for i in range(seen):
        shift[i] = (shift[i] - sum(lower[i][k] * shift[k] for k in range(i))) / lower[i][i]
    return solve_upper(lower, shift), lower, innovations


def solve_upper(lower, values):
    """L^-T values; what is not seen stays."""
    values = list(values)
    for i in reversed(range(len(lower))):
        rest = sum(lower[k][i] * values[k] for k in range(i + 1, len(lower)))
        values[i] = (values[i] - rest) / lower[i][i]
    return values


def times_upper(lower, values):
    """L' values."""
    seen = range(len(lower))
    return [sum(lower[k][i] * values[k] for k in seen[i:]) for i in seen] + list(values[len(lower) :])


def systematic(key, weights, x):
    """Systematic resampling by counting points below the end of each particle's interval, inside the compiled program."""
    count = weights.shape[0]
    ends = jnp.cumsum(weights)
    below = jnp.ceil(ends * (count / ends[-1]) - random.uniform(key, dtype=weights.dtype)).astype(jnp.int32)
    steps = jnp.zeros(count, jnp.int32).at[jnp.clip(below, 0, count)].add(1, mode="drop")
    return x[:, jnp.clip(jnp.cumsum(steps), 0, count - 1)]


def build(task):
    """A function that makes one pass and returns its log evidence, and one that shows the density of the proposal."""
    folder, count = task["folder"], task["particles"]
    real = jnp.float64 if task["bits"] == 64 else jnp.float32
    model = MODELS[task["model"]]()
    head, n = head_of(model), len(model.slopes)
    y = jnp.asarray(np.array(problem_of(folder)["measurements"]), real)
    by_rows = task.get("layout", "columns") == "rows"

    def network(name):
        weights, (means, scales) = weights_of(folder, name)

        def theta(inputs):
            standard = [(row - mean) * scale for row, mean, scale in zip(inputs, means.tolist(), scales.tolist())]
            standard = [jnp.clip(row, -LARGEST_INPUT, LARGEST_INPUT) for row in standard]
            standard = [jnp.where(jnp.isnan(row), 0.0, row).astype(jnp.float32) for row in standard]
            if by_rows:
                return theta_of_rows(weights, jnp.stack(standard, 1)).T.astype(real)
            return theta_of_columns(weights, jnp.stack(standard)).astype(real)

        return theta

    initial, later = network("initial"), network("later")

    def log_densities(theta, shift, lower, v):
        """Logarithms of the mixture and of the transition at noise v; the slopes of the transition are left out of both."""
        moved = [value - shift[i] if i < len(shift) else value for i, value in enumerate(v)]
        log_head = head.log_density(theta, times_upper(lower, moved))
        log_head = log_head + sum(jnp.log(lower[i][i]) for i in range(len(lower)))
        log_transition = -0.5 * sum(value * value for value in v) - 0.5 * n * math.log(2.0 * math.pi)
        return log_sum_exp([log_head + LOG_HEAD, log_transition + LOG_SAFE]), log_transition

    def draw(key, y, centres, slopes, shift, lower, theta):
        """States, and log p(y|x) + log p(x|x') - log q of each.

        One uniform number chooses between the transition, and the component of the head; the same normal numbers serve all.
        """
        of_noise, of_choice = random.split(key)
        noise = list(random.normal(of_noise, (n, count), real))
        uniform = random.uniform(of_choice, (count,), real)
        is_safe = uniform < DEFENSIVE
        drawn = head.draw(theta, (uniform - DEFENSIVE) / (1.0 - DEFENSIVE), noise)
        drawn = solve_upper(lower, drawn)
        drawn = [value + shift[i] if i < len(shift) else value for i, value in enumerate(drawn)]
        v = [jnp.where(is_safe, safe, value) for safe, value in zip(noise, drawn)]
        states = [centre + slope * value for centre, slope, value in zip(centres, slopes, v)]
        mixture, log_transition = log_densities(theta, shift, lower, v)
        return jnp.stack(states), log_likelihood(model, y, states) + log_transition - mixture

    def weigh(log_weights):
        """Weights that sum to 1, their logarithms, and log of the sum before."""
        largest = jnp.max(log_weights)
        weights = jnp.exp(log_weights - largest)
        total = jnp.sum(weights)
        log_total = largest + jnp.log(total)
        return weights / total, log_weights - log_total, log_total

    def first(key):
        centres, slopes = ([jnp.full((1,), value, real) for value in of] for of in (model.centres_of_first, model.slopes_of_first))
        shift, lower, innovations = base(model, y[0], centres, slopes)
        measured = [jnp.full((1,), value) for value in y[0]]
        x, increments = draw(key, y[0], centres, slopes, shift, lower, initial(measured + innovations))
        weights, log_weights, log_total = weigh(increments)
        return x, weights, log_weights, log_total - math.log(count)

    def condition(t, x, y):
        """What states are drawn with, given those before."""
        centres = model.centres(t, x)
        shift, lower, innovations = base(model, y, centres, model.slopes)
        measured = [jnp.full(x.shape[1], value) for value in y]
        return centres, shift, lower, later(list(x) + centres + measured + innovations)

    def step(state, known):
        x, weights, log_weights, log_evidence = state
        t, y, key = known
        of_resampling, of_draw = random.split(key)
        x, log_weights = lax.cond(
            jnp.sum(weights * weights) * (ENOUGH * count) > 1.0,
            lambda: (systematic(of_resampling, weights, x), jnp.full(count, -math.log(count), real)),
            lambda: (x, log_weights),
        )
        centres, shift, lower, theta = condition(t, x, y)
        x, increments = draw(of_draw, y, centres, model.slopes, shift, lower, theta)
        weights, log_weights, log_total = weigh(log_weights + increments)
        return (x, weights, log_weights, log_evidence + log_total), None

    def loss():
        """Minus the mean log density, at the pairs of states in the folder, of what filters draw from."""
        previous, states = (jnp.asarray(pairs_of(folder, name, n), real) for name in ("previous", "states"))
        centres, shift, lower, theta = condition(jnp.asarray(1.0, real), previous, y[1])
        v = [(state - centre) / slope for state, centre, slope in zip(states, centres, model.slopes)]
        mixture, _ = log_densities(theta, shift, lower, v)
        return -jnp.mean(mixture) + sum(math.log(slope) for slope in model.slopes)

    def once(key):
        keys = random.split(key, y.shape[0])
        times = jnp.arange(1, y.shape[0]).astype(real)
        state, _ = lax.scan(step, first(keys[0]), (times, y[1:], keys[1:]))
        return state[-1]

    passes, keys = jax.jit(once), fresh_keys(random.key(1, impl=task.get("generator")))
    return lambda: np.asarray(passes(next(keys)))[None], lambda: float(jax.jit(loss)())


def fresh_keys(key):
    """A fresh key for each pass, made before it is asked for."""
    while True:
        fresh = random.split(key, 1000)
        key = fresh[0]
        yield from list(fresh[1:])
