"""Times several tasks side by side: one worker each, run in turns; tasks come as JSON lines on standard input."""

import argparse
import json
import pathlib
import subprocess
import sys


class Worker:
    """A worker process with one task prepared."""

    def __init__(self, task):
        path = pathlib.Path(__file__).with_name("worker.py")
        command = [sys.executable, str(path), "--threads", str(task.get("threads", 1))]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(
            command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, text=True
        )
        self.fault = self.ask({"prepare": task}).get("error")

    def ask(self, request):
        print(json.dumps(request), file=self.process.stdin, flush=True)
        return json.loads(self.process.stdout.readline() or '{"error": "the worker ended"}')


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=10)
    rounds = parser.parse_args().rounds
    tasks = [json.loads(line) for line in sys.stdin if line.strip()]
    workers = [Worker(task) for task in tasks]
    answers = [[] for _ in tasks]
    for _ in range(rounds):
        for worker, found in zip(workers, answers):
            if worker.fault is None:
                found.append(worker.ask({"run": True}))
    for task, worker, found in zip(tasks, workers, answers):
        least = {key: min(one[key] for one in found) for key in ("seconds", "cpu_seconds")} if found else {}
        print(json.dumps(task | least | ({"error": worker.fault} if worker.fault else {})))
        worker.process.stdin.close()
        worker.process.wait()


if __name__ == "__main__":
    main()
