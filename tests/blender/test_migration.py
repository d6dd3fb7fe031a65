# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of Sinew 0.1, which had all settings of an object in one group, as this version opens them.

`files/make_files.py` wrote them with Sinew 0.1, once in each Blender.
"""

import shutil
import warnings
from pathlib import Path

import bpy
import numpy as np
import pytest
from bl_ext.user_default.sinew.live import session
from bl_ext.user_default.sinew.scene import painted_data, stored_settings
from bl_ext.user_default.sinew.settings import migration, old_names
from conftest import add_muscle, bend, bind, evaluated_points, make_arm

FILES = Path(__file__).with_name("files")
FRAMES = (1, 6, 12)
BLENDERS = [version for version in ("4.5", "5.2") if tuple(map(int, version.split("."))) <= bpy.app.version[:2]]
SAME_M = 1e-5


@pytest.fixture(params=BLENDERS)
def written_by(request, tmp_path):
    """The version of Blender that wrote the files, which are copied to `tmp_path`."""
    for path in FILES.glob(f"*_blender_{request.param}.*"):
        shutil.copy(path, tmp_path)
    return request.param


def open_file(tmp_path, kind, version):
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / f"{kind}_0.1_blender_{version}.blend"))
    return np.load(tmp_path / f"shown_0.1_blender_{version}.npz")


def values_of(group):
    """All values that are set in a group of settings, with the groups and collections inside of it."""
    values = {}
    for known in group.bl_rna.properties:
        name = known.identifier
        if name == "rna_type" or not group.is_property_set(name):
            continue
        value = getattr(group, name)
        if known.type == "COLLECTION":
            value = [values_of(item) for item in value]
        elif known.type == "POINTER":
            value = value.name if isinstance(value, bpy.types.ID) else values_of(value)
        elif known.type == "FLOAT":
            value = pytest.approx(value, rel=1e-6) if not known.is_array else tuple(value)
        values[name] = value
    return values


# all that `make_files.py` sets
SETTINGS = {
    "Arm": {
        "skin": {
            "bound": True, "live": True, "motion_source": "FULL", "scale_fat": True, "falloff": 0.0625, "iterations": 8,
            "anchor_stiffness": 0.75, "edge_stiffness": 1.5, "slack": 0.015625, "fat_sliding": 0.25,
            "contacts": False, "quality_text": "Arm Quality", "quality_summary": "stretch 1.25",
            "corrective_summary": "lower: 2 keys", "cache_modifier": 0, "muscle_influence": 1.5,
        },
    },
    "Arm Rig": {
        "rig": {
            "shaded": "Arm Rig Shaded Muscles", "mirror_x": True, "show_attachments": True, "show_bones": False,
            "show_spheres": False, "export_copy": "Arm Rig Export",
        },
    },
    "Ball": {"tissue": {"kind": "SPHERE", "disabled_by_layer": True, "skin_thickness": 0.0}},
    "Shaft": {"tissue": {"kind": "BONE", "disabled_by_layer": True}},
    "Flexor": {
        "tissue": {
            "kind": "MUSCLE", "origin_tendon": pytest.approx(0.03), "insertion_tendon": pytest.approx(0.02),
            "volume_keeping": 0.75, "skin_thickness": 0.0078125,
        },
    },
    "Extensor": {"tissue": {"kind": "MUSCLE", "wraps": [{"sphere": "Ball"}]}},
    "Extensor via": {"tissue": {"kind": "VIA", "muscle": "Extensor", "order": 3}},
    "Hand Goal": {
        "goal": {
            "rig": "Arm Rig", "bone": "lower", "at_tail": False, "chain_length": 2, "position_weight": 0.5,
            "orientation_weight": 0.25, "look_at_weight": 0.125, "look_axis": "-Z",
        },
    },
    "Grown": {
        "skin": {
            "bound": True, "live": False, "anchoring": "NEAREST", "energy": "SPRINGS",
            "growth": {
                "is_grown": True, "resolution": 48, "thickness": 0.0078125, "faces": 400, "symmetric": False,
            },
            "baked_keys": [
                {"name": "walk0001", "muted_by_sinew": True}, {"name": "walk0007", "muted_by_sinew": True},
                {"name": "run0001"}, {"name": "run0007"},
            ],
        },
    },
}  # fmt: skip


def assert_within(expected, found, path):
    """Every expected value is there; more may be set."""
    for name, value in expected.items():
        assert name in found, f"{path}.{name}"
        if isinstance(value, dict):
            assert_within(value, found[name], f"{path}.{name}")
        else:
            assert found[name] == value, f"{path}.{name}"


def state_of_the_file():
    """All settings, paths and painted names, to compare two states of a file."""
    objects = {found.name: values_of(found.sinew) for found in bpy.data.objects if found.is_property_set("sinew")}
    bones = {
        (rig.name, bone.name): values_of(bone.sinew)
        for rig in bpy.data.objects
        if rig.type == "ARMATURE"
        for bone in rig.pose.bones
        if bone.is_property_set("sinew")
    }
    attributes = {mesh.name: sorted(mesh.attributes.keys()) for mesh in bpy.data.meshes}
    groups = {found.name: found.vertex_groups.keys() for found in bpy.data.objects if found.type == "MESH"}
    return objects, bones, sorted(paths_of_the_file()), attributes, groups


def paths_of_the_file():
    for action in bpy.data.actions:
        for layer in action.layers:
            for strip in layer.strips:
                for bag in strip.channelbags:
                    yield from (curve.data_path for curve in bag.fcurves)
    for found in bpy.data.objects:
        for curve in found.animation_data.drivers if found.animation_data else ():
            yield curve.data_path
            yield from (target.data_path for variable in curve.driver.variables for target in variable.targets)


def points_at(frame, name):
    bpy.context.scene.frame_set(frame)
    bpy.context.view_layer.update()
    return evaluated_points(bpy.data.objects[name])


def test_every_setting_arrives(written_by, tmp_path):
    open_file(tmp_path, "arm", written_by)
    for name, expected in SETTINGS.items():
        assert_within(expected, values_of(bpy.data.objects[name].sinew), name)
    lower = bpy.data.objects["Arm Rig"].pose.bones["lower"].sinew
    assert (lower.eagerness, lower.slack, lower.anchor_stiffness, lower.crease) == (0.5, 2.0, 1.25, 0.75)
    assert all(found.sinew.version == 2 for found in bpy.data.objects if found.is_property_set("sinew"))
    assert not migration.notices()
    for found in bpy.data.objects:
        root = stored_settings.properties_of(found)
        stored = set(root["sinew"].keys()) if root and "sinew" in root else set()
        assert stored <= {"version", "tissue", "skin", "rig", "goal"}


def test_keys_strips_and_drivers_use_the_new_paths(written_by, tmp_path):
    open_file(tmp_path, "arm", written_by)
    assert {path for path in paths_of_the_file() if "sinew" in path} == {
        "sinew.tissue.tension", "sinew.skin.muscle_influence", "sinew.tissue.volume_keeping", "sinew.goal.position_weight",
        'pose.bones["lower"].sinew.slack',
    }  # fmt: skip
    flexor, extensor, skin = (bpy.data.objects[name] for name in ("Flexor", "Extensor", "Arm"))
    for frame, keyed, in_strip in ((1, 0.0, 1.0), (12, 1.0, 0.25)):
        bpy.context.scene.frame_set(frame)
        assert flexor.sinew.tissue.tension == pytest.approx(keyed, abs=1e-6)
        assert extensor.sinew.tissue.tension == pytest.approx(in_strip, abs=1e-6)
    flexor.sinew.tissue.volume_keeping = 0.5
    bpy.context.view_layer.update()
    assert skin.sinew.skin.muscle_influence == pytest.approx(1.0)
    assert skin.animation_data.drivers[0].is_valid and skin.animation_data.drivers[0].driver.is_valid


def test_what_was_painted_is_renamed_and_read(written_by, tmp_path):
    open_file(tmp_path, "arm", written_by)
    skin, grown = bpy.data.objects["Arm"], bpy.data.objects["Grown"]
    assert "sinew_slack" in skin.data.attributes and "sinew_rest_distance" not in skin.data.attributes
    assert "sinew_slack" in grown.vertex_groups and "sinew_rest_distance" not in grown.vertex_groups
    assert np.allclose(painted_data.read(skin)["slack"], np.linspace(0.0, 2.0, len(skin.data.vertices)))
    assert (painted_data.read(grown)["slack"] == 0.5).all()


def test_former_painted_names_are_read():
    skin, _rig = make_arm()
    skin.data.attributes.new("sinew_rest_distance", "FLOAT", "POINT")
    assert (painted_data.read(skin)["slack"] == 0.0).all()
    painted_data.remove_all(skin)
    assert "sinew_rest_distance" not in skin.data.attributes


def assert_same_skin(frame, name, shown):
    """The skin is where it was.

    *Collide with Tissues*, which the arm had, is removed: it moved few of its 480 vertices, by 0.67 mm at most.
    """
    moved_m = np.linalg.norm(points_at(frame, name) - shown[f"{name}_{frame}"], axis=1)
    collided = moved_m >= SAME_M
    assert not collided.any() or (name == "Arm" and collided.mean() < 0.02 and moved_m.max() < 7e-4), (name, frame)


def test_the_skin_is_where_it_was(written_by, tmp_path):
    shown = open_file(tmp_path, "arm", written_by)
    for frame in FRAMES:
        for name in ("Arm", "Grown"):
            assert_same_skin(frame, name, shown)
    assert np.abs(shown["Arm_12"] - shown["Arm_1"]).max() > 0.1


def test_a_second_load_changes_nothing(written_by, tmp_path):
    shown = open_file(tmp_path, "arm", written_by)
    migrated = state_of_the_file()
    migration.migrate()
    assert state_of_the_file() == migrated
    path = str(tmp_path / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert state_of_the_file() == migrated
    assert_same_skin(12, "Arm", shown)


def test_an_appended_character_is_migrated(written_by, tmp_path):
    shown = np.load(tmp_path / f"shown_0.1_blender_{written_by}.npz")
    path = str(tmp_path / f"arm_0.1_blender_{written_by}.blend")
    with bpy.data.libraries.load(path) as (source, target):
        target.objects = list(source.objects)
    for found in target.objects:
        bpy.context.scene.collection.objects.link(found)
    assert bpy.data.objects["Flexor"].sinew.tissue.volume_keeping == 0.75
    assert_same_skin(12, "Arm", shown)


def test_a_linked_character_works_and_its_file_is_named(written_by, tmp_path):
    library = tmp_path / f"library_0.1_blender_{written_by}.blend"
    with bpy.data.libraries.load(str(library), link=True) as (_source, target):
        target.collections = ["Character"]
    bpy.context.scene.collection.children.link(target.collections[0])
    linked = {found.name: found for found in bpy.data.objects}
    assert linked["Arm"].library and linked["Arm"].sinew.skin.motion_source == "FULL"
    assert linked["Extensor via"].sinew.tissue.muscle == linked["Extensor"]
    assert any(library.name in notice and "save" in notice for notice in migration.notices())
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "linking.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "linking.blend"))
    assert bpy.data.objects["Arm"].sinew.skin.motion_source == "FULL"
    assert any(library.name in notice for notice in migration.notices())


def overrides():
    return {found.name: found for found in bpy.data.objects if found.override_library}


def test_an_overridden_character_keeps_its_settings(written_by, tmp_path):
    shown = open_file(tmp_path, "shot", written_by)
    found = overrides()
    skin, flexor, rig = found["Arm"].sinew.skin, found["Flexor"].sinew.tissue, found["Arm Rig"]
    assert (skin.muscle_influence, skin.falloff, skin.energy, skin.motion_source) == (2.5, 0.0625, "SPRINGS", "FULL")
    assert (flexor.tension, flexor.volume_keeping) == (0.75, 0.5)
    assert not rig.sinew.rig.show_bones and rig.sinew.rig.mirror_x
    lower = rig.pose.bones["lower"].sinew
    assert (lower.eagerness, lower.slack) == (0.25, 1.5)
    assert found["Extensor"].sinew.tissue.wraps[0].sphere == found["Ball"]
    assert found["Extensor via"].sinew.tissue.muscle == found["Extensor"]
    for frame in FRAMES:
        bpy.context.scene.frame_set(frame)
        bpy.context.view_layer.update()
        assert np.abs(evaluated_points(found["Arm"]) - shown[f"Override_{frame}"]).max() < SAME_M
    assert any("library_0.1" in notice for notice in migration.notices())


@pytest.fixture
def forgetful(monkeypatch):
    monkeypatch.setattr(old_names, "_warned", set())


def test_former_names_still_work_and_warn_once(forgetful):
    skin, rig = make_arm()
    muscle = add_muscle(rig)
    bind(skin)
    with pytest.warns(DeprecationWarning, match=r"object\.sinew\.gain is now object\.sinew\.skin\.muscle_influence"):
        skin.sinew.gain = 2.0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert skin.sinew.gain == skin.sinew.skin.muscle_influence == 2.0
    bone = rig.pose.bones["lower"].sinew
    with pytest.warns(DeprecationWarning):
        skin.sinew.carry, skin.sinew.reach, skin.sinew.rest_distance = "FULL", 0.125, 0.25
        skin.sinew.contacts = False
        muscle.sinew.wraps.add()
        rig.sinew.mirror_x = True
        bone.multiplier, bone.rest_distance = 0.5, 2.0
        muscle.sinew.keyframe_insert("tension", frame=1)
        skin.sinew.driver_add("gain")
    settings = skin.sinew.skin
    assert (settings.motion_source, settings.falloff, settings.slack, settings.contacts) == ("FULL", 0.125, 0.25, False)
    assert len(muscle.sinew.tissue.wraps) == 1 and rig.sinew.rig.mirror_x
    assert (bone.eagerness, bone.slack) == (0.5, 2.0)
    assert {"sinew.tissue.tension", "sinew.skin.muscle_influence"} <= set(paths_of_the_file())
    muscle.sinew.tissue.keyframe_insert("tension", frame=2)  # Blender's own methods take the new names


def test_all_former_names_lead_somewhere():
    skin, rig = make_arm()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for owner, names in ((skin, old_names.OF_OBJECTS), (rig.pose.bones["lower"], old_names.OF_BONES)):
            for name in names:
                getattr(owner.sinew, name)


def test_reading_settings_leaves_no_trace():
    skin, rig = make_arm()
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    bpy.context.scene.collection.objects.link(camera)
    for found in (skin, rig, camera):
        assert stored_settings.tissue_of(found) is stored_settings.skin_of(found) is stored_settings.rig_of(found) is None
        assert stored_settings.rig_of_goal(found) is stored_settings.growth_of(found) is None
        assert not stored_settings.baked_keys_of(found)
        assert not found.is_property_set("sinew")
    migration.migrate()
    assert not any(found.is_property_set("sinew") for found in bpy.data.objects)


def test_a_setting_makes_only_its_own_rig_dirty():
    characters = []
    for name in ("One", "Two"):
        skin, rig = make_arm(name)
        muscle = add_muscle(rig)
        bind(skin)
        bend(rig, 1.0)
        characters.append((skin, rig, muscle))
    (skin, rig, muscle), (_skin, other, _muscle) = characters
    for settings, name, value in (
        (muscle.sinew.tissue, "tension", 0.5),
        (skin.sinew.skin, "muscle_influence", 2.0),
        (rig.sinew.rig, "show_posed", False),
        (rig.sinew.rig, "show_muscles", False),
        (rig.pose.bones["lower"].sinew, "crease", 0.5),
    ):
        bpy.context.view_layer.update()
        assert session.cached_rig(rig).character_index is not None
        setattr(settings, name, value)
        assert session.cached_rig(rig).character_index is None, name
        assert session.cached_rig(other).character_index is not None, name


def test_a_file_of_a_newer_version_is_named(tmp_path):
    skin, rig = make_arm()
    add_muscle(rig)
    bind(skin)
    skin.sinew.version = 99
    path = str(tmp_path / "newer.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert any("newer version" in notice for notice in migration.notices())
    assert bpy.data.objects["Arm"].sinew.version == 99


def test_an_overridden_character_is_saved_again(written_by, tmp_path):
    shown = open_file(tmp_path, "shot", written_by)
    overrides()["Arm"].sinew.skin.iterations = 7
    path = str(tmp_path / "shot again.blend")
    for _ in range(2):
        bpy.ops.wm.save_as_mainfile(filepath=path)
        bpy.ops.wm.open_mainfile(filepath=path)
    found = overrides()
    skin, flexor, rig = found["Arm"].sinew.skin, found["Flexor"].sinew.tissue, found["Arm Rig"]
    assert (skin.muscle_influence, skin.falloff, skin.energy, skin.iterations) == (2.5, 0.0625, "SPRINGS", 7)
    assert (flexor.tension, flexor.volume_keeping) == (0.75, 0.5)
    assert not rig.sinew.rig.show_bones and rig.sinew.rig.mirror_x
    assert found["Extensor"].sinew.tissue.wraps[0].sphere == found["Ball"]
    assert found["Extensor via"].sinew.tissue.muscle == found["Extensor"]
    skin.iterations = 10
    for frame in FRAMES:
        bpy.context.scene.frame_set(frame)
        bpy.context.view_layer.update()
        assert np.abs(evaluated_points(found["Arm"]) - shown[f"Override_{frame}"]).max() < SAME_M


def test_an_old_shot_keeps_its_overrides_over_a_migrated_library(written_by, tmp_path):
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / f"library_0.1_blender_{written_by}.blend"))
    bpy.ops.wm.save_mainfile()
    shown = open_file(tmp_path, "shot", written_by)
    found = overrides()
    skin, flexor, rig = found["Arm"].sinew.skin, found["Flexor"].sinew.tissue, found["Arm Rig"]
    assert (skin.muscle_influence, skin.falloff, skin.energy, skin.motion_source) == (2.5, 0.0625, "SPRINGS", "FULL")
    assert (flexor.tension, flexor.volume_keeping) == (0.75, 0.5)
    assert not rig.sinew.rig.show_bones and rig.sinew.rig.mirror_x
    assert (rig.pose.bones["lower"].sinew.eagerness, rig.pose.bones["lower"].sinew.slack) == (0.25, 1.5)
    assert found["Extensor via"].sinew.tissue.muscle == found["Extensor"]
    assert not migration.notices()
    bpy.context.scene.frame_set(12)
    bpy.context.view_layer.update()
    assert np.abs(evaluated_points(found["Arm"]) - shown["Override_12"]).max() < SAME_M
