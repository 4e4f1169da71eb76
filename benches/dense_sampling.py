#!/usr/bin/env python3
"""Dense sampling with coal beside taut's proofs, on the same paths: an optional comparison that nothing else runs.

    pip install pin==4.1.0 coal==3.0.3 numpy==2.4.6        (Python 3.10 or newer; pin is pinocchio)
    cargo build --release
    python3 benches/dense_sampling.py FOLDER... [--limit N] [--step 1mm] [--taut target/release/taut]

Each problem file (`taut-problem/1`) below the folders is checked twice, one after the other:

* by sampling: pinocchio and coal on the robot's given geometry (meshes as triangle trees) at so many configurations
  that no point of a robot's body travels more than the step between two of them. It stops at the first collision;
* by proof: `taut bench --check --geometry given`, whose time to prove the path is taken.

What is compared, and what is not counted against sampling:

* Both look at the same pairs: the robot's links that a joint moves against each other, less those that the SRDF, the
  problem or the scene allows, and moving links against obstacles.
* Samples are spread so that each stretch uses the whole step: where the fastest point slows down they lie farther
  apart. No even spread with the same promise has fewer.
* Sampling CPU is the process's time in the loop over configurations made beforehand, one call each, less what as many
  calls cost on an empty robot in an empty scene: Python and its bindings are not counted.
* Each path takes the fastest of three ways, found on some of its samples: every pair (`pairs`), a broad phase over the
  bodies (`bodies`), or over the links (`links`), both with coal's dynamic box tree.
* taut's figure is wall time of one thread, a median of several runs, and its proof keeps a clearance besides.
"""

import argparse
import dataclasses
import gc
import itertools
import json
import math
import os
import pathlib
import statistics
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # threads that wait busily would count as CPU time
try:
    import numpy as np
    import pinocchio as pin
    import coal
except ImportError as error:
    sys.exit(f"{error}; next: pip install pin==4.1.0 coal==3.0.3 numpy==2.4.6")

# Motion between two configurations at which the path's speed is looked at (rad or m).
SPEED_STEP = 0.02
# Samples on which the three ways of checking are compared, and calls on the empty robot.
PROBES, EMPTY_CALLS = 200, 20_000
DIRECTIONS = np.array([d for d in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(d)])
UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}


class Refused(Exception):
    """A problem that cannot be run, with the reason in one line."""


@dataclasses.dataclass
class Row:
    """What was measured on one problem; times in seconds."""

    name: str
    samples: int = 0
    sampled_s: float = 0.0
    way: str = ""
    overhead_s: float = 0.0
    collides_with: str = ""
    proof_s: float = 0.0
    proved: bool = False
    error: str = ""

    @property
    def ratio(self):
        """Sampling over proof, where both find the path free."""
        return self.sampled_s / self.proof_s if self.proved and not self.collides_with and not self.error else None


class Problem:
    """A robot and a scene in pinocchio, and a path."""

    def __init__(self, file):
        self.text = json.loads(file.read_text())
        if self.text.get("format") != "taut-problem/1":
            raise Refused(f"its format is {self.text.get('format')!r}; valid: 'taut-problem/1'")
        self.folder, robot = file.parent, self.text["robot"]
        self.virtual = robot.get("virtual_joint")
        kind = self.virtual["type"] if self.virtual else "fixed"
        roots = {"fixed": None, "planar": pin.JointModelPlanar(), "floating": pin.JointModelFreeFlyer()}
        if kind not in roots:
            raise Refused(f"virtual joint has the type {kind!r}; valid types: {', '.join(roots)}")
        self.kind, urdf = kind, str(self.folder / robot["urdf"])
        # pinocchio looks for package://NAME below the parents of the packages' folders.
        packages = [str((self.folder / folder).resolve().parent) for folder in robot.get("packages", {}).values()]
        packages.append(str(pathlib.Path(urdf).parent))
        self.model = pin.buildModelFromUrdf(urdf, *([roots[kind]] if roots[kind] else []))
        self.geometry = pin.buildGeomFromUrdf(self.model, urdf, pin.GeometryType.COLLISION, package_dirs=packages)
        self.names = [self.model.frames[g.parentFrame].name for g in self.geometry.geometryObjects]
        self.robot_bodies = len(self.names)
        self.add_obstacles()
        self.add_pairs()
        self.columns = Columns(self)

    def add_obstacles(self):
        scene = self.text["scene"]
        for field in ("attached_collision_objects", "link_padding", "forbidden_collisions"):
            if scene.get(field):
                raise Refused(f"its scene has {field}, which this comparison does not know; leave the problem out")
        for item in scene["objects"]:
            whole = pose(item.get("pose", {}))
            shapes = [primitive(shape) for shape in item.get("primitives", [])]
            for mesh in item.get("meshes", []):
                scale = np.array(mesh.get("scale", [1.0, 1.0, 1.0]), float)
                shapes.append(coal.MeshLoader().load(str(self.folder / mesh["file"]), scale))
            placements = item.get("primitive_poses", []) + item.get("mesh_poses", [])
            for shape, placement in zip(shapes, placements, strict=True):
                name = f"{item['id']}#{len(self.names)}"
                self.geometry.addGeometryObject(pin.GeometryObject(name, 0, 0, whole * pose(placement), shape))
                self.names.append(item["id"])

    def add_pairs(self):
        robot, links = self.text["robot"], set(self.names[: self.robot_bodies])
        srdf = self.folder / robot["srdf"] if robot.get("srdf") else None
        allowed = disabled_pairs(srdf, links) if srdf else set()
        for pair in robot.get("allowed_collisions", []) + self.text["scene"].get("allowed_collisions", []):
            allowed.add(frozenset(pair))
        joints = [g.parentJoint for g in self.geometry.geometryObjects]
        for a, b in itertools.combinations(range(len(joints)), 2):
            # The world is joint 0, and an obstacle is part of it.
            if joints[a] != joints[b] and frozenset((self.names[a], self.names[b])) not in allowed:
                is_static = 0 in (joints[a], joints[b]) and max(a, b) >= self.robot_bodies
                if not is_static or joints[a] != 0:
                    self.geometry.addCollisionPair(pin.CollisionPair(a, b))

    def samples(self, step):
        """Configurations on the path, as an array of rows, between which no body's point travels more than `step`."""
        data, geometry_data = self.model.createData(), self.geometry.createData()
        moving = [i for i, g in enumerate(self.geometry.geometryObjects) if g.parentJoint != 0]
        hulls = [support_points(self.geometry.geometryObjects[i].geometry) for i in moving]

        def points(q):
            pin.updateGeometryPlacements(self.model, data, self.geometry, geometry_data, q)
            placed = ((hull, geometry_data.oMg[i]) for i, hull in zip(moving, hulls))
            return np.concatenate([hull @ at.rotation.T + at.translation for hull, at in placed])

        rows = [np.asarray(row, float) for row in self.text["path"]]
        parts = []
        for start, end in zip(rows, rows[1:]):
            way = self.columns.way(start, end)
            grid = np.linspace(0.0, 1.0, 1 + max(1, math.ceil(np.abs(end - start).max() / SPEED_STEP)))
            where = [points(q) for q in self.columns.configurations(way(grid))]
            travel = [np.linalg.norm(b - a, axis=1).max() for a, b in zip(where, where[1:])]
            travelled = np.concatenate([[0.0], np.cumsum(travel)])
            count = max(1, math.ceil(travelled[-1] / step))
            parts.append(way(np.interp(np.arange(count) / count * travelled[-1], travelled, grid)))
        return self.columns.configurations(np.concatenate([*parts, rows[-1][None]]))

    def ways(self):
        """The ways to check a configuration, by name: functions from a configuration to whether it collides."""
        return ways(self.model, self.geometry)

    def contact(self, q):
        """Names of the first pair that touches at a configuration."""
        data, geometry_data = self.model.createData(), self.geometry.createData()
        pin.computeCollisions(self.model, data, self.geometry, geometry_data, q, False)
        hits = (k for k, result in enumerate(geometry_data.collisionResults) if result.isCollision())
        pair = self.geometry.collisionPairs[next(hits)]
        return f"{self.names[pair.first]} × {self.names[pair.second]}"


class Columns:
    """How a path's columns become pinocchio's coordinates, and how they move on a straight segment."""

    def __init__(self, problem):
        self.model, variables = problem.model, problem.text["variables"]
        self.single, self.continuous, self.base, self.kind = [], [], None, problem.kind
        joints = {name: j for j, name in enumerate(self.model.names) if j > 0}
        wide = {"planar": 3, "floating": 7}.get(problem.kind, 0)
        if wide:
            prefix = problem.virtual["name"] + "/"
            self.base = next((i for i, name in enumerate(variables) if name.startswith(prefix)), None)
            if self.base is None:
                raise Refused(f"no variable begins with {prefix!r}")
            joints.pop("root_joint")
        for column, name in enumerate(variables):
            if self.base is not None and self.base <= column < self.base + wide:
                continue
            if name not in joints:
                raise Refused(f"variable {name!r} is no joint of one coordinate; joints: {', '.join(joints)}")
            joint = joints.pop(name)
            self.single.append((column, self.model.idx_qs[joint], self.model.nqs[joint]))
            if self.model.nqs[joint] == 2:
                self.continuous.append(column)
        if joints:
            raise Refused(f"joint {next(iter(joints))!r} is no variable; this comparison moves every joint")
        if self.kind == "planar":
            self.continuous.append(self.base + 2)

    def way(self, start, end):
        """The straight segment, as a function from times in 0..1 to rows: turns go the shorter way round."""
        delta = end - start
        delta[self.continuous] = (delta[self.continuous] + math.pi) % (2 * math.pi) - math.pi

        def rows(times):
            moved = start + np.outer(times, delta)
            if self.kind == "floating":
                turn = slice(self.base + 3, self.base + 7)
                moved[:, turn] = slerp(start[turn], end[turn], times)
            return moved

        return rows

    def configurations(self, rows):
        """pinocchio's coordinates of rows."""
        q = np.zeros((len(rows), self.model.nq))
        for column, at, wide in self.single:
            if wide == 2:
                q[:, at], q[:, at + 1] = np.cos(rows[:, column]), np.sin(rows[:, column])
            else:
                q[:, at] = rows[:, column]
        base = self.base
        if self.kind == "planar":
            q[:, :2] = rows[:, base : base + 2]
            q[:, 2], q[:, 3] = np.cos(rows[:, base + 2]), np.sin(rows[:, base + 2])
        elif self.kind == "floating":
            q[:, :7] = rows[:, base : base + 7]
        return q


def slerp(a, b, times):
    """Quaternions on the shorter arc from a to b."""
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    b = b if a @ b >= 0 else -b
    angle = math.acos(min(1.0, a @ b))
    if angle < 1e-9:
        return np.tile(b, (len(times), 1))
    return (np.outer(np.sin((1 - times) * angle), a) + np.outer(np.sin(times * angle), b)) / math.sin(angle)


def pose(text):
    """A placement from MoveIt's pose."""
    o = text.get("orientation", {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0})
    turn = pin.Quaternion(float(o["w"]), float(o["x"]), float(o["y"]), float(o["z"])).normalized()
    return pin.SE3(turn.matrix(), np.array(text.get("position", [0.0, 0.0, 0.0]), float))


def primitive(shape):
    """coal's shape for a primitive of a scene."""
    kind, sizes = shape["type"], shape["dimensions"]
    makers = {
        "box": lambda x, y, z: coal.Box(x, y, z),
        "sphere": lambda radius: coal.Sphere(radius),
        "cylinder": lambda height, radius: coal.Cylinder(radius, height),
        "capsule": lambda length, radius: coal.Capsule(radius, length),
    }
    if kind not in makers:
        raise Refused(f"a primitive has the type {kind!r}; valid types: {', '.join(makers)}")
    return makers[kind](*map(float, sizes))


def support_points(shape):
    """Points of a shape that lie farthest in some directions: they travel as far as any, or little less."""
    if isinstance(shape, coal.Box):
        return np.sign(DIRECTIONS) * np.asarray(shape.halfSide).reshape(3)
    if isinstance(shape, coal.Sphere):
        return shape.radius * DIRECTIONS / np.linalg.norm(DIRECTIONS, axis=1)[:, None]
    along = DIRECTIONS * [0.0, 0.0, 1.0]
    if isinstance(shape, coal.Capsule):
        return shape.radius * DIRECTIONS / np.linalg.norm(DIRECTIONS, axis=1)[:, None] + shape.halfLength * along
    if isinstance(shape, coal.Cylinder):
        across = DIRECTIONS * [1.0, 1.0, 0.0]
        norms = np.maximum(np.linalg.norm(across, axis=1), 1.0)[:, None]
        return shape.radius * across / norms + shape.halfLength * along
    if isinstance(shape, coal.BVHModelBase):
        vertices = np.asarray(shape.vertices())
        return vertices[np.unique((vertices @ DIRECTIONS.T).argmax(axis=0))]
    raise Refused(f"a link has the shape {type(shape).__name__}, which this comparison does not know")


def disabled_pairs(srdf, links):
    """Pairs of links that an SRDF leaves out."""
    root = ElementTree.parse(srdf).getroot()
    pairs = lambda tag: {frozenset((e.get("link1"), e.get("link2"))) for e in root.findall(tag)}
    without = {e.get("link") for e in root.findall("disable_default_collisions")}
    disabled = {frozenset((a, b)) for a in without for b in links if a != b}
    return (disabled - pairs("enable_collisions")) | pairs("disable_collisions")


def ways(model, geometry):
    """See Problem.ways; an empty model and geometry give what the calls themselves cost."""
    data, geometry_data = model.createData(), geometry.createData()
    managers = {
        "bodies": pin.BroadPhaseManager_DynamicAABBTreeCollisionManager,
        "links": pin.TreeBroadPhaseManager_DynamicAABBTreeCollisionManager,
    }
    made = {name: manager(model, geometry, geometry.createData()) for name, manager in managers.items()}
    return {
        "pairs": lambda q: pin.computeCollisions(model, data, geometry, geometry_data, q, True),
        "bodies": lambda q: pin.computeCollisions(model, data, made["bodies"], q, True),
        "links": lambda q: pin.computeCollisions(model, data, made["links"], q, True),
    }


def timed(check, configurations):
    """CPU time until the first collision (s), and its index or None."""
    hit = None
    gc.disable()
    start = time.process_time()
    for index, q in enumerate(configurations):
        if check(q):
            hit = index
            break
    spent = time.process_time() - start
    gc.enable()
    return spent, hit


def call_costs():
    """CPU time of one call on an empty robot in an empty scene (s), by way: Python, the bindings, the loop."""
    nothing = [np.zeros(0)] * EMPTY_CALLS
    empty = ways(pin.Model(), pin.GeometryModel())
    return {name: min(timed(check, nothing)[0] for _ in range(3)) / EMPTY_CALLS for name, check in empty.items()}


def sample(problem, row, step, costs):
    """Fills in what sampling finds and costs."""
    configurations = list(problem.samples(step))
    checks = problem.ways()
    probes = configurations[:: max(1, len(configurations) // PROBES)]
    verdicts = {name: timed(check, probes) for name, check in checks.items()}
    if len({hit for _, hit in verdicts.values()}) > 1:
        raise Refused(f"coal's ways disagree on the first collision: {verdicts}")
    row.way = min(verdicts, key=lambda name: verdicts[name][0] - costs[name] * len(probes))
    spent, hit = timed(checks[row.way], configurations)
    row.samples = len(configurations) if hit is None else hit + 1
    row.overhead_s = costs[row.way] * row.samples
    row.sampled_s = max(0.0, spent - row.overhead_s)
    row.collides_with = "" if hit is None else problem.contact(configurations[hit])


def prove(taut, file, row):
    """Fills in what taut finds and how long it takes."""
    command = [taut, "bench", "--check", str(file.parent), "--geometry", "given", "--format", "json"]
    result = subprocess.run([*command, "--filter", file.stem], capture_output=True, text=True)
    if result.returncode not in (0, 65):
        raise Refused(f"taut: {result.stderr.strip() or result.returncode}")
    found = next(r for r in json.loads(result.stdout)["rows"] if r["name"] == file.stem and "/" not in r["set"])
    if found["error"]:
        raise Refused(f"taut: {found['error']}")
    row.proof_s, row.proved = found["proof_s"], found["proved"]


def cells(row):
    """A row of the table."""
    if row.error:
        return f"{row.name:<36} {row.error}"
    ratio = "-" if row.ratio is None else f"{row.ratio:.0f}"
    sampled, proved = row.collides_with or "free", "proved" if row.proved else "refused"
    return (f"{row.name:<36} {row.samples:>8} {row.sampled_s * 1e3:>10.1f} {row.overhead_s * 1e3:>8.1f} {row.way:>7} "
            f"{row.proof_s * 1e3:>9.3f} {proved:>8} {ratio:>6}  {sampled}")


def summary(name, rows):
    """The medians of a set."""
    ran = [row for row in rows if not row.error]
    both = [row for row in ran if row.ratio is not None]
    hits = [row for row in ran if row.collides_with]
    text = (f"{name}: {len(ran)} of {len(rows)} run; {len(both)} free and proved, {len(hits)} colliding "
            f"({sum(row.proved for row in hits)} of them proved), "
            f"{sum(not row.proved and not row.collides_with for row in ran)} free where sampled but refused")
    if both:
        middle = lambda values: statistics.median(values)
        ratios = [row.ratio for row in both]
        text += (f"\n  medians of the free and proved: {middle([r.samples for r in both]):.0f} samples, "
                 f"{middle([r.sampled_s for r in both]) * 1e3:.1f} ms sampling, "
                 f"{middle([r.proof_s for r in both]) * 1e3:.3f} ms proof; "
                 f"sampling ÷ proof {middle(ratios):.0f} (worst {min(ratios):.0f}, best {max(ratios):.0f}), "
                 f"all together {sum(r.sampled_s for r in both) / sum(r.proof_s for r in both):.0f}")
    return text


def metres(text):
    """A length: 1mm, 0.5cm, or metres."""
    unit = next((unit for unit in UNITS if text.endswith(unit)), "")
    try:
        value = float(text.removesuffix(unit)) * UNITS.get(unit, 1.0)
    except ValueError:
        value = math.nan
    if not (0.0 < value < math.inf):
        raise argparse.ArgumentTypeError(f"{text!r} is no positive length; valid: 1mm, 0.5cm, 0.001 (metres)")
    return value


def spread(files, limit):
    """At most `limit` of the files, evenly over all of them."""
    return files if limit is None or limit >= len(files) else [files[k * len(files) // limit] for k in range(limit)]


def main():
    parser = argparse.ArgumentParser(description="Dense sampling with coal beside taut's proofs, on the same paths.")
    parser.add_argument("folders", nargs="+", type=pathlib.Path, metavar="FOLDER", help="folder with problem files")
    parser.add_argument("--limit", type=int, help="at most this many problems of each folder, evenly spread")
    parser.add_argument("--step", type=metres, default=1e-3, help="travel between samples (default 1mm)")
    parser.add_argument("--taut", default="target/release/taut", help="taut's binary (default %(default)s)")
    arguments = parser.parse_args()
    if not pathlib.Path(arguments.taut).is_file():
        sys.exit(f"no taut at {arguments.taut}; next: cargo build --release, or name it with --taut")
    sets = {}
    for folder in arguments.folders:
        for file in sorted(folder.rglob("*.json")):
            sets.setdefault(file.parent, []).append(file)
    if not sets:
        sys.exit(f"no .json file below {', '.join(map(str, arguments.folders))}")
    costs = call_costs()
    print("an empty call costs " + ", ".join(f"{cost * 1e6:.2f} µs ({name})" for name, cost in costs.items()))
    print(f"{'problem':<36} {'samples':>8} {'CPU ms':>10} {'less ms':>8} {'way':>7} {'proof ms':>9} {'taut':>8} "
          f"{'ratio':>6}  sampled", flush=True)
    summaries, failed = [], False
    for folder, files in sets.items():
        rows = []
        for file in spread(files, arguments.limit):
            row = Row(f"{folder.name}/{file.stem}")
            try:
                sample(Problem(file), row, arguments.step, costs)
                prove(arguments.taut, file, row)
            except (Refused, OSError, ValueError, KeyError) as error:
                row.error = f"{type(error).__name__}: {error}" if not isinstance(error, Refused) else str(error)
            rows.append(row)
            print(cells(row), flush=True)
        failed = failed or any(row.error for row in rows)
        summaries.append(summary(folder.name, rows))
    print("\n" + "\n".join(summaries))
    sys.exit(65 if failed else 0)


if __name__ == "__main__":
    main()
