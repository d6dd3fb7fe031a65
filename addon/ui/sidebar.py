# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panels share: where they stand, and which character they show."""

from ..errors import SinewError
from ..scene import armature_modifier, characters


class SidebarPanel:
    """Mix-in: a panel in the "Sinew" tab."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Sinew"


class RigPanel(SidebarPanel):
    """Mix-in: a panel that needs an armature."""

    @classmethod
    def poll(cls, context):
        return rig_and_reason(context)[0] is not None


def rig_and_reason(context):
    """The armature that the active object is, follows or belongs to; without one, a text that says what to select."""
    active = context.object
    if active is None:
        return None, "Select an armature or its mesh"
    if active.type == "ARMATURE":
        return active, ""
    if active.type == "MESH":
        try:
            return armature_modifier.rig_of(active), ""
        except SinewError as error:
            return None, str(error)
    if active.parent and active.parent.type == "ARMATURE":
        return active.parent, ""
    if active.sinew.goal.rig:
        return active.sinew.goal.rig, ""
    return None, "Select an armature or its mesh"


def active_skin(context):
    """The bound mesh that is active, else the first of the active armature, else None."""
    active = context.object
    if active and active.type == "MESH":
        return active if armature_modifier.is_bound(active) else None
    rig, _reason = rig_and_reason(context)
    character = characters.character_of(rig) if rig else None
    return character.skins[0].find() if character and character.skins else None


def label_wrapped(layout, text: str, icon: str, width: int = 42):
    """A text in as many lines as it needs: a label is one line, and the sidebar is narrow."""
    lines, line = [], ""
    for word in text.split():
        if line and len(line) + len(word) >= width:
            lines.append(line)
            line = word
        else:
            line = f"{line} {word}".strip()
    column = layout.column(align=True)
    column.scale_y = 0.8
    for number, shown in enumerate((*lines, line)):
        column.label(text=shown, icon="BLANK1" if number else icon)


def draw_settings(layout, settings, *names: str, can_be_keyed: bool = False):
    """A column of settings whose names can be read in the narrow sidebar: a number's stands inside of its field.

    Beside it only two fifths of the width are left for a name, and those of anatomy are long.
    """
    column = layout.column()
    column.use_property_decorate = False
    for name in names:
        kind = settings.bl_rna.properties[name]
        row = column.row(align=True)
        row.use_property_split = kind.type not in {"INT", "FLOAT"} or kind.is_array
        row.prop(settings, name)
        if can_be_keyed:
            row.prop_decorator(settings, name)
