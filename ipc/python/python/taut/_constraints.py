"""What a path must keep besides clearance, in few words or as MoveIt has it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple, Union

from ._errors import InvalidInput

#: x y z (metres), in the frame that is named with it.
Point = Tuple[float, float, float]

_AXES: Mapping[str, Point] = {
    sign + name: (direction[0] * factor, direction[1] * factor, direction[2] * factor)
    for sign, factor in (("", 1.0), ("+", 1.0), ("-", -1.0))
    for name, direction in (("x", (1.0, 0.0, 0.0)), ("y", (0.0, 1.0, 0.0)), ("z", (0.0, 0.0, 1.0)))
}


def _axis(axis: Union[str, Point]) -> List[float]:
    if not isinstance(axis, str):
        return [float(number) for number in axis]
    if axis not in _AXES:
        raise InvalidInput(f"axis {axis!r}; valid: {', '.join(sorted(_AXES))}, or a direction (x, y, z)")
    return list(_AXES[axis])


@dataclass(frozen=True)
class Upright:
    """A direction of a link stays within an angle of another direction: a full cup, a welding torch."""

    #: The link, or an attached object.
    link: str
    #: Its axis: "x", "-z", or a direction in its frame.
    axis: Union[str, Point] = "z"
    #: The angle (rad), up to π/2.
    within: float = 0.1
    #: What it is compared with, in `frame`: a direction, or "start": where the axis points at the first waypoint.
    against: Union[str, Point] = (0.0, 0.0, 1.0)
    #: A link or a frame of the scene; empty = the world.
    frame: str = ""

    def message(self) -> Dict[str, Any]:
        """As `path_constraints` have it."""
        is_start = isinstance(self.against, str) and self.against == "start"
        against = "start" if is_start else _axis(self.against)
        tilt = {
            "header": {"frame_id": self.frame},
            "link_name": self.link,
            "axis": _axis(self.axis),
            "reference": against,
            "tolerance_rad": float(self.within),
        }
        return {"name": "upright", "orientation_constraints": [tilt]}


@dataclass(frozen=True)
class Oriented:
    """A link stays turned as it is asked, within MoveIt's tolerances: XYZ Euler angles of the difference."""

    #: The link, or an attached object.
    link: str
    #: How it is to be turned in `frame`: x y z w.
    orientation: Tuple[float, float, float, float]
    #: Tolerances about x, y and z (rad); π = free.
    within: Point
    #: A link or a frame of the scene; empty = the world.
    frame: str = ""

    def message(self) -> Dict[str, Any]:
        """As `path_constraints` have it."""
        x, y, z = self.within
        if len(self.orientation) != 4:
            raise InvalidInput(f"orientation {self.orientation!r}; valid: four numbers, x y z w")
        euler = {
            "header": {"frame_id": self.frame},
            "link_name": self.link,
            "orientation": dict(zip("xyzw", map(float, self.orientation))),
            "absolute_x_axis_tolerance": float(x),
            "absolute_y_axis_tolerance": float(y),
            "absolute_z_axis_tolerance": float(z),
        }
        return {"orientation_constraints": [euler]}


def _position(link: str, point: Point, frame: str, shape: str, sizes: Sequence[float], at: Point) -> Dict[str, Any]:
    region = {
        "primitives": [{"type": shape, "dimensions": [float(size) for size in sizes]}],
        "primitive_poses": [{"position": [float(number) for number in at]}],
    }
    position = {
        "header": {"frame_id": frame},
        "link_name": link,
        "target_point_offset": [float(number) for number in point],
        "constraint_region": region,
    }
    return {"position_constraints": [position]}


@dataclass(frozen=True)
class InBox:
    """A point of a link stays in a box along the axes of a frame."""

    #: The link, or an attached object.
    link: str
    #: Whole extents along x, y and z (m).
    size: Point
    #: Centre of the box, in `frame` (m).
    at: Point
    #: The point, in the link's frame (m).
    point: Point = (0.0, 0.0, 0.0)
    #: A link or a frame of the scene; empty = the world.
    frame: str = ""

    def message(self) -> Dict[str, Any]:
        """As `path_constraints` have it."""
        return _position(self.link, self.point, self.frame, "box", self.size, self.at)


@dataclass(frozen=True)
class InBall:
    """A point of a link stays in a ball."""

    #: The link, or an attached object.
    link: str
    #: Radius (m).
    radius: float
    #: Centre, in `frame` (m).
    at: Point
    #: The point, in the link's frame (m).
    point: Point = (0.0, 0.0, 0.0)
    #: A link or a frame of the scene; empty = the world.
    frame: str = ""

    def message(self) -> Dict[str, Any]:
        """As `path_constraints` have it."""
        return _position(self.link, self.point, self.frame, "sphere", [self.radius], self.at)


@dataclass(frozen=True)
class InCylinder:
    """A point of a link stays in a cylinder along z of a frame."""

    #: The link, or an attached object.
    link: str
    #: Radius (m).
    radius: float
    #: Whole length (m).
    length: float
    #: Centre, in `frame` (m).
    at: Point
    #: The point, in the link's frame (m).
    point: Point = (0.0, 0.0, 0.0)
    #: A link or a frame of the scene; empty = the world.
    frame: str = ""

    def message(self) -> Dict[str, Any]:
        """As `path_constraints` have it."""
        return _position(self.link, self.point, self.frame, "cylinder", [self.length, self.radius], self.at)


@dataclass(frozen=True)
class JointWithin:
    """A joint stays near a value."""

    #: Its name.
    joint: str
    #: The value (rad or m).
    value: float
    #: How far it may be below it.
    below: float
    #: How far above it.
    above: float

    def message(self) -> Dict[str, Any]:
        """As `path_constraints` have it."""
        joint = {
            "joint_name": self.joint,
            "position": float(self.value),
            "tolerance_below": float(self.below),
            "tolerance_above": float(self.above),
        }
        return {"joint_constraints": [joint]}


#: One thing to keep: of these classes, MoveIt's `Constraints` as a dictionary, or a text: its JSON or few words.
Constraint = Union[Upright, Oriented, InBox, InBall, InCylinder, JointWithin, Mapping[str, Any], str]
#: One thing to keep, or several: all of them must hold.
Constraints = Union[Constraint, Sequence[Constraint]]

_TYPES = (Upright, Oriented, InBox, InBall, InCylinder, JointWithin)


def constraints_text(constraints: Optional[Constraints]) -> Optional[str]:
    """The text that a request carries."""
    if constraints is None or isinstance(constraints, str):
        return constraints
    try:
        several = [constraints] if isinstance(constraints, (Mapping, *_TYPES)) else list(constraints)
        return json.dumps([_message(one) for one in several], allow_nan=False)
    except InvalidInput:
        raise
    except (TypeError, ValueError) as error:
        raise InvalidInput(f"constraints {constraints!r} cannot be sent: {error}") from None


def _message(one: Constraint) -> Any:
    if isinstance(one, _TYPES):
        return one.message()
    if isinstance(one, Mapping):
        return dict(one)
    if isinstance(one, str):
        return json.loads(one) if one.lstrip().startswith(("{", "[")) else one
    valid = ", ".join(kind.__name__ for kind in _TYPES)
    raise InvalidInput(f"{one!r} is no constraint; valid: {valid}, MoveIt's Constraints as a dictionary, or a text")
