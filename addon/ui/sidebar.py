# SPDX-License-Identifier: GPL-3.0-or-later
"""Base classes and layout functions of the panels."""

from ..errors import SinewError
from ..languages.messages import translated
from ..operators.base import rig_of_context
from ..scene import armature_modifier, characters, stored_settings
from . import text_width


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


class TissuesPanel(SidebarPanel):
    """Mix-in: a panel that needs tissues."""

    @classmethod
    def poll(cls, context):
        character = context_character(context)
        return character is not None and bool(character.tissues)


class CharacterPanel(SidebarPanel):
    """Mix-in: a panel that needs tissues or a bound skin."""

    @classmethod
    def poll(cls, context):
        return context_character(context) is not None


class BoundPanel(SidebarPanel):
    """Mix-in: a panel that needs a bound skin."""

    @classmethod
    def poll(cls, context):
        character = context_character(context)
        return character is not None and bool(character.skins)


def context_character(context):
    """The character of the context, or None."""
    rig, _reason = rig_and_reason(context)
    return characters.last_character_of(rig) if rig else None


def rig_and_reason(context):
    """(armature of the context, ""), or (None, the reason why there is none)."""
    try:
        return rig_of_context(context), ""
    except SinewError as error:
        return None, str(error)


def rig_settings(rig):
    """`object.sinew.rig` of an armature, or None if it has no muscles, no skin and no stored settings."""
    return rig.sinew.rig if characters.last_character_of(rig) else stored_settings.rig_of(rig)


def active_skin(context):
    """The active mesh if it is bound, or the first bound mesh of the active armature, or None."""
    active = context.object
    if active and active.type == "MESH":
        return active if armature_modifier.is_bound(active) else None
    rig, _reason = rig_and_reason(context)
    character = characters.last_character_of(rig) if rig else None
    return character.skins[0].find() if character and character.skins else None


def label_wrapped(layout, text: str, icon: str):
    """Draws a text, in the user's language, as several labels, because a label is one line and the sidebar is narrow."""
    column = layout.column(align=True)
    column.scale_y = 0.8
    for number, line in enumerate(text_width.wrapped(translated(text))):
        column.label(text=line, icon="BLANK1" if number else icon, translate=False)


def draw_settings(layout, settings, *names: str, can_be_keyed: bool = False):
    """Draws a column of settings. Numbers have their name inside the field, and choices have none.

    Beside the field, two fifths of the sidebar's width would remain, which cuts off many names and choices.
    """
    column = layout.column()
    column.use_property_decorate = False
    for name in names:
        kind = settings.bl_rna.properties[name]
        if kind.type == "ENUM":
            column.label(text=kind.name)
        row = column.row(align=True)
        row.use_property_split = kind.type == "POINTER" or getattr(kind, "is_array", False)
        row.prop(settings, name, **({"text": ""} if kind.type == "ENUM" else {}))
        if can_be_keyed:
            row.prop_decorator(settings, name)
