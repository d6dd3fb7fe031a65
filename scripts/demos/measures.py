"""Measures the demo from outside: evaluated meshes and Empties, without the add-on's own data."""

import statistics
import time

import bpy
import numpy as np

from demos.motion import FRAME_END, FRAME_START

FRAMES = range(FRAME_START, FRAME_END + 1)


def points_of(skin) -> np.ndarray:
    """(V, 3) float32: the evaluated mesh of the current frame, mesh space."""
    mesh = skin.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    points = np.empty((len(mesh.vertices), 3), np.float32)
    mesh.attributes["position"].data.foreach_get("vector", points.reshape(-1))
    return points


def points_by_frame(skin) -> np.ndarray:
    """(frames, V, 3) float32: the evaluated mesh over the demo's motion."""
    shown = []
    for frame in FRAMES:
        bpy.context.scene.frame_set(frame)
        shown.append(points_of(skin))
    return np.array(shown)


def median_frame_ms(skin, rounds: int = 3) -> float:
    """The median time of one `frame_set` with evaluation of the mesh, over all frames and several rounds."""
    times = []
    for _ in range(rounds):
        for frame in FRAMES:
            start = time.perf_counter()
            bpy.context.scene.frame_set(frame)
            skin.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.vertices[0].co  # noqa: B018 - evaluates
            times.append(time.perf_counter() - start)
    return 1000.0 * statistics.median(times)


def muscles_of(rig) -> list:
    return [found for found in bpy.data.objects if found.parent == rig and found.sinew.tissue.kind == "MUSCLE"]


def ellipsoid_of(muscle) -> np.ndarray:
    """(4, 4): the matrix from the unit sphere to the ellipsoid that the Empty shows, world space."""
    shown = muscle.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return np.array(shown.matrix_world) @ np.diag([muscle.empty_display_size] * 3 + [1.0])


def largest_volume_drift(muscles: list) -> float:
    """The largest change of a belly's volume over the motion, as a fraction of its volume in the first frame."""
    by_frame = []
    for frame in FRAMES:
        bpy.context.scene.frame_set(frame)
        by_frame.append([abs(np.linalg.det(ellipsoid_of(muscle)[:3, :3])) for muscle in muscles])
    volumes = np.array(by_frame)
    return float(np.abs(volumes / volumes[0] - 1.0).max())
