#!/usr/bin/env bash
# MeshLab's reader (pymeshlab 2025.7) puts parts of a Collada file elsewhere: order of transforms and <scale> are lost.
#
# Versions: pymeshlab 2025.7.post1, pycollada 0.9.3 (PyPI).
# Input: a tetrahedron at the origin, 1 × 0.5 × 0.25 m, in a node with <rotate> and <translate> in either order, or a
#   <scale>. Collada: transforms apply from the last to the first, so "rotate, translate" turns the shifted mesh.
# Guess before the run: pymeshlab and pycollada agree on all boxes.
# Seen: to pymeshlab both orders are "translate, rotate": a part written the other way round lands at (1, 2, 3) instead of
#   (-2, 1, 3). A <scale> of 2 3 4 is not applied. No warning.
# Why it matters: MeshLab is a common step from a maker's visual DAE to a collision STL or convex hull. The result sits
#   metres beside the link that is drawn, or has another size; a planner then proves paths for another robot.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet pymeshlab==2025.7.post1 pycollada==0.9.3 numpy==2.4.6
cd "$folder"
seen=$(venv/bin/python - <<'PYTHON'
import pathlib

import collada
import numpy as np
import pymeshlab

DOCUMENT = """<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="meter" meter="1"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="part"><mesh>
<source id="corners"><float_array id="numbers" count="12">0 0 0 1 0 0 0 0.5 0 0 0 0.25</float_array>
<technique_common><accessor source="#numbers" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="vertices"><input semantic="POSITION" source="#corners"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#vertices" offset="0"/><p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene"><node id="node">%s<instance_geometry url="#part"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#scene"/></scene></COLLADA>"""
TURN, SHIFT, SCALE = "<rotate>0 0 1 90</rotate>", "<translate>1 2 3</translate>", "<scale>2 3 4</scale>"


def box(points):
    words = lambda corner: " ".join(f"{c + 0:g}" for c in np.round(corner, 4) + 0.0)
    return f"({words(points.min(axis=0))}) to ({words(points.max(axis=0))})"


for name, transforms in (("translate, rotate", SHIFT + TURN), ("rotate, translate", TURN + SHIFT), ("scale", SCALE)):
    pathlib.Path("part.dae").write_text(DOCUMENT % transforms)
    bound = [part.vertex for shown in collada.Collada("part.dae").scene.objects("geometry") for part in shown.primitives()]
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh("part.dae")
    mesh = meshes.current_mesh()
    print(f"{name}: pycollada {box(np.concatenate(bound))}, pymeshlab {box(mesh.transformed_vertex_matrix())}")
PYTHON
)
expected="translate, rotate: pycollada (0.5 2 3) to (1 3 3.25), pymeshlab (0.5 2 3) to (1 3 3.25)
rotate, translate: pycollada (-2.5 1 3) to (-2 2 3.25), pymeshlab (0.5 2 3) to (1 3 3.25)
scale: pycollada (0 0 0) to (2 1.5 1), pymeshlab (0 0 0) to (1 0.5 0.25)"
printf '%s\n' "$seen"
[[ "$seen" == "$expected" ]] || { printf 'expected:\n%s\n' "$expected" >&2; exit 1; }
