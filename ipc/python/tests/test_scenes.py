"""Scenes that live."""

import pytest
from conftest import PATIENCE

import taut

BOX = {"id": "box", "primitives": [{"type": "box", "dimensions": [0.1, 0.1, 0.1]}], "primitive_poses": [{}]}


@pytest.fixture
def cell(planner, problems):
    planner.load_robot("scene-arm", problems.parent / "robots" / "panda_like.urdf", replace=True)
    scene = planner.load_scene("cell", {"objects": [{**BOX, "pose": {"position": [1, 0, 0]}}]}, replace=True)
    yield scene
    if not planner.closed:
        scene.unload()


def test_changes_make_versions(planner, cell):
    first = cell.snapshot()
    moved = cell.move("box", [0.9, 0.0, 0.1])
    assert moved.version == first.version + 1 and moved.hash != first.hash
    assert cell.add("ball", {"type": "sphere", "dimensions": [0.05]}, [2, 0, 0]).objects == 2
    links = planner.robot("scene-arm")
    assert links.columns
    hand = cell.attach("ball", "hand", [0, 0, 0.1], touch=["box"])
    assert cell.move("ball", [0, 0, 0.2], link="hand").version == hand.version + 1
    assert cell.detach("ball", [3, 0, 0, 0, 0, 0, 1]).objects == 2
    assert cell.remove("ball").objects == 1
    content = cell.snapshot(first.version).content
    assert content["objects"][0]["pose"]["position"] == [1, 0, 0]
    diff = cell.snapshot(moved.version, base=first.version).content
    assert "MOVE" in str(diff)
    summary = next(scene for scene in planner.scenes() if scene.label == "cell")
    assert summary.objects == 1


def test_diffs_are_made_as_a_whole_or_not_at_all(cell):
    before = cell.snapshot()
    wrong = {"objects": [{"id": "box", "operation": "REMOVE"}, {"id": "ghost", "operation": "REMOVE"}]}
    with pytest.raises(taut.UnknownName, match="ghost"):
        cell.diff(wrong)
    assert cell.snapshot() == before
    with pytest.raises(taut.VersionConflict):
        cell.diff({"objects": []}, base=before.version + 5)
    for change in ({"objects": 3}, {"objekts": []}, {"objects": [{1, 2}]}, {"objects": [{"id": float("nan")}]}):
        with pytest.raises(taut.InvalidInput):
            cell.diff(change)
    for pose in ([1, 2], [0, 0, 0, 0, 0, 0, 9], [float("nan"), 0, 0]):
        with pytest.raises(taut.Error):
            cell.move("box", pose)


def test_pinned_versions_stay(cell):
    first = cell.snapshot().version
    assert first in cell.pin(first).pinned
    with pytest.raises(taut.VersionConflict):
        cell.unload()
    assert first not in cell.unpin(first).pinned


def test_an_answer_names_its_version(planner, problems):
    problem = planner.load_problem(problems / "rooms.json", scene="versions")
    scene = planner.scene("versions")
    old = planner.check(problem.path, problem.robot, scene)
    new = scene.diff({"objects": [{**BOX, "operation": "ADD", "pose": {"position": [50, 50, 0]}}]})
    assert planner.check(problem.path, problem.robot, scene).scene_version == new.version
    assert planner.check(problem.path, problem.robot, scene, scene_version=old.scene_version).scene_version == old.scene_version
    scene.unload()


def test_a_subscriber_hears_of_changes(daemon):
    scene = daemon.load_scene("heard", {"objects": []}, replace=True)
    changes = scene.subscribe()
    assert changes.next(timeout=0.0) is None
    made = scene.diff({"objects": [{**BOX, "operation": "ADD"}]})
    change = changes.next(PATIENCE)
    assert (change.kind, change.version, change.hash) == ("changed", made.version, made.hash)
    scene.unload()
    assert next(changes).kind == "deleted"


def test_a_watched_path_becomes_unsafe_and_safe(daemon, problems):
    problem = daemon.load_problem(problems / "rooms.json", scene="watched")
    scene = daemon.scene("watched")
    with daemon.watch(problem.path, problem.robot, scene) as watch:
        assert watch.next(PATIENCE)
        x, y = problem.path[5][:2]
        scene.diff({"objects": [{"id": "intruder", "operation": "ADD", "pose": {"position": [x, y, 0]},
                                 "primitives": [{"type": "sphere", "dimensions": [0.05]}],
                                 "primitive_poses": [{}]}]})
        verdict = watch.next(PATIENCE)
        assert not verdict and "intruder" in verdict.problem.names
        scene.remove("intruder")
        assert watch.next(PATIENCE)
    scene.unload()


def test_what_a_sensor_sees_has_an_age(daemon, problems):
    problem = daemon.load_problem(problems / "rooms.json", scene="sensed")
    scene = daemon.scene("sensed")
    assert daemon.check(problem.path, problem.robot, scene).world_age is None
    scene.sense("head", radius=0.01)
    sensed = lambda: next(version for version in daemon.scenes() if version.label == "sensed").sensed
    assert sensed() == (taut.Sensed("head"),)
    far = [[50.0, 50.0, 0.0]]
    scene.set_cloud("head", far)
    (head,) = sensed()
    assert head.points == 1 and head.age > 0
    with daemon.watch(problem.path, problem.robot, scene, max_age=1.0) as watch:
        seen = watch.next(PATIENCE)
        assert seen and 0 < seen.world_age <= 1.0
        silent = watch.next(PATIENCE)
        assert not silent and silent.code_name == "CLOUD_TOO_OLD" and "head" in str(silent.problem)
        assert silent.world_age > 1.0
        scene.set_cloud("head", far)
        assert watch.next(PATIENCE)
    scene.unload()


def test_a_watch_and_a_subscription_need_a_daemon(problems):
    with taut.local() as here:
        problem = here.load_problem(problems / "rooms.json")
        with pytest.raises(taut.InvalidInput, match="daemon"):
            here.scene(problem.scene).subscribe()
        with pytest.raises(taut.InvalidInput, match="daemon"):
            here.watch(problem.path, problem.robot, problem.scene).next()


def test_files_that_are_none_are_refused(planner, tmp_path):
    bad = tmp_path / "bad.json"
    bad.write_text("{")
    for call in (
        lambda: planner.load_scene("bad", bad),
        lambda: planner.load_scene("bad", {"objects": 1}),
        lambda: planner.load_scene("bad", 3),
        lambda: planner.load_problem(bad),
        lambda: planner.load_robot("bad", bad),
    ):
        with pytest.raises(taut.InvalidInput):
            call()
    for call in (
        lambda: planner.load_scene("bad", tmp_path / "none.json"),
        lambda: planner.load_problem(tmp_path / "none.json"),
        lambda: planner.load_robot("bad", tmp_path / "none.urdf"),
    ):
        with pytest.raises(taut.UnreadableFile):
            call()
