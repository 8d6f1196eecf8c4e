"""Draws of numpy's Generator, one call for all particles; `draws.rs` has the same parameters."""

import numpy as np


class Drawing:
    """Draws of one distribution."""

    def __init__(self, task):
        generator, particles = np.random.default_rng(1), np.arange(task["draws"], dtype=np.float64)
        u, v = (np.modf(step * particles)[0] for step in (0.6180339887498949, 0.7548776662466927))
        size = task["size"] * (0.8 + 0.4 * u)
        if task["distribution"] == "binomial":
            p = 0.01 + 0.02 * v
            n = np.round(size / p).astype(np.int64)
            self.draw = lambda: generator.binomial(n, p)
        elif task["distribution"] == "poisson":
            self.draw = lambda: generator.poisson(size)
        else:
            self.draw = lambda: generator.standard_gamma(size)
        self.draw()

    def check(self):
        drawn = self.draw()
        return {"mean_draw": float(drawn.mean()), "mean_draw_error": float(drawn.std() / np.sqrt(len(drawn)))}
