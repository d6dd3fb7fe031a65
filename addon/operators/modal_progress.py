# SPDX-License-Identifier: GPL-3.0-or-later
"""The timer, the progress cursor and the status text of an operator that works between the events of a window."""

from ..languages.messages import translated


class ModalProgress:
    """Starts on construction: the operator's `modal` then receives a TIMER event every `interval_s` seconds.

    activity: what the operator does, for the status bar, as in "Baking".
    """

    def __init__(self, operator, context, interval_s: float, activity: str):
        manager = context.window_manager
        self._activity = activity
        manager.progress_begin(0.0, 1.0)
        self._timer = manager.event_timer_add(interval_s, window=context.window)
        manager.modal_handler_add(operator)
        self.show(context, 0.0)

    def show(self, context, fraction: float):
        """Shows the completed fraction, 0..1."""
        context.window_manager.progress_update(fraction)
        _set_status(context, f"{self._activity} {100.0 * fraction:.0f} % - Esc cancels")

    def end(self, context):
        """Removes timer, cursor and status text."""
        _set_status(context, None)
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()


def _set_status(context, text: str | None):
    if context.workspace:  # a window that closes may have none
        context.workspace.status_text_set(text and translated(text))
