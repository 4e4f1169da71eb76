"""Times: the same trajectory as from everywhere else, as numpy arrays, and what is told where there is none."""

import json
import os
import subprocess

import numpy as np
import pytest

import taut

#: What is asked; its work is counted, so that answers are equal.
TIMES = taut.Times(acceleration="2/s", speed=0.5, work=20000)


def shortened(planner, problems, **more):
    problem = planner.load_problem(problems / "arm_window.json")
    return problem, planner.shorten(problem.path, problem.robot, problem.scene, budget=20000, **more)


def test_a_trajectory_comes_after_the_path_and_is_what_the_command_line_gets(planner, problems):
    problem, answers = shortened(planner, problems, timing=TIMES)
    durations = [best.trajectory.duration for best in answers if best.times == "timed"]
    assert durations and durations == sorted(durations, reverse=True)
    result = answers.result()
    found = result.trajectory
    text = json.dumps({"acceleration": "2/s", "speed": 0.5, "work": 20000})
    again = shortened(planner, problems, timing=text)[1].result().trajectory
    assert np.array_equal(found.times_ns, again.times_ns) and np.array_equal(found.positions, again.positions)
    assert tuple(found.joint_names) == tuple(problem.columns) and found.positions.shape == (len(found), len(problem.columns))
    assert found.velocities.shape == found.positions.shape and found.accelerations is None
    assert np.array_equal(found.positions[0], result.path[0]) and np.array_equal(found.positions[-1], result.path[-1])
    assert np.all(np.diff(found.times_ns) > 0) and found.times[-1] == pytest.approx(found.duration)
    assert found.bound <= found.duration <= found.stops and found.decides in problem.columns
    assert all(motor.velocity_used <= 1 + 1e-6 for motor in found.motors.values())
    message = found.to_joint_trajectory()
    assert message["joint_names"] == list(problem.columns) and len(message["points"]) == len(found)
    last = message["points"][-1]
    assert last["time_from_start"]["sec"] * 10**9 + last["time_from_start"]["nanosec"] == found.times_ns[-1]
    assert set(last) == {"positions", "velocities", "time_from_start"}


def test_python_gets_the_bits_that_the_command_line_gets(planner, problems, tmp_path):
    limits = tmp_path / "joint_limits.yaml"
    limits.write_text("joint_limits: {joint1: {has_acceleration_limits: true, max_acceleration: 1.5}}\n")
    times = taut.Times(acceleration="2/s", limits=limits)
    found = shortened(planner, problems, timing=times)[1].result().trajectory
    command = [os.environ["TAUT_BIN"], "shorten", str(problems / "arm_window.json"), "--local", "--format", "json"]
    command += ["--budget", "20000", "--time", "--acceleration", "2/s", "--limits", str(limits)]
    told = json.loads(subprocess.run(command, capture_output=True, check=True, text=True).stdout)
    trajectory = told["times"]["trajectory"]
    assert found.times_ns.tolist() == trajectory["times_ns"]
    assert found.positions.tolist() == trajectory["positions"]
    assert found.velocities.tolist() == trajectory["velocities"]


def test_a_check_times_the_path_as_it_is(planner, problems):
    problem = planner.load_problem(problems / "arm_window.json")
    checked = planner.check(problem.path, problem.robot, problem.scene, timing="acceleration=2/s work=1")
    assert checked and np.array_equal(checked.path, problem.path)
    assert checked.trajectory.duration >= checked.trajectory.bound


def test_what_is_missing_is_told(planner, problems):
    result = shortened(planner, problems)[1].result()
    assert result.times == "not-asked"
    with pytest.raises(taut.Untimed, match="asked for no times"):
        result.trajectory
    with pytest.raises(taut.InvalidInput, match="acceleration limit"):
        shortened(planner, problems, timing=taut.Times())[1].result()
    with pytest.raises(taut.InvalidInput, match="valid"):
        shortened(planner, problems, timing=3)
    hurried = shortened(planner, problems, timing=TIMES, deadline=1e-9)[1]
    try:
        late = hurried.result()
    except taut.TimedOut:
        return
    assert late.times == "not-reached"
    with pytest.raises(taut.Untimed, match="no times yet"):
        late.trajectory
