# SPDX-License-Identifier: GPL-3.0-or-later
"""Frame range that long operators share. In a dialog it starts as the range of the scene."""

from bpy.props import IntProperty

from .stepped import SteppedOperator

STEP = IntProperty(name="Step", description="Use every frame (1), every second frame (2), and so on", default=1, min=1)


class FrameRangeOperator(SteppedOperator):
    """Mix-in for a stepped operator over the frames from `frame_start` to `frame_end`, both included."""

    frame_start: IntProperty(name="First Frame", description="First frame of the range", default=1)
    frame_end: IntProperty(name="Last Frame", description="Last frame of the range (included)", default=250)

    def invoke(self, context, event):
        self.frame_start, self.frame_end = context.scene.frame_start, context.scene.frame_end
        return super().invoke(context, event)
