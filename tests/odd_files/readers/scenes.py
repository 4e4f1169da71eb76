"""Scenes: MoveIt's messages by their definitions, twice, and its `.scene` text.

moveit_msgs/CollisionObject: `pose` in the frame `header.frame_id`, shapes' poses in the frame of `pose`.
shape_msgs/SolidPrimitive: BOX 1 (x y z), SPHERE 2 (radius), CYLINDER 3 (height, radius).
A quaternion of zeros is one that was not set: MoveIt takes it for the identity, with a warning.
moveit_msgs/AllowedCollisionMatrix: a pair is allowed where either of its two entries is true.
"""

import numpy as np

from . import robots, surfaces

KINDS = {1: "box", 2: "sphere", 3: "cylinder", "box": "box", "sphere": "sphere", "cylinder": "cylinder"}


def by_pyyaml(file):
    import yaml

    return evaluated(file, lambda text: list(yaml.safe_load_all(text)), Matrices)


def by_ruamel(file):
    import ruamel.yaml

    load = ruamel.yaml.YAML(typ="safe", pure=True)
    return evaluated(file, lambda text: list(load.load_all(text)), Rotations)


class Matrices:
    """Poses as 4 × 4 matrices, written out."""

    @staticmethod
    def pose(position, xyzw):
        return robots.matrix(position, xyzw)

    @staticmethod
    def times(a, b):
        return a @ b

    @staticmethod
    def numbers(pose):
        return robots.pose(pose)


class Rotations:
    """Poses as a position and a rotation of SciPy's."""

    @staticmethod
    def pose(position, xyzw):
        from scipy.spatial.transform import Rotation

        return np.asarray(position, float), Rotation.from_quat(xyzw)

    @staticmethod
    def times(a, b):
        return a[0] + a[1].apply(b[0]), a[1] * b[1]

    @staticmethod
    def numbers(pose):
        q = pose[1].as_quat()
        first = next(c for c in (q[3], q[0], q[1], q[2]) if abs(c) > 1e-9)
        return list(pose[0]) + list(q * np.sign(first))


def evaluated(file, load, algebra):
    if file.suffix == ".scene":
        return of_text(file.read_text(encoding="utf-8"), algebra)
    documents = [d for d in load(file.read_bytes()) if d is not None]
    if len(documents) != 1:
        raise ValueError(f"{len(documents)} documents")
    scene = documents[0]
    world = scene.get("world", {"collision_objects": scene.get("objects", [])})
    if ((world.get("octomap") or {}).get("octomap") or {}).get("data"):
        raise ValueError("an octomap, which is not evaluated here")
    if scene.get("is_diff"):
        raise ValueError("a diff")
    # MoveIt's transforms are from the world, their child, to the frame that the header names.
    name_of = lambda t: t.get("header", {}).get("frame_id") or t["child_frame_id"]
    frames = {name_of(t): of_pose(t.get("transform"), algebra, "translation", "rotation") for t in scene.get("fixed_frame_transforms", [])}
    identity = algebra.pose([0, 0, 0], [0, 0, 0, 1])
    objects, placed = {}, {}
    for o in world["collision_objects"]:
        name = o.get("header", {}).get("frame_id", "").removeprefix("/")
        frame = identity if name == "" else frames.get(name, placed.get(name))
        if frame is None:
            raise ValueError(f"no frame {name!r}")
        placed[o["id"]] = algebra.times(frame, of_pose(o.get("pose"), algebra))
        objects[str(o["id"])] = shapes(o, placed[o["id"]], algebra)
    attached = {}
    for a in scene.get("robot_state", {}).get("attached_collision_objects", []):
        o, frame = a["object"], a["object"].get("header", {}).get("frame_id", "")
        if frame not in ("", a["link_name"]):
            raise ValueError(f"no frame {frame!r}")
        own = shapes(o, of_pose(o.get("pose"), algebra), algebra)
        attached[o["id"]] = {"link": a["link_name"], "touch": sorted(a["touch_links"]), "shapes": own}
    allowed = allowed_pairs(scene.get("allowed_collision_matrix", {}))
    padding = {p["link_name"]: p["padding"] for p in scene.get("link_padding", []) if p["padding"] != 0}
    scale = {s["link_name"]: s["scale"] for s in scene.get("link_scale", []) if s["scale"] != 1}
    return {"objects": objects, "attached": attached, "allowed": allowed, "padding": padding, "scale": scale}


def of_pose(pose, algebra, position="position", orientation="orientation"):
    pose = pose or {}
    p, q = pose.get(position, {}), pose.get(orientation, {"w": 1.0})
    p = p if isinstance(p, list) else [p.get(c, 0.0) for c in "xyz"]
    q = q if isinstance(q, list) else [q.get(c, 0.0) for c in "xyzw"]
    if not np.isfinite(p).all():
        raise ValueError(f"a position of {p}")
    length = np.linalg.norm(q)
    q = [0, 0, 0, 1] if length == 0 else q
    if length != 0 and abs(length - 1) > 1e-3:
        raise ValueError(f"a quaternion of length {length}")
    return algebra.pose(p, q)


def shapes(o, at, algebra):
    found = []
    unknown = set(o) - {"header", "pose", "id", "type", "primitives", "primitive_poses", "meshes", "mesh_poses", "planes", "plane_poses", "subframe_names", "subframe_poses", "operation"}
    if unknown or o.get("planes"):
        raise ValueError(f"no message has {unknown or 'a plane that ends'}")
    if len(o.get("primitives", [])) != len(o.get("primitive_poses", [])):
        raise ValueError("not a pose for each primitive")
    for primitive, pose in zip(o.get("primitives", []), o.get("primitive_poses", [])):
        kind = primitive["type"]
        kind = KINDS[kind.lower() if isinstance(kind, str) else kind]
        sizes = [float(d) for d in primitive["dimensions"]]
        if len(sizes) != {"box": 3, "sphere": 1, "cylinder": 2}[kind] or min(sizes) < 0:
            raise ValueError(f"a {kind} of {sizes}")
        sizes = sizes[::-1] if kind == "cylinder" else sizes
        found.append([kind, sizes, algebra.numbers(algebra.times(at, of_pose(pose, algebra)))])
    for mesh, pose in zip(o.get("meshes", []), o.get("mesh_poses", [])):
        vertices = np.array([[v["x"], v["y"], v["z"]] for v in mesh["vertices"]])
        faces = [t["vertex_indices"] for t in mesh["triangles"]]
        found.append(["mesh", robots.of_mesh(vertices[faces]), algebra.numbers(algebra.times(at, of_pose(pose, algebra)))])
    return found


def allowed_pairs(matrix):
    names, rows = matrix.get("entry_names", []), matrix.get("entry_values", [])
    rows = [row["enabled"] if isinstance(row, dict) else row for row in rows]
    if any(len(row) != len(names) for row in rows):
        raise ValueError("a matrix that is not square")
    pairs = [(i, j) for i in range(len(names)) for j in range(i) if rows[i][j] or rows[j][i]]
    return sorted(sorted((names[i], names[j])) for i, j in pairs)


def of_text(text, algebra):
    """As moveit's PlanningScene reads the stream: names to the ends of their lines, then words."""
    lines = text.replace("\r\n", "\n").split("\n")
    first = next((i for i, line in enumerate(lines) if line.startswith("*")), None)
    newer = first is not None and len(lines[first + 1].split()) > 1
    rest = "\n".join(lines[1:])
    objects = {}

    def word():
        nonlocal rest
        stripped = rest.lstrip()
        if not stripped:
            raise ValueError("the text ends too early")
        found = stripped.split(None, 1)[0]
        rest = stripped[len(found):]
        return found

    def numbers(count):
        return [float(word()) for _ in range(count)]

    def pose():
        return algebra.pose(numbers(3), numbers(4))

    while True:
        marker = word()
        if marker == ".":
            break
        name, _, rest = rest.partition("\n")
        at = pose() if newer else algebra.pose([0, 0, 0], [0, 0, 0, 1])
        found = []
        for _ in range(int(word())):
            kind = word()
            if kind == "mesh":
                vertices, triangles = int(word()), int(word())
                vertices = np.array([numbers(3) for _ in range(vertices)])
                faces = [[int(word()) for _ in range(3)] for _ in range(triangles)]
                sizes = robots.of_mesh(vertices[faces])
            else:
                sizes = numbers({"box": 3, "sphere": 1, "cylinder": 2}[kind])
            placed = pose()
            numbers(4)
            found.append([kind, sizes, algebra.numbers(algebra.times(at, placed))])
        if newer:
            for _ in range(int(word())):
                word()
                pose()
        objects[name.strip()] = found
    return {"objects": objects, "attached": {}, "allowed": [], "padding": {}, "scale": {}}


READERS = {"messages-pyyaml": by_pyyaml, "messages-ruamel": by_ruamel}
