# SPDX-License-Identifier: GPL-3.0-or-later
"""Base class of long operators: in a window they work in steps with progress and Esc, in a script without interruption."""

import logging
import time

from ..errors import SinewError
from .base import SinewOperator, require_numbers
from .modal_progress import ModalProgress

TIMER_INTERVAL_S = 0.01
WORK_BETWEEN_EVENTS_S = 0.1


class SteppedOperator(SinewOperator):
    """Mix-in for an operator that implements:

    begin(context): checks the properties and returns an iterator that does the work and yields the completed fraction,
    0..1. Raises SinewError, and then nothing has changed.
    finish(context): runs after the work and returns the operator's result.

    It can override:

    abandon(): restores the state before `begin`. By default it closes the iterator, which restores the state.
    stop(context): handles Esc and returns the operator's result. By default it abandons the work.

    From the user interface, the operator first shows a dialog with its properties and then works in the window. Adjust Last
    Operation (F9) runs it again without interruption.
    """

    work_name = "Bake"  # for the report after Esc
    activity = "Baking"  # for the status bar
    in_window = False
    _steps = _progress = None

    def invoke(self, context, _event):
        self.in_window = True
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context):
        # Adjust Last Operation (F9) calls this again, on the same operator
        works_in_window, self.in_window = self.in_window, False
        try:
            require_numbers(self)
            self._steps = self.begin(context)
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if not works_in_window:
            return self._work(context, seconds=float("inf"))
        self._progress = ModalProgress(self, context, TIMER_INTERVAL_S, self.activity)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self._end_progress(context)
            return self.stop(context)
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        return self._work(context, WORK_BETWEEN_EVENTS_S)

    def cancel(self, context):
        """Blender calls this when the window closes, and when the user cancels the dialog."""
        self._end_progress(context)
        if self._steps is not None:
            self._try_to_abandon()

    def abandon(self):
        self._steps.close()

    def stop(self, _context):
        self.abandon()
        self.report({"INFO"}, f"{self.work_name} canceled. Nothing has changed")
        return {"CANCELLED"}

    def _work(self, context, seconds: float):
        until = time.perf_counter() + seconds
        try:
            for fraction in self._steps:
                if self._progress:
                    self._progress.show(context, fraction)
                if time.perf_counter() > until:
                    return {"RUNNING_MODAL"}
            self._end_progress(context)
            return self.finish(context)
        except (SinewError, ReferenceError) as error:
            self._end_progress(context)
            self._try_to_abandon()
            is_deleted = isinstance(error, ReferenceError)
            self.report({"ERROR"}, "Data was deleted meanwhile. Start again" if is_deleted else str(error))
            return {"CANCELLED"}
        except Exception:
            self._end_progress(context)
            self._try_to_abandon()
            raise

    def _try_to_abandon(self):
        """Abandons the work. An error in that is logged, so that it does not hide why the work ended."""
        try:
            self.abandon()
        except Exception:
            logging.getLogger("sinew").exception("%s: the state before could not be restored", self.bl_label)
            self.report({"WARNING"}, "Not everything could be restored. The system console shows why")

    def _end_progress(self, context):
        if self._progress:
            self._progress.end(context)
            self._progress = None
