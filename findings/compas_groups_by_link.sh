#!/usr/bin/env bash
# An SRDF group of links has other joints in compas_fab 2.0.1 than in MoveIt: those below its links, not those that carry them.
#
# Versions: compas_fab 2.0.1, compas_robots 1.0.1 (PyPI).
# Input: an arm of three joints j1 … j3 with two fingers g1, g2, and an SRDF with the same group said three ways: as a
#   chain from base to l3, as the joints j1 j2 j3, and as the links l1 l2 l3. SRDF: a link stands for its parent joint.
# Guess before the run: all three are j1, j2, j3.
# Seen: the group of links is j2, j3, g1, g2: without the joint that carries the first link, with both fingers'.
# Why it matters: whoever plans for that group with compas_fab holds the shoulder still and moves the gripper; a
#   configuration of "the arm" has four numbers where MoveIt's has three, with other meanings.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet compas_fab==2.0.1 compas_robots==1.0.1 compas==2.15.1
cd "$folder"
seen=$(venv/bin/python - <<'PYTHON'
from compas_fab.robots import RobotSemantics
from compas_robots import RobotModel

chain = [("j1", "base", "l1"), ("j2", "l1", "l2"), ("j3", "l2", "l3"), ("g1", "l3", "f1"), ("g2", "l3", "f2")]
links = "".join(f'<link name="{name}"/>' for name in ("base", "l1", "l2", "l3", "f1", "f2"))
joint = ('<joint name="%s" type="revolute"><parent link="%s"/><child link="%s"/><axis xyz="0 0 1"/>'
         '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>')
robot = RobotModel.from_urdf_string('<robot name="r">' + links + "".join(joint % j for j in chain) + "</robot>")
for kind, members in (
    ("chain", '<chain base_link="base" tip_link="l3"/>'),
    ("joints", "".join(f'<joint name="{name}"/>' for name in ("j1", "j2", "j3"))),
    ("links", "".join(f'<link name="{name}"/>' for name in ("l1", "l2", "l3"))),
):
    srdf = f'<robot name="r"><group name="arm">{members}</group></robot>'
    semantics = RobotSemantics.from_srdf_string(srdf, robot)
    print(f"{kind}: {' '.join(semantics.groups['arm']['joints'])}")
PYTHON
)
expected="chain: j1 j2 j3
joints: j1 j2 j3
links: j2 j3 g1 g2"
printf '%s\n' "$seen"
[[ "$seen" == "$expected" ]] || { printf 'expected:\n%s\n' "$expected" >&2; exit 1; }
