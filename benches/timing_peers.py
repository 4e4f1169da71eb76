#!/usr/bin/env python3
"""Other timers on taut's shortened paths, all judged by one evaluator of what ros2_control executes.

    python3 -m venv peers && peers/bin/pip install numpy==2.4.6 pin==4.1.0 coal==3.0.3 toppra==0.6.10 ruckig==0.19.4 \\
        sscbirrt==3.15.0 tesseract-robotics==0.5.1
    peers/bin/python benches/timing_peers.py FOLDER --named benches/timed_problems.txt --taut target/release/taut

FOLDER holds problem files. Each is shortened and timed by taut; the others time the same shortened path, each as its
documentation says, within the same limits (the URDF's velocities, 1 where it has none; accelerations of twice that
per second). A line for each: duration over the least that the motors need in an empty room, the largest part of a
velocity and of an acceleration limit on the executed curve, and samples in collision (pinocchio and coal, every
0.005 rad; "-" where they are not installed). A package that is not installed is left out, with a line that says so.
"""
import argparse
import json
import math
import multiprocessing
import os
import statistics
import subprocess
import tempfile
import xml.etree.ElementTree as ET

import numpy as np

STEP_RAD = 0.005
SAMPLE_S = 0.01
# Time that one of the others may take for a path.
MOST_S = 120


# --- What a controller executes: (time, positions, velocities, accelerations or None) at each point. ---

def coefficients(a, b):
    """joint_trajectory_controller's, constant term first."""
    h = b[0] - a[0]
    p, q, v, w = a[1], b[1], a[2], b[2]
    if a[3] is None or b[3] is None:
        square = (3 * (q - p) - (2 * v + w) * h) / h**2
        cube = (-2 * (q - p) + (v + w) * h) / h**3
        return h, [p, v, square, cube, 0 * p, 0 * p]
    k, l = a[3], b[3]
    third = (20 * (q - p) - (12 * v + 8 * w) * h - (3 * k - l) * h**2) / (2 * h**3)
    fourth = (-30 * (q - p) + (16 * v + 14 * w) * h + (3 * k - 2 * l) * h**2) / (2 * h**4)
    fifth = (12 * (q - p) - 6 * (v + w) * h - (k - l) * h**2) / (2 * h**5)
    return h, [p, v, k / 2, third, fourth, fifth]


def executed(points):
    """Positions no farther apart than STEP_RAD, and the largest velocities and accelerations."""
    rows, velocity, acceleration = [], 0.0, 0.0
    for a, b in zip(points, points[1:]):
        h, c = coefficients(a, b)
        for t in np.linspace(0, h, 21):
            velocity = np.maximum(velocity, abs(sum(k * c[k] * t**(k - 1) for k in range(1, 6))))
            acceleration = np.maximum(acceleration, abs(sum(k * (k - 1) * c[k] * t**(k - 2) for k in range(2, 6))))
        far = np.max(abs(a[2]) + abs(b[2])) * h + np.max(abs(b[1] - a[1]))
        count = max(2, math.ceil(far / STEP_RAD))
        rows += [sum(c[k] * t**k for k in range(6)) for t in np.linspace(0, h, count, endpoint=False)]
    return rows + [points[-1][1]], velocity, acceleration


def bound(step, velocity, acceleration):
    """The least time from rest to rest of the joint that needs most."""
    times = [d / v + v / a if d > v * v / a else 2 * math.sqrt(d / a) for d, v, a in zip(abs(step), velocity, acceleration)]
    return max(times)


# --- Collisions by pinocchio and coal. ---

class World:
    """A problem's robot among its obstacles; primitives, and meshes as pinocchio reads them."""

    def __init__(self, file, geometry):
        import coal
        import pinocchio as pin
        self.pin = pin
        problem = json.load(open(file))
        here = os.path.dirname(os.path.abspath(file))
        robot = problem["robot"]
        has_spheres = geometry == "spheres"
        urdf = os.path.join(here, robot["spherized_urdf"] if has_spheres else robot["urdf"])
        if robot.get("virtual_joint"):
            raise NotImplementedError("virtual joint")
        folders = [os.path.dirname(os.path.normpath(os.path.join(here, folder))) for folder in robot["packages"].values()]
        self.model = pin.buildModelFromUrdf(urdf)
        self.geometry = pin.buildGeomFromUrdf(self.model, urdf, pin.GeometryType.COLLISION,
                                              package_dirs=folders + [os.path.dirname(urdf)])
        bodies = self.geometry.ngeoms
        self.geometry.addAllCollisionPairs()
        if robot.get("srdf"):
            pin.removeCollisionPairs(self.model, self.geometry, os.path.join(here, robot["srdf"]), False)
        allowed = robot.get("allowed_collisions", []) + (robot.get("spherized_allowed_collisions", []) if has_spheres else [])
        allowed = {frozenset(pair) for pair in allowed}
        link = lambda index: self.geometry.geometryObjects[index].name.rsplit("_", 1)[0]
        for pair in list(self.geometry.collisionPairs):
            if frozenset((link(pair.first), link(pair.second))) in allowed:
                self.geometry.removeCollisionPair(pair)
        shapes = {"box": lambda d: coal.Box(*d), "sphere": lambda d: coal.Sphere(d[0]),
                  "cylinder": lambda d: coal.Cylinder(d[1], d[0])}
        for thing in problem["scene"]["objects"]:
            if thing.get("meshes"):
                raise NotImplementedError("meshes among the obstacles")
            for shape, pose in zip(thing.get("primitives", []), thing.get("primitive_poses", [])):
                turn = pose["orientation"]
                place = pin.SE3(pin.Quaternion(turn["w"], turn["x"], turn["y"], turn["z"]).matrix(), np.array(pose["position"], float))
                solid = pin.GeometryObject(thing["id"], 0, 0, place, shapes[shape["type"]](shape["dimensions"]))
                index = self.geometry.addGeometryObject(solid)
                for body in range(bodies):
                    if self.geometry.geometryObjects[body].parentJoint != 0:
                        self.geometry.addCollisionPair(pin.CollisionPair(body, index))
        self.data, self.pairs = self.model.createData(), pin.GeometryData(self.geometry)
        self.columns = [(self.model.idx_qs[self.model.getJointId(name)], self.model.nqs[self.model.getJointId(name)])
                        for name in problem["variables"]]

    def collides(self, row):
        q = self.pin.neutral(self.model)
        for value, (index, width) in zip(row, self.columns):
            q[index:index + width] = [value] if width == 1 else [math.cos(value), math.sin(value)]
        return self.pin.computeCollisions(self.model, self.data, self.geometry, self.pairs, q, True)


# --- The others. Each takes rows and limits and gives points. ---

def toppra_with(parametrizer):
    def run(rows, velocity, acceleration, world):
        import toppra
        import toppra.algorithm
        import toppra.constraint
        toppra.setup_logging("ERROR")
        length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(rows, axis=0), axis=1))])
        path = toppra.SplineInterpolator(length, rows)
        limits = [toppra.constraint.JointVelocityConstraint(np.stack([-velocity, velocity], 1)),
                  toppra.constraint.JointAccelerationConstraint(np.stack([-acceleration, acceleration], 1))]
        found = toppra.algorithm.TOPPRA(limits, path, parametrizer=parametrizer).compute_trajectory(0, 0)
        times = np.append(np.arange(0, found.duration - 1e-3, SAMPLE_S), found.duration)
        return [(t, found(t), found(t, 1), None) for t in times]
    return run


def ruckig_stops(rows, velocity, acceleration, world):
    import ruckig
    points, start = [], 0.0
    machine = ruckig.Ruckig(rows.shape[1])
    for a, b in zip(rows, rows[1:]):
        wanted, found = ruckig.InputParameter(rows.shape[1]), ruckig.Trajectory(rows.shape[1])
        wanted.current_position, wanted.target_position = list(a), list(b)
        wanted.max_velocity, wanted.max_acceleration = list(velocity), list(acceleration)
        wanted.max_jerk = list(10 * acceleration)
        wanted.synchronization = ruckig.Synchronization.Phase
        machine.calculate(wanted, found)
        for t in np.append(np.arange(0, found.duration - 1e-3, SAMPLE_S), found.duration)[1 if points else 0:]:
            points.append((start + t, *(np.array(x) for x in found.at_time(t)[:3])))
        start += found.duration
    return points


def tesseract_totg(rows, velocity, acceleration, world):
    from tesseract_robotics.tesseract_command_language import (
        CompositeInstruction, MoveInstruction, MoveInstructionType_FREESPACE, StateWaypoint, StateWaypointPoly_wrap_StateWaypoint,
        InstructionPoly_as_MoveInstructionPoly, MoveInstructionPoly_wrap_MoveInstruction, WaypointPoly_as_StateWaypointPoly)
    from tesseract_robotics.tesseract_time_parameterization import InstructionsTrajectory, TimeOptimalTrajectoryGeneration
    names = [f"joint{column}" for column in range(rows.shape[1])]
    program = CompositeInstruction()
    for row in rows:
        waypoint = StateWaypointPoly_wrap_StateWaypoint(StateWaypoint(names, np.array(row)))
        move = MoveInstruction(waypoint, MoveInstructionType_FREESPACE)
        program.appendMoveInstruction(MoveInstructionPoly_wrap_MoveInstruction(move))
    way = InstructionsTrajectory(program)
    two_sided = lambda most: np.stack([-most, most], 1)
    if not TimeOptimalTrajectoryGeneration(0.1, 0.001).compute(way, two_sided(velocity), two_sided(acceleration), two_sided(10 * acceleration)):
        raise RuntimeError("it says no")
    points = []
    instructions = program.getInstructions()
    for index in range(len(instructions)):
        # Each has a name: what a temporary refers to may be gone.
        instruction = instructions[index]
        move = InstructionPoly_as_MoveInstructionPoly(instruction)
        waypoint = move.getWaypoint()
        said = WaypointPoly_as_StateWaypointPoly(waypoint)
        lists = [said.getPosition(), said.getVelocity(), said.getAcceleration()]
        points.append((said.getTime(), *(np.array(values, float).reshape(-1) for values in lists)))
    return points


def sscbirrt_shortcuts(rows, velocity, acceleration, world):
    from types import SimpleNamespace
    from sscbirrt import trajectory
    if world is None:
        raise RuntimeError("it needs pinocchio and coal to ask about collisions")
    chord = lambda a, b: SimpleNamespace(reached=not world.collides(b), configs=[b])
    options = trajectory.TrajectoryOptions(velocity_limits=velocity, acceleration_limits=acceleration)
    found = trajectory.shortcut(trajectory.initial_trajectory(list(rows), velocity, acceleration),
                                motion_validator=SimpleNamespace(validate=chord),
                                admissible=lambda q: (not world.collides(q), "collision"), resolution=0.05, options=options)
    # Where an acceleration switches there is a point, so that cubics are what it planned.
    times = {0.0}
    start = 0.0
    for piece in found.pieces:
        for ramp in piece.ramps:
            times |= set(start + np.cumsum([0.0] + [duration for duration, _ in ramp.pieces]))
        start += piece.duration
    times = sorted(times)
    times = [t for t, next in zip(times, times[1:] + [math.inf]) if next - t > 1e-6]
    return [(t, *found.state(min(t, found.duration))[:2], None) for t in times]


PEERS = {
    "toppra, spline, ParametrizeSpline": toppra_with("ParametrizeSpline"),
    "toppra, spline, ParametrizeConstAccel": toppra_with("ParametrizeConstAccel"),
    "ruckig, full stops": ruckig_stops,
    "tesseract, TOTG, tolerance 0.1": tesseract_totg,
    "sscbirrt, shortcuts": sscbirrt_shortcuts,
}


# --- Ours, and the run. ---

def velocities(file, geometry, names):
    robot = json.load(open(file))["robot"]
    urdf = robot.get("spherized_urdf", robot["urdf"]) if geometry == "spheres" else robot["urdf"]
    root = ET.parse(os.path.join(os.path.dirname(file), urdf)).getroot()
    said = {joint.get("name"): float(limit.get("velocity") or 0) for joint in root.findall("joint")
            for limit in joint.findall("limit")}
    return np.array([said.get(name) or 1.0 for name in names])


def taut(program, *arguments):
    run = subprocess.run([program, *arguments], capture_output=True, text=True)
    if run.returncode:
        raise RuntimeError((run.stderr or run.stdout).strip()[-300:])
    return run.stdout


def ours(program, file, geometry, folder):
    path, limits = os.path.join(folder, "path.json"), os.path.join(folder, "limits.yaml")
    taut(program, "shorten", file, "--local", "--budget", "1000000", "--geometry", geometry, "--format", "json", "-o", path)
    table = json.load(open(path))
    velocity = velocities(file, geometry, table["variables"])
    rows = [f'  "{name}": {{has_velocity_limits: true, max_velocity: {most}}}' for name, most in zip(table["variables"], velocity)]
    open(limits, "w").write("joint_limits:\n" + "\n".join(rows) + "\n")
    found = json.loads(taut(program, "time", path, "--problem", file, "--geometry", geometry, "--limits", limits,
                            "--acceleration", "2/s", "--format", "json"))
    seconds = lambda time: time["sec"] + time["nanosec"] / 1e9
    points = [(seconds(p["time_from_start"]), np.array(p["positions"]), np.array(p["velocities"]), None) for p in found["points"]]
    return np.array(table["path"]), velocity, points


def judged(points, velocity, acceleration, least, world):
    rows, fastest, hardest = executed(points)
    hits = None if world is None else sum(world.collides(row) for row in rows)
    return points[-1][0] / least, np.max(fastest / velocity), np.max(hardest / acceleration), hits


def apart(run, *given):
    """In a process of its own, for it may crash or never end."""
    here, there = multiprocessing.Pipe(False)

    def work():
        try:
            there.send(run(*given))
        except Exception as error:  # whatever another program says is a result
            there.send(f"{type(error).__name__}: {str(error)[:200]}")

    process = multiprocessing.get_context("fork").Process(target=work)
    process.start()
    there.close()
    try:
        found = here.recv() if here.poll(MOST_S) else f"no answer in {MOST_S} s"
    except EOFError:
        process.join()
        found = f"it ended with {process.exitcode}"
    process.kill()
    process.join()
    if isinstance(found, str):
        raise RuntimeError(found)
    return found


def told(name, found):
    ratio, velocity, acceleration, hits = found
    print(f"    {name:<40} T/LB {ratio:6.3f}   velocity {velocity:8.4f}   acceleration {acceleration:8.4f}   "
          f"in collision {'-' if hits is None else hits}", flush=True)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("folder")
    arguments.add_argument("--named", required=True)
    arguments.add_argument("--taut", default="taut")
    arguments.add_argument("--limit", type=int)
    given = arguments.parse_args()
    lines = [line.split() for line in open(given.named) if line.strip() and not line.startswith("#")]
    all_found = {}
    for name, *geometry in lines[:given.limit]:
        geometry = (geometry or ["given"])[0]
        file = os.path.join(given.folder, name + ".json")
        print(name, geometry, flush=True)
        try:
            world = World(file, geometry)
        except (ImportError, NotImplementedError) as error:
            print(f"    no look at collisions: {error}")
            world = None
        with tempfile.TemporaryDirectory() as folder:
            try:
                rows, velocity, points = ours(given.taut, file, geometry, folder)
            except RuntimeError as error:
                print(f"    taut: {error}")
                continue
        acceleration = 2 * velocity
        least = bound(rows[-1] - rows[0], velocity, acceleration)
        found = {"taut time": judged(points, velocity, acceleration, least, world)}
        told("taut time", found["taut time"])
        for peer, run in PEERS.items():
            try:
                points = apart(run, rows, velocity, acceleration, world)
                found[peer] = judged(points, velocity, acceleration, least, world)
                told(peer, found[peer])
            except RuntimeError as error:
                print(f"    {peer:<40} {error}", flush=True)
        for peer, figures in found.items():
            all_found.setdefault(peer, []).append(figures)
    print()
    for peer, figures in all_found.items():
        ratios = [figure[0] for figure in figures]
        print(f"{peer:<44} {len(figures)} ran, T/LB median {statistics.median(ratios):.3f}, mean {statistics.mean(ratios):.3f}; "
              f"{sum(max(figure[1], figure[2]) > 1.02 for figure in figures)} beyond limits by more than 2 %, "
              f"{sum(bool(figure[3]) for figure in figures)} in collision")


if __name__ == "__main__":
    main()
