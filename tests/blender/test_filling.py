# SPDX-License-Identifier: GPL-3.0-or-later
"""Filling a body: figures, the table of volumes, and tissues made of a mesh."""

import math

import bpy
import pytest
from bl_ext.user_default.sinew.muscles import portable_names
from bl_ext.user_default.sinew.muscles.placing.place import preset_file
from bl_ext.user_default.sinew.muscles.placing.place.figure import AVERAGE, STRONG, measured_volumes
from bl_ext.user_default.sinew.scene import characters, tissue_empty
from conftest import select

pytestmark = pytest.mark.one_blender


def volume(shape):
    return 4 / 3 * math.pi * math.prod(shape.semi_axes)


def test_measured_volumes_scale_with_the_body_and_the_figure():
    preset = preset_file.read("human")
    average, strong = (measured_volumes(preset, 0.15, figure) for figure in (AVERAGE, STRONG))
    assert average["Soleus"] == pytest.approx(2 * 454.3e-6)
    assert strong["Soleus"] == pytest.approx(STRONG.muscle * average["Soleus"])


def test_the_real_body_is_filled_and_the_volumes_are_listed(real_body):
    _, rig = real_body
    select(rig)
    bpy.ops.sinew.add_preset(name="human")
    shapes = {empty.name: tissue_empty.read(empty, rig) for empty in characters.tissues_of(rig)}
    assert sum(map(volume, shapes.values())) > 0.6 * 0.063
    for name in ("Vastus lateralis", "Soleus", "Gluteus maximus, middle part"):
        left, right = shapes[f"{name}.L"], shapes[f"{name}.R"]
        assert (left.centre.x, left.centre.y, left.centre.z) == pytest.approx(
            (-right.centre.x, right.centre.y, right.centre.z), abs=1e-5
        )
        assert volume(left) == pytest.approx(volume(right), rel=1e-4)
    bpy.context.view_layer.update()
    assert bpy.ops.sinew.muscle_volumes() == {"FINISHED"}
    text = bpy.data.texts["Muscle Volumes"].as_string()
    assert "Soleus.L" in text and "measured" in text


def test_a_mesh_becomes_ellipsoids_on_the_nearest_bone(arm):
    _, rig = arm
    bpy.ops.mesh.primitive_cube_add(size=0.1, location=rig.matrix_world @ rig.data.bones["lower"].head_local)
    cube = bpy.context.object
    cube.name = "Scan"
    select(rig)
    cube.select_set(True)
    bpy.ops.sinew.mesh_to_tissues(bone="lower", count=4)
    made = [empty for empty in characters.tissues_of(rig) if empty.name.startswith("Scan")]
    assert 1 <= len(made) <= 4
    assert {empty.sinew.tissue.origin_bone for empty in made} == {"lower"}
    # the ellipsoids in four equal boxes have pi / 6 of their volume, less the margin under the surface
    assert sum(volume(tissue_empty.read(empty, rig)) for empty in made) > 0.4 * 0.1**3


def test_a_mesh_needs_to_be_selected(arm):
    _, rig = arm
    select(rig)
    with pytest.raises(RuntimeError, match="Select the meshes"):
        bpy.ops.sinew.mesh_to_tissues()


def test_muscles_transfer_to_the_same_body_unchanged(real_body):
    skin, rig = real_body
    other = rig.copy()
    other.data = rig.data.copy()
    other_skin = skin.copy()
    other_skin.data = skin.data.copy()
    for made in (other, other_skin):
        bpy.context.scene.collection.objects.link(made)
    other_skin.parent = other
    other_skin.modifiers["Armature"].object = other
    select(rig)
    bpy.ops.sinew.add_preset(name="limbs")
    select(other)
    rig.select_set(True)
    bpy.ops.sinew.transfer_muscles(fit_skin=False)
    before = portable_names.of_rig(rig)
    after = portable_names.of_rig(other)
    assert before.keys() == after.keys()
    for name, empty in before.items():
        one, two = tissue_empty.read(empty, rig), tissue_empty.read(after[name], other)
        assert (one.centre - two.centre).length < 1e-4, name
        assert (one.semi_axes - two.semi_axes).length < 1e-4, name
