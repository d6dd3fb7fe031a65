# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of a rig's tissues, with search; a row is the Empty itself."""

from bpy.props import BoolProperty, EnumProperty
from bpy.types import UIList

from ..live import session
from ..scene import characters
from ..settings.object_settings import TISSUE_KINDS
from .sidebar import rig_and_reason

ICON_OF_KIND = {"MUSCLE": "META_ELLIPSOID", "BONE": "BONE_DATA", "STUFFING": "META_BALL", "SPHERE": "SPHERE"}
KINDS = tuple((*kind, ICON_OF_KIND[kind[0]], 1 << place) for place, kind in enumerate(TISSUE_KINDS))


class SINEW_UL_tissues(UIList):
    """The tissues among all objects of the file, in the order of their names."""

    has_shown_search: BoolProperty(options={"HIDDEN"})
    kinds: EnumProperty(name="Kinds", description="Show these kinds alone; none: all", items=KINDS, options={"ENUM_FLAG"})

    def draw_item(self, _context, layout, _data, item, _icon, _active_data, _active_property, _index, _flag):
        state = session.kept_rig(item.parent)
        is_wrong = state is not None and item.name in state.problems
        row = layout.row(align=True)
        row.alert = is_wrong
        row.prop(
            item, "name", text="", emboss=False, icon="ERROR" if is_wrong else ICON_OF_KIND.get(item.sinew.kind, "NONE")
        )
        row.prop(item, "hide_viewport", text="", emboss=False)

    def draw_filter(self, _context, layout):
        row = layout.row(align=True)
        row.prop(self, "filter_name", text="", icon="VIEWZOOM")
        row.prop(self, "use_filter_invert", text="", icon="ARROW_LEFTRIGHT")
        row.separator()
        for kind, *_ in KINDS:
            row.prop_enum(self, "kinds", kind, text="")

    def filter_items(self, context, data, property_name):
        if not self.has_shown_search:
            self.has_shown_search = self.use_filter_show = True  # Blender begins with the search folded away
        objects = getattr(data, property_name)
        rig, _reason = rig_and_reason(context)
        character = characters.character_of(rig) if rig else None
        names = {key.name for key in character.tissues} if character else set()
        # Blender turns every flag round where the search is inverted, also of objects that are no tissues
        wanted = [found.name in names and self._matches(found, rig) for found in objects]
        flags = [self.bitflag_filter_item if shown != self.use_filter_invert else 0 for shown in wanted]
        return flags, []

    def _matches(self, empty, rig) -> bool:
        if empty.parent != rig or (self.kinds and empty.sinew.kind not in self.kinds):
            return False
        is_found = self.filter_name.casefold() in empty.name.casefold()
        return is_found != self.use_filter_invert
