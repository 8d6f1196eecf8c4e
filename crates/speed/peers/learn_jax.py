"""Gradient steps of the inclusive objective in JAX: all steps of a run are one compiled scan."""

import math
import os

import jax
import jax.numpy as jnp
import numpy as np

from once_heads import head_of
from once_models import MODELS
from once_networks import problem_of, theta_of_columns, theta_of_rows, weights_of

FLOOR, LARGEST_NORM = 0.02, 5.0
RATE, BETA_1, BETA_2, EPSILON = 3e-3, 0.9, 0.999, 1e-8


class Learning:
    """Weights and moments, and a compiled run of steps."""

    def __init__(self, task):
        folder, self.steps = task["folder"], task["steps"]
        real = jnp.float64 if task["bits"] == 64 else jnp.float32
        model = MODELS[task["model"]]()
        rows, head = problem_of(folder)["rows"], head_of(model)

        def read(name, width, kind):
            values = np.fromfile(os.path.join(folder, f"{name}.f64"), dtype="<f8")
            # Batches, then a row each number and a column each particle.
            return jnp.asarray(values.reshape(-1, rows, width).transpose(0, 2, 1), kind)

        weights, _ = weights_of(folder, "later")
        n = len(model.slopes)
        inputs = read("inputs", weights["0.weight"].shape[0], jnp.float32)
        units, log_transition = read("units", n, real), read("log_transition", 1, real)
        by_rows = task.get("layout", "columns") == "rows"
        if by_rows:
            inputs = inputs.transpose(0, 2, 1)
        batches = units.shape[0]
        log_head, log_floor = math.log1p(-FLOOR), math.log(FLOOR)

        def loss(weights, batch):
            inputs, units, log_transition = batch
            theta = theta_of_rows(weights, inputs).T if by_rows else theta_of_columns(weights, inputs)
            of_head = head.log_density(theta.astype(real), units) + log_head
            log_transition = log_transition[0]
            mixture = jnp.logaddexp(of_head, log_transition + log_floor)
            return -jnp.mean(mixture - log_transition)

        def differentiate(weights, step):
            batch = [jax.lax.dynamic_index_in_dim(part, step % batches, keepdims=False) for part in data]
            found, gradient = jax.value_and_grad(loss)(weights, batch)
            norm = jnp.sqrt(sum(jnp.sum(part * part) for part in jax.tree.leaves(gradient)))
            return found, gradient, norm

        def step(state, number):
            weights, first, second, taken = state
            found, gradient, norm = differentiate(weights, number)
            scale = jnp.minimum(1.0, LARGEST_NORM / norm)
            taken = taken + 1.0
            rate = RATE / (1.0 - BETA_1**taken)
            correction = 1.0 / jnp.sqrt(1.0 - BETA_2**taken)

            def adam(weight, g, m, v):
                g = g * scale
                m = BETA_1 * m + (1.0 - BETA_1) * g
                v = BETA_2 * v + (1.0 - BETA_2) * g * g
                return weight - rate * m / (jnp.sqrt(v) * correction + EPSILON), m, v

            moved = {key: adam(weights[key], gradient[key], first[key], second[key]) for key in weights}
            weights, first, second = ({key: part[i] for key, part in moved.items()} for i in range(3))
            return (weights, first, second, taken), found

        data = (inputs, units, log_transition)
        weights = jax.tree.map(jnp.asarray, weights)
        found, _, norm = jax.jit(differentiate)(weights, 0)
        self.at_first = {"loss": float(found), "gradient_norm": float(norm)}
        zeros = lambda: jax.tree.map(jnp.zeros_like, weights)
        self.state = (weights, zeros(), zeros(), jnp.zeros((), jnp.float32))
        numbers = jnp.arange(self.steps)
        self.steps_of_run = jax.jit(lambda state: jax.lax.scan(step, state, numbers), donate_argnums=0)

    def run(self):
        self.state, losses = self.steps_of_run(self.state)
        return float(jax.block_until_ready(losses)[-1])
