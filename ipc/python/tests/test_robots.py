"""Robots as others write them: the right answers of `tests/cases`."""

import json

import numpy as np
import pytest
from conftest import CONFIG

import taut

CASES = CONFIG.parent / "tests" / "cases"


def load(planner, name, **more):
    return planner.load_robot("case", CASES / name, replace=True, **more)


def read(name):
    return np.loadtxt(CASES / name, delimiter=",", skiprows=1, ndmin=2)


def empty(planner):
    return planner.load_scene("nothing", {"objects": []}, replace=True)


@pytest.mark.parametrize("robot", ["quat", "rpy"])
def test_a_quaternion_near_the_vertical_is_exact(planner, robot):
    arm = load(planner, f"quat-near-vertical/{robot}.urdf")
    scene = planner.load_scene("post", CASES / "quat-near-vertical" / "post.json", replace=True)
    verdict = planner.check([[0.0]], arm, scene)
    assert not verdict and isinstance(verdict.problem, taut.InCollision)
    assert verdict.problem.amount == pytest.approx(-3.80e-3, abs=5e-6)


@pytest.mark.parametrize("robot", ["undeclared_prefix", "blank_line_before_declaration", "same_without_prefix"])
def test_xml_that_others_read(planner, robot):
    assert planner.check([[0.0], [0.5]], load(planner, f"xml/{robot}.urdf"), empty(planner))


@pytest.mark.parametrize("robot", ["prefix", "latin", "doctype"])
def test_more_xml_that_others_read(planner, robot):
    assert planner.check([[0.0, 0.0], [0.5, 0.5]], load(planner, f"xml/{robot}.urdf"), empty(planner))


def test_what_xacro_has_to_expand(planner):
    with pytest.raises(taut.Error, match="xacro FILE.xacro"):
        load(planner, "xml/xacro_undecl.urdf")


@pytest.mark.parametrize("case", ["srdf-group-errors/r", "srdf-state-errors/r"])
def test_groups_and_states_refuse_no_robot(planner, case):
    robot = load(planner, f"{case}.urdf")
    assert robot.warnings and planner.check([[0.0], [0.5]], robot, empty(planner))


def test_an_srdf_that_disables_nothing(planner):
    hints = load(planner, "srdf-without-pairs/r.urdf").warnings
    assert any("the SRDF disables no pair" in text and "<disable_collisions" in text for text in hints)


def test_a_pair_that_separates_is_not_offered(planner):
    robot = load(planner, "rest-contacts-advice/r.urdf")
    assert any("base × forearm" in text for text in robot.warnings)
    assert not any("<disable_collisions" in text for text in robot.warnings)
    assert not planner.check(read("rest-contacts-advice/hits.csv"), robot, empty(planner))


@pytest.mark.parametrize("robot", ["zero", "zerobox", "zero_sphere"])
def test_markers_without_a_size(planner, robot):
    loaded = load(planner, f"zero-size-shapes/{robot}.urdf")
    assert any("left out" in text for text in loaded.warnings)
    assert planner.check([[0.0], [0.5]], loaded, empty(planner))


def test_a_joint_named_8(planner):
    table = json.loads((CASES / "joint-named-8" / "path.json").read_text())
    robot = load(planner, "joint-named-8/joint_named_8.urdf", columns=table["variables"])
    assert robot.columns == ["8"] and planner.check(table["path"], robot, empty(planner))


def test_soft_limits_bound_answers(planner):
    robot = load(planner, "soft-limits/robot.urdf")
    scene = planner.load_scene("shelf", CASES / "soft-limits" / "scene.json", replace=True)
    bounds = {limit.name: (limit.lower, limit.upper) for limit in robot.variables}
    assert bounds["joint6"] == (2.2387, 2.8341) and bounds["joint7"] == (-0.4519, 1.0978)
    best = planner.shorten(read("soft-limits/path.csv"), robot, scene).result()
    for name, (lower, upper) in bounds.items():
        column = best.path[:, robot.columns.index(name)]
        assert lower <= column.min() and column.max() <= upper
