"""OMPL plans with a path constraint; what it plans is recorded as problem files.

    pip install -r examples/planners/requirements-ompl.txt
    python examples/planners/constrained_planner.py FOLDER -o recorded --link panda_hand --axis x --within 0.1
    python examples/planners/constrained_judge.py recorded

Each problem of FOLDER (taut-problem/1, a fixed base) keeps its robot and its scene. The link carries
a cup (`--cup`), and its axis stays within an angle of the vertical: between two sampled
configurations that are upright and free, RRT-Connect plans in OMPL's ProjectedStateSpace with the
constraint as its wheel's users write it, in Python. Recorded are the path as OMPL interpolates it
and, as a peer, what OMPL's `simplifySolution` makes of it, interpolated too.
"""

import argparse
import json
import math
import os
import sys
import time
from pathlib import Path

import numpy as np
import ompl.base as ob
import ompl.geometric as og
import ompl.util as ou
import pinocchio as pin

from problem import Problem, Refused

AXES = {"x": 0, "y": 1, "z": 2}


class Upright(ob.Constraint):
    """The horizontal part of a link's axis is nothing, up to the sine of an angle."""

    def __init__(self, problem, link, axis, within):
        super().__init__(len(problem.columns), 2, math.sin(within))
        self.problem, self.within = problem, within
        self.model, self.data = problem.model, problem.model.createData()
        self.frame, self.axis = self.model.getFrameId(link), axis
        self.rates = [self.model.joints[self.model.getJointId(name)].idx_v for name in problem.columns]

    def direction(self, row):
        """The axis in the world."""
        pin.framesForwardKinematics(self.model, self.data, self.problem.configuration(row))
        return self.data.oMf[self.frame].rotation[:, self.axis]

    def tilt(self, row):
        """Its angle against the vertical."""
        direction = self.direction(row)
        return math.atan2(math.hypot(direction[0], direction[1]), direction[2])

    def function(self, x, out):
        out[:] = self.direction(x)[:2]

    def jacobian(self, x, out):
        q = self.problem.configuration(x)
        turning = pin.computeFrameJacobian(self.model, self.data, q, self.frame, pin.LOCAL_WORLD_ALIGNED)[3:]
        moved = np.cross(turning.T, self.data.oMf[self.frame].rotation[:, self.axis]).T[:2]
        out[:, :] = moved[:, self.rates]

    def keeps(self, row):
        """Whether the axis points up; the constraint itself knows no sign."""
        return self.tilt(row) <= self.within


def cup(axis, radius, height, away):
    """A cylinder along the axis, in front of a hand."""
    turned = {"x": {"y": 1.0, "w": 1.0}, "y": {"x": -1.0, "w": 1.0}, "z": {"w": 1.0}}[axis]
    turned = {name: value / math.sqrt(sum(v * v for v in turned.values())) for name, value in turned.items()}
    place = {"position": [0.0, 0.0, away], "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 0.0, **turned}}
    shape = {"type": "cylinder", "dimensions": [height, radius]}
    return {"id": "cup", "primitives": [shape], "primitive_poses": [place]}


def limits(problem):
    """The joints' lower and upper ends."""
    return np.array([[part.lower, part.upper] for part in problem.parts]).T


def upright_and_free(problem, constraint, random):
    """A configuration that the constraint keeps and that nothing touches."""
    lower, upper = limits(problem)
    jacobian = np.zeros((2, len(lower)))
    for _ in range(20_000):
        row = random.uniform(lower, upper)
        for _ in range(30):
            missing = constraint.direction(row)[:2]
            if np.linalg.norm(missing) < 1e-9:
                break
            constraint.jacobian(row, jacobian)
            row = row - np.linalg.pinv(jacobian) @ missing
        inside = np.all(lower <= row) and np.all(row <= upper)
        if inside and constraint.tilt(row) < 1e-8 and problem.free(problem.configuration(row)):
            return row
    raise Refused(f"{problem.file.name}: 20,000 samples, and none is upright and free")


def straight_tilt(constraint, start, goal):
    """The most that the straight line tilts."""
    return max(constraint.tilt(start + t * (goal - start)) for t in np.linspace(0, 1, 200))


def plan(problem, constraint, ends, given):
    """A path between two configurations, and what OMPL makes of it."""
    ambient = ob.RealVectorStateSpace(len(problem.columns))
    bounds = ob.RealVectorBounds(len(problem.columns))
    for index, part in enumerate(problem.parts):
        bounds.setLow(index, float(part.lower))
        bounds.setHigh(index, float(part.upper))
    ambient.setBounds(bounds)
    space = ob.ProjectedStateSpace(ambient, constraint)
    setup = og.SimpleSetup(ob.ConstrainedSpaceInformation(space))
    width = len(problem.columns)
    lower, upper = limits(problem)

    def row(state):
        return np.array([state[index] for index in range(width)])

    def is_free(state):
        at = row(state)
        # A projection may leave the joints' limits: the space does not see to that.
        inside = np.all(lower <= at) and np.all(at <= upper)
        return bool(inside) and constraint.keeps(at) and problem.free(problem.configuration(at))

    setup.setStateValidityChecker(is_free)
    states = []
    for end in ends:
        state = space.allocState()
        state.copy(end)
        states.append(state)
    setup.setStartAndGoalStates(*states)
    setup.setPlanner(og.RRTConnect(setup.getSpaceInformation()))
    if not setup.solve(given.seconds) or not setup.haveExactSolutionPath():
        raise Refused(f"{problem.file.name}: no path in {given.seconds} s")

    def rows():
        path = setup.getSolutionPath()
        path.interpolate()
        found = [row(state) for state in path.getStates()]
        found[0], found[-1] = ends
        return found

    before = rows()
    began = time.process_time()
    setup.simplifySolution()
    return before, rows(), time.process_time() - began


def length(rows):
    """Length in joint space: what a controller executes."""
    return float(np.sum(np.linalg.norm(np.diff(np.array(rows), axis=0), axis=1)))


def record(problem, given, constraint, before, after, simplify_s, out):
    """The problem with the path planned, beside what OMPL makes of it."""
    text = json.loads(problem.file.read_text())
    here = out.parent
    text["robot"] = dict(problem.robot)
    for field in ("urdf", "srdf", "spherized_urdf"):
        if text["robot"].get(field):
            text["robot"][field] = os.path.relpath(problem.folder / text["robot"][field], here)
    text["robot"]["packages"] = {name: os.path.relpath(folder, here) for name, folder in problem.packages().items()}
    text["scene"] = problem.scene
    axis = [float(index == AXES[given.axis]) for index in range(3)]
    tilt = {"link_name": given.link, "axis": axis, "reference": [0, 0, 1], "tolerance_rad": given.within}
    text["path_constraints"] = {"name": "upright", "orientation_constraints": [tilt]}
    text["metric"] = {"weights_per_dof": [1.0] * len(problem.columns)}
    text["path"] = [list(map(float, row)) for row in before]
    text["path_length"] = length(before)
    text["lower_bound"] = float(np.linalg.norm(before[-1] - before[0]))
    simplified = {"length": length(after), "cpu_s": simplify_s, "path": [list(map(float, row)) for row in after]}
    text["peers"] = {"ompl/simplifySolution": simplified}
    for field in ("best_honest_peer", "mesh_check"):
        text.pop(field, None)
    out.write_text(json.dumps(text) + "\n")


def carrying(file, given):
    """The problem with a cup on the link."""
    problem = Problem(file)
    if problem.base or any(part.kind != "number" for part in problem.parts):
        raise Refused(f"{file}: a base that moves, or a joint without end; valid: a fixed base, bounded joints")
    names = [frame.name for frame in problem.model.frames if frame.type == pin.FrameType.BODY]
    for link in [given.link, *given.touch]:
        if link not in names:
            raise Refused(f"{file}: no link {link!r}; valid: {', '.join(names)}")
    held = {"link_name": given.link, "object": cup(given.axis, *given.cup)}
    held["touch_links"] = given.touch
    problem.scene = {**problem.scene, "attached_collision_objects": [held]}
    problem.geometry = problem._geometry()
    problem._seen = problem.geometry.createData()
    return problem


def main():
    """Plans, records."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="taut-problem/1 files, at any depth; or one such file")
    parser.add_argument("-o", "--output", required=True, help="folder of the recorded problems")
    parser.add_argument("--link", default="panda_hand", help="that carries the cup")
    parser.add_argument("--axis", default="x", choices=list(AXES), help="of the link, upwards")
    parser.add_argument("--within", type=float, default=0.1, help="angle against the vertical (rad)")
    parser.add_argument("--cup", type=float, nargs=3, default=[0.035, 0.12, 0.1034], help="radius, height, distance (m)")
    parser.add_argument("--touch", nargs="*", default=["panda_leftfinger", "panda_rightfinger"], help="links that hold it")
    parser.add_argument("--margin", type=float, default=2e-3, help="that the planner keeps (m)")
    parser.add_argument("--seconds", type=float, default=60.0, help="for planning")
    parser.add_argument("--seed", type=int, default=0, help="of all random numbers")
    given = parser.parse_args()
    ou.setLogLevel(ou.LogLevel.LOG_ERROR)
    ou.RNG.setSeed(given.seed + 1)
    recorded, source = 0, Path(given.folder)
    for number, file in enumerate(sorted(source.rglob("*.json")) or [source]):
        random = np.random.default_rng([given.seed, number])
        try:
            problem = carrying(file, given)
            for pair in range(len(problem.geometry.collisionPairs)):
                problem._seen.collisionRequests[pair].security_margin = given.margin
            constraint = Upright(problem, given.link, AXES[given.axis], given.within)
            while True:
                ends = [upright_and_free(problem, constraint, random) for _ in range(2)]
                if straight_tilt(constraint, *ends) > given.within:
                    break
            found = plan(problem, constraint, ends, given)
        except Refused as refused:
            print(refused, file=sys.stderr)
            continue
        out = Path(given.output) / (file.relative_to(source) if source.is_dir() else file.name)
        out.parent.mkdir(parents=True, exist_ok=True)
        record(problem, given, constraint, *found, out)
        recorded += 1
        before, after, seconds = found
        print(f"{out}: {len(before)} waypoints {length(before):.3f}; OMPL's own {length(after):.3f} in {seconds:.2f} s", flush=True)
    print(f"{recorded} recorded")
    sys.exit(recorded == 0)


if __name__ == "__main__":
    main()
