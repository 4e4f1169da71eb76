"""Robots: links' poses where the movable joints, in the order of their names, stand at 0.1, 0.2 …; limits; shapes."""

import math
import re

import numpy as np

from . import surfaces

PLANAR = [0.1, 0.2, 0.3]
FLOATING = [0.1, 0.2, 0.3, 0.0, 0.0, 0.6, 0.8]


def quaternion(rotation):
    """x y z w of a rotation matrix; w, or the first that is not 0, is positive."""
    m = np.asarray(rotation, float)
    trace = [m.trace(), m[0, 0], m[1, 1], m[2, 2]]
    i = int(np.argmax(trace))
    if i == 0:
        q = np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], 1 + trace[0]])
    else:
        a, b, c = [(0, 1, 2), (1, 2, 0), (2, 0, 1)][i - 1]
        q = np.zeros(4)
        q[a] = 1 + m[a, a] - m[b, b] - m[c, c]
        q[b], q[c], q[3] = m[b, a] + m[a, b], m[c, a] + m[a, c], m[c, b] - m[b, c]
    q /= np.linalg.norm(q)
    first = next(c for c in (q[3], q[0], q[1], q[2]) if abs(c) > 1e-9)
    return q * math.copysign(1, first)


def pose(matrix):
    matrix = np.asarray(matrix, float)
    return list(matrix[:3, 3]) + list(quaternion(matrix[:3, :3]))


def matrix(position, xyzw):
    x, y, z, w = np.asarray(xyzw, float) / np.linalg.norm(xyzw)
    out = np.eye(4)
    out[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    out[:3, 3] = position
    return out


def rpy(roll, pitch, yaw):
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in (roll, pitch, yaw))
    return np.array([
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ])


def mimics(file):
    """Names of the joints that hold a <mimic>: what is said about their limits is not compared."""
    text = file.read_bytes().decode("utf-8", "replace")
    joints = re.findall(r'<joint\s+name="([^"]*)"(.*?)</joint>', text, re.S)
    return {name.replace("&amp;", "&") for name, inner in joints if "<mimic" in inner}


def values(names):
    """A value for each movable joint."""
    return {name: 0.1 * (i + 1) for i, name in enumerate(sorted(names))}


def of_mesh(corners):
    surface = surfaces.measured(corners)["surface"]
    return list(surface["lo"]) + list(surface["hi"]) + [1e6 * surface["volume"]]


def result(poses, limits, shapes):
    shapes = {link: found for link, found in shapes.items() if found}
    return {"poses": poses, "limits": limits, "shapes": shapes}


def mesh_path(file, name):
    name = re.sub(r"^(package|model)://[^/]*/+", "", re.sub(r"^file://", "", name))
    return file.parent / name


def posed_by_pinocchio(file):
    """Poses of links and limits, without shapes."""
    import pinocchio as pin

    model = pin.buildModelFromUrdf(str(file), mimic=True)
    joints = {model.names[i]: model.joints[i] for i in range(1, model.njoints)}
    joints = {name: joint for name, joint in joints.items() if "Mimic" not in joint.shortname()}
    wanted, q, limits = values(joints), pin.neutral(model), {}
    for name, joint in joints.items():
        at, value = joint.idx_q, wanted[name]
        if joint.nq == 1:
            q[at] = value
            limits[name] = [end(model.lowerPositionLimit[at]), end(model.upperPositionLimit[at])]
        elif joint.nq == 2:
            q[at : at + 2] = [math.cos(value), math.sin(value)]
            limits[name] = [None, None]
        elif joint.nq == 4:
            q[at : at + 4] = [PLANAR[0], PLANAR[1], math.cos(PLANAR[2]), math.sin(PLANAR[2])]
        else:
            q[at : at + 7] = FLOATING
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    bodies = [(i, frame) for i, frame in enumerate(model.frames) if frame.type == pin.FrameType.BODY]
    return model, {"poses": {frame.name: pose(data.oMf[i].homogeneous) for i, frame in bodies}, "limits": limits}


def pinocchio(file):
    import pinocchio as pin

    model, posed = posed_by_pinocchio(file)
    packages = [str(file.parent.parent), str(file.parent)]
    geometry = pin.buildGeomFromUrdf(model, str(file), pin.GeometryType.COLLISION, package_dirs=packages)
    shapes = {}
    for shape in geometry.geometryObjects:
        frame = model.frames[shape.parentFrame]
        placement = pose((frame.placement.inverse() * shape.placement).homogeneous)
        shapes.setdefault(frame.name, []).append([*of_coal(shape.geometry, shape.meshScale), placement])
    return result(posed["poses"], posed["limits"], shapes)


def of_coal(shape, scale):
    import coal

    if isinstance(shape, coal.Box):
        return "box", list(2 * shape.halfSide)
    if isinstance(shape, coal.Sphere):
        return "sphere", [shape.radius]
    if isinstance(shape, coal.Cylinder):
        return "cylinder", [shape.radius, 2 * shape.halfLength]
    if isinstance(shape, coal.Capsule):
        return "capsule", [shape.radius, 2 * shape.halfLength]
    vertices = np.asarray(shape.vertices())
    corners = [vertices[[t[0], t[1], t[2]]] for t in map(shape.tri_indices, range(shape.num_tris))]
    # A mirrored mesh stays as it is wound in coal: volumes are compared as what they enclose.
    sizes = of_mesh(corners)
    if np.prod(scale) < 0:
        sizes[-1] = -sizes[-1]
    return "mesh", sizes


def of_file(file, name, scale):
    import trimesh

    path = mesh_path(file, name)
    mesh = trimesh.load(str(path), process=False, force="mesh")
    unit = 1.0
    if path.suffix.lower() == ".dae":
        import collada

        unit = collada.Collada(str(path)).assetInfo.unitmeter or 1.0
        mesh = None
        return "mesh", of_mesh(np.concatenate([p.vertex[p.vertex_index] for b in collada.Collada(str(path)).scene.objects("geometry") for p in b.primitives()]) * unit * scale)
    corners = mesh.triangles * scale
    if np.prod(scale) < 0:
        corners = corners[:, ::-1]
    return "mesh", of_mesh(corners)


def end(value):
    return None if value is None or abs(value) > 1e300 else value


def yourdfpy(file):
    import yourdfpy as y

    robot = y.URDF.load(str(file), load_meshes=False, build_scene_graph=True)
    errors = robot.errors if hasattr(robot, "errors") else []
    if errors:
        raise ValueError("; ".join(map(str, errors)))
    if any(joint.type in ("planar", "floating") for joint in robot.robot.joints):
        raise ValueError("its planar and floating joints are not posed")
    wanted = values([j.name for j in robot.robot.joints if j.type != "fixed" and j.mimic is None])
    robot.update_cfg({name: wanted[name] for name in robot.actuated_joint_names})
    limits = {}
    for joint in robot.robot.joints:
        if joint.mimic is not None or joint.type not in ("revolute", "prismatic", "continuous"):
            continue
        if joint.type == "continuous" or joint.limit is None:
            limits[joint.name] = [None, None]
            continue
        # As MoveIt's robot model: the soft limits bound the joint where they are given.
        lower, upper = joint.limit.lower, joint.limit.upper
        safe = joint.safety_controller
        if safe is not None:
            lower = max(x for x in (lower, safe.soft_lower_limit) if x is not None)
            upper = min(x for x in (upper, safe.soft_upper_limit) if x is not None)
        limits[joint.name] = [end(lower), end(upper)]
    base = robot.base_link
    poses = {link.name: pose(robot.get_transform(link.name, base)) for link in robot.robot.links}
    shapes = {}
    for link in robot.robot.links:
        for shape in link.collisions:
            g = shape.geometry
            placement = pose(np.eye(4) if shape.origin is None else shape.origin)
            shapes.setdefault(link.name, []).append([*of_words(file, g), placement])
    return result(poses, limits, shapes)


def of_words(file, g):
    if g.box is not None:
        return "box", list(g.box.size)
    if g.cylinder is not None:
        return "cylinder", [g.cylinder.radius, g.cylinder.length]
    if g.sphere is not None:
        return "sphere", [g.sphere.radius]
    if getattr(g, "capsule", None) is not None:
        return "capsule", [g.capsule.radius, g.capsule.length]
    if g.mesh is None:
        raise ValueError("a geometry without a shape")
    scale = np.ones(3) if g.mesh.scale is None else np.broadcast_to(g.mesh.scale, 3)
    return of_file(file, g.mesh.filename, scale)


def urchin(file):
    import urchin as u

    robot = u.URDF.load(str(file), lazy_load_meshes=True)
    moving = [j for j in robot.joints if j.joint_type != "fixed" and j.mimic is None]
    wanted = values([j.name for j in moving])
    if any(j.joint_type == "floating" for j in moving):
        raise ValueError("its floating joints have other coordinates")
    configuration = {j.name: (PLANAR[:2] if j.joint_type == "planar" else wanted[j.name]) for j in moving}
    fk = robot.link_fk(cfg=configuration)
    root = np.linalg.inv(fk[robot.base_link])
    poses = {link.name: pose(root @ at) for link, at in fk.items()}
    if any(j.joint_type == "planar" for j in moving):
        poses = None
    limits = {}
    for joint in moving:
        if joint.joint_type == "continuous" or joint.limit is None:
            limits[joint.name] = [None, None]
        elif joint.joint_type in ("revolute", "prismatic"):
            lower, upper = joint.limit.lower, joint.limit.upper
            safe = joint.safety_controller
            if safe is not None:
                lower, upper = max(lower, safe.soft_lower_limit), min(upper, safe.soft_upper_limit)
            limits[joint.name] = [end(lower), end(upper)]
    shapes = {}
    for link in robot.links:
        for shape in link.collisions:
            shapes.setdefault(link.name, []).append([*of_words(file, shape.geometry), pose(shape.origin)])
    found = result(poses, limits, shapes)
    if poses is None:
        del found["poses"]
    return found


def pybullet(file):
    import pybullet as p

    p.resetSimulation(physicsClientId=p.connect(p.DIRECT)) if not p.isConnected() else p.resetSimulation()
    p.setAdditionalSearchPath(str(file.parent.parent))
    robot = p.loadURDF(str(file), useFixedBase=True, flags=p.URDF_MAINTAIN_LINK_ORDER | p.URDF_USE_IMPLICIT_CYLINDER)
    followers = mimics(file)
    joints = [p.getJointInfo(robot, i) for i in range(p.getNumJoints(robot))]
    moving = {j[1].decode(): j for j in joints if j[2] in (p.JOINT_REVOLUTE, p.JOINT_PRISMATIC)}
    if any(j[2] not in (p.JOINT_REVOLUTE, p.JOINT_PRISMATIC, p.JOINT_FIXED) for j in joints):
        raise ValueError("its planar and spherical joints have other coordinates")
    wanted = values([name for name in moving if name not in followers])
    for name, value in wanted.items():
        p.resetJointState(robot, moving[name][0], value)
    # Bullet marks a joint without limits by lower > upper.
    limits = {n: ([None, None] if j[8] > j[9] else [j[8], j[9]]) for n, j in moving.items() if n not in followers}
    name = {-1: p.getBodyInfo(robot)[0].decode(), **{j[0]: j[12].decode() for j in joints}}
    shapes = {}
    poses = {name[-1]: pose(np.eye(4))}
    base = np.linalg.inv(matrix(*p.getBasePositionAndOrientation(robot)))
    for j in joints:
        state = p.getLinkState(robot, j[0], computeForwardKinematics=True)
        poses[name[j[0]]] = pose(base @ matrix(state[4], state[5]))
    for i in name:
        inertial = p.getDynamicsInfo(robot, i)
        for shape in p.getCollisionShapeData(robot, i):
            kind, sizes = shape[2], shape[3]
            placement = pose(matrix(inertial[3], inertial[4]) @ matrix(shape[5], shape[6]))
            if kind == p.GEOM_BOX:
                found = ["box", list(sizes)]
            elif kind == p.GEOM_SPHERE:
                found = ["sphere", [sizes[0]]]
            elif kind == p.GEOM_CYLINDER:
                found = ["cylinder", [sizes[1], sizes[0]]]
            elif kind == p.GEOM_CAPSULE:
                found = ["capsule", [sizes[1], sizes[0]]]
            else:
                found = None
            if found is None:
                shapes = None
                break
            shapes.setdefault(name[i], []).append([*found, placement])
        if shapes is None:
            break
    found = result(poses, limits, shapes or {})
    if shapes is None:
        del found["shapes"]
    if followers:
        del found["poses"]
    return found


def drake(file):
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.geometry import SceneGraph, Role, Box, Sphere, Cylinder, Capsule
    from pydrake.math import RigidTransform

    plant, graph = MultibodyPlant(0.0), SceneGraph()
    plant.RegisterAsSourceForSceneGraph(graph)
    parser = Parser(plant)
    parser.package_map().Add("urdf", str(file.parent))
    (robot,) = parser.AddModels(str(file))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    followers = mimics(file)
    joints = [plant.get_joint(i) for i in plant.GetJointIndices(robot)]
    moving = [j for j in joints if j.num_positions() > 0 and j.type_name() in ("revolute", "prismatic", "continuous", "planar")]
    moving = [j for j in moving if j.name() not in followers]
    wanted, limits, q = values([j.name() for j in moving]), {}, plant.GetPositions(context)
    for joint in moving:
        if joint.type_name() == "planar":
            q[joint.position_start() : joint.position_start() + 3] = PLANAR
            continue
        q[joint.position_start()] = wanted[joint.name()]
        lower, upper = joint.position_lower_limit(), joint.position_upper_limit()
        limits[joint.name()] = [None if math.isinf(lower) else lower, None if math.isinf(upper) else upper]
    plant.SetPositions(context, q)
    if any(j.type_name() == "quaternion_floating" and j.parent_body().name() != "world" for j in joints):
        raise ValueError("its floating joints are posed otherwise")
    children = {j.child_body().index() for j in joints if j.parent_body().name() != "WorldBody" and j.parent_body().model_instance() == robot}
    bodies = [plant.get_body(i) for i in plant.GetBodyIndices(robot)]
    (root,) = [b for b in bodies if b.index() not in children]
    base = plant.EvalBodyPoseInWorld(context, root).inverse()
    poses = {b.name(): pose((base @ plant.EvalBodyPoseInWorld(context, b)).GetAsMatrix4()) for b in bodies}
    inspector, shapes = graph.model_inspector(), {}
    for body in bodies:
        for id in plant.GetCollisionGeometriesForBody(body):
            shape = inspector.GetShape(id)
            placement = pose(inspector.GetPoseInFrame(id).GetAsMatrix4())
            if isinstance(shape, Box):
                found = ["box", list(shape.size())]
            elif isinstance(shape, Sphere):
                found = ["sphere", [shape.radius()]]
            elif isinstance(shape, Cylinder):
                found = ["cylinder", [shape.radius(), shape.length()]]
            elif isinstance(shape, Capsule):
                found = ["capsule", [shape.radius(), shape.length()]]
            else:
                found = None
            if found is None:
                shapes = None
                break
            shapes.setdefault(body.name(), []).append([*found, placement])
        if shapes is None:
            break
    found = result(poses, limits, shapes or {})
    if shapes is None:
        del found["shapes"]
    if followers:
        del found["poses"]
    return found


def compas(file):
    from compas.geometry import Frame
    from compas_robots import RobotModel

    robot = RobotModel.from_urdf_file(str(file))
    moving = [j for j in robot.get_configurable_joints()]
    wanted = values([j.name for j in moving])
    limits = {}
    for joint in moving:
        if joint.type == joint.CONTINUOUS or joint.limit is None:
            limits[joint.name] = [None, None]
        elif joint.type in (joint.REVOLUTE, joint.PRISMATIC):
            limits[joint.name] = [end(joint.limit.lower), end(joint.limit.upper)]
    shapes = {}
    for link in robot.links:
        for shape in link.collision:
            g = shape.geometry.shape
            origin = np.eye(4)
            if shape.origin is not None:
                f = shape.origin
                origin[:3, 0], origin[:3, 1], origin[:3, 2] = f.xaxis, f.yaxis, f.zaxis
                origin[:3, 3] = f.point
            kind = type(g).__name__
            if kind == "BoxProxy" or kind == "Box":
                found = ["box", list(g.size)]
            elif kind.startswith("Cylinder"):
                found = ["cylinder", [g.radius, g.length]]
            elif kind.startswith("Sphere"):
                found = ["sphere", [g.radius]]
            elif kind.startswith("Capsule"):
                found = ["capsule", [g.radius, g.length]]
            else:
                return {"limits": limits}
            shapes.setdefault(link.name, []).append([*found, pose(origin)])
    return {"limits": limits, "shapes": shapes}


def ours(file):
    """What the format's own words say, where readers leave a shape in that has no inside."""
    if file.stem == "mesh_percent":
        return pinocchio(file.with_name("mesh_in_folder.urdf"))
    plain = pinocchio(file.with_name("plain.urdf"))["shapes"]
    without = {"zero_box": "base", "zero_sphere": "base"}
    if file.stem not in without:
        raise ValueError("nothing is written down")
    return {"shapes": {link: shapes for link, shapes in plain.items() if link != without[file.stem]}}


READERS = {
    "pinocchio": pinocchio,
    "yourdfpy": yourdfpy,
    "urchin": urchin,
    "pybullet": pybullet,
    "drake": drake,
    "compas": compas,
    "ours": ours,
}
