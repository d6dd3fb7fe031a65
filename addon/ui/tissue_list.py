# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of a rig's tissues, with search."""

from bpy.props import BoolProperty, EnumProperty
from bpy.types import UIList

from ..live import session
from ..scene import characters, stored_settings
from ..settings.tissue_settings import TISSUE_KINDS
from . import text_width
from .sidebar import rig_and_reason

ICON_OF_KIND = {"MUSCLE": "META_ELLIPSOID", "BONE": "BONE_DATA", "STUFFING": "META_BALL", "SPHERE": "SPHERE"}
KINDS = tuple((*kind, ICON_OF_KIND[kind[0]], 1 << bit) for bit, kind in enumerate(TISSUE_KINDS))


SIDES = (".L", ".R")
SIDE_UNITS = 0.8  # width of a letter, in units of Blender's interface
# widths at a resolution scale of 1: margins, icon and scroll bar; the letter of a side; mute and solo
_BESIDE_NAME, _SIDE, _BUTTONS = 64.0, 16.0, 42.0


def _room(is_muscle: bool, has_side: bool) -> float:
    """The width of a name in the list, in pixels."""
    beside = _BESIDE_NAME + _SIDE * has_side + _BUTTONS * is_muscle
    return text_width.contents_width() - beside * text_width.scale()


def side_of(name: str) -> str:
    """The side that a name ends with, "L" or "R", or an empty text."""
    return name[-1] if name.endswith(SIDES) else ""


class SINEW_UL_tissues(UIList):
    """The tissues of the active character. The rows are all objects of the file, filtered; each tissue is an Empty."""

    has_shown_search: BoolProperty(options={"HIDDEN"})
    kinds: EnumProperty(
        name="Kinds",
        description="Show only these kinds of tissue. None selected: all kinds",
        items=KINDS,
        options={"ENUM_FLAG"},
    )

    def draw_item(self, _context, layout, _data, item, _icon, _active_data, _active_property, _index, _flag):
        state = session.cached_rig(item.parent)
        is_wrong = state is not None and item.name in state.problems
        row = layout.row(align=True)
        row.alert = is_wrong
        settings = stored_settings.tissue_of(item)
        icon = ICON_OF_KIND.get(settings.kind, "NONE") if settings is not None and not is_wrong else "NONE"
        is_muscle = settings is not None and settings.kind == "MUSCLE"
        icon = "ERROR" if is_wrong else icon
        room = _room(is_muscle, has_side=False)
        if text_width.width_of(item.name) <= room:
            row.prop(item, "name", text="", emboss=False, icon=icon)
        else:
            side = side_of(item.name)
            stem = item.name.removesuffix(f".{side}") if side else item.name
            row.label(
                text=text_width.shortened(stem, room - (_SIDE * text_width.scale() if side else 0.0)),
                icon=icon,
                translate=False,
            )
            if side:
                column = row.row()
                column.ui_units_x = SIDE_UNITS
                column.label(text=side, translate=False)
        if is_muscle:
            row.prop(settings, "solo", text="", icon="SOLO_ON" if settings.solo else "SOLO_OFF", emboss=False)
            row.prop(settings, "muted", text="", icon="HIDE_ON" if settings.muted else "HIDE_OFF", emboss=False)

    def draw_filter(self, _context, layout):
        row = layout.row(align=True)
        row.prop(self, "filter_name", text="", icon="VIEWZOOM")
        row.prop(self, "use_filter_invert", text="", icon="ARROW_LEFTRIGHT")
        row.separator()
        for kind, *_ in KINDS:
            row.prop_enum(self, "kinds", kind, text="")

    def filter_items(self, context, data, property_name):
        if not self.has_shown_search:
            self.has_shown_search = self.use_filter_show = True  # Blender hides the search by default
        count = len(getattr(data, property_name))
        rig, _reason = rig_and_reason(context)
        tissues = (characters.cached() or characters.current()).tissue_rows(rig) if rig else []
        # an inverted search makes Blender invert all flags, also those of objects that are not tissues
        shown, others = self.bitflag_filter_item, 0
        if self.use_filter_invert:
            shown, others = others, shown
        flags = [others] * count
        for key, row in tissues:
            if self._matches(key):
                flags[row] = shown
        return flags, []

    def _matches(self, key) -> bool:
        """Whether the search finds a tissue. key: as in the index of characters."""
        if self.kinds:
            tissue = key.find()
            if tissue is None or tissue.sinew.tissue.kind not in self.kinds:
                return False
        has_text = not self.filter_name or self.filter_name.casefold() in key.name.casefold()
        return has_text != self.use_filter_invert
