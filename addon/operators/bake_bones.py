# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.bake_bones` makes an export copy with a bone for each muscle (docs/mathematics/baking.md, Muscle bones).

    bpy.ops.sinew.bake_bones(frame_start=1, frame_end=48, influences="4", keyed=False, weights="FITTED")

The operator copies the active armature and its bound meshes, or the selected meshes, to the collection "RIG Export". Each
muscle is a deform bone of the copy ("muscle NAME"). The character is not changed. A new bake replaces the collection, and
`sinew.remove` removes it. Baked keys are copied, refitted to the weights of the copy, and driven by the copy's bones.
"""

from bpy.props import BoolProperty, EnumProperty
from bpy.types import Operator

from ..export.bone_bake import BoneBake, Settings
from .base import rig_of_context, skins_to_bake
from .frame_range import STEP, FrameRangeOperator

INFLUENCES = (
    ("4", "4", "Supported by mobile devices and by most glTF viewers"),
    ("8", "8", "Supported by Unreal and Unity"),
)
WEIGHTS = (
    ("FITTED", "Fitted to Frames", "Weights that come closest to the live skin in the frames"),
    ("BIND", "As Bound", "The influence of each muscle from the bind of the skin"),
)


class SINEW_OT_bake_bones(FrameRangeOperator, Operator):
    """Copy the armature and its meshes for export. Each muscle becomes a bone that stretches and bulges without Sinew"""

    bl_idname, bl_label = "sinew.bake_bones", "Bake Muscle Bones"
    needs_bound_skin = True

    step: STEP
    influences: EnumProperty(
        name="Influences", description="Maximum number of bones per vertex", items=INFLUENCES, default="4"
    )
    weights: EnumProperty(
        name="Weights", description="How to compute the weights of the muscle bones", items=WEIGHTS, default="FITTED"
    )
    keyed: BoolProperty(
        name="Keys Only",
        description=(
            "Key location, rotation and scale of the muscle bones in each frame. Off: constraints stretch them in any pose, "
            "and only curved muscles are keyed"
        ),
        default=False,
    )

    _bake = None

    def begin(self, context):
        rig = rig_of_context(context)
        skins = skins_to_bake(context)
        settings = Settings(self.frame_start, self.frame_end, self.step, int(self.influences), self.keyed, self.weights)
        self._bake = BoneBake(context, rig, skins, settings)
        return self._bake.steps()

    def finish(self, _context):
        bake = self._bake
        if bake.unfit:
            self.report({"WARNING"}, f"These keys do not fit the copy and are muted there: {', '.join(bake.unfit)}")
        keyed, error = sum(muscle.is_keyed for muscle in bake.muscles), bake.difference
        self.report(
            {"INFO"},
            f"{keyed} of {len(bake.muscles)} muscle bones are keyed. The copy is hidden in this view layer. Error of the "
            f"Armature modifier alone: mean {error.bare_mean_mm:.3f} mm, max {error.bare_max_mm:.2f} mm",
        )
        self.report(
            {"INFO"},
            f"{len(bake.muscles)} muscle bones in '{bake.rig} Export'. "
            f"Error: mean {error.mean_mm:.3f} mm, max {error.max_mm:.2f} mm",
        )
        return {"FINISHED"}
