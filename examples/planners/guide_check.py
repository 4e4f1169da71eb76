"""Runs a piece of README.md on a real path: guide_check.py ompl | hpp | moveit, or vamp PROBLEM.json."""

import argparse
import contextlib
import io
import re
import sys
from pathlib import Path

HERE = Path(__file__).parent
PROBLEM = HERE / "../../config/problems/arm_window.json"


def piece(name):
    """The code of README.md that is marked with a name."""
    found = re.search(rf"^```python {name}\n(.*?)^```$", (HERE / "README.md").read_text(), re.M | re.S)
    if not found:
        raise SystemExit(f"README.md has no piece of code named {name!r}")
    # A loaded machine may not prove a path in the guide's time.
    return re.sub(r"deadline=[0-9.]+", "deadline=60", found[1])


def options():
    """What a planner's script takes by default."""
    from comparison import options as add

    parser = argparse.ArgumentParser()
    add(parser)
    return parser.parse_args([])


def shorter(problem, before, after):
    """Ends with a message unless a path is shorter, free, and joins the same ends."""
    lengths = problem.length(before), problem.length(after)
    print(f"{len(before)} waypoints {lengths[0]:.3f} -> {len(after)} waypoints {lengths[1]:.3f}")
    if not lengths[1] < 0.9 * lengths[0]:
        raise SystemExit("not shorter")
    if list(before[0]) != list(after[0]) or list(before[-1]) != list(after[-1]):
        raise SystemExit("other ends")
    hit = problem.collision(after, 0.002)
    if hit:
        raise SystemExit(f"coal: {hit}")


def ompl():
    import ompl.base as ob
    import ompl.geometric as og

    import ompl_planner
    from problem import Problem

    problem = Problem(PROBLEM)
    before = ompl_planner.plan(problem, problem.start, problem.goal, options()).path
    space = ompl_planner.Space(problem)
    information = ob.SpaceInformation(space.space)
    path = og.PathGeometric(information)
    for row in before:
        path.append(space.state(row))
    scope = {}
    exec(piece("ompl"), scope)
    scope["simplify"](information, path)
    shorter(problem, before, [space.row(state) for state in path.getStates()])


def hpp():
    import hpp_planner
    import pyhpp.core
    from pyhpp.core.path import Vector

    from problem import Problem

    problem = Problem(PROBLEM)
    before = hpp_planner.plan(problem, problem.start, problem.goal, options()).path
    task = pyhpp.core.Problem(hpp_planner.device(problem))
    task.steeringMethod(pyhpp.core.Straight(task))
    path = Vector(7, 7)
    for start, end in zip(before, before[1:]):
        path.appendPath(task.steeringMethod().steer(start, end))
    scope = {}
    exec(piece("hpp"), scope)
    shorter(problem, before, hpp_planner.rows(problem, scope["optimize"](task, path)))


def vamp():
    import vamp

    import vamp_planner
    from problem import Problem

    problem = Problem(sys.argv[2], spheres=True)
    robot = getattr(vamp, vamp_planner.robot_of(problem))
    before = vamp_planner.plan(problem, problem.start, problem.goal, options()).path
    path = robot.Path()
    for row in before:
        path.append(row.tolist())
    scope = {}
    exec(piece("vamp"), scope)
    loaded = scope["daemon"].load_problem(str(problem.file), spheres=problem.spheres)
    after = scope["simplify"](robot, path, loaded.robot, loaded.scene)
    print(f"{len(path)} waypoints {path.cost():.3f} -> {len(after)} waypoints {after.cost():.3f}")
    if not after.cost() < path.cost():
        raise SystemExit("not shorter")


def moveit():
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        exec(piece("moveit"), {})
    print(said.getvalue(), end="")
    if not said.getvalue().rstrip().endswith("True"):
        raise SystemExit("not proved")


if __name__ == "__main__":
    {"ompl": ompl, "hpp": hpp, "vamp": vamp, "moveit": moveit}[sys.argv[1]]()
