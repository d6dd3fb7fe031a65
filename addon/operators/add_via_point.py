# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.add_via_point`"""

from bpy.props import FloatProperty, StringProperty
from bpy.types import Operator

from ..muscles import muscle_path
from .base import MuscleOperator, writable_muscle


class SINEW_OT_add_via_point(MuscleOperator, Operator):
    """Add a point to the active muscle that its path passes; drag its Empty in the rest pose to lead the muscle round things"""

    bl_idname, bl_label = "sinew.add_via_point", "Add Via Point"

    share: FloatProperty(
        name="Along",
        description="Where along the muscle's path, from its origin to its insertion",
        min=0.0,
        max=1.0,
        default=0.5,
        subtype="FACTOR",
    )
    bone: StringProperty(name="Bone", description="The bone that carries the point. Empty: the nearest along the muscle")

    def run(self, context):
        muscle = writable_muscle(context)
        via = muscle_path.add_via_point(muscle, self.share, self.bone)
        via.select_set(True)
        return f"Added {via.name} on {via.parent_bone}"
