# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.wrap` sets the spheres that a muscle wraps around (docs/mathematics/paths.md, Wrapping spheres)."""

from bpy.props import BoolProperty
from bpy.types import Operator

from ..errors import SinewError
from ..scene import tissue_empty
from .base import MuscleOperator, writable_muscle


class SINEW_OT_wrap(MuscleOperator, Operator):
    """Wrap the active muscle around the selected joint spheres, on the side where it passes them in the rest pose"""

    bl_idname, bl_label = "sinew.wrap", "Wrap around Spheres"

    unwrap: BoolProperty(
        name="Unwrap",
        description="Stop wrapping around the selected spheres, or around all spheres if none is selected",
        default=False,
    )

    def run(self, context):
        muscle = writable_muscle(context)
        selected = [
            empty
            for empty in context.selected_objects
            if tissue_empty.is_tissue(empty) and empty.sinew.tissue.kind == "SPHERE" and empty.parent == muscle.parent
        ]
        present = [wrap.sphere for wrap in muscle.sinew.tissue.wraps if wrap.sphere]
        if self.unwrap:
            kept = [sphere for sphere in present if selected and sphere not in selected]
            tissue_empty.write_wraps(muscle, kept)
            return f"{muscle.name} wraps around {_names(kept)}"
        if not selected:
            raise SinewError(
                f"{muscle.name} needs a sphere to wrap around. Select a sphere of {muscle.parent.name}, then Shift-click "
                "the muscle. Add Tissue makes spheres"
            )
        wrapped = list(dict.fromkeys((*present, *selected)))
        tissue_empty.write_wraps(muscle, wrapped)
        return f"{muscle.name} wraps around {_names(wrapped)}"


def _names(spheres: list) -> str:
    return ", ".join(sphere.name for sphere in spheres) or "nothing"
