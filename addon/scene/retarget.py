# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes constraints and drivers of copied objects refer to the copies where they referred to the originals."""


def retarget_constraint(constraint, rig, copy):
    """Replaces a rig by its copy in all targets of a constraint."""
    for name in ("target", "pole_target", "space_object"):
        if getattr(constraint, name, None) == rig:
            setattr(constraint, name, copy)
    for target in getattr(constraint, "targets", ()):
        if target.target == rig:
            target.target = copy


def retarget_drivers(owner, copies: dict):
    """Replaces originals by their copies in all driver variables of an ID (or None). copies: original to copy."""
    animation = owner.animation_data if owner is not None else None
    for curve in animation.drivers if animation else ():
        for variable in curve.driver.variables:
            for target in variable.targets:
                if target.id in copies:
                    target.id = copies[target.id]
