# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.remove_via_points` removes via points of a muscle."""

import bpy
from bpy.types import Operator

from ..errors import SinewError
from ..muscles import muscle_path
from ..scene import characters, tissue_empty
from .base import MuscleOperator


class SINEW_OT_remove_via_points(MuscleOperator, Operator):
    """Remove the selected via points, or all via points of the active muscle if none is selected"""

    bl_idname, bl_label = "sinew.remove_via_points", "Remove Via Points"

    def run(self, context):
        muscle = muscle_path.muscle_of(context.object)
        vias = [empty for empty in context.selected_objects if tissue_empty.is_via(empty)] or tissue_empty.vias_of(muscle)
        if not vias:
            raise SinewError(f"{muscle.name} has no via points")
        for via in vias:
            bpy.data.objects.remove(via)
        if context.view_layer.objects.get(muscle.name) == muscle:  # the muscles' collection may be excluded
            context.view_layer.objects.active = muscle
        characters.forget()
        muscle.update_tag()
        return f"{len(vias)} via points removed from {muscle.name}"
