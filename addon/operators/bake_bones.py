# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.bake_bones`

    bpy.ops.sinew.bake_bones(frame_start=1, frame_end=48, influences="4", keyed=False, weights="FITTED")

makes, from the active armature and its bound meshes, or the selected ones, the collection "RIG Export": copies of armature and
meshes in which each muscle is a deform bone ("muscle NAME"). The character stays as it is. A new bake replaces the collection,
`sinew.remove` takes it away. Baked keys come along, made to fit the copy's weights, with their drivers on the copy's bones.
"""

from bpy.props import BoolProperty, EnumProperty, IntProperty
from bpy.types import Operator

from ..export.bone_bake import BoneBake, Settings
from .base import rig_of_context, skins_to_bake
from .frame_range import FrameRangeOperator

INFLUENCES = (
    ("4", "4", "As phones and most of glTF's players skin"),
    ("8", "8", "As Unreal and Unity can skin"),
)
WEIGHTS = (
    ("FITTED", "Fitted to Frames", "Those that come nearest to the live skin in the frames"),
    ("BIND", "As Bound", "Each muscle weighs the skin as strongly as it is bound to it"),
)


class SINEW_OT_bake_bones(FrameRangeOperator, Operator):
    """Copy armature and meshes for export, with a bone for each muscle that stretches and bulges as it does, without Sinew"""

    bl_idname, bl_label = "sinew.bake_bones", "Bake Muscle Bones"

    step: IntProperty(name="Step", description="Look at every frame (1), every second (2), ...", default=1, min=1)
    influences: EnumProperty(
        name="Influences", description="How many bones may weigh a vertex", items=INFLUENCES, default="4"
    )
    weights: EnumProperty(name="Weights", description="How strongly muscle bones weigh", items=WEIGHTS, default="FITTED")
    keyed: BoolProperty(
        name="Keys Only",
        description=(
            "Key the muscle bones' location, rotation and scale at each frame; off: constraints stretch them in any pose, "
            "and only curved muscles are keyed"
        ),
        default=False,
    )

    _bake = None

    def begin(self, context):
        rig = rig_of_context(context)
        skins = skins_to_bake(context)
        asked = Settings(self.frame_start, self.frame_end, self.step, int(self.influences), self.keyed, self.weights)
        self._bake = BoneBake(context, rig, skins, asked)
        return self._bake.steps()

    def finish(self, _context):
        bake = self._bake
        if bake.unfit:
            self.report({"WARNING"}, f"Muted on the copy, because they can't be fitted to it: {', '.join(bake.unfit)}")
        keyed, error = sum(muscle.is_keyed for muscle in bake.muscles), bake.difference
        self.report(
            {"INFO"},
            f"{len(bake.muscles)} muscle bones, {keyed} keyed, in '{bake.rig} Export' (hidden in this view layer). "
            f"Error: mean {error.mean_mm:.3f} mm, max {error.max_mm:.2f} mm "
            f"(Armature modifier alone: mean {error.bare_mean_mm:.3f} mm, max {error.bare_max_mm:.2f} mm)",
        )
        return {"FINISHED"}
