# SPDX-License-Identifier: GPL-3.0-or-later
"""Attachment lines: tendons and curved muscle paths, drawn over viewports whose overlays are on."""

import weakref
from dataclasses import dataclass

import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

from ..live import session
from ..live.rig_cache import RigState
from ..scene import bone_geometry, characters, tissue_empty

COLOUR = (1.0, 0.85, 0.55, 0.9)
WIDTH_PX = 2.0

_drawing = None
# attachments by rig, valid as long as the session keeps the rig's state
_attached = {}


@dataclass(frozen=True)
class _Attached:
    """Attachments of the muscles of a rig.

    origins, insertions: (muscles, 4) float32, homogeneous, in the space of their bones.
    origin_bones, insertion_bones: (muscles,) indices of these bones in the pose.
    rows: (muscles,) indices of the muscles in the posed tissues.
    """

    state: weakref.ref
    origins: np.ndarray
    origin_bones: np.ndarray
    insertions: np.ndarray
    insertion_bones: np.ndarray
    rows: np.ndarray


def lines_of(rig, state: RigState) -> np.ndarray:
    """(points, 3) float32: the two ends of each line, in armature space and in the pose of the last frame.

    A straight muscle has two lines, its tendons. A curved muscle has the lines of its whole path.
    """
    attached = _attached.get(rig.session_uid)
    if attached is None or attached.state() is not state:
        attached = _attached[rig.session_uid] = _read(rig, state)
    belly = state.posed[attached.rows]
    centre, half = belly[:, 3, :3], belly[:, 2, :3]
    # the matrices are column-major, so a row vector is multiplied from the left
    origins = np.einsum("pi,pij->pj", attached.origins, state.pose[attached.origin_bones])[:, :3]
    insertions = np.einsum("pi,pij->pj", attached.insertions, state.pose[attached.insertion_bones])[:, :3]
    tendons = np.stack((origins, centre - half, centre + half, insertions), axis=1)
    points, offsets = state.musculature.path_points(state.pose)
    is_straight = np.diff(offsets)[attached.rows] <= 2
    paths = [np.repeat(points[offsets[row] : offsets[row + 1]], 2, axis=0)[1:-1] for row in attached.rows[~is_straight]]
    return np.concatenate((tendons[is_straight].reshape(-1, 3), *paths)).astype(np.float32)


def _read(rig, state: RigState) -> _Attached:
    tissues = characters.tissues_of(rig)
    rows, ends = [], ([], [])
    for row, tissue in enumerate(state.solved):
        shape = tissue_empty.read(tissues[tissue], rig)
        if shape.kind != "MUSCLE":
            continue
        rows.append(row)
        for end, bone, point in zip(ends, (shape.origin_bone, shape.insertion_bone), (shape.origin, shape.insertion)):
            end.append((state.rest.index_of_bone[bone], bone_geometry.in_bone(rig, bone, point)))
    bones = [np.array([bone for bone, _ in end], np.intp) for end in ends]
    points = [np.array([(*point, 1.0) for _, point in end], np.float32).reshape(-1, 4) for end in ends]
    return _Attached(weakref.ref(state), points[0], bones[0], points[1], bones[1], np.array(rows, np.intp))


def _draw():
    space = bpy.context.space_data
    if not space.overlay.show_overlays:
        return
    for character in characters.in_file():
        rig = character.rig.find()
        state = session.cached_rig(rig) if rig else None
        if state is None or state.musculature is None or not rig.sinew.rig.show_attachments:
            continue
        if bpy.context.view_layer.objects.get(rig.name) != rig:
            continue  # excluded from the view layer (a hidden armature still shows its muscles)
        lines = lines_of(rig, state)
        if len(lines):
            _draw_lines(lines, rig.matrix_world)


def _draw_lines(lines: np.ndarray, to_world):
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    batch = batch_for_shader(shader, "LINES", {"pos": lines})
    _left, _bottom, width, height = gpu.state.viewport_get()
    shader.bind()
    shader.uniform_float("viewportSize", (width, height))
    shader.uniform_float("lineWidth", WIDTH_PX)
    shader.uniform_float("color", COLOUR)
    gpu.state.blend_set("ALPHA")
    with gpu.matrix.push_pop():
        gpu.matrix.multiply_matrix(to_world)
        batch.draw(shader)
    gpu.state.blend_set("NONE")


def register():
    global _drawing
    if not bpy.app.background:
        _drawing = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW")


def unregister():
    global _drawing
    if _drawing:
        bpy.types.SpaceView3D.draw_handler_remove(_drawing, "WINDOW")
    _drawing = None
    _attached.clear()
