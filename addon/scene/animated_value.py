# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the values of an object are in an evaluation: the rule for everything that can be keyed or driven.

Blender writes animated values to its evaluated copies. The original has them only in the window's evaluation, and keeps the
window's values while another evaluation renders or shows another scene. So `values_of` is read for every setting and every
transform that can be animated. Names, parents and lists can't be, and are read from the original.
"""

from collections.abc import Iterator

import bpy

_GROUPS = ("sinew", "tissue", "skin", "goal")


def values_of(original, depsgraph):
    """The object that has the values of `original` in an evaluation. Not to be kept, and not to be written to.

    An object without keys and drivers is returned as it is. Of others, it is the evaluated copy. Blender does not evaluate
    objects that are disabled or in an excluded collection: it is then a `KeyedValues`.
    """
    if original.animation_data is None:
        return original
    evaluated = original.evaluated_get(depsgraph)
    if is_evaluated(evaluated, depsgraph):
        return evaluated
    return KeyedValues(original, original, depsgraph.scene.frame_current_final)


def is_evaluated(evaluated, depsgraph) -> bool:
    """Whether Blender evaluates an object in an evaluation, as it does with the objects of the evaluated view layer.

    evaluated: as from `Object.evaluated_get`. An object that another one points to has an evaluated copy, too, whose values
    are never updated.
    """
    if not evaluated.is_evaluated:
        return False
    layer = depsgraph.view_layer_eval
    # the first two look up a hash, and suffice for most objects; the third searches a list
    if evaluated.visible_get(view_layer=layer) or evaluated.hide_get(view_layer=layer):
        return True
    return layer.objects.get(evaluated.name) == evaluated or evaluated in layer.objects.values()


class KeyedValues:
    """The values of an object that Blender does not evaluate: those of its keys at a frame, else the original's.

    Only the active action counts. Drivers and the NLA can depend on anything, so only Blender can evaluate them.
    """

    def __init__(self, owner, original, frame: float, path: str = ""):
        self._owner, self._original, self._frame, self._path = owner, original, frame, path

    def __getattr__(self, name: str):
        value, path = getattr(self._owner, name), self._path + name
        if name in _GROUPS:
            return KeyedValues(value, self._original, self._frame, f"{path}.")
        if isinstance(value, (bool, int, float)):
            return _at(self._original, path, 0, self._frame, value)
        found = self._owner.bl_rna.properties.get(name)
        if found is None or not found.is_animatable:
            return value
        if found.type == "ENUM" and not found.is_enum_flag:
            number = _at(self._original, path, 0, self._frame, found.enum_items[value].value)
            return next((item.identifier for item in found.enum_items if item.value == round(number)), value)
        if getattr(found, "is_array", False) and found.array_dimensions[1] == 0:
            value = value.copy() if hasattr(value, "copy") else list(value)
            for index, component in enumerate(value):
                value[index] = _at(self._original, path, index, self._frame, component)
        return value


def animate_again(mesh):
    """Makes Blender apply the keys of a mesh, its shape keys and its objects again, after a handler wrote it in a render.

    Blender evaluates an edit of a handler in a second pass. There it copies these three from the originals again, which have
    the values of the window's frame, and does not apply keys. Drivers it does apply.
    """
    users = [found for found in bpy.data.objects if found.data == mesh]
    for animated in (mesh, mesh.shape_keys, *users):
        animation = animated.animation_data if animated else None
        if animation:
            # of the functions of Python, only setting such a property tags the animation of any kind of data
            animation.use_nla = animation.use_nla


def has_drivers_or_strips(original) -> bool:
    """Whether an object has drivers or NLA strips, which only Blender can evaluate."""
    animation = original.animation_data
    return animation is not None and (len(animation.drivers) > 0 or any(track.strips for track in animation.nla_tracks))


def sources_of(original) -> tuple:
    """Identifies the actions and the number of drivers that animate an object. Cheap enough to compare in every frame."""
    animation = original.animation_data
    if animation is None:
        return ()
    actions = [animation.action, *(strip.action for track in animation.nla_tracks for strip in track.strips)]
    return (len(animation.drivers), *(action.session_uid if action else 0 for action in actions))


def paths_of(original) -> Iterator[str]:
    """The data paths of an object that have keys, in its action or its NLA strips, or drivers."""
    animation = original.animation_data
    if animation is None:
        return
    yield from (curve.data_path for curve in animation.drivers)
    actions = {animation.action, *(strip.action for track in animation.nla_tracks for strip in track.strips)} - {None}
    for action in actions:
        for layer in action.layers:
            for strip in layer.strips:
                for bag in strip.channelbags:
                    yield from (curve.data_path for curve in bag.fcurves)


def _at(original, path: str, index: int, frame: float, otherwise):
    """The value of the active action's F-curve at a frame, or `otherwise` if there is no such curve."""
    curve = _curve(original.animation_data, path, index)
    return type(otherwise)(curve.evaluate(frame)) if curve else otherwise


def _curve(animation, path: str, index: int):
    action, slot = animation.action, animation.action_slot
    if action is None or slot is None:
        return None
    for layer in action.layers:
        for strip in layer.strips:
            bag = strip.channelbag(slot)
            curve = bag.fcurves.find(path, index=index) if bag else None
            if curve and not curve.mute and curve.is_valid:
                return curve
    return None
