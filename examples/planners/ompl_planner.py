"""OMPL's RRT-Connect and its path simplifier, and then taut.

    pip install ./ipc/python -r examples/planners/requirements-ompl.txt
    python examples/planners/ompl_planner.py config/problems/arm_shelf.json

OMPL's validity check is what its users write: the robot's URDF and the scene in pinocchio and coal,
one configuration at a time, along a motion every `--resolution` of the space's extent (OMPL's own
default is 0.01, MoveIt's 0.005).
"""

import functools
import math
import sys
import time

import numpy as np
import ompl.base as ob
import ompl.geometric as og
import ompl.util as ou

from comparison import NoPath, Planned, main

NAME, SIMPLIFIER, SPHERES = "ompl", "simplifyMax", False


class Space:
    """A problem's columns as an OMPL state space: numbers first, then angles, then rotations."""

    def __init__(self, problem):
        numbers = [part for part in problem.parts if part.kind == "number"]
        turns = [part for part in problem.parts if part.kind != "number"]
        bounds = ob.RealVectorBounds(len(numbers))
        for index, part in enumerate(numbers):
            bounds.setLow(index, float(part.lower))
            bounds.setHigh(index, float(part.upper))
        reals = ob.RealVectorStateSpace(len(numbers))
        reals.setBounds(bounds)
        self.numbers = [part.column for part in numbers]
        self.turns = [(part.column, part.kind == "rotation") for part in turns]
        self.width = len(problem.columns)
        self.space = ob.CompoundStateSpace() if turns else reals
        if turns:
            self.space.addSubspace(reals, 1.0)
            for _, rotation in self.turns:
                self.space.addSubspace(ob.SO3StateSpace() if rotation else ob.SO2StateSpace(), 1.0)

    def state(self, row):
        """A row as a state."""
        state = self.space.allocState()
        reals = state[0] if self.turns else state
        for index, column in enumerate(self.numbers):
            reals[index] = float(row[column])
        for index, (column, rotation) in enumerate(self.turns, 1):
            turn = state[index]
            if rotation:
                turn.x, turn.y, turn.z, turn.w = map(float, row[column : column + 4])
            else:
                turn.value = math.remainder(row[column], 2 * math.pi)
        return state

    def row(self, state):
        """A state as a row."""
        row = np.zeros(self.width)
        reals = state[0] if self.turns else state
        for index, column in enumerate(self.numbers):
            row[column] = reals[index]
        for index, (column, rotation) in enumerate(self.turns, 1):
            turn = state[index]
            if rotation:
                row[column : column + 4] = turn.x, turn.y, turn.z, turn.w
            else:
                row[column] = turn.value
        return row


@functools.cache
def seed(number):
    """Seeds OMPL's random numbers, which it allows once in a process."""
    ou.RNG.setSeed(number + 1)


def plan(problem, start, goal, options):
    """A path of RRT-Connect from start to goal and what `simplifyMax` makes of it."""
    ou.setLogLevel(ou.LogLevel.LOG_ERROR)
    seed(options.seed)
    space = Space(problem)
    setup = og.SimpleSetup(space.space)
    information = setup.getSpaceInformation()
    setup.setStateValidityChecker(
        lambda state: space.space.satisfiesBounds(state) and problem.free(problem.configuration(space.row(state)))
    )
    information.setStateValidityCheckingResolution(options.resolution)
    setup.setStartAndGoalStates(space.state(start), space.state(goal))
    setup.setPlanner(og.RRTConnect(information))
    began = time.perf_counter()
    if not setup.solve(options.seconds) or not setup.haveExactSolutionPath():
        raise NoPath(f"OMPL's RRT-Connect found no path in {options.seconds} s")
    planned = time.perf_counter()
    path = setup.getSolutionPath()
    before = [space.row(state) for state in path.getStates()]
    before[0], before[-1] = start, goal
    simplified = time.perf_counter()
    og.PathSimplifier(information).simplifyMax(path)
    done = time.perf_counter()
    own = [space.row(state) for state in path.getStates()]
    own[0], own[-1] = start, goal
    return Planned(before, planned - began, own, done - simplified)


if __name__ == "__main__":
    main(__doc__, sys.modules[__name__])
