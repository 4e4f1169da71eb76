"""A `taut-problem/1` file in pinocchio and coal, for dense_sampling.py: robot, scene, pairs, and the path's samples."""

import itertools
import json
import math
import pathlib
from xml.etree import ElementTree

import coal
import numpy as np
import pinocchio as pin

# Motion between two configurations at which the path's speed is looked at (rad or m).
SPEED_STEP = 0.02
# How many configurations around a path, and how far around (rad or m).
AROUND, AROUND_BY = 300, 0.7
DIRECTIONS = np.array([d for d in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(d)])


class Refused(Exception):
    """A problem that cannot be run, with the reason in one line."""


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
        for start, end in itertools.pairwise(rows):
            way = self.columns.way(start, end)
            grid = np.linspace(0.0, 1.0, 1 + max(1, math.ceil(np.abs(end - start).max() / SPEED_STEP)))
            where = [points(q) for q in self.columns.configurations(way(grid))]
            travel = [np.linalg.norm(b - a, axis=1).max() for a, b in itertools.pairwise(where)]
            travelled = np.concatenate([[0.0], np.cumsum(travel)])
            count = max(1, math.ceil(travelled[-1] / step))
            parts.append(way(np.interp(np.arange(count) / count * travelled[-1], travelled, grid)))
        return self.columns.configurations(np.concatenate([*parts, rows[-1][None]]))

    def around(self, configurations):
        """Configurations near some of those given, many of them colliding."""
        chance = np.random.default_rng(0)
        some = chance.integers(len(configurations), size=AROUND)
        shake = lambda: chance.normal(scale=AROUND_BY, size=self.model.nv)
        return [pin.integrate(self.model, configurations[k], shake()) for k in some]

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
