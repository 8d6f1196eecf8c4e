"""Effective draws a second of the pound's stochastic volatility, by Motes and by PMMH of particles, in turns on one thread.

    python beside_particles.py MOTES [ROUNDS]

MOTES is the command; this Python needs particles 0.4. Model, data and priors are those of examples/fit/pound.toml. Seconds are those of whole runs: of Motes with its search for starts, its
choice of particles and its warm-up, of particles with the first tenth of its draws, which is left out as its burn-in. The numbers of particles of the latter are tried before, and the best one counts.
"""

import csv
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import particles.distributions as dists
from particles import mcmc
from particles import state_space_models as ssms

FIT = Path(__file__).parents[2] / "examples" / "fit"
NAMES = ["mu", "phi", "sigma"]
TRIED = [100, 200, 400]


def effective(chains):
    """The effective sample size of draws, `(chains, draws)`: by autocorrelations up to the first pair of them whose sum is negative (Geyer, 1992)."""
    chains = np.asarray(chains)
    m, n = chains.shape
    centred = chains - chains.mean(axis=1, keepdims=True)
    size = 2 ** int(np.ceil(np.log2(2 * n)))
    spectrum = np.fft.rfft(centred, size, axis=1)
    autocovariance = np.fft.irfft(spectrum * spectrum.conj(), size, axis=1)[:, :n].mean(axis=0) / n
    within = autocovariance[0] * n / (n - 1)
    between = chains.mean(axis=1).var(ddof=1) if m > 1 else 0.0
    total = within * (n - 1) / n + between
    rho = 1 - (within - autocovariance * n / (n - 1)) / total
    pairs = rho[0 : n - 1 : 2] + rho[1:n:2]
    negative = np.flatnonzero(pairs < 0)
    last = negative[0] if len(negative) else len(pairs)
    pairs = np.minimum.accumulate(pairs[:last])
    return m * n / max(2 * pairs.sum() - 1, 1.0)


def of_motes(motes, seed, *options):
    with tempfile.TemporaryDirectory() as folder:
        command = [motes, "fit", FIT / "pound.toml", FIT / "pound.csv", "-o", folder, "--seed", str(seed), "--threads", "1", "--quiet", *options]
        start = time.perf_counter()
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        seconds = time.perf_counter() - start
        with open(Path(folder) / "draws.csv") as file:
            rows = list(csv.DictReader(file))
        summary = json.loads((Path(folder) / "summary.json").read_text())
    chains = sorted({row["chain"] for row in rows})
    sizes = [effective([[float(row[name]) for row in rows if row["chain"] == chain] for chain in chains]) for name in NAMES]
    return min(sizes), seconds, summary["particles"]


def of_particles(data, seed, k, draws):
    np.random.seed(seed)
    priors = {"mu": dists.Normal(-1.0, 1.0), "rho": dists.Uniform(-1.0, 1.0), "sigma": dists.TruncNormal(0.0, 1.0, a=0.0, b=np.inf)}
    # The adaptive walk begins at a posterior mean that a fit has found, which it is not charged for.
    start = dists.StructDist(priors).rvs(size=1)
    start["mu"], start["rho"], start["sigma"] = -1.7, 0.2, 0.6
    chain = mcmc.PMMH(ssm_cls=ssms.StochVol, prior=dists.StructDist(priors), data=data, Nx=k, niter=draws, theta0=start, adaptive=True)
    begin = time.perf_counter()
    chain.run()
    seconds = time.perf_counter() - begin
    kept = chain.chain.theta[draws // 10 :]
    return min(effective([kept[name]]) for name in ["mu", "rho", "sigma"]), seconds


def main():
    motes, rounds = Path(sys.argv[1]).resolve(), int(sys.argv[2]) if len(sys.argv) > 2 else 3
    with open(FIT / "pound.csv") as file:
        data = np.array([float(row["return"]) for row in csv.DictReader(file)])
    tried = {}
    for k in TRIED:
        size, seconds = of_particles(data, 1, k, 1000)
        tried[k] = size / seconds
        print(f"particles, K = {k}: {size:.0f} of 900 draws effective in {seconds:.1f} s: {tried[k]:.2f} a second", flush=True)
    best = max(tried, key=tried.get)
    rates = {"motes": [], "motes, bootstrap": [], "particles": []}
    for seed in range(1, rounds + 1):
        for name, options in [("motes", []), ("motes, bootstrap", ["--proposal", "bootstrap"])]:
            size, seconds, k = of_motes(motes, seed, *options)
            rates[name].append(size / seconds)
            print(f"{name}, K = {k}: {size:.0f} in {seconds:.1f} s: {size / seconds:.2f} a second", flush=True)
        size, seconds = of_particles(data, 10 + seed, best, 3000)
        rates["particles"].append(size / seconds)
        print(f"particles, K = {best}: {size:.0f} in {seconds:.1f} s: {size / seconds:.2f} a second", flush=True)
    base = np.median(rates["particles"])
    for name, found in rates.items():
        print(f"{name}: {np.median(found):.2f} a second ({min(found):.2f} to {max(found):.2f}), {np.median(found) / base:.1f} times particles")


main()
