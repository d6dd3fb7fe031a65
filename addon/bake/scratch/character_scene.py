# SPDX-License-Identifier: GPL-3.0-or-later
"""A temporary scene that holds only the characters of a bake, so that a bake does not evaluate the rest of the file.

Blender also evaluates what these objects depend on, such as the targets of constraints, although the scene does not hold it.
"""

import types
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import bpy

from ...errors import SinewError
from ...live import handlers
from ...scene import armature_modifier, characters, stored_settings
from ...scene.current_frame import split_frame, visit_frames

_NAME = "Sinew Bake"
_ANIMATED_DATA = ("objects", "armatures", "meshes", "shape_keys", "node_groups", "worlds", "materials")


@contextmanager
def visit_frames_of_characters(scene, skins: list) -> Iterator[Callable[[float], bpy.types.Depsgraph]]:
    """Yields a function that evaluates the characters of these skins at a frame, and returns the evaluation.

    A fraction is a subframe. The scene shows its frame again when the block ends. Where a character may depend on the scene
    itself, the scene is evaluated instead.
    """
    if depends_on_scene(scene):
        with visit_frames(scene) as go_to:
            yield lambda frame: _in_scene(go_to, frame)
        return
    before = scene.frame_current, scene.frame_subframe
    added = _add(scene, skins)
    uid = added.session_uid

    def evaluate(frame: float):
        own = _by_uid(uid)
        if own is None:
            raise SinewError(f"The scene '{_NAME}', which the bake needs, was deleted meanwhile: bake again")
        whole, fraction = split_frame(frame)
        own.frame_set(whole, subframe=fraction)
        own.view_layers[0].update()
        return own.view_layers[0].depsgraph

    try:
        yield evaluate
    finally:
        own = _by_uid(uid)
        if own:
            bpy.data.scenes.remove(own)
        # Blender writes animated values to the originals, and the meshes hold the corrections of the last frame
        frame, subframe = before
        scene.frame_set(frame, subframe=subframe)


def depends_on_scene(scene) -> bool:
    """Whether a pose may depend on the scene as such: by a simulation, a driver, or another add-on's handler."""
    if scene.rigidbody_world or handlers.has_foreign():
        return True
    functions = [name for name, found in bpy.app.driver_namespace.items() if isinstance(found, types.FunctionType)]
    return any(
        _refers_to_scene(curve.driver, ["bpy", *functions])
        for name in _ANIMATED_DATA
        for datum in getattr(bpy.data, name)
        if datum.animation_data
        for curve in datum.animation_data.drivers
    )


def _refers_to_scene(driver, names: list[str]) -> bool:
    if driver.type == "SCRIPTED" and any(name in driver.expression for name in names):
        return True
    return any(
        variable.type == "CONTEXT_PROP" or isinstance(target.id, bpy.types.Scene)
        for variable in driver.variables
        for target in variable.targets
    )


def _in_scene(go_to: Callable[[float], None], frame: float):
    go_to(frame)
    return bpy.context.evaluated_depsgraph_get()


def _add(scene, skins: list):
    added = bpy.data.scenes.new(_NAME)
    for name in ("fps", "fps_base", "frame_map_old", "frame_map_new", "use_simplify", "simplify_subdivision"):
        setattr(added.render, name, getattr(scene.render, name))
    for name in ("frame_start", "frame_end", "use_gravity", "gravity"):
        setattr(added, name, getattr(scene, name))
    added.unit_settings.scale_length = scene.unit_settings.scale_length
    for member in _members(skins):
        added.collection.objects.link(member)
    return added


def _members(skins: list) -> list:
    """The objects of the characters of these skins, and the bodies that the skins are worn over, once each."""
    settings = [stored_settings.skin_of(skin) for skin in skins]
    bodies = [found.worn_over for found in settings if found is not None and found.worn_over]
    meshes = [*skins, *bodies]
    rigs = [armature_modifier.rig_of(mesh) for mesh in meshes]
    tissues = [tissue for rig in rigs for tissue in (*characters.tissues_of(rig), *characters.vias_of(rig))]
    return list(dict.fromkeys((*rigs, *meshes, *tissues)))


def _by_uid(uid: int):
    return next((found for found in bpy.data.scenes if found.session_uid == uid), None)
