"""Files of the extension's exports held against what Blender shows: imported without Sinew, by `imported.py` in a process of its own."""

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
# what each importer makes of the scene's frame `start`: glTF's clips begin at 0; Blender's FBX importer counts from 1
FIRST_FRAME = {".glb": lambda start: 0, ".fbx": lambda start: start + 1}


@dataclass(frozen=True)
class RoundTrip:
    """What came back of a file: distances in mm from what was shown, how many vertices were found again, what the file gave Blender."""

    mean_mm: float
    max_mm: float
    missing: int
    told: dict
    log: str


def shown(skin, frames) -> np.ndarray:
    """(frames, vertices, 3): the points of a mesh as the scene shows them, world space."""
    found = []
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        found.append(imported.world_points(skin))
    return np.array(found)


def round_trips(files: list[tuple[Path, np.ndarray, str | None]], start: int) -> list[RoundTrip]:
    """Imports files, all in one process, and holds each against points, (frames, vertices, 3), of frames from `start` on, one after
    the other; those of the mesh of this name, or of that with most vertices.
    """
    with tempfile.TemporaryDirectory() as folder:
        asked = []
        for number, (file, points, mesh) in enumerate(files):
            first = FIRST_FRAME.get(file.suffix, lambda start: start)(start)
            frames = list(range(first, first + len(points)))
            asked.append({"file": str(file), "frames": frames, "mesh": mesh, "result": str(Path(folder, f"{number}.npz"))})
        asked_file = Path(folder, "asked.json")
        asked_file.write_text(json.dumps(asked))
        done = without_sinew([imported.__file__, asked_file])
        log = done.stdout + done.stderr
        return [_held_against(Path(one["result"]), points, log) for one, (_, points, _) in zip(asked, files, strict=True)]


def _held_against(result: Path, points: np.ndarray, log: str) -> RoundTrip:
    with np.load(result) as loaded:
        got, told = loaded["points"], json.loads(str(loaded["told"]))
    same = same_vertices(got[0], points[0])
    apart_mm = 1000.0 * np.linalg.norm(got - points[:, same], axis=2)
    missing = len(points[0]) - len(np.unique(same))
    return RoundTrip(float(apart_mm.mean()), float(apart_mm.max()), missing, told, log)


def same_vertices(points: np.ndarray, known: np.ndarray) -> np.ndarray:
    """(points,) the place of each point among the known ones, (N, 3) both, of one pose, by distance.

    A vertex that lies at a seam is several in some formats, and the order is another.
    """
    tree = KDTree(len(known))
    for place, point in enumerate(known):
        tree.insert(point, place)
    tree.balance()
    return np.array([tree.find(point)[1] for point in points])


def without_sinew(arguments: list) -> subprocess.CompletedProcess:
    """Runs a script in this bpy with factory settings and nobody's add-ons. Raises CalledProcessError."""
    own = {key: value for key, value in os.environ.items() if not key.startswith("BLENDER_")}
    with tempfile.TemporaryDirectory() as folder:
        return subprocess.run(
            [sys.executable, *map(str, arguments)],
            env=own | {"BLENDER_USER_RESOURCES": folder},
            check=True,
            capture_output=True,
            text=True,
        )
