"""VAMP's RRT-Connect and its simplifier, and then taut.

    pip install ./ipc/python -r examples/planners/requirements-vamp.txt
    python examples/planners/vamp_planner.py PROBLEM.json

VAMP is compiled for its robots (panda, ur5, fetch, baxter): the problem's columns must be the joints of one of them.
It plans with spheres, so a problem that has a `spherized_urdf` is compared on that, by coal and by taut. VAMP has no
cylinders: it takes capsules in their place, which are larger, as its own benchmark does.

The package `vamp-planner` is built from source: it needs git access to GitHub, a C++17 compiler, CMake and Eigen.
"""

import sys
import time

import numpy as np
import pinocchio as pin
import vamp

from comparison import NoPath, Planned, main
from problem import Refused, placement

NAME, SIMPLIFIER, SPHERES = "vamp", "simplify", True


def robot_of(problem):
    """The name of the robot that VAMP was compiled for whose joints a problem's columns are."""
    for name in vamp.robots:
        if list(getattr(vamp, name).joint_names()) == list(problem.columns):
            return name
    raise Refused(f"{problem.name}: its columns are the joints of none of VAMP's robots: {', '.join(vamp.robots)}")


def environment(problem):
    """A problem's scene as VAMP has it."""
    found = vamp.Environment()
    for item in problem.scene["objects"]:
        if item.get("meshes"):
            raise Refused(f"{problem.name}: object {item['id']!r} is a mesh; VAMP has none")
        for shape, pose in zip(item["primitives"], item["primitive_poses"]):
            place, size = placement(pose), shape["dimensions"]
            center = place.translation.tolist()
            turn = pin.rpy.matrixToRpy(place.rotation).tolist()
            if shape["type"] == "box":
                found.add_cuboid(vamp.Cuboid(center, turn, [side / 2 for side in size]))
            elif shape["type"] == "sphere":
                found.add_sphere(vamp.Sphere(center, size[0]))
            else:
                found.add_capsule(vamp.Cylinder(center, turn, size[1], size[0]))
    return found


def rows(path):
    """A path of VAMP's as rows."""
    return [np.array(path[index], float) for index in range(len(path))]


def plan(problem, start, goal, options):
    """A path of RRT-Connect from start to goal and what `simplify` makes of it."""
    robot, rrtc, settings, simplifying = vamp.configure_robot_and_planner_with_kwargs(robot_of(problem), "rrtc")
    scene = environment(problem)
    sampler = robot.halton()
    sampler.skip(options.seed * 1000)
    began = time.perf_counter()
    found = rrtc(list(map(float, start)), list(map(float, goal)), scene, settings, sampler)
    planned = time.perf_counter()
    if not found.solved:
        raise NoPath(f"VAMP's RRT-Connect found no path in {settings.max_iterations} iterations")
    simplified = time.perf_counter()
    shorter = robot.simplify(found.path, scene, simplifying, sampler)
    done = time.perf_counter()
    before, own = rows(found.path), rows(shorter.path)
    for ends in (before, own):
        ends[0], ends[-1] = start, goal  # VAMP computes in single precision
    return Planned(before, planned - began, own, done - simplified)


if __name__ == "__main__":
    main(__doc__, sys.modules[__name__])
