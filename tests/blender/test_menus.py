# SPDX-License-Identifier: GPL-3.0-or-later
"""The menus: Object > Sinew has every operator, so that F3 finds it, and the pie menu draws in every situation."""

import types

import bpy
from bl_ext.user_default.sinew import ui
from bl_ext.user_default.sinew.ui import menus
from conftest import add_muscle, select
from test_panels import OPERATORS, Layout

# started by a click, a tool or a button beside a problem
WITHOUT_MENU = {"SINEW_OT_choose_tissue", "SINEW_OT_repair", "SINEW_OT_drag_handle", "SINEW_OT_drop_preset"}


class MenuLayout(Layout):
    """Draws submenus too."""

    def menu(self, name, **settings):
        super().menu(name, **settings)
        draw(getattr(bpy.types, name), self.drawn)

    def menu_pie(self):
        return MenuLayout(self.drawn)


def draw(menu, drawn=None):
    drawn = [] if drawn is None else drawn
    menu.draw(types.SimpleNamespace(layout=MenuLayout(drawn)), bpy.context)
    return drawn


def operators_in(drawn):
    return {f"SINEW_OT_{entry[1].removeprefix('sinew.')}" for entry in drawn if entry[0] == "operator"}


def test_every_operator_is_in_the_menu():
    assert operators_in(draw(menus.SINEW_MT_sinew)) >= set(OPERATORS) - WITHOUT_MENU


def test_blenders_menus_show_it():
    for menu in (bpy.types.VIEW3D_MT_object, bpy.types.VIEW3D_MT_pose):
        assert menus._draw_in_menu in menu._dyn_ui_initialize()


def test_the_pie_draws_in_every_situation(arm):
    _skin, rig = arm
    bpy.context.view_layer.objects.active = None
    assert len(draw(menus.SINEW_MT_pie)) >= 8
    add_muscle(rig)
    select(rig)
    drawn = draw(menus.SINEW_MT_pie)
    assert ("prop", "view", "") in drawn


def test_every_menu_has_a_tooltip():
    found = [cls for cls in ui._CLASSES if issubclass(cls, bpy.types.Menu)]
    assert len(found) > 5 and all(cls.__doc__ and len(cls.__doc__.split()) >= 3 for cls in found)
