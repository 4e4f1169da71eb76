"""Answers: improvements as they come, and results."""

from __future__ import annotations

import json
from dataclasses import dataclass
from os import PathLike
from typing import Any, Dict, Iterator, List, Optional, Tuple, Union

import numpy as np
import numpy.typing as npt

from . import _taut
from ._errors import Cancelled, Error
from ._timing import Trajectory, trajectory_of

Path = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Corridor:
    """How far what is executed may stray from a proved path: for every configuration p of a segment and every q with
    the sum of ``reach * abs(q - p)`` at most the segment's slack, every pair of bodies keeps the floor at q."""

    #: Distance that every pair keeps within the corridor, in metres.
    floor: float
    #: How far bodies move at most against each other (m per rad or m), for each velocity coordinate in order: the
    #: variable that it belongs to, and the number. The three of a rotation have the quaternion's first three variables.
    reach: Tuple[Tuple[str, float], ...]
    #: The slack of each segment, in metres.
    slack: Tuple[float, ...]


def _corridor(corridor: Dict[str, Any]) -> Corridor:
    return Corridor(
        floor=corridor["floor_m"],
        reach=tuple((one["variable"], one["reach_m"]) for one in corridor["coordinates"]),
        slack=tuple(corridor["slack_m"]),
    )


class Improvement:
    """A proved path that is shorter than those before it.

    `path` is a read-only view of shared memory: nothing is copied. It is valid, and stays as it is, for as long as
    there is a reference to it or to this object, whatever happens to the request and the daemon. `copy()` gives an
    array of its own.

    At most two improvements of one request lie in shared memory at once. Keep more of them as you like: those that
    come while you hold two are copied (`is_shared` is False then).
    """

    __slots__ = ("_best",)

    def __init__(self, best: _taut.Improvement) -> None:
        self._best = best

    @property
    def path(self) -> Path:
        """The waypoints, a read-only array with a row per waypoint and the request's columns."""
        return self._best.path

    @property
    def __array_interface__(self) -> Dict[str, Any]:
        return self._best.__array_interface__

    def copy(self) -> Path:
        """The waypoints as an array of their own."""
        return np.array(self._best.path)

    @property
    def is_shared(self) -> bool:
        """Whether `path` is a view of the daemon's memory; else this process has a copy."""
        return self._best.is_shared

    @property
    def length(self) -> float:
        """Its length, in the request's metric (metres of reach unless weights are given)."""
        return self._best.length

    @property
    def length_before(self) -> float:
        """Length of the path that was sent, in the same metric."""
        return self._best.length_before

    @property
    def lower_bound(self) -> float:
        """No path between these ends is shorter."""
        return self._best.lower_bound

    @property
    def proved(self) -> bool:
        """Whether the path is proved collision-free at every instant."""
        return self._best.proved

    @property
    def final(self) -> bool:
        """Whether it is the last answer."""
        return self._best.final

    @property
    def time(self) -> float:
        """When it came, in seconds after the request was sent."""
        return self._best.time

    @property
    def stage(self) -> str:
        """The stage of the method that found it: input, shortcut, partial-shortcut, gradient, contact."""
        return self._best.stage

    @property
    def times(self) -> str:
        """Whether there is a trajectory: timed; not-reached (yet, or when the request ended), refused, no-path, not-asked."""
        return self._best.times

    @property
    def trajectory(self) -> Optional[Trajectory]:
        """The trajectory so far, proved as it is written; None where there is none yet."""
        return trajectory_of(self._best.trajectory()) if self.times == "timed" else None

    @property
    def scene_version(self) -> int:
        """Version of the scene that it is proved against."""
        return self._best.scene_version

    @property
    def world_age(self) -> Optional[float]:
        """Seconds since the oldest frame was taken among those that the scene is seen by, when this was sent; None where
        no sensor sees it."""
        return self._best.world_age

    @property
    def superseded(self) -> bool:
        """Whether the scene has changed since the request was taken."""
        return self._best.superseded

    @property
    def request_id(self) -> str:
        """The id that `taut why` takes."""
        return self._best.request_id

    @property
    def code(self) -> int:
        """Result code: 1 is success."""
        return self._best.code

    @property
    def code_name(self) -> str:
        """Its name, such as SUCCESS."""
        return self._best.code_name

    def __len__(self) -> int:
        return int(self._best.path.shape[0])

    def __repr__(self) -> str:
        word = "proved" if self.proved else self.code_name
        shape = self._best.path.shape
        return f"<{type(self).__name__} {shape[0]} x {shape[1]}, length {self.length:.4f}, {word}>"


class Result(Improvement):
    """The final answer, with what was proved and what holds the path."""

    __slots__ = ("_details", "_sent", "_lengths")

    def __init__(self, best: _taut.Improvement, sent: Path, lengths: List[Tuple[float, float]]) -> None:
        super().__init__(best)
        self._details: Optional[Dict[str, Any]] = None
        self._sent = sent
        self._lengths = lengths

    @property
    def clearance(self) -> float:
        """Smallest clearance that the proof promises, in metres; infinite where nothing is near."""
        return self._best.clearance

    @property
    def floor(self) -> float:
        """Lowest floor of any clearance, in metres."""
        return self._best.floor

    @property
    def gap(self) -> Optional[float]:
        """By which part of the lower bound it is longer; None where that bound is 0."""
        bound = self.lower_bound
        return self.length / bound - 1.0 if bound > 0.0 else None

    @property
    def ended(self) -> str:
        """How the work ended: converged, deadline, work-budget, finished-early, checked, ..."""
        return self._best.ended

    @property
    def iterations(self) -> int:
        """Iterations of the method."""
        return self._best.iterations

    @property
    def work(self) -> int:
        """Counted work, the same on every machine."""
        return self._best.work

    @property
    def compute_time(self) -> float:
        """Time that it was worked on, in seconds."""
        return self._best.compute_time

    @property
    def message(self) -> str:
        """What to do about a refusal, or why nothing can be proved; mostly empty."""
        return self._best.message

    @property
    def turned(self) -> Dict[str, int]:
        """Angle columns whose numbers are not those that were sent, since a step of more than half a turn means the
        short way round: whole turns from the goal that was sent to this one; 0 where only numbers before it moved."""
        return {column["variable"]: column["turns"] for column in self.details["turned"]}

    @property
    def warnings(self) -> List[str]:
        """What a person should know of robot, scene and request, a line each, first what the verdict does not cover.
        Of trifles that are alike the first is told and the others are counted."""
        return [text for _, text in self._best.warnings]

    @property
    def uncovered(self) -> List[str]:
        """Those of `warnings` that say what the verdict does not cover, or rests on."""
        return [text for uncovered, text in self._best.warnings if uncovered]

    @property
    def pairs(self) -> int:
        """How many pairs of bodies were checked."""
        return self._best.pairs

    @property
    def details(self) -> Dict[str, Any]:
        """All of it but the paths and the proof, with the names of result files (`holds`, `smallest_clearance`,
        `floors_lowered`, `pinched`, `stages`, ...)."""
        if self._details is None:
            loaded: Dict[str, Any] = json.loads(self._best.details())
            self._details = loaded
        return self._details

    @property
    def corridor(self) -> Optional[Corridor]:
        """How far what is executed may stray from the path; None unless `corridor` was asked for and it is proved."""
        corridor = self.details.get("corridor")
        return None if corridor is None else _corridor(corridor)

    @property
    def keeps(self) -> List[Dict[str, Any]]:
        """What the path keeps of each constraint: its `kind`, `names` and `unit`; what of its tolerance is proved to be
        `left` everywhere; the least that was found (`amount`, a look and no proof), with its `segment` and `t`; and
        what was `asked`, where one number says it. Empty where the path is not proved."""
        keeps: List[Dict[str, Any]] = self.details.get("keeps", [])
        return keeps

    @property
    def trajectory(self) -> Trajectory:
        """When what is to be where, of a request with `timing`: proved as it is written, between its points too.

        Raises `Untimed` where there is none, with why: the deadline came first, or none is proved. The path is there
        all the same.
        """
        return trajectory_of(self._best.trajectory())

    @property
    def holds(self) -> List[Dict[str, Any]]:
        """What holds the path: of each the place, kind, names, amount and unit of what is kept, points and normal."""
        return self.details["holds"] or []

    def save(self, file: Union[str, "PathLike[str]"]) -> None:
        """Writes the result file that `taut shorten --out` writes, for `taut view`.

        It holds the path that was sent too: where that is your array itself (C-contiguous float64), leave it
        unchanged until then.
        """
        self._best.save(file, self._sent, self._lengths)


class Check(Result):
    """The verdict on a path: `proved`, or `problem` with what is not kept and where. True where it is proved."""

    __slots__ = ()

    @property
    def problem(self) -> Optional[Error]:
        """What `shorten` would raise for this path; None where it is proved."""
        try:
            self._best.check()
        except Error as error:
            return error
        return None

    def __bool__(self) -> bool:
        return self.proved


class Answers(Iterator[Improvement]):
    """Improvements of one request as they come, the final one last; it is a `Result`.

    Closing it, leaving its `with` block, or dropping it cancels the request. Iterate in one thread; `finish_early` and
    `close` may come from another.
    """

    def __init__(self, answers: _taut.Answers, sent: Path) -> None:
        self._answers = answers
        self._sent = sent
        self._lengths: List[Tuple[float, float]] = []
        self._result: Optional[Result] = None

    def __iter__(self) -> Answers:
        return self

    def __next__(self) -> Improvement:
        best = self.next()
        if best is None:
            raise StopIteration
        return best

    def next(self, timeout: Optional[float] = None) -> Optional[Improvement]:
        """The next answer; None after the final one, or after `timeout` seconds without one.

        Raises what is wrong with the path or the request, such as `taut.InCollision`.
        """
        best = self._answers.next(timeout)
        if best is None:
            return None
        if not best.final:
            best.check()
            self._lengths.append((best.time, best.length))
            return Improvement(best)
        best.check()
        self._lengths.append((best.time, best.length))
        self._result = Result(best, self._sent, self._lengths)
        return self._result

    def result(self, timeout: Optional[float] = None) -> Result:
        """Waits for the final answer; improvements before it are skipped.

        Raises `TimeoutError` after `timeout` seconds (the request goes on), and as `next`.
        """
        import time

        end = None if timeout is None else time.monotonic() + timeout
        while self._result is None:
            left = None if end is None else max(0.0, end - time.monotonic())
            if self.next(left) is None and self._result is None:
                if end is not None and time.monotonic() >= end:
                    raise TimeoutError(f"no final answer within {timeout} s; wait again, finish_early() or close()")
                raise Cancelled("the request is over and has no final answer", -7, "PREEMPTED")
        return self._result

    def finish_early(self) -> None:
        """Asks for the best so far, now: the final answer comes next."""
        self._answers.finish_early()

    def close(self) -> None:
        """Cancels the request if it still runs. What was handed out stays valid."""
        self._answers.close()

    @property
    def request_id(self) -> str:
        """The id that `taut why` takes."""
        return self._answers.request_id

    def __enter__(self) -> Answers:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()
