# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.add_automatic`"""

from bpy.props import BoolProperty, EnumProperty, FloatProperty
from bpy.types import Operator

from ..errors import SinewError
from ..muscles import edit
from ..muscles.placing.fit import fit
from ..muscles.placing.fit.skin_surface import SkinSurface
from ..muscles.placing.place import automatic
from ..scene.linked_data import writable
from ..skin.main_skin import main_skin_of
from .base import SinewOperator, rig_of_context

SCOPES = (
    ("AUTO", "Automatic", "The selected bones in Pose Mode, else all"),
    ("SELECTED", "Selected Bones", "The joints of the selected bones with the bones above them"),
    ("ALL", "All Bones", "Every joint of the armature"),
)
KINDS = tuple((kind, kind.capitalize(), "") for kind in automatic.KINDS)


class SINEW_OT_add_automatic(SinewOperator, Operator):
    """Add four muscles to each joint, of the selected bones or of the whole armature: for a fish, a horse, a robot"""

    bl_idname, bl_label = "sinew.add_automatic", "Add Automatic Muscles"

    scope: EnumProperty(name="Joints", description="Which joints get muscles", items=SCOPES, default="AUTO")
    kinds: EnumProperty(
        name="Muscles",
        description="Which of a joint's four muscles to add",
        items=KINDS,
        options={"ENUM_FLAG"},
        default=set(automatic.KINDS),
    )
    along: FloatProperty(
        name="Along",
        description="Where a muscle is attached along its bones (Wilhelms: 10 %)",
        min=0.0,
        max=1.0,
        default=0.1,
        subtype="FACTOR",
    )
    gamma: FloatProperty(
        name="Gamma",
        description="Distance of the attachments from the bones, as a share of each bone's length",
        min=0.0,
        soft_max=0.5,
        default=0.12,
    )
    shortest_bone: FloatProperty(
        name="Shortest Bone",
        description="Bones shorter than this get no muscles; 0 chooses by the size of the armature",
        min=0.0,
        soft_max=0.2,
        subtype="DISTANCE",
    )
    fit_skin: BoolProperty(
        name="Fit under Skin", description="Size the muscles so that they lie under the mesh", default=True
    )

    @classmethod
    def poll(cls, context):
        if not super().poll(context):
            return False
        if context.object.type == "ARMATURE" and len(context.object.data.bones) < 2:
            cls.poll_message_set("The armature has no joint: it needs two bones")
            return False
        return True

    def run(self, context):
        rig = writable(rig_of_context(context))
        if not self.kinds:
            raise SinewError("None of the four muscles is chosen: choose at least one under Muscles")
        joints = automatic.joints(rig, self._bones(context, rig), self.shortest_bone)
        if not joints:
            raise SinewError(
                f"{rig.name}: no joint found: a joint is a bone with another above it, both longer than Shortest Bone"
            )
        shapes = [shape for joint in joints for shape in automatic.muscles(rig, joint, self.kinds, self.along, self.gamma)]
        skin = main_skin_of(rig)
        if skin and self.fit_skin:
            shapes = fit.fit_all(shapes, SkinSurface.of(skin, rig))
        edit.add(rig, shapes)
        return f"{len(shapes)} muscles added to {len(joints)} joints of {rig.name}"

    def _bones(self, context, rig) -> set[str] | None:
        """The bones whose joints are meant; None: all."""
        selected = {bone.name for bone in context.selected_pose_bones or () if bone.id_data == rig}
        if self.scope == "ALL" or (self.scope == "AUTO" and not selected):
            return None
        if not selected:
            raise SinewError("No bone is selected: in Pose Mode select the lower bone of each joint")
        return selected
