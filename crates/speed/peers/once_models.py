"""The models of proposals that are learned once: growth and tracking, their states as rows of coordinates, a column each particle."""

import math

import jax.numpy as jnp


class Growth:
    """x' = x/2 + 25 x/(1 + x^2) + 8 cos 1.2 t + noise, seen as x^2/20."""

    centres_of_first, slopes_of_first = (0.0,), (math.sqrt(5.0),)
    slopes = (math.sqrt(10.0),)
    scales = (1.0,)
    # How many coordinates, the first ones, the measurement depends on.
    seen = 1
    linearised, components = False, 5

    def centres(self, t, x):
        """The median of each coordinate of the next state."""
        return [x[0] / 2.0 + x[0] * 25.0 / (x[0] * x[0] + 1.0) + 8.0 * jnp.cos(1.2 * t)]

    def locations(self, x):
        """The location of each entry of the measurement."""
        return [x[0] * x[0] / 20.0]

    def jacobian(self, x):
        """Their derivatives by the coordinates that are seen."""
        return [[x[0] / 10.0]]


class Tracking:
    """A target in the plane with a velocity, seen by distance and direction."""

    centres_of_first, slopes_of_first = (5.0, 5.0, 0.2, -0.1), (1.0, 1.0, 0.1, 0.1)
    slopes = (0.05,) * 4
    scales = (0.1, 0.02)
    seen = 2
    linearised, components = True, None

    def centres(self, t, x):
        return [x[0] + x[2], x[1] + x[3], x[2], x[3]]

    def locations(self, x):
        return [jnp.sqrt(x[0] * x[0] + x[1] * x[1]), jnp.arctan2(x[1], x[0])]

    def jacobian(self, x):
        square = x[0] * x[0] + x[1] * x[1]
        distance = jnp.sqrt(square)
        return [[x[0] / distance, x[1] / distance], [-x[1] / square, x[0] / square]]


MODELS = {"growth": Growth, "tracking": Tracking}


def log_likelihood(model, y, x):
    """log p(y | x)."""
    residuals = [(y[j] - found) / model.scales[j] for j, found in enumerate(model.locations(x))]
    constant = sum(math.log(scale) + 0.5 * math.log(2.0 * math.pi) for scale in model.scales)
    return -0.5 * sum(residual * residual for residual in residuals) - constant
