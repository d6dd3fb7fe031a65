# SPDX-License-Identifier: GPL-3.0-or-later
"""The names of settings in Sinew 0.1, where all settings of an object were in `object.sinew`, and what they are called now.

Scripts can still use the old names: each is a Python property that reads and writes the new one and warns once per name.
Keyframes and drivers that are added by an old name go to the new path.
"""

import warnings

TISSUE = {
    name: f"tissue.{name}"
    for name in (
        "kind", "origin_bone", "insertion_bone", "origin_tendon", "insertion_tendon", "volume_keeping", "tension",
        "semi_axes", "width_ratio", "offset", "skin_thickness", "wraps", "muscle", "order",
    )
} | {"is_put_away": "tissue.disabled_by_layer"}  # fmt: skip
SKIN = {
    name: f"skin.{name}"
    for name in (
        "bound", "live", "anchoring", "scale_fat", "elastic", "iterations", "energy", "anchor_stiffness", "edge_stiffness",
        "fat_sliding", "collides", "contacts", "baked_keys", "cache_modifier", "bake_error_mm", "corrective_summary",
        "quality_text", "quality_json", "quality_summary", "growth",
    )
} | {
    "carry": "skin.motion_source",
    "reach": "skin.falloff",
    "gain": "skin.muscle_influence",
    "rest_distance": "skin.slack",
}  # fmt: skip
RIG = {
    name: f"rig.{name}"
    for name in (
        "show_posed", "show_muscles", "show_bones", "show_stuffing", "show_spheres", "show_empties", "show_shaded", "shaded",
        "export_copy", "show_attachments", "mirror_x", "active_tissue",
    )
}  # fmt: skip
# old name: path from `object.sinew`. `goal` kept its name and place
OF_OBJECTS = TISSUE | SKIN | RIG
# old name: new name, both in `pose_bone.sinew`
OF_BONES = {"rest_distance": "slack", "multiplier": "eagerness"}
OF_BAKED_KEYS = {"silenced": "muted_by_sinew"}

# methods of a group that take the name of a property first
_METHODS = ("keyframe_insert", "keyframe_delete", "driver_add", "driver_remove", "property_unset")

_warned: set[tuple[str, str]] = set()


def add_to_objects(cls):
    """Adds the old names to the class of `object.sinew`."""
    _add(cls, OF_OBJECTS, "object.sinew")


def add_to_bones(cls):
    """Adds the old names to the class of `pose_bone.sinew`."""
    _add(cls, OF_BONES, "pose_bone.sinew")


def add_to_baked_keys(cls):
    """Adds the old name to the class of a baked key."""
    _add(cls, OF_BAKED_KEYS, "baked_keys[...]")


def _add(cls, names: dict[str, str], owner: str):
    for old, new in names.items():
        setattr(cls, old, _alias(old, new, owner))
    for method in _METHODS:
        setattr(cls, method, _forwarding(cls, method, names, owner))


def _alias(old: str, new: str, owner: str) -> property:
    def read(settings):
        _warn(old, new, owner)
        group, name = _resolve(settings, new)
        return getattr(group, name)

    def write(settings, value):
        _warn(old, new, owner)
        group, name = _resolve(settings, new)
        setattr(group, name, value)

    return property(read, write, doc=f"Former name of `{owner}.{new}`.")


def _forwarding(cls, method: str, names: dict[str, str], owner: str):
    def forward(settings, name, *args, **options):
        if name not in names:
            return getattr(super(cls, settings), method)(name, *args, **options)
        _warn(name, names[name], owner)
        group, new = _resolve(settings, names[name])
        return getattr(group, method)(new, *args, **options)

    forward.__name__, forward.__doc__ = method, f"As Blender's `{method}`, which also takes a former name."
    return forward


def _resolve(settings, path: str):
    group, _, name = path.rpartition(".")
    return (getattr(settings, group) if group else settings), name


def _warn(old: str, new: str, owner: str):
    if (owner, old) not in _warned:
        _warned.add((owner, old))
        warnings.warn(f"{owner}.{old} is now {owner}.{new}", DeprecationWarning, stacklevel=3)
