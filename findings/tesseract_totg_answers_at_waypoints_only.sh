#!/usr/bin/env bash
# What a controller makes of tesseract-robotics 0.5.1's TOTG breaks the limits that TOTG was given.
#
# Versions: tesseract-robotics 0.5.1, numpy 2.4.6 (PyPI).
# Input: three joints through three waypoints, velocities within 1, 1.5 and 2 rad/s, accelerations within twice that;
#   TimeOptimalTrajectoryGeneration(path_tolerance 0.1, min_angle_change 0.001).
# Guess before the run: points dense enough that their interpolation keeps the limits, as MoveIt's TOTG has them (0.1 s).
# Seen: `True`, and three points: states of the time-optimal curve at the waypoints, with accelerations. Between them a
#   controller that has positions, velocities and accelerations goes by quintics (ros2_control's
#   joint_trajectory_controller), and that curve accelerates by 1.39 times the limit. With all accelerations left out
#   it goes by cubics, by 1.48 times the limit. Nothing is raised or printed.
# Why it matters: the curve that TOTG found is not the one that is executed: neither its limits nor its way, so neither a
#   check of its points nor its tolerance says anything of what the robot does. On shortened paths among obstacles
#   the acceleration was up to 10 times the limit, and 15 of 21 collided at a path_tolerance of 0.001.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet tesseract-robotics==0.5.1 numpy==2.4.6
cd "$folder"
seen=$(venv/bin/python - <<'PYTHON'
import numpy as np
from tesseract_robotics.tesseract_command_language import (
    CompositeInstruction, InstructionPoly_as_MoveInstructionPoly, MoveInstruction, MoveInstructionPoly_wrap_MoveInstruction,
    MoveInstructionType_FREESPACE, StateWaypoint, StateWaypointPoly_wrap_StateWaypoint, WaypointPoly_as_StateWaypointPoly)
from tesseract_robotics.tesseract_time_parameterization import InstructionsTrajectory, TimeOptimalTrajectoryGeneration

rows = np.array([[0, 0, 0], [0.5, 0.2, -0.3], [1.0, 0.1, 0.4]])
velocity = np.array([1.0, 1.5, 2.0])
acceleration = 2 * velocity
names = ["a", "b", "c"]
program = CompositeInstruction()
for row in rows:
    waypoint = StateWaypointPoly_wrap_StateWaypoint(StateWaypoint(names, row))
    move = MoveInstruction(waypoint, MoveInstructionType_FREESPACE)
    program.appendMoveInstruction(MoveInstructionPoly_wrap_MoveInstruction(move))
trajectory = InstructionsTrajectory(program)
both = lambda most: np.stack([-most, most], 1)
answer = TimeOptimalTrajectoryGeneration(0.1, 0.001).compute(trajectory, both(velocity), both(acceleration), both(10 * acceleration))
points = []
instructions = program.getInstructions()
for index in range(len(instructions)):
    instruction = instructions[index]
    move = InstructionPoly_as_MoveInstructionPoly(instruction)
    waypoint = move.getWaypoint()
    state = WaypointPoly_as_StateWaypointPoly(waypoint)
    lists = state.getPosition(), state.getVelocity(), state.getAcceleration()
    points.append((state.getTime(), *(np.array(values, float).reshape(-1) for values in lists)))


def accelerates(by_quintics):
    """The largest part of an acceleration limit between the points, by joint_trajectory_controller's formulas."""
    most = 0.0
    for (s, p, v, k), (e, q, w, l) in zip(points, points[1:]):
        h = e - s
        for u in np.linspace(0, 1, 201):
            if by_quintics:
                c3 = 20 * (q - p) - (12 * v + 8 * w) * h - (3 * k - l) * h**2
                c4 = -30 * (q - p) + (16 * v + 14 * w) * h + (3 * k - 2 * l) * h**2
                c5 = 12 * (q - p) - 6 * (v + w) * h - (k - l) * h**2
                there = k + (3 * c3 * u + 6 * c4 * u**2 + 10 * c5 * u**3) / h**2
            else:
                there = ((6 - 12 * u) * (q - p) + ((6 * u - 4) * v + (6 * u - 2) * w) * h) / h**2
            most = max(most, np.max(abs(there) / acceleration))
    return most


print(f"{answer}, {len(points)} points in {points[-1][0]:.3f} s")
print(f"by quintics {accelerates(True):.2f}, by cubics {accelerates(False):.2f} of the limit")
PYTHON
)
expected="True, 3 points in 1.558 s
by quintics 1.39, by cubics 1.48 of the limit"
printf '%s\n' "$seen"
[[ "$seen" == "$expected" ]] || { printf 'expected:\n%s\n' "$expected" >&2; exit 1; }
