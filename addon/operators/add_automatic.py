# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.add_automatic` adds muscles to the joints of any skeleton (docs/mathematics/fitting.md, Automatic muscles)."""

from bpy.props import EnumProperty, FloatProperty
from bpy.types import Operator

from ..errors import SinewError
from ..muscles import edit
from ..muscles.placing.place import automatic
from ..scene import characters, skinned_bones
from ..scene.linked_data import writable
from ..skin.main_skin import skins_to_fit
from .base import SinewOperator, rig_of_context
from .tissue_options import ALONG, FIT_SKIN

SCOPES = (
    ("AUTO", "Automatic", "The joints of the bones that are selected in Pose Mode; without a selection, all joints"),
    ("SELECTED", "Selected Bones", "The joints between the selected bones and their parents"),
    ("ALL", "All Bones", "Every joint of the armature"),
)
POSITION_OF_KIND = {
    "FLEXOR": "On the side to which the joint bends",
    "EXTENSOR": "On the side opposite to the flexor",
    "ABDUCTOR": "On the side away from the center of the body",
    "ADDUCTOR": "On the side towards the center of the body",
}
KINDS = tuple((kind, kind.capitalize(), POSITION_OF_KIND[kind]) for kind in automatic.KINDS)


class SINEW_OT_add_automatic(SinewOperator, Operator):
    """Add four muscles to each joint of the selected bones or of the whole armature. Works for any skeleton"""

    bl_idname, bl_label = "sinew.add_automatic", "Add Muscles to Joints"

    scope: EnumProperty(name="Joints", description="The joints that get muscles", items=SCOPES, default="AUTO")
    kinds: EnumProperty(
        name="Muscles",
        description="The muscles to add to each joint",
        items=KINDS,
        options={"ENUM_FLAG"},
        default=set(automatic.KINDS),
    )
    along: ALONG
    gamma: FloatProperty(
        name="Distance",
        description="Distance of the attachments from the bones, as a fraction of each bone's length",
        min=0.0,
        max=10.0,
        soft_max=0.5,
        default=0.12,
    )
    shortest_bone: FloatProperty(
        name="Shortest Bone",
        description="Bones shorter than this get no muscles. 0: chosen by the size of the armature",
        min=0.0,
        soft_max=0.2,
        subtype="DISTANCE",
    )
    fit_skin: FIT_SKIN

    @classmethod
    def poll(cls, context):
        if not super().poll(context):
            return False
        if context.object.type == "ARMATURE" and len(context.object.data.bones) < 2:
            cls.poll_message_set("The armature has no joint. It needs at least two bones")
            return False
        return True

    def run(self, context):
        rig = writable(rig_of_context(context))
        if not self.kinds:
            raise SinewError("No muscle is chosen. Choose at least one under Muscles")
        options = automatic.Options(self.kinds, self.along, self.gamma, self.shortest_bone, self.fit_skin)
        skinned = skinned_bones.skinned_bones(rig, characters.skins_of(rig))
        bones = self._bones(context, rig)
        shapes, joints = automatic.on_joints(rig, bones, skins_to_fit(rig), skinned, options)
        if not joints:
            raise SinewError(
                f"{rig.name}: no joint was found. A joint needs a bone and its parent, both longer than Shortest Bone"
            )
        edit.add(rig, shapes)
        return f"{len(shapes)} muscles added to {joints} joints of {rig.name}"

    def _bones(self, context, rig) -> set[str] | None:
        """The bones whose joints get muscles; None: all bones."""
        selected = {bone.name for bone in context.selected_pose_bones or () if bone.id_data == rig}
        if self.scope == "ALL" or (self.scope == "AUTO" and not selected):
            return None
        if not selected:
            raise SinewError("No bone is selected. Select the lower bone of each joint in Pose Mode")
        return selected
