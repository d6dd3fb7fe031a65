# SPDX-License-Identifier: GPL-3.0-or-later
"""Characters that are linked from another file and overridden."""

import bpy
import numpy as np
import pytest
from conftest import (
    FLEXOR,
    add_muscle,
    bend,
    bind,
    evaluated_points,
    lifts,
    link_character,
    make_arm,
    rest_points,
    save_character,
    select,
    set_bone,
)


@pytest.fixture
def library(tmp_path):
    """(path, points): a file with a bound character in the collection "Character", and its points at a bend of 1.2."""
    skin, rig = make_arm()
    add_muscle(rig, around=FLEXOR)
    bind(skin)
    bend(rig, 1.2)
    points = evaluated_points(skin)
    bend(rig, 0.0)
    path = str(tmp_path / "library.blend")
    save_character(path)
    return path, points


def test_an_override_is_live(library, tmp_path):
    path, points = library
    skin, rig = link_character(path)
    assert skin.data.library is not None
    bend(rig, 1.2)
    assert np.abs(evaluated_points(skin) - points).max() <= 1e-6
    bend(rig, 0.0)
    assert np.abs(evaluated_points(skin) - rest_points(skin)).max() <= 1e-6
    bend(rig, 1.2)
    shot = str(tmp_path / "shot.blend")
    bpy.ops.wm.save_as_mainfile(filepath=shot)
    bpy.ops.wm.open_mainfile(filepath=shot)
    skin = next(found for found in bpy.data.objects if found.type == "MESH" and found.override_library)
    assert np.abs(evaluated_points(skin) - points).max() <= 1e-6


def tissue_of(rig):
    return next(found for found in bpy.data.objects if found.type == "EMPTY" and found.parent == rig)


def test_the_muscles_of_an_override_and_of_a_linked_character_show_the_pose(library):
    path, _points = library
    _skin, rig = link_character(path)
    bend(rig, 1.2)
    shown = [np.array(tissue_of(rig).matrix_world)]
    bpy.ops.wm.open_mainfile(filepath=path)
    rig = bpy.data.objects["Arm Rig"]
    bend(rig, 1.2)
    rig.pose.bones["lower"].keyframe_insert("rotation_euler", frame=1)
    shown.append(np.array(tissue_of(rig).matrix_world))
    bpy.ops.wm.save_mainfile()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(path, link=True) as (_source, target):
        target.collections = ["Character"]
    bpy.context.scene.collection.children.link(target.collections[0])
    bpy.context.scene.frame_set(1)
    bpy.context.view_layer.update()
    linked = next(found for found in bpy.data.objects if found.type == "EMPTY")
    assert linked.library and linked.delta_scale.x > 1.01
    shown.append(np.array(linked.matrix_world))
    assert np.allclose(shown, shown[0], atol=1e-5)


def test_two_overrides_of_one_character_do_not_mix(library):
    from bl_ext.user_default.sinew.live import session

    path, _points = library
    skin, rig = link_character(path)
    twin, twin_rig = link_character(path)
    assert twin != skin and twin.data == skin.data
    bend(rig, 1.2)
    bend(twin_rig, 0.4)
    assert lifts(skin).max() > 5e-4 and session.reason(skin) == ""
    assert f"shares its mesh with {skin.name}" in session.reason(twin) and "single user" in session.reason(twin)
    shown = evaluated_points(twin)
    next(modifier for modifier in twin.modifiers if modifier.type == "NODES").show_viewport = False
    bpy.context.view_layer.update()
    assert np.array_equal(evaluated_points(twin), shown)


def overridden(tmp_path):
    """(mesh, rig): all objects, linked from a saved file and overridden."""
    library = str(tmp_path / "library.blend")
    save_character(library)
    return link_character(library)


def of_the_saved_shot(tmp_path):
    """The override of each type, after saving and opening the shot."""
    shot = str(tmp_path / "shot.blend")
    bpy.ops.wm.save_as_mainfile(filepath=shot)
    bpy.ops.wm.open_mainfile(filepath=shot)
    return {found.type: found for found in bpy.data.objects if found.override_library}


def test_bones_of_an_override_have_their_own_settings(bent, tmp_path):
    _skin, rig = bent
    set_bone(rig, "lower", muscle_influence=0.5)  # "upper" has no settings in the library
    skin, rig = overridden(tmp_path)
    before = evaluated_points(skin)
    assert rig.pose.bones["lower"].sinew.muscle_influence == 0.5
    set_bone(rig, "upper", muscle_influence=0.0, crease=0.25)
    after = evaluated_points(skin)
    assert np.abs(after - before).max() > 1e-4
    shot = of_the_saved_shot(tmp_path)
    own = shot["ARMATURE"].pose.bones["upper"].sinew
    assert (own.muscle_influence, own.crease) == (0.0, 0.25)
    assert np.abs(evaluated_points(shot["MESH"]) - after).max() <= 1e-6


@pytest.mark.parametrize(
    ("name", "value"), [("muscle_influence", 0.0), ("slack", 0.25), ("elastic", True), ("energy", "SPRINGS")]
)
def test_an_overridden_skin_has_its_own_settings(bent, tmp_path, name, value):
    skin, _rig = overridden(tmp_path)
    setattr(skin.sinew.skin, name, value)
    assert getattr(of_the_saved_shot(tmp_path)["MESH"].sinew.skin, name) == value


def test_an_overridden_muscle_has_its_own_tension(bent, tmp_path):
    overridden(tmp_path)
    next(found for found in bpy.data.objects if found.type == "EMPTY" and found.override_library).sinew.tissue.tension = 0.75
    assert of_the_saved_shot(tmp_path)["EMPTY"].sinew.tissue.tension == 0.75


# computed: from the Empty's transform, its parent, its constraint, an object or the selection
COMPUTED = {"semi_axes", "width_ratio", "offset", "origin_bone", "insertion_bone", "show_shaded", "active_tissue"}


def settings_of(group):
    """(group, property) of all settings of a kind, including nested groups."""
    for found in group.properties:
        if found.identifier in {"rna_type", "name"} | COMPUTED or (found.is_hidden and found.identifier != "growth"):
            continue
        yield group, found
        if found.type in {"POINTER", "COLLECTION"} and found.fixed_type.identifier.startswith("Sinew"):
            yield from settings_of(found.fixed_type)


def test_all_settings_of_a_user_can_be_overridden():
    of_objects, of_bones = (owner.bl_rna.properties["sinew"] for owner in (bpy.types.Object, bpy.types.PoseBone))
    assert of_objects.is_overridable and of_bones.is_overridable
    found = [*settings_of(of_objects.fixed_type), *settings_of(of_bones.fixed_type)]
    names = {f"{group.identifier}.{setting.identifier}" for group, setting in found}
    assert {"SinewRigSettings.mirror_x", "SinewGoalSettings.bone", "SinewGrowthSettings.faces", "SinewWrap.sphere"} <= names
    assert [f"{group.identifier}.{setting.identifier}" for group, setting in found if not setting.is_overridable] == []


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("rig.mirror_x", True), ("rig.show_bones", False), ("rig.show_empties", False), ("rig.show_attachments", True),
        ("goal.chain_length", 3), ("skin.growth.resolution", 64), ("tissue.skin_thickness", 0.0625),
    ],
)  # fmt: skip
def test_an_overridden_armature_has_its_own_settings(bent, tmp_path, path, value):
    _skin, rig = bent
    # nested groups are in the library's file if they are used
    rig.sinew.goal.rig, rig.sinew.skin.growth.faces, rig.sinew.tissue.skin_thickness = rig, 100, 0.125
    _skin, rig = overridden(tmp_path)
    owner, _, name = path.rpartition(".")
    setattr(rig.sinew.path_resolve(owner), name, value)
    assert of_the_saved_shot(tmp_path)["ARMATURE"].sinew.path_resolve(path) == value


def test_what_is_made_for_an_overridden_character_is_in_a_collection_that_can_hold_it(library):
    path, _points = library
    _skin, rig = link_character(path)
    select(tissue_of(rig))
    assert bpy.ops.sinew.add_via_point(bone="upper") == {"FINISHED"}
    select(rig)
    assert bpy.ops.sinew.add_tissue(kind="SPHERE", origin_bone="lower", name="Elbow") == {"FINISHED"}
    added = [found for found in bpy.data.objects if found.type == "EMPTY" and found.override_library is None]
    local = [found for found in added if found.library is None]
    assert len(local) == 2 and all(found.users_collection[0].override_library is None for found in local)


def test_an_overridden_skin_with_a_mesh_of_its_own_bakes_again(library):
    path, _points = library
    skin, rig = link_character(path)
    skin.data = skin.data.copy()
    bend(rig, 1.2)
    select(skin)
    for _again in range(2):
        assert bpy.ops.sinew.bake_correctives(joints="lower") == {"FINISHED"}
        baked = [key.name for key in skin.sinew.skin.baked_keys]
        assert len(baked) > 3 and baked == skin.data.shape_keys.key_blocks.keys()[1:]
    rig.sinew.rig.view = "MUSCLES"
    assert skin.hide_get()
    rig.sinew.rig.view = "SKIN"
    assert not skin.hide_get()
    select(rig)
    assert bpy.ops.sinew.remove() == {"FINISHED"}
    assert skin.data.shape_keys is None


def test_baked_keys_of_the_library_are_refused_in_words(tmp_path):
    skin, rig = make_arm()
    add_muscle(rig, around=FLEXOR)
    bind(skin)
    select(skin)
    bpy.ops.sinew.bake_correctives(joints="lower")
    path = str(tmp_path / "library.blend")
    save_character(path)
    skin, rig = link_character(path)
    skin.data = skin.data.copy()
    bend(rig, 1.2)
    select(skin)
    with pytest.raises(RuntimeError, match="Make the object local"):
        bpy.ops.sinew.bake_correctives(joints="lower")
    select(rig)
    assert bpy.ops.sinew.remove() == {"FINISHED"}
