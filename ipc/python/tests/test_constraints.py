"""What a path must keep besides clearance: each class, MoveIt's message as a dictionary, and texts."""

import json
from collections import OrderedDict

import numpy as np
import pytest

import taut

#: A hand that carries a cup on three joints that meet in one point: about y, z and y.
WAITER = """<robot name="waiter">
<link name="base"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
<link name="shoulder"/><link name="elbow"/>
<link name="hand"><collision><origin xyz="0.5 0 0.5"/><geometry><sphere radius="0.05"/></geometry></collision></link>
<joint name="lean" type="revolute"><parent link="base"/><child link="shoulder"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="turn" type="revolute"><parent link="shoulder"/><child link="elbow"/><axis xyz="0 0 1"/>
<limit lower="-4" upper="4" effort="1" velocity="1"/></joint>
<joint name="nod" type="revolute"><parent link="elbow"/><child link="hand"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
</robot>"""
#: Upright on all of it: both leans cancel each other.
UPRIGHT = [[0.5, 0.0, -0.5], [0.0, 0.0, 0.0], [0.0, np.pi, 0.0], [0.5, np.pi, 0.5]]
#: Upright at both ends only.
STRAIGHT = [UPRIGHT[0], UPRIGHT[-1]]
#: Where the cup is, in the hand (m).
CUP = (0.0, 0.0, 0.5)


def about_y(angle):
    sin, cos = np.sin(angle), np.cos(angle)
    return np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]])


def about_z(angle):
    sin, cos = np.sin(angle), np.cos(angle)
    return np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])


def hand(q):
    """How the hand is turned in the world."""
    return about_y(q[0]) @ about_z(q[1]) @ about_y(q[2])


def tilt(q):
    return np.arccos(np.clip(hand(q)[2, 2], -1, 1))


def euler(q):
    """How much the first two of MoveIt's XYZ Euler angles leave of 0.1 rad."""
    turned = hand(q)
    alpha, beta = np.arctan2(-turned[1, 2], turned[2, 2]), np.arcsin(turned[0, 2])
    return 0.1 - max(abs(alpha), abs(beta))


def off(q):
    """How far the cup is from where it is upright."""
    return hand(q) @ CUP - CUP


def moveit(**constraints):
    """MoveIt's message, as ROS's tools make dictionaries of it."""
    empty = {"joint_constraints": [], "position_constraints": [], "orientation_constraints": []}
    return OrderedDict(name="cup", **{**empty, **constraints}, visibility_constraints=[])


HEADER = {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "base"}
EULER = {
    "header": HEADER,
    "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
    "link_name": "hand",
    "absolute_x_axis_tolerance": 0.1,
    "absolute_y_axis_tolerance": 0.1,
    "absolute_z_axis_tolerance": 2 * np.pi,
    "parameterization": 0,
    "weight": 1.0,
}
BALL = {
    "header": HEADER,
    "link_name": "hand",
    "target_point_offset": {"x": CUP[0], "y": CUP[1], "z": CUP[2]},
    "constraint_region": {
        "primitives": [{"type": 2, "dimensions": [0.05], "polygon": {"points": []}}],
        "primitive_poses": [{"position": {"x": 0.0, "y": 0.0, "z": 0.5}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}],
        "meshes": [],
        "mesh_poses": [],
    },
    "weight": 1.0,
}
NOD = {"joint_name": "nod", "position": 0.0, "tolerance_above": 0.55, "tolerance_below": 0.55, "weight": 1.0}

#: What is asked, what is left of it at a configuration, its kind, unit and name.
UPRIGHT_LEFT = (lambda q: 0.1 - tilt(q), "orientation", "rad", "upright: hand")
BALL_LEFT = (lambda q: 0.05 - np.linalg.norm(off(q)), "position", "m")
CASES = {
    "upright": (taut.Upright("hand", axis="z", within=0.1), *UPRIGHT_LEFT),
    "upright by numbers": (taut.Upright("hand", np.array([0, 0, 2.0]), np.float64(0.1), np.array([0, 0, 1])), *UPRIGHT_LEFT),
    "upright as it starts": (taut.Upright("hand", within=0.1, against="start"), *UPRIGHT_LEFT),
    "oriented": (taut.Oriented("hand", (0, 0, 0, 1), within=(0.1, 0.1, np.pi)), euler, "orientation", "rad", "hand"),
    "in a box": (
        taut.InBox("hand", (0.1, 0.1, 0.1), (0, 0, 0.5), CUP),
        lambda q: 0.05 - np.abs(off(q)).max(), "position", "m", "hand",
    ),
    "in a ball": (taut.InBall("hand", 0.05, (0, 0, 0.5), CUP), *BALL_LEFT, "hand"),
    "in a cylinder": (
        taut.InCylinder("hand", 0.05, 1.0, (0, 0, 0.5), CUP),
        lambda q: 0.05 - np.hypot(*off(q)[:2]), "position", "m", "hand",
    ),
    "MoveIt's orientation": (moveit(orientation_constraints=[EULER]), euler, "orientation", "rad", "cup: hand"),
    "MoveIt's position": (moveit(position_constraints=[BALL]), *BALL_LEFT, "cup: hand"),
    "words": ("upright hand:z=0.1", *UPRIGHT_LEFT),
}


@pytest.fixture
def waiter(planner, tmp_path):
    file = tmp_path / "waiter.urdf"
    file.write_text(WAITER)
    return planner.load_robot("waiter", file, replace=True).label


def between(rows, segment, t):
    return np.asarray(rows[segment]) * (1 - t) + np.asarray(rows[segment + 1]) * t


def least(rows, left):
    """The least that is left along a path, by samples."""
    places = [(i, t) for i in range(len(rows) - 1) for t in np.linspace(0, 1, 401)]
    return min(left(between(rows, segment, t)) for segment, t in places)


@pytest.mark.parametrize("asked, left, kind, unit, name", CASES.values(), ids=CASES.keys())
def test_a_path_keeps_it_and_is_shortened_or_is_refused_with_its_number(planner, waiter, asked, left, kind, unit, name):
    plain = planner.shorten(UPRIGHT, waiter, budget=50_000).result()
    assert least(plain.path, left) < 0, "the test asks for nothing"
    best = planner.shorten(UPRIGHT, waiter, budget=50_000, constraints=asked).result()
    assert best.proved and best.length < best.length_before
    assert least(best.path, left) >= 0
    with pytest.raises(taut.OutsideConstraint) as caught:
        planner.shorten(STRAIGHT, waiter, constraints=asked).result()
    error = caught.value
    assert (error.kind, error.unit, error.names) == (kind, unit, (name,)) and "\n" not in str(error)
    assert error.code_name == "INVALID_MOTION_PLAN" and error.segment == 0 and 0 < error.t < 1
    assert error.amount == pytest.approx(left(between(STRAIGHT, 0, error.t)), abs=1e-9) and error.amount < 0
    verdict = planner.check(STRAIGHT, waiter, constraints=asked)
    assert not verdict and verdict.problem.names == (name,) and verdict.problem.amount == error.amount
    assert planner.check(UPRIGHT, waiter, constraints=asked)


@pytest.mark.parametrize("asked", [taut.JointWithin("nod", 0.0, 0.55, 0.55), moveit(joint_constraints=[NOD])])
def test_a_joint_stays_near_a_value(planner, waiter, asked):
    best = planner.shorten(UPRIGHT, waiter, budget=50_000, constraints=asked).result()
    assert best.proved and best.length < best.length_before
    assert np.abs(best.path[:, 2]).max() <= 0.55
    rows = [UPRIGHT[0], [0.0, 1.0, 1.2], UPRIGHT[-1]]
    with pytest.raises(taut.OutsideConstraint) as caught:
        planner.shorten(rows, waiter, constraints=asked).result()
    error = caught.value
    assert (error.kind, error.unit) == ("joint", "rad") and error.names[0].endswith("nod")
    assert error.amount == pytest.approx(0.55 - abs(between(rows, error.segment, error.t)[2]), abs=1e-9) and error.amount < 0


def test_all_of_several_must_hold(planner, waiter):
    upright, still = taut.Upright("hand", within=0.1), taut.JointWithin("nod", 0.0, 0.55, 0.55)
    assert planner.check(UPRIGHT, waiter, constraints=[upright, still, moveit(), "keep hand in ball 1 at 0,0,0"])
    narrow = taut.JointWithin("nod", -0.5, 0.1, 0.1)
    verdict = planner.check(UPRIGHT, waiter, constraints=[upright, narrow])
    assert not verdict and verdict.problem.kind == "joint"
    for nothing in (None, "", [], moveit()):
        assert planner.check(STRAIGHT, waiter, constraints=nothing)


@pytest.mark.parametrize(
    "asked, text",
    [
        (taut.Upright("arm"), "links: base, shoulder, elbow, hand"),
        (taut.Upright(""), "links: base, shoulder, elbow, hand"),
        (taut.Upright("hand", frame="table"), "'table'|\"table\""),
        (taut.Upright("hand", axis="w"), "valid: .*-x"),
        (taut.Upright("hand", axis=(0, 0, 0)), "must not be zero"),
        (taut.Upright("hand", within=0.0), "tolerance_rad is 0"),
        (taut.Upright("hand", within=2.0), "tolerance_rad is 2"),
        (taut.Upright("hand", within=float("nan")), "cannot be sent"),
        (taut.Upright("hand", axis=(0, 1)), "length 3|\\[x, y, z\\]|an array of length"),
        (taut.Oriented("hand", (0, 0, 1), (0.1, 0.1, 0.1)), "four numbers"),
        (taut.Oriented("hand", (0, 0, 1, 1), (0.1, 0.1, 0.1)), "unit quaternion"),
        (taut.Oriented("hand", (0, 0, 0, 1), (0.1, 0.1)), "cannot be sent"),
        (taut.Oriented("hand", (0, 0, 0, 1), (0.1, 0.1, 2.0)), "absolute_z_axis_tolerance is 2"),
        (taut.InBox("hand", (1, 1), (0, 0, 0)), "box \\[x, y, z\\]"),
        (taut.InBox("hand", (1, 0, 1), (0, 0, 0)), "is 0"),
        (taut.InBall("hand", -1.0, (0, 0, 0)), "is -1"),
        (taut.InCylinder("nobody", 1.0, 1.0, (0, 0, 0)), "\"nobody\""),
        (taut.JointWithin("elbow", 0, 1, 1), "valid: lean, turn, nod"),
        (taut.JointWithin("nod", 0, -1, 1), "tolerance_below is -1"),
        (moveit(orientation_constraints=[{**EULER, "parameterization": 1}]), "parameterization 1"),
        (moveit(orientation_constraints=[{**EULER, "absolute_x": 1}]), "absolute_x"),
        ({**moveit(), "visibility_constraints": [{}]}, "visibility_constraints"),
        ({"orientation_constraint": []}, "orientation_constraints"),
        ("hand:z=0.1", "valid: "),
        (["upright hand"], "valid: "),
        ([3], "Upright, Oriented, InBox"),
        (3, "cannot be sent"),
        ("{", "Constraints"),
        (["{"], "cannot be sent"),
    ],
)
def test_what_cannot_be_kept_is_refused_by_name(planner, waiter, asked, text):
    with pytest.raises(taut.InvalidInput, match=text) as caught:
        planner.shorten(UPRIGHT, waiter, constraints=asked).result()
    assert "\n" not in str(caught.value) and caught.value.code_name in ("INVALID_CONSTRAINT", "MALFORMED_REQUEST")


def test_ends_outside_have_codes_of_their_own(planner, waiter):
    leaning = [0.3, 0.0, 0.0]
    for rows, code in (
        ([leaning, UPRIGHT[1]], "START_STATE_VIOLATES_PATH_CONSTRAINTS"),
        ([UPRIGHT[1], leaning], "GOAL_VIOLATES_PATH_CONSTRAINTS"),
    ):
        verdict = planner.check(rows, waiter, constraints=taut.Upright("hand"))
        assert verdict.problem.code_name == code and verdict.problem.amount == pytest.approx(0.1 - 0.3)


def test_a_saved_answer_says_what_it_keeps(planner, waiter, tmp_path):
    best = planner.shorten(UPRIGHT, waiter, budget=1000, constraints=taut.Upright("hand")).result()
    best.save(tmp_path / "answer.json")
    kept = json.loads((tmp_path / "answer.json").read_text())["path_constraints"]
    assert kept["orientation_constraints"][0]["link_name"] == "hand"
