# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.add_via_point` adds a via point to a muscle."""

from bpy.props import FloatProperty, StringProperty
from bpy.types import Operator

from ..muscles import muscle_path
from .base import MuscleOperator, writable_muscle


class SINEW_OT_add_via_point(MuscleOperator, Operator):
    """Add a point that the path of the active muscle passes through. Move its Empty in the rest pose to shape the path"""

    bl_idname, bl_label = "sinew.add_via_point", "Add Via Point"

    share: FloatProperty(
        name="Along",
        description="Position along the muscle path: 0 is the origin, 1 is the insertion",
        min=0.0,
        max=1.0,
        default=0.5,
        subtype="FACTOR",
    )
    bone: StringProperty(
        name="Bone", description="The bone that carries the point. Empty: the nearest bone between origin and insertion"
    )

    def run(self, context):
        muscle = writable_muscle(context)
        via = muscle_path.add_via_point(muscle, self.share, self.bone)
        if context.view_layer.objects.get(via.name) == via:  # the muscles' collection may be excluded
            via.select_set(True)
        return f"{via.name} added on {via.parent_bone}"
