"""Pulls planners' paths taut, and proves every answer collision-free.

>>> import taut
>>> with taut.local() as d:                      # or taut.connect(), where a daemon runs
...     problem = d.load_problem(PROBLEMS + "/rooms.json")
...     for best in d.shorten(problem.path, problem.robot, problem.scene, budget=2000):
...         assert best.proved and best.length <= best.length_before
"""

from ._answers import Answers, Check, Corridor, Improvement, Result
from ._constraints import InBall, InBox, InCylinder, JointWithin, Oriented, Upright
from ._errors import (
    Cancelled,
    Crash,
    DaemonLost,
    Error,
    InCollision,
    InvalidInput,
    NotProvable,
    OutsideConstraint,
    Overloaded,
    ResourceExhausted,
    TimedOut,
    UnknownName,
    UnreadableFile,
    Untimed,
    VersionConflict,
)
from ._planner import Planner, Problem, Robot, Variable, Watch, connect, local
from ._scene import Frame, Scene, SceneChange, SceneChanges, SceneVersion, Sensed, Snapshot
from ._timing import Motor, Nearest, Times, Trajectory

__all__ = [
    "Answers",
    "Cancelled",
    "Check",
    "Corridor",
    "Crash",
    "DaemonLost",
    "Error",
    "Frame",
    "Improvement",
    "InBall",
    "InBox",
    "InCollision",
    "InCylinder",
    "InvalidInput",
    "JointWithin",
    "Motor",
    "Nearest",
    "NotProvable",
    "Oriented",
    "OutsideConstraint",
    "Overloaded",
    "Planner",
    "Problem",
    "ResourceExhausted",
    "Result",
    "Robot",
    "Scene",
    "SceneChange",
    "SceneChanges",
    "SceneVersion",
    "Sensed",
    "Snapshot",
    "TimedOut",
    "Times",
    "Trajectory",
    "UnknownName",
    "UnreadableFile",
    "Untimed",
    "Upright",
    "Variable",
    "VersionConflict",
    "Watch",
    "connect",
    "local",
]
