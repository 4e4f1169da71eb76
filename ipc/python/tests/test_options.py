"""Every option of the table, asked from Python."""

import json

import numpy as np
import pytest

import taut

BUDGET = 20000


@pytest.fixture
def shelf(planner, problems):
    return planner.load_problem(problems / "arm_shelf.json")


def shorten(planner, problem, **options):
    options.setdefault("budget", BUDGET)
    return planner.shorten(problem.path, problem.robot, problem.scene, **options).result()


def test_a_corridor_says_how_far_the_path_may_be_strayed_from(planner, shelf, tmp_path):
    plain = shorten(planner, shelf)
    result = shorten(planner, shelf, corridor=True)
    assert plain.corridor is None
    assert np.array_equal(plain.path, result.path), "a corridor changes no path"
    corridor = result.corridor
    assert corridor.floor == result.floor
    assert [name for name, _ in corridor.reach] == list(shelf.columns)
    assert all(reach >= 0.0 for _, reach in corridor.reach)
    assert len(corridor.slack) == len(result.path) - 1
    assert all(0.0 <= slack <= 0.1 for slack in corridor.slack) and max(corridor.slack) > 0.0
    result.save(tmp_path / "answer.json")
    saved = json.loads((tmp_path / "answer.json").read_text())
    assert tuple(saved["corridor"]["slack_m"]) == corridor.slack


def test_a_check_has_a_corridor_too(planner, shelf):
    verdict = planner.check(shelf.path, shelf.robot, shelf.scene, corridor=True)
    assert verdict and len(verdict.corridor.slack) == len(shelf.path) - 1
    refused = planner.check(shelf.path[[0, -1]], shelf.robot, shelf.scene, corridor=True)
    assert not refused and refused.corridor is None


def test_a_version_of_the_scene_is_answered_about(planner, shelf):
    version = next(scene.version for scene in planner.scenes() if scene.label == shelf.scene)
    result = shorten(planner, shelf, priority=3, scene_version=version)
    assert result.scene_version == version
    with pytest.raises(taut.Error):
        shorten(planner, shelf, scene_version=10**9)


def test_numbers_that_are_none_are_refused_with_the_valid_ones(planner, shelf):
    with pytest.raises(taut.InvalidInput, match="0 to 4294967295"):
        shorten(planner, shelf, priority=2**32)
    with pytest.raises(taut.InvalidInput, match="more than 0"):
        shorten(planner, shelf, clearance=0.0)
    with pytest.raises(taut.InvalidInput, match="valid: check, gradient"):
        shorten(planner, shelf, mode="fast")


def test_a_saved_certificate_says_where_held_joints_stand(planner, problems, tmp_path):
    arms = planner.load_problem(problems / "exchange_arms.json")
    torso = arms.columns.index("torso_lift")
    others = [column for column in range(len(arms.columns)) if column != torso]
    urdf = problems.parent / "robots" / "duo.urdf"
    planner.load_robot("held_duo", urdf, columns=[arms.columns[column] for column in others], replace=True)
    held = float(arms.path[0, torso])
    verdict = planner.check(arms.path[:2, others], "held_duo", hold={"torso_lift": held})
    verdict.save(tmp_path / "verdict.json")
    saved = json.loads((tmp_path / "verdict.json").read_text())
    assert saved["certificate"]["held"] == [held]
