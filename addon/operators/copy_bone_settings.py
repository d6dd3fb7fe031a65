# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.copy_bone_settings`"""

from bpy.props import EnumProperty
from bpy.types import Operator

from ..errors import SinewError
from ..muscles import mirror
from ..scene import bone_geometry
from ..scene.linked_data import writable
from ..settings import bone_settings
from .base import SinewOperator, active_bone, rig_of_context

TARGETS = (
    ("SEGMENT", "Whole Segment", "The other bones of the same segment of the body: its split and twist bones"),
    ("SELECTED", "Selected Bones", "The other selected bones"),
    ("MIRROR", "Other Side", "The bone of the flipped name, with its split and twist bones"),
)


class SINEW_OT_copy_bone_settings(SinewOperator, Operator):
    """Copy Sinew's settings of the active bone to its whole segment, to the selected bones or to the other side"""

    bl_idname, bl_label = "sinew.copy_bone_settings", "Copy Bone Settings"

    to: EnumProperty(name="To", description="Which bones get the settings", items=TARGETS, default="SEGMENT")

    @classmethod
    def poll(cls, context):
        if not super().poll(context):
            return False
        if active_bone(context) is None:
            cls.poll_message_set("Make the bone active whose settings are copied (Pose Mode)")
            return False
        return True

    def run(self, context):
        rig = writable(rig_of_context(context))
        source = active_bone(context)
        others = [bone for bone in _targets(rig, source, self.to) if bone != source.name]
        if not others:
            raise SinewError(_WITHOUT_OTHERS[self.to].format(source.name))
        for bone in others:
            bone_settings.copy(source, rig.pose.bones[bone])
        return f"Settings of {source.name} copied to {', '.join(others)}"


_WITHOUT_OTHERS = {
    "SEGMENT": "{} is a segment of its own: there is no other bone to copy to",
    "SELECTED": "Select other bones than {} as well, which get its settings",
    "MIRROR": "{} has no bone of the flipped name to copy to",
}


def _targets(rig, source, to: str) -> list[str]:
    if to == "SEGMENT":
        return bone_geometry.bones_of_segment(rig, source.name)
    if to == "SELECTED":
        return bone_geometry.selected_bones(rig)
    twin = mirror.flipped(source.name)
    if twin == source.name or not bone_geometry.has_bone(rig, twin):
        return []
    return bone_geometry.bones_of_segment(rig, twin)
