"""Heads of proposals that are learned once: draws and log densities from rows of theta, as crates/proposals/src/amortised/heads."""

import math

import jax.numpy as jnp

LARGEST_LOG_SCALE = 6.0


def bounded(theta):
    """Logarithms of scales within bounds."""
    return theta / jnp.sqrt(1.0 + (theta / LARGEST_LOG_SCALE) ** 2)


class Normal:
    """N(m, (A'A)^-1): the mean, the logarithms of A's diagonal, and A's entries below it, row after row."""

    def __init__(self, n):
        self.n, self.outputs = n, 2 * n + n * (n - 1) // 2

    def below(self, theta, i, j):
        return theta[2 * self.n + i * (i - 1) // 2 + j]

    def log_density(self, theta, u):
        n, total = self.n, -0.5 * math.log(2.0 * math.pi) * self.n
        deviations = [u[i] - theta[i] for i in range(n)]
        for i in range(n):
            log_scale = bounded(theta[n + i])
            noise = deviations[i] * jnp.exp(log_scale)
            for j in range(i):
                noise = noise + self.below(theta, i, j) * deviations[j]
            total = total + log_scale - 0.5 * noise * noise
        return total

    def draw(self, theta, uniform, noise):
        n, found = self.n, []
        for i in range(n):
            left = noise[i]
            for j in range(i):
                left = left - self.below(theta, i, j) * found[j]
            found.append(left * jnp.exp(-bounded(theta[n + i])))
        return [found[i] + theta[i] for i in range(n)]


def log_sum_exp(logs):
    """Unrolled, so that it becomes one loop over particles with all that is around it."""
    largest = logs[0]
    for log in logs[1:]:
        largest = jnp.maximum(largest, log)
    return largest + jnp.log(sum(jnp.exp(log - largest) for log in logs))


class Mixture:
    """Gaussians with probabilities softmax(lambda): lambda, mean and factor of each."""

    def __init__(self, n, components):
        self.normal = Normal(n)
        self.components, self.each = components, 1 + self.normal.outputs
        self.outputs = components * self.each

    def parts(self, theta):
        return [theta[k * self.each : (k + 1) * self.each] for k in range(self.components)]

    def log_density(self, theta, u):
        parts = self.parts(theta)
        logs = [part[0] + self.normal.log_density(part[1:], u) for part in parts]
        return log_sum_exp(logs) - log_sum_exp([part[0] for part in parts])

    def draw(self, theta, uniform, noise):
        parts = self.parts(theta)
        largest = parts[0][0]
        for part in parts[1:]:
            largest = jnp.maximum(largest, part[0])
        odds = [jnp.exp(part[0] - largest) for part in parts]
        point = uniform * sum(odds)
        chosen, below = parts[0], 0.0
        for odd, part in zip(odds, parts[1:]):
            below = below + odd
            chosen = [jnp.where(point >= below, other, one) for one, other in zip(chosen, part)]
        return self.normal.draw(chosen[1:], None, noise)


def head_of(model):
    n = len(model.slopes)
    return Mixture(n, model.components) if model.components else Normal(n)
