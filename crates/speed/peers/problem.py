"""A linear Gaussian problem: x_0 ~ N(1, I), x_t = A x_{t-1} + v_t, y_t = C x_t + w_t, noises of covariance sigma^2 I."""

import json
import math

import numpy as np

LOG_TAU = math.log(2.0 * math.pi)


class Problem:
    """What the file says, and the minimum-degeneracy proposal p(x_t | x_{t-1}, y_t) in closed form."""

    def __init__(self, path):
        with open(path, encoding="utf-8") as file:
            self.raw = json.load(file)
        self.a = np.array(self.raw["A"])
        self.c = np.array(self.raw["C"])
        self.sigma = float(self.raw["sigma"])
        self.measurements = np.array(self.raw["measurements"])
        self.n, self.m = self.a.shape[0], self.c.shape[0]

    def first(self):
        """The correction of the prior N(1, I) by y_0."""
        return Correction(np.zeros_like(self.a), np.ones(self.n), np.eye(self.n), self)

    def later(self):
        """The correction of N(A x_{t-1}, sigma^2 I) by y_t."""
        return Correction(self.a, np.zeros(self.n), self.sigma**2 * np.eye(self.n), self)


class Correction:
    """p(x_t | x_{t-1}, y_t) = N(offset(y_t) + step x_{t-1}, L L') for the prediction N(a x_{t-1} + b, prior).

    p(y_t | x_{t-1}) = N(C (a x_{t-1} + b), C prior C' + sigma^2 I), whose inverse factor is `whiten`.
    """

    def __init__(self, a, b, prior, problem):
        c, variance = problem.c, problem.sigma**2
        precision = np.linalg.inv(prior) + c.T @ c / variance
        covariance = np.linalg.inv(precision)
        self.gain = covariance @ c.T / variance
        rest = np.eye(problem.n) - self.gain @ c
        self.step, self.shift = rest @ a, rest @ b
        self.lower = np.linalg.cholesky(covariance)
        self.inverse_lower = np.linalg.inv(self.lower)
        self.log_normalizer = -np.log(np.diag(self.lower)).sum() - 0.5 * problem.n * LOG_TAU
        predicted = np.linalg.cholesky(c @ prior @ c.T + variance * np.eye(problem.m))
        self.whiten = np.linalg.inv(predicted)
        self.whitened_step, self.whitened_shift = self.whiten @ c @ a, self.whiten @ c @ b
        self.log_normalizer_of_y = -np.log(np.diag(predicted)).sum() - 0.5 * problem.m * LOG_TAU

    def offset(self, y):
        return self.shift + self.gain @ y
