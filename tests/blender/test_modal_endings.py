# SPDX-License-Identifier: GPL-3.0-or-later
"""Long operators in a window: however they end, the file, the mode, the frame and Live are as before.

Blender can't run modal operators without a window. The tests call the operators' methods with stand-ins for the operator,
its context and its events.
"""

from types import FunctionType, MethodType, SimpleNamespace

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew import operators
from bl_ext.user_default.sinew.operators import stepped
from conftest import FLEXOR, add_muscle, bend, bind, evaluated_points, make_arm, select
from test_reach import select_bones

TIMER, ESC = SimpleNamespace(type="TIMER", value="NOTHING"), SimpleNamespace(type="ESC", value="PRESS")
OPERATORS = {cls.bl_idname.partition(".")[2]: cls for cls in operators.CLASSES if hasattr(cls, "bl_idname")}
BAKES = {
    "bake_shape_keys": {"frame_start": 1, "frame_end": 6},
    "bake_cache": {"frame_start": 1, "frame_end": 6},
    "bake_correctives": {"joints": "lower"},
    "bake_bones": {"frame_start": 1, "frame_end": 6},
    "bake_reach": {"frame_start": 1, "frame_end": 6},
    "measure": {"poses": "FRAMES", "frame_start": 1, "frame_end": 6},
}


class StandIn:
    """An operator that Blender did not start: the functions of its class, and the defaults of its properties."""

    def __init__(self, name, **settings):
        self._class = OPERATORS[name]
        self.properties = SimpleNamespace(is_property_set=lambda name: name in settings)
        self.reports = []
        rna_type = getattr(bpy.ops.sinew, name).get_rna_type()
        self.__dict__ |= {found.identifier: getattr(found, "default", None) for found in rna_type.properties}
        self.rna_type = rna_type
        self.__dict__.update(settings)

    def __getattr__(self, name):
        found = getattr(self._class, name)
        return MethodType(found, self) if isinstance(found, FunctionType) else found

    def report(self, level, text):
        self.reports.append((next(iter(level)), text))


class Window:
    """A stand-in for a context with a window: it records timers, progress and status text."""

    def __init__(self):
        self.timers, self.is_progress_shown, self.texts = [], False, []
        self.window_manager = self
        self.workspace = SimpleNamespace(status_text_set=self.texts.append)
        self.window = self.area = self.region = None

    def __getattr__(self, name):
        return getattr(bpy.context, name)

    def progress_begin(self, _first, _last):
        self.is_progress_shown = True

    def progress_update(self, _fraction):
        assert self.is_progress_shown

    def progress_end(self):
        self.is_progress_shown = False

    def event_timer_add(self, interval, window):
        self.timers.append(interval)
        return interval

    def event_timer_remove(self, timer):
        self.timers.remove(timer)

    def modal_handler_add(self, _operator):
        pass

    @property
    def has_ended(self):
        return not self.timers and not self.is_progress_shown and (not self.texts or self.texts[-1] is None)


def state():
    """What an interrupted operator must leave as it was, by identity instead of names."""
    active = bpy.context.view_layer.objects.active
    return {
        "frame": (bpy.context.scene.frame_current, bpy.context.scene.frame_subframe),
        "live": {found.session_uid: found.sinew.skin.live for found in bpy.data.objects if found.type == "MESH"},
        "mode": (active.session_uid, active.mode) if active else None,
        "selected": {found.session_uid for found in bpy.context.view_layer.objects if found.select_get()},
        "data": {
            name: {found.session_uid for found in getattr(bpy.data, name)}
            for name in ("objects", "meshes", "armatures", "collections", "actions", "node_groups", "texts", "shape_keys")
        },
        "poses": {
            found.session_uid: [tuple(bone.rotation_euler) + tuple(bone.rotation_quaternion) for bone in found.pose.bones]
            for found in bpy.data.objects
            if found.type == "ARMATURE"
        },
    }


@pytest.fixture
def character(waving, tmp_path):
    """(mesh, rig, other mesh): a waving arm with a goal and a second skin, saved, at frame 3."""
    skin, rig = waving
    second, own_rig = make_arm("Second")
    second.modifiers["Armature"].object = second.parent = rig
    bpy.data.objects.remove(own_rig)
    bind(second)
    select(rig)
    bpy.ops.object.mode_set(mode="POSE")
    select_bones(rig, "lower")
    bpy.ops.sinew.add_goal()
    bpy.ops.object.mode_set(mode="OBJECT")
    select(rig)
    skin.sinew.skin.live = True
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "character.blend"))
    bpy.context.scene.frame_set(3)
    return skin, rig, second


@pytest.fixture(params=BAKES)
def started(request, character, monkeypatch):
    """(operator, window, state before): a long operator in a window, after two steps."""
    monkeypatch.setattr(stepped, "WORK_BETWEEN_EVENTS_S", 0.0)
    if request.param == "measure":
        select(character[0])
    before, window = state(), Window()
    operator = StandIn(request.param, in_window=True, **BAKES[request.param])
    assert operator.execute(window) == {"RUNNING_MODAL"}
    for _step in range(2):
        assert operator.modal(window, TIMER) == {"RUNNING_MODAL"}, operator.reports
    assert window.timers and window.is_progress_shown
    return operator, window, before


def test_escape(started):
    operator, window, before = started
    assert operator.modal(window, ESC) == {"CANCELLED"}
    assert state() == before and window.has_ended
    assert "canceled" in operator.reports[-1][1]


def test_a_closed_window(started):
    operator, window, before = started
    operator.cancel(window)
    assert state() == before and window.has_ended


def test_a_closed_window_without_a_workspace(started):
    operator, window, before = started
    window.workspace = None
    operator.cancel(window)
    assert state() == before and not window.timers and not window.is_progress_shown


def test_the_status_bar_shows_the_progress_and_the_way_out(started):
    operator, window, _before = started
    assert any(text and text.endswith("% - Esc cancels") for text in window.texts)
    while operator.modal(window, TIMER) == {"RUNNING_MODAL"}:
        pass
    assert window.has_ended and window.texts[-1] is None and operator.reports[-1][0] == "INFO"


@pytest.mark.parametrize("edit", ["rename", "delete"])
@pytest.mark.parametrize("edited", ["skin", "second", "rig"])
def test_an_object_renamed_or_deleted_meanwhile(started, character, edited, edit):
    operator, window, before = started
    skin, rig, second = character
    target = {"skin": skin, "rig": rig, "second": second}[edited]
    if edit == "rename":
        target.name = "Renamed"
    else:
        _forget(before, target)
        bpy.data.objects.remove(target)
    result = {"RUNNING_MODAL"}
    while result == {"RUNNING_MODAL"}:
        result = operator.modal(window, TIMER)
    assert window.has_ended
    level, text = operator.reports[-1]
    if result == {"FINISHED"}:  # what it works on was not touched
        assert level == "INFO"
        return
    assert result == {"CANCELLED"} and level == "ERROR" and "bake again" in text or "again" in text
    now = state()
    if edit == "delete":
        for name in before["data"]:
            assert now["data"][name] <= before["data"][name]
        del now["data"], before["data"]
    assert now == before


def _forget(before, target):
    """Removes what belongs to an object that is about to be deleted."""
    before["live"].pop(target.session_uid, None)
    before["poses"].pop(target.session_uid, None)
    before["selected"].discard(target.session_uid)
    if target.session_uid == before["mode"][0]:
        before["mode"] = None


def test_adjusting_the_last_operation_does_not_start_a_modal(character, monkeypatch):
    operator, window = StandIn("bake_shape_keys", in_window=True, **BAKES["bake_shape_keys"]), Window()
    assert operator.execute(window) == {"RUNNING_MODAL"}
    while operator.modal(window, TIMER) == {"RUNNING_MODAL"}:
        pass
    operator.tolerance = 0.5
    assert operator.execute(window) == {"FINISHED"}
    assert window.has_ended


@pytest.fixture
def growing(arm):
    """(operator, window, state before): a skin that grows in a window."""
    _skin, rig = arm
    add_muscle(rig, around=FLEXOR)
    rig.data.bones["lower"].name = "eye"
    select(rig)
    before, window = state(), Window()
    operator = StandIn("grow_skin")
    assert operator.invoke(window, None) == {"RUNNING_MODAL"}
    return operator, window, before


@pytest.mark.parametrize("close", [True, False])
def test_growing_ends_well(growing, close):
    operator, window, before = growing
    operator.modal(window, SimpleNamespace(type="MOUSEMOVE", value="NOTHING"))
    if close:
        operator.cancel(window)
    else:
        assert operator.modal(window, ESC) == {"CANCELLED"}
    assert state() == before and window.has_ended


def test_growing_shows_its_progress(growing):
    operator, window, _before = growing
    while operator.modal(window, TIMER) == {"RUNNING_MODAL"}:
        pass
    assert window.has_ended and any(text and "Esc cancels" in text for text in window.texts)


def test_growing_after_the_armature_was_deleted(growing):
    operator, window, _before = growing
    bpy.data.objects.remove(bpy.data.objects["Arm Rig"])
    result = {"RUNNING_MODAL"}
    while result == {"RUNNING_MODAL"}:
        result = operator.modal(window, TIMER)
    assert result == {"CANCELLED"} and operator.reports[-1][0] == "ERROR" and window.has_ended


@pytest.fixture
def reaching(arm):
    """(operator, window, rig, state before): a Reach that has moved the arm."""
    _skin, rig = arm
    bend(rig, 0.4)
    select(rig)
    bpy.ops.object.mode_set(mode="POSE")
    rig.data.bones.active = rig.data.bones["lower"]
    before, window = state(), Window()
    window.area = SimpleNamespace(type="VIEW_3D", tag_redraw=lambda: None)
    operator = StandIn("reach")
    assert operator.invoke(window, None) == {"RUNNING_MODAL"}
    operator._goal = rig.matrix_world @ rig.pose.bones["lower"].tail + type(rig.location)((0.0, 0.1, -0.2))
    operator._pull(window, rig)
    bpy.context.view_layer.update()
    assert state() != before
    return operator, window, rig, before


def test_reaching_in_a_window_that_is_closed(reaching):
    operator, window, _rig, before = reaching
    window.area = None
    operator.cancel(window)
    assert state() == before and window.texts[-1] is None


def test_reaching_in_an_area_that_is_lost(reaching):
    operator, window, _rig, before = reaching
    window.area = None
    assert operator.modal(window, TIMER) == {"CANCELLED"}
    assert state() == before and window.texts[-1] is None


@pytest.mark.parametrize("edit", ["rename", "delete", "mode"])
def test_reaching_with_an_armature_that_was_renamed_or_deleted(reaching, edit):
    operator, window, rig, before = reaching
    if edit == "rename":
        rig.name = "Renamed"
    elif edit == "mode":
        bpy.ops.object.mode_set(mode="OBJECT")
        before["mode"] = (rig.session_uid, "OBJECT")
    else:
        bpy.data.objects.remove(rig)
    assert operator.modal(window, TIMER) == {"CANCELLED"}
    assert window.texts[-1] is None
    if edit != "delete":
        assert state() == before


def test_a_canceled_bake_leaves_the_skin_live(character):
    skin, _rig, _second = character
    shown = evaluated_points(skin)
    operator, window = StandIn("bake_shape_keys", in_window=True, **BAKES["bake_shape_keys"]), Window()
    operator.execute(window)
    operator.modal(window, TIMER)
    operator.cancel(window)
    assert np.array_equal(evaluated_points(skin), shown)
