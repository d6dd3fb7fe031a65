# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.bake_shape_keys`"""

from bpy.props import IntProperty, StringProperty
from bpy.types import Operator

from .. import mesh_io
from ..bake.shape_keys import Bake
from ..errors import SinewError
from .base import skins_of_context
from .stepped import SteppedOperator


class SINEW_OT_bake_shape_keys(SteppedOperator, Operator):
    """Bake the live skin to one shape key a frame, which plays, renders and exports without Sinew"""

    bl_idname, bl_label = "sinew.bake_shape_keys", "Bake to Shape Keys"

    frame_start: IntProperty(name="First Frame", default=1)
    frame_end: IntProperty(name="Last Frame", default=250)
    step: IntProperty(name="Step", description="Bake every frame (1), every second (2), ...", default=1, min=1)
    prefix: StringProperty(name="Prefix", description="The keys' names begin with this", default="sinew_")

    _bake = None

    def invoke(self, context, _event):
        self.frame_start, self.frame_end = context.scene.frame_start, context.scene.frame_end
        self.in_window = True
        return context.window_manager.invoke_props_dialog(self)

    def begin(self, context):
        skins = skins_of_context(context)
        if context.object.type != "MESH":
            skins = [skin for skin in skins if mesh_io.is_bound(skin)] or skins
        playing = [skin.name for skin in skins if mesh_io.is_bound(skin) and mesh_io.cache_modifier_of(skin)]
        if playing:
            raise SinewError(f"{playing[0]} plays a point cache, which would hide the keys: remove its modifier first")
        self._bake = Bake(skins, context.scene, self.frame_start, self.frame_end, self.step, self.prefix)
        return self._bake.steps()

    def abandon(self):
        self._bake.cancel()

    def stop(self, _context):
        self._bake.cancel()
        if self._bake.is_baked:
            self.report({"INFO"}, f"{len(self._bake.frames)} keys baked; comparing them with the live skin was stopped")
            return {"FINISHED"}
        self.report({"INFO"}, "Bake cancelled; nothing has changed")
        return {"CANCELLED"}

    def finish(self, _context):
        bake = self._bake
        between = f", {bake.error_between_mm:.4f} mm between them" if bake.frames.step > 1 else ""
        if bake.silenced:
            self.report({"WARNING"}, f"{bake.silenced} keys of bakes with other prefixes act at these frames: they are muted now")
        self.report(
            {"INFO"},
            f"{len(bake.frames)} keys baked; live and baked differ by {bake.error_mm:.4f} mm at most{between}. "
            "Live is off now, so that the keys play",
        )
        return {"FINISHED"}
