# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.wrap`"""

from bpy.props import BoolProperty
from bpy.types import Operator

from ..errors import SinewError
from ..scene import tissue_empty
from .base import MuscleOperator, writable_muscle


class SINEW_OT_wrap(MuscleOperator, Operator):
    """Lead the active muscle round the selected joint spheres, on the side where it passes them in the rest pose"""

    bl_idname, bl_label = "sinew.wrap", "Wrap around Spheres"

    unwrap: BoolProperty(
        name="Unwrap",
        description="Take the selected spheres out of the muscle's way instead; all of them where none is selected",
        default=False,
    )

    def run(self, context):
        muscle = writable_muscle(context)
        selected = [
            found
            for found in context.selected_objects
            if tissue_empty.is_tissue(found) and found.sinew.kind == "SPHERE" and found.parent == muscle.parent
        ]
        present = [wrap.sphere for wrap in muscle.sinew.wraps if wrap.sphere]
        if self.unwrap:
            kept = [sphere for sphere in present if selected and sphere not in selected]
            tissue_empty.write_wraps(muscle, kept)
            return f"{muscle.name} goes round {_names(kept)}"
        if not selected:
            raise SinewError(
                f"{muscle.name} needs something to go round: select a sphere of {muscle.parent.name}, then with Shift the "
                "muscle (Add Tissue makes spheres)"
            )
        wrapped = list(dict.fromkeys((*present, *selected)))
        tissue_empty.write_wraps(muscle, wrapped)
        return f"{muscle.name} goes round {_names(wrapped)}"


def _names(spheres: list) -> str:
    return ", ".join(sphere.name for sphere in spheres) or "nothing"
