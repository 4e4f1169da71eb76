"""HPP's bi-RRT and one of its path optimizers, and then taut.

    pip install ./ipc/python -r examples/planners/requirements-hpp.txt
    python examples/planners/hpp_planner.py config/problems/arm_shelf.json

HPP validates continuously (`Dichotomy`), in C++, on the same URDF and scene. Its distance weighs
every joint with 1, so that it shortens what is measured here. Its bi-RRT ends edges where bodies
touch, and a path that touches cannot be proved free: the obstacles' boxes, cylinders and spheres are
larger by `--margin` for it.
"""

import ctypes
import os
import sys
import time
import xml.etree.ElementTree as xml
from pathlib import Path

import cmeel
import numpy as np
import pinocchio as pin

# The wheel's libraries do not say where they find each other: the loader must be told, before it starts.
LIBRARIES = str(Path(cmeel.__file__).parents[1] / "cmeel.prefix" / "lib")
if LIBRARIES not in os.environ.get("LD_LIBRARY_PATH", "").split(":"):
    os.environ["LD_LIBRARY_PATH"] = ":".join(filter(None, [LIBRARIES, os.environ.get("LD_LIBRARY_PATH")]))
    sys.stdout.flush()
    os.execv(sys.executable, sys.orig_argv)

import pyhpp.core as hpp  # noqa: E402
from pyhpp.pinocchio import Device  # noqa: E402
from pyhpp.pinocchio.urdf import loadModelFromString  # noqa: E402

from comparison import NoPath, Planned, main  # noqa: E402
from problem import Refused, placement  # noqa: E402

NAME, SIMPLIFIER, SPHERES = "hpp", "RandomShortcut", False
NO_SRDF = '<robot name="none"/>'


def device(problem, margin=0.0):
    """A problem's robot and scene as HPP has them, the scene larger by a margin (m) on every side."""
    robot = Device(problem.name)
    root = {None: "anchor", "planar": "planar", "floating": "freeflyer"}[problem.base]
    loadModelFromString(robot, 0, "", root, problem.urdf, problem.srdf or NO_SRDF, pin.SE3.Identity())
    if problem.scene["objects"]:
        scene = scene_urdf(problem, margin)
        loadModelFromString(robot, 0, "scene", "anchor", scene, NO_SRDF, pin.SE3.Identity())
    if problem.base:
        places, turns = (3, 4) if problem.base == "floating" else (2, 2)
        bounds = [limit for part in problem.parts[:places] for limit in (part.lower, part.upper)]
        robot.setJointBounds("root_joint", [float(bound) for bound in bounds] + [-1.01, 1.01] * turns)
    if len(robot.geomModel().collisionPairs) != len(problem.geometry.collisionPairs):
        raise Refused(f"{problem.name}: HPP checks other pairs than the problem says (its allowed_collisions)")
    return robot


def scene_urdf(problem, margin):
    """A problem's scene as the URDF of one fixed link, its primitives larger by a margin (m)."""
    robot = xml.Element("robot", name="scene")
    link = xml.SubElement(robot, "link", name="objects")

    def add(pose, kind, **sizes):
        solid = xml.SubElement(link, "collision")
        place = placement(pose)
        turn = pin.rpy.matrixToRpy(place.rotation)
        xml.SubElement(solid, "origin", xyz=numbers(place.translation), rpy=numbers(turn))
        xml.SubElement(xml.SubElement(solid, "geometry"), kind, **sizes)

    for item in problem.scene["objects"]:
        for shape, pose in zip(item.get("primitives", []), item.get("primitive_poses", [])):
            size = shape["dimensions"]
            if shape["type"] == "box":
                add(pose, "box", size=numbers(side + 2 * margin for side in size))
            elif shape["type"] == "sphere":
                add(pose, "sphere", radius=numbers([size[0] + margin]))
            else:
                add(pose, "cylinder", length=numbers([size[0] + 2 * margin]), radius=numbers([size[1] + margin]))
        for mesh, pose in zip(item.get("meshes", []), item.get("mesh_poses", [])):
            file = str((problem.folder / mesh["file"]).resolve())
            add(pose, "mesh", filename=file, scale=numbers(mesh.get("scale", [1, 1, 1])))
    return xml.tostring(robot, encoding="unicode")


def numbers(values):
    """Numbers as XML has them, to the last bit."""
    return " ".join(repr(float(value)) for value in values)


def rows(problem, path):
    """The waypoints of a path of HPP."""
    pieces = [path.pathAtRank(rank) for rank in range(path.numberPaths())]
    return [problem.row(np.array(pieces[0].initial()))] + [problem.row(np.array(piece.end())) for piece in pieces]


def plan(problem, start, goal, options):
    """A path of bi-RRT from start to goal and what `options.simplifier` makes of it."""
    ctypes.CDLL(None).srand(options.seed + 1)  # HPP draws from C's rand()
    robot = device(problem, options.margin)
    task = hpp.Problem(robot)
    task.clearConfigValidations()
    for validation in ("CollisionValidation", "JointBoundValidation"):
        task.addConfigValidation(validation)
    task.pathValidation(hpp.Dichotomy(robot, 0.0))
    distance = hpp.WeighedDistance(robot)
    distance.setWeights(np.ones_like(distance.getWeights()))
    task.distance(distance.asDistancePtr_t())
    task.steeringMethod(hpp.Straight(task))
    task.initConfig(problem.configuration(start))
    task.addGoalConfig(problem.configuration(goal))
    planner = hpp.BiRRTPlanner(task)
    planner.maxIterations(10_000_000)
    planner.timeOut(float(options.seconds))
    began = time.perf_counter()
    try:
        path = planner.solve()
    except RuntimeError as error:
        raise NoPath(f"HPP's bi-RRT found no path in {options.seconds} s: {error}") from None
    planned = time.perf_counter()
    before = rows(problem, path)
    optimizer = getattr(hpp, options.simplifier or SIMPLIFIER)(task)
    simplified = time.perf_counter()
    shortened = optimizer.optimize(path)
    done = time.perf_counter()
    own = rows(problem, shortened)
    for ends in (before, own):
        ends[0], ends[-1] = start, goal
    return Planned(before, planned - began, own, done - simplified)


if __name__ == "__main__":
    main(__doc__, sys.modules[__name__])
