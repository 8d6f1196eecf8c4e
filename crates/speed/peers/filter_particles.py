"""Particle filters of the library particles: its own SMC class, with a vectorised normal distribution for each law."""

import numpy as np
import particles
from particles import distributions, state_space_models

from problem import LOG_TAU

GENERATOR = np.random.Generator(np.random.SFC64())


class ScaledNormal(distributions.ProbDist):
    """N(loc, scale^2 I), with a mean for each particle or one for all."""

    def __init__(self, loc, scale):
        self.loc, self.scale, self.dim = loc, scale, loc.shape[-1]

    def rvs(self, size=None):
        draws = GENERATOR.standard_normal((size, self.dim))
        draws *= self.scale
        draws += self.loc
        return draws

    def logpdf(self, x):
        away = x - self.loc
        squares = np.einsum("ki,ki->k", away, away)
        squares *= -0.5 / self.scale**2
        squares -= self.dim * (np.log(self.scale) + 0.5 * LOG_TAU)
        return squares


class CorrelatedNormal(distributions.ProbDist):
    """N(loc, L L') of a Correction, with a mean for each particle or one for all."""

    def __init__(self, loc, correction):
        self.loc, self.correction, self.dim = loc, correction, loc.shape[-1]

    def rvs(self, size=None):
        draws = GENERATOR.standard_normal((size, self.dim)) @ self.correction.lower.T
        draws += self.loc
        return draws

    def logpdf(self, x):
        whitened = (x - self.loc) @ self.correction.inverse_lower.T
        squares = np.einsum("ki,ki->k", whitened, whitened)
        squares *= -0.5
        squares += self.correction.log_normalizer
        return squares


class LinearGaussian(state_space_models.StateSpaceModel):
    """The problem in the library's terms."""

    def __init__(self, problem):
        super().__init__(problem=problem, first=problem.first(), later=problem.later())

    def PX0(self):
        return ScaledNormal(np.ones(self.problem.n), 1.0)

    def PX(self, t, xp):
        return ScaledNormal(xp @ self.problem.a.T, self.problem.sigma)

    def PY(self, t, xp, x):
        return ScaledNormal(x @ self.problem.c.T, self.problem.sigma)

    def proposal0(self, data):
        return CorrelatedNormal(self.first.offset(data[0]), self.first)

    def proposal(self, t, xp, data):
        mean = xp @ self.later.step.T
        mean += self.later.offset(data[t])
        return CorrelatedNormal(mean, self.later)


class ClosedFormGuidedPF(state_space_models.GuidedPF):
    """GuidedPF with the weights p(y_t | x_{t-1}) that the three densities come to under this proposal."""

    def logG(self, t, xp, x):
        correction = self.ssm.first if t == 0 else self.ssm.later
        centre = correction.whiten @ self.data[t] - correction.whitened_shift
        if t == 0:
            whitened = np.broadcast_to(centre, (x.shape[0], centre.size))
        else:
            whitened = centre - xp @ correction.whitened_step.T
        squares = np.einsum("ki,ki->k", whitened, whitened)
        squares *= -0.5
        squares += correction.log_normalizer_of_y
        return squares


FORMALISMS = {
    ("bootstrap", "densities"): state_space_models.Bootstrap,
    ("bootstrap", "closed-form"): state_space_models.Bootstrap,
    ("min-degeneracy", "densities"): state_space_models.GuidedPF,
    ("min-degeneracy", "closed-form"): ClosedFormGuidedPF,
}


def build(problem, task):
    """A function that makes one pass of each filter and returns their log evidence."""
    global GENERATOR
    GENERATOR = np.random.Generator(np.random.SFC64(task["seed"]))
    np.random.seed(task["seed"])  # the library's resampling draws from here
    formalism = FORMALISMS[task["method"], task.get("weights", "closed-form")]
    model, data = LinearGaussian(problem), list(problem.measurements)

    def once():
        smc = particles.SMC(
            fk=formalism(ssm=model, data=data),
            N=task["particles"],
            resampling=task["resampling"],
            ESSrmin=1.0 / 3.0,
            collect="off",
        )
        smc.run()
        return smc.logLt

    return lambda: np.array([once() for _ in range(task["filters"])])
