# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.bake_correctives` bakes skins to shape keys that joint angles drive (docs/mathematics/baking.md, Correctives).

    bpy.ops.sinew.bake_correctives(joints="upper_arm.L, forearm.L", angles="X -90..90 Z -45..120, 0..150", tolerance=0.5)

The operator bakes the bound meshes of the active armature, or the selected meshes, and switches Live off, so that the keys
act.

joints: the bones to rotate. Empty: the bones that `bones` selects.
angles: the range of rotation of each bone, or of all bones, in degrees from the rest pose, about the muscles' bending axis
or about the bone's X, Y (twist) and Z. Empty: from the bones' locks and limits; without those 150 for a hinge, -90..90
for any other joint, -60..60 for twist.

Each key is named "PREFIX BONE AXIS ANGLE" (a combination has two of those) and has one driver on its value: a simple
expression of TRANSFORMS variables that read a bone of the armature (LOCAL_SPACE, SWING_TWIST_Y). The names and
bones of the keys are in `mesh_object.sinew.skin.baked_keys` (name, joints), the report is in
`mesh_object.sinew.skin.corrective_summary`.
"""

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy.types import Operator

from ..bake.correctives.correctives import CorrectiveBake, Settings
from ..bake.correctives.turn_ranges import named_bones
from ..errors import SinewError
from ..scene import bone_geometry
from . import angle_table
from .base import rig_of_context, skins_for_keys
from .joint_choices import CROSSED, SELECTED
from .stepped import SteppedOperator

WIDTH_PX = 480  # of the dialog

BONES = (
    CROSSED,
    SELECTED,
    (
        "ALL",
        "All with an Effect",
        "Every joint whose rotation needs a correction above the tolerance, including fingers and toes",
    ),
)


def _joints_changed(operator, context):
    """Fills the table again for other joints. Only the dialog has a table."""
    if operator.ranges:
        operator.fill_table(context)


class SINEW_OT_bake_correctives(SteppedOperator, Operator):
    """Bake the live skin to corrective shape keys that joint angles drive. They work and export without Sinew"""

    bl_idname, bl_label = "sinew.bake_correctives", "Bake Correctives"
    needs_bound_skin = True

    bones: EnumProperty(
        name="Joints",
        description="The joints that get correctives",
        items=BONES,
        default="CROSSED",
        update=_joints_changed,
    )
    joints: StringProperty(name="Bones", description="Names of bones, separated by commas. Empty: the joints chosen above")
    angles: StringProperty(
        name="Angles",
        description=(
            "Range of rotation from the rest pose, in degrees: '0..150' about the muscles' bending axis, "
            "'X -20..150 Y -80..80' about the bone's local axes. One range for all joints, or one per joint, separated by "
            "commas. Empty: from the bones' locks and limits, or else by the kind of joint"
        ),
    )
    twists: BoolProperty(name="Twist", description="Also twist each joint, unless Angles sets its range", default=True)
    tolerance: FloatProperty(
        name="Tolerance",
        description="Largest error of the skin in any pose of a joint, in mm. A smaller tolerance makes more keys",
        default=0.5,
        min=0.001,
        soft_max=5.0,
        precision=3,
    )
    threshold: FloatProperty(
        name="Threshold",
        description="Displacements of a vertex up to this distance are left out of a key, in mm",
        default=0.002,
        min=0.0,
        soft_max=0.1,
        precision=4,
    )
    most_keys: IntProperty(
        name="Maximum Keys",
        description="Maximum number of keys per axis of a joint, even if the tolerance needs more. 0: no limit",
        default=16,
        min=0,
        soft_max=60,
    )
    combinations: IntProperty(
        name="Combinations",
        description="Maximum number of keys for two joints that rotate together, in each pair of directions. 0: none",
        default=4,
        min=0,
        max=16,
    )
    prefix: StringProperty(name="Prefix", description="Prefix of the names of the keys", default="sinew ")
    ranges: angle_table.table_property()
    row: angle_table.row_property()

    _bake = None

    def invoke(self, context, _event):
        self.in_window = True
        if not self.angles and not self.joints:
            self.fill_table(context)
        return context.window_manager.invoke_props_dialog(self, width=WIDTH_PX)

    def fill_table(self, context):
        """Fills the table with the rotations of the joints that `bones` chooses. ALL is known only after the bake began."""
        rig = rig_of_context(context)
        if self.bones == "ALL":
            self.ranges.clear()
            return
        bones = bone_geometry.selected_bones(rig) if self.bones == "SELECTED" else None
        angle_table.fill(self.ranges, rig, skins_for_keys(context), bones)

    def draw(self, _context):
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "bones")
        if self.ranges:
            angle_table.draw(layout, self)
        else:
            for name in ("joints", "angles", "twists"):
                layout.prop(self, name)
        for name in ("tolerance", "threshold", "most_keys", "combinations", "prefix"):
            layout.prop(self, name)

    def begin(self, context):
        rig = rig_of_context(context)
        skins = skins_for_keys(context)
        self._bake = CorrectiveBake(rig, skins, context.scene, self._settings(rig))
        return self._bake.steps()

    def abandon(self):
        self._bake.cancel()

    def finish(self, _context):
        bake = self._bake
        results = bake.results
        if bake.muted_keys:
            self.report(
                {"WARNING"},
                f"{bake.muted_keys} baked keys of frames are now muted, because they would add to the correctives",
            )
        at_poses = max(result.error_at_mm for result in results)
        alone, together = (
            max((result.error_between_mm for result in results if (len(result.turns) > 1) == several), default=0.0)
            for several in (False, True)
        )
        both = f", {together:.2f} mm with several rotations at once" if together else ""
        self.report(
            {"INFO"},
            f"{sum(result.keys for result in results)} correctives baked. Maximum error: {at_poses:.4f} mm at their poses, "
            f"{alone:.2f} mm between{both}. Live is switched off, so that they act",
        )
        return {"FINISHED"}

    def _settings(self, rig) -> Settings:
        joints = named_bones(rig, self.joints)
        angles = [text for text in self.angles.split(",") if text.strip()]
        if self.ranges and not joints and not angles:
            joints, angles = angle_table.read(self.ranges, rig)
        if not joints and self.bones == "SELECTED":
            joints = named_bones(rig, ",".join(bone_geometry.selected_bones(rig)))
            if not joints:
                raise SinewError("No bones are selected. Select bones in Pose Mode, or bake all joints that muscles cross")
        return Settings(
            joints=joints or None,
            all_joints=not joints and self.bones == "ALL",
            angles=angles,
            twists=self.twists,
            tolerance_mm=self.tolerance,
            threshold_mm=self.threshold,
            max_keys_per_turn=self.most_keys,
            max_keys_per_pair=self.combinations,
            prefix=self.prefix,
        )
