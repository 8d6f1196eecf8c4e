"""What each family of proposals draws in two steps, from its formulas alone.

tests/tests/parity.rs holds the Rust code against these numbers. Only the formulas, the names of the weights
and the order of their blocks are shared with that code. Samples are rows.

To run it, with Python 3 and numpy, from the root of the repository:

    python tests/parity/families.py

It writes tests/parity/families.json, beside itself.
"""

import json
import pathlib
import platform

import numpy as np

N, M, K, T = 5, 3, 3, 2  # coordinates of a state and of a measurement, particles, times
RIDGE = 1e-3  # of every covariance, and of every matrix that psi inverts

WIDTHS = [N + M, 6, 7, N]  # fcnn
HIDDEN, DEPTH = 5, 2  # rnn
FEATURES, ORDER = [2, 5, 3, 1], 3  # gnn
LAYERS = 4  # psi

# The graph: S, and the adapter A_y, by which measurement j goes to nodes j and, if there is one, M + j.
SHIFT = np.array([
    [0.0, 0.5, 0.0, 0.2, 0.3],
    [0.4, 0.0, 0.4, 0.0, 0.0],
    [0.0, 0.3, 0.0, 0.6, 0.0],
    [0.1, 0.0, 0.5, 0.0, 0.2],
    [0.2, 0.0, 0.0, 0.3, 0.0],
])
ADAPTER = np.array([
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
])


# What goes in, by rules that parity.rs states too.


def weight(name, rows, columns):
    """Entry k, along rows: 0.4 sin(s + 0.7 k + 0.01 k^2), s = sum over the name's bytes b_i of (i + 1) b_i, mod 97."""
    s = sum((i + 1) * byte for i, byte in enumerate(name.encode())) % 97
    k = np.arange(rows * columns)
    return (0.4 * np.sin(s + 0.7 * k + 0.01 * k**2)).reshape(rows, columns)


def epsilon(t):
    return (1.5 * np.sin(2.0 + 1.3 * np.arange(K * N) + 5.0 * t)).reshape(K, N)


def uniform(t):
    return ((0.37 * np.arange(K * N) + 0.11 + 0.29 * t) % 1.0).reshape(K, N)


def measurement(t):
    return np.cos(1.0 + np.arange(M) + 2.0 * t)


# What the Gaussian families share.


def draw_gaussian(means, representations, noise):
    """x = mu + L eps, L L' = Sigma = C K(z) C' + ridge I, K(z)_ij = exp(-(z_i - z_j)^2), and log q there."""
    c = weight("covariance.mixing", N, N)
    states, log_q = np.zeros((K, N)), np.zeros(K)
    for k, (mean, z) in enumerate(zip(means, representations)):
        kernel = np.exp(-np.square(z[:, None] - z[None, :]))
        sigma = c @ kernel @ c.T + RIDGE * np.eye(N)
        states[k] = mean + np.linalg.cholesky(sigma) @ noise[k]
        # log N(x; mu, Sigma), without the factor and without the noise.
        away = states[k] - mean
        log_det = np.linalg.slogdet(2.0 * np.pi * sigma).logabsdet
        log_q[k] = -0.5 * (away @ np.linalg.solve(sigma, away) + log_det)
    return states, log_q


def stacked(previous, y):
    """[x_{t-1}; y_t] of each particle."""
    return np.hstack([previous, np.tile(y, (K, 1))])


def affine(name, inputs, outputs):
    return inputs @ weight(f"{name}.weight", inputs.shape[1], outputs) + weight(f"{name}.bias", 1, outputs)


# fcnn: mu_t = NN_t(x_{t-1}, y_t) and z_t = NN(x_{t-1}, y_t), tanh after each layer but the last.


def fully_connected(name, values):
    for layer, width in enumerate(WIDTHS[1:]):
        values = affine(f"{name}.{layer}", np.tanh(values) if layer > 0 else values, width)
    return values


def fcnn(t, previous, y, carried):
    inputs = stacked(previous, y)
    return fully_connected(f"mean.{t}", inputs), fully_connected("covariance", inputs), carried


# rnn: mu_t and z_t are affine in the last layer's h_t, and a layer's input is the output of the one below it.


def sigmoid(a):
    return 1.0 / (1.0 + np.exp(-a))


def products(name, u, h, blocks):
    """u W + b and h U, each in blocks of HIDDEN columns."""
    columns = blocks * HIDDEN
    of_input = u @ weight(f"{name}.input", u.shape[1], columns) + weight(f"{name}.bias", 1, columns)
    of_hidden = h @ weight(f"{name}.hidden", HIDDEN, columns)
    return np.hsplit(of_input, blocks), np.hsplit(of_hidden, blocks)


def elman(name, u, h, c):
    (a,), (b,) = products(name, u, h, 1)
    return np.tanh(a + b), c


def gru(name, u, h, c):
    (ar, a_s, av), (br, bs, bx) = products(name, u, h, 3)
    r, s = sigmoid(ar + br), sigmoid(a_s + bs)
    candidate = np.tanh(av + r * (bx + weight(f"{name}.candidate_bias", 1, HIDDEN)))
    return (1.0 - s) * candidate + s * h, c


def lstm(name, u, h, c):
    i, f, g, o = (a + b for a, b in zip(*products(name, u, h, 4)))
    c = sigmoid(f) * c + sigmoid(i) * np.tanh(g)
    return sigmoid(o) * np.tanh(c), c


def rnn(cell):
    def emit(_t, previous, y, carried):
        values = stacked(previous, y)
        carried = carried or [(np.zeros((K, HIDDEN)), np.zeros((K, HIDDEN)))] * DEPTH
        after = []
        for layer, (h, c) in enumerate(carried):
            after.append(cell(f"recurrent.{layer}", values, h, c))
            values = after[-1][0]
        return affine("mean.0", values, N), affine("covariance.0", values, N), after

    return emit


# gnn: Z' = tanh(sum_d S^d Z W_d + 1 b') from two features of each node, x_{t-1} and A_y y_t; no tanh after
# the last layer.


def graph_network(name, previous, at_nodes):
    outputs = np.zeros((K, N))
    for k in range(K):
        z = np.column_stack([previous[k], at_nodes])
        for layer, (before, after) in enumerate(zip(FEATURES, FEATURES[1:])):
            # W_0 ... W_D on top of each other.
            taps = np.vsplit(weight(f"{name}.{layer}.taps", (ORDER + 1) * before, after), ORDER + 1)
            z = np.tanh(z) if layer > 0 else z
            z = sum(np.linalg.matrix_power(SHIFT, d) @ z @ tap for d, tap in enumerate(taps))
            z = z + weight(f"{name}.{layer}.bias", 1, after)
        outputs[k] = z[:, 0]
    return outputs


def gnn(learned):
    def emit(t, previous, y, carried):
        of_mean, of_covariance = ADAPTER, ADAPTER
        if learned:
            of_mean, of_covariance = weight("mean.adapter", N, M), weight("covariance.adapter", N, M)
        means = graph_network(f"mean.{t}", previous, of_mean @ y)
        return means, graph_network("covariance", previous, of_covariance @ y), carried

    return emit


# psi: x_t = NN_t(tanh(A u + B x_{t-1} + C y_t)) and log q = -(sum of log|det| + sum of log tanh'(a)).


def psi(t, previous, y, u):
    def square(name):
        return weight(name, N, N) + RIDGE * np.eye(N)

    matrix = square(f"psi.{t}.noise")
    values = u @ matrix + previous @ weight(f"psi.{t}.previous", N, N)
    values = values + y @ weight(f"psi.{t}.measurement", M, N)
    log_q = np.full(K, -np.linalg.slogdet(matrix).logabsdet)
    for layer in range(LAYERS):
        # tanh' = 1 / cosh^2.
        log_q += 2.0 * np.log(np.cosh(values)).sum(axis=1)
        matrix = square(f"psi.{t}.{layer}.weight")
        values = np.tanh(values) @ matrix + weight(f"psi.{t}.{layer}.bias", 1, N)
        log_q -= np.linalg.slogdet(matrix).logabsdet
    return values, log_q


def steps(emit):
    """States and log q at t = 0 and at t = 1, where the previous states are those drawn at t = 0."""
    states, carried, found = np.zeros((K, N)), None, []
    for t in range(T):
        y = measurement(t)
        if emit is psi:
            states, log_q = psi(t, states, y, uniform(t))
        else:
            means, representations, carried = emit(t, states, y, carried)
            states, log_q = draw_gaussian(means, representations, epsilon(t))
        found.append({"states": states.tolist(), "log_q": log_q.tolist()})
    return found


FAMILIES = {
    "fcnn": fcnn,
    "psi": psi,
    "rnn Lstm": rnn(lstm),
    "rnn Gru": rnn(gru),
    "rnn Elman": rnn(elman),
    "gnn Fixed": gnn(learned=False),
    "gnn Learned": gnn(learned=True),
}


def main():
    made_by = f"tests/parity/families.py, Python {platform.python_version()}, numpy {np.__version__}"
    # A step a line.
    families = [
        f"{json.dumps(name)}: [\n" + ",\n".join(json.dumps(step) for step in steps(emit)) + "\n]"
        for name, emit in FAMILIES.items()
    ]
    head = f'"made_by": {json.dumps(made_by)},\n"adjacency": {json.dumps(SHIFT.tolist())},\n"families": '
    path = pathlib.Path(__file__).with_suffix(".json")
    path.write_text("{\n" + head + "{\n" + ",\n".join(families) + "\n}\n}\n", encoding="utf-8")
    print(f"wrote {path}; to make it again: python tests/parity/families.py (Python 3 with numpy)")


if __name__ == "__main__":
    main()
