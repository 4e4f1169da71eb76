"""A problem file (taut-problem/1) as planners need it: robot and scene in pinocchio and coal.

What is here knows nothing of taut's own collision code: the same URDF, SRDF and scene are read by
pinocchio, and every check is coal's. So it serves planners as their validity check, and the
comparison as an independent judge.
"""

import json
import math
import re
import xml.etree.ElementTree as xml
from dataclasses import dataclass
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin

FORMAT = "taut-problem/1"


class Refused(Exception):
    """A problem that these scripts cannot plan, and why."""


@dataclass(frozen=True)
class Part:
    """Some columns of a path and the numbers of a pinocchio configuration that they are.

    kind: "number" (radians or metres), "angle" (a joint without end, cos and sin in pinocchio) or
    "rotation" (a quaternion x y z w in four columns); lower and upper bound a number.
    """

    kind: str
    column: int
    index: int
    lower: float = -math.inf
    upper: float = math.inf


class Problem:
    """A robot in a scene, with a start and a goal."""

    def __init__(self, file, spheres=False):
        """Reads a file; with `spheres`, the robot's sphere model is taken where the problem has one."""
        self.file = Path(file).resolve()
        try:
            text = json.loads(self.file.read_text())
        except (OSError, ValueError) as error:
            raise Refused(f"{file} cannot be read: {error}") from None
        if text.get("format") != FORMAT:
            raise Refused(f"{file} has the format {text.get('format')!r}; valid: {FORMAT!r}")
        self.name = text["name"]
        self.columns = text["variables"]
        self.robot, self.scene = text["robot"], text["scene"]
        for field in ("link_padding", "link_scale", "forbidden_collisions"):
            if self.scene.get(field):
                raise Refused(f"{file} has {field}, which these scripts do not read; `taut shorten` does")
        self.folder = self.file.parent
        self.spheres = spheres and bool(self.robot.get("spherized_urdf"))
        urdf = self.robot["spherized_urdf" if self.spheres else "urdf"]
        self.urdf = plain_urdf(self.folder / urdf, self.packages())
        self.srdf = self._text(self.robot.get("srdf"))
        joint = self.robot.get("virtual_joint")
        self.base = joint["type"] if joint and joint["type"] != "fixed" else None
        self.model = pin.buildModelFromXML(self.urdf, *root_joint(self.base))
        self.parts = self._parts(joint)
        self.geometry = self._geometry()
        self._data, self._seen = self.model.createData(), self.geometry.createData()
        self.start, self.goal = np.array(text["path"][0], float), np.array(text["path"][-1], float)

    def packages(self):
        """Folders of the packages that `package://` names, by name."""
        return {name: (self.folder / folder).resolve() for name, folder in self.robot.get("packages", {}).items()}

    def configuration(self, row):
        """A row of the path as pinocchio's configuration."""
        q = pin.neutral(self.model)
        for part in self.parts:
            value = row[part.column]
            if part.kind == "angle":
                q[part.index : part.index + 2] = math.cos(value), math.sin(value)
            elif part.kind == "rotation":
                q[part.index : part.index + 4] = row[part.column : part.column + 4]
            else:
                q[part.index] = value
        return q

    def row(self, q):
        """pinocchio's configuration as a row of the path."""
        row = np.zeros(len(self.columns))
        for part in self.parts:
            if part.kind == "angle":
                row[part.column] = math.atan2(q[part.index + 1], q[part.index])
            elif part.kind == "rotation":
                turn = np.array(q[part.index : part.index + 4])
                row[part.column : part.column + 4] = turn / np.linalg.norm(turn)
            else:
                row[part.column] = q[part.index]
        return row

    def free(self, q):
        """Whether nothing overlaps at a configuration."""
        return not pin.computeCollisions(self.model, self._data, self.geometry, self._seen, q, True)

    def length(self, path):
        """Length of a path, every joint weighted with 1, in radians and metres together."""
        q = [self.configuration(row) for row in path]
        return sum(float(np.linalg.norm(pin.difference(self.model, a, b))) for a, b in zip(q, q[1:]))

    def collision(self, path, step):
        """Where a path collides, looked at every `step` (radians and metres together): None, or
        (segment, share of the segment, the two bodies)."""
        q = [self.configuration(row) for row in path]
        for segment, (a, b) in enumerate(zip(q, q[1:])):
            pieces = max(1, math.ceil(float(np.linalg.norm(pin.difference(self.model, a, b))) / step))
            for piece in range(pieces + 1):
                if not self.free(pin.interpolate(self.model, a, b, piece / pieces)):
                    return segment, piece / pieces, self._overlapping()
        return None

    def sample(self, random):
        """A configuration within the limits, uniformly; `random` is numpy's generator."""
        q = pin.neutral(self.model)
        for part in self.parts:
            if part.kind == "angle":
                turn = random.uniform(-math.pi, math.pi)
                q[part.index : part.index + 2] = math.cos(turn), math.sin(turn)
            elif part.kind == "rotation":
                turn = random.normal(size=4)
                q[part.index : part.index + 4] = turn / np.linalg.norm(turn)
            else:
                q[part.index] = random.uniform(part.lower, part.upper)
        return q

    def query(self, number, step=0.02):
        """Start and goal of query `number`: 0 is the file's own, others are sampled until both are
        free and the straight line between them is not, so that there is something to plan."""
        if number == 0:
            return self.start, self.goal
        random = np.random.default_rng(number)
        for _ in range(10_000):
            ends = []
            while len(ends) < 2:
                q = self.sample(random)
                if self.free(q):
                    ends.append(self.row(q))
            if self.collision(ends, step):
                return ends[0], ends[1]
        raise Refused(f"{self.file.name}: 10,000 pairs of free configurations, and a straight line joins each")

    def _overlapping(self):
        for index, pair in enumerate(self.geometry.collisionPairs):
            if self._seen.collisionResults[index].isCollision():
                return tuple(self._body(end) for end in (pair.first, pair.second))
        raise AssertionError("a collision without a pair")

    def _body(self, index):
        shape = self.geometry.geometryObjects[index]
        return shape.name if shape.parentJoint == 0 and shape.name in self._objects else shape.name.rsplit("_", 1)[0]

    def _text(self, name):
        return (self.folder / name).read_text() if name else None

    def _parts(self, virtual):
        parts, column = [], 0
        if self.base:
            bounds = virtual.get("position_bounds") or []
            places = 3 if self.base == "floating" else 2
            if len(bounds) != places:
                raise Refused(f"{self.file.name}: a {self.base} base needs {places} position_bounds to sample within")
            parts = [Part("number", index, index, *bound) for index, bound in enumerate(bounds)]
            parts.append(Part("rotation" if self.base == "floating" else "angle", places, places))
            column = 7 if self.base == "floating" else 3
        for place, name in enumerate(self.columns[column:], column):
            if not self.model.existJointName(name):
                raise Refused(f"{self.file.name}: column {name!r} is no joint of the URDF")
            joint = self.model.getJointId(name)
            index = self.model.idx_qs[joint]
            if self.model.nqs[joint] == 2:
                parts.append(Part("angle", place, index))
            else:
                limits = self.model.lowerPositionLimit[index], self.model.upperPositionLimit[index]
                parts.append(Part("number", place, index, *limits))
        if len(self.columns) - column != self.model.njoints - 1 - bool(self.base):
            missing = set(self.model.names[1 + bool(self.base) :]) - set(self.columns)
            raise Refused(f"{self.file.name}: no column for {', '.join(sorted(missing))}")
        return parts

    def _geometry(self):
        geometry = pin.buildGeomFromUrdfString(self.model, self.urdf, pin.GeometryType.COLLISION)
        solids = geometry.ngeoms
        geometry.addAllCollisionPairs()
        if self.srdf:
            pin.removeCollisionPairsFromXML(self.model, geometry, self.srdf, False)
        allowed = {frozenset(pair) for pair in self.robot.get("allowed_collisions", [])}
        if self.spheres:
            allowed |= {frozenset(pair) for pair in self.robot.get("spherized_allowed_collisions", [])}
        allowed |= {frozenset(pair) for pair in self.scene.get("allowed_collisions", [])}
        link = [shape.name.rsplit("_", 1)[0] for shape in geometry.geometryObjects]
        joint = [shape.parentJoint for shape in geometry.geometryObjects]
        for pair in list(geometry.collisionPairs):
            joined = self.model.parents[joint[pair.second]] == joint[pair.first]
            joined |= self.model.parents[joint[pair.first]] == joint[pair.second]
            if frozenset((link[pair.first], link[pair.second])) in allowed or (joined and not self.srdf):
                geometry.removeCollisionPair(pair)
        self._objects = {item["id"] for item in self.scene["objects"]}
        for name, shape, place in scene_shapes(self.scene, self.folder):
            obstacle = geometry.addGeometryObject(pin.GeometryObject(name, 0, 0, place, shape))
            for solid in range(solids):
                if joint[solid] != 0 and frozenset((link[solid], name)) not in allowed:
                    geometry.addCollisionPair(pin.CollisionPair(solid, obstacle))
        for held in self.scene.get("attached_collision_objects", []):
            self._attach(geometry, held)
        return geometry

    def _attach(self, geometry, held):
        """Adds an object that a link carries; its poses are of the link's frame."""
        carrier, given = held["link_name"], held["object"]
        frame = self.model.frames[self.model.getFrameId(carrier)]
        touched = {carrier, *held.get("touch_links", [])}
        others = [
            index
            for index, shape in enumerate(geometry.geometryObjects)
            if shape.name in self._objects or shape.name.rsplit("_", 1)[0] not in touched
        ]
        for name, shape, place in scene_shapes({"objects": [given]}, self.folder):
            solid = pin.GeometryObject(f"{name}_0", frame.parentJoint, 0, frame.placement * place, shape)
            index = geometry.addGeometryObject(solid)
            for other in others:
                if geometry.geometryObjects[other].parentJoint != frame.parentJoint:
                    geometry.addCollisionPair(pin.CollisionPair(other, index))


def root_joint(base):
    """pinocchio's root joint for a base, made of parts so that straight lines are straight in each
    (pinocchio's own FreeFlyer and Planar screw instead)."""
    if base is None:
        return ()
    pieces = {
        "planar": (pin.JointModelPX(), pin.JointModelPY(), pin.JointModelRUBZ()),
        "floating": (pin.JointModelTranslation(), pin.JointModelSpherical()),
    }[base]
    joint = pin.JointModelComposite()
    for piece in pieces:
        joint.addJoint(piece)
    return (joint,)


def plain_urdf(file, packages):
    """A URDF's text with full paths to its meshes and with capsules as pinocchio reads them (a
    cylinder that `collision_checking` names)."""
    tree = xml.parse(file).getroot()
    for mesh in tree.iter("mesh"):
        mesh.set("filename", str(mesh_file(mesh.get("filename"), file, packages)))
    for link in tree.iter("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
        checking = xml.Element("collision_checking")
        for number, solid in enumerate(link.findall("collision")):
            capsule = solid.find("geometry/capsule")
            if capsule is not None:
                capsule.tag = "cylinder"
                solid.set("name", f"{link.get('name')}_capsule{number}")
                xml.SubElement(checking, "capsule", name=solid.get("name"))
        if len(checking):
            link.append(checking)
    return xml.tostring(tree, encoding="unicode")


def mesh_file(name, urdf, packages):
    """The file that a URDF's mesh names."""
    found = re.match(r"package://([^/]+)/(.*)", name)
    if not found:
        return (urdf.parent / name.removeprefix("file://")).resolve()
    if found[1] not in packages:
        raise Refused(f"{urdf} names the package {found[1]!r}; the problem gives: {', '.join(packages) or 'none'}")
    return packages[found[1]] / found[2]


def scene_shapes(scene, folder):
    """Name, coal's shape and place of every shape of a scene."""
    for item in scene["objects"]:
        for part, pose in zip(item.get("primitives", []), item.get("primitive_poses", [])):
            sizes = part["dimensions"]
            if part["type"] == "box":
                shape = coal.Box(*sizes)
            elif part["type"] == "sphere":
                shape = coal.Sphere(sizes[0])
            elif part["type"] == "cylinder":
                shape = coal.Cylinder(sizes[1], sizes[0])
            else:
                raise Refused(f"object {item['id']!r} is a {part['type']}; valid here: box, sphere, cylinder")
            yield item["id"], shape, placement(pose)
        for mesh, pose in zip(item.get("meshes", []), item.get("mesh_poses", [])):
            scale = np.array(mesh.get("scale", [1, 1, 1]), float)
            yield item["id"], coal.MeshLoader().load(str(folder / mesh["file"]), scale), placement(pose)


def placement(pose):
    """A pose of a scene file as pinocchio's SE3."""
    turn = pose.get("orientation", {"x": 0, "y": 0, "z": 0, "w": 1})
    return pin.SE3(pin.Quaternion(turn["w"], turn["x"], turn["y"], turn["z"]), np.array(pose["position"], float))
