# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies of a character's meshes for the time of an export, in the form that every file format and exporter can hold.

Exporters lose what their formats do not know: the masks of shape keys, modifiers, and in glTF the drivers of keys where a
mesh is not a child of its armature. So the meshes that are written are copies: children of the armature, with plain keys
(`plain_keys`), and with the modifiers before the Armature modifier applied (`applied_modifiers`).
"""

from collections.abc import Iterator
from contextlib import contextmanager

import bpy
from mathutils import Matrix

from ..display import edge_stretch_colours
from ..scene import armature_modifier, characters, correction_modifier, live_switch, painted_data, stored_settings
from ..scene.retarget import retarget_drivers
from ..settings import object_settings
from . import applied_modifiers, plain_keys, scales

_RENAMED = " (original)"


@contextmanager
def file_copies(scene, layer, rig, meshes: list) -> Iterator[list]:
    """Yields copies of the meshes, which have the names of the originals until the block ends.

    rig: the armature that is written. meshes: those that follow it, or the armature of which it is an export copy.
    Raises SinewError where a modifier before the Armature modifier can't be applied.
    """
    names = [(mesh, mesh.name, mesh.data, mesh.data.name) for mesh in meshes]
    copies: list = []
    try:
        for mesh, name, data, data_name in names:
            for owner, kept in ((mesh, name), (data, data_name)):
                if owner.library is None:
                    owner.name = f"{kept}{_RENAMED}"
        for mesh, name, data, data_name in names:
            copy = mesh.copy()
            copies.append(copy)
            copy.name, copy.data = name, data.copy()
            _finish(copy, mesh, rig, scene, layer)
            copy.data.name = data_name
        for copy, mesh in zip(copies, meshes, strict=True):
            _retarget(copy, dict(zip(meshes, copies, strict=True)) | {_rig_of(mesh): rig})
        layer.update()
        yield copies
    finally:
        for copy in copies:
            data = copy.data
            bpy.data.objects.remove(copy)
            if data.users == 0:
                bpy.data.meshes.remove(data)
        for mesh, name, data, data_name in names:
            for owner, kept in ((mesh, name), (data, data_name)):
                if owner.library is None:
                    owner.name = kept
        characters.forget()


def _finish(copy, mesh, rig, scene, layer):
    """Links a copy and gives it the form of a file. copy: has its own mesh."""
    object_settings.clear(copy)  # before it is linked: it would count as another skin of the same rig
    correction_modifier.remove_correction(copy)
    cache = live_switch.cache_modifier_of(mesh)
    if cache:
        copy.modifiers.remove(copy.modifiers[cache.name])
    painted_data.remove_all(copy)
    edge_stretch_colours.remove(copy.data)
    keys = copy.data.shape_keys
    for baked in stored_settings.baked_keys_of(mesh) if keys else ():
        key = keys.key_blocks.get(baked.name)
        if key:
            key.mute = baked.muted_by_sinew
    scene.collection.objects.link(copy)
    copy.hide_viewport = copy.hide_render = False
    copy.hide_set(False)
    for modifier in armature_modifier.armature_modifiers(copy):
        modifier.object = rig
        modifier.show_viewport = modifier.show_render = True
    _make_child(copy, mesh, rig)
    plain_keys.make_plain(copy)
    applied_modifiers.apply_before_armature(copy, scene, layer)
    _apply_uneven_scale(copy, rig, layer)


def _make_child(copy, mesh, rig):
    """Makes a copy the child of its rig where its original is. A mesh on a bone stays on the bone."""
    if mesh.parent is not None and mesh.parent == _rig_of(mesh):
        inverse = copy.matrix_parent_inverse.copy()
        copy.parent = rig
        copy.matrix_parent_inverse = inverse
        return
    copy.animation_data_clear()
    copy.constraints.clear()
    copy.parent, copy.parent_type = rig, "OBJECT"
    copy.matrix_parent_inverse = rig.matrix_world.inverted_safe() @ mesh.matrix_world
    copy.matrix_basis = Matrix()


def _apply_uneven_scale(copy, rig, layer):
    """Applies the transform of a copy to its rig to its mesh, if that or the rig has an uneven or negative scale."""
    layer.update()
    relation = rig.matrix_world.inverted_safe() @ copy.matrix_world
    if copy.parent_type != "OBJECT" or (scales.is_even(relation) and scales.is_even(rig.matrix_world)):
        return
    copy.data.transform(relation, shape_keys=True)
    if relation.determinant() < 0.0:
        copy.data.flip_normals()
    copy.animation_data_clear()
    copy.matrix_parent_inverse, copy.matrix_basis = Matrix(), Matrix()


def _retarget(copy, copies: dict):
    """Makes the drivers of a copy read the copies. copies: original to copy."""
    for owner in (copy, copy.data.shape_keys):
        retarget_drivers(owner, copies)


def _rig_of(mesh):
    return characters.rig_or_none(mesh)
