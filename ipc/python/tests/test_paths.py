"""Paths in, answers out."""

import json
import os
import pickle
from pathlib import Path

import numpy as np
import pytest

import taut

#: Small inputs that went wrong once.
CASES = Path(os.environ["TAUT_CONFIG"]).parent / "tests" / "cases"
#: As much work as a test needs, the same everywhere.
BUDGET = 20000


def shorten(planner, problem, path=None, **options):
    options.setdefault("budget", BUDGET)
    return planner.shorten(problem.path if path is None else path, problem.robot, problem.scene, **options)


@pytest.fixture
def rooms(planner, problems):
    return planner.load_problem(problems / "rooms.json")


@pytest.fixture
def shelf(planner, problems):
    return planner.load_problem(problems / "arm_shelf.json")


def test_improvements_get_shorter_and_the_last_is_the_result(planner, shelf):
    answers = shorten(planner, shelf)
    lengths, last = [], None
    for last in answers:
        assert last.proved and last.path.shape[1] == 7 and not last.path.flags.writeable
        lengths.append(last.length)
    assert isinstance(last, taut.Result) and last.final and last is answers.result()
    assert lengths == sorted(lengths, reverse=True) and last.length < last.length_before
    assert last.clearance > 0 and last.code_name == "SUCCESS" and last.ended
    assert np.array_equal(last.path[[0, -1]], shelf.path[[0, -1]])
    assert last.details["stages"] and len(last) == len(last.path)


def test_both_answer_the_same_to_the_last_bit(daemon, problems):
    with taut.local() as here:
        for name in ["arm_shelf", "rooms", "ell_window"]:
            found = []
            for planner in (here, daemon):
                problem = planner.load_problem(problems / f"{name}.json")
                result = shorten(planner, problem, seed=3).result()
                details = {key: value for key, value in result.details.items() if key not in OTHERWISE}
                found.append((result.path.tobytes(), result.length, result.work, result.clearance, details))
            assert found[0] == found[1], name


def test_what_is_kept_besides_clearance_is_told_with_what_is_proved_of_it(planner, shelf):
    result = shorten(planner, shelf, constraints="keep hand in ball 3 at 0,0,0").result()
    (kept,) = result.keeps
    assert (kept["kind"], kept["names"], kept["unit"], kept["asked"]) == ("position", ["hand"], "m", 3.0)
    assert 0 < kept["left"] <= kept["amount"] < 3 and kept["segment"] < len(result) - 1 and 0 <= kept["t"] <= 1
    assert shorten(planner, shelf).result().keeps == []


OTHERWISE = {"cpu_s", "time_s", "request_id", "lengths_over_time", "name"}


def test_columns_come_in_any_order(planner, shelf):
    names = list(shelf.columns)
    plain = shorten(planner, shelf).result()
    order = [3, 0, 6, 1, 5, 2, 4]
    turned = shorten(planner, shelf, shelf.path[:, order], columns=[names[i] for i in order]).result()
    assert np.array_equal(turned.path, plain.path[:, order]) and turned.length == plain.length


def test_missing_columns_are_held(planner, shelf):
    names = list(shelf.columns)
    start = shelf.path[0]
    path = np.linspace(start[1:], start[1:] + 0.01, 5)
    result = shorten(planner, shelf, path, columns=names[1:], hold={names[0]: start[0]}).result()
    assert result.path.shape[1] == 6 and np.array_equal(result.path[[0, -1]], path[[0, -1]])
    assert not any("no column" in line for line in result.warnings)
    with pytest.raises(taut.InvalidInput, match="valid: joint1, joint2"):
        shorten(planner, shelf, path, columns=["elbow", *names[2:]]).result()


def test_what_nobody_holds_stands_at_zero_and_the_answer_says_so(planner):
    planner.load_robot("case_hand", CASES / "group-trajectory/hand.urdf", srdf=CASES / "group-trajectory/hand.srdf")
    path = [[-0.5], [0.2], [0.9]]
    verdict = planner.check(path, "case_hand", columns=["swing"], hold={"f_l": 0.03})
    assert verdict and verdict.path.shape == (3, 1) and verdict.pairs > 0
    assert "the path has no column for caster_yaw: held still at 0" in verdict.uncovered
    assert not any("camera_link" in line for line in verdict.uncovered)
    assert any("camera_link" in line for line in verdict.warnings)
    assert verdict.details["warnings"] == verdict.warnings and verdict.details["uncovered"] == verdict.uncovered


def test_a_robot_without_geometry_proves_nothing(planner):
    planner.load_robot("case_bare", CASES / "visual-only/visual.urdf")
    verdict = planner.check([[-1.0, 0.2], [0.3, 0.9]], "case_bare")
    assert (verdict.proved, verdict.code_name, verdict.pairs) == (False, "UNCERTIFIED", 0)
    why = "no link of robot arm2 has collision geometry: nothing is checked"
    assert why in str(verdict.problem) and why in verdict.details["uncheckable"]


def test_every_kind_of_table_is_taken(planner, rooms):
    plain = shorten(planner, rooms).result().path.copy()
    path = rooms.path
    kinds = [
        path.tolist(),
        tuple(map(tuple, path)),
        np.asfortranarray(path),
        np.repeat(path, 2, axis=0)[::2],
        path.astype(">f8"),
        path.astype(np.longdouble),
    ]
    for kind in kinds:
        assert np.array_equal(shorten(planner, rooms, kind).result().path, plain)
    # An answer is a path too.
    assert len(shorten(planner, rooms, shorten(planner, rooms).result()).result()) >= 2


@pytest.mark.parametrize(
    "path",
    [
        [],
        [[]],
        [1.0, 2.0],
        [[[1.0, 2.0]]],
        [["a", "b"]],
        [[1.0, 2.0], [3.0]],
        [[1j, 2.0]],
        [[None, 1.0]],
        [[1.0, 2.0, 3.0]] * 2,
        [[1.0]] * 4,
        [[float("nan"), 0.0], [0.0, 0.0]],
        [[float("inf"), 0.0], [0.0, 0.0]],
        [[1e300, 0.0], [0.0, 0.0]],
        None,
        "path",
        object(),
        {"a": 1},
        np.zeros((131_073, 2)),
    ],
)
def test_what_is_no_path_is_refused(planner, rooms, path):
    with pytest.raises((taut.InvalidInput, taut.ResourceExhausted)):
        planner.shorten(path, rooms.robot, rooms.scene).result()


@pytest.mark.parametrize(
    "options, kind, text",
    [
        ({"mode": "fast"}, taut.InvalidInput, "valid: check, gradient"),
        ({"deadline": -1.0}, taut.InvalidInput, "deadline"),
        ({"deadline": float("nan")}, taut.InvalidInput, "deadline"),
        ({"clearance": 0.0}, taut.InvalidInput, "more than 0"),
        ({"group": "tail"}, taut.UnknownName, "valid: "),
        ({"fix": [0, 99]}, taut.InvalidInput, "waypoints 0 to"),
        ({"fix": [-1]}, taut.InvalidInput, "valid: 0, 1"),
        ({"weights": {"z": 1.0}}, taut.InvalidInput, "valid: x, y"),
        ({"weights": 3}, taut.InvalidInput, "dictionary"),
        ({"metric": [1.0]}, taut.InvalidInput, "weights"),
        ({"hold": {"z": 1.0}}, taut.InvalidInput, "valid: none"),
        ({"columns": ["x", "x"]}, taut.InvalidInput, "twice"),
        ({"columns": "xy"}, taut.InvalidInput, "list of names"),
        ({"seed": -1}, taut.InvalidInput, "wrong kind"),
        ({"priority": "high"}, taut.InvalidInput, "wrong kind"),
        ({"scene_version": 99}, taut.VersionConflict, "version"),
    ],
)
def test_wrong_options_are_refused_with_the_valid_ones(planner, rooms, options, kind, text):
    with pytest.raises(kind, match=text):
        shorten(planner, rooms, **options).result()


def test_unknown_names_list_the_known_ones(planner, rooms):
    with pytest.raises(taut.UnknownName, match=rooms.robot):
        planner.shorten(rooms.path, "nobody", rooms.scene).result()
    with pytest.raises(taut.UnknownName, match=rooms.scene):
        planner.shorten(rooms.path, rooms.robot, "nowhere").result()


def test_a_colliding_path_is_an_exception_with_its_place(planner, rooms):
    straight = rooms.path[[0, -1]]
    with pytest.raises(taut.InCollision) as caught:
        shorten(planner, rooms, straight).result()
    error = caught.value
    assert (error.kind, error.unit, len(error.names)) == ("clearance", "m", 2) and error.segment == 0 and 0 <= error.t <= 1 and error.amount < 1e-9 < error.allowed
    assert len(error.points) == 2 and abs(np.linalg.norm(error.normal) - 1) < 1e-9
    assert error.code == -2 and error.names[0] in str(error) and "\n" not in str(error)
    again = pickle.loads(pickle.dumps(error))
    assert (type(again), again.names, again.code, str(again)) == (taut.InCollision, error.names, -2, str(error))
    verdict = planner.check(straight, rooms.robot, rooms.scene)
    assert not verdict and verdict.problem.names == error.names and np.array_equal(verdict.path, straight)
    good = planner.check(rooms.path, rooms.robot, rooms.scene)
    assert good and good.problem is None and good.length == good.length_before


def test_without_a_scene_there_is_nothing_around(planner, rooms):
    straight = rooms.path[[0, -1]]
    assert planner.check(straight, rooms.robot)


def test_waypoints_and_joints_stay(planner, shelf):
    fixed = [2, 3]
    result = shorten(planner, shelf, fix=fixed).result()
    rows = {row.tobytes() for row in result.path}
    assert all(shelf.path[index].tobytes() in rows for index in fixed)
    assert shorten(planner, shelf, weights={"joint1": 50.0}).result().length > 0


def test_views_outlive_everything(planner, rooms):
    kept, copies = [], []
    answers = shorten(planner, rooms)
    for best in answers:
        kept.append(best.path)
        copies.append(best.copy())
    del answers, best
    planner.close()
    assert len(kept) >= 1 and all(np.array_equal(a, b) for a, b in zip(kept, copies))
    with pytest.raises(ValueError):
        kept[-1][0, 0] = 1.0


def test_save_writes_a_result_file(planner, shelf, tmp_path):
    result = shorten(planner, shelf).result()
    file = tmp_path / "result.json"
    result.save(file)
    saved = json.loads(file.read_text())
    assert saved["format"] == "taut-result/1" and saved["proved"] and saved["certificate"]
    assert np.array_equal(saved["path"], result.path) and np.array_equal(saved["path_before"], shelf.path)
    assert saved["variables"] == list(shelf.columns) and saved["lengths_over_time"][-1][1] == result.length
    subject = saved["subject"]
    assert subject["robot"]["files"]["urdf"].endswith("panda_like.urdf") and subject["scene"]["content"]["objects"]


def test_the_metric_of_a_problem_is_taken(planner, problems):
    problem = planner.load_problem(problems / "arm_shelf.json")
    nv = len(planner.robot(problem.robot).weights)
    result = planner.check(problem.path, problem.robot, problem.scene)
    ones = shorten(planner, problem, metric=[1.0] * nv).result()
    assert ones.length_before != result.length_before


def test_a_long_path_of_every_mode_is_answered(planner, problems):
    problem = planner.load_problem(problems / "arm_shelf.json")
    there = problem.path
    lap = np.concatenate([there, there[-2:0:-1]])
    path = np.tile(lap, (2000 // len(lap) + 1, 1))[:2000]
    for mode in ["check", "hybrid", "contact", "gradient", "random-shortcut", "partial-shortcut"]:
        result = planner.shorten(path, problem.robot, problem.scene, mode=mode, budget=1, contacts=False).result()
        assert result.proved and result.length <= result.length_before
