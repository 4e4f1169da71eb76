"""Shortens recorded constrained paths with taut, and judges what comes back by other means.

    python examples/planners/constrained_judge.py FOLDER [FOLDER...] [--taut taut] [-o table.json]

FOLDER holds taut-problem/1 files with path constraints of the kind "an axis of a link within an
angle of a direction of the world" (`axis`, `reference`, `tolerance_rad`). Each is shortened by
`taut shorten FILE --local`; the joint-linear path that comes back, which is what a controller
executes, is sampled every 1e-4 rad by kinematics written here, from the URDF, with numpy alone. So
are the recorded peers' paths, with `--peers`. Lengths are of joint space. `--collisions 0.005` has
pinocchio and coal (requirements-ompl.txt) look for collisions every so many radians, too.

A path on which links of the robot itself meet is refused. Was the planner not asked to look at
them, its question was another: `--alone` asks taut the planner's, with all pairs of links allowed
to meet, so that the constraint alone is kept.
"""

import argparse
import json
import math
import statistics
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np

STEP = 1e-4  # rad, along the path
AT_ONCE = 20_000  # samples


def turned(roll, pitch, yaw):
    """Rotation of a URDF's rpy."""
    about = [(0, roll), (1, pitch), (2, yaw)]
    return np.linalg.multi_dot([rotation(np.eye(3)[axis], np.array([angle]))[0] for axis, angle in reversed(about)])


def rotation(axis, angles):
    """Rotations about an axis."""
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    sine, rest = np.sin(angles)[:, None, None], (1 - np.cos(angles))[:, None, None]
    return np.eye(3) + sine * cross + rest * (cross @ cross)


class Tilt:
    """The angle between a link's axis and a direction of the world, by the rotations above it."""

    def __init__(self, urdf, columns, message):
        joints = {joint.find("child").get("link"): joint for joint in xml.parse(urdf).getroot().findall("joint")}
        self.steps, link = [], message["link_name"]
        while link in joints:
            joint = joints[link]
            origin = joint.find("origin")
            rpy = "0 0 0" if origin is None else origin.get("rpy", "0 0 0")
            self.steps.append((turned(*map(float, rpy.split())), self._turn(joint, columns)))
            link = joint.find("parent").get("link")
        self.steps.reverse()
        self.axis = unit(message["axis"])
        self.reference = unit(message["reference"])
        self.allowed = message["tolerance_rad"]

    def _turn(self, joint, columns):
        """Column and axis of a joint that turns; None of one that does not."""
        name = joint.get("name")
        if joint.get("type") in ("fixed", "prismatic"):
            return None
        if joint.get("type") not in ("revolute", "continuous") or name not in columns:
            raise SystemExit(f"joint {name!r}: only revolute columns of the path turn the link here")
        axis = joint.find("axis")
        return columns.index(name), unit([1, 0, 0] if axis is None else list(map(float, axis.get("xyz").split())))

    def at(self, rows):
        """The angle at each of many configurations."""
        turned = np.broadcast_to(np.eye(3), (len(rows), 3, 3))
        for origin, turn in self.steps:
            turned = turned @ origin
            if turn is not None:
                turned = turned @ rotation(turn[1], rows[:, turn[0]])
        pointing = turned @ self.axis
        across = np.linalg.norm(np.cross(pointing, self.reference), axis=1)
        return np.arctan2(across, pointing @ self.reference)

    def most(self, path):
        """The largest angle on straight segments, and how many samples saw it."""
        worst, samples = 0.0, 0
        for start, end in zip(path, path[1:]):
            pieces = max(1, math.ceil(np.linalg.norm(end - start) / STEP))
            for first in range(0, pieces + 1, AT_ONCE):
                t = np.arange(first, min(first + AT_ONCE, pieces + 1))[:, None] / pieces
                worst = max(worst, float(self.at(start + t * (end - start)).max()))
                samples += len(t)
        return worst, samples


def unit(vector):
    return np.array(vector, float) / np.linalg.norm(vector)


def length(path):
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def links(urdf):
    return [link.get("name") for link in xml.parse(urdf).getroot().findall("link")]


def alone(file, text, folder):
    """The problem where no link minds another, written to a folder."""
    names = links(file.parent / text["robot"]["urdf"])
    pairs = [[a, b] for index, a in enumerate(names) for b in names[:index]]
    robot = dict(text["robot"], allowed_collisions=pairs)
    for field in ("urdf", "srdf", "spherized_urdf"):
        if robot.get(field):
            robot[field] = str((file.parent / robot[field]).resolve())
    robot["packages"] = {name: str((file.parent / at).resolve()) for name, at in robot.get("packages", {}).items()}
    changed = Path(folder) / file.name
    changed.write_text(json.dumps(dict(text, robot=robot)))
    return changed


def shortened(given, file, folder):
    """taut's answer, as `taut shorten` writes it."""
    out = Path(folder) / "answer.json"
    command = [given.taut, "shorten", str(file), "--local", "--no-contacts", "-o", str(out), *given.option]
    ran = subprocess.run(command, capture_output=True, text=True)
    if ran.returncode > 2 or not out.exists():
        raise SystemExit(f"{' '.join(command)}: {ran.stderr.strip()}")
    answer = json.loads(out.read_text())
    out.unlink()
    return answer


def peers(text):
    """Lengths of recorded answers, by name."""
    found = {name: peer["length"] for name, peer in text.get("peers", {}).items()}
    # The recorded pairs have OMPL's length by itself.
    if "ompl_simplified_interpolated_length" in text:
        found["ompl/simplified, interpolated"] = text["ompl_simplified_interpolated_length"]
    return found


def collides(file, path, step):
    """Where coal sees a path collide, for people."""
    from problem import Problem

    hit = Problem(file).collision(path, step)
    return f"{hit[2][0]} x {hit[2][1]} at segment {hit[0]}, t = {hit[1]:.3f}" if hit else ""


def judge(given, file, folder):
    """One problem: a record of what came back, and what was seen of it."""
    text = json.loads(file.read_text())
    constraints = text["path_constraints"]["orientation_constraints"]
    tilts = [Tilt(file.parent / text["robot"]["urdf"], text["variables"], message) for message in constraints]
    answer = shortened(given, alone(file, text, folder) if given.alone else file, folder)
    path = np.array(answer["path"])
    row = {"problem": text["name"], "waypoints": [len(text["path"]), len(path)], "proved": answer["proved"]}
    row["length"] = [length(np.array(text["path"])), length(path)]
    row["cpu_ms"] = answer["cpu_s"] * 1e3
    row["code"] = answer["code_name"]
    row["raised"] = [lowered for lowered in answer["floors_lowered"] if lowered["kind"] != "clearance"]
    row["over"] = {name: row["length"][1] / theirs for name, theirs in peers(text).items()}
    seen = [tilt.most(path) for tilt in tilts]
    raised = max((-lowered["floor"] for lowered in row["raised"]), default=0.0)
    row["worst"] = max(worst for worst, _ in seen)
    row["samples"] = sum(samples for _, samples in seen)
    row["allowed"] = max(tilt.allowed for tilt in tilts) + raised
    row["violated"] = any(worst > tilt.allowed + raised for (worst, _), tilt in zip(seen, tilts))
    row["collides"] = collides(file, path, given.collisions) if row["proved"] and given.collisions else ""
    if given.peers:
        strays = {name: np.array(peer["path"]) for name, peer in text.get("peers", {}).items() if "path" in peer}
        row["peers_worst"] = {name: max(tilt.most(path)[0] for tilt in tilts) for name, path in strays.items()}
    return row


def line(row):
    """One problem for people."""
    begin = f"{row['problem']}: {row['waypoints'][0]} waypoints {row['length'][0]:.3f}"
    if not row["proved"]:
        return f"{begin}, refused: {row['code']} ({row['cpu_ms']:.1f} ms)"
    over = ", ".join(f"{ratio:.3f} of {name}" for name, ratio in row["over"].items())
    raised = f", raised to {row['allowed']:.5f}" if row["raised"] else ""
    seen = f"most {row['worst']:.9f} rad of {row['allowed']:g} in {row['samples']} samples"
    verdict = "VIOLATED" if row["violated"] else "kept"
    if row["collides"]:
        verdict = f"COLLIDES {row['collides']}, {verdict}"
    strays = "".join(f"; {name} strays to {worst:.6f}" for name, worst in row.get("peers_worst", {}).items())
    shorter = f"{row['waypoints'][1]} waypoints {row['length'][1]:.3f} in {row['cpu_ms']:.1f} ms"
    return f"{begin} -> {shorter}; {over}; {verdict}: {seen}{raised}{strays}"


def summary(rows):
    """What all of it comes to."""
    proved = [row for row in rows if row["proved"]]
    if not proved:
        return f"{len(rows)} paths, none proved"
    names = sorted({name for row in proved for name in row["over"]})
    ratios = {name: [row["over"][name] for row in proved if name in row["over"]] for name in names}
    over = "".join(f", {statistics.median(found):.3f} of {name}" for name, found in ratios.items())
    times = [row["cpu_ms"] for row in proved]
    return (
        f"{len(rows)} paths, {len(proved)} proved, {sum(row['violated'] for row in proved)} violated in "
        f"{sum(row['samples'] for row in proved)} samples, {sum(bool(row['collides']) for row in proved)} seen to "
        f"collide; medians: "
        f"{statistics.median(row['length'][1] / row['length'][0] for row in proved):.3f} of the input{over}; "
        f"{statistics.median(times):.1f} ms (most {max(times):.1f})"
    )


def main():
    """Shortens, judges, prints."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", help="of problem files with path constraints, at any depth")
    parser.add_argument("--taut", default="taut", help="the program")
    parser.add_argument("--alone", action="store_true", help="keep the constraint alone: links may meet")
    parser.add_argument("--peers", action="store_true", help="judge the recorded peers' paths too")
    parser.add_argument("--collisions", type=float, default=0.0, help="between looks for collisions (rad)")
    parser.add_argument("--option", action="append", default=[], help="of taut shorten, such as --option=--strict")
    parser.add_argument("-o", "--output", help="all rows, as JSON")
    given = parser.parse_args()
    if given.alone and given.collisions:
        parser.error("--collisions is what --alone does not keep")
    files = [file for folder in given.folders for file in sorted(Path(folder).rglob("*.json"))]
    if not files:
        raise SystemExit(f"no problem file in {', '.join(given.folders)}; constrained_planner.py makes some")
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for file in files:
            rows.append(judge(given, file, folder))
            print(line(rows[-1]), flush=True)
    print(summary(rows))
    if given.output:
        Path(given.output).write_text(json.dumps(rows, indent=1) + "\n")
    sys.exit(any(row["violated"] or row["collides"] for row in rows if row["proved"]))


if __name__ == "__main__":
    main()
