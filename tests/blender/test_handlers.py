# SPDX-License-Identifier: GPL-3.0-or-later
"""Sinew's handlers beside those of other add-ons: cleared lists, exceptions, deletions, any order, several windows."""

import itertools
import random
from types import SimpleNamespace

import bpy
import addon_utils
import numpy as np
import pytest
from bl_ext.user_default.sinew.live import handlers
from conftest import FLEXOR, add_muscle, armature_alone, bend, bind, evaluated_points, lifts, make_arm

LISTS = sorted({name for name, _handler in handlers._HANDLERS})
EXTENSION = "bl_ext.user_default.sinew"


@pytest.fixture
def enabled_again():
    """Enables Sinew after a test that disabled it or changed its handlers."""
    before = {name: list(getattr(bpy.app.handlers, name)) for name in LISTS}
    yield
    addon_utils.disable(EXTENSION)
    for name, registered in before.items():
        getattr(bpy.app.handlers, name)[:] = [handler for handler in registered if (name, handler) not in handlers._HANDLERS]
    addon_utils.enable(EXTENSION)


@pytest.mark.parametrize(
    "cleared", [[name] for name in LISTS] + [LISTS], ids=lambda names: names[0] if len(names) == 1 else "all"
)
def test_disabling_works_after_another_addon_cleared_the_handlers(bent, enabled_again, cleared, capfd):
    skin, _rig = bent
    alone = armature_alone(skin)
    for name in cleared:
        getattr(bpy.app.handlers, name).clear()
    addon_utils.disable(EXTENSION)
    assert "Traceback" not in capfd.readouterr().err
    bpy.context.view_layer.update()
    assert np.array_equal(evaluated_points(skin), alone)
    assert not any(handler in getattr(bpy.app.handlers, name) for name, handler in handlers._HANDLERS)
    assert not hasattr(bpy.types.Object, "sinew")


def test_disabling_works_after_a_class_was_unregistered(bent, enabled_again):
    skin, _rig = bent
    alone = armature_alone(skin)
    bpy.utils.unregister_class(bpy.types.SINEW_OT_bind)
    addon_utils.disable(EXTENSION)
    bpy.context.view_layer.update()
    assert np.array_equal(evaluated_points(skin), alone)
    assert not hasattr(bpy.types.Object, "sinew") and not hasattr(bpy.types, "SINEW_OT_unbind")


def test_cleared_handlers_return_with_the_next_file(bent, enabled_again, tmp_path):
    names = [found.name for found in bent]
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "bent.blend"))
    bpy.app.handlers.depsgraph_update_post.clear()
    bpy.app.handlers.frame_change_post.clear()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "bent.blend"))
    skin, rig = (bpy.data.objects[name] for name in names)
    before = evaluated_points(skin)
    bend(rig, 0.0)
    bend(rig, 1.2)
    assert np.array_equal(evaluated_points(skin), before) and lifts(skin).max() > 5e-4


@pytest.mark.parametrize("is_first", [True, False])
@pytest.mark.parametrize("name", LISTS)
def test_handlers_work_beside_one_that_raises(bent, tmp_path, name, is_first):
    skin, rig = bent
    before = evaluated_points(skin)

    def raises(*_):
        raise RuntimeError("another add-on")

    others = getattr(bpy.app.handlers, name)
    others.insert(0 if is_first else len(others), raises)
    try:
        bend(rig, 0.0)
        bpy.context.scene.frame_set(2)
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "bent.blend"), copy=True)
        bend(rig, 1.2)
    finally:
        others.remove(raises)
    assert np.array_equal(evaluated_points(skin), before)


def test_another_handler_may_delete_what_was_just_edited():
    arms = [make_arm(name) for name in "AB"]
    for skin, rig in arms:
        add_muscle(rig, around=FLEXOR)
        bind(skin)

    def deletes(*_):
        muscle = next((child for child in arms[0][1].children if child.type == "EMPTY"), None)
        if muscle:
            bpy.data.objects.remove(muscle)

    bpy.app.handlers.depsgraph_update_post.insert(0, deletes)
    try:
        for _skin, rig in arms:
            bend(rig, 1.2)
    finally:
        bpy.app.handlers.depsgraph_update_post.remove(deletes)
    assert lifts(arms[1][0]).max() > 5e-4 and lifts(arms[0][0]).max() < 1e-6


def test_handlers_can_be_called_in_any_order(bent):
    skin, rig = bent
    before = evaluated_points(skin)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    names = [handler for _name, handler in handlers._HANDLERS]
    orders = itertools.chain(itertools.permutations(dict.fromkeys(names), 2), [random.Random(0).choices(names, k=60)])
    for order in orders:
        for handler in order:
            handler(bpy.context.scene, depsgraph)
    bend(rig, 1.1)
    bend(rig, 1.2)
    assert np.array_equal(evaluated_points(skin), before)


def test_saving_restores_the_skins_of_all_windows(monkeypatch, tmp_path):
    skin, rig = make_arm()
    skin.sinew.skin.elastic = False
    muscle = add_muscle(rig, around=FLEXOR)
    bind(skin)
    bend(rig, 1.2)
    shown = evaluated_points(skin)
    first, second = bpy.context.scene, bpy.data.scenes.new("Second")
    for found in (skin, rig, muscle):
        for collection in found.users_collection:
            collection.objects.unlink(found)
        second.collection.objects.link(found)
    second.view_layers[0].update()
    depsgraph = second.view_layers[0].depsgraph
    windows = [SimpleNamespace(scene=scene, view_layer=scene.view_layers[0]) for scene in (first, second)]
    monkeypatch.setattr(handlers, "_windows", lambda: windows)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "two.blend"), copy=True)
    correction = np.empty((len(shown), 3), np.float32)
    skin.data.attributes["sinew_correction"].data.foreach_get("vector", correction.reshape(-1))
    assert np.abs(correction).max() > 5e-4  # before any update of the second scene
    second.view_layers[0].update()
    points = np.empty((len(shown), 3), np.float32)
    skin.evaluated_get(depsgraph).data.vertices.foreach_get("co", points.reshape(-1))
    assert np.array_equal(points, shown)
