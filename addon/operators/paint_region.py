# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.paint_region` adds the vertex group or attribute that scales a skin setting, and opens it for painting."""

import bpy
from bpy.props import EnumProperty
from bpy.types import Operator

from ..errors import SinewError
from ..scene import armature_modifier, painted_data, skin_regions
from .base import SinewOperator, skins_of_context


class SINEW_OT_paint_region(SinewOperator, Operator):
    """Paint where a setting acts on the skin of the active mesh: 1 is the full setting, 0 switches it off"""

    bl_idname, bl_label = "sinew.paint_region", "Paint Region"

    parameter: EnumProperty(
        name="Setting",
        description="The setting to paint. Painted values multiply the values of the mesh and of its bones",
        items=[(parameter.name, parameter.label, parameter.description) for parameter in skin_regions.PARAMETERS],
        default="muscle_influence",
    )
    storage: EnumProperty(
        name="Storage", description="Where painted values are stored", items=painted_data.STORAGES, default="VERTEX_GROUP"
    )

    def run(self, context):
        skin = _skin_of_context(context)
        parameter = skin_regions.parameter_of(self.parameter)
        painted_data.make(skin, parameter, self.storage)  # before the mode changes, because it can raise
        if context.object.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        context.view_layer.objects.active = skin
        skin.select_set(True)
        if self.storage == "VERTEX_GROUP":
            bpy.ops.object.mode_set(mode="WEIGHT_PAINT")
        if parameter.of_mesh and getattr(skin.sinew.skin, parameter.name) == 0.0:
            self.report(
                {"WARNING"}, f"{parameter.label} of {skin.name} is 0, so painting has no effect. Set it above 0 first"
            )
        return f"Paint {parameter.painted} of {skin.name}. 1 keeps {parameter.label}, 0 removes it"


def _skin_of_context(context):
    """The active mesh, or the largest bound mesh of the active armature. Raises SinewError if it cannot be painted."""
    skins = skins_of_context(context)
    if context.object.type != "MESH":
        skins = [skin for skin in skins if armature_modifier.is_bound(skin)] or skins
        skins.sort(key=lambda skin: -len(skin.data.vertices))
    skin = skins[0]
    if skin.library or skin.data.library:
        raise SinewError(f"{skin.name} is linked from another file and cannot be painted. Paint it there, or make it local")
    if not skin.visible_get():
        raise SinewError(f"{skin.name} is hidden. Show it to paint it")
    return skin
