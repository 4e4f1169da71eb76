"""A planner's path, the planner's own simplifier and taut, side by side."""

import argparse
import time
from dataclasses import asdict, dataclass

import numpy as np
import taut

from problem import Problem, Refused


class NoPath(Exception):
    """A planner that found no path in its time."""


@dataclass
class Planned:
    """What a planner found, rows of the problem's columns, and what its own simplifier made of it."""

    path: list
    plan_s: float
    simplified: list
    simplify_s: float


@dataclass
class Comparison:
    """One planner's path, shortened twice. Lengths weigh every joint with 1 (radians and metres
    together); times are of the wall clock (s); `*_hits` says where coal, looking every `step`,
    found a path to collide."""

    problem: str
    planner: str
    simplifier: str
    waypoints: int
    before: float
    own: float
    own_s: float
    own_hits: str
    taut: float
    taut_s: float
    taut_hits: str
    proved: bool
    clearance: float
    passed_own_s: float
    refused: str

    def line(self):
        """The comparison in one line."""
        own = f"own {self.simplifier} {self.own:.3f} in {self.own_s * 1e3:.0f} ms ({self.own_hits or 'free'})"
        if self.refused:
            return f"{self.problem}: {self.planner} {self.before:.3f}, {own}, taut refused: {self.refused}"
        proof = f"proved, clearance >= {self.clearance * 1e3:.1f} mm" if self.proved else "NOT PROVED"
        passed = "" if self.passed_own_s is None else f", as short as own after {self.passed_own_s * 1e3:.1f} ms"
        taut_part = f"taut {self.taut:.3f} in {self.taut_s * 1e3:.0f} ms ({proof}{passed})"
        return f"{self.problem}: {self.planner} {self.before:.3f}, {own}, {taut_part}"

    def record(self):
        """The comparison as JSON has it."""
        return asdict(self)


def compare(problem, planner, planned, daemon, options):
    """Lets taut shorten what the planner found, and coal judge both."""
    own_hit = problem.collision(planned.simplified, options.step)
    row = Comparison(
        problem=problem.name,
        planner=planner.NAME,
        simplifier=options.simplifier or planner.SIMPLIFIER,
        waypoints=len(planned.path),
        before=problem.length(planned.path),
        own=problem.length(planned.simplified),
        own_s=planned.simplify_s,
        own_hits=told(own_hit),
        taut=None,
        taut_s=None,
        taut_hits="",
        proved=False,
        clearance=None,
        passed_own_s=None,
        refused="",
    )
    loaded = daemon.load_problem(str(problem.file), spheres=problem.spheres)
    began = time.perf_counter()
    try:
        answer = daemon.shorten(
            np.array(planned.path),
            robot=loaded.robot,
            scene=loaded.scene,
            columns=problem.columns,
            metric=np.ones(problem.model.nv),
            deadline=options.deadline,
        )
        for best in answer:
            if row.passed_own_s is None and best.length <= row.own:
                row.passed_own_s = best.time
        result = answer.result()
    except taut.Error as error:
        row.refused = str(error)
        return row
    row.taut_s = time.perf_counter() - began
    path = np.array(result.path)
    row.taut, row.proved, row.clearance = problem.length(path), result.proved, result.clearance
    row.taut_hits = told(problem.collision(path, options.step))
    return row


def told(hit):
    """Where a path collides, for people."""
    return f"{hit[2][0]} x {hit[2][1]} at segment {hit[0]}, t = {hit[1]:.3f}" if hit else ""


def options(parser):
    """The options that every planner's script has."""
    parser.add_argument("--seed", type=int, default=0, help="of the planner's random numbers")
    parser.add_argument("--seconds", type=float, default=20.0, help="for planning")
    parser.add_argument("--deadline", type=float, default=0.05, help="for taut (s)")
    parser.add_argument("--resolution", type=float, default=0.001, help="of OMPL's motion check, share of the extent")
    parser.add_argument("--margin", type=float, default=1e-4, help="that HPP keeps from obstacles (m)")
    parser.add_argument("--step", type=float, default=0.001, help="of the judge, radians and metres together")
    parser.add_argument("--simplifier", help="another of the planner's own, by its class")
    parser.add_argument("--local", action="store_true", help="taut in this process, without a daemon")


def connection(given):
    """The daemon, or taut in this process."""
    return taut.local() if given.local else taut.connect()


def main(description, planner):
    """One problem, one planner, one line."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("problem", help="a taut-problem/1 file")
    parser.add_argument("--query", type=int, default=0, help="0 the file's own ends, others sampled")
    options(parser)
    given = parser.parse_args()
    try:
        problem = Problem(given.problem, spheres=planner.SPHERES)
        planned = planner.plan(problem, *problem.query(given.query), given)
        with connection(given) as daemon:
            row = compare(problem, planner, planned, daemon, given)
    except (Refused, NoPath, taut.Error) as error:
        raise SystemExit(f"{planner.NAME}: {error}") from None
    print(row.line())
    if row.refused or not row.proved or row.taut_hits:
        raise SystemExit(1)
