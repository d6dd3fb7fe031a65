# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of the bones of each part of the body, which the operators that add presets show (F9)."""

from bpy.props import CollectionProperty, EnumProperty, StringProperty
from bpy.types import PropertyGroup

from ..muscles.placing.recognise import segments
from ..muscles.placing.recognise.body import Body
from ..muscles.placing.recognise.body_parts import CENTRAL_ROLES, ROLES, body_parts, part_label

CENTRE = "C"


class SinewSegmentBone(PropertyGroup):
    """The first bone of a part of the body. Its name is the label in the list."""

    role: EnumProperty(
        name="Part",
        description="The part of the body",
        items=[(role, part_label(role).capitalize(), f"The {part_label(role)}") for role in ROLES],
    )
    side: EnumProperty(
        name="Side",
        description="The side of the body",
        items=[(CENTRE, "Center", "On the center line"), ("L", "Left", "The left side"), ("R", "Right", "The right side")],
        default=CENTRE,
    )
    bone: StringProperty(name="Bone", description="The first bone of this part, nearest to the center of the body")

    @property
    def part(self) -> tuple[str, str]:
        """(role, side), as in `segments`."""
        return self.role, "" if self.role in CENTRAL_ROLES else self.side


def bones_property():
    """The rows of the table, as a property of an operator."""
    return CollectionProperty(
        type=SinewSegmentBone,
        name="Bones",
        description="The first bone of each part of the body. Recognized bones are filled in and can be corrected",
        options={"SKIP_SAVE"},
    )


def recognised(rows, rig, roles, kind: str = "") -> Body:
    """The body of a rig with the corrections of the rows. Fills in the missing rows.

    roles: the parts that the preset needs. kind: the kind of creature, which says how its bones are looked for. Raises
    SinewError as `segments.recognise` does.
    """
    body = segments.recognise(rig, {row.part: row.bone for row in rows}, kind)
    fill(rows, roles, {part: bones[0] for part, bones in body.recognised.chains.items()})
    return body


def fill(rows, roles, guesses):
    """Adds the missing rows: every part that was recognised or that the preset needs."""
    present = {row.part for row in rows}
    for role, side in body_parts():
        if (role, side) not in present and ((role, side) in guesses or role in roles):
            row = rows.add()
            row.role, row.side = role, side or CENTRE
            row.name, row.bone = part_label(role, side), guesses.get((role, side), "")


def draw(layout, rows, rig):
    """Draws the table."""
    column = layout.column(align=True)
    column.label(text="Bones")
    for row in rows:
        role, side = row.part
        column.prop_search(row, "bone", rig.data, "bones", text=part_label(role, side).capitalize())
