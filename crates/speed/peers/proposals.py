"""The learned proposals in PyTorch: how each family draws x_t from x_{t-1}, y_t and noise, all particles at once."""

import torch

RIDGE, RIDGE_OF_PSI = 1e-6, 1e-3
TAPS = 4  # of graph filters of order 3

# Of the covariances, which are small and nearly singular; the networks compute in 32 bits.
WIDE = torch.float64


def fully_connected(affine, weights, name, layers, values):
    """Affine maps with tanh between them, samples as rows."""
    for layer in range(layers):
        if layer > 0:
            values = torch.tanh(values)
        values = affine(weights[f"{name}.{layer}.bias"], values, weights[f"{name}.{layer}.weight"])
    return values


class Gaussian:
    """x_t = mu + L eps with L L' = C K(z) C' + ridge I; a family says how mu and z come about."""

    def __init__(self, weights, problem, particles, affine):
        self.weights, self.particles, self.affine = weights, particles, affine
        self.measurements = problem["measurements"]
        self.n = problem["A"].shape[0]
        self.ridge = RIDGE * torch.eye(self.n, dtype=WIDE)
        self.start = torch.zeros(particles, self.n)

    def draw_all(self, noise):
        """The states of all times, in the precision of the covariance."""
        mixing = self.weights["covariance.mixing"].to(WIDE)
        noise = noise.to(WIDE).unsqueeze(-1)
        previous, carried, states = self.start, None, []
        for t in range(self.measurements.shape[0]):
            means, representations, carried = self.emit(t, previous, carried)
            z = representations.to(WIDE)
            kernel = torch.exp(-torch.square(z.unsqueeze(2) - z.unsqueeze(1)))
            covariance = mixing @ kernel @ mixing.T + self.ridge
            lower = torch.linalg.cholesky_ex(covariance).L
            state = torch.baddbmm(means.to(WIDE).unsqueeze(-1), lower, noise[t]).squeeze(-1)
            states.append(state)
            previous = state.to(torch.float32)
        return torch.stack(states)


class Fcnn(Gaussian):
    """A mean network for each time and one for the covariance, both of [x_{t-1}; y_t]."""

    def __init__(self, weights, problem, particles, affine):
        super().__init__(weights, problem, particles, affine)
        self.layers = sum(name.startswith("covariance.") and name.endswith(".weight") for name in weights)
        self.rows = self.measurements.unsqueeze(1).expand(-1, particles, -1)

    def emit(self, t, previous, carried):
        inputs = torch.cat([previous, self.rows[t]], 1)
        means = fully_connected(self.affine, self.weights, f"mean.{t}", self.layers, inputs)
        return means, fully_connected(self.affine, self.weights, "covariance", self.layers, inputs), None


class Rnn(Gaussian):
    """One LSTM cell with all gates in one product; mean and z are affine in its hidden state."""

    def __init__(self, weights, problem, particles, affine):
        super().__init__(weights, problem, particles, affine)
        self.rows = self.measurements.unsqueeze(1).expand(-1, particles, -1)
        self.no_bias = torch.zeros(1, weights["recurrent.0.hidden"].shape[1])

    def emit(self, t, previous, carried):
        weights = self.weights
        inputs = torch.cat([previous, self.rows[t]], 1)
        gates = self.affine(weights["recurrent.0.bias"], inputs, weights["recurrent.0.input"])
        if carried is None:
            take, _, new, give = gates.chunk(4, 1)
            c = torch.sigmoid(take) * torch.tanh(new)
        else:
            h, c = carried
            gates = gates + self.affine(self.no_bias, h, weights["recurrent.0.hidden"])
            take, keep, new, give = gates.chunk(4, 1)
            c = torch.sigmoid(keep) * c + torch.sigmoid(take) * torch.tanh(new)
        h = torch.sigmoid(give) * torch.tanh(c)
        means, representations = (
            fully_connected(self.affine, weights, name, 1, h) for name in ("mean", "covariance")
        )
        return means, representations, (h, c)


class Gnn(Gaussian):
    """Graph filters with tanh between them; rows are node by node, so that all particles are one product."""

    def __init__(self, weights, problem, particles, affine):
        super().__init__(weights, problem, particles, affine)
        self.layers = sum(name.startswith("covariance.") and name.endswith(".taps") for name in weights)
        self.shift = problem["shift"]
        at_nodes = self.measurements @ problem["adapter"].T
        self.at_nodes = at_nodes.unsqueeze(2).expand(-1, -1, particles).reshape(len(at_nodes), -1, 1)

    def emit(self, t, previous, carried):
        inputs = self.taps_of(torch.cat([previous.T.reshape(-1, 1), self.at_nodes[t]], 1))
        means, representations = self.network(f"mean.{t}", inputs), self.network("covariance", inputs)
        return means, representations, None

    def moved(self, rows):
        """S X of each particle."""
        return (self.shift @ rows.view(self.n, -1)).view(rows.shape)

    def taps_of(self, rows):
        """[X, S X, S^2 X, S^3 X]."""
        taps = [rows]
        while len(taps) < TAPS:
            taps.append(self.moved(taps[-1]))
        return torch.cat(taps, 1)

    def network(self, name, inputs):
        """Takes the taps of its first layer's input, which two networks share."""
        values = None
        for layer in range(self.layers):
            taps, bias = self.weights[f"{name}.{layer}.taps"], self.weights[f"{name}.{layer}.bias"]
            fan_in, fan_out = taps.shape[0] // TAPS, taps.shape[1]
            if layer == 0 or fan_in <= fan_out:
                inputs = inputs if layer == 0 else self.taps_of(values)
                values = self.affine(bias, inputs, taps)
            else:
                # X W_0 + S (X W_1 + S (X W_2 + ...)), from the inside.
                beside = taps.view(TAPS, fan_in, fan_out).permute(1, 0, 2).reshape(fan_in, -1)
                products = (values @ beside).split(fan_out, 1)
                values = products[-1]
                for product in reversed(products[:-1]):
                    values = product + self.moved(values.contiguous())
                values = values + bias
            if layer + 1 < self.layers:
                values = torch.tanh(values)
        return values.view(self.n, self.particles).T


class Psi:
    """x_t = NN_t(tanh(u A + x_{t-1} B + y_t C)), square layers, a transform for each time."""

    def __init__(self, weights, problem, _particles, _affine):
        self.weights, self.measurements = weights, problem["measurements"]
        self.horizon, self.n = self.measurements.shape[0], problem["A"].shape[0]
        self.layers = weights["layers.weight"].shape[1]
        self.ridge = RIDGE_OF_PSI * torch.eye(self.n)

    def draw_all(self, noise):
        weights = self.weights
        # All that does not depend on earlier states, for all times at once.
        known = self.measurements.unsqueeze(1) @ weights["measurement"]
        known = torch.baddbmm(known, noise, weights["noise"] + self.ridge).unbind(0)
        previous = weights["previous"].unbind(0)
        layers = (weights["layers.weight"] + self.ridge).flatten(0, 1).unbind(0)
        biases = weights["layers.bias"].flatten(0, 1).unbind(0)
        states = []
        for t in range(self.horizon):
            values = torch.addmm(known[t], states[-1], previous[t]) if t > 0 else known[t]
            for layer in range(t * self.layers, (t + 1) * self.layers):
                values = torch.addmm(biases[layer], torch.tanh(values), layers[layer])
            states.append(values)
        return torch.stack(states)


def stacked_weights_of_psi(weights):
    """The many small matrices of psi, those of one kind in one tensor."""
    horizon = sum(name.endswith(".noise") for name in weights)
    layers = sum(name.startswith("psi.0.") and name.endswith(".weight") for name in weights)
    kinds = {
        kind: torch.stack([weights[f"psi.{t}.{kind}"] for t in range(horizon)])
        for kind in ("noise", "previous", "measurement")
    }
    for kind in ("weight", "bias"):
        flat = [weights[f"psi.{t}.{layer}.{kind}"] for t in range(horizon) for layer in range(layers)]
        kinds[f"layers.{kind}"] = torch.stack(flat).unflatten(0, (horizon, layers))
    return kinds


FAMILIES = {"fcnn": Fcnn, "rnn": Rnn, "gnn": Gnn, "psi": Psi}
