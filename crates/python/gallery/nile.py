"""The Nile's flow: a level that wanders, filtered and smoothed, with a gap. `python gallery/nile.py`"""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import motes

HERE = Path(__file__).parent
EXAMPLES = HERE.parents[2] / "examples"

years, flows = np.genfromtxt(EXAMPLES / "nile.csv", delimiter=",", skip_header=1, unpack=True)
# Twenty years are taken out: the filter has to bridge them.
flows[(years >= 1900) & (years < 1920)] = np.nan

model = motes.Model(EXAMPLES / "nile.toml")
data = {"year": years.astype(int), "flow": flows}
filtered = model.filter(data, proposal="optimal", particles=5000)
smoothed = model.smooth(data, proposal="optimal", particles=5000, paths=500)
print(f"log-evidence {filtered.log_evidence:.2f}")

figure, axes = plt.subplots(2, 1, sharex=True, sharey=True, figsize=(8, 5), layout="constrained")
for axis, found, name in zip(axes, (filtered, smoothed), ("filtered", "smoothed"), strict=True):
    axis.plot(years, flows, ".", color="0.4", label="measured")
    axis.fill_between(years, found.quantiles[:, 0, 0], found.quantiles[:, 0, 2], alpha=0.25, linewidth=0)
    axis.plot(years, found.mean[:, 0], label=f"level, {name}")
    axis.set_ylabel("10⁸ m³ a year")
    axis.legend(loc="upper right", frameon=False)
figure.savefig(HERE / "nile.png", dpi=120)
