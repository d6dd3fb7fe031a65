# SPDX-License-Identifier: GPL-3.0-or-later
"""The keyed value of a property at a frame, for objects that Blender does not evaluate."""


def value_at(animated, path: str, frame: float, otherwise: float) -> float:
    """The value of the active action's F-curve for `path` at a frame, or `otherwise` if there is no such curve.

    Drivers and the NLA are ignored: they can depend on anything, so only Blender can evaluate them.
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
