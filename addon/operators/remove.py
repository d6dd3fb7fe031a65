# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.remove` removes Sinew from a character."""

from bpy.props import BoolProperty
from bpy.types import Operator

from ..bake.cache import playback
from ..bake.keys import key_store
from ..export import export_copy
from ..live import session
from ..measure import report
from ..muscles import edit
from ..reach import goals
from ..scene import armature_modifier, characters, correction_modifier, painted_data
from ..scene.linked_data import writable
from ..settings import object_settings, preferences
from ..skin import binding, grow
from .base import SinewOperator, rig_of_context


class SINEW_OT_remove(SinewOperator, Operator):
    """Remove all muscles, goals, corrections, baked data, grown skin, painted regions and settings of the character"""

    bl_idname, bl_label = "sinew.remove", "Remove Sinew"

    keep_baked: BoolProperty(
        name="Keep Baked",
        description="Keep baked shape keys, the point cache and the export copy. They work without Sinew",
        default=False,
    )

    keep_grown: BoolProperty(
        name="Keep Grown Skin",
        description="Keep the grown skin. Its Armature modifier deforms it",
        default=False,
    )

    def invoke(self, context, _event):
        stored = preferences.current()
        if stored is not None and not stored.confirms_remove:
            return self.execute(context)
        return context.window_manager.invoke_props_dialog(self, title="Remove Sinew from the Character?")

    def run(self, context):
        rig = writable(rig_of_context(context))
        # an unbound mesh still has its settings and baked keys
        skins = [skin for skin in characters.skins_of(rig) if skin.library is None]
        for skin in skins:
            if skin.data.library is None:
                painted_data.remove_all(skin)
        for skin in [skin for skin in skins if skin.is_property_set("sinew")]:
            if self.keep_baked:
                skin.sinew.skin.live = False  # so that the remaining keys play
            else:
                key_store.remove_baked(skin)
                playback.detach(skin)
            if armature_modifier.is_bound(skin):
                binding.unbind(skin)
            report.remove(skin)
            was_grown = grow.is_grown(skin)
            object_settings.clear(skin)
            if was_grown and not self.keep_grown:
                if context.object == skin:
                    context.view_layer.objects.active = rig
                grow.discard(skin)
        if self.keep_baked:
            export_copy.release(rig)
        else:
            export_copy.remove(rig)
        correction_modifier.remove_unused()
        count = edit.remove_all(rig)
        goals.remove_all(rig)
        for bone in [bone for bone in rig.pose.bones if bone.is_property_set("sinew")]:
            object_settings.clear(bone)
        session.forget_bone_settings(rig)
        object_settings.clear(rig)
        return f"{count} tissues removed from {rig.name}. Its meshes have their original shape"
