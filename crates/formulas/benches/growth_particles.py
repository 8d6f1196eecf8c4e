"""The growth model's bootstrap filter by `particles`: prints millions of particles a second, and the log-evidence."""

import sys
import time

import numpy as np
import particles
from particles import distributions as dists
from particles import state_space_models as ssm


class Growth(ssm.StateSpaceModel):
    def PX0(self):
        return dists.Normal(scale=np.sqrt(5))

    def PX(self, t, xp):
        return dists.Normal(loc=xp / 2 + 25 * xp / (1 + xp**2) + 8 * np.cos(1.2 * t), scale=np.sqrt(10))

    def PY(self, t, xp, x):
        return dists.Normal(loc=x**2 / 20, scale=1.0)


count = int(sys.argv[1])
data = [np.array([float(value)]) for value in sys.argv[2].split(",")]
np.random.seed(1)
fk = ssm.Bootstrap(ssm=Growth(), data=data)
# The first run compiles what the library compiles.
particles.SMC(fk=fk, N=count, resampling="systematic", ESSrmin=0.5).run()
filter_ = particles.SMC(fk=fk, N=count, resampling="systematic", ESSrmin=0.5)
start = time.perf_counter()
filter_.run()
seconds = time.perf_counter() - start
print(count * len(data) / seconds / 1e6, filter_.logLt)
