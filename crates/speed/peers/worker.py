"""Prepares, checks and times one peer: a JSON request per line on standard input, an answer per line on standard output."""

import argparse
import importlib
import importlib.metadata
import json
import math
import os
import platform
import signal
import sys
import time


def limit_threads(threads):
    """Must come before numpy, jax and torch are imported."""
    for name in ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "NUMBA", "VECLIB_MAXIMUM"):
        os.environ[f"{name}_NUM_THREADS"] = str(threads)
    os.environ["PJRT_NPROC"] = os.environ["NPROC"] = str(threads)
    os.environ["JAX_PLATFORMS"] = "cpu"
    os.environ["CUDA_VISIBLE_DEVICES"] = ""
    if threads == 1:
        flags = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
        os.environ["XLA_FLAGS"] = f"{os.environ.get('XLA_FLAGS', '')} {flags}".strip()


class FilterTask:
    """Passes of particle filters along the measurements."""

    def __init__(self, task):
        self.task, self.passes = task, self.build(task)
        for _ in range(2):
            self.passes()

    def build(self, task):
        from problem import Problem

        return importlib.import_module(f"filter_{task['peer']}").build(Problem(task["problem"]), task)

    def check(self):
        passes = self.task.get("check_passes", 20)
        found = [float(value) for _ in range(passes) for value in self.passes()]
        mean = sum(found) / len(found)
        variance = sum((value - mean) ** 2 for value in found) / max(len(found) - 1, 1)
        return {"mean_log_evidence": mean, "log_evidence_error": math.sqrt(variance / len(found)), "passes": len(found)}

    def run(self):
        start, start_cpu = time.perf_counter(), time.process_time()
        found = self.passes()
        seconds, cpu_seconds = time.perf_counter() - start, time.process_time() - start_cpu
        return {"seconds": seconds, "cpu_seconds": cpu_seconds, "log_evidence": found[:4].tolist()}


class DrawsTask:
    """Draws of a distribution."""

    def __init__(self, task):
        self.drawing = importlib.import_module(f"draws_{task['peer']}").Drawing(task)

    def check(self):
        return self.drawing.check()

    def run(self):
        start, start_cpu = time.perf_counter(), time.process_time()
        self.drawing.draw()
        return {"seconds": time.perf_counter() - start, "cpu_seconds": time.process_time() - start_cpu}


class LearnedTask(FilterTask):
    """Passes of a filter with a proposal that is learned once."""

    def build(self, task):
        set_bits(task["bits"])
        passes, self.loss = importlib.import_module(f"filter_{task['peer']}").build(task)
        return passes

    def check(self):
        return super().check() | {"loss": self.loss()}


class LearnTask:
    """Gradient steps of a proposal that is learned once."""

    def __init__(self, task):
        set_bits(task["bits"])
        from learn_jax import Learning

        self.steps, self.learning = task["steps"], Learning(task)
        for _ in range(2):
            self.learning.run()

    def check(self):
        return self.learning.at_first

    def run(self):
        start, start_cpu = time.perf_counter(), time.process_time()
        loss = self.learning.run()
        seconds, cpu_seconds = time.perf_counter() - start, time.process_time() - start_cpu
        return {"seconds": seconds, "cpu_seconds": cpu_seconds, "steps": self.steps, "loss": loss}


def set_bits(bits):
    """Whether JAX computes in 64 bits where it is asked to; before anything is made."""
    import jax

    jax.config.update("jax_enable_x64", bits == 64)


class TrainTask:
    """Steps of training of a learned proposal."""

    def __init__(self, task):
        import torch

        torch.set_num_threads(task["threads"])
        from train import Training

        self.steps = task["steps"]
        with time_limit(180 if task.get("compile") else 600):
            self.training = Training(task)
            self.training.run(2)

    def check(self):
        return self.training.at_first

    def run(self):
        start, start_cpu = time.perf_counter(), time.process_time()
        loss = self.training.run(self.steps)
        seconds, cpu_seconds = time.perf_counter() - start, time.process_time() - start_cpu
        return {"seconds": seconds, "cpu_seconds": cpu_seconds, "steps": self.steps, "loss": loss}


class time_limit:
    """Raises TimeoutError inside a block that takes longer."""

    def __init__(self, seconds):
        self.seconds = seconds

    def __enter__(self):
        signal.signal(signal.SIGALRM, self.stop)
        signal.alarm(self.seconds)

    def __exit__(self, *_):
        signal.alarm(0)

    def stop(self, *_):
        raise TimeoutError(f"it took more than {self.seconds} s to prepare")


PACKAGES = {
    "particles": ("particles", "numpy", "scipy", "numba"),
    "cuthbert": ("cuthbert", "cuthbertlib", "jax", "jaxlib", "numpy"),
    "jax": ("jax", "jaxlib", "numpy", "safetensors"),
    "numpy": ("numpy",),
    None: ("torch", "numpy", "safetensors"),
}


def versions(task):
    found = {name: importlib.metadata.version(name) for name in PACKAGES[task.get("peer")]}
    return {"python": platform.python_version()} | found


def answer(request, threads, current):
    """The answer to a request, and the task that is prepared after it."""
    if "prepare" in request:
        task = request["prepare"]
        if task.setdefault("threads", threads) != threads:
            raise ValueError(f"this worker was started with --threads {threads}")
        kind = {"filter": FilterTask, "train": TrainTask, "learn": LearnTask, "learned": LearnedTask, "draws": DrawsTask}[task["kind"]]
        return {"ready": True, "versions": versions(task)}, kind(task)
    if current is None:
        raise ValueError("nothing is prepared")
    if "check" in request:
        return current.check(), current
    if "run" in request:
        return current.run(), current
    raise ValueError("a request is one of prepare, check, run and quit")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--threads", type=int, default=1)
    threads = parser.parse_args().threads
    limit_threads(threads)
    # Answers go to the real standard output, and all else that is printed to standard error.
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    current = None
    for line in sys.stdin:
        try:
            request = json.loads(line)
            if "quit" in request:
                break
            if "prepare" in request:
                current = None
            found, current = answer(request, threads, current)
        except Exception as error:  # whatever it was, the other side is to hear of it
            found = {"error": " ".join(f"{type(error).__name__}: {error}".split())[:500]}
        print(json.dumps(found), file=answers, flush=True)


if __name__ == "__main__":
    main()
