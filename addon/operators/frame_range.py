# SPDX-License-Identifier: GPL-3.0-or-later
"""What long operators over a range of frames share: its ends, which are the scene's where a person asks."""

from bpy.props import IntProperty

from .stepped import SteppedOperator


class FrameRangeOperator(SteppedOperator):
    """Mix-in: a stepped operator that works on the frames from `frame_start` to `frame_end`, both included."""

    frame_start: IntProperty(name="First Frame", default=1)
    frame_end: IntProperty(name="Last Frame", default=250)

    def invoke(self, context, event):
        self.frame_start, self.frame_end = context.scene.frame_start, context.scene.frame_end
        return super().invoke(context, event)
