# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.bind` binds skins to the muscles of their armature (docs/mathematics/binding.md)."""

from bpy.types import Operator

from ..errors import SinewError
from ..scene import armature_modifier, mesh_role
from ..settings import preferences
from ..skin import bind_outcomes, binding
from .base import SinewOperator, rig_of_context, skins_of_context


class SINEW_OT_bind(SinewOperator, Operator):
    """Bind the active and selected meshes to the muscles in the rest pose. On an armature: all its skin and cloth"""

    bl_idname, bl_label = "sinew.bind", "Bind Skin"
    needs_tissues = True

    def run(self, context):
        skins, rigid = skins_of_context(context), {}
        chosen = skins
        if context.object.type != "MESH":
            chosen, rigid = mesh_role.soft_and_rigid(skins, rig_of_context(context))
        before = [skin for skin in chosen if armature_modifier.is_bound(skin)]
        summaries, refused = binding.bind_all(chosen, context.evaluated_depsgraph_get())
        bind_outcomes.keep(skins, rigid | refused)
        for skin in chosen:
            if skin.name in summaries and skin not in before:
                preferences.set_quality(skin)
        if not summaries:
            raise SinewError(_refusal(rigid, refused))
        for reason in refused.values():
            self.report({"WARNING"}, reason)
        for reason in rigid.values():
            self.report({"INFO"}, f"Left as it is: {reason}")
        problems: dict[str, str] = {}
        for summary in summaries.values():
            problems |= summary.problems  # meshes of one armature have the same
        self.warn(problems)
        anchored = sum(summary.anchored for summary in summaries.values())
        vertices = sum(summary.vertices for summary in summaries.values())
        bound = f"{anchored} of {vertices} vertices bound to {max(s.tissues for s in summaries.values())} tissues"
        if len(summaries) + len(rigid) + len(refused) == 1:
            return bound
        others = {"rigid and left": rigid, "refused": refused}
        left = [f"{what}: {', '.join(names)}" for what, names in others.items() if names]
        return "; ".join([f"{', '.join(summaries)}: {bound}", *left])


def _refusal(rigid: dict[str, str], refused: dict[str, str]) -> str:
    """Why nothing was bound, and what to do."""
    if refused:
        return "\n".join(refused.values())
    left = "; ".join(rigid.values())
    return f"No mesh is skin or cloth: {left}. To bind such a mesh anyway, select it and click Bind Skin again"
