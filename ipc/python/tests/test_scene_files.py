"""Scene files that others read another way than they looked, with their right values."""

import numpy as np
import pytest

import taut

PATH = np.array([[0.2, 0.9], [1.0, 0.3]])


@pytest.fixture
def cases(problems):
    return problems.parent.parent / "tests" / "cases"


@pytest.fixture
def arm(planner, cases):
    return planner.load_robot("frames-arm", cases / "object-frames" / "arm2.urdf", replace=True)


@pytest.mark.parametrize("name", ["f", "f_ref"])
def test_a_frame_is_an_objects(planner, cases, arm, name):
    scene = planner.load_scene("frames", cases / "object-frames" / f"{name}.json", replace=True)
    verdict = planner.check(PATH, arm, scene)
    assert not verdict and list(verdict.problem.names) == ["fore", "crate"]
    assert abs(verdict.problem.t - 0.079) < 1e-3


@pytest.mark.parametrize(
    ("file", "part"),
    [
        ("object-frames/c.json", "attach it"),
        ("object-frames/d.json", "shelff"),
        ("octomap-in-scene/scene_c.json", "octomap"),
        ("octomap-in-scene/scene.yaml", "octomap"),
        ("misspelt-field/s.json", "did you mean `primitives`"),
        ("pose-not-set/cone.yaml", "has a cone"),
    ],
)
def test_what_is_not_read_is_refused_by_name(planner, cases, arm, file, part):
    with pytest.raises(taut.Error, match=part):
        planner.load_scene("refused", cases / file, replace=True)
