# SPDX-License-Identifier: GPL-3.0-or-later
"""A heat map over the skin: how strongly the chosen tissue moves each vertex, in the pose that the viewport shows.

The mesh is drawn over the viewport as weights are in Weight Paint, from blue (a little) to red (fully). Nothing is stored.
"""

import weakref

import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

from ..live import session
from ..scene import characters

# weight: linear red, green, blue, alpha. Skin that the tissue does not move stays as it is
STOPS = (0.0, 0.02, 0.25, 0.5, 0.75, 1.0)
COLOURS = np.array(
    (
        (0.0, 0.0, 0.6, 0.0),
        (0.0, 0.0, 1.0, 0.45),
        (0.0, 0.8, 1.0, 0.6),
        (0.0, 1.0, 0.1, 0.7),
        (1.0, 0.9, 0.0, 0.8),
        (1.0, 0.0, 0.0, 0.85),
    ),
    np.float32,
)
LIFT = 0.002  # of the mesh's size, so that the colors are in front of the surface

_drawing = None
# by skin: its state, the chosen tissue, and the weights; valid as long as the session keeps the state
_weights: dict[int, tuple] = {}


def is_shown() -> bool:
    """Whether the heat map is on."""
    return _drawing is not None


def show(shown: bool):
    """Turns the heat map on or off. While it is off, there is no draw handler."""
    global _drawing
    if shown and _drawing is None and not bpy.app.background:
        _drawing = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW")
    elif not shown and _drawing is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_drawing, "WINDOW")
        _drawing = None
        _weights.clear()


def colours_of(weights: np.ndarray) -> np.ndarray:
    """(vertices, 4) float32: the color of each weight, 0..1."""
    return np.stack([np.interp(weights, STOPS, COLOURS[:, channel]) for channel in range(4)], axis=1).astype(np.float32)


def weights_of(skin, rig) -> np.ndarray | None:
    """(vertices,) float32, 0..1: how strongly the chosen tissue moves a skin. None if no tissue that acts is chosen."""
    state, rig_state = session.cached_skin(skin), session.cached_rig(rig)
    if state is None or rig_state is None:
        return None
    chosen = rig.sinew.rig.chosen
    known = _weights.get(skin.session_uid)
    if known is None or known[0]() is not state or known[1] != chosen:
        known = _weights[skin.session_uid] = (weakref.ref(state), chosen, _read_weights(state, rig_state, rig, chosen))
    return known[2]


def _read_weights(state, rig_state, rig, chosen: str) -> np.ndarray | None:
    names = [tissue.name for tissue in characters.tissues_of(rig)]
    if chosen not in names or names.index(chosen) not in rig_state.solved:
        return None
    return state.skin.tissue_weights[:, rig_state.solved.index(names.index(chosen))].copy()


def triangles_of(skin, depsgraph):
    """(points (vertices, 3), triangles (triangles, 3)) of an evaluated mesh, moved a little outwards."""
    mesh = skin.evaluated_get(depsgraph).data
    points, normals = (np.empty((len(mesh.vertices), 3), np.float32) for _ in range(2))
    mesh.vertices.foreach_get("co", points.reshape(-1))
    mesh.vertex_normals.foreach_get("vector", normals.reshape(-1))
    triangles = np.empty((len(mesh.loop_triangles), 3), np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles.reshape(-1))
    size = float(np.ptp(points, axis=0).max(initial=0.0))
    return points + LIFT * size * normals, triangles


def _draw():
    context = bpy.context
    if not context.space_data.overlay.show_overlays:
        return
    for character in characters.in_file():
        rig = character.rig.find()
        for key in character.skins if rig else ():
            skin = key.find()
            if skin and skin.visible_get(view_layer=context.view_layer):
                _draw_skin(skin, rig, context.evaluated_depsgraph_get())


def _draw_skin(skin, rig, depsgraph):
    weights = weights_of(skin, rig)
    if weights is None or not weights.any():
        return
    points, triangles = triangles_of(skin, depsgraph)
    if len(points) != len(weights):
        return  # a modifier adds vertices, whose weights are not known
    moved = (weights[triangles] > 0.0).any(axis=1)
    shader = gpu.shader.from_builtin("SMOOTH_COLOR")
    batch = batch_for_shader(
        shader, "TRIS", {"pos": points, "color": colours_of(weights)}, indices=np.ascontiguousarray(triangles[moved])
    )
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_test_set("LESS_EQUAL")
    with gpu.matrix.push_pop():
        gpu.matrix.multiply_matrix(skin.matrix_world)
        batch.draw(shader)
    gpu.state.depth_test_set("NONE")
    gpu.state.blend_set("NONE")
