"""A bank of particle filters in plain numpy, all at once; particles in columns, so that sums over coordinates are fast."""

import numpy as np

from problem import LOG_TAU


class Bank:
    """B filters of K particles; column b K + k of an array is particle k of filter b."""

    def __init__(self, problem, task):
        self.problem, self.method = problem, task["method"]
        self.by_prediction = task.get("weights", "closed-form") == "closed-form"
        self.scheme = task["resampling"]
        self.filters, self.particles = task["filters"], task["particles"]
        self.generator = np.random.Generator(np.random.SFC64(task["seed"]))
        self.first, self.later = problem.first(), problem.later()
        corrections = [self.first] + [self.later] * (len(problem.measurements) - 1)
        self.offsets = [one.offset(y) for one, y in zip(corrections, problem.measurements)]
        columns = self.filters * self.particles
        self.own = np.arange(columns).reshape(self.filters, self.particles)
        self.noise = np.empty((problem.n, columns))
        self.states, self.previous, self.spare = (np.empty((problem.n, columns)) for _ in range(3))
        self.away, self.away_y = np.empty((problem.n, columns)), np.empty((problem.m, columns))

    def run(self):
        """The log evidence of each filter."""
        shape = (self.filters, self.particles)
        log_weights, log_evidence = np.zeros(shape), np.zeros(self.filters)
        weights, total = None, np.full((self.filters, 1), float(self.particles))
        peak = np.zeros((self.filters, 1))
        for t, y in enumerate(self.problem.measurements):
            if t > 0:
                self.states, self.previous = self.previous, self.states
                effective = total[:, 0] ** 2 / np.einsum("bk,bk->b", weights, weights)
                due = np.flatnonzero(effective < self.particles / 3.0)
                if due.size:
                    self.resample(due, weights)
                    log_weights[due], peak[due], total[due] = 0.0, 0.0, self.particles
            before = peak[:, 0] + np.log(total[:, 0])
            log_weights += self.advance(t, y).reshape(shape)
            peak = log_weights.max(axis=1, keepdims=True)
            weights = np.subtract(log_weights, peak, out=weights)
            np.exp(weights, out=weights)
            total = weights.sum(axis=1, keepdims=True)
            log_evidence += peak[:, 0] + np.log(total[:, 0]) - before
        return log_evidence

    def resample(self, due, weights):
        """Draws ancestors for the filters that are due, all in one search."""
        count = due.size
        ends = weights[due].cumsum(axis=1)
        ends /= ends[:, -1:]
        ends += np.arange(count)[:, None]
        if self.scheme == "systematic":
            points = (self.generator.random((count, 1)) + np.arange(self.particles)) / self.particles
        else:
            # In order, because a search for sorted points runs through memory once.
            points = np.sort(self.generator.random((count, self.particles)), axis=1)
        points += np.arange(count)[:, None]
        found = ends.ravel().searchsorted(points.ravel(), side="right").reshape(points.shape)
        # From places among the filters that are due to places among all.
        found += ((due - np.arange(count)) * self.particles)[:, None]
        np.minimum(found, ((due + 1) * self.particles - 1)[:, None], out=found)
        ancestors = self.own.copy()
        ancestors[due] = found
        self.previous, self.spare = self.spare, self.previous
        np.take(self.spare, ancestors.ravel(), axis=1, out=self.previous, mode="clip")

    def advance(self, t, y):
        """Draws the states at time t and returns their log weights."""
        problem, sigma = self.problem, self.problem.sigma
        self.generator.standard_normal(out=self.noise)
        if self.method == "bootstrap":
            if t == 0:
                np.add(self.noise, 1.0, out=self.states)
            else:
                np.matmul(problem.a, self.previous, out=self.states)
                self.noise *= sigma
                self.states += self.noise
            return self.log_likelihood(y)
        correction = self.later if t else self.first
        np.matmul(correction.lower, self.noise, out=self.states)
        if t:
            self.states += np.matmul(correction.step, self.previous, out=self.away)
        self.states += self.offsets[t][:, None]
        if self.by_prediction:
            return self.log_prediction(t, y, correction)
        # The noise is the whitened deviation, so log q needs no product.
        log_weights = self.log_likelihood(y)
        log_weights += self.log_prior(t)
        log_weights += 0.5 * squares(self.noise) - correction.log_normalizer
        return log_weights

    def log_likelihood(self, y):
        away = np.matmul(self.problem.c, self.states, out=self.away_y)
        away -= y[:, None]
        return scaled(squares(away), self.problem.sigma, self.problem.m)

    def log_prior(self, t):
        if t == 0:
            return scaled(squares(np.subtract(self.states, 1.0, out=self.away)), 1.0, self.problem.n)
        away = np.matmul(self.problem.a, self.previous, out=self.away)
        np.subtract(self.states, away, out=away)
        return scaled(squares(away), self.problem.sigma, self.problem.n)

    def log_prediction(self, t, y, correction):
        centre = (correction.whiten @ y - correction.whitened_shift)[:, None]
        if t == 0:
            log_weight = -0.5 * float(centre[:, 0] @ centre[:, 0]) + correction.log_normalizer_of_y
            return np.full(self.states.shape[1], log_weight)
        away = np.matmul(correction.whitened_step, self.previous, out=self.away_y)
        away -= centre
        log_weights = squares(away)
        log_weights *= -0.5
        log_weights += correction.log_normalizer_of_y
        return log_weights


def squares(columns):
    """The sum of squares of each column."""
    return np.einsum("ip,ip->p", columns, columns)


def scaled(squares, sigma, dimension):
    """The log density N(0, sigma^2 I) from a sum of squares, in place."""
    squares *= -0.5 / sigma**2
    squares -= dimension * (np.log(sigma) + 0.5 * LOG_TAU)
    return squares


def build(problem, task):
    """A function that makes one pass of each filter and returns their log evidence."""
    return Bank(problem, task).run
