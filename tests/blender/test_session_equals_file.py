# SPDX-License-Identifier: GPL-3.0-or-later
"""After any edit, the skins of the session equal those of the saved file: nothing stays from before the edit."""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.live import session
from conftest import (
    FLEXOR,
    add_muscle,
    armature_alone,
    bend,
    bind,
    evaluated_points,
    lifts,
    make_arm,
    rest_points,
    select,
)


@pytest.fixture
def equals_file(tmp_path):
    """A function that compares all meshes, and their reasons, with the file opened again. All references end."""

    def compare():
        bpy.context.view_layer.update()
        shown, reasons = _all_meshes()
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "session.blend"))
        bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "session.blend"))
        bpy.context.view_layer.update()
        fresh, fresh_reasons = _all_meshes()
        assert reasons == fresh_reasons
        assert {name: np.abs(points - fresh[name]).max() for name, points in shown.items()} == dict.fromkeys(fresh, 0.0)

    return compare


def _all_meshes():
    skins = [found for found in bpy.context.view_layer.objects if found.type == "MESH"]
    return {skin.name: evaluated_points(skin) for skin in skins}, {skin.name: session.reason(skin) for skin in skins}


@pytest.fixture
def elbow():
    """(mesh, rig): a bound, bent arm with elastic skin."""
    skin, rig = make_arm()
    add_muscle(rig, around=FLEXOR)
    bind(skin)
    bend(rig, 1.2)
    return skin, rig


def other_rig(has_muscle):
    skin, rig = make_arm("Other")
    if has_muscle:
        add_muscle(rig, around=-FLEXOR)
    bpy.data.objects.remove(skin)
    bend(rig, 0.9)
    return rig


@pytest.mark.parametrize("has_muscle", [True, False])
def test_a_skin_moved_to_another_armature(elbow, equals_file, has_muscle):
    skin, _rig = elbow
    other = other_rig(has_muscle)
    skin.parent = other
    skin.modifiers["Armature"].object = other
    bpy.context.view_layer.update()
    assert (lifts(skin).max() > 1e-4) == has_muscle
    assert ("has no muscles" in session.reason(skin)) != has_muscle
    equals_file()


@pytest.mark.parametrize("then", ["update", "frame"])
def test_a_skin_without_its_armature_and_with_it_again(elbow, equals_file, then):
    skin, rig = elbow
    shown = evaluated_points(skin)
    for armature in (None, rig):
        skin.parent = armature
        skin.modifiers["Armature"].object = armature
        bpy.context.scene.frame_set(2) if then == "frame" else bpy.context.view_layer.update()
        if armature is None:
            assert np.array_equal(evaluated_points(skin), rest_points(skin))
            assert "follows no armature" in session.reason(skin)
        else:
            assert np.array_equal(evaluated_points(skin), shown) and session.reason(skin) == ""
    equals_file()


def test_a_skin_whose_parent_alone_changed(elbow, equals_file):
    skin, _rig = elbow
    other = other_rig(True)
    skin.modifiers.remove(skin.modifiers["Armature"])
    bpy.context.view_layer.update()
    skin.parent = other
    bpy.context.view_layer.update()
    equals_file()


def test_a_muscle_moved_to_another_armature(elbow, equals_file):
    skin, rig = elbow
    other, second_rig = make_arm("Other")
    add_muscle(second_rig, name="Second", around=-FLEXOR)
    bind(other)
    bend(second_rig, 1.0)
    before = evaluated_points(other)
    muscle = bpy.data.objects["Muscle lower"]
    placed = muscle.matrix_parent_inverse.copy()
    muscle.parent = second_rig
    muscle.matrix_parent_inverse = placed
    bpy.context.view_layer.update()
    assert lifts(skin).max() < 1e-6 and "no muscles" in session.reason(skin)
    assert np.abs(evaluated_points(other) - before).max() > 1e-4
    equals_file()


def test_a_skin_with_another_mesh(elbow, equals_file):
    skin, _rig = elbow
    skin.data = skin.data.copy()
    bpy.context.view_layer.update()
    skin.data.vertices[200].co.z += 0.01
    bpy.context.view_layer.update()
    skin.vertex_groups["upper"].add(range(200, 240), 1.0, "REPLACE")
    skin.data.update()
    equals_file()


def test_faces_alone_deleted(elbow, equals_file):
    import bmesh

    skin, _rig = elbow
    for edit in ("script", "Edit Mode"):
        if edit == "Edit Mode":
            select(skin)
            bpy.ops.object.mode_set(mode="EDIT")
            editing = bmesh.from_edit_mesh(skin.data)
        else:
            editing = bmesh.new()
            editing.from_mesh(skin.data)
        faces = [face for face in editing.faces if 0.25 < face.calc_center_median().x < 0.35 and face.normal.z > 0.2]
        counts = len(editing.verts), len(editing.edges)
        bmesh.ops.delete(editing, geom=faces[: len(faces) // 2], context="FACES_ONLY")
        assert counts == (len(editing.verts), len(editing.edges)) and len(faces) > 4
        if edit == "Edit Mode":
            bmesh.update_edit_mesh(skin.data)
            bpy.ops.object.mode_set(mode="OBJECT")
        else:
            editing.to_mesh(skin.data)
            editing.free()
        bpy.context.view_layer.update()
    assert lifts(skin).max() > 5e-4
    equals_file()


def test_edges_rotated(elbow, equals_file):
    import bmesh

    skin, _rig = elbow
    editing = bmesh.new()
    editing.from_mesh(skin.data)
    edges = [edge for edge in editing.edges if all(0.2 < vertex.co.x < 0.4 for vertex in edge.verts)]
    counts = len(editing.verts), len(editing.edges), len(editing.faces)
    bmesh.ops.rotate_edges(editing, edges=edges[::3])
    assert counts == (len(editing.verts), len(editing.edges), len(editing.faces))
    editing.to_mesh(skin.data)
    editing.free()
    equals_file()


def test_the_eye_of_the_armature_modifier(elbow, equals_file):
    skin, _rig = elbow
    shown = evaluated_points(skin)
    skin.modifiers["Armature"].show_viewport = False
    bpy.context.view_layer.update()
    assert np.array_equal(evaluated_points(skin), rest_points(skin))
    skin.modifiers["Armature"].show_viewport = True
    bpy.context.view_layer.update()
    assert np.array_equal(evaluated_points(skin), shown)
    skin.modifiers["Armature"].show_viewport = False
    equals_file()


@pytest.mark.parametrize("setting", ["use_deform_preserve_volume", "use_vertex_groups", "use_bone_envelopes"])
def test_settings_of_the_armature_modifier(elbow, equals_file, setting):
    skin, _rig = elbow
    modifier = skin.modifiers["Armature"]
    setattr(modifier, setting, not getattr(modifier, setting))
    equals_file()


def test_the_correction_attribute_deleted(elbow, equals_file):
    skin, _rig = elbow
    shown = evaluated_points(skin)
    skin.data.attributes.active = skin.data.attributes["sinew_correction"]
    select(skin)
    bpy.ops.geometry.attribute_remove()
    bpy.context.view_layer.update()
    assert np.array_equal(evaluated_points(skin), shown)
    equals_file()


def linked_duplicate(skin):
    select(skin)
    bpy.ops.object.duplicate(linked=True)
    return bpy.context.object


def test_a_moved_linked_duplicate_leaves_the_original_live(elbow, equals_file):
    skin, rig = elbow
    shown, alone = evaluated_points(skin), armature_alone(skin)
    twin = linked_duplicate(skin)
    bpy.context.view_layer.update()
    assert np.array_equal(evaluated_points(twin), shown) and session.reason(twin) == ""
    twin.location.x += 0.5
    bpy.context.view_layer.update()
    assert np.array_equal(evaluated_points(skin), shown) and session.reason(skin) == ""
    assert "single user" in session.reason(twin) and skin.name in session.reason(twin)
    twin.location.x -= 0.5
    bpy.context.view_layer.update()
    assert np.array_equal(evaluated_points(twin), shown) and session.reason(twin) == ""
    twin.location.x += 0.5
    bend(rig, 0.0)
    bend(rig, 1.2)
    assert np.array_equal(evaluated_points(skin), shown) and not np.array_equal(shown, alone)
    equals_file()


def test_a_linked_duplicate_without_armature_leaves_the_original_live(elbow, equals_file, capfd):
    skin, rig = elbow
    shown = evaluated_points(skin)
    twin = linked_duplicate(skin)
    twin.parent = twin.modifiers["Armature"].object = None
    for angle in (0.4, 1.2):
        bend(rig, angle)
    assert "Traceback" not in capfd.readouterr().err
    assert np.array_equal(evaluated_points(skin), shown)
    assert "follows no armature" in session.reason(twin)
    assert np.array_equal(evaluated_points(twin), rest_points(twin))
    equals_file()


def test_a_mesh_is_bound_again_beside_a_linked_duplicate_without_armature(elbow):
    skin, _rig = elbow
    shown = evaluated_points(skin)
    twin = linked_duplicate(skin)
    twin.parent = twin.modifiers["Armature"].object = None
    bind(skin)
    assert np.array_equal(evaluated_points(skin), shown)


def two_rigs_on_one_mesh(skin):
    rig = other_rig(True)
    twin = linked_duplicate(skin)
    twin.parent = twin.modifiers["Armature"].object = rig
    bpy.context.view_layer.update()
    return twin, rig


def test_one_mesh_on_two_armatures_leaves_the_original_live(elbow, equals_file):
    skin, rig = elbow
    shown = evaluated_points(skin)
    twin, second_rig = two_rigs_on_one_mesh(skin)
    bend(second_rig, 1.1)
    assert np.array_equal(evaluated_points(skin), shown) and session.reason(skin) == ""
    assert "single user" in session.reason(twin)
    assert np.array_equal(evaluated_points(twin), armature_alone_of_hidden(twin))
    equals_file()


def armature_alone_of_hidden(twin):
    """The points of a mesh object without its Sinew modifier, which is off."""
    modifier = next(modifier for modifier in twin.modifiers if modifier.type == "NODES")
    assert not modifier.show_viewport and not modifier.show_render
    return evaluated_points(twin)


def test_one_mesh_on_two_armatures_made_a_single_user(elbow, equals_file):
    skin, _rig = elbow
    shown = evaluated_points(skin)
    twin, _second_rig = two_rigs_on_one_mesh(skin)
    twin.data = twin.data.copy()
    bpy.context.view_layer.update()
    assert lifts(twin).max() > 5e-4 and session.reason(twin) == ""
    assert np.array_equal(evaluated_points(skin), shown)
    equals_file()


def test_one_mesh_on_two_armatures_when_the_first_is_removed(elbow, equals_file):
    skin, _rig = elbow
    twin, _second_rig = two_rigs_on_one_mesh(skin)
    bpy.data.objects.remove(skin)
    bpy.context.view_layer.update()
    assert lifts(twin).max() > 5e-4 and session.reason(twin) == ""
    equals_file()


def test_a_failure_of_the_second_armature_leaves_the_original_live(elbow, equals_file):
    skin, _rig = elbow
    shown = evaluated_points(skin)
    twin, second_rig = two_rigs_on_one_mesh(skin)
    second_rig.data.bones["lower"].bbone_segments = 3
    second_rig.pose.bones["lower"].scale = (0.0, 1.0, 1.0)
    bpy.context.view_layer.update()
    assert np.array_equal(evaluated_points(skin), shown)
    assert "scale of 0" in session.reason(twin)


def test_a_skin_that_failed_while_it_was_live(elbow, equals_file):
    skin, _rig = elbow
    skin.modifiers.move(skin.modifiers.find("Sinew"), 1)
    bpy.context.view_layer.update()
    assert "below" in session.reason(skin)
    skin.sinew.skin.live = False
    equals_file()


def test_a_skin_that_is_not_live_has_no_correction_although_its_modifier_is_on(elbow, equals_file):
    skin, _rig = elbow
    skin.sinew.skin.live = False
    skin.modifiers["Sinew"].show_viewport = True
    bpy.context.view_layer.update()
    assert lifts(skin).max() == 0.0
    equals_file()


def test_a_skin_without_an_armature_is_the_last_of_its_file(elbow, equals_file):
    skin, rig = elbow
    bpy.data.objects.remove(rig)
    bpy.context.view_layer.update()
    assert "follows no armature" in session.reason(skin)
    skin.name = "Renamed"
    bpy.context.view_layer.update()
    assert session.reason(skin).startswith("Renamed")
    equals_file()


def test_a_setting_of_a_tissue_in_an_excluded_collection(elbow, equals_file):
    _skin, rig = elbow
    tissue = next(found for found in rig.children if found.type == "EMPTY")
    layer = bpy.context.view_layer.layer_collection.children[tissue.users_collection[0].name]
    layer.exclude = True
    bpy.context.view_layer.update()
    tissue.sinew.tissue.volume_keeping = 0.0
    equals_file()


def test_an_armature_whose_bones_are_edited_through_another_object(elbow):
    skin, rig = elbow
    shown = evaluated_points(skin)
    twin = bpy.data.objects.new("Twin", rig.data)
    bpy.context.scene.collection.objects.link(twin)
    select(twin)
    bpy.ops.object.mode_set(mode="EDIT")
    twin.data.edit_bones.new("third").tail = (0.0, 0.0, 0.1)
    bpy.context.view_layer.update()
    assert session.reason(skin) == ""
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    assert session.reason(skin) == "" and np.allclose(evaluated_points(skin), shown, atol=1e-5)


def test_a_renamed_armature_whose_muscles_have_problems(elbow, equals_file):
    """The texts of the problems name the armature."""
    skin, rig = elbow
    rig.data.bones["upper"].name = "elsewhere"
    for tissue in bpy.data.objects:
        if tissue.type == "EMPTY":
            tissue.sinew.tissue.insertion_bone = "nowhere"
    bpy.context.view_layer.update()
    rig.name = "Renamed"
    bpy.context.view_layer.update()
    assert "Renamed" in session.reason(skin)
    equals_file()
