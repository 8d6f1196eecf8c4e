"""Range and bearing: a proposal that is learned once, in seconds, beside the designed ones. `python gallery/tracking.py`"""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

import motes

HERE = Path(__file__).parent
EXAMPLES = HERE.parents[2] / "examples"

model = motes.Model(EXAMPLES / "tracking.toml")
learned = model.learn(seed=1)
print(learned)

drawn = model.simulate(100, seed=7)
found = {
    name: model.filter(drawn.measurements[0], proposal=proposal, particles=300)
    for name, proposal in (("bootstrap", "bootstrap"), ("learned once", learned.proposal))
}
figure, (path, sizes) = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
path.plot(*drawn.states[0, :, [0, 1]], color="black", linewidth=2, label="true path")
for name, filtered in found.items():
    path.plot(filtered.mean[:, 0], filtered.mean[:, 1], label=name)
    sizes.plot(filtered.ess, label=name)
path.set(xlabel=model.states[0], ylabel=model.states[1])
sizes.set(xlabel="t", ylabel="effective particles of 300", ylim=(0, 300))
path.legend(frameon=False)
figure.savefig(HERE / "tracking.png", dpi=120)
