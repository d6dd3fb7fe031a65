# SPDX-License-Identifier: GPL-3.0-or-later
"""`object.sinew.rig.groups`: what a user changes for all muscles of a group at once.

A changed value is written to each member, so that muscles can also differ again.
"""

from bpy.props import BoolProperty, FloatProperty, StringProperty
from bpy.types import PropertyGroup

from ..scene import characters
from . import updates
from .updates import OVERRIDABLE


def members_of(group) -> list:
    """The muscles of a group."""
    tissues = characters.tissues_of(group.id_data)
    settings = [tissue.sinew.tissue for tissue in tissues]
    return [member for member in settings if member.group == group.name and member.kind == "MUSCLE"]


def _write_to_members(name: str):
    def update(group, _context):
        if not updates.is_silent():
            for member in members_of(group):
                setattr(member, name, getattr(group, name))

    return update


class SinewMuscleGroup(PropertyGroup):
    """A group of tissues. Its name is that of its members' setting `group`."""

    name: StringProperty(name="Group", description="Name of the group", override=OVERRIDABLE)
    tension: FloatProperty(
        name="Tension",
        description="Tenses all muscles of the group at constant length",
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        options=set(),
        update=_write_to_members("tension"),
        override=OVERRIDABLE,
    )
    influence: FloatProperty(
        name="Influence",
        description="How much all muscles of the group swell",
        min=0.0,
        max=1.0,
        default=1.0,
        subtype="FACTOR",
        options=set(),
        update=_write_to_members("influence"),
        override=OVERRIDABLE,
    )
    muted: BoolProperty(
        name="Mute",
        description="Leave out all muscles of the group",
        options=set(),
        update=_write_to_members("muted"),
        override=OVERRIDABLE,
    )
    solo: BoolProperty(
        name="Solo",
        description="Leave out all muscles that are not in a solo group",
        options=set(),
        update=_write_to_members("solo"),
        override=OVERRIDABLE,
    )


def follow(rig, names: list[str]):
    """Gives a rig the groups of these names, in this order. Existing groups keep their values."""
    groups = rig.sinew.rig.groups
    for index in reversed(range(len(groups))):
        if groups[index].name not in names:
            groups.remove(index)
    with updates.silent():
        for position, name in enumerate(names):
            index = groups.find(name)
            if index < 0:
                groups.add().name = name
                index = len(groups) - 1
            groups.move(index, position)


CLASSES = (SinewMuscleGroup,)
