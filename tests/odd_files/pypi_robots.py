#!/usr/bin/env python3
"""Robots that makers publish on PyPI: read as pinocchio reads them, and paths that are proved sampled free with coal.

    cargo build --release && python3 tests/odd_files/pypi_robots.py [--paths 20] [--keep FOLDER]

Installs the packages below in a virtual environment in a temporary folder (about 1.5 GB), and changes nothing else.
For each robot: poses of all links as pinocchio has them, limits too, cut by the soft ones; random short paths that `taut check` proves,
sampled with coal between their ends. Prints a table; exits with 1 where a number differs or a sample collides.
"""

import argparse
import collections
import json
import math
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile

PACKAGES = [
    "pin==4.1.0", "numpy==2.4.6",
    "example-robot-data==6.0.0", "pybullet==3.2.7", "icub-models==3.2.0", "hello-robot-stretch-urdf==0.1.2",
    "airo-models==0.0.12", "dexmate-urdf==0.8.4", "orca-arm==0.0.0",
]
DATA = "cmeel.prefix/share/example-robot-data/robots"
# Package, and URDF below site-packages (or below the environment, for data files).
ROBOTS = [
    ("example-robot-data", f"{DATA}/panda_description/urdf/panda.urdf"),
    ("example-robot-data", f"{DATA}/ur_description/urdf/ur5_robot.urdf"),
    ("example-robot-data", f"{DATA}/talos_data/robots/talos_reduced.urdf"),
    ("example-robot-data", f"{DATA}/tiago_description/robots/tiago.urdf"),
    ("example-robot-data", f"{DATA}/baxter_description/urdf/baxter.urdf"),
    ("example-robot-data", f"{DATA}/xarm_description/urdf/xarm7.urdf"),
    ("example-robot-data", f"{DATA}/solo_description/robots/solo12.urdf"),
    ("example-robot-data", f"{DATA}/allegro_hand_description/urdf/allegro_right_hand.urdf"),
    ("pybullet", "pybullet_data/kuka_iiwa/model.urdf"),
    ("pybullet", "pybullet_data/franka_panda/panda.urdf"),
    ("pybullet", "pybullet_data/laikago/laikago_toes.urdf"),
    ("pybullet", "pybullet_data/r2d2.urdf"),
    ("icub-models", "../../../share/iCub/robots/iCubGenova11/model.urdf"),
    ("icub-models", "../../../share/iCub/robots/iCubGazeboV2_7/model.urdf"),
    ("hello-robot-stretch-urdf", "stretch_urdf/SE3/stretch_description_SE3_eoa_wrist_dw3_tool_sg3.urdf"),
    ("hello-robot-stretch-urdf", "stretch_urdf/RE1V0/stretch_description_RE1V0_tool_stretch_gripper.urdf"),
    ("airo-models", "airo_models/arms/ur5e/ur5e.urdf"),
    ("airo-models", "airo_models/grippers/robotiq_2f_85/urdf/robotiq_2f_85.urdf"),
    ("dexmate-urdf", "dexmate_urdf/robots/humanoid/vega_1/vega_1.urdf"),
    ("dexmate-urdf", "dexmate_urdf/robots/hands/f5d6_hand/f5d6_left.urdf"),
    ("orca-arm", "orca_arm/orcabot.urdf"),
]
PROJECT = pathlib.Path(__file__).resolve().parents[2]
# Poses of every reader are of this tolerance: URDFs have six to nine digits.
TOLERANCE = 1e-5
SAMPLES = 100
LOOKS = 20


def installed(folder):
    """Runs this script again in an environment that has the packages."""
    python = folder / "venv/bin/python"
    if not python.is_file():
        subprocess.run([sys.executable, "-m", "venv", folder / "venv"], check=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", *PACKAGES], check=True)
    return subprocess.run([python, __file__, *sys.argv[1:], "--keep", folder, "--inside"]).returncode


def readings(folder, files):
    """What taut reads, from its own kinematics."""
    (folder / "robots.txt").write_text("\n".join(map(str, files)))
    environment = dict(os.environ, TAUT_ROBOTS=str(folder / "robots.txt"), TAUT_READINGS=str(folder / "readings.json"))
    test = ["cargo", "test", "--quiet", "--test", "odd_files", "--", "--ignored", "read_other_robots"]
    subprocess.run(test, cwd=PROJECT, env=environment, check=True, stdout=subprocess.DEVNULL)
    return json.loads((folder / "readings.json").read_text())


def bounded(limits, urdf):
    """Limits and soft limits, as in MoveIt's robot model; pinocchio has the former only."""
    # Some of these files are no XML: their prefixes are not declared.
    text = urdf.read_text(encoding="utf-8", errors="replace")
    for name, inner in re.findall(r'<joint\s[^>]*?name="([^"]+)"[^>]*>(.*?)</joint>', text, re.S):
        soft = re.search(r"<safety_controller\s([^>]*)", inner)
        if soft is not None and limits.get(name, [None])[0] is not None:
            numbers = dict(re.findall(r'soft_(lower|upper)_limit="([^"]*)"', soft.group(1)))
            lower, upper = (float(numbers.get(end, 0)) for end in ("lower", "upper"))
            limits[name] = [max(limits[name][0], lower), min(limits[name][1], upper)]


def differing(ours, theirs):
    """Names of the limits and links that differ."""
    found = []
    for name, limits in ours["limits"].items():
        other = theirs["limits"].get(name)
        same = other is not None and all((a is None) == (b is None) and (a is None or abs(a - b) < TOLERANCE) for a, b in zip(limits, other))
        if not same:
            found.append(f"limits of {name}: {limits}, {other}")
    for name, pose in ours["poses"].items():
        other = theirs["poses"].get(name)
        turned = other is not None and [*other[:3], *(-c for c in other[3:])]
        if other is None or min(max(abs(a - b) for a, b in zip(pose, o)) for o in (other, turned)) > TOLERANCE:
            found.append(f"pose of {name}: {pose}, {other}")
    return found


class Sampled:
    """A robot as pinocchio and coal have it, without the pairs that touch wherever it stands."""

    def __init__(self, urdf, packages, rng):
        import pinocchio as pin

        self.pin = pin
        self.model = pin.buildModelFromUrdf(str(urdf), mimic=True)
        self.geometry = pin.buildGeomFromUrdf(self.model, str(urdf), pin.GeometryType.COLLISION, package_dirs=packages)
        self.data = self.model.createData()
        self.geometry.addAllCollisionPairs()
        link = lambda i: self.model.frames[self.geometry.geometryObjects[i].parentFrame].name
        self.links = [(link(p.first), link(p.second)) for p in self.geometry.collisionPairs]
        scene, times = pin.GeometryData(self.geometry), collections.Counter()
        for _ in range(LOOKS):
            pin.computeCollisions(self.model, self.data, self.geometry, scene, self.random(rng), False)
            hits = {tuple(sorted(pair)) for pair, result in zip(self.links, scene.collisionResults) if result.isCollision()}
            times.update(hits)
        # A pair that nearly always touches does so by design.
        touching = {pair for pair, count in times.items() if count > 0.6 * LOOKS}
        touching |= {tuple(sorted(pair)) for pair in self.links if pair[0] == pair[1]} | self.joined()
        pairs = [(pin.CollisionPair(p.first, p.second), tuple(sorted(names))) for p, names in zip(self.geometry.collisionPairs, self.links)]
        for pair, names in pairs:
            if names in touching:
                self.geometry.removeCollisionPair(pair)
        self.touching = {pair for pair in touching if pair[0] != pair[1]}
        self.scene = pin.GeometryData(self.geometry)

    def joined(self):
        """Pairs of links with one moving joint between them."""
        joint = {self.model.frames[o.parentFrame].name: o.parentJoint for o in self.geometry.geometryObjects}
        parents = self.model.parents
        is_joined = lambda a, b: joint[a] == joint[b] or parents[joint[a]] == joint[b] or parents[joint[b]] == joint[a]
        return {tuple(sorted(pair)) for pair in self.links if is_joined(*pair)}

    def random(self, rng):
        """A configuration within the limits; joints without limits within half a turn."""
        q = self.pin.neutral(self.model)
        for i in range(1, self.model.njoints):
            joint = self.model.joints[i]
            if joint.nq == 1 and joint.nv == 1:
                lower, upper = self.model.lowerPositionLimit[joint.idx_q], self.model.upperPositionLimit[joint.idx_q]
                q[joint.idx_q] = rng.uniform(max(lower, -math.pi), min(upper, math.pi))
            elif joint.nq == 2:
                angle = rng.uniform(-3, 3)
                q[joint.idx_q : joint.idx_q + 2] = [math.cos(angle), math.sin(angle)]
        return q

    def values(self, q):
        """By joint name, as a path has them; pinocchio's continuous joints are on the circle."""
        found = {}
        for i in range(1, self.model.njoints):
            joint = self.model.joints[i]
            if joint.nv == 1 and joint.nq in (1, 2) and "Mimic" not in joint.shortname():
                at = joint.idx_q
                found[self.model.names[i]] = float(q[at]) if joint.nq == 1 else math.atan2(q[at + 1], q[at])
        return found

    def is_free(self, q):
        return not self.pin.computeCollisions(self.model, self.data, self.geometry, self.scene, q, True)

    def between(self, a, b, t):
        return self.pin.interpolate(self.model, a, b, t)


def srdf(name, pairs):
    lines = [f'<disable_collisions link1="{a}" link2="{b}" reason="Default"/>' for a, b in sorted(pairs)]
    return f'<robot name="{name}">\n' + "\n".join(lines) + "\n</robot>\n"


def paths(taut, urdf, robot, columns, folder, count, rng, environment):
    """How many short random paths are proved, and at how many samples of them coal finds a collision."""
    (folder / "pairs.srdf").write_text(srdf(urdf.stem, robot.touching))
    made, tries = [], 0
    while len(made) < count and tries < 50 * count:
        tries += 1
        a = robot.random(rng)
        b = robot.between(a, robot.random(rng), rng.uniform(0.02, 0.3))
        if robot.is_free(a) and robot.is_free(b):
            made.append((a, b))
    proved, refuted, others = 0, 0, collections.Counter()
    for index, (a, b) in enumerate(made):
        file = folder / f"path{index}.csv"
        rows = [",".join(repr(robot.values(q)[name]) for name in columns) for q in (a, b)]
        file.write_text(",".join(columns) + "\n" + "\n".join(rows) + "\n")
    if made:
        files = [folder / f"path{index}.csv" for index in range(len(made))]
        command = [taut, "check", *files, "--local", "--robot", urdf, "--srdf", folder / "pairs.srdf", "--format", "json"]
        run = subprocess.run(list(map(str, command)), env=environment, capture_output=True, text=True)
        answers = [json.loads(line) for line in run.stdout.splitlines() if line.startswith("{")]
        if len(answers) != len(made):
            return len(made), 0, 0, [run.stderr.strip().splitlines()[-1] if run.stderr.strip() else "no answer"]
        for (a, b), answer in zip(made, answers):
            if answer.get("proved") is True:
                proved += 1
                refuted += sum(not robot.is_free(robot.between(a, b, i / SAMPLES)) for i in range(SAMPLES + 1))
            else:
                others[" ".join([answer["code_name"], *answer.get("names", [])])] += 1
    return len(made), proved, refuted, [f"{count} × {reason}" for reason, count in others.items()]


def inside(folder, arguments):
    site = next(folder.glob("venv/lib/python*/site-packages"))
    taut = arguments.taut or PROJECT / "target/release/taut"
    wanted = [robot for robot in ROBOTS if any(arguments.only in word for word in robot)]
    files = [(package, (site / name).resolve()) for package, name in wanted]
    roots = sorted({str(parent) for _, file in files for parent in list(file.parents)[1:5]})
    os.environ["ROS_PACKAGE_PATH"] = ":".join([*roots, str(site / "pybullet_data"), str(site)])
    environment = dict(os.environ)
    ours = readings(folder, [file for _, file in files])
    sys.path.insert(0, str(pathlib.Path(__file__).parent))
    from readers import robots as readers

    failed = False
    print(f"{'package':26} {'robot':34} {'links':>5} {'limits, poses':16} {'paths':>5} {'proved':>6} {'refuted':>7}")
    for package, file in files:
        reading, rng = ours[str(file)], random.Random(7)
        head = f"{package:26} {file.parent.name[-14:] + '/' + file.stem[-19:]:34}"
        if "refused" in reading:
            print(f"{head} refused: {reading['refused'].replace(str(site), '')}")
            continue
        read = reading["read"]
        try:
            theirs = readers.posed_by_pinocchio(file)[1]
            bounded(theirs["limits"], file)
            different = differing(read, theirs)
            robot = Sampled(file, [str(file.parent), *roots, str(site)], rng)
            made, proved, refuted, others = paths(taut, file, robot, list(read["limits"]), folder, arguments.paths, rng, environment)
        except Exception as error:
            line = str(error).replace("\n", " ")
            print(f"{head} {len(read['poses']):5} pinocchio: {type(error).__name__}: {line[:150]}")
            continue
        verdict = "equal" if not different else f"{len(different)} differ"
        print(f"{head} {len(read['poses']):5} {verdict:16} {made:5} {proved:6} {refuted:>7}", flush=True)
        for line in others + different[:5]:
            print(f"{'':26} {line[:220]}")
        failed |= bool(different) or refuted > 0
    return int(failed)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--paths", type=int, default=20, help="random paths of each robot")
    parser.add_argument("--only", default="", help="robots whose package or file holds this")
    parser.add_argument("--taut", type=pathlib.Path, help="the binary; target/release/taut by default")
    parser.add_argument("--keep", type=pathlib.Path, help="folder of the environment, to use it again")
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.inside:
        return inside(arguments.keep.resolve(), arguments)
    if arguments.keep:
        arguments.keep.mkdir(parents=True, exist_ok=True)
        return installed(arguments.keep.resolve())
    with tempfile.TemporaryDirectory() as folder:
        return installed(pathlib.Path(folder))


if __name__ == "__main__":
    sys.exit(main())
