"""A ROS 2 node without ROS (zenoh-ros2-sdk): asks for a shorter path, then publishes a change of the scene
and has the path checked until the verdict is another."""

import json
import sys
import time

import numpy
from zenoh_ros2_sdk import ROS2Publisher, ROS2ServiceClient
from zenoh_ros2_sdk.message_registry import get_registry
from zenoh_ros2_sdk.session import ZenohSession

folder, port, service_hash, scene_hash, problem = sys.argv[1:]
PLAN = "moveit_msgs/srv/GetMotionPlan"
SCENE = "moveit_msgs/msg/PlanningScene"
PATIENCE = 20.0

session = ZenohSession.get_instance("127.0.0.1", int(port))
registry = get_registry(folder)
assert registry.load_service_type(PLAN) and registry.load_message_type(SCENE)
store = session.store


def nothing(kind):
    """The value of a field that says nothing, by what rosbags says of its type."""
    node, of = int(kind[0]), kind[1]
    if node == 1:  # a number or a text
        return {"string": "", "bool": False}.get(of[0], 0)
    if node == 2:
        return empty(of)
    inner, count = of
    if int(inner[0]) == 1 and inner[1][0] != "string":
        return numpy.zeros(count if node == 3 else 0, dtype=inner[1][0].replace("octet", "uint8"))
    return [nothing(inner) for _ in range(count if node == 3 else 0)]


def empty(name, **said):
    fields = {field: nothing(kind) for field, kind in store.fielddefs[name][1]}
    return store.types[name](**{**fields, **said})


def request(names, rows):
    point = "trajectory_msgs/msg/JointTrajectoryPoint"
    points = [empty(point, positions=numpy.array(row, dtype=float)) for row in rows]
    path = empty("trajectory_msgs/msg/JointTrajectory", joint_names=names, points=points)
    reference = empty("moveit_msgs/msg/GenericTrajectory", joint_trajectory=[path])
    return empty(
        "moveit_msgs/msg/MotionPlanRequest", reference_trajectories=[reference], allowed_planning_time=10.0
    )


def change(operation):
    """A box around everything, or none."""
    pose = empty("geometry_msgs/msg/Pose", orientation=empty("geometry_msgs/msg/Quaternion", w=1.0))
    primitive = empty("shape_msgs/msg/SolidPrimitive", type=1, dimensions=numpy.array([20.0, 20.0, 20.0]))
    shapes = {"primitives": [primitive], "primitive_poses": [pose]} if operation == 0 else {}
    box = empty("moveit_msgs/msg/CollisionObject", id="everywhere", pose=pose, operation=operation, **shapes)
    return {
        **{field: nothing(kind) for field, kind in store.fielddefs[SCENE][1]},
        "world": empty("moveit_msgs/msg/PlanningSceneWorld", collision_objects=[box]),
        "is_diff": True,
    }


def client(name):
    return ROS2ServiceClient(name, PLAN, router_port=int(port), type_hash=service_hash, timeout=PATIENCE)


def asked(client, of):
    start = time.perf_counter()
    answer = client.call(motion_plan_request=of).motion_plan_response
    return answer, (time.perf_counter() - start) * 1e3


def until(client, of, code):
    end = time.monotonic() + PATIENCE
    while True:
        answer, _ = asked(client, of)
        if answer.error_code.val == code or time.monotonic() > end:
            print(json.dumps({"code": answer.error_code.val, "message": answer.error_code.message}))
            return
        time.sleep(0.02)


with open(problem) as file:
    given = json.load(file)
path = request(given["variables"], given["path"])
shorten, check = client("/taut/shorten"), client("/taut/check")
publisher = ROS2Publisher("/monitored_planning_scene", SCENE, router_port=int(port), type_hash=scene_hash)
answer, ms = asked(shorten, path)
trajectory = answer.trajectory.joint_trajectory
line = {
    "code": answer.error_code.val,
    "message": answer.error_code.message,
    "names": list(trajectory.joint_names),
    "points": [[float(value) for value in point.positions] for point in trajectory.points],
    "given": given["path"],
    "ms": ms,
}
print(json.dumps(line))
publisher.publish(**change(0))
until(check, path, -10)
publisher.publish(**change(1))
until(check, path, 1)
for one in (publisher, shorten, check):
    one.close()
session.close()
