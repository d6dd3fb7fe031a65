# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.bake_correctives`

    bpy.ops.sinew.bake_correctives(joints="upper_arm.L, forearm.L", angles="X -90..90 Z -45..120, 0..150", tolerance=0.5)

bakes the bound meshes of the active armature, or the selected ones, and switches Live off, so that the keys act. joints: the
bones that turn; empty: those of `bones`. angles: how far each turns, or all do, in degrees from the rest pose, about the axis
that muscles bend it about or about its own X, Y (twist) and Z; empty: from the bones' locks and limits, else 150 for a hinge, 90
both ways for another joint, 60 both ways of twist.

Each key, "PREFIX BONE AXIS ANGLE" or two of those, has one driver on its value: a simple expression over TRANSFORMS variables
that read a bone of the armature (LOCAL_SPACE, SWING_TWIST_Y). The keys' names and bones stand in `mesh_object.sinew.baked_keys`
(name, joints), the report in `mesh_object.sinew.corrective_summary`.
"""

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy.types import Operator

from ..bake.correctives.correctives import CorrectiveBake, Settings
from ..bake.correctives.turn_ranges import named_bones
from ..errors import SinewError
from ..scene import bone_geometry
from .base import rig_of_context, skins_to_give_keys
from .stepped import SteppedOperator

BONES = (
    ("CROSSED", "All that Muscles Cross", "The joint at the head of each bone that a muscle pulls against its parent"),
    ("SELECTED", "Selected Bones", "The joints at the heads of the bones that are selected in Pose Mode"),
    (
        "ALL",
        "All with an Effect",
        "Every joint whose turn gives the skin a correction above the tolerance: fingers and toes, too",
    ),
)


class SINEW_OT_bake_correctives(SteppedOperator, Operator):
    """Bake the live skin to corrective shape keys that the bones' angles drive, which pose, play and export without Sinew"""

    bl_idname, bl_label = "sinew.bake_correctives", "Bake Correctives"

    bones: EnumProperty(name="Joints", items=BONES, default="CROSSED")
    joints: StringProperty(
        name="Bones", description="Names of bones with commas between, instead; empty: the joints chosen above"
    )
    angles: StringProperty(
        name="Angles",
        description=(
            "How far the joints turn from the rest pose, in degrees: '0..150' about the axis that muscles bend, "
            "'X -20..150 Y -80..80' about the bone's own; one such text for all joints, or one for each with commas "
            "between. Empty: from the bones' "
            "locks and limits, else by the kind of joint"
        ),
    )
    twists: BoolProperty(name="Twist", description="Also twist each joint, where Angles does not say", default=True)
    tolerance: FloatProperty(
        name="Tolerance",
        description="How far the skin may be from the live one in any pose of a joint, mm: less makes more keys",
        default=0.5,
        min=0.001,
        soft_max=5.0,
        precision=3,
    )
    threshold: FloatProperty(
        name="Threshold",
        description="Movements of a vertex up to this are left out of a key, mm",
        default=0.002,
        min=0.0,
        soft_max=0.1,
        precision=4,
    )
    most_keys: IntProperty(
        name="Most Keys",
        description="Keys at most for each axis that a joint turns about, even where the tolerance needs more; 0: no limit",
        default=16,
        min=0,
        soft_max=60,
    )
    combinations: IntProperty(
        name="Combinations",
        description="Keys at most for two joints that turn at once, for each of the four ways they can; 0: each joint alone",
        default=4,
        min=0,
        max=16,
    )
    prefix: StringProperty(name="Prefix", description="The keys' names begin with this", default="sinew ")

    _bake = None

    def begin(self, context):
        rig = rig_of_context(context)
        skins = skins_to_give_keys(context)
        self._bake = CorrectiveBake(rig, skins, context.scene, self._settings(rig))
        return self._bake.steps()

    def abandon(self):
        self._bake.cancel()

    def finish(self, _context):
        bake = self._bake
        found = bake.results
        if bake.silenced:
            self.report(
                {"WARNING"}, f"{bake.silenced} baked keys of frames would add to the correctives: they are muted now"
            )
        at = max(one.error_at_mm for one in found)
        alone, together = (
            max((one.error_between_mm for one in found if len(one.turns) == count), default=0.0) for count in (1, 2)
        )
        both = f", {together:.2f} mm where two turn at once" if together else ""
        self.report(
            {"INFO"},
            f"{sum(one.keys for one in found)} correctives baked; from live at most {at:.4f} mm at their poses, "
            f"{alone:.2f} mm between{both}. Live is off now, so that they act",
        )
        return {"FINISHED"}

    def _settings(self, rig) -> Settings:
        joints = named_bones(rig, self.joints)
        if not joints and self.bones == "SELECTED":
            joints = named_bones(rig, ",".join(bone_geometry.selected_bones(rig)))
            if not joints:
                raise SinewError("No bones are selected: select some in Pose Mode, or bake all joints that muscles cross")
        return Settings(
            joints=joints or None,
            all_joints=not joints and self.bones == "ALL",
            angles=[told for told in self.angles.split(",") if told.strip()],
            twists=self.twists,
            tolerance_mm=self.tolerance,
            threshold_mm=self.threshold,
            max_keys_per_turn=self.most_keys,
            max_keys_per_pair=self.combinations,
            prefix=self.prefix,
        )
