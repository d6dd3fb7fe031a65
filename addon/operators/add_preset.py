# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.add_preset`"""

from bpy.props import BoolProperty, EnumProperty
from bpy.types import Operator

from .. import musculature
from ..anatomy import fit, placement, preset_file, segments
from ..anatomy.skin_surface import SkinSurface
from ..errors import SinewError
from .base import SinewOperator, main_skin_of, rig_of_context

# Blender keeps no reference to an enumeration's texts, so this module must
_presets = []


def _preset_items(_self, _context):
    _presets[:] = preset_file.available()
    return _presets


class SINEW_OT_add_preset(SinewOperator, Operator):
    """Add a whole set of muscles to the armature, sized to lie under its mesh; muscles of the same names are replaced"""

    bl_idname, bl_label = "sinew.add_preset", "Add Muscles"

    name: EnumProperty(name="Preset", description="Which set of muscles", items=_preset_items)
    fit_skin: BoolProperty(name="Fit under Skin", description="Size the muscles so that they lie under the mesh", default=True)

    def run(self, context):
        rig = rig_of_context(context)
        if rig.library:
            raise SinewError(f"{rig.name} is linked from another file: make a library override of it first")
        preset = preset_file.read(self.name)
        skin = main_skin_of(rig)
        surface = SkinSurface.of(skin, rig) if skin and self.fit_skin else None
        shapes = placement.place(preset, segments.recognise(rig), surface)
        if surface:
            shapes = [fit.fit(shape, surface) for shape in shapes]
        musculature.add(rig, shapes)
        muscles = sum(shape.kind == "MUSCLE" for shape in shapes)
        return f"{muscles} muscles and {len(shapes) - muscles} other tissues added to {rig.name}"
