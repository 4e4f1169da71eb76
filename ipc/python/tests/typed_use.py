"""Calls that a type checker takes as they are meant."""

from typing import Mapping, Sequence, Union

import numpy as np

import taut

MESSAGE: Mapping[str, object] = {"name": "cup", "orientation_constraints": []}
EVERY: Sequence[Union[taut.Upright, taut.InBox, taut.JointWithin]] = [
    taut.Upright("hand", axis="-z", within=0.1, against="start"),
    taut.InBox("hand", size=(1, 1, 1), at=(0, 0, 0.5), frame="table"),
    taut.JointWithin("elbow", 0.0, below=0.1, above=0.2),
]


def use(planner: taut.Planner, path: "np.typing.NDArray[np.float64]") -> float:
    """Each way to say what is kept."""
    planner.check(path, "robot", constraints=taut.Oriented("hand", (0, 0, 0, 1), within=(0.1, 0.1, 3.2)))
    planner.check(path, "robot", constraints=[*EVERY, MESSAGE, "upright hand:x=0.1"])
    planner.watch(path, "robot", "scene", constraints=taut.InBall("hand", 0.1, (0, 0, 0)))
    try:
        return planner.shorten(path, "robot", constraints=taut.InCylinder("hand", 0.1, 1, (0, 0, 0))).result().length
    except taut.OutsideConstraint as error:
        return error.amount or 0.0
