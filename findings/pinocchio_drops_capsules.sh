#!/usr/bin/env bash
# pinocchio 4.1.0 loads a robot with <capsule> collision shapes without those shapes, unless <robot> has a version.
#
# Versions: pin 4.1.0 with cmeel-urdfdom 6.0.0 (PyPI); beside it drake 1.51.1.
# Input: a robot of a base and a sliding arm, both capsules (radius 0.1 m, straight part 0.4 m), which overlap at 0;
#   `<robot name="r">` without `version`, as most URDFs are written; then with version 1.0, 1.1 and 1.2.
# Guess before the run: urdfdom 6 knows capsules, so pinocchio reads them in all four; or it raises for old versions.
# Seen: without a version and with 1.0 the model loads, no exception, and has no collision shape at all: every
#   configuration is free. (An error on stderr names the link, not the capsule.) From 1.1 on both capsules are there and
#   collide. drake reads the capsules in all files.
# Why it matters: capsules are the usual hand-made collision model of arms and humanoids (drake and pybullet
#   read them). A planner on pinocchio then proves nothing at all and says "free"; the same file with one more attribute
#   collides.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet pin==4.1.0 cmeel-urdfdom==6.0.0 drake==1.51.1
cd "$folder"
seen=$(venv/bin/python - 2>/dev/null <<'PYTHON'
import pathlib

import numpy as np
import pinocchio as pin
from pydrake.geometry import SceneGraph
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

capsule = '<collision><geometry><capsule radius="0.1" length="0.4"/></geometry></collision>'
for version in ("", ' version="1.0"', ' version="1.1"', ' version="1.2"'):
    pathlib.Path("robot.urdf").write_text(f"""<robot name="r"{version}><link name="base">{capsule}</link>
      <link name="arm">{capsule}</link><joint name="x" type="prismatic"><parent link="base"/><child link="arm"/>
      <axis xyz="1 0 0"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint></robot>""")
    model = pin.buildModelFromUrdf("robot.urdf")
    geometry = pin.buildGeomFromUrdf(model, "robot.urdf", pin.GeometryType.COLLISION)
    geometry.addAllCollisionPairs()
    data = pin.GeometryData(geometry)
    hit = pin.computeCollisions(model, model.createData(), geometry, data, np.zeros(1), True)
    plant, graph = MultibodyPlant(0.0), SceneGraph()
    plant.RegisterAsSourceForSceneGraph(graph)
    Parser(plant).AddModels("robot.urdf")
    print(f"{version.strip() or 'no version':13} pinocchio: {geometry.ngeoms} shapes,"
          f" {'collision' if hit else 'free'}; drake: {plant.num_collision_geometries()} shapes")
PYTHON
)
expected='no version    pinocchio: 0 shapes, free; drake: 2 shapes
version="1.0" pinocchio: 0 shapes, free; drake: 2 shapes
version="1.1" pinocchio: 2 shapes, collision; drake: 2 shapes
version="1.2" pinocchio: 2 shapes, collision; drake: 2 shapes'
printf '%s\n' "$seen"
[[ "$seen" == "$expected" ]] || { printf 'expected:\n%s\n' "$expected" >&2; exit 1; }
