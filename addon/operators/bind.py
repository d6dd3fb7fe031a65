# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.bind` binds skins to the muscles of their armature (docs/mathematics/binding.md)."""

from bpy.types import Operator

from ..skin import binding
from .base import SinewOperator, skins_of_context


class SINEW_OT_bind(SinewOperator, Operator):
    """Bind the active mesh, or all meshes of the active armature, to the muscles in the rest pose"""

    bl_idname, bl_label = "sinew.bind", "Bind Skin"
    needs_tissues = True

    def run(self, context):
        skins = skins_of_context(context)
        for skin in skins:
            binding.check_bindable(skin)
        depsgraph = context.evaluated_depsgraph_get()
        summaries = [binding.bind(skin, depsgraph) for skin in skins]
        for summary in summaries:
            self.warn(summary.problems)
        anchored = sum(summary.anchored for summary in summaries)
        vertices = sum(summary.vertices for summary in summaries)
        return f"{anchored} of {vertices} vertices bound to {summaries[0].tissues} tissues"
