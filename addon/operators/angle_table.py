# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of joints and angles in the dialog of Bake Correctives: a row for each rotation of a joint."""

import math

from bpy.props import BoolProperty, CollectionProperty, EnumProperty, FloatProperty, IntProperty
from bpy.types import PropertyGroup, UIList

from ..bake.correctives import turn_ranges
from ..bake.scratch.joint_turns import BEND, JointTurn
from ..errors import SinewError
from ..live import session
from ..measure import joint_regions
from ..reach import bone_limits
from ..scene import bone_geometry

ROWS = 12
FARTHEST_RAD = math.radians(turn_ranges.FARTHEST_DEGREES)
AXES = (
    ("BEND", "Bend", "About the axis of the muscles that cross the joint"),
    ("X", "X", "About the bone's local X axis"),
    ("Y", "Twist", "About the bone's local Y axis, which twists it"),
    ("Z", "Z", "About the bone's local Z axis"),
)


class SinewAngleRange(PropertyGroup):
    """A rotation of a joint. Its name is the bone."""

    is_baked: BoolProperty(name="Bake", description="Bake correctives for this rotation of the joint", default=True)
    axis: EnumProperty(name="Axis", description="The axis that the joint rotates about", items=AXES)
    low: FloatProperty(
        name="From",
        description="The first angle, from the rest pose",
        subtype="ANGLE",
        min=-FARTHEST_RAD,
        max=0.0,
    )
    high: FloatProperty(
        name="To", description="The last angle, from the rest pose", subtype="ANGLE", min=0.0, max=FARTHEST_RAD
    )


class SINEW_UL_angles(UIList):
    """The rotations of joints that get correctives"""

    def draw_item(self, _context, layout, _data, item, _icon, _active_data, _active_property, _index, _flag):
        row = layout.row(align=True)
        row.prop(item, "is_baked", text="")
        values = row.row(align=True)
        values.active = item.is_baked
        values.label(text=item.name)
        values.label(text=next(label for axis, label, _tip in AXES if axis == item.axis))
        values.prop(item, "low", text="")
        values.prop(item, "high", text="")


CLASSES = (SinewAngleRange, SINEW_UL_angles)


def table_property():
    """The property of the operator that holds the table."""
    return CollectionProperty(
        type=SinewAngleRange,
        name="Angles",
        description="The rotations to bake. Empty: all joints chosen above, within their limits",
        options={"SKIP_SAVE"},
    )


def row_property():
    """The property of the operator that holds the row in the table that was clicked last."""
    return IntProperty(name="Row", description="The row of the table that was clicked last", options={"SKIP_SAVE", "HIDDEN"})


def fill(table, rig, skins: list, bones: list[str] | None):
    """Fills the table with the rotations that a bake without a table would bake. bones: None for all that muscles cross."""
    table.clear()
    for turn in turns_of(rig, skins, bones):
        row = table.add()
        row.name, row.axis = turn.bone, "BEND" if turn.axis == BEND else turn.axis
        row.low, row.high = turn.low, turn.high


def turns_of(rig, skins: list, bones: list[str] | None) -> list[JointTurn]:
    """The rotations of the joints at the heads of some bones, within the limits of the bones."""
    state = session.cached_rig(rig)
    if state is None:
        return []
    joints = {}
    for skin in skins:
        for joint in joint_regions.joints_of(skin, rig, state.rest, state.musculature, bones, "MUSCLES"):
            joints.setdefault(joint.bone, joint)
    free = joints.keys() - bone_limits.driven_bones(rig)
    if bones is None and free:
        joints = {bone: joint for bone, joint in joints.items() if bone in free}
    return [turn for joint in joints.values() for turn in turn_ranges.turns_of_joint(rig, joint, "", True)]


def read(table, rig) -> tuple[list[str], list[str]]:
    """(bones, ranges): the chosen rows, one range for each bone as `turn_ranges.parse_ranges` takes it."""
    ranges: dict[str, list[str]] = {}
    for row in table:
        if row.is_baked and row.high - row.low > 0.0:
            if not bone_geometry.has_bone(rig, row.name):
                raise SinewError(f"{rig.name} has no bone '{row.name}'")
            axis = "" if row.axis == "BEND" else f"{row.axis} "
            low, high = (round(math.degrees(angle), 4) for angle in (row.low, row.high))
            ranges.setdefault(row.name, []).append(f"{axis}{low:.4f}..{high:.4f}")
    if not ranges:
        raise SinewError("No rotation is chosen. Check at least one row of the table, or clear the table")
    return list(ranges), [" ".join(of_bone) for of_bone in ranges.values()]


def draw(layout, operator):
    """Draws the table of an operator with the properties `ranges` and `row`, and what it adds up to."""
    layout.label(text=summary(operator.ranges))
    column = layout.column()
    column.use_property_split = False
    column.template_list("SINEW_UL_angles", "", operator, "ranges", operator, "row", rows=ROWS)


def summary(table) -> str:
    """How many joints and rotations are chosen."""
    chosen = [row for row in table if row.is_baked]
    return f"{len(chosen)} rotations of {len({row.name for row in chosen})} joints"
