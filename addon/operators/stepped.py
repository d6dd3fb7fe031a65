# SPDX-License-Identifier: GPL-3.0-or-later
"""What long operators share: work in steps, with a progress bar and Esc in a window, at once from a script."""

import time

from ..errors import SinewError
from .base import SinewOperator

WORK_BETWEEN_EVENTS_S = 0.1


class SteppedOperator(SinewOperator):
    """Mix-in for an operator that has:

    begin(context): checks what was asked for and returns an iterator that does the work, yielding the part done, 0..1.
    Raises SinewError, and then nothing has been changed.
    finish(context): what is done when the work is; returns the operator's result.

    and that may have other ways than these of its own:

    abandon(): puts everything back as it was before, by default as the iterator does when it is closed.
    stop(context): Esc; by default all is abandoned. Returns the operator's result.

    Asked for by a person, it shows its properties first, and then works in the window.
    """

    work_name = "Bake"  # what is told to be cancelled
    in_window = False
    _steps = _timer = None

    def invoke(self, context, _event):
        self.in_window = True
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context):
        try:
            self._steps = self.begin(context)
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if not self.in_window:
            return self._work(context, seconds=float("inf"))
        manager = context.window_manager
        manager.progress_begin(0.0, 1.0)
        self._timer = manager.event_timer_add(0.01, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self._end_progress(context)
            return self.stop(context)
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        return self._work(context, WORK_BETWEEN_EVENTS_S)

    def abandon(self):
        self._steps.close()

    def stop(self, _context):
        self.abandon()
        self.report({"INFO"}, f"{self.work_name} cancelled; nothing has changed")
        return {"CANCELLED"}

    def _work(self, context, seconds: float):
        until = time.perf_counter() + seconds
        try:
            for done in self._steps:
                if self._timer:
                    context.window_manager.progress_update(done)
                if time.perf_counter() > until:
                    return {"RUNNING_MODAL"}
            self._end_progress(context)
            return self.finish(context)
        except SinewError as error:
            self._end_progress(context)
            self.abandon()
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        except Exception:
            self._end_progress(context)
            self.abandon()
            raise

    def _end_progress(self, context):
        if self._timer:
            context.window_manager.event_timer_remove(self._timer)
            context.window_manager.progress_end()
            self._timer = None
