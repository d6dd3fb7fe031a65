# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.bake_reach`"""

import time

from bpy.props import BoolProperty, FloatProperty, IntProperty
from bpy.types import Operator

from ..errors import SinewError
from ..reaching.clip import ClipBake
from .base import SinewOperator, rig_of_context, writable

WORK_BETWEEN_EVENTS_S = 0.1


class SINEW_OT_bake_reach(SinewOperator, Operator):
    """Key the bones that reach for this armature's goals in a range of frames, smoothly from frame to frame"""

    bl_idname, bl_label = "sinew.bake_reach", "Bake Reach"

    frame_start: IntProperty(name="First Frame", default=1)
    frame_end: IntProperty(name="Last Frame", default=250)
    smoothness: FloatProperty(
        name="Smoothness",
        description="How much sudden changes of the joints count against the goals; 0: each frame by itself",
        default=0.01,
        min=0.0,
        soft_max=1.0,
        precision=3,
    )
    preference: FloatProperty(
        name="Preference",
        description="How much the pose that is keyed already counts against the goals",
        default=1e-3,
        min=0.0,
        soft_max=0.1,
        precision=4,
    )
    pin_feet: BoolProperty(
        name="Pin Feet", description="Keep both feet in the world where they are in the first frame, while the body moves"
    )

    _bake = _steps = _timer = None
    _in_window = False

    def invoke(self, context, _event):
        self.frame_start, self.frame_end = context.scene.frame_start, context.scene.frame_end
        self._in_window = True
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context):
        try:
            self._bake = ClipBake(
                writable(rig_of_context(context)),
                context.scene,
                range(self.frame_start, self.frame_end + 1),
                smoothness=self.smoothness,
                preference=self.preference,
                pin_feet=self.pin_feet,
            )
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._steps = self._bake.steps()
        if not self._in_window:
            return self._work(context, seconds=float("inf"))
        context.window_manager.progress_begin(0.0, 1.0)
        self._timer = context.window_manager.event_timer_add(0.01, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self._bake.cancel()
            self._end(context)
            self.report({"INFO"}, "Bake cancelled; nothing has changed")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        return self._work(context, WORK_BETWEEN_EVENTS_S)

    def _work(self, context, seconds: float):
        until = time.perf_counter() + seconds
        try:
            for done in self._steps:
                if self._timer:
                    context.window_manager.progress_update(done)
                if done < 1.0 and time.perf_counter() > until:
                    return {"RUNNING_MODAL"}
        except SinewError as error:
            self._bake.cancel()
            self._end(context)
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._end(context)
        bake = self._bake
        self.report(
            {"INFO"},
            f"{len(bake.bones)} bones keyed in {len(bake.frames)} frames; positions are missed by {bake.worst_mm:.2f} mm at most",
        )
        return {"FINISHED"}

    def _end(self, context):
        if self._timer:
            context.window_manager.event_timer_remove(self._timer)
            context.window_manager.progress_end()
            self._timer = None
