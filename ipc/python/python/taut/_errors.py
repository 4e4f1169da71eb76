"""Exceptions. Each has the daemon's code, as MoveIt numbers them where MoveIt has one."""

from __future__ import annotations

from typing import Any, Dict, Optional, Sequence, Tuple, Type


class Error(Exception):
    """Anything that goes wrong; the subclasses say what.

    `str(error)` is one line: the bad value, the valid ones, the next step.
    """

    #: Number of the result code, such as -12.
    code: int
    #: Its name, such as ``GOAL_IN_COLLISION``.
    code_name: str
    #: One line for people.
    message: str
    #: When the same call may succeed, in seconds from now; None = never.
    retry_after: Optional[float]

    def __init__(
        self,
        message: str,
        code: int = -1008,
        code_name: str = "MALFORMED_REQUEST",
        retry_after: Optional[float] = None,
    ) -> None:
        super().__init__(message)
        self.message = message
        self.code = code
        self.code_name = code_name
        self.retry_after = retry_after

    def __reduce__(self) -> Tuple[Any, ...]:
        return (_again, (type(self), self.args, self.__dict__.copy()))


class _OnPath(Error):
    """Something about a place of the path."""

    #: What kind of thing the path must keep and does not: ``clearance``, the distance of two bodies; of a constraint
    #: ``orientation``, ``position`` or ``joint``.
    kind: Optional[str] = None
    #: What it is about: of a clearance the two bodies, of a constraint its name; empty where nothing is named.
    names: Tuple[str, ...] = ()
    #: Segment of the path, counted from 0.
    segment: Optional[int] = None
    #: Ratio on the segment, 0 to 1.
    t: Optional[float] = None
    #: How much is kept there: of a clearance the distance, below 0 the penetration depth, which is from below unless
    #: both bodies are convex; of a constraint what is left of its tolerance, below 0 how far it is outside.
    amount: Optional[float] = None
    #: The floor: how much must be kept.
    allowed: Optional[float] = None
    #: What both are counted in: ``m`` or ``rad``.
    unit: Optional[str] = None
    #: Where that is seen, world frame, in metres: of a clearance contact or closest points on the bodies.
    points: Tuple[Tuple[float, float, float], ...] = ()
    #: Unit vector along which the first point moves for more to be kept, world frame: of a clearance from the second
    #: body to the first.
    normal: Optional[Tuple[float, float, float]] = None


class InCollision(_OnPath):
    """The path collides: where, and which bodies."""


class OutsideConstraint(_OnPath):
    """The path is outside a constraint that it must keep: where, of which, and by how much."""


class NotProvable(_OnPath):
    """Nothing was found colliding, and the path cannot be proved free; where it is closest."""


class TimedOut(_OnPath):
    """The deadline passed before the path that was sent was proved."""


class Cancelled(Error):
    """The request was cancelled, or ended before the path was proved."""


class Overloaded(Error):
    """Not now: the daemon has no room, is still preparing what is asked about, or its sensors have not seen it lately enough;
    `retry_after` says when to ask again."""


class UnknownName(Error, LookupError):
    """No robot, scene, group, link or object of this name; the message lists those that there are."""


class VersionConflict(Error):
    """The scene has another version than was asked for, or a label names other content."""


class InvalidInput(Error, ValueError):
    """A path, an option or a file that is none."""


class UnreadableFile(Error):
    """A robot or scene file cannot be read."""


class ResourceExhausted(Error):
    """Too large, too many, or no memory left."""


class DaemonLost(Error, ConnectionError):
    """No daemon, or it went away; sending again is safe."""


class Crash(Error):
    """A defect: the worker panicked on this request. The daemon goes on."""


class Untimed(Error):
    """The path is proved, but has no times: the request ended before a trajectory was proved, or none is."""


_KINDS: Dict[int, Type[Error]] = {
    -2: InCollision,
    -3: InCollision,
    -10: InCollision,
    -11: OutsideConstraint,
    -12: InCollision,
    -13: OutsideConstraint,
    -6: TimedOut,
    -7: Cancelled,
    -15: UnknownName,
    -17: InvalidInput,
    -18: UnknownName,
    -19: UnknownName,
    -29: Crash,
    -1001: NotProvable,
    -1002: Overloaded,
    -1003: Overloaded,
    -1004: UnknownName,
    -1005: UnknownName,
    -1006: VersionConflict,
    -1007: ResourceExhausted,
    -1008: InvalidInput,
    -1009: DaemonLost,
    -1010: Overloaded,
    -1011: VersionConflict,
    -1012: InvalidInput,
    -1013: UnreadableFile,
    -1014: InvalidInput,
    -1015: Untimed,
    -1016: InvalidInput,
    -1017: Overloaded,
}


def of(
    code: int,
    code_name: str,
    message: str,
    retry_after: Optional[float],
    place: Optional[Dict[str, Any]],
) -> Error:
    """The exception for a code."""
    kind = _KINDS.get(code, Error)
    if kind is InCollision and place is not None and place["kind"] != "clearance":
        kind = OutsideConstraint
    error = kind(message, code, code_name, retry_after)
    if place is not None and isinstance(error, _OnPath):
        error.kind = place["kind"]
        error.names = tuple(place["names"])
        error.segment = place["segment"]
        error.t = place["t"]
        error.amount = place["amount"]
        error.allowed = place["allowed"]
        error.unit = place["unit"]
        error.points = tuple(_vector(point) for point in place["points"])
        error.normal = _vector(place["normal"])
    return error


def _again(kind: Type[Error], args: Tuple[Any, ...], state: Dict[str, Any]) -> Error:
    error = kind(*args)
    error.__dict__.update(state)
    return error


def _vector(numbers: Sequence[float]) -> Tuple[float, float, float]:
    x, y, z = numbers
    return (x, y, z)
