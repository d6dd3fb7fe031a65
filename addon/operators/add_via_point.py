# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.add_via_point`"""

from bpy.props import FloatProperty, StringProperty
from bpy.types import Operator

from .. import courses
from ..errors import SinewError
from .base import SinewOperator
from .wrap import is_on_muscle


class SINEW_OT_add_via_point(SinewOperator, Operator):
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

    @classmethod
    def poll(cls, context):
        return super().poll(context) and is_on_muscle(cls, context)

    def run(self, context):
        muscle = courses.muscle_of(context.object)
        if muscle.library:
            raise SinewError(f"{muscle.name} is linked from another file: make a library override of its armature first")
        via = courses.add_via_point(muscle, self.share, self.bone)
        via.select_set(True)
        return f"Added {via.name} on {via.parent_bone}"

