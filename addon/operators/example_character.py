# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.example_character` makes a human from nothing: a skeleton, its muscles, and a skin grown over them."""

import bpy
from bpy.types import Operator

from ..errors import SinewError
from ..muscles.placing.place import example_skeleton
from ..scene import selection
from .base import Translated, show_changed

# as in the demo of a grown human: without a mesh to fit under, the muscles are slim and the skin is thick
GROWTH = {"resolution": 100, "thickness": 0.008, "smoothing": 8, "unwrap": False}


class SINEW_OT_example_character(Translated, Operator):
    """Make a human with muscles and a bound skin from nothing, to try Sinew without a character of your own"""

    bl_idname, bl_label, bl_options = "sinew.example_character", "Example Character", {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if context.mode != "OBJECT":
            cls.poll_message_set("Leave Edit Mode first (Tab). The example is made in Object Mode")
            return False
        return True

    def execute(self, context):
        rig = example_skeleton.create(context)
        try:
            bpy.ops.sinew.add_preset(name="human")
            selection.make_active(rig)
            bpy.ops.sinew.grow_skin(**GROWTH)
        except (RuntimeError, SinewError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        selection.make_active(rig)
        show_changed(rig, context, is_first=False)
        self.report({"INFO"}, "Example character made. Enter Pose Mode and bend an arm, or add the Range of Motion")
        return {"FINISHED"}
