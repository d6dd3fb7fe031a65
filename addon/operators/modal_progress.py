# SPDX-License-Identifier: GPL-3.0-or-later
"""The timer and the progress cursor of an operator that works between the events of a window."""


class ModalProgress:
    """Starts on construction: the operator's `modal` then receives a TIMER event every `interval_s` seconds."""

    def __init__(self, operator, context, interval_s: float):
        manager = context.window_manager
        manager.progress_begin(0.0, 1.0)
        self._timer = manager.event_timer_add(interval_s, window=context.window)
        manager.modal_handler_add(operator)

    def show(self, context, fraction: float):
        """Shows the completed fraction, 0..1."""
        context.window_manager.progress_update(fraction)

    def end(self, context):
        """Removes timer and cursor."""
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
