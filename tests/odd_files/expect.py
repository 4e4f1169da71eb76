#!/usr/bin/env python3
"""Makes expected.json anew: what independent programs read in the corpus.

    TAUT_ODD_FILES=/tmp/odd cargo test --test odd_files -- --ignored write_the_corpus
    python3 -m venv /tmp/readers && /tmp/readers/bin/pip install -r tests/odd_files/requirements.txt
    /tmp/readers/bin/python tests/odd_files/expect.py /tmp/odd tests/odd_files/expected.json [KIND ...]

Each reader has a process of its own. `ours` stands for values that are written down here by the
format's own words, where no reader on PyPI has them: MoveIt is not on PyPI, so its messages are read here by two
evaluators, one over PyYAML with rotation matrices, one over ruamel.yaml with SciPy's rotations.
"""

import importlib
import importlib.metadata
import json
import math
import multiprocessing
import os
import pathlib
import re
import sys

import numpy as np

from readers import robots, scenes, semantics, surfaces

SECONDS = 60
KINDS = {
    "stl": surfaces.STL,
    "obj": surfaces.OBJ,
    "dae": surfaces.DAE,
    "urdf": robots.READERS,
    "srdf": semantics.READERS,
    "scene": scenes.READERS,
}
LIBRARIES = [
    "coal", "pinocchio", "trimesh", "stl.mesh", "meshio", "vtk", "vtkmodules.util.numpy_support", "pymeshlab",
    "tinyobjloader", "collada", "yourdfpy", "urchin", "pybullet", "pydrake.multibody.parsing", "pydrake.multibody.plant",
    "pydrake.geometry", "pydrake.math", "compas_robots", "compas_fab.robots", "tesseract_robotics.tesseract_srdf",
    "tesseract_robotics.tesseract_urdf", "yaml", "ruamel.yaml", "scipy.spatial.transform",
]
# Package that a reader is, the library beneath it, and the family whose code it shares.
PACKAGES = {
    "coal": (["coal", "cmeel-assimp"], "assimp"),
    "trimesh": (["trimesh"], "trimesh"),
    "numpy-stl": (["numpy-stl"], "numpy-stl"),
    "meshio": (["meshio"], "meshio"),
    "vtk": (["vtk"], "vtk"),
    "pymeshlab": (["pymeshlab"], "vcg"),
    "tinyobj": (["tinyobjloader"], "tinyobj"),
    "pycollada": (["pycollada"], "pycollada"),
    "pinocchio": (["pin", "cmeel-urdfdom"], "urdfdom"),
    "yourdfpy": (["yourdfpy"], "yourdfpy"),
    "urchin": (["urchin"], "urdfpy"),
    "pybullet": (["pybullet"], "bullet"),
    "drake": (["drake"], "drake"),
    "tesseract": (["tesseract-robotics"], "tesseract"),
    "compas": (["compas_robots", "compas_fab"], "compas"),
    "pinocchio-srdf": (["pin"], "pinocchio"),
    "messages-pyyaml": (["PyYAML", "numpy"], "messages-pyyaml"),
    "messages-ruamel": (["ruamel.yaml", "scipy"], "messages-ruamel"),
    "ours": ([], "ours"),
}


def load_libraries():
    """Before the children are made: each would load them anew."""
    for name in LIBRARIES:
        importlib.import_module(name)


def of_all(reader, files, pipe):
    """In the child: what a reader makes of each file."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    for file in files:
        try:
            pipe.send(("read", rounded(reader(file))))
        except BaseException as error:  # what a reader raises is its answer
            text = str(error).strip() or type(error).__name__
            pipe.send(("refused", f"{type(error).__name__}: {text}"))
    pipe.close()
    os._exit(0)


def ask(reader, files):
    """The answers of a reader; when its process ends or hangs, another one goes on with the next file."""
    context = multiprocessing.get_context("fork")
    answers = []
    while len(answers) < len(files):
        ours, theirs = context.Pipe(duplex=False)
        child = context.Process(target=of_all, args=(reader, files[len(answers):], theirs))
        child.start()
        theirs.close()
        answer = None
        while len(answers) < len(files) and (answer is None or answer[0] != "died"):
            answer = ("died", "hangs")
            if ours.poll(SECONDS):
                try:
                    answer = ours.recv()
                except EOFError:
                    answer = ("died", "ends its process")
            answers.append(answer)
        if child.is_alive() and answer[0] == "died":
            child.kill()
        child.join()
    return answers


def rounded(value):
    if isinstance(value, dict):
        return {str(key): rounded(value[key]) for key in sorted(value)}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [rounded(item) for item in value]
    if isinstance(value, (float, np.floating)):
        return None if not math.isfinite(value) else float(f"{float(value):.12g}") + 0.0
    return int(value) if isinstance(value, np.integer) else value


def same(a, b, size=1.0):
    """As in compare.rs, more strictly."""
    if isinstance(a, dict) and isinstance(b, dict):
        if {"lo", "hi"} <= b.keys():
            if None in a["lo"] + a["hi"] + b["lo"] + b["hi"]:
                return a == b
            size = float(np.linalg.norm(np.subtract(b["hi"], b["lo"])))
        power = {"area": 2, "volume": 3}
        solid = lambda key, value: abs(value) if key == "volume" else value
        return a.keys() == b.keys() and all(same(solid(k, a[k]), solid(k, b[k]), size ** power.get(k, 1)) for k in a)
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(same(x, y, size) for x, y in zip(a, b))
    if isinstance(a, (int, float)) and isinstance(b, (int, float)) and not isinstance(a, bool):
        return abs(a - b) <= 4e-6 * (max(1.0, abs(b)) if size == 1.0 else size)
    return a == b


def add(meanings, reader, answer):
    for aspect, value in answer.items():
        groups = meanings.setdefault(aspect, [])
        group = next((g for g in groups if same(value, g["value"])), None)
        if group is None:
            groups.append({"readers": [reader], "value": value})
        else:
            group["readers"].append(reader)


def main(folder, out, kinds):
    files = json.loads((folder / "list.json").read_text())
    former = json.loads(out.read_text())["files"] if kinds else {}
    load_libraries()
    table = {name: former[name] for name, _ in files if name in former}
    died = []
    for kind in kinds or KINDS:
        of_kind = [(name, digest) for name, digest in files if name.startswith(f"{kind}/")]
        table.update({name: {"digest": digest, "meanings": {}, "refused": {}} for name, digest in of_kind})
        for reader, read in KINDS[kind].items():
            answers = ask(read, [folder / name for name, _ in of_kind])
            for (name, _), (how, answer) in zip(of_kind, answers):
                if how == "died":
                    died.append(f"{name}: {reader} {answer}")
                elif how == "refused":
                    line = re.sub(r"\s+", " ", answer.replace(str(folder), "")).strip()
                    table[name]["refused"][reader] = line[:160]
                else:
                    add(table[name]["meanings"], reader, answer)
            print(kind, reader, flush=True)
    versions = lambda packages: ", ".join(f"{p} {importlib.metadata.version(p)}" for p in packages)
    readers = {r: {"family": PACKAGES[r][1], "version": versions(PACKAGES[r][0])} for r in sorted(PACKAGES)}
    lines = [f' "{name}": {json.dumps(table[name], ensure_ascii=False)}' for name in sorted(table)]
    head = f'{{"readers": {json.dumps(readers, indent=1)},\n"files": {{\n'
    out.write_text(head + ",\n".join(lines) + "\n}}\n")
    if died:
        sys.exit("these readers die of these files, which must not stay in the corpus:\n" + "\n".join(died))


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]), sys.argv[3:])
