"""Times: what is asked of a trajectory, and trajectories."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Tuple, Union

import numpy as np
import numpy.typing as npt

from ._errors import InvalidInput

#: Limits of joints: the file or the content of MoveIt's joint_limits.yaml as a mapping, by joints.
Limits = Union[str, "PathLike[str]", Mapping[str, Mapping[str, Any]]]


@dataclass(frozen=True)
class Times:
    """What a trajectory is to be: ``shorten(..., timing=Times(acceleration="2/s"))``."""

    #: Greatest acceleration of joints of which `limits` say none: "2/s" is twice the velocity limit per second, 1.5 so
    #: many rad/s² or m/s².
    acceleration: Optional[Union[str, float]] = None
    #: Limits of joints, a file or a mapping, as in MoveIt's joint_limits.yaml; what they do not say of velocities, the
    #: robot's URDF does.
    limits: Optional[Limits] = None
    #: Part of full speed, above 0 and up to 1.
    speed: float = 1.0
    #: How fast joints move at the start (rad/s or m/s); the others stand still.
    start_velocity: Mapping[str, float] = field(default_factory=dict)
    #: What goes from point to point: "cubic", "quintic", or "linear@100" (points per second).
    controller: str = "cubic"
    #: Clearance to keep where it is executed, in metres; None = that of the path.
    clearance: Optional[float] = None
    #: Work after which nothing faster is looked for; None = enough for most paths.
    work: Optional[int] = None

    def text(self) -> str:
        """The text that a request carries."""
        words: Dict[str, Any] = {"speed": float(self.speed), "controller": self.controller}
        if isinstance(self.limits, Mapping):
            words["joint_limits"] = {joint: dict(own) for joint, own in self.limits.items()}
        elif self.limits is not None:
            words["file"] = str(self.limits)
            words["content"] = Path(self.limits).read_text(encoding="utf-8")
        if self.acceleration is not None:
            is_text = isinstance(self.acceleration, str)
            words["acceleration"] = self.acceleration if is_text else float(self.acceleration)
        if self.start_velocity:
            words["start_velocity"] = {joint: float(velocity) for joint, velocity in self.start_velocity.items()}
        if self.clearance is not None:
            words["clearance"] = float(self.clearance)
        if self.work is not None:
            words["work"] = int(self.work)
        return json.dumps(words, allow_nan=False)


#: What a trajectory is to be: `Times`, or a text: MoveIt's joint_limits.yaml with our words beside it, or few words such
#: as ``acceleration=2/s speed=0.5``.
Timing = Union[Times, str]


def timing_text(timing: Optional[Timing]) -> Optional[str]:
    """The text that a request carries."""
    if timing is None or isinstance(timing, str):
        return timing
    if not isinstance(timing, Times):
        raise InvalidInput(f"timing {timing!r}; valid: taut.Times(...), or a text such as 'acceleration=2/s'")
    try:
        return timing.text()
    except (TypeError, ValueError) as error:
        raise InvalidInput(f"timing {timing!r} cannot be sent: {error}") from None


@dataclass(frozen=True)
class Motor:
    """What a joint was allowed, and the largest part of it that is used."""

    #: Least and greatest velocity (per s).
    velocity: Tuple[float, float]
    #: Least and greatest acceleration (per s²).
    acceleration: Tuple[float, float]
    #: Largest part of a limit of velocity; 1 is all of it.
    velocity_used: float
    #: When (s).
    velocity_time: float
    #: Largest part of a limit of acceleration.
    acceleration_used: float
    #: When (s).
    acceleration_time: float


@dataclass(frozen=True)
class Nearest:
    """Where in time a trajectory comes nearest to anything."""

    #: When (s).
    time: float
    #: The two bodies.
    names: Tuple[str, ...]
    #: Their distance (m).
    distance: float
    #: The closest points, in the world (m).
    points: Tuple[Tuple[float, float, float], ...]


@dataclass(frozen=True, eq=False)
class Trajectory:
    """When what is to be where: proved as it is written, at every instant between its points too."""

    #: Names of the columns.
    joint_names: List[str]
    #: When each point is passed, in nanoseconds from the start.
    times_ns: npt.NDArray[np.int64]
    #: A row of positions for each point (rad or m).
    positions: npt.NDArray[np.float64]
    #: The same of velocities; None where the controller goes straight.
    velocities: Optional[npt.NDArray[np.float64]]
    #: The same of accelerations; None where a controller that had them would go another way.
    accelerations: Optional[npt.NDArray[np.float64]]
    #: What goes from point to point: cubic, quintic, linear.
    controller: str
    #: Points per second of a linear one.
    rate: Optional[float]
    #: From the first point to the last (s).
    duration: float
    #: No trajectory between the same ends within the same limits takes less (s).
    bound: float
    #: By which part of the bound it takes longer.
    gap: float
    #: The joint whose motor needs the time of the bound; None where it is none of the request's.
    decides: Optional[str]
    #: What the first trajectory that was proved takes, which stops where it must (s).
    stops: float
    #: What it comes of: stops, rounded, shortcuts.
    stage: str
    #: Clearance that is proved at every instant (m); infinite where nothing is near.
    clearance: float
    #: What each joint was allowed, and uses.
    motors: Dict[str, Motor]
    #: Where it comes nearest to anything; None where nothing was found or looked for.
    nearest: Optional[Nearest]

    @property
    def times(self) -> npt.NDArray[np.float64]:
        """When each point is passed, in seconds from the start."""
        return np.multiply(self.times_ns, 1e-9, dtype=np.float64)

    def __len__(self) -> int:
        return len(self.times_ns)

    def to_joint_trajectory(self) -> Dict[str, Any]:
        """As ROS's `trajectory_msgs/JointTrajectory`, a dictionary: give the controller these points as they are, and it
        goes where it was proved."""
        points = []
        for index, ns in enumerate(self.times_ns.tolist()):
            point: Dict[str, Any] = {"positions": self.positions[index].tolist()}
            if self.velocities is not None:
                point["velocities"] = self.velocities[index].tolist()
            if self.accelerations is not None:
                point["accelerations"] = self.accelerations[index].tolist()
            point["time_from_start"] = {"sec": ns // 10**9, "nanosec": ns % 10**9}
            points.append(point)
        return {"joint_names": list(self.joint_names), "points": points}

    def __repr__(self) -> str:
        return f"<Trajectory {len(self)} points, {self.duration:.3f} s, gap {100 * self.gap:.1f} %>"


def trajectory_of(found: Dict[str, Any]) -> Trajectory:
    """What the Rust half says."""
    names = found.pop("joint_names")
    motors = {name: Motor(*own) for name, own in zip(names, found.pop("motors"))}
    nearest = found.pop("nearest")
    return Trajectory(joint_names=names, motors=motors, nearest=nearest and Nearest(*nearest), **found)
