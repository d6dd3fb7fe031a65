# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.bake_shape_keys`"""

from bpy.props import FloatProperty, IntProperty, StringProperty
from bpy.types import Operator

from ..bake.keys.shape_keys import Bake
from .base import skins_to_give_keys
from .frame_range import FrameRangeOperator


class SINEW_OT_bake_shape_keys(FrameRangeOperator, Operator):
    """Bake the live skin to shape keys of those frames that it needs, which play, render and export without Sinew"""

    bl_idname, bl_label = "sinew.bake_shape_keys", "Bake to Shape Keys"

    step: IntProperty(name="Step", description="Bake every frame (1), every second (2), ...", default=1, min=1)
    tolerance: FloatProperty(
        name="Tolerance",
        description=(
            "How far the baked skin may be from the live one at any frame or half frame, mm: less makes more keys. "
            "0: a key for each frame"
        ),
        default=0.1,
        min=0.0,
        soft_max=2.0,
        precision=3,
    )
    prefix: StringProperty(name="Prefix", description="The keys' names begin with this", default="sinew_")

    _bake = None

    def begin(self, context):
        skins = skins_to_give_keys(context)
        self._bake = Bake(skins, context.scene, self.frame_start, self.frame_end, self.step, self.prefix, self.tolerance)
        return self._bake.steps()

    def abandon(self):
        self._bake.cancel()

    def stop(self, _context):
        self._bake.cancel()
        if self._bake.is_baked:
            self.report({"INFO"}, f"{self._bake.keys} keys baked; comparing them with the live skin was stopped")
            return {"FINISHED"}
        self.report({"INFO"}, "Bake cancelled; nothing has changed")
        return {"CANCELLED"}

    def finish(self, _context):
        bake = self._bake
        if bake.silenced:
            self.report(
                {"WARNING"}, f"{bake.silenced} keys of bakes with other prefixes act at these frames: they are muted now"
            )
        self.report(
            {"INFO"},
            f"{bake.keys} keys baked for {len(bake.frames)} frames; live and baked differ by {bake.error_mm:.4f} mm at most, "
            f"{bake.error_between_mm:.4f} mm between frames. Live is off now, so that the keys play",
        )
        return {"FINISHED"}
