# SPDX-License-Identifier: GPL-3.0-or-later
"""The views of a character: Skin, X-ray and Muscles. Each shows what it says and puts everything back."""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.display import anatomy_colours, ellipsoid_nodes, shaded, translucent_skin, views
from bl_ext.user_default.sinew.live import attachments, session
from bl_ext.user_default.sinew.operators import base
from bl_ext.user_default.sinew.scene import characters, tissue_empty
from conftest import add_muscle, bend, bind, evaluated_points, make_arm, select

KINDS = ("objects", "meshes", "materials", "node_groups", "collections")


def names_in_file():
    return {kind: sorted(found.name for found in getattr(bpy.data, kind)) for kind in KINDS}


def look(skin):
    """What decides how a mesh looks in viewports and renders."""
    return {
        "hidden": skin.hide_get(),
        "disabled": (skin.hide_viewport, skin.hide_render),
        "as": (skin.display_type, tuple(skin.color), skin.show_in_front),
        "slots": [(slot.link, slot.material.name if slot.material else "") for slot in skin.material_slots],
        "modifiers": [(found.name, found.show_viewport, found.show_render) for found in skin.modifiers],
    }


def evaluated_material(skin):
    """The material of the first face after all modifiers."""
    mesh = skin.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    return mesh.materials[mesh.polygons[0].material_index]


@pytest.fixture
def character(arm):
    skin, rig = arm
    add_muscle(rig, name="Biceps", around=-1.5)
    bpy.ops.sinew.add_tissue(kind="BONE", origin_bone="lower", name="Bone")
    skin.data.materials.append(bpy.data.materials.new("Own"))
    bpy.context.view_layer.update()
    return skin, rig


def test_xray_shows_muscles_and_a_translucent_skin(character):
    skin, rig = character
    rig.sinew.rig.view = "XRAY"
    bpy.context.view_layer.update()
    material = evaluated_material(skin)
    assert material.diffuse_color[3] < 0.5  # Solid shading
    assert material.surface_render_method == "BLENDED"  # the other shadings
    assert material.node_tree.nodes["Principled BSDF"].inputs["Alpha"].is_linked
    assert len(shaded.find(rig).data.vertices) > 3
    assert skin.data.materials[0].name == "Own"


def test_the_view_muscles_hides_the_skin(character):
    skin, rig = character
    rig.sinew.rig.view = "MUSCLES"
    assert skin.hide_get() and shaded.find(rig)
    rig.sinew.rig.view = "SKIN"
    assert not skin.hide_get() and shaded.find(rig) is None


@pytest.mark.parametrize("path", [("XRAY",), ("MUSCLES",), ("XRAY", "MUSCLES"), ("MUSCLES", "XRAY")])
def test_the_view_skin_puts_everything_back(character, path):
    skin, rig = character
    bind(skin)
    before, in_file = look(skin), names_in_file()
    for view in path:
        rig.sinew.rig.view = view
        bend(rig, 1.0)
    rig.sinew.rig.view = "SKIN"
    assert look(skin) == before and names_in_file() == in_file


def test_a_mesh_that_the_user_hid_stays_hidden(character):
    skin, rig = character
    skin.hide_set(True)
    rig.sinew.rig.view = "MUSCLES"
    rig.sinew.rig.view = "SKIN"
    assert skin.hide_get()


def test_removing_sinew_removes_the_view(arm):
    skin, rig = arm
    before, in_file = look(skin), names_in_file()
    for view in ("XRAY", "MUSCLES"):
        add_muscle(rig)
        bind(skin)
        rig.sinew.rig.view = view
        select(rig)
        bpy.ops.sinew.remove()
        assert look(skin) == before and names_in_file() == in_file, view


@pytest.mark.parametrize("view", ["XRAY", "MUSCLES"])
def test_a_saved_file_shows_the_skin_without_sinew(character, tmp_path, view):
    skin, rig = character
    bind(skin)
    rig.sinew.rig.view = view
    seen = look(skin)
    path = str(tmp_path / "a.blend")
    in_file = []
    bpy.app.handlers.save_pre.append(saving := lambda *_: in_file.append(look(bpy.data.objects["Arm"])))
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.app.handlers.save_pre.remove(saving)
    assert not in_file[0]["hidden"]
    assert not any(shown for name, shown, _ in in_file[0]["modifiers"] if name == translucent_skin.MODIFIER)
    assert look(skin) == seen  # after saving the view is as before
    bpy.ops.wm.open_mainfile(filepath=path)
    skin, rig = bpy.data.objects["Arm"], bpy.data.objects["Arm Rig"]
    assert views.of(rig) == view and look(skin) == seen
    bpy.context.view_layer.update()
    assert len(shaded.find(rig).data.vertices) > 3
    rig.sinew.rig.view = "SKIN"
    assert not skin.hide_get() and translucent_skin.modifier_of(skin) is None


def test_the_view_can_be_undone(character):
    bpy.ops.ed.undo_push(message="before")
    bpy.data.objects["Arm Rig"].sinew.rig.view = "XRAY"
    bpy.ops.ed.undo_push(message="view")
    bpy.ops.ed.undo()
    assert views.of(bpy.data.objects["Arm Rig"]) == "SKIN"
    assert translucent_skin.modifier_of(bpy.data.objects["Arm"]) is None
    bpy.ops.ed.redo()
    assert translucent_skin.modifier_of(bpy.data.objects["Arm"])


def test_xray_does_not_change_the_skin_or_what_is_rendered(character):
    skin, rig = character
    bind(skin)
    bend(rig, 1.0)
    before = evaluated_points(skin)
    rig.sinew.rig.view = "XRAY"
    bpy.context.view_layer.update()
    assert np.array_equal(evaluated_points(skin), before)
    assert not translucent_skin.modifier_of(skin).show_render and shaded.find(rig).hide_render


def test_two_characters_have_their_own_views(character):
    skin, rig = character
    other_skin, other = make_arm("Other")
    add_muscle(other, name="Foreign")
    rig.sinew.rig.view = "XRAY"
    assert views.of(other) == "SKIN" and translucent_skin.modifier_of(other_skin) is None
    other.sinew.rig.view = "XRAY"
    rig.sinew.rig.view = "SKIN"
    bpy.context.view_layer.update()
    assert evaluated_material(other_skin).diffuse_color[3] < 0.5
    assert evaluated_material(skin).name == "Own"


def test_the_first_tissues_are_seen_at_once_in_a_window(arm, monkeypatch):
    _skin, rig = arm
    monkeypatch.setattr(base, "is_in_window", lambda: True)
    add_muscle(rig, name="A")
    assert views.of(rig) == "XRAY" and not rig.sinew.rig.show_empties
    rig.sinew.rig.view = "SKIN"
    bpy.context.view_layer.update()
    add_muscle(rig, name="B")
    assert views.of(rig) == "SKIN"  # only the first tissues change the view


def test_a_script_keeps_the_view(arm):
    _skin, rig = arm
    add_muscle(rig)
    assert views.of(rig) == "SKIN"


def test_a_mesh_that_joins_the_character_is_shown_as_the_others(character):
    skin, rig = character
    rig.sinew.rig.view = "XRAY"
    coat = skin.copy()
    coat.data = skin.data.copy()
    for modifier in [found for found in coat.modifiers if found.type == "NODES"]:
        coat.modifiers.remove(modifier)
    bpy.context.scene.collection.objects.link(coat)
    bind(coat)
    assert translucent_skin.modifier_of(coat)


def test_bellies_are_red_tendons_pale_and_bones_ivory(character):
    _skin, rig = character
    rig.sinew.rig.view = "XRAY"
    bpy.context.view_layer.update()
    mesh = shaded.find(rig).data
    shapes = np.empty(len(mesh.vertices), np.int32)
    mesh.attributes[ellipsoid_nodes.SHAPE].data.foreach_get("value", shapes)
    counts = np.bincount(shapes - ellipsoid_nodes.FIRST_OF_ANATOMY, minlength=6)
    assert counts[anatomy_colours.BELLY] == 1 and counts[anatomy_colours.TENDON] == 2 and counts[anatomy_colours.BONE] == 3
    red, pale = (anatomy_colours.colour_of(number) for number in (anatomy_colours.BELLY, anatomy_colours.TENDON))
    assert red[0] > 5 * max(red[1:3]) and min(pale[:3]) > 0.5


@pytest.mark.parametrize("angle", [0.0, 1.2])
def test_tendons_connect_attachments_and_bellies(character, angle):
    _skin, rig = character
    rig.sinew.rig.view = "XRAY"
    bend(rig, angle)
    state = session.cached_rig(rig)
    state.musculature.pose(state.pose, state.tension, state.posed)
    tubes = attachments.tendons_of(rig, state)
    belly = state.posed[state.solved.index(characters.tissues_of(rig).index(bpy.data.objects["Biceps"]))]
    shape = tissue_empty.read(bpy.data.objects["Biceps"], rig)
    for tube, bone, point in zip(tubes, ("upper", "lower"), (shape.origin, shape.insertion)):
        posed_bone = rig.pose.bones[bone]
        wanted = posed_bone.matrix @ posed_bone.bone.matrix_local.inverted() @ point
        assert np.abs(tube[3, :3] - np.array(wanted)).max() < 1e-5
        end_in_belly = np.append(tube[3, :3] + tube[2, :3], 1.0) @ np.linalg.inv(belly)
        assert np.linalg.norm(end_in_belly[:3]) < 0.9


def test_tendons_of_curved_muscles_follow_their_paths(human):
    human.sinew.rig.view = "MUSCLES"
    bpy.context.view_layer.update()
    state = session.cached_rig(human)
    state.musculature.pose(state.pose, state.tension, state.posed)
    tubes = attachments.tendons_of(human, state)
    pieces = np.hstack((tubes[:, 3, :3], tubes[:, 3, :3] + tubes[:, 2, :3]))
    points, offsets = state.musculature.path_points(state.pose)
    paths = [points[first:last] for first, last in zip(offsets, offsets[1:]) if last - first > 2]
    assert len(paths) > 20

    def is_shown(path):
        """Whether each piece of a path that has a length is shown."""
        path = path[np.append(True, np.linalg.norm(np.diff(path, axis=0), axis=1) > 1e-6)]
        wanted = np.hstack((path[:-1], path[1:]))
        return (np.abs(wanted[:, None] - pieces).max(axis=2) < 1e-5).any(axis=1)

    shown = [is_shown(path) for path in paths]
    # each tendon is shown from the bone on, and the pieces inside bellies are left out
    assert all(of_path[0] and of_path[-1] for of_path in shown)
    assert np.mean(np.concatenate(shown)) < 0.7


def test_an_export_copy_has_the_materials_of_the_mesh(character):
    skin, rig = character
    bind(skin)
    rig.sinew.rig.view = "XRAY"
    select(rig)
    bpy.ops.sinew.bake_bones(frame_start=1, frame_end=2)
    copies = [found for found in rig.sinew.rig.export_copy.objects if found.type == "MESH"]
    assert copies and not any(translucent_skin.modifier_of(copy) for copy in copies)
    assert translucent_skin.modifier_of(skin)


def test_an_added_tissue_is_chosen_and_pose_mode_stays(arm, monkeypatch):
    _skin, rig = arm
    select(rig)
    bpy.ops.object.mode_set(mode="POSE")
    monkeypatch.setattr(base, "is_in_window", lambda: True)
    bpy.ops.sinew.add_tissue(kind="MUSCLE", origin_bone="upper", insertion_bone="lower", name="New")
    assert rig.mode == "POSE" and rig.sinew.rig.chosen == "New" and views.of(rig) == "XRAY"
    assert not bpy.data.objects["New"].hide_get()
