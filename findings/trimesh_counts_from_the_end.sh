#!/usr/bin/env bash
# Negative indices of an OBJ mean other corners to trimesh 5.2.0 and meshio 5.3.5 than to the format.
#
# Versions: trimesh 5.2.0, meshio 5.3.5, tinyobjloader 2.0.0rc13, vtk 9.7.2 (PyPI).
# Input: a cube of 1 m, written as a stream: four vertices, then `f -4 -3 -2 -1`, six times. -1 is the last vertex
#   before the line, so that exporters need not count.
# Guess before the run: all four read a cube of volume 1.
# Seen: trimesh counts from the last vertex of the file: all six faces are the last one, volume 0, without a warning.
#   meshio makes yet another surface, of volume 0 too. tinyobjloader and VTK read the cube.
# Why it matters: yourdfpy, urchin and many planners' tools load collision meshes with trimesh. The link or obstacle
#   becomes one square; every query away from it says "free".
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet trimesh==5.2.0 meshio==5.3.5 tinyobjloader==2.0.0rc13 vtk==9.7.2 numpy==2.4.6
cd "$folder"
seen=$(venv/bin/python - <<'PYTHON'
import pathlib

import meshio
import numpy as np
import tinyobjloader
import trimesh
import vtk
from vtkmodules.util.numpy_support import vtk_to_numpy

points = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
quads = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
stream = "".join("".join("v %g %g %g\n" % points[i] for i in quad) + "f -4 -3 -2 -1\n" for quad in quads)
pathlib.Path("cube.obj").write_text(stream)


def show(name, corners):
    a, b, c = np.asarray(corners, float).reshape(-1, 3, 3).transpose(1, 0, 2)
    size = np.ptp(np.concatenate([a, b, c]), axis=0)
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
    print(f"{name}: {len(a)} triangles, volume {volume + 0:.3f}, size {' '.join(f'{s:g}' for s in size)}")


show("trimesh", trimesh.load("cube.obj", process=False, force="mesh").triangles)
mesh = meshio.read("cube.obj")
show("meshio", [mesh.points[[q[0], q[i], q[i + 1]]] for block in mesh.cells for q in block.data for i in (1, 2)])
reader = tinyobjloader.ObjReader()
reader.ParseFromFile("cube.obj")
found = np.reshape(reader.GetAttrib().vertices, (-1, 3))
show("tinyobjloader", [found[i.vertex_index] for shape in reader.GetShapes() for i in shape.mesh.indices])
reader, cut = vtk.vtkOBJReader(), vtk.vtkTriangleFilter()
reader.SetFileName("cube.obj")
cut.SetInputConnection(reader.GetOutputPort())
cut.Update()
data = cut.GetOutput()
show("vtk", vtk_to_numpy(data.GetPoints().GetData())[vtk_to_numpy(data.GetPolys().GetConnectivityArray())])
PYTHON
)
expected="trimesh: 12 triangles, volume 0.000, size 0 1 1
meshio: 12 triangles, volume 0.000, size 1 1 1
tinyobjloader: 12 triangles, volume 1.000, size 1 1 1
vtk: 12 triangles, volume 1.000, size 1 1 1"
printf '%s\n' "$seen"
[[ "$seen" == "$expected" ]] || { printf 'expected:\n%s\n' "$expected" >&2; exit 1; }
