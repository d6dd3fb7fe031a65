# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.bake_reach` keys the bones that reach for goals over a range of frames (docs/mathematics/reach.md)."""

from bpy.props import BoolProperty, FloatProperty
from bpy.types import Operator

from ..reach.reach_bake import ReachBake
from ..scene.linked_data import writable
from .base import rig_of_context
from .frame_range import FrameRangeOperator


class SINEW_OT_bake_reach(FrameRangeOperator, Operator):
    """Key the bones that reach for the goals of this armature, in a range of frames and smoothly from frame to frame"""

    bl_idname, bl_label = "sinew.bake_reach", "Bake Reach"

    smoothness: FloatProperty(
        name="Smoothness",
        description="Weight of a smooth motion against the goals. 0: each frame is solved by itself",
        default=0.01,
        min=0.0,
        soft_max=1.0,
        precision=3,
    )
    preference: FloatProperty(
        name="Preference",
        description="Weight of the existing pose against the goals",
        default=1e-3,
        min=0.0,
        soft_max=0.1,
        precision=4,
    )
    pin_feet: BoolProperty(
        name="Pin Feet", description="Keep both feet at their world positions of the first frame while the body moves"
    )

    _bake = None

    def begin(self, context):
        self._bake = ReachBake(
            writable(rig_of_context(context)),
            context.scene,
            range(self.frame_start, self.frame_end + 1),
            smoothness=self.smoothness,
            preference=self.preference,
            pin_feet=self.pin_feet,
        )
        return self._bake.steps()

    def abandon(self):
        self._bake.cancel()

    def finish(self, _context):
        bake = self._bake
        self.report(
            {"INFO"},
            f"{len(bake.bones)} bones keyed in {len(bake.frames)} frames, at most {bake.worst_mm:.2f} mm from their goals",
        )
        return {"FINISHED"}
