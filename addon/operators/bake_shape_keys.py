# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.bake_shape_keys` bakes skins to keyed shape keys (docs/mathematics/baking.md, Reduction of frames)."""

from bpy.props import FloatProperty, StringProperty
from bpy.types import Operator

from ..bake.keys.shape_keys import Bake
from .base import skins_for_keys
from .frame_range import STEP, FrameRangeOperator


class SINEW_OT_bake_shape_keys(FrameRangeOperator, Operator):
    """Bake the live skin to shape keys, as few as the tolerance allows. They play, render and export without Sinew"""

    bl_idname, bl_label = "sinew.bake_shape_keys", "Bake to Shape Keys"
    needs_bound_skin = True

    step: STEP
    tolerance: FloatProperty(
        name="Tolerance",
        description=(
            "Largest error of the baked skin at any frame or half frame, in mm. A smaller tolerance makes more keys. "
            "0: one key per frame"
        ),
        default=0.1,
        min=0.0,
        soft_max=2.0,
        precision=3,
    )
    prefix: StringProperty(name="Prefix", description="Prefix of the names of the keys", default="sinew_")

    _bake = None

    def begin(self, context):
        skins = skins_for_keys(context)
        self._bake = Bake(skins, context.scene, self.frame_start, self.frame_end, self.step, self.prefix, self.tolerance)
        return self._bake.steps()

    def abandon(self):
        self._bake.cancel()

    def stop(self, _context):
        self._bake.cancel()
        if self._bake.is_baked:
            self.report({"INFO"}, f"{self._bake.keys} keys baked. The comparison with the live skin was canceled")
            return {"FINISHED"}
        self.report({"INFO"}, "Bake canceled. Nothing has changed")
        return {"CANCELLED"}

    def finish(self, _context):
        bake = self._bake
        if bake.muted_keys:
            self.report(
                {"WARNING"}, f"{bake.muted_keys} keys of other bakes are now muted, because they act in the same frames"
            )
        self.report(
            {"INFO"},
            f"{bake.keys} keys baked for {len(bake.frames)} frames. Maximum error: {bake.error_mm:.4f} mm at frames, "
            f"{bake.error_between_mm:.4f} mm between frames. Live is switched off, so that the keys play",
        )
        return {"FINISHED"}
