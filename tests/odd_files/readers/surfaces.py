"""Meshes: STL, OBJ and Collada."""

import numpy as np


def measured(corners):
    """Of triangles, an n × 3 × 3 array: box, area, signed volume, and the area's centre."""
    corners = np.asarray(corners, float).reshape(-1, 3, 3)
    # A triangle that comes twice in the same order is there once.
    first = np.array([min(range(3), key=lambda i: tuple(t[i])) for t in corners], int)
    corners = np.stack([np.roll(t, -i, axis=0) for t, i in zip(corners, first)]) if len(corners) else corners
    corners = np.unique(corners.reshape(-1, 9), axis=0).reshape(-1, 3, 3)
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    corners, areas = corners[areas > 0], areas[areas > 0]
    if len(corners) == 0:
        raise ValueError("no triangle with an area")
    lo, hi = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    a, b, c = (corners[:, i] - lo for i in range(3))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
    centre = (areas[:, None] * (a + b + c) / 3).sum(axis=0) / areas.sum() + lo
    return {"surface": {"lo": lo, "hi": hi, "area": areas.sum(), "volume": volume, "centre": centre}}


def indexed(vertices, faces):
    return measured(np.asarray(vertices, float)[np.asarray(faces, int)])


def fan(polygon):
    return [[polygon[0], polygon[i], polygon[i + 1]] for i in range(1, len(polygon) - 1)]


def coal_(file):
    import coal

    mesh = coal.MeshLoader().load(str(file), np.ones(3))
    triangles = [[t[0], t[1], t[2]] for t in map(mesh.tri_indices, range(mesh.num_tris))]
    return indexed(mesh.vertices(), triangles)


def trimesh_(file):
    import trimesh

    mesh = trimesh.load(str(file), process=False, force="mesh")
    return measured(mesh.triangles)


def numpy_stl(file):
    import stl.mesh

    meshes = list(stl.mesh.Mesh.from_multi_file(str(file)))
    return measured(np.concatenate([m.vectors for m in meshes]))


def meshio_(file):
    import meshio

    mesh = meshio.read(str(file))
    faces = []
    for block in mesh.cells:
        if block.type in ("triangle", "quad", "polygon"):
            faces += [t for row in block.data for t in fan(list(row))]
    return indexed(mesh.points, faces)


def of_vtk(reader, file):
    import vtk
    from vtkmodules.util.numpy_support import vtk_to_numpy

    errors = []
    reader.AddObserver("ErrorEvent", lambda *event: errors.append("error"))
    reader.SetFileName(str(file))
    cut = vtk.vtkTriangleFilter()
    cut.PassLinesOff()
    cut.PassVertsOff()
    cut.SetInputConnection(reader.GetOutputPort())
    cut.Update()
    if errors:
        raise ValueError("vtk reports an error")
    data = cut.GetOutput()
    if data.GetNumberOfPolys() == 0:
        raise ValueError("no polygon")
    cells = vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    return indexed(vtk_to_numpy(data.GetPoints().GetData()), cells)


def vtk_stl(file):
    import vtk

    return of_vtk(vtk.vtkSTLReader(), file)


def vtk_obj(file):
    import vtk

    return of_vtk(vtk.vtkOBJReader(), file)


def pymeshlab_(file):
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(file))
    corners = []
    for i in range(meshes.mesh_number()):
        mesh = meshes.mesh(i)
        corners.append(mesh.transformed_vertex_matrix()[mesh.face_matrix()])
    return measured(np.concatenate(corners))


def tinyobj(file):
    import tinyobjloader

    reader = tinyobjloader.ObjReader()
    if not reader.ParseFromFile(str(file)):
        raise ValueError(reader.Error())
    vertices = np.array(reader.GetAttrib().vertices).reshape(-1, 3)
    faces = [index.vertex_index for shape in reader.GetShapes() for index in shape.mesh.indices]
    return indexed(vertices, np.reshape(faces, (-1, 3)))


def pycollada(file):
    """Every bound geometry as pycollada cuts it, times the unit."""
    import collada

    document = collada.Collada(str(file))
    scene = document.scene or (document.scenes[0] if len(document.scenes) else None)
    if scene is None:
        raise ValueError("no scene")
    triangles = []
    for bound in scene.objects("geometry"):
        for part in bound.primitives():
            if isinstance(part, (collada.lineset.BoundLineSet,)):
                continue
            part = part if hasattr(part, "vertex_index") and hasattr(part, "triangleset") is False else part.triangleset()
            triangles.append(part.vertex[part.vertex_index])
    unit = document.assetInfo.unitmeter
    return measured(np.concatenate(triangles) * (1.0 if unit is None else unit))


STL = {
    "coal": coal_,
    "trimesh": trimesh_,
    "numpy-stl": numpy_stl,
    "meshio": meshio_,
    "vtk": vtk_stl,
    "pymeshlab": pymeshlab_,
}
OBJ = {"coal": coal_, "trimesh": trimesh_, "meshio": meshio_, "vtk": vtk_obj, "tinyobj": tinyobj, "pymeshlab": pymeshlab_}
DAE = {"coal": coal_, "pycollada": pycollada, "pymeshlab": pymeshlab_}
