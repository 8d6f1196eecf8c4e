"""Two hundred series in several processes, by joblib and by Dask, one of whose workers is killed: the bytes of one process.

`pip install joblib "dask[distributed]"`, then `python gallery/many_series.py`, or with another number of series.
"""

import os
import signal
import sys

import joblib
from dask.distributed import Client, LocalCluster, as_completed

import motes

# Log-volatility of daily returns, and the returns.
MODEL = motes.Model(
    {
        "initial": {"v": "normal(0, 0.7)"},
        "transition": {"v": "normal(0.97*v, 0.17)"},
        "measurement": {"r": "normal(0, exp(v/2))"},
    }
)


def filtered(returns, number):
    """The filter of one series: its seed is its number, so that it is the same wherever it runs."""
    return MODEL.filter(returns, particles=1000, seed=number, threads=1)


def main(count):
    returns = list(MODEL.simulate(500, series=count, seed=1).measurements)
    numbers = range(count)

    # In this process, one after the other.
    here = [filtered(*each) for each in zip(returns, numbers, strict=True)]
    print(f"log-evidence of {count} series: {sum(found.log_evidence for found in here):.2f}")

    # Over two processes of joblib: each result comes back as a pickle.
    by_joblib = joblib.Parallel(n_jobs=2)(joblib.delayed(filtered)(*each) for each in zip(returns, numbers, strict=True))

    # Over two workers of Dask. One is killed while it works: Dask starts another, and does again what was lost.
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        futures = client.map(filtered, returns, numbers)
        next(as_completed(futures))
        victim, *_ = client.run(os.getpid).values()
        done = sum(future.done() for future in futures)
        os.kill(victim, signal.SIGKILL)
        print(f"killed one of two workers with {done} of {count} series done")
        by_dask = client.gather(futures)

    # Whatever ran where, and whatever was done twice.
    tables = [found.to_csv() for found in here]
    assert [found.to_csv() for found in by_joblib] == tables
    assert [found.to_csv() for found in by_dask] == tables
    print("the same bytes from one process, joblib and Dask")


# Each worker imports this file.
if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 200)
