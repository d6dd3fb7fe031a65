# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.bake_shape_keys`"""

import time

from bpy.props import IntProperty, StringProperty
from bpy.types import Operator

from .. import mesh_io
from ..bake.shape_keys import Bake
from ..errors import SinewError
from .base import SinewOperator, skins_of_context

WORK_BETWEEN_EVENTS_S = 0.1


class SINEW_OT_bake_shape_keys(SinewOperator, Operator):
    """Bake the live skin to one shape key a frame, which plays, renders and exports without Sinew"""

    bl_idname, bl_label = "sinew.bake_shape_keys", "Bake to Shape Keys"

    frame_start: IntProperty(name="First Frame", default=1)
    frame_end: IntProperty(name="Last Frame", default=250)
    step: IntProperty(name="Step", description="Bake every frame (1), every second (2), ...", default=1, min=1)
    prefix: StringProperty(name="Prefix", description="The keys' names begin with this", default="sinew_")

    _bake = _steps = _timer = None
    _in_window = False

    def invoke(self, context, _event):
        self.frame_start, self.frame_end = context.scene.frame_start, context.scene.frame_end
        self._in_window = True
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context):
        try:
            self._bake = self._begin(context)
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._steps = self._bake.steps()
        if not self._in_window:
            return self._work(context, seconds=float("inf"))
        manager = context.window_manager
        manager.progress_begin(0.0, 1.0)
        self._timer = manager.event_timer_add(0.01, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self._bake.cancel()
            self._end(context)
            if self._bake.is_baked:
                self.report({"INFO"}, f"{len(self._bake.frames)} keys baked; comparing them with the live skin was stopped")
                return {"FINISHED"}
            self.report({"INFO"}, "Bake cancelled; nothing has changed")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        return self._work(context, WORK_BETWEEN_EVENTS_S)

    def _begin(self, context) -> Bake:
        skins = skins_of_context(context)
        if context.object.type != "MESH":
            skins = [skin for skin in skins if mesh_io.is_bound(skin)] or skins
        return Bake(skins, context.scene, self.frame_start, self.frame_end, self.step, self.prefix)

    def _work(self, context, seconds: float):
        until = time.perf_counter() + seconds
        try:
            for done in self._steps:
                if self._timer:
                    context.window_manager.progress_update(done)
                if time.perf_counter() > until:
                    return {"RUNNING_MODAL"}
        except SinewError as error:
            self._bake.cancel()
            self._end(context)
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._end(context)
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

    def _end(self, context):
        if self._timer:
            context.window_manager.event_timer_remove(self._timer)
            context.window_manager.progress_end()
            self._timer = None
