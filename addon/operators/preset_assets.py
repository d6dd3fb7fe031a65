# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets in the Asset Browser: `sinew.make_assets` writes the library, `sinew.drop_preset` follows a drop on a body."""

import bpy
from bpy.types import Operator
from mathutils import Vector

from ..errors import SinewError
from ..muscles import preset_assets
from ..scene import characters, selection
from ..settings import updates
from .base import Translated, is_in_window

# Beyond this part of a character's size, a preset was not dropped on it.
FARTHEST = 0.5


class SINEW_OT_make_assets(Translated, Operator):
    """Write all presets as assets with thumbnails, which can be dragged from the Asset Browser on a character"""

    bl_idname, bl_label, bl_options = "sinew.make_assets", "Presets in Asset Browser", {"REGISTER"}

    def execute(self, context):
        try:
            count = preset_assets.write()
            preset_assets.register_library(context.preferences)
        except (SinewError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"{count} presets are in the library {preset_assets.LIBRARY} of the Asset Browser")
        return {"FINISHED"}


class SINEW_OT_drop_preset(Translated, Operator):
    """Add the preset of the assets that were dropped in the scene to the character under them, and remove the assets"""

    bl_idname, bl_label = "sinew.drop_preset", "Drop Preset"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    def execute(self, context):
        dropped = [found for found in context.view_layer.objects if preset_assets.PROPERTY in found]
        if not dropped:
            self.report({"ERROR"}, "No preset was dropped. Drag one from the Asset Browser on a character")
            return {"CANCELLED"}
        at, preset = dropped[0].matrix_world.translation.copy(), str(dropped[0][preset_assets.PROPERTY])
        for empty in dropped:
            bpy.data.objects.remove(empty)
        try:
            rig = character_at(context, at)
            _leave_mode(context)
            selection.make_active(rig)
            self._add(preset)
        except (SinewError, RuntimeError) as error:
            self.report({"ERROR"}, str(error).removeprefix("Error: ").strip())
        return {"FINISHED"}  # also after an error: the assets are removed

    def _add(self, preset: str):
        if preset not in [asset.identifier for asset in preset_assets.all_presets()]:
            name = preset.removeprefix(preset_assets.OF_USER)
            raise SinewError(f"There is no preset '{name}' here any more. Write the assets again (Presets in Asset Browser)")
        if preset.startswith(preset_assets.OF_USER):
            name = preset.removeprefix(preset_assets.OF_USER)
            bpy.ops.sinew.load_preset(preset=name)
        else:
            bpy.ops.sinew.add_preset(name=preset)


def character_at(context, point: Vector):
    """The armature whose mesh or bones are nearest to a point in world space. Raises SinewError if none is near."""
    rigs = [found for found in context.view_layer.objects if found.type == "ARMATURE" and found.visible_get()]
    distances = {rig.name: _distance(context, rig, point) for rig in rigs}
    nearest = min(distances, key=distances.get, default=None)
    if nearest is None or distances[nearest] > FARTHEST * max(context.view_layer.objects[nearest].dimensions):
        raise SinewError("There is no character under the mouse. Drop the preset on the skin of one")
    return context.view_layer.objects[nearest]


def _distance(context, rig, point: Vector) -> float:
    depsgraph = context.evaluated_depsgraph_get()
    distances = []
    for skin in characters.skins_of(rig):
        evaluated = skin.evaluated_get(depsgraph)
        if evaluated.is_evaluated and len(evaluated.data.polygons):
            is_found, nearest, *_ = evaluated.closest_point_on_mesh(evaluated.matrix_world.inverted_safe() @ point)
            distances += [(evaluated.matrix_world @ nearest - point).length] if is_found else []
    if not distances:
        distances = [(rig.matrix_world @ bone.center - point).length for bone in rig.pose.bones]
    return min(distances, default=float("inf"))


def _leave_mode(context):
    active = context.view_layer.objects.active
    if active and active.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")


def _after_drop():
    """A handler can't change the scene, so the operator runs after it."""
    if not bpy.app.timers.is_registered(_follow_drop):
        bpy.app.timers.register(_follow_drop, first_interval=0.0)


def _follow_drop():
    windows = bpy.context.window_manager.windows
    if is_in_window() and windows:
        with bpy.context.temp_override(window=windows[0]):
            bpy.ops.sinew.drop_preset("INVOKE_DEFAULT")


def register():
    updates.on_preset_dropped.append(_after_drop)


def unregister():
    updates.on_preset_dropped.remove(_after_drop)
