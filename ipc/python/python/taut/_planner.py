"""Connections: to a daemon, or to this process itself."""

from __future__ import annotations

from dataclasses import dataclass, field
from os import PathLike, fspath
from pathlib import Path as FilePath
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

from . import _taut
from ._answers import Answers, Check, Path
from ._constraints import Constraints, constraints_text
from ._errors import InvalidInput
from ._scene import File, Scene, SceneVersion, _json, version_of
from ._timing import Timing, timing_text

#: Anything that numpy takes for a table of numbers, a row per waypoint.
PathLikeArray = npt.ArrayLike


@dataclass(frozen=True)
class Variable:
    """One column of a path."""

    #: Its name, as MoveIt names it: a joint, or ``joint/x``.
    name: str
    #: Lowest value within limits and soft limits (rad or m), -inf where there is none.
    lower: float
    #: Highest value.
    upper: float
    #: An angle on the circle.
    continuous: bool


@dataclass(frozen=True)
class Robot:
    """A loaded robot."""

    #: Its label.
    label: str
    #: Hash of its content, in hexadecimal digits.
    hash: str
    #: Columns of its paths, in order.
    variables: Tuple[Variable, ...]
    #: Names of the variables of each group.
    groups: Mapping[str, Tuple[str, ...]]
    #: Joints that are no columns, and where they stand.
    held: Mapping[str, float]
    #: Default weights of the metric, one per velocity coordinate.
    weights: Tuple[float, ...]
    #: What is odd about it, a line each.
    warnings: Tuple[str, ...]

    @property
    def columns(self) -> List[str]:
        """Names of the columns, in order."""
        return [variable.name for variable in self.variables]


@dataclass(frozen=True)
class Problem:
    """What a problem file holds, loaded."""

    #: Its name.
    name: str
    #: Label of its robot.
    robot: str
    #: Label of its scene.
    scene: str
    #: Columns of its path.
    columns: Tuple[str, ...]
    #: The planner's path.
    path: Path = field(repr=False)
    #: Weights of its metric, one per velocity coordinate; None where it gives none. `shorten(metric=…)` takes them.
    weights: Optional[Tuple[float, ...]]
    #: What its path must keep besides clearance, as JSON; None = nothing. `shorten(constraints=…)` takes it.
    constraints: Optional[str]
    #: What is odd about robot and scene, a line each.
    warnings: Tuple[str, ...]


class Planner:
    """Robots, scenes, and work on paths: of a daemon (`taut.connect`) or of this process (`taut.local`).

    Several threads may use one at once. After `os.fork` the child needs its own.
    """

    def __init__(self, connection: _taut.Connection) -> None:
        self._connection = connection

    # Robots and scenes.

    def robots(self) -> List[str]:
        """Labels of the loaded robots."""
        return self._connection.listing()[0]

    def scenes(self) -> List[SceneVersion]:
        """The loaded scenes, each with its newest version."""
        return [version_of(scene) for scene in self._connection.listing()[1]]

    def robot(self, label: str) -> Robot:
        """Columns, groups and weights of a loaded robot."""
        return _robot(self._connection.robot(label))

    def load_robot(
        self,
        label: str,
        urdf: File,
        srdf: Optional[File] = None,
        packages: Optional[Mapping[str, File]] = None,
        *,
        columns: Optional[Sequence[str]] = None,
        allowed_collisions: Sequence[Tuple[str, str]] = (),
        replace: bool = False,
    ) -> Robot:
        """Loads a robot under a label; a robot that is loaded already changes nothing.

        `packages` says where ``package://NAME/`` is (else ROS_PACKAGE_PATH and AMENT_PREFIX_PATH). `columns` are the
        joints that paths have columns for, all movable ones by default; the others are held. Without `srdf`, one of
        the URDF's name beside it is taken, or one of that name or the robot's in ``srdf/`` or ``config/`` there or one
        folder up. With `replace`, the label is taken away from other content.

        >>> import taut
        >>> with taut.local() as d:
        ...     d.load_robot("panda", ROBOTS + "/panda_like.urdf").columns[:2]
        ['joint1', 'joint2']
        """
        folders: Dict[str, File] = {name: fspath(folder) for name, folder in (packages or {}).items()}
        names = None if columns is None else list(columns)
        pairs = [(a, b) for a, b in allowed_collisions]
        srdf_path = None if srdf is None else fspath(srdf)
        return _robot(self._connection.load_robot(label, fspath(urdf), srdf_path, folders, names, pairs, replace))

    def unload_robot(self, label: str) -> None:
        """Forgets a robot; running requests keep it."""
        self._connection.unload_robot(label)

    def load_scene(
        self,
        label: str,
        scene: Union[File, Mapping[str, Any]],
        *,
        base_dir: Optional[File] = None,
        replace: bool = False,
    ) -> Scene:
        """Loads a scene under a label: from a file (JSON, MoveIt's .scene text, or a problem file), or from a
        dictionary as scene files are. Mesh files start from the file's folder, or from `base_dir`.
        """
        if isinstance(scene, Mapping):
            text, folder = _json(dict(scene)), None
        elif isinstance(scene, (str, PathLike)):
            text, folder = self._connection.scene_text(fspath(scene)), str(FilePath(fspath(scene)).absolute().parent)
        else:
            raise InvalidInput(f"a scene of type {type(scene).__name__}; give a file's path or a dictionary")
        if base_dir is not None:
            folder = str(FilePath(fspath(base_dir)).absolute())
        self._connection.load_scene(label, text, folder, replace)
        return Scene(self._connection, label)

    def scene(self, label: str) -> Scene:
        """A scene that is loaded, to change it or look at it."""
        return Scene(self._connection, label)

    def load_problem(
        self,
        file: File,
        *,
        spheres: bool = False,
        robot: Optional[str] = None,
        scene: Optional[str] = None,
    ) -> Problem:
        """Loads robot and scene of a ``taut-problem/1`` file and reads its path. Labels are made of names and hashes
        unless `robot` and `scene` give them. With `spheres`, the robot's sphere model is taken.
        """
        loaded = self._connection.load_problem(fspath(file), spheres, robot, scene)
        columns = tuple(loaded["columns"])
        weights = loaded["weights"]
        return Problem(
            name=loaded["name"],
            robot=loaded["robot"],
            scene=loaded["scene"],
            columns=columns,
            path=loaded["path"].reshape(loaded["waypoints"], len(columns)),
            weights=None if weights is None else tuple(weights),
            constraints=loaded["constraints"] or None,
            warnings=tuple(loaded["warnings"]),
        )

    # Paths.

    def shorten(
        self,
        path: PathLikeArray,
        robot: Union[str, Robot],
        scene: Union[str, Scene, None] = None,
        *,
        # Keywords of shorten, from the table of options:
        deadline: Optional[float] = None,
        clearance: Optional[float] = None,
        budget: int = 0,
        seed: int = 0,
        scene_version: int = 0,
        max_age: Optional[float] = None,
        mode: str = "hybrid",
        priority: int = 0,
        strict: bool = False,
        unwrapped: bool = False,
        contacts: bool = True,
        keep_goal: bool = False,
        corridor: bool = False,
        columns: Optional[Sequence[str]] = None,
        hold: Optional[Mapping[str, float]] = None,
        metric: Optional[Sequence[float]] = None,
        weights: Optional[Mapping[str, float]] = None,
        fix: Sequence[int] = (),
        group: Optional[str] = None,
        constraints: Optional[Constraints] = None,
        timing: Optional[Timing] = None,
        # (end of the table)
    ) -> Answers:
        """Shortens a path: gives its improvements as they are found, each proved; `.result()` gives the last.

        `path` has a row per waypoint. A C-contiguous float64 array is copied once, straight into shared memory; all
        else is converted first. Without `scene` there is nothing around the robot.

        A step of an angle column means its numbers up to half a turn, and beyond it the short way round: answers are
        written that way, and `turned` says which columns end whole turns away. Where the path itself comes closer than
        `clearance`, that pair keeps less and the answer says so. Answers have the columns of the path.

        Options, each with its default:
        * `deadline`: Time that the request may take, from when it is sent; the best path by then is the answer, in s
          (no limit).
        * `clearance`: Distance that every pair of bodies must keep, in m (1mm).
        * `budget`: Most work to spend on a shorter path, in the units of the answer's `work`: the same on every machine
          (200,000,000).
        * `seed`: Seed of every random choice (0).
        * `scene_version`: Version of the scene, of those that are kept (the newest).
        * `max_age`: Refuse where what a sensor sees of the scene is older than this, in s (any age).
        * `mode`: Optimizer: check, gradient, random-shortcut, partial-shortcut, contact, hybrid (hybrid).
        * `priority`: Class of the request: one of a higher class is served first (0).
        * `strict`: Refuse a path that keeps less, instead of lowering the clearance of the pairs that come closer
          (False).
        * `unwrapped`: Take the columns of continuous joints as they stand, as real numbers and not as angles on the
          circle (False).
        * `contacts`: Look for what is nearest along the path; without it the answer comes sooner (True).
        * `keep_goal`: Keep the goal's numbers: refuse a path whose angles lead there only by a step of more than half a
          turn, and take no path that ends whole turns away (False).
        * `corridor`: Prove each segment at the largest clearance that it keeps, up to 10 cm, and tell how far what is
          executed may stray from the path (False).
        * `columns`: Names of the path's columns, in the path's order; joints of the robot that are missing stand still
          (all of the robot's, in its order).
        * `hold`: Where a joint stands that is no column of the path, instead of at 0, in rad or m (0).
        * `metric`: Weights of the metric, one per velocity coordinate of the robot (metres of reach).
        * `weights`: Weight of a joint in the metric, by its name, instead of the one that it has (the metric's).
        * `fix`: Waypoints that stay as they are to the last bit, counted from 0; the ends always do (the ends).
        * `group`: Group of the robot: only its joints may move otherwise than on the path given (all may).
        * `constraints`: What the path must keep besides clearance, see docs/constraints.md: MoveIt's Constraints in
          JSON, a list of such, or few words such as "upright hand:x=0.1" (nothing).
        * `timing`: A trajectory along the path, near the least time that the motors allow and proved as it is written,
          see docs/timing.md: what they allow, and how it is executed. MoveIt's joint_limits.yaml, with our words beside
          it, or few words such as "acceleration=2/s speed=0.5" (no times).

        Raises, here or while iterating: `InCollision` with names and place where **the path that is sent collides**
        (`check` tells instead of raising), `NotProvable`, `TimedOut`, `UnknownName`, `InvalidInput`, `Overloaded`,
        `DaemonLost`, ...; all are `taut.Error`.

        >>> import taut
        >>> with taut.local() as d:
        ...     problem = d.load_problem(PROBLEMS + "/rooms.json")
        ...     best = d.shorten(problem.path, problem.robot, problem.scene).result()
        ...     best.proved, best.length < best.length_before
        (True, True)
        """
        options: Dict[str, Any] = {
            # Values of shorten, from the table of options:
            "deadline": deadline,
            "clearance_m": clearance,
            "work_budget": budget,
            "seed": seed,
            "scene_version": scene_version,
            "max_age": max_age,
            "mode": mode,
            "priority": priority,
            "strict": strict,
            "unwrapped": unwrapped,
            "contacts": contacts,
            "keep_goal": keep_goal,
            "corridor": corridor,
            "columns": _names(columns),
            "held": _pairs(hold),
            "metric": _numbers(metric),
            "joint_weights": _pairs(weights),
            "fixed_waypoints": [_index(number) for number in fix],
            "group": group,
            "constraints": constraints_text(constraints),
            "timing": timing_text(timing),
            # (end of the table)
        }
        return self._ask(path, robot, scene, options)

    def check(
        self,
        path: PathLikeArray,
        robot: Union[str, Robot],
        scene: Union[str, Scene, None] = None,
        *,
        # Keywords of check, from the table of options:
        deadline: Optional[float] = None,
        clearance: Optional[float] = None,
        seed: int = 0,
        scene_version: int = 0,
        max_age: Optional[float] = None,
        priority: int = 0,
        strict: bool = False,
        unwrapped: bool = False,
        contacts: bool = True,
        keep_goal: bool = False,
        corridor: bool = False,
        columns: Optional[Sequence[str]] = None,
        hold: Optional[Mapping[str, float]] = None,
        metric: Optional[Sequence[float]] = None,
        constraints: Optional[Constraints] = None,
        timing: Optional[Timing] = None,
        # (end of the table)
    ) -> Check:
        """Proves a path, or says where it collides: never raises for what is wrong with the path itself.

        The verdict is true where the path is proved; else `problem` is the error that `shorten` would raise, with
        names and place.

        >>> import taut
        >>> with taut.local() as d:
        ...     problem = d.load_problem(PROBLEMS + "/rooms.json")
        ...     verdict = d.check(problem.path[[0, -1]], problem.robot, problem.scene)
        ...     bool(verdict), type(verdict.problem).__name__, verdict.problem.segment
        (False, 'InCollision', 0)
        """
        options: Dict[str, Any] = {
            "mode": "check",
            # Values of check, from the table of options:
            "deadline": deadline,
            "clearance_m": clearance,
            "seed": seed,
            "scene_version": scene_version,
            "max_age": max_age,
            "priority": priority,
            "strict": strict,
            "unwrapped": unwrapped,
            "contacts": contacts,
            "keep_goal": keep_goal,
            "corridor": corridor,
            "columns": _names(columns),
            "held": _pairs(hold),
            "metric": _numbers(metric),
            "constraints": constraints_text(constraints),
            "timing": timing_text(timing),
            # (end of the table)
        }
        answers = self._ask(path, robot, scene, options)
        best = answers._answers.next()
        while best is not None and not best.final:
            best = answers._answers.next()
        if best is None:
            raise InvalidInput("the daemon ended a check without a verdict; use client and daemon of the same release")
        if best.path.shape[0] == 0:
            # Not about the path but about the request.
            best.check()
        return Check(best, answers._sent, [(best.time, best.length)])

    def watch(
        self,
        path: PathLikeArray,
        robot: Union[str, Robot],
        scene: Union[str, Scene],
        *,
        # Keywords of watch, from the table of options:
        clearance: Optional[float] = None,
        max_age: Optional[float] = None,
        strict: bool = False,
        unwrapped: bool = False,
        keep_goal: bool = False,
        columns: Optional[Sequence[str]] = None,
        hold: Optional[Mapping[str, float]] = None,
        constraints: Optional[Constraints] = None,
        # (end of the table)
    ) -> Watch:
        """Checks a path, and again whenever a change of its scene makes it unsafe or safe. Of a daemon only."""
        options: Dict[str, Any] = {
            "mode": "check",
            "watch": True,
            "contacts": False,
            # Values of watch, from the table of options:
            "clearance_m": clearance,
            "max_age": max_age,
            "strict": strict,
            "unwrapped": unwrapped,
            "keep_goal": keep_goal,
            "columns": _names(columns),
            "held": _pairs(hold),
            "constraints": constraints_text(constraints),
            # (end of the table)
        }
        return Watch(self._ask(path, robot, scene, options))

    def _ask(
        self,
        path: PathLikeArray,
        robot: Union[str, Robot],
        scene: Union[str, Scene, None],
        options: Dict[str, Any],
    ) -> Answers:
        sent = _rows(path)
        robot_label = robot.label if isinstance(robot, Robot) else robot
        scene_label = scene.label if isinstance(scene, Scene) else scene
        try:
            return Answers(self._connection.ask(sent, robot_label, scene_label, options), sent)
        except (TypeError, OverflowError) as error:
            raise InvalidInput(f"an argument of the wrong kind: {error}") from None

    # The connection.

    def close(self) -> None:
        """Ends the connection. Answers that run go on, and what was handed out stays valid."""
        self._connection.close()

    @property
    def closed(self) -> bool:
        """Whether it is closed."""
        return self._connection.closed

    def __enter__(self) -> Planner:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


class Watch:
    """Verdicts on a watched path: the first at once, others as the scene changes. Closing it ends the watch."""

    def __init__(self, answers: Answers) -> None:
        self._answers = answers

    def next(self, timeout: Optional[float] = None) -> Optional[Check]:
        """The next verdict; None after `timeout` seconds without one, or when the watch is over."""
        best = self._answers._answers.next(timeout)
        if best is None:
            return None
        if best.final and best.path.shape[0] == 0:
            best.check()
        return Check(best, self._answers._sent, [])

    def close(self) -> None:
        """Ends the watch."""
        self._answers.close()

    def __enter__(self) -> Watch:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


def connect(instance: Optional[str] = None) -> Planner:
    """Connects to the daemon of an instance: ``"name"`` or ``"name:/root"``; by default TAUT_INSTANCE, or the default
    one. Raises `DaemonLost` where there is none (start one with ``taut serve``).
    """
    return Planner(_taut.connect(instance))


def local() -> Planner:
    """Answers in this process, without a daemon: the same interface, and the same answers to the last bit."""
    return Planner(_taut.local())


def _rows(path: PathLikeArray) -> Path:
    try:
        rows = np.asarray(path)
    except (TypeError, ValueError) as error:
        raise InvalidInput(f"the path is no table of numbers: {error}") from None
    if rows.dtype.kind not in "fiu":
        raise InvalidInput(f"the path has numbers of type {rows.dtype}; valid: floating point and integers")
    if rows.ndim != 2 or rows.shape[0] == 0 or rows.shape[1] == 0:
        raise InvalidInput(f"the path has the shape {rows.shape}; valid: (waypoints, columns), at least one of each")
    return np.ascontiguousarray(rows, dtype=np.float64)


def _names(columns: Optional[Sequence[str]]) -> Optional[List[str]]:
    if columns is None:
        return None
    names = list(columns)
    if isinstance(columns, str) or not names or not all(isinstance(name, str) for name in names):
        raise InvalidInput(f"columns are {columns!r}; valid: a list of names")
    return names


def _pairs(values: Optional[Mapping[str, float]]) -> Optional[List[Tuple[str, float]]]:
    if values is None:
        return None
    if not isinstance(values, Mapping):
        raise InvalidInput(f"{values!r} is no dictionary of names and numbers")
    try:
        return [(str(name), float(value)) for name, value in values.items()]
    except (TypeError, ValueError) as error:
        raise InvalidInput(f"{values!r} is no dictionary of names and numbers: {error}") from None


def _numbers(values: Optional[Sequence[float]]) -> Optional[List[float]]:
    return None if values is None else [float(value) for value in values]


def _index(number: int) -> int:
    try:
        index = int(number)
    except (TypeError, ValueError, OverflowError):
        index = -1
    if index < 0 or index != number:
        raise InvalidInput(f"waypoint {number!r} is to stay; valid: 0, 1, ...")
    return index


def _robot(described: Mapping[str, Any]) -> Robot:
    return Robot(
        label=described["label"],
        hash=described["hash"],
        variables=tuple(Variable(*variable) for variable in described["variables"]),
        groups={name: tuple(names) for name, names in described["groups"].items()},
        held=dict(described["held"]),
        weights=tuple(described["weights"]),
        warnings=tuple(described["warnings"]),
    )
