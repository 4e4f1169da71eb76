"""MoveIt's messages in, the same trajectory out, shorter and proved; no ROS needed.

    pip install ./ipc/python
    python examples/planners/moveit_adapter.py examples/planners/moveit_request.json \\
        --urdf config/robots/panda_like.urdf --srdf config/robots/panda_like.srdf

The file has `planning_scene` (moveit_msgs/PlanningScene), `motion_plan_request` (MotionPlanRequest: its group_name,
start_state, path_constraints and allowed_planning_time) and `trajectory` (RobotTrajectory), as their fields are named in ROS. What comes
out is the RobotTrajectory with other points. Points say nothing of time any more: velocities, accelerations and
efforts are empty and time_from_start is 0, as a planner's are before MoveIt's time parameterization, which has to run
after this as it runs after any planner.
"""

import argparse
import json
import sys
from pathlib import Path

import numpy as np
import taut

PRIMITIVES = {1: "box", 2: "sphere", 3: "cylinder"}  # shape_msgs/SolidPrimitive


class Refused(Exception):
    """Something in the messages that has no counterpart here, and what to do."""


def pose(message):
    """geometry_msgs/Pose as scene files have it."""
    position, turn = message.get("position", {}), message.get("orientation", {})
    return {
        "position": [position.get(axis, 0.0) for axis in "xyz"],
        "orientation": {**{axis: turn.get(axis, 0.0) for axis in "xyz"}, "w": turn.get("w", 1.0)},
    }


def collision_object(message):
    """moveit_msgs/CollisionObject as scene files have it."""
    name = message["id"]
    if message.get("planes"):
        raise Refused(f"object {name!r} has planes; give a thin box instead")
    if any(primitive["type"] not in PRIMITIVES for primitive in message.get("primitives", [])):
        raise Refused(f"object {name!r} has a primitive that is none of box 1, sphere 2, cylinder 3")
    found = {
        "id": name,
        "header": {"frame_id": message.get("header", {}).get("frame_id", "")},
        "pose": pose(message.get("pose", {})),
        "primitives": [
            {"type": PRIMITIVES[primitive["type"]], "dimensions": primitive["dimensions"]}
            for primitive in message.get("primitives", [])
        ],
        "primitive_poses": [pose(one) for one in message.get("primitive_poses", [])],
    }
    if message.get("meshes"):
        found["meshes"] = [
            {
                "vertices": [[vertex[axis] for axis in "xyz"] for vertex in mesh["vertices"]],
                "triangles": [triangle["vertex_indices"] for triangle in mesh["triangles"]],
            }
            for mesh in message["meshes"]
        ]
        found["mesh_poses"] = [pose(one) for one in message.get("mesh_poses", [])]
    return found


def scene_of(message):
    """moveit_msgs/PlanningScene as a scene."""
    if message.get("is_diff"):
        raise Refused("the planning scene is a diff; give the whole one (get_planning_scene), or apply it with scene.diff")
    matrix = message.get("allowed_collision_matrix", {})
    names = matrix.get("entry_names", [])
    allowed = [
        [a, b]
        for row, a in enumerate(names)
        for column, b in enumerate(names)
        if row < column and matrix["entry_values"][row]["enabled"][column]
    ]
    attached = message.get("robot_state", {}).get("attached_collision_objects", [])
    frames = [
        {
            "child_frame_id": frame["child_frame_id"],
            "transform": {
                "translation": [frame["transform"]["translation"][axis] for axis in "xyz"],
                "rotation": frame["transform"]["rotation"],
            },
        }
        for frame in message.get("fixed_frame_transforms", [])
    ]
    return {
        "name": message.get("name", ""),
        "fixed_frame_transforms": frames,
        "objects": [collision_object(item) for item in message.get("world", {}).get("collision_objects", [])],
        "attached_collision_objects": [
            {
                "link_name": item["link_name"],
                "touch_links": item.get("touch_links", []),
                "object": collision_object(item["object"]),
            }
            for item in attached
        ],
        "allowed_collisions": allowed,
        "link_padding": message.get("link_padding", []),
        "link_scale": message.get("link_scale", []),
    }


def shorten(daemon, robot, messages):
    """The RobotTrajectory of `messages` with the points of a shorter, proved path; raises `taut.Error`."""
    request, trajectory = messages["motion_plan_request"], messages["trajectory"]
    if trajectory.get("multi_dof_joint_trajectory", {}).get("points"):
        raise Refused("the trajectory moves multi-DOF joints; send their columns by name (joint/x ...) with taut itself")
    if request.get("trajectory_constraints", {}).get("constraints"):
        raise Refused("the request has trajectory_constraints, which are not kept; give path_constraints")
    joints = trajectory["joint_trajectory"]
    columns = joints["joint_names"]
    start = request.get("start_state", {}).get("joint_state", {})
    known = set(daemon.robot(robot).columns) | set(daemon.robot(robot).held)
    others = dict(zip(start.get("name", []), start.get("position", [])))
    best = daemon.shorten(
        np.array([point["positions"] for point in joints["points"]], float),
        robot,
        daemon.load_scene("moveit", scene_of(messages["planning_scene"]), replace=True),
        columns=columns,
        hold={name: value for name, value in others.items() if name in known and name not in columns},
        group=request.get("group_name") or None,
        deadline=request.get("allowed_planning_time") or None,
        constraints=request.get("path_constraints"),
    ).result()
    still = {"velocities": [], "accelerations": [], "effort": [], "time_from_start": {"sec": 0, "nanosec": 0}}
    points = [{"positions": list(map(float, row)), **still} for row in best.path]
    return {**trajectory, "joint_trajectory": {**joints, "points": points}}, best


def main():
    """One file of messages, one trajectory."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("messages", help="JSON with planning_scene, motion_plan_request and trajectory")
    parser.add_argument("--urdf", required=True)
    parser.add_argument("--srdf")
    parser.add_argument("-o", "--output", help="where the trajectory goes (default: standard output)")
    parser.add_argument("--local", action="store_true", help="taut in this process, without a daemon")
    given = parser.parse_args()
    try:
        messages = json.loads(Path(given.messages).read_text())
        with taut.local() if given.local else taut.connect() as daemon:
            robot = messages["planning_scene"].get("robot_model_name") or Path(given.urdf).stem
            daemon.load_robot(robot, given.urdf, given.srdf)
            trajectory, best = shorten(daemon, robot, messages)
    except KeyError as missing:
        raise SystemExit(f"moveit: {given.messages} has no field {missing}") from None
    except (OSError, ValueError, Refused, taut.Error) as error:
        raise SystemExit(f"moveit: {error}") from None
    text = json.dumps(trajectory, indent=1)
    Path(given.output).write_text(text + "\n") if given.output else print(text)
    points = messages["trajectory"]["joint_trajectory"]["points"]
    proof = "proved" if best.proved else "NOT PROVED"
    print(
        f"moveit: {len(points)} points {best.length_before:.3f} -> {len(best.path)} points {best.length:.3f}, {proof}",
        file=sys.stderr,
    )


if __name__ == "__main__":
    main()
