"""Compares exported files with the skin in Blender. `imported.py` imports them without Sinew, in another process."""

import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from mathutils.kdtree import KDTree

from exports import imported

SUFFIXES = {"GLTF": ".glb", "FBX": ".fbx", "USD": ".usdc", "ALEMBIC": ".abc"}
# the frame at which each importer puts the scene's frame `start`: a glTF clip starts at 0; Blender's FBX importer adds 1
FIRST_FRAME = {".glb": lambda start: 0, ".fbx": lambda start: start + 1}


@dataclass(frozen=True)
class RoundTrip:
    """The result of importing a file.

    mean_mm, max_mm: distance from the points in Blender. missing: number of vertices that were not found again.
    contents: what Blender read from the file (see imported.py). log: the output of the importing process.
    """

    mean_mm: float
    max_mm: float
    missing: int
    contents: dict
    log: str


def shown(skin, frames) -> np.ndarray:
    """(frames, vertices, 3): the evaluated points of a mesh, world space."""
    points = []
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        points.append(imported.world_points(skin))
    return np.array(points)


def round_trips(files: list[tuple[Path, np.ndarray, str | None]], start: int) -> list[RoundTrip]:
    """Imports files in one process and compares each with points.

    files: path, (frames, vertices, 3) points of consecutive frames from `start` on, and the name of the mesh, or None for
    the mesh with the most vertices.
    """
    with tempfile.TemporaryDirectory() as folder:
        requests, results = [], []
        for number, (file, points, mesh) in enumerate(files):
            first = FIRST_FRAME.get(file.suffix, lambda start: start)(start)
            frames = list(range(first, first + len(points)))
            results.append(Path(folder, f"{number}.npz"))
            requests.append({"file": str(file), "frames": frames, "mesh": mesh, "result": str(results[-1])})
        request_file = Path(folder, "requests.json")
        request_file.write_text(json.dumps(requests))
        done = without_sinew([imported.__file__, request_file])
        log = done.stdout + done.stderr
        return [_compared(result, points, log) for result, (_, points, _) in zip(results, files, strict=True)]


def _compared(result: Path, points: np.ndarray, log: str) -> RoundTrip:
    with np.load(result) as loaded:
        found, contents = loaded["points"], json.loads(str(loaded["contents"]))
    same = same_vertices(found[0], points[0])
    apart_mm = 1000.0 * np.linalg.norm(found - points[:, same], axis=2)
    missing = len(points[0]) - len(np.unique(same))
    return RoundTrip(float(apart_mm.mean()), float(apart_mm.max()), missing, contents, log)


def same_vertices(points: np.ndarray, known: np.ndarray) -> np.ndarray:
    """(points,): for each point, the index of the nearest known point, both (N, 3) in the same pose.

    Some formats divide a vertex at a seam into several, and change the order.
    """
    tree = KDTree(len(known))
    for index, point in enumerate(known):
        tree.insert(point, index)
    tree.balance()
    return np.array([tree.find(point)[1] for point in points])


def without_sinew(arguments: list) -> subprocess.CompletedProcess:
    """Runs a script in this bpy with factory settings and without installed add-ons. Raises CalledProcessError."""
    environment = {key: value for key, value in os.environ.items() if not key.startswith("BLENDER_")}
    with tempfile.TemporaryDirectory() as folder:
        return subprocess.run(
            [sys.executable, *map(str, arguments)],
            env=environment | {"BLENDER_USER_RESOURCES": folder},
            check=True,
            capture_output=True,
            text=True,
        )
