# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.unbind` removes the bind and the correction of skins."""

from bpy.types import Operator

from ..errors import SinewError
from ..scene import armature_modifier
from ..skin import binding
from .base import SinewOperator, skins_of_context


class SINEW_OT_unbind(SinewOperator, Operator):
    """Unbind the active mesh, or all meshes of the active armature, from the muscles. Muscles and baked keys remain"""

    bl_idname, bl_label = "sinew.unbind", "Unbind Skin"
    needs_bound_skin = True

    def run(self, context):
        bound = [skin for skin in skins_of_context(context) if armature_modifier.is_bound(skin)]
        if not bound:
            raise SinewError(f"{context.object.name} is not bound")
        for skin in bound:
            if skin.library:
                raise SinewError(f"{skin.name} is linked from another file. Unbind it there, or make it local")
        for skin in bound:
            binding.unbind(skin)
        return f"{', '.join(skin.name for skin in bound)} unbound"
