# SPDX-License-Identifier: GPL-3.0-or-later
"""The value that an object's own keys give a property, for objects that Blender does not evaluate."""


def value_at(animated, path: str, frame: float, otherwise: float) -> float:
    """What the active action's F-curve for `path` says at a frame; `otherwise` where it has none.

    Drivers and the NLA are not asked: they can depend on anything, and only Blender's own evaluation knows all of it.
    """
    curve = _curve(animated.animation_data, path)
    return curve.evaluate(frame) if curve else otherwise


def _curve(animation, path: str):
    action, slot = animation.action, animation.action_slot
    if action is None or slot is None:
        return None
    for layer in action.layers:
        for strip in layer.strips:
            bag = strip.channelbag(slot)
            curve = bag.fcurves.find(path) if bag else None
            if curve and not curve.mute and curve.is_valid:
                return curve
    return None
