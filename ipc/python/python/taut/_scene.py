"""Scenes that live: versions, changes, snapshots."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass
from os import PathLike, fspath
from typing import Any, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from . import _taut
from ._errors import InvalidInput

File = Union[str, "PathLike[str]"]
#: x y z, or x y z qx qy qz qw (metres, unit quaternion).
Pose = Sequence[float]


@dataclass(frozen=True)
class Sensed:
    """An object that a sensor sees, and its last frame; numbers are None before there is any."""

    #: Its id.
    object: str
    #: How long ago the frame was taken (s).
    age: Optional[float] = None
    #: How long after the one before (s); 0 of the first.
    period: Optional[float] = None
    #: Points that came.
    came: Optional[int] = None
    #: Points left out as the robot's or of what it carries.
    on_robot: Optional[int] = None
    #: Of these, points that only the padding holds: the world may be there.
    in_padding: Optional[int] = None
    #: Points of the shape.
    points: Optional[int] = None


@dataclass(frozen=True)
class SceneVersion:
    """One version of a scene."""

    #: The scene's label.
    label: str
    #: Counts the contents that the label had, from 1.
    version: int
    #: Hash of the content, in hexadecimal digits.
    hash: str
    #: Objects in it, attached ones included.
    objects: int
    #: What is odd about it, a line each.
    warnings: Tuple[str, ...]
    #: Oldest version from which on all are kept.
    kept_from: int
    #: Pinned versions.
    pinned: Tuple[int, ...]
    #: Its objects that sensors see.
    sensed: Tuple[Sensed, ...] = ()


@dataclass(frozen=True)
class Snapshot:
    """The content of one version of a scene."""

    #: The version.
    version: int
    #: Hash of the content, in hexadecimal digits.
    hash: str
    #: The scene, or the diff where one was asked for, as scene files and diffs are.
    content: Any


@dataclass(frozen=True)
class SceneChange:
    """Something that happened to a scene."""

    #: created, changed, deleted, or path-unsafe.
    kind: str
    #: The version since then.
    version: int
    #: Hash of its content, in hexadecimal digits.
    hash: str
    #: Of path-unsafe: the request whose path became unsafe.
    request_id: Optional[str]
    #: Of path-unsafe: the first segment that is not proved any more.
    segment: Optional[int]


def version_of(summary: Mapping[str, Any]) -> SceneVersion:
    """A version from what the Rust half says of it."""
    return SceneVersion(
        label=summary["label"],
        version=summary["version"],
        hash=summary["hash"],
        objects=summary["objects"],
        warnings=tuple(summary["warnings"]),
        kept_from=summary["kept_from"],
        pinned=tuple(summary["pinned"]),
        sensed=tuple(Sensed(object, **(last or {})) for object, last in summary["sensed"].items()),
    )


def pose_of(pose: Pose) -> Dict[str, Any]:
    """A pose as diffs have it."""
    numbers = [float(number) for number in pose]
    if len(numbers) == 3:
        return {"position": numbers}
    if len(numbers) == 7:
        return {"position": numbers[:3], "orientation": dict(zip("xyzw", numbers[3:]))}
    raise InvalidInput(f"{len(numbers)} numbers given for a pose; give x y z, or x y z qx qy qz qw")


@dataclass(frozen=True)
class Frame:
    """A sensor's frame that a scene has taken in."""

    #: The scene's version with it.
    version: int
    #: Hash of that version's content, in hexadecimal digits.
    hash: str
    #: Points that came.
    came: int
    #: Points that are none: not finite, or in the sensor's very origin.
    not_finite: int
    #: Points left out as the robot's own or those of what it carries.
    on_robot: int
    #: Of these, points that only the padding holds: the world may be there.
    in_padding: int
    #: Points that others in their cells stand for.
    thinned: int
    #: Points of the shape.
    points: int
    #: What a person should know, a line each.
    warnings: Tuple[str, ...]


class SceneChanges(Iterator[SceneChange]):
    """Changes of a scene from `subscribe` on; of more than 64 that nobody takes the oldest are lost."""

    def __init__(self, feed: _taut.SceneFeed) -> None:
        self._feed = feed

    def __iter__(self) -> SceneChanges:
        return self

    def __next__(self) -> SceneChange:
        change = self.next()
        if change is None:
            raise StopIteration
        return change

    def next(self, timeout: Optional[float] = None) -> Optional[SceneChange]:
        """The next change; None after `timeout` seconds without one."""
        change = self._feed.next(timeout)
        return None if change is None else SceneChange(**change)


class Scene:
    """A scene under its label. Every change makes its next version; the versions before it stay for a while.

    >>> import taut
    >>> with taut.local() as d:
    ...     cell = d.load_scene("cell", {"objects": [
    ...         {"id": "box", "primitives": [{"type": "box", "dimensions": [0.1, 0.1, 0.1]}],
    ...          "primitive_poses": [{"position": [1, 0, 0]}]}]})
    ...     cell.move("box", [0.5, 0, 0.2]).version
    ...     cell.remove("box").objects
    ...     cell.snapshot(1).content["objects"][0]["id"]
    2
    0
    'box'
    """

    def __init__(self, connection: _taut.Connection, label: str) -> None:
        self._connection = connection
        self._label = label

    @property
    def label(self) -> str:
        """Its label."""
        return self._label

    def diff(
        self,
        change: Union[Mapping[str, Any], Sequence[Mapping[str, Any]]],
        *,
        base: int = 0,
        base_dir: Optional[File] = None,
    ) -> SceneVersion:
        """Makes a diff's changes, all or none. A diff is in MoveIt's words (`objects` with `operation`,
        `attached_collision_objects`, `allowed_collisions`, `link_padding`, ...); `is_diff` may be left out.

        `base` is the version that the scene has to have (0: any), else `taut.VersionConflict`. Mesh files in it start
        from `base_dir`.
        """
        parts: List[Mapping[str, Any]] = [change] if isinstance(change, Mapping) else list(change)
        text = _json([{"is_diff": True, **part} for part in parts])
        folder = None if base_dir is None else fspath(base_dir)
        return version_of(self._connection.change_scene(self._label, text, folder, base))

    def add(self, id: str, shape: Mapping[str, Any], pose: Pose = (0.0, 0.0, 0.0)) -> SceneVersion:
        """Puts an object into the world: `shape` is a primitive such as
        ``{"type": "box", "dimensions": [x, y, z]}`` or a mesh such as ``{"file": "/abs/part.stl"}``."""
        kind = "meshes" if "file" in shape or "triangles" in shape else "primitives"
        body = {"id": id, "operation": "ADD", "pose": pose_of(pose), kind: [dict(shape)]}
        body["primitive_poses" if kind == "primitives" else "mesh_poses"] = [{}]
        return self.diff({"objects": [body]})

    def move(self, id: str, pose: Pose, *, link: Optional[str] = None) -> SceneVersion:
        """Moves an object of the world; or, with `link`, one that this link carries, the pose in the link's frame."""
        moved = {"id": id, "operation": "MOVE", "pose": pose_of(pose)}
        if link is None:
            return self.diff({"objects": [moved]})
        return self.diff({"attached_collision_objects": [{"link_name": link, "object": moved}]})

    def attach(self, id: str, link: str, pose: Pose, touch: Sequence[str] = ()) -> SceneVersion:
        """Lets a link carry an object of the world, its pose in the link's frame. The two may touch, and so may the
        object and what `touch` names."""
        carried = {"id": id, "operation": "ADD", "pose": pose_of(pose)}
        attached = {"link_name": link, "touch_links": list(touch), "object": carried}
        return self.diff({"attached_collision_objects": [attached]})

    def detach(self, id: str, pose: Pose) -> SceneVersion:
        """Puts an attached object down, its pose in the world."""
        carried = {"id": id, "operation": "REMOVE", "pose": pose_of(pose)}
        return self.diff({"attached_collision_objects": [{"object": carried}]})

    def remove(self, id: str) -> SceneVersion:
        """Takes an object out of the world."""
        return self.diff({"objects": [{"id": id, "operation": "REMOVE"}]})

    def sense(
        self, id: str, *, radius: float, thin: float = 0.0, self_padding: float = 0.0
    ) -> SceneVersion:
        """Makes an object of the world one whose shape a sensor sees. Until its first frame nothing is known of what
        is there: requests in this scene are answered with LOADING.

        Each point is a ball of `radius` (metres); `thin` keeps one point for each cell of this edge, and pays for the
        others by larger balls; points within `self_padding` of the robot's own bodies are left out.
        """
        sensed = {"radius": radius, "thin": thin, "self_padding": self_padding}
        return self.diff({"objects": [{"id": id, "operation": "ADD", "sensed": sensed}]})

    def set_cloud(
        self,
        id: str,
        points: Any,
        *,
        pose: Pose = (0.0, 0.0, 0.0),
        robot: str = "",
        at: Optional[Mapping[str, float]] = None,
        link: str = "",
        taken_ns: Optional[int] = None,
    ) -> Frame:
        """A sensor's frame: the shape of a sensed object from now on, in the scene's next version.

        `points` is an array of x, y, z rows (metres; float32 or float64; more columns are ignored), or a message of
        ROS's `PointCloud2`. `pose` is where their frame is in the world, or in the frame of `link`. With `robot`, its
        variables are at the values of `at`, and points on its own bodies and on what it carries are left out.
        `taken_ns` is when the sensor saw it on the monotonic clock (`time.monotonic_ns()`; now if it is not given): a
        frame that is not newer than the last raises `taut.Cancelled`. A sensor has a connection of its own.
        """
        head, body = _layout(points)
        position = [float(number) for number in pose]
        if len(position) == 3:
            position += [0.0, 0.0, 0.0, 1.0]
        if len(position) != 7:
            raise InvalidInput(
                f"{len(position)} numbers given for a pose; give x y z, or x y z qx qy qz qw"
            )
        head.update(
            pose=position,
            robot=robot,
            link=link,
            joints=[(name, float(value)) for name, value in (at or {}).items()],
            taken_ns=time.monotonic_ns() if taken_ns is None else taken_ns,
        )
        summary = self._connection.frame(self._label, id, body, head)
        return Frame(**{**summary, "warnings": tuple(summary["warnings"])})

    def snapshot(self, version: int = 0, *, base: int = 0) -> Snapshot:
        """The content of a version that is kept, 0 being the newest; as the diff from `base` where that is not 0."""
        version, content_hash, text = self._connection.show_scene(self._label, version, base)
        return Snapshot(version, content_hash, json.loads(text))

    def pin(self, version: int = 0) -> SceneVersion:
        """Keeps a version, 0 being the newest, until it is unpinned."""
        return version_of(self._connection.pin_scene(self._label, version, True))

    def unpin(self, version: int = 0) -> SceneVersion:
        """Lets a pinned version go."""
        return version_of(self._connection.pin_scene(self._label, version, False))

    def subscribe(self) -> SceneChanges:
        """Changes of this scene from now on, whoever makes them. Of a daemon only."""
        return SceneChanges(self._connection.subscribe(self._label))

    def unload(self) -> None:
        """Forgets the scene with its versions; running requests keep theirs."""
        self._connection.unload_scene(self._label)

    def __repr__(self) -> str:
        return f"<Scene {self._label!r}>"


def _layout(points: Any) -> Tuple[Dict[str, Any], Any]:
    """How points lie in memory, and that memory."""
    if hasattr(points, "point_step"):
        head = {name: getattr(points, name) for name in ("height", "width", "point_step", "row_step", "is_bigendian")}
        head["fields"] = [(field.name, field.offset, field.datatype, field.count) for field in points.fields]
        return head, np.frombuffer(points.data, dtype=np.uint8)
    rows = np.asarray(points)
    if rows.dtype not in (np.float32, np.float64):
        rows = rows.astype(np.float64)
    if rows.ndim != 2 or rows.shape[1] < 3:
        raise InvalidInput(f"points of shape {rows.shape}; give rows of x, y, z")
    rows = np.ascontiguousarray(rows)
    size = rows.dtype.itemsize
    step = rows.shape[1] * size
    head = {
        "height": 1,
        "width": rows.shape[0],
        "point_step": step,
        "row_step": step * rows.shape[0],
        "is_bigendian": False,
        "fields": [(name, index * size, 7 if size == 4 else 8, 1) for index, name in enumerate("xyz")],
    }
    return head, rows.reshape(-1).view(np.uint8)


def _json(value: object) -> str:
    try:
        return json.dumps(value, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise InvalidInput(f"this is no JSON: {error}") from None
