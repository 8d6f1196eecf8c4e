"""Influenza in a boarding school, 1978: counts, and what comes next. `python gallery/influenza.py`"""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import motes

HERE = Path(__file__).parent
EXAMPLES = HERE.parents[2] / "examples"

model = motes.Model(EXAMPLES / "influenza.toml")
print(model)
filtered = model.filter(EXAMPLES / "influenza.csv", proposal="linearised", particles=5000)
# What was known on day 6, and 8 days ahead.
known = filtered.measurements[:7]
forecast = model.forecast(known, 8, proposal="linearised", particles=5000)
print(f"log-evidence {filtered.log_evidence:.2f}")

figure, axis = plt.subplots(figsize=(8, 4), layout="constrained")
ahead = np.arange(len(known), len(known) + 8)
infectious = model.states.index("log_i")
# Quantiles of the logarithm are those of the number, by exp.
low, middle, high = np.exp(filtered.quantiles[:, infectious]).T
axis.fill_between(filtered.time, low, high, alpha=0.25, linewidth=0)
axis.plot(filtered.time, middle, label="infectious, filtered")
low, middle, high = np.exp(forecast.quantiles[0, :, infectious]).T
axis.fill_between(ahead, low, high, alpha=0.2, linewidth=0, color="C1")
axis.plot(ahead, middle, color="C1", label="forecast on day 6")
axis.plot(filtered.time, filtered.measurements[:, 0], "o", color="0.3", label="in bed")
axis.set(xlabel="day", ylabel="boys", ylim=(0, 763))
axis.legend(frameon=False)
figure.savefig(HERE / "influenza.png", dpi=120)
