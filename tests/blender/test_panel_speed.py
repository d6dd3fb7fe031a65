# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel stays cheap with hundreds of muscles."""

import time
import types

import bpy
import pytest
from bl_ext.user_default.sinew.scene import characters
from conftest import select
from test_panels import PANELS, tissue_list

MOST_MS = 1.0
ROUNDS = 25


class Silent:
    """A layout that accepts every call and attribute, so that only Sinew's Python is measured."""

    def __getattr__(self, _name):
        return self._accept

    def _accept(self, *_arguments, **_settings):
        return self


def draw_once(filter_list):
    for panel in PANELS:
        if not hasattr(panel, "poll") or panel.poll(bpy.context):
            own = types.SimpleNamespace(layout=Silent(), _draw_shaded=lambda *_: None)
            if hasattr(panel, "draw_header"):
                panel.draw_header(own, bpy.context)
            panel.draw(own, bpy.context)
    tissue_list.SINEW_UL_tissues.filter_items(filter_list, bpy.context, bpy.data, "objects")


@pytest.mark.slow
def test_the_panel_of_400_muscles_is_drawn_in_a_millisecond(rigify):
    bpy.ops.object.armature_human_metarig_add()
    rig = bpy.context.object
    bpy.ops.sinew.add_preset(name="myo")
    bpy.context.view_layer.update()
    select(rig)
    assert len(characters.tissues_of(rig)) >= 400
    list_ = types.SimpleNamespace(
        bitflag_filter_item=1 << 30, filter_name="", use_filter_invert=False, kinds=set(), has_shown_search=True
    )
    list_._matches = types.MethodType(tissue_list.SINEW_UL_tissues._matches, list_)
    times = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        draw_once(list_)
        times.append(1000.0 * (time.perf_counter() - start))
    print(f"panel of {len(characters.tissues_of(rig))} tissues: {min(times):.3f} ms")
    assert min(times) < MOST_MS
