"""Posteriors of the models beside this file, by sums over grids: exact means and standard deviations for what `motes fit` finds.

    python examples/fit/references.py                     prints them
    python examples/fit/references.py ricker ricker-fit   prints them beside the draws in a folder of a fit

It needs NumPy. The states of Ricker's map and of the pound's volatility are summed over a grid, the Nile's are a Kalman filter's; parameters are
summed over a box of 4.5 standard deviations around the posterior, which is found in two rounds. Influenza is summed over all numbers of susceptible
and ill boys, seven seconds for each value of the parameters and half an hour in all. Its parameters are therefore summed over 257 places within 5.5
standard deviations of where a fit had them. 257 places that were nearer to each other by a quarter gave means within 0.2 %, and standard deviations within 1 %.
"""

import csv
import json
import math
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
LOG_2PI = math.log(2 * math.pi)


def column(path, name):
    with open(path) as file:
        return np.array([float(row[name]) for row in csv.DictReader(file)])


def normal(x, mean, sd):
    return -0.5 * ((x - mean) / sd) ** 2 - np.log(sd) - 0.5 * LOG_2PI


def log_normal(x, location, scale):
    return normal(np.log(x), location, scale) - np.log(x)


class Nile:
    names = ["measurement_variance", "level_variance"]
    start, spread = [9.6, 7.2], [0.3, 1.0]
    flow = column(HERE.parent / "nile.csv", "flow")

    def values(self, u):
        return np.exp(u)

    def log_joint(self, u):
        r, q = np.exp(u)
        # Densities of the logarithms, which the sum is over.
        found = normal(u[0], math.log(10000), 1.5) + normal(u[1], math.log(1000), 1.5)
        mean, variance = 1000.0, 1000.0**2
        for number, y in enumerate(self.flow):
            variance += q if number else 0.0
            total = variance + r
            found += normal(y, mean, math.sqrt(total))
            gain = variance / total
            mean, variance = mean + gain * (y - mean), variance * (1 - gain)
        return found


class Ricker:
    names = ["log_r", "sigma", "phi"]
    start, spread = [3.8, math.log(0.2), math.log(10)], [0.1, 0.25, 0.04]
    counts = column(HERE / "ricker.csv", "y")
    grid = np.arange(-45.0, 6.0, 0.04)

    def values(self, u):
        return np.array([u[0], math.exp(u[1]), math.exp(u[2])])

    def log_joint(self, u):
        log_r, sigma, phi = self.values(u)
        found = normal(log_r, 3.5, 1.0) + math.log(2) + normal(sigma, 0.0, 0.5) + u[1] + normal(u[2], math.log(10), 0.7)
        x, step = self.grid, self.grid[1] - self.grid[0]
        log_mean = math.log(phi) + x
        factorials = np.array([math.lgamma(y + 1) for y in self.counts])
        # p(y_t | x) for all points of the grid.
        weigh = [np.exp(y * log_mean - np.exp(log_mean) - factorial) for y, factorial in zip(self.counts, factorials)]
        centres = log_r + x - np.exp(x)
        move = np.exp(normal(x[:, None], centres[None, :], sigma)) * step
        first = math.log(7)
        found += self.counts[0] * (math.log(phi) + first) - phi * math.exp(first) - factorials[0]
        density = np.exp(normal(x, log_r + first - math.exp(first), sigma))
        for number, weights in enumerate(weigh[1:]):
            if number:
                density = move @ density
            density = density * weights
            total = density.sum() * step
            found += math.log(total)
            density /= total
        return found


class Pound:
    names = ["mu", "phi", "sigma"]
    start, spread = [-1.73, 0.24, -0.45], [0.08, 0.22, 0.17]
    returns = column(HERE / "pound.csv", "return")

    def values(self, u):
        return np.array([u[0], math.tanh(u[1]), math.exp(u[2])])

    def log_joint(self, u):
        mu, phi, sigma = self.values(u)
        # The prior of phi is uniform on (−1, 1); the derivatives of tanh and exp make densities of what the sum is over.
        found = normal(mu, -1.0, 1.0) + math.log(0.5) + math.log(1 - phi * phi) + math.log(2) + normal(sigma, 0.0, 1.0) + u[2]
        sd = sigma / math.sqrt(1 - phi * phi)
        x = mu + sd * np.linspace(-7.0, 7.0, 141)
        step = x[1] - x[0]
        move = np.exp(normal(x[:, None], mu + phi * (x[None, :] - mu), sigma)) * step
        density = np.exp(normal(x, mu, sd))
        for number, y in enumerate(self.returns):
            if number:
                density = move @ density
            density = density * np.exp(normal(y, 0.0, np.exp(x / 2)))
            total = density.sum() * step
            found += math.log(total)
            density /= total
        return found


class Influenza:
    names = ["infection", "recovery", "size"]
    boys = 763
    # Where a fit had its posterior, in logarithms: its mean, and 1.25 times a factor of its covariance, since the size has a long tail.
    start = [0.815, -0.4645, 3.108]
    axes = [[0.144, 0.0, 0.0], [-0.0644, 0.1034, 0.0], [-0.1067, -0.0646, 0.704]]
    counts = column(HERE.parent / "influenza.csv", "in_bed")
    log_factorial = np.array([math.lgamma(n + 1) for n in range(764)])

    def values(self, u):
        return np.exp(u)

    def binomial(self, n, k, p):
        """Probabilities of k out of n; 0 where k is more."""
        rest = n - k
        logs = self.log_factorial[n] - self.log_factorial[k] - self.log_factorial[np.maximum(rest, 0)]
        return np.where(rest >= 0, np.exp(logs + k * math.log(p) + rest * math.log1p(-p)), 0.0)

    @staticmethod
    def near(low, high, p):
        """Numbers that binomial draws of low to high take but with a probability of about 1e-12."""
        reach = 7 * math.sqrt(high * p * (1 - p)) + 7
        return np.arange(max(0, int(low * p - reach)), min(high, int(high * p + reach) + 1) + 1)

    def day(self, before, infection, recovery):
        """Probabilities of (S, I) a day later."""
        after = np.zeros_like(before)
        least = 1e-13 * before.sum()
        get_well = 1 - math.exp(-recovery)
        for ill in np.flatnonzero(before.max(axis=0) > least):
            if ill == 0:
                after[:, 0] += before[:, 0]
                continue
            fall_ill = 1 - math.exp(-infection * ill / self.boys)
            susceptible = np.flatnonzero(before[:, ill] > least)
            low, high = susceptible[0], susceptible[-1]
            new, well = self.near(low, high, fall_ill), self.near(ill, ill, get_well)
            # Row: the number that is left; column: the number that has fallen ill.
            left = np.arange(max(0, low - new[-1]), high - new[0] + 1)
            were = left[:, None] + new[None, :]
            inside = (were >= low) & (were <= high)
            were = np.where(inside, were, low)
            joint = np.where(inside, before[were, ill] * self.binomial(were, np.broadcast_to(new, were.shape), fall_ill), 0.0)
            # The number of the ill changes by those who fall ill less those who get well.
            change = np.arange(new[0] - well[-1], new[-1] - well[0] + 1)
            gone = new[:, None] - change[None, :]
            ends = np.where((gone >= well[0]) & (gone <= well[-1]), self.binomial(ill, np.clip(gone, well[0], well[-1]), get_well), 0.0)
            places = ill + change
            fits = (places >= 0) & (places <= self.boys)
            after[left[0] : left[-1] + 1, places[fits][0] : places[fits][-1] + 1] += (joint @ ends)[:, fits]
        return after

    def log_joint(self, u):
        infection, recovery, size = self.values(u)
        found = normal(u[0], math.log(1.5), 0.5) + normal(u[1], math.log(0.5), 0.5) + normal(u[2], math.log(10), 1.0)
        density = np.zeros((self.boys + 1, self.boys + 1))
        for ill in range(60):
            density[self.boys - ill, ill] = math.exp(ill * math.log(3.3) - 3.3 - math.lgamma(ill + 1))
        mean = np.arange(self.boys + 1) + 0.1
        for number, y in enumerate(self.counts):
            if number:
                density = self.day(density, infection, recovery)
            logs = math.lgamma(y + size) - math.lgamma(size) - math.lgamma(y + 1)
            density = density * np.exp(logs + size * np.log(size / (size + mean)) + y * np.log(mean / (size + mean)))
            total = density.sum()
            found += math.log(total)
            density /= total
        return found


MODELS = {"nile": Nile, "ricker": Ricker, "pound": Pound, "influenza": Influenza}
# Places along axes, in units of theirs.
STEP, REACH = 1.1, 4.4


def posterior_on_axes(model):
    """Means, standard deviations and log p(y), over places within a ball along the axes of a posterior."""
    line = np.arange(-REACH, REACH + STEP / 2, STEP)
    places = np.stack(np.meshgrid(line, line, line, indexing="ij"), -1).reshape(-1, 3)
    places = places[(places**2).sum(axis=1) <= REACH**2 + 1e-9]
    axes = np.array(model.axes)
    positions = np.array(model.start) + places @ axes.T
    return moments(model, positions, STEP**3 * abs(np.linalg.det(axes)))


def weights_at(model, positions):
    """The share of the posterior at each place, and the logarithm of the sum of all."""
    logs = np.array([model.log_joint(u) for u in positions])
    weights = np.exp(logs - logs.max())
    return weights / weights.sum(), logs.max() + math.log(weights.sum())


def moments(model, positions, cell):
    """Means, standard deviations and log p(y), each place having so large a cell."""
    weights, log_sum = weights_at(model, positions)
    values = np.array([model.values(u) for u in positions])
    means = weights @ values
    return means, np.sqrt(weights @ (values - means) ** 2), log_sum + math.log(cell)


def box(centre, spread, points, ends):
    """Places within so many standard deviations, and the cell of each."""
    line = np.linspace(-ends, ends, points)
    places = np.stack(np.meshgrid(*[line] * len(centre), indexing="ij"), -1).reshape(-1, len(centre))
    return np.array(centre) + places * np.array(spread), np.prod(spread) * (line[1] - line[0]) ** len(centre)


def posterior(model, points=13):
    """Means, standard deviations and log p(y); a box is moved and scaled once by what a first sum finds."""
    if hasattr(model, "axes"):
        return posterior_on_axes(model)
    positions, _ = box(model.start, model.spread, 7, 3.5)
    weights, _ = weights_at(model, positions)
    centre = weights @ positions
    spread = np.sqrt(weights @ (positions - centre) ** 2)
    return moments(model, *box(centre, spread, points, 4.5))


def main():
    named = sys.argv[1:2] or list(MODELS)
    for name in named:
        model = MODELS[name]()
        means, sds, log_marginal = posterior(model)
        print(f"{name}: log marginal likelihood {log_marginal:.3f}")
        found = {}
        if len(sys.argv) > 2:
            found = json.loads((Path(sys.argv[2]) / "summary.json").read_text())
            print(f"  the fit has {found['log_marginal_likelihood']:.3f} ± {found['log_marginal_likelihood_error']:.3f}")
        for at, parameter in enumerate(model.names):
            line = f"  {parameter}: {means[at]:.5g} ± {sds[at]:.4g}"
            if found:
                of = found["parameters"][parameter]
                errors = (of["mean"] - means[at]) / of["mcse"]
                line += f"; the fit has {of['mean']:.5g} ± {of['sd']:.4g}, {errors:+.1f} Monte Carlo standard errors off"
            print(line)


if __name__ == "__main__":
    main()
