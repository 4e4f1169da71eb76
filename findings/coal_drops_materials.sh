#!/usr/bin/env bash
# A collision mesh with more than one material loses faces in coal 3.0.3, and so in pinocchio 4.1.0.
#
# Versions: pin 4.1.0, coal 3.0.3, cmeel-assimp 6.0.5 (PyPI).
# Input: a cube of 1 m as OBJ, one object of eight vertices and six quads; once without materials, once with a
#   `usemtl` line before each face, as exporters write painted parts. The surfaces are the same.
# Guess before the run: both are read as the same cube, since materials say nothing about the shape.
# Seen: with materials, volume 0 instead of 1 m³: all twelve triangles lie on the first face. assimp hands out a mesh
#   for each material of an object; coal joins them, but counts the indices of each from the first one's vertices.
#   A ball in the middle of each of the six faces touches only one of them, and pinocchio calls the robot free where
#   it stands in the cube's wall. Nothing is raised or printed.
# Why it matters: planners that check with pinocchio or coal take such a link or obstacle for a sheet. Join the materials before export, or look at the volume of what was loaded.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet pin==4.1.0 coal==3.0.3 libcoal==3.0.3 cmeel-assimp==6.0.5
cd "$folder"
seen=$(venv/bin/python - <<'PYTHON'
import coal, numpy as np, pathlib, pinocchio as pin

vertices = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
faces = ["1 4 3 2", "5 6 7 8", "1 2 6 5", "2 3 7 6", "3 4 8 7", "4 1 5 8"]
middles = [(.5, .5, 0), (.5, .5, 1), (.5, 0, .5), (1, .5, .5), (.5, 1, .5), (0, .5, .5)]

def robot(has_materials):
    text = "".join("v %g %g %g\n" % v for v in vertices)
    for i, face in enumerate(faces):
        text += (f"usemtl paint{i}\n" if has_materials else "") + f"f {face}\n"
    pathlib.Path("cube.obj").write_text(text)
    pathlib.Path("robot.urdf").write_text("""<robot name="r">
      <link name="base"><collision><geometry><mesh filename="cube.obj"/></geometry></collision></link>
      <link name="ball"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
      <joint name="x" type="prismatic"><parent link="base"/><child link="ball"/><axis xyz="1 0 0"/>
        <origin xyz="0 0.5 0.5"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint></robot>""")
    model = pin.buildModelFromUrdf("robot.urdf")
    geometry = pin.buildGeomFromUrdf(model, "robot.urdf", pin.GeometryType.COLLISION, package_dirs=["."])
    geometry.addAllCollisionPairs()
    data = pin.GeometryData(geometry)
    hit = pin.computeCollisions(model, model.createData(), geometry, data, np.array([1.0]), True)
    return geometry.geometryObjects[0].geometry, hit

for has_materials in (False, True):
    mesh, hit = robot(has_materials)
    points = np.asarray(mesh.vertices())
    corners = np.array([[points[t[k]] for k in range(3)] for t in map(mesh.tri_indices, range(mesh.num_tris))])
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    touched = 0
    for middle in middles:
        result = coal.CollisionResult()
        at = coal.Transform3s(np.eye(3), np.array(middle, float))
        touched += coal.collide(mesh, coal.Transform3s(), coal.Sphere(.05), at, coal.CollisionRequest(), result) > 0
    print(f"{'materials' if has_materials else 'plain'}: {mesh.num_tris} triangles, volume {volume + 0:.3f},"
          f" faces touched {touched} of 6, ball in the wall: {'collision' if hit else 'free'}")
PYTHON
)
expected="plain: 12 triangles, volume 1.000, faces touched 6 of 6, ball in the wall: collision
materials: 12 triangles, volume 0.000, faces touched 1 of 6, ball in the wall: free"
printf '%s\n' "$seen"
[[ "$seen" == "$expected" ]] || { printf 'expected:\n%s\n' "$expected" >&2; exit 1; }
