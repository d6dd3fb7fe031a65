# SPDX-License-Identifier: GPL-3.0-or-later
"""No label is cut off at the sidebar's default width, in any language, and names in the list stay different."""

import types
from dataclasses import dataclass, field

import bpy
import pytest
from bl_ext.user_default.sinew.languages import tables
from bl_ext.user_default.sinew.muscles.placing.place import preset_file
from bl_ext.user_default.sinew.ui import text_width, tissue_list
from conftest import add_muscle, bind, select
from test_panels import PANELS

# widths in units of Blender's interface at a scale of 1: around a text, an icon or arrow, a value beside its name
PADDING, ICON, VALUE, SHORTEST_NAME = 10.0, 20.0, 44.0, 40.0
SPLIT = 0.4  # the part of a row that names have where values are beside them
HEADER = 46.0  # the arrow and the handle of a panel's header
LANGUAGES = ("en_US", *tables.TABLES)


@dataclass
class Item:
    """A text in a layout, and the width that it needs."""

    text: str
    width: float


@dataclass
class Measured:
    """A layout that keeps its items, to compare what they need with what they have."""

    language: str
    kind: str = "COLUMN"
    factor: float = 0.0
    children: list = field(default_factory=list)
    use_property_split: bool = False
    ui_units_x: float = 0.0

    def _inside(self, kind, factor=0.0):
        inside = Measured(self.language, kind, factor, use_property_split=self.use_property_split)
        self.children.append(inside)
        return inside

    def row(self, **_settings):
        return self._inside("ROW")

    def column(self, **_settings):
        return self._inside("COLUMN")

    def split(self, factor=0.5, **_settings):
        return self._inside("SPLIT", factor)

    def _add(self, text: str, more: float = 0.0, is_name=False):
        shown = tables.TABLES.get(self.language, {}).get(text, text)
        width = SHORTEST_NAME if is_name else text_width.width_of(shown) + PADDING if shown else 0.0
        self.children.append(Item(shown, width + more))

    def label(self, text="", icon="NONE", **_settings):
        self._add(text, ICON * (icon != "NONE"))

    def menu(self, name, text="", **_settings):
        self._add(text or getattr(bpy.types, name).bl_label, 2 * ICON)

    def operator(self, name, text=None, icon="NONE", **_settings):
        rna = getattr(bpy.ops.sinew, name.removeprefix("sinew.")).get_rna_type() if name.startswith("sinew.") else None
        self._add(rna.name if text is None else text, ICON * (icon != "NONE"))
        return types.SimpleNamespace()

    def operator_menu_enum(self, name, _property, **settings):
        self.operator(name, **settings)
        self._add("", ICON)

    def prop(self, data, name, text=None, icon="NONE", expand=False, **_settings):
        rna = data.bl_rna.properties[name]
        title = rna.name if text is None else text
        icon_width = ICON * (icon != "NONE")
        if rna.type == "ENUM" and expand:
            row = self.row()
            for item in rna.enum_items:
                row._add(item.name)
        elif rna.type == "ENUM":
            longest = max((item.name for item in rna.enum_items_static), key=text_width.width_of)
            self._add(longest, 2 * ICON + (text_width.width_of(title) if title else 0.0))
        elif getattr(rna, "is_array", False) and self.use_property_split:
            split = self.split(factor=SPLIT)
            split._add(f"{title} X")
            split._add("", VALUE)
        elif rna.type in ("INT", "FLOAT"):
            self._add(title, VALUE)
        elif rna.type == "BOOLEAN":
            self._add(title, icon_width or ICON)
        else:
            self._add(title, icon_width, is_name=True)

    def prop_search(self, data, name, *_where, **_settings):
        self._add("", SHORTEST_NAME)

    def prop_enum(self, *_arguments, **_settings):
        self._add("", ICON)

    def prop_decorator(self, *_arguments, **_settings):
        self._add("", ICON)

    def separator(self, **_settings):
        pass

    def template_list(self, *_arguments, **_settings):
        pass

    def needed(self) -> float:
        if self.ui_units_x:
            return self.ui_units_x * ICON
        widths = [child.width if isinstance(child, Item) else child.needed() for child in self.children]
        return sum(widths) if self.kind == "ROW" else max(widths, default=0.0)

    def cut(self, room: float) -> list[str]:
        """The texts that have less room than they need."""
        if self.kind == "ROW" and self.needed() > room:
            return [self.texts()]
        rooms = [room] * len(self.children)
        if self.kind == "SPLIT":
            rooms = [self.factor * room, *[(1.0 - self.factor) * room] * len(self.children[1:])]
        found = []
        for child, its_room in zip(self.children, rooms, strict=True):
            if isinstance(child, Measured):
                found += child.cut(its_room)
            elif child.width > its_room and self.kind != "ROW":
                found.append(child.text)
        return found

    def texts(self) -> str:
        return " | ".join(child.text if isinstance(child, Item) else child.texts() for child in self.children)


def cut_labels(language: str) -> list[str]:
    found = []
    for panel in PANELS:
        if hasattr(panel, "poll") and not panel.poll(bpy.context):
            continue
        own = types.SimpleNamespace(layout=Measured(language))
        if hasattr(panel, "_draw_shaded"):
            own._draw_shaded = types.MethodType(panel._draw_shaded, own)
        panel.draw(own, bpy.context)
        found += [f"{panel.bl_label}: {text}" for text in own.layout.cut(text_width.contents_width())]
        if hasattr(panel, "draw_header"):
            header = types.SimpleNamespace(layout=Measured(language, "ROW"))
            panel.draw_header(header, bpy.context)
            found += [
                f"{panel.bl_label}, header: {text}" for text in header.layout.cut(text_width.contents_width() - HEADER)
            ]
    return found


@pytest.mark.parametrize("language", LANGUAGES)
def test_no_label_is_cut_off(arm, language):
    skin, rig = arm
    bpy.context.view_layer.objects.active = None
    found = cut_labels(language)
    select(rig)
    found += cut_labels(language)
    muscle = add_muscle(rig)
    select(rig)
    found += cut_labels(language)
    select(muscle)
    bpy.ops.sinew.group_tissues(by="SELECTED", name="Arm.L")
    bind(skin)
    rig.data.bones.active = rig.data.bones["lower"]
    rig.sinew.rig.show_shaded = True
    for active in (skin, rig, muscle):
        select(active)
        found += cut_labels(language)
    select(rig)
    bpy.ops.object.mode_set(mode="POSE")
    found += cut_labels(language)
    assert sorted(set(found)) == []


def test_shortened_names_fit_and_stay_different():
    for preset, *_ in preset_file.available():
        names = {rule.name for rule in preset_file.read(preset).tissues}
        room = tissue_list._room(is_muscle=True, has_side=True)
        shown = {name: text_width.shortened(name, room) for name in sorted(names)}
        assert all(text_width.width_of(text) <= room for text in shown.values()), shown
        assert [(name, text) for name, text in shown.items() if list(shown.values()).count(text) > 1] == []


@pytest.mark.parametrize("text", ["one two three four five six seven eight nine ten", "皮" * 60, "x" * 80, ""])
def test_wrapped_text_is_complete_and_fits(text):
    lines = text_width.wrapped(text)
    assert "".join(lines).replace(" ", "") == text.replace(" ", "")
    room = text_width.contents_width() - text_width._ICON * text_width.scale()
    assert all(text_width.width_of(line) <= room or len(line.split()) == 1 for line in lines)
