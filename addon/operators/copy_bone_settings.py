# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.copy_bone_settings` copies the settings of a bone to other bones."""

from bpy.props import EnumProperty
from bpy.types import Operator

from ..errors import SinewError
from ..muscles import mirror
from ..scene import bone_geometry
from ..scene.linked_data import writable
from ..settings import bone_settings
from .base import SinewOperator, active_bone, rig_of_context

TARGETS = (
    ("SEGMENT", "Whole Segment", "The other bones of the same segment of the body, such as twist bones"),
    ("SELECTED", "Selected Bones", "The other bones that are selected in Pose Mode"),
    ("MIRROR", "Other Side", "The bone with the flipped name, and the other bones of its segment"),
)


class SINEW_OT_copy_bone_settings(SinewOperator, Operator):
    """Copy the bone settings of the active bone to its segment, to the selected bones or to the other side"""

    bl_idname, bl_label = "sinew.copy_bone_settings", "Copy Bone Settings"

    to: EnumProperty(name="To", description="The bones that get the settings", items=TARGETS, default="SEGMENT")

    @classmethod
    def poll(cls, context):
        if not super().poll(context):
            return False
        if active_bone(context) is None:
            cls.poll_message_set("Select the bone to copy from in Pose Mode")
            return False
        return True

    def run(self, context):
        rig = writable(rig_of_context(context))
        source = active_bone(context)
        others = [bone for bone in _targets(rig, source, self.to) if bone != source.name]
        if not others:
            raise SinewError(_NO_TARGETS[self.to].format(source.name))
        for bone in others:
            bone_settings.copy(source, rig.pose.bones[bone])
        return f"Settings of {source.name} copied to {', '.join(others)}"


_NO_TARGETS = {
    "SEGMENT": "{} is the only bone of its segment, so there is no bone to copy to",
    "SELECTED": "Select the target bones, then {} last (active)",
    "MIRROR": "{} has no bone with the flipped name to copy to",
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
