"""What a path of 100,000 x 7 costs on its way in and out, beside a copy of the same size.

    python ipc/python/benches/copies.py INSTANCE PROBLEM.json [--rounds 20]

Prints where answers lie, what Python allocates, and times. The daemon's own work (a check that is over at once) is
left out of the way in; the way out is the time from the answer's coming to its last number being read.
"""

import argparse
import statistics
import time
import tracemalloc

import numpy as np

import taut

WAYPOINTS = 100_000


def mapped(address):
    with open("/proc/self/maps") as maps:
        for line in maps:
            start, end = (int(part, 16) for part in line.split()[0].split("-"))
            if start <= address < end:
                return line.split()[-1]
    return "nothing"


def rss_kb():
    with open("/proc/self/status") as status:
        lines = dict(line.split(":", 1) for line in status if line.startswith("Rss"))
    return {name: int(value.split()[0]) for name, value in lines.items()}


def median_ms(times):
    return statistics.median(times) * 1e3


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("instance")
    parser.add_argument("problem")
    parser.add_argument("--rounds", type=int, default=20)
    arguments = parser.parse_args()
    with taut.connect(arguments.instance) as d:
        problem = d.load_problem(arguments.problem)
        parts = np.array_split(np.arange(WAYPOINTS - 1), len(problem.path) - 1)
        pieces = [np.linspace(a, b, len(part), endpoint=False)
                  for part, a, b in zip(parts, problem.path, problem.path[1:])]
        path = np.ascontiguousarray(np.concatenate([*pieces, problem.path[-1:]]))
        size = path.nbytes
        print(f"path {path.shape[0]} x {path.shape[1]}, {size / 1e6:.1f} MB")

        def ask(path=path, **options):
            return d.shorten(path, problem.robot, problem.scene, mode="check", contacts=False, **options)

        result = ask().result()
        address = result.path.__array_interface__["data"][0]
        print(f"the answer lies in {mapped(address)} at {address:#x}, shared {result.is_shared}")
        del result
        before = rss_kb()
        tracemalloc.start()
        result = ask().result()
        view = result.path
        total = float(view.sum())
        now, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        after = rss_kb()
        grown = {name: after[name] - before[name] for name in after}
        print(f"Python allocated at most {peak} bytes, numpy's arrays included; resident memory grew by {grown} kB")
        del result, view
        memcpy, sending, reading, turned_in = [], [], [], []
        order = list(range(path.shape[1]))[::-1]
        names = [problem.columns[i] for i in order]
        turned = np.ascontiguousarray(path[:, order])
        target = np.empty_like(path)
        for _ in range(arguments.rounds):
            start = time.perf_counter()
            np.copyto(target, path)
            memcpy.append(time.perf_counter() - start)
            start = time.perf_counter()
            answers = ask()
            sending.append(time.perf_counter() - start)
            result = answers.result()
            start = time.perf_counter()
            view = result.path
            reading.append(time.perf_counter() - start)
            del answers, result, view
            start = time.perf_counter()
            answers = ask(turned, columns=names)
            turned_in.append(time.perf_counter() - start)
            answers.result()
            del answers
        print(f"copy of the same size {median_ms(memcpy):.2f} ms")
        print(f"in: shorten() returns after {median_ms(sending):.2f} ms, with columns in another order {median_ms(turned_in):.2f} ms")
        print(f"out: .path takes {median_ms(reading) * 1e3:.1f} us (sum of the numbers {total:.3f})")


main()
