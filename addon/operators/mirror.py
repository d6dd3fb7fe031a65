# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.mirror` mirrors tissues to the other side of the body."""

from bpy.props import EnumProperty
from bpy.types import Operator

from ..errors import SinewError
from ..muscles import mirror, portable_names
from ..scene import characters
from ..scene.linked_data import writable
from .base import SinewOperator, rig_of_context

DIRECTIONS = (
    (
        "SELECTED",
        "Selected",
        "The selected tissues. If both of a pair are selected, the side of the active tissue is mirrored",
    ),
    ("LEFT_TO_RIGHT", "Left to Right", "All tissues of the left side, to the right"),
    ("RIGHT_TO_LEFT", "Right to Left", "All tissues of the right side, to the left"),
)


class SINEW_OT_mirror(SinewOperator, Operator):
    """Mirror tissues to the other side, using names such as .L and .R. Existing tissues of the other side are replaced"""

    bl_idname, bl_label = "sinew.mirror", "Mirror Muscles"
    needs_tissues = True

    direction: EnumProperty(name="Direction", description="The tissues to mirror", items=DIRECTIONS)

    def run(self, context):
        rig = writable(rig_of_context(context))
        chosen = self._selected(context, rig) if self.direction == "SELECTED" else self._side(rig)
        problems = {}
        twins = mirror.mirror(rig, chosen, problems)
        if problems and not twins:
            raise SinewError(next(iter(problems.values())))
        self.warn(problems)
        return f"{len(twins)} tissues mirrored; {len(chosen) - len(twins) - len(problems)} on the center line were skipped"

    def _side(self, rig) -> list:
        wanted = "L" if self.direction == "LEFT_TO_RIGHT" else "R"
        chosen = [empty for empty in characters.tissues_of(rig) if _side_of(empty) == wanted]
        if not chosen:
            raise SinewError(f"{rig.name} has no tissue on its {'left' if wanted == 'L' else 'right'} side")
        return chosen

    def _selected(self, context, rig) -> list:
        # by portable names: the two of a pair can have different numbers
        selected = {name: empty for name, empty in portable_names.of_rig(rig).items() if empty.select_get()}
        if not selected:
            raise SinewError("Select the muscles to mirror, or use Left to Right or Right to Left")
        kept = _side_of(context.object) if context.object in selected.values() else "L"
        return [
            empty
            for name, empty in selected.items()
            if mirror.flipped(name) == name or mirror.flipped(name) not in selected or _side_of(empty) == (kept or "L")
        ]


def _side_of(empty) -> str:
    return mirror.side_of(empty.name, empty.sinew.tissue.origin_bone, empty.sinew.tissue.insertion_bone)
