# SPDX-License-Identifier: GPL-3.0-or-later
"""What long operators on a range of frames share: in a window they work between events, with a progress bar, and Esc stops them."""

import time

from ..errors import SinewError
from .base import SinewOperator

WORK_BETWEEN_EVENTS_S = 0.1


class StepwiseOperator(SinewOperator):
    """Mix-in: `begin` returns the work, an object with `steps()`, a generator of shares done 0..1, and `cancel()`.

    `finished` reports the end; `stopped` the end by Esc, after `cancel`. A SinewError of `begin` or of a step becomes the error
    report. The operator has the properties `frame_start` and `frame_end`.
    """

    _job = _steps = _timer = None
    _in_window = False

    def invoke(self, context, _event):
        self.frame_start, self.frame_end = context.scene.frame_start, context.scene.frame_end
        self._in_window = True
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context):
        try:
            self._job = self.begin(context)
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._steps = self._job.steps()
        if not self._in_window:
            return self._work(context, seconds=float("inf"))
        manager = context.window_manager
        manager.progress_begin(0.0, 1.0)
        self._timer = manager.event_timer_add(0.01, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self._job.cancel()
            self._end(context)
            return self.stopped(self._job)
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        return self._work(context, WORK_BETWEEN_EVENTS_S)

    def stopped(self, _job):
        """Reports that Esc stopped the work; returns what the operator ends with."""
        self.report({"INFO"}, "Bake cancelled; nothing has changed")
        return {"CANCELLED"}

    def _work(self, context, seconds: float):
        until = time.perf_counter() + seconds
        try:
            for done in self._steps:
                if self._timer:
                    context.window_manager.progress_update(done)
                if time.perf_counter() > until:
                    return {"RUNNING_MODAL"}
        except SinewError as error:
            self._job.cancel()
            self._end(context)
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._end(context)
        self.finished(self._job)
        return {"FINISHED"}

    def _end(self, context):
        if self._timer:
            context.window_manager.event_timer_remove(self._timer)
            context.window_manager.progress_end()
            self._timer = None
