# SPDX-License-Identifier: GPL-3.0-or-later
"""Applies the modifiers of a copied mesh that act before its Armature modifier, to its basis and to each of its keys.

Files hold bones and keys, and no modifiers. A modifier before the Armature modifier changes the rest shape, so it can be
applied. One after it changes the posed shape, which no rest shape reproduces.
"""

import bpy
import numpy as np

from ..errors import SinewError
from ..scene import armature_modifier, mesh_arrays


def left_out(skin) -> list[str]:
    """The names of the modifiers after the Armature modifier that the viewport shows. No file can hold them."""
    return [modifier.name for modifier in _after(skin) if modifier.show_viewport]


def apply_before_armature(copy, scene, layer):
    """Applies the shown modifiers before the Armature modifier, and removes all but the Armature modifier.

    copy: a mesh object with plain keys (`plain_keys.make_plain`) and without Sinew's modifier. Raises SinewError where the
    keys get other numbers of vertices than the basis, or have NLA tracks.
    """
    before = [modifier.name for modifier in _before(copy) if modifier.show_viewport]
    keys = copy.data.shape_keys
    if before and keys and keys.animation_data and keys.animation_data.nla_tracks:
        raise SinewError(
            f"{copy.name} has NLA tracks on its shape keys, and modifiers before its Armature modifier. Apply the "
            "modifiers, or bake the tracks to an action"
        )
    if before:
        _replace_mesh(copy, scene, layer, before)
    armature = armature_modifier.armature_modifiers(copy)
    for modifier in list(copy.modifiers):
        if modifier not in armature:
            copy.modifiers.remove(modifier)


def _armature_index(skin) -> int:
    armature = armature_modifier.armature_modifiers(skin)
    return skin.modifiers.find(armature[0].name) if armature else len(skin.modifiers)


def _before(skin) -> list:
    return skin.modifiers[: _armature_index(skin)]


def _after(skin) -> list:
    return skin.modifiers[_armature_index(skin) + 1 :]


def _replace_mesh(copy, scene, layer, modifiers: list[str]):
    """Gives the copy the mesh that these modifiers make, with its keys."""
    old = copy.data
    work = copy.copy()
    work.data = old.copy()
    try:
        work.shape_key_clear()
        for modifier in list(work.modifiers):
            if modifier.name not in modifiers:
                work.modifiers.remove(modifier)
        scene.collection.objects.link(work)
        new = _evaluated(work, layer)
        points = {key.name: _points_with(work, layer, key) for key in old.shape_keys.key_blocks} if old.shape_keys else {}
    finally:
        data = work.data
        bpy.data.objects.remove(work)
        bpy.data.meshes.remove(data)
    wrong = [name for name, shape in points.items() if len(shape) != len(new.vertices)]
    if wrong:
        bpy.data.meshes.remove(new)
        raise SinewError(
            f"{copy.name}: {', '.join(modifiers)} makes another number of vertices for the shape key '{wrong[0]}'. "
            "Apply the modifier first, or remove the key"
        )
    name, old.name = old.name, f"{old.name} before"
    copy.data, new.name = new, name
    if old.shape_keys:
        _copy_keys(old.shape_keys, copy, points)
    bpy.data.meshes.remove(old)


def _evaluated(work, layer):
    """A new mesh, as Blender evaluates the object now."""
    layer.update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return bpy.data.meshes.new_from_object(work.evaluated_get(depsgraph), preserve_all_data_layers=True, depsgraph=depsgraph)


def _points_with(work, layer, key) -> np.ndarray:
    """The evaluated points, (vertices, 3) float32, where the mesh has the shape of a key."""
    points = np.empty(3 * len(key.points), np.float32)
    key.points.foreach_get("co", points)
    work.data.vertices.foreach_set("co", points)
    work.data.update()
    work.update_tag(refresh={"DATA"})
    layer.update()
    evaluated = work.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return mesh_arrays.read_evaluated_points(evaluated.data)


def _copy_keys(old, copy, points: dict[str, np.ndarray]):
    """Adds keys with these points, (vertices, 3) float32, and the values, animation and drivers of the old ones."""
    for key in old.key_blocks:
        added = copy.shape_key_add(name=key.name, from_mix=False)
        added.points.foreach_set("co", points[key.name].reshape(-1))
        added.slider_min, added.slider_max, added.value = key.slider_min, key.slider_max, key.value
    new, animation = copy.data.shape_keys, old.animation_data
    if animation is None:
        return
    copied = new.animation_data_create()
    if animation.action:
        copied.action = animation.action
        copied.action_slot = animation.action_slot
    for curve in animation.drivers:
        copied.drivers.from_existing(src_driver=curve)
