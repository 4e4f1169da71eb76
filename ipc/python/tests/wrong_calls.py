"""Throws wrong values, types, shapes and orders of calls at every method; prints how many raised what.

Anything but an exception of these kinds ends it: a crash of the process, or an exception that should not be.
"""

import collections
import os
import random
import sys

import numpy as np

import taut

EXPECTED = (taut.Error, TimeoutError, ValueError, TypeError, AttributeError, StopIteration, OSError, OverflowError)

seed, rounds, instance, problem_file = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3], sys.argv[4]
rng = random.Random(seed)
numbers = np.random.default_rng(seed)

# Waits end: what needs a daemon's answer gets a deadline.
VALUES = [
    None, True, False, 0, 1, -1, 2**31, 2**63, 2**64, -(2**70), 0.0, -0.0, 1e-300, 1e300, float("nan"), float("inf"),
    "", "rooms", "x", "\0", "\ud800", "a" * 10_000, b"bytes", [], (), {}, [[]], [1], [None], {"x": 1}, {1: 2},
    {"is_diff": True}, {"objects": [{"id": "w"}]}, set(), object(), type, range(3), 3j, np.float32(1), np.zeros(0),
    np.zeros((0, 2)), np.zeros((2, 2)), np.zeros((2, 2), dtype=object), np.zeros((2, 3)), np.full((2, 2), np.nan),
    np.zeros((2, 2), dtype="c16"), np.zeros((2, 2), dtype="U3"), np.zeros((3, 2))[::2], np.zeros((2, 2), dtype=">f4"),
    taut.Upright("x"), taut.Upright("disc", axis="w"), taut.Oriented("disc", (0, 0, 1), (1, 2)), taut.InBall(None, "r", [1]),
    [taut.JointWithin("x", float("nan"), 1, 1), {"name": "x"}], ["keep disc in ball 9 at 0,0,0", "[[\"upright\"]]"],
    np.ma.masked_array(np.zeros((2, 2)), mask=True), np.broadcast_to(np.zeros(2), (5, 2)), memoryview(b"ab"),
]
OPTIONS = ["deadline", "mode", "columns", "hold", "group", "fix", "weights", "metric", "clearance", "strict",
           "unwrapped", "contacts", "budget", "seed", "priority", "scene_version", "constraints", "nonsense"]


def value():
    if rng.random() < 0.2:
        return numbers.random((rng.randrange(4), rng.randrange(4))) * 10 ** rng.randrange(-3, 4)
    return rng.choice(VALUES)


def planners():
    made = [taut.local(), taut.connect(instance)]
    closed = taut.local()
    closed.close()
    return [*made, closed]


def main():
    counts = collections.Counter()
    all_planners = planners()
    own = f"wrong-calls-{os.getpid()}"
    problems = [planner.load_problem(problem_file, scene=own) for planner in all_planners[:2]]
    problems.append(problems[0])
    things = []
    for _ in range(rounds):
        index = rng.randrange(len(all_planners))
        planner, problem = all_planners[index], problems[index]
        try:
            kind = rng.randrange(8)
            if kind == 0:
                options = {rng.choice(OPTIONS): value() for _ in range(rng.randrange(3))}
                path = problem.path if rng.random() < 0.6 else value()
                options.setdefault("budget", 50)
                options.setdefault("deadline", 0.2)
                things.append(planner.shorten(path, problem.robot, problem.scene, **options))
            elif kind == 1:
                path = problem.path if rng.random() < 0.3 else value()
                robot = problem.robot if rng.random() < 0.7 else value()
                scene = problem.scene if rng.random() < 0.7 else value()
                things.append(planner.check(path, robot, scene, deadline=0.2))
            elif kind == 2:
                name = rng.choice(["robot", "load_robot", "load_scene", "unload_robot", "scene", "load_problem"])
                count = rng.randrange(4)
                arguments = [value() for _ in range(count)]
                # What the others need stays.
                if name == "unload_robot" and arguments[:1] == [problem.robot]:
                    continue
                things.append(getattr(planner, name)(*arguments))
            elif kind == 3:
                scene = planner.scene(rng.choice(["wrong", problem.scene, value()]))
                if rng.random() < 0.3:
                    scene = planner.load_scene("wrong", {"objects": []}, replace=True)
                name = rng.choice(["diff", "move", "attach", "detach", "add", "snapshot", "pin", "unpin", "subscribe"])
                things.append(getattr(scene, name)(*[value() for _ in range(rng.randrange(4))]))
            elif kind == 4 and things:
                thing = rng.choice(things)
                if isinstance(thing, taut.SceneChanges):
                    continue  # it would wait for good
                names = [name for name in dir(thing) if not name.startswith("__") and name != "unload"]
                member = getattr(thing, rng.choice(names))
                if callable(member):
                    member(*[value() for _ in range(rng.randrange(3))])
            elif kind == 5 and things:
                thing = rng.choice(things)
                if isinstance(thing, taut.Answers):
                    rng.choice([thing.next, thing.result, thing.close, thing.finish_early, lambda: list(thing)])()
                elif isinstance(thing, taut.Improvement):
                    assert not thing.path.flags.writeable
                    np.asarray(thing).sum()
                elif isinstance(thing, taut.SceneChanges):
                    thing.next(0.0)
            elif kind == 6 and things:
                del things[rng.randrange(len(things))]
            elif kind == 7:
                del things[rng.randrange(len(things) + 1):]
            counts["returned"] += 1
        except EXPECTED as error:
            counts[type(error).__name__] += 1
    assert all(problem.path is not None for problem in problems)
    for planner, problem in zip(all_planners[:2], problems):
        things.clear()
        problem = planner.load_problem(problem_file)
        assert planner.shorten(problem.path, problem.robot, problem.scene, budget=50).result().proved
    print(dict(counts))


main()
