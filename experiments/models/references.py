"""Right values of the models of this folder, from exact methods: Kalman's filter, the forward algorithm,
and quadrature on a grid. `python references.py` needs NumPy. Data files that are not there are left out."""

import csv
import math
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
LOG_2PI = math.log(2 * math.pi)
lgamma = np.vectorize(math.lgamma, otypes=[float])


def columns(path):
    """The columns of a CSV file; cells that are no number are NaN."""

    def number(cell):
        try:
            return float(cell)
        except ValueError:
            return math.nan

    with open(HERE / path) as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([number(row[name]) for row in rows]) for name in rows[0]}


def normal(x, mean, sd):
    return -0.5 * ((x - mean) / sd) ** 2 - np.log(sd) - LOG_2PI / 2


def poisson(y, mean):
    return y * np.log(mean) - mean - lgamma(y + 1)


def negative_binomial(y, mean, size):
    p = size / (size + mean)
    return lgamma(y + size) - lgamma(size) - lgamma(y + 1) + size * np.log(p) + y * np.log1p(-p)


def binomial_logit(y, n, x):
    return lgamma(n + 1) - lgamma(y + 1) - lgamma(n - y + 1) + y * x - n * np.logaddexp(0, x)


def kalman(rows, m, P, C, R, step):
    """log p(y) where y = C x + d + N(0, R) at rows (y, d), and step(k, m, P) predicts row k from row k - 1."""
    total = 0.0
    for k, (y, d) in enumerate(rows):
        if k > 0:
            m, P = step(k, m, P)
        here = ~np.isnan(y)
        if here.any():
            c, e = C[here], (y - C @ m - d)[here]
            F = c @ P @ c.T + (R[k] if np.ndim(R) == 3 else R)[np.ix_(here, here)]
            gain = np.linalg.solve(F, c @ P).T
            total -= 0.5 * (e @ np.linalg.solve(F, e) + np.linalg.slogdet(F)[1] + here.sum() * LOG_2PI)
            m, P = m + gain @ e, P - gain @ c @ P
            P = (P + P.T) / 2
    return total


def linear(A, Q, mean=0.0):
    """The prediction of a step x - mean -> A (x - mean) + N(0, Q)."""
    return lambda _, m, P: (mean + A @ (m - mean), A @ P @ A.T + Q)


def forward(log_likelihoods, start, transition):
    """log p(y) of a chain with few states: log_likelihoods[k, s], start[s], transition[from, to]."""
    total, p = 0.0, start
    for k, row in enumerate(log_likelihoods):
        p = (p if k == 0 else p @ transition) * np.exp(row - row.max())
        total += row.max() + math.log(p.sum())
        p = p / p.sum()
    return total


def grid(log_likelihood, rows, start, points, weights, kernel):
    """log p(y) by quadrature. start is a log-density at the points, or a known x; kernel(k) is log p(x' | x)
    of the step to row k as [x, x'], or of a known x as [x']."""
    total, known = 0.0, not isinstance(start, np.ndarray)
    p = None if known else np.exp(start) * weights
    if known:
        total += float(log_likelihood(rows[0], np.array([start]))[0])
    for k in range(1 if known else 0, len(rows)):
        if p is None:
            p = np.exp(kernel(k, np.array([start]))[0]) * weights
        elif k > 0:
            p = (p @ np.exp(kernel(k, points))) * weights
        row = log_likelihood(rows[k], points)
        p = p * np.exp(row - row.max())
        total += row.max() + math.log(p.sum())
        p = p / p.sum()
    return total


def arma():
    y = columns("arma/data.csv")["change"]
    ar, ma, var = 0.8742288, -0.4120458, 0.7250436**2
    A, Q = np.array([[ar, 1.0], [0.0, 0.0]]), var * np.array([[1.0, ma], [ma, ma**2]])
    P = Q.copy()
    P[0, 0] = var * (1 + ma**2 + 2 * ar * ma) / (1 - ar**2)
    rows = [(np.array([v]), np.array([0.7498197])) for v in y]
    return kalman(rows, np.zeros(2), P, np.array([[1.0, 0.0]]), np.zeros((1, 1)), linear(A, Q))


def seasonal(head):
    """A and C of `head` coordinates, the first of which is measured, and eleven dummies."""
    n = head + 11
    A, C = np.zeros((n, n)), np.zeros((1, n))
    A[head, head:] = -1.0
    A[np.arange(head + 1, n), np.arange(head, n - 1)] = 1.0
    A[:head, :head] = np.triu(np.ones((head, head)))
    C[0, [0, head]] = 1.0
    return A, C


def co2():
    A, C = seasonal(2)
    Q = np.zeros((13, 13))
    Q[[0, 1, 2], [0, 1, 2]] = np.array([0.22565, 0.0018574, 0.0032958]) ** 2
    m, P = np.zeros(13), np.diag([10.0, 0.1] + [5.0] * 11) ** 2
    m[:2] = 316, 0.1
    rows = [(np.array([v]), 0.0) for v in columns("co2/data.csv")["co2"]]
    return kalman(rows, m, P, C, np.array([[0.15438**2]]), linear(A, Q))


def seatbelts():
    data, (A, C) = columns("seatbelts/data.csv"), seasonal(1)
    Q = np.zeros((12, 12))
    Q[0, 0] = 0.01496**2
    m, P = np.zeros(12), np.diag([1.0] + [0.3] * 11) ** 2
    m[0] = 7
    d = -0.2816 * data["petrol"] - 0.2359 * data["law"]
    rows = [(np.array([v]), np.array([e])) for v, e in zip(data["log_drivers"], d)]
    return kalman(rows, m, P, C, np.array([[0.0639**2]]), linear(A, Q))


def nelson_siegel():
    data = columns("nelson-siegel/data.csv")
    y = np.array([data[f"y[{i}]"] for i in range(8)]).T
    months = np.array([3, 6, 12, 24, 36, 60, 84, 120]) * 0.077
    slope = (1 - np.exp(-months)) / months
    C = np.array([np.ones(8), slope, slope - np.exp(-months)]).T
    R = np.diag([0.27, 0.08, 0.10, 0.07, 0.06, 0.08, 0.10, 0.12]) ** 2
    mean, A = np.array([8.0, -1.4, -0.4]), np.array([[0.99, 0.03, -0.02], [-0.03, 0.94, 0.04], [0.03, 0.02, 0.84]])
    Q = np.array([[0.09, -0.01, 0.04], [-0.01, 0.38, 0.01], [0.04, 0.01, 0.80]])
    return kalman([(row, 0.0) for row in y], mean, 4 * np.eye(3), C, R, linear(A, Q, mean))


def quasar():
    data, mean, tau, spread = columns("quasar/data.csv"), 18.5, 200.0, 0.14
    decay = np.exp(-np.diff(data["day"], prepend=data["day"][0]) / tau)

    def step(k, m, P):
        return mean + decay[k] * (m - mean), decay[k] ** 2 * P + spread**2 * (1 - decay[k] ** 2)

    R = (data["error"] ** 2).reshape(-1, 1, 1)
    rows = [(np.array([v]), 0.0) for v in data["magnitude"]]
    return kalman(rows, np.array([mean]), np.array([[spread**2]]), np.eye(1), R, step)


def federal_funds():
    y = columns("federal-funds/data.csv")["rate"]
    stay, back = 0.9820939, 0.0503587
    transition = np.array([[stay, 1 - stay], [back, 1 - back]])
    start = np.array([back, 1 - stay]) / (1 - stay + back)
    return forward(normal(y[:, None], np.array([3.70877, 9.556793]), 2.107562), start, transition)


def ricker(log_r, sigma, phi):
    """x = log N, on points that are even in x + N, as the map is steep where N is large."""
    even = np.arange(-70.0, 90.0, 0.05)
    N = np.exp(even - np.logaddexp(0, even))
    for _ in range(100):                       # Newton's method for log N + N = even
        N = N * (1 + even - np.log(N)) / (1 + N)
    x, weights = np.log(N), 0.05 / (1 + N)

    def kernel(_, points):
        return normal(x[None, :], (log_r + points - np.exp(points))[:, None], sigma)

    likelihood = lambda y, points: poisson(y, phi * np.exp(points))
    return grid(likelihood, columns("ricker/data.csv")["y"], math.log(7), x, weights, kernel)


def parus():
    x = np.arange(0.0, 8.0, 0.005)
    kernel = lambda _, points: normal(x[None, :], (points + 2.7 * (1 - np.exp(points) / 190))[:, None], 0.2)
    likelihood = lambda y, points: negative_binomial(y, np.exp(points), 20.0)
    return grid(likelihood, columns("parus/data.csv")["pop"], math.log(148), x, 0.005, kernel)


def whiskers(rho, var):
    x = np.arange(-16.0, 6.0, 0.04)
    matrix = normal(x[None, :], rho * x[:, None], math.sqrt(var))
    likelihood = lambda y, points: binomial_logit(y, 50.0, points)
    return grid(likelihood, columns("whiskers/data.csv")["spikes"], normal(x, 0, 1), x, 0.04, lambda *_: matrix)


def fishery(r, K, q, sigma, tau):
    data, x = columns("fishery/data.csv"), np.arange(-4.0, 1.5, 0.005)

    def kernel(k, points):
        P = np.exp(points)
        left = np.maximum(P + r * P * (1 - P) - data["catch"][k - 1] / K, 0.001)
        return normal(x[None, :], np.log(left)[:, None], sigma)

    likelihood = lambda y, points: normal(np.log(y), np.log(q * K) + points, tau) - np.log(y)
    return grid(likelihood, data["cpue"], normal(x, 0, sigma), x, 0.005, kernel)


def leverage(lev, path="../../examples/returns.csv"):
    """The return of a row depends on h before and after the step: a kernel for each row."""
    y, mu, rho, sigma = columns(path)["return"], -0.926, 0.9935, 0.0656
    sd = sigma / math.sqrt(1 - rho**2)
    h = np.linspace(mu - 6 * sd, mu + 6 * sd, 450)
    width = h[1] - h[0]
    shock = (h[None, :] - mu - rho * (h[:, None] - mu)) / sigma
    moves = np.exp(normal(shock, 0, 1)) / sigma * width
    first = np.exp(normal(h, mu, sd)) * width
    mean, spread = lev * np.exp(h / 2)[None, :] * shock, np.exp(h / 2) * math.sqrt(1 - lev**2)
    total, p = 0.0, first
    for v in y:                                # before the first row, h is stationary
        p = (p[:, None] * moves * np.exp(normal(v, mean, spread))).sum(0)
        total += math.log(p.sum())
        p = p / p.sum()
    return total


ALL = [
    ("arma", arma), ("co2", co2), ("seatbelts", seatbelts), ("nelson-siegel", nelson_siegel),
    ("quasar", quasar), ("federal-funds", federal_funds),
    ("ricker", lambda: ricker(3.8, 0.3, 10.0)),
    ("ricker at (3.802, 0.192, 10.20)", lambda: ricker(3.802, 0.192, 10.20)),
    ("parus", parus),
    ("whiskers", lambda: whiskers(0.99, 0.11)),
    ("whiskers at (0.9982, 0.1007)", lambda: whiskers(0.9982, 0.1007)),
    ("fishery", lambda: fishery(0.32, 248.0, 0.258, 0.05, 0.11)),
    ("leverage", lambda: leverage(-0.17)),
]

if __name__ == "__main__":
    for name, value in ALL:
        try:
            print(f"{name:34} {value():12.5f}", flush=True)
        except FileNotFoundError as missing:
            print(f"{name:34} no {Path(missing.filename).relative_to(HERE)}", flush=True)
