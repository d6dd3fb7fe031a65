# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.paint_region` adds the vertex group or attribute that scales a skin setting, and opens it for painting."""

import warnings

import bpy
from bpy.props import EnumProperty
from bpy.types import Operator

from ..errors import SinewError
from ..scene import armature_modifier, painted_data, skin_regions
from .base import SinewOperator, skins_of_context

PARAMETERS = tuple((parameter.name, parameter.label, parameter.description) for parameter in skin_regions.PARAMETERS)
FORMER_NAMES = {parameter.former_name: parameter for parameter in skin_regions.PARAMETERS if parameter.former_name}


class SINEW_OT_paint_region(SinewOperator, Operator):
    """Paint where a setting acts on the skin of the active mesh: 1 is the full setting, 0 switches it off"""

    bl_idname, bl_label = "sinew.paint_region", "Paint Region"

    parameter: EnumProperty(
        name="Setting",
        description="The setting to paint. Painted values multiply the values of the mesh and of its bones",
        items=(
            *PARAMETERS,
            # scripts of Sinew 0.1 use these; the menu does not offer them
            *((name, parameter.label, f"Former name of '{parameter.name}'") for name, parameter in FORMER_NAMES.items()),
        ),
        default="muscle_influence",
    )
    storage: EnumProperty(
        name="Storage", description="Where painted values are stored", items=painted_data.STORAGES, default="VERTEX_GROUP"
    )

    def draw(self, _context):
        column = self.layout.column()
        for name, _label, _description in PARAMETERS:
            column.prop_enum(self, "parameter", name)
        self.layout.prop(self, "storage")

    def run(self, context):
        if self.parameter in FORMER_NAMES:
            current = FORMER_NAMES[self.parameter].name
            warnings.warn(
                f"sinew.paint_region: parameter '{self.parameter}' is now '{current}'", DeprecationWarning, stacklevel=2
            )
            self.parameter = current
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
