#!/usr/bin/env python3
"""Dense sampling with coal beside taut's proofs, on the same paths: an optional comparison that nothing else runs.

    pip install pin==4.1.0 coal==3.0.3 numpy==2.4.6        (Python 3.10 or newer; pin is pinocchio)
    cargo build --release
    python3 benches/dense_sampling.py FOLDER... [--limit N] [--step 1mm] [--taut target/release/taut]

Each problem file (`taut-problem/1`) below the folders is checked twice, one after the other:

* by sampling: pinocchio and coal on the robot's given geometry (meshes as triangle trees) at so many configurations
  that no point of a robot's body travels more than the step between two of them (the few extreme points of a body that
  are followed may leave 2 % more to others). It stops at the first collision;
* by proof: `taut bench --check --geometry given`, whose time to prove the path is taken.

What is compared, and what is not counted against sampling:

* Both look at the same pairs: the robot's links that a joint moves against each other, less those that the SRDF, the
  problem or the scene allows, and moving links against obstacles.
* Samples are spread so that each stretch uses the whole step: where the fastest point slows down they lie farther
  apart. No even spread with the same promise has fewer.
* Sampling CPU is the process's time in the loop over configurations made beforehand, one call each, less what as many
  calls cost on an empty robot in an empty scene: Python and its bindings are not counted. The least of some runs.
* Each path is sampled in several ways, and the fastest counts: pinocchio's plain `computeCollisions` (`pairs`), and its
  broad phases over coal's naive manager (`boxes`), sweep and prune (`sorted`) and dynamic tree (`tree`). A broad phase
  that disagrees with `pairs` on configurations around the path is left out; coal 3.0.3's `SaP` and
  `DynamicAABBTreeArray` managers miss collisions on some robots and are not used at all.
* taut's figure is wall time of one thread, a median of several runs. Its proof keeps a clearance besides; the pairs
  that cannot keep it are found before, and the time for that is not in the figure.
"""

import argparse
import dataclasses
import gc
import json
import math
import os
import pathlib
import statistics
import subprocess
import sys
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # threads that wait busily would count as CPU time
try:
    import coal  # noqa: F401, only looked for
    import numpy as np
    import pinocchio as pin
except ImportError as error:
    sys.exit(f"{error}; next: pip install pin==4.1.0 coal==3.0.3 numpy==2.4.6")

sys.dont_write_bytecode = True
from dense_problem import Problem, Refused

# Calls on the empty robot, and runs of which the least is taken.
EMPTY_CALLS, RUNS = 20_000, 2
UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}


@dataclasses.dataclass
class Row:
    """What was measured on one problem; times in seconds."""

    name: str
    samples: int = 0
    sampled_s: dict = dataclasses.field(default_factory=dict)
    calls_s: float = 0.0
    left_out: list = dataclasses.field(default_factory=list)
    collides_with: str = ""
    proof_s: float = 0.0
    proved: bool = False
    error: str = ""

    @property
    def way(self):
        """The fastest way."""
        return min(self.sampled_s, key=self.sampled_s.get)

    @property
    def is_compared(self):
        """Whether both find the path free."""
        return self.proved and not self.collides_with and not self.error

    def ratio(self, way):
        """Sampling over proof."""
        return self.sampled_s[way] / self.proof_s


def ways(model, geometry):
    """The ways to check a configuration, by name: functions from a configuration to whether it collides."""
    data = model.createData()

    def pairs():
        geometry_data = geometry.createData()
        return lambda q: pin.computeCollisions(model, data, geometry, geometry_data, q, True)

    def broad_phase(kind):
        # The manager refers to the geometry data but does not keep it.
        geometry_data = geometry.createData()
        manager = kind(model, geometry, geometry_data)
        return lambda q, kept=geometry_data: pin.computeCollisions(model, data, manager, q, True)

    return {
        "pairs": pairs(),
        "boxes": broad_phase(pin.BroadPhaseManager_NaiveCollisionManager),
        "sorted": broad_phase(pin.BroadPhaseManager_SSaPCollisionManager),
        "tree": broad_phase(pin.BroadPhaseManager_DynamicAABBTreeCollisionManager),
    }


def timed(check, configurations):
    """CPU time until the first collision (s), and its index or None."""
    hit = None
    gc.disable()
    start = time.process_time()
    for index, q in enumerate(configurations):
        if check(q):
            hit = index
            break
    spent = time.process_time() - start
    gc.enable()
    return spent, hit


def call_costs():
    """CPU time of one call on an empty robot in an empty scene (s), by way: Python, the bindings, the loop."""
    nothing = [np.zeros(0)] * EMPTY_CALLS
    empty = ways(pin.Model(), pin.GeometryModel())
    return {name: min(timed(check, nothing)[0] for _ in range(3)) / EMPTY_CALLS for name, check in empty.items()}


def sample(problem, row, step, costs):
    """Fills in what sampling finds and costs."""
    configurations = list(problem.samples(step))
    checks, around = ways(problem.model, problem.geometry), problem.around(configurations)
    verdicts = {name: [check(q) for q in around] for name, check in checks.items()}
    row.left_out = [name for name in checks if verdicts[name] != verdicts["pairs"]]
    hits = set()
    for name in (name for name in checks if name not in row.left_out):
        runs = [timed(checks[name], configurations) for _ in range(RUNS)]
        hits.update(hit for _, hit in runs)
        hit = runs[0][1]
        row.samples = len(configurations) if hit is None else hit + 1
        row.sampled_s[name] = max(0.0, min(spent for spent, _ in runs) - costs[name] * row.samples)
    if len(hits) > 1:
        raise Refused(f"coal's ways disagree on the first collision: samples {hits}")
    row.calls_s = costs[row.way] * row.samples
    row.collides_with = "" if hit is None else problem.contact(configurations[hit])


def prove(taut, file, row):
    """Fills in what taut finds and how long it takes."""
    command = [taut, "bench", "--check", str(file.parent), "--geometry", "given", "--format", "json"]
    result = subprocess.run([*command, "--filter", file.stem], capture_output=True, text=True, check=False)
    if result.returncode not in (0, 65):
        raise Refused(f"taut: {result.stderr.strip() or result.returncode}")
    found = next(r for r in json.loads(result.stdout)["rows"] if r["name"] == file.stem and "/" not in r["set"])
    if found["error"]:
        raise Refused(f"taut: {found['error']}")
    row.proof_s, row.proved = found["proof_s"], found["proved"]


HEADER = (f"{'problem':<36} {'samples':>8} {'pairs ms':>10} {'best ms':>10} {'way':>7} {'calls ms':>9} {'proof ms':>9} "
          f"{'taut':>8} {'÷ pairs':>8} {'÷ best':>7}  sampled")


def cells(row):
    """A row of the table."""
    if row.error:
        return f"{row.name:<36} {row.error}"
    ratios = [f"{row.ratio(way):.1f}" if row.is_compared else "-" for way in ("pairs", row.way)]
    sampled, proved = row.collides_with or "free", "proved" if row.proved else "refused"
    left_out = f" (left out, for they miss collisions: {', '.join(row.left_out)})" if row.left_out else ""
    return (f"{row.name:<36} {row.samples:>8} {row.sampled_s['pairs'] * 1e3:>10.1f} "
            f"{row.sampled_s[row.way] * 1e3:>10.1f} {row.way:>7} {row.calls_s * 1e3:>9.1f} {row.proof_s * 1e3:>9.3f} "
            f"{proved:>8} {ratios[0]:>8} {ratios[1]:>7}  {sampled}{left_out}")


def summary(name, rows):
    """The medians of a set."""
    ran = [row for row in rows if not row.error]
    both = [row for row in ran if row.is_compared]
    hits = [row for row in ran if row.collides_with]
    free = [row for row in ran if not row.collides_with]
    text = (f"{name}: {len(ran)} of {len(rows)} run; {len(both)} free and proved, {len(hits)} colliding where sampled "
            f"({sum(row.proved for row in hits)} of them proved), "
            f"{sum(not row.proved for row in free)} free where sampled but refused")
    if both:
        proofs = [row.proof_s for row in both]
        text += (f"\n  free and proved: median of {statistics.median(row.samples for row in both):.0f} samples, "
                 f"of {statistics.median(proofs) * 1e3:.3f} ms for the proof")
        for label, way in (("every pair", lambda row: "pairs"), ("fastest way", lambda row: row.way)):
            times = [row.sampled_s[way(row)] for row in both]
            ratios = [row.ratio(way(row)) for row in both]
            text += (f"\n  {label:<11} median {statistics.median(times) * 1e3:.1f} ms; sampling ÷ proof: median "
                     f"{statistics.median(ratios):.1f}, worst {min(ratios):.1f}, best {max(ratios):.1f}, "
                     f"sum ÷ sum {sum(times) / sum(proofs):.1f}")
    return text


def metres(text):
    """A length: 1mm, 0.5cm, or metres."""
    unit = next((unit for unit in UNITS if text.endswith(unit)), "")
    try:
        value = float(text.removesuffix(unit)) * UNITS.get(unit, 1.0)
    except ValueError:
        value = math.nan
    if not (0.0 < value < math.inf):
        raise argparse.ArgumentTypeError(f"{text!r} is no positive length; valid: 1mm, 0.5cm, 0.001 (metres)")
    return value


def spread(files, limit):
    """At most `limit` of the files, evenly over all of them."""
    return files if limit is None or limit >= len(files) else [files[k * len(files) // limit] for k in range(limit)]


def main():
    parser = argparse.ArgumentParser(description="Dense sampling with coal beside taut's proofs, on the same paths.")
    parser.add_argument("folders", nargs="+", type=pathlib.Path, metavar="FOLDER", help="folder with problem files")
    parser.add_argument("--limit", type=int, help="at most this many problems of each folder, evenly spread")
    parser.add_argument("--step", type=metres, default=1e-3, help="travel between samples (default 1mm)")
    parser.add_argument("--taut", default="target/release/taut", help="taut's binary (default %(default)s)")
    arguments = parser.parse_args()
    if not pathlib.Path(arguments.taut).is_file():
        sys.exit(f"no taut at {arguments.taut}; next: cargo build --release, or name it with --taut")
    sets = {}
    for folder in arguments.folders:
        for file in sorted(folder.rglob("*.json")):
            sets.setdefault(file.parent, []).append(file)
    if not sets:
        sys.exit(f"no .json file below {', '.join(map(str, arguments.folders))}")
    costs = call_costs()
    print("an empty call costs " + ", ".join(f"{cost * 1e6:.2f} µs ({name})" for name, cost in costs.items()))
    print(HEADER, flush=True)
    summaries, failed = [], False
    for folder, files in sets.items():
        rows = []
        for file in spread(files, arguments.limit):
            row = Row(f"{folder.name}/{file.stem}")
            try:
                sample(Problem(file), row, arguments.step, costs)
                prove(arguments.taut, file, row)
            except (Refused, OSError, ValueError, KeyError) as error:
                row.error = f"{type(error).__name__}: {error}" if not isinstance(error, Refused) else str(error)
            rows.append(row)
            print(cells(row), flush=True)
        failed = failed or any(row.error for row in rows)
        summaries.append(summary(folder.name, rows))
    print("\n" + "\n".join(summaries))
    sys.exit(65 if failed else 0)


if __name__ == "__main__":
    main()
