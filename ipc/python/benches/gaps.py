"""How much a thread that runs at 1 kHz is held up by taut beside it.

    python ipc/python/benches/gaps.py INSTANCE PROBLEM.json [--seconds 5] [--rounds 4]

Alternates runs without taut (the other thread sleeps), with the same calls made by another process (what the machine and
the daemon's own work cost), and with taut (a long path sent and a short one, in turns). Prints for each the gaps above
2 ms between two ticks, of the seconds measured.
"""

import argparse
import subprocess
import sys
import threading
import time

import numpy as np

import taut

PERIOD = 1e-3
GAP = 2e-3


def ticks(seconds):
    """Gaps between the ticks of a 1 kHz loop."""
    gaps = []
    end = time.perf_counter() + seconds
    last = time.perf_counter()
    while last < end:
        time.sleep(max(0.0, PERIOD - (time.perf_counter() - last)))
        now = time.perf_counter()
        gaps.append(now - last)
        last = now
    return np.array(gaps)


def measure(work, seconds):
    stop = threading.Event()
    done = [0]

    def beside():
        while not stop.is_set():
            work()
            done[0] += 1

    thread = threading.Thread(target=beside)
    thread.start()
    gaps = ticks(seconds)
    stop.set()
    thread.join()
    return gaps, done[0]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("instance")
    parser.add_argument("problem")
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--rounds", type=int, default=4)
    parser.add_argument("--only-call", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    sys.setswitchinterval(5e-3)
    with taut.connect(arguments.instance) as d:
        problem = d.load_problem(arguments.problem)
        rows = problem.path
        long = np.concatenate([np.linspace(a, b, 2000, endpoint=False) for a, b in zip(rows, rows[1:])] + [rows[-1:]])

        def with_taut():
            for path, mode in ((rows, "hybrid"), (long, "check")):
                try:
                    for best in d.shorten(path, problem.robot, problem.scene, deadline=0.05, mode=mode, contacts=False):
                        best.path.sum()
                except taut.TimedOut:
                    pass

        if arguments.only_call:
            while True:
                with_taut()

        def elsewhere():
            again = [sys.executable, __file__, arguments.instance, arguments.problem, "--only-call"]
            process = subprocess.Popen(again)
            time.sleep(1.0)
            return process

        print(f"{len(rows)} and {len(long)} waypoints x {rows.shape[1]}, switch interval {sys.getswitchinterval() * 1e3} ms")
        print(f"{'':>9} {'ticks':>7} {'gaps > 2 ms':>12} {'p99 ms':>8} {'longest ms':>11} {'calls':>7}")
        for _ in range(arguments.rounds):
            for name in ("without", "elsewhere", "with taut"):
                process = elsewhere() if name == "elsewhere" else None
                work = with_taut if name == "with taut" else lambda: time.sleep(0.01)
                gaps, calls = measure(work, arguments.seconds)
                if process:
                    process.terminate()
                    process.wait()
                wide = int((gaps > GAP).sum())
                p99 = np.percentile(gaps, 99) * 1e3
                print(f"{name:>9} {len(gaps):7} {wide:12} {p99:8.2f} {gaps.max() * 1e3:11.2f} {calls:7}")


main()
