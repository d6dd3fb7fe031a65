# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.paint_region`"""

import bpy
from bpy.props import EnumProperty
from bpy.types import Operator

from ..errors import SinewError
from ..scene import armature_modifier, painted_data, skin_regions
from .base import SinewOperator, skins_of_context


class SINEW_OT_paint_region(SinewOperator, Operator):
    """Give the active mesh a vertex group (or float attribute) that says where the skin follows a setting: 1 fully, 0 not at all"""

    bl_idname, bl_label = "sinew.paint_region", "Paint Region"

    parameter: EnumProperty(
        name="Setting",
        description="What is painted; it multiplies what is set for the whole mesh and for its bones",
        items=[(found.name, found.label, found.description) for found in skin_regions.PARAMETERS],
        default="muscle_influence",
    )
    storage: EnumProperty(
        name="Storage", description="What is painted in", items=painted_data.STORAGES, default="VERTEX_GROUP"
    )

    def run(self, context):
        skin = _skin_of_context(context)
        parameter = skin_regions.parameter_of(self.parameter)
        painted_data.make(skin, parameter, self.storage)  # may be refused, and leaves the mode as it was then
        if context.object.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        context.view_layer.objects.active = skin
        skin.select_set(True)
        if self.storage == "VERTEX_GROUP":
            bpy.ops.object.mode_set(mode="WEIGHT_PAINT")
        if parameter.of_mesh and getattr(skin.sinew, parameter.of_mesh) == 0.0:
            self.report({"WARNING"}, f"{parameter.label} of {skin.name} is 0, and painting multiplies it: set it first")
        return f"Paint {parameter.painted} of {skin.name}: 1 leaves the skin as it is, 0 takes all {parameter.label} away"


def _skin_of_context(context):
    """The active mesh, or of the active armature the bound one with most vertices, which can be painted."""
    skins = skins_of_context(context)
    if context.object.type != "MESH":
        skins = [skin for skin in skins if armature_modifier.is_bound(skin)] or skins
        skins.sort(key=lambda skin: -len(skin.data.vertices))
    skin = skins[0]
    if skin.library or skin.data.library:
        raise SinewError(f"{skin.name} is linked from another file and can't be painted: paint it there, or make it local")
    if not skin.visible_get():
        raise SinewError(f"{skin.name} is hidden: show it to paint it")
    return skin
