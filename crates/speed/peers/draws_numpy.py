"""Draws of numpy's Generator, for all particles in a call; `draws.rs` has the same parameters, and as many."""

import numpy as np

# Particles with parameters of their own, as many as stay in a cache.
DISTINCT = 16 * 1024


class Drawing:
    """Draws of one distribution."""

    def __init__(self, task):
        generator, particles = np.random.default_rng(1), np.arange(DISTINCT, dtype=np.float64)
        u, v = (np.modf(step * particles)[0] for step in (0.6180339887498949, 0.7548776662466927))
        size = task["size"] * (0.8 + 0.4 * u)
        self.calls = task["draws"] // DISTINCT
        if task["distribution"] == "binomial":
            p = 0.01 + 0.02 * v
            n = np.round(size / p).astype(np.int64)
            self.call = lambda: generator.binomial(n, p)
        elif task["distribution"] == "poisson":
            self.call = lambda: generator.poisson(size)
        else:
            scale = 0.5 + v
            self.call = lambda: generator.gamma(size, scale)
        self.draw()

    def draw(self):
        for _ in range(self.calls):
            self.call()

    def check(self):
        drawn = np.concatenate([self.call() for _ in range(self.calls)])
        return {"mean_draw": float(drawn.mean()), "mean_draw_error": float(drawn.std() / np.sqrt(len(drawn)))}
