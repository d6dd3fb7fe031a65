# SPDX-License-Identifier: GPL-3.0-or-later
"""The names of settings in Sinew 0.1, where all settings of an object were in `object.sinew`, and what they are called now.

Scripts can still use the old names: reading and writing one goes to the new one and warns once per name.
Keyframes and drivers that a script adds by an old name go to the new one, too.

The old names also stay properties of Blender, hidden and without effect: while Blender loads a shot, it stores the values
that the shot overrides in them. Without them these values would be lost before `migration` can move them.
"""

import warnings

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty

TISSUE = {
    name: f"tissue.{name}"
    for name in (
        "kind", "origin_bone", "insertion_bone", "origin_tendon", "insertion_tendon", "volume_keeping", "tension",
        "semi_axes", "width_ratio", "offset", "skin_thickness", "wraps", "muscle", "order",
    )
} | {"is_put_away": "tissue.disabled_by_layer"}  # fmt: skip
REMOVED = ("collides",)  # settings of former versions that have no effect now
SKIN = {
    name: f"skin.{name}"
    for name in (
        "bound", "live", "anchoring", "scale_fat", "elastic", "iterations", "energy", "anchor_stiffness", "edge_stiffness",
        "fat_sliding", "contacts", "baked_keys", "cache_modifier", "bake_error_mm", "corrective_summary",
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
# old name: path from `object.sinew`. `goal` kept its name and path
OF_OBJECTS = TISSUE | SKIN | RIG
# old name: new name, both in `pose_bone.sinew`
OF_BONES = {"rest_distance": "slack", "multiplier": "eagerness"}
OF_BAKED_KEYS = {"silenced": "muted_by_sinew"}

# methods of a group that take the name of a property first
_METHODS = ("keyframe_insert", "keyframe_delete", "driver_add", "driver_remove", "property_unset")
_STORED = (BoolProperty, EnumProperty, FloatProperty, IntProperty)

_warned: set[tuple[str, str]] = set()


def add_to(cls, names: dict[str, str], owner: str, groups: dict[str, type] | None = None):
    """Adds old names to a class of settings, before it is registered.

    owner: how scripts reach the settings, for the warning. groups: the classes of its groups, by their names.
    """
    read, write = cls.__getattribute__, cls.__setattr__

    def read_any(settings, name):
        if name not in names:
            return read(settings, name)
        _warn(name, names[name], owner)
        group, new = resolve(settings, names[name])
        return getattr(group, new)

    def write_any(settings, name, value):
        if name not in names:
            write(settings, name, value)
            return
        _warn(name, names[name], owner)
        group, new = resolve(settings, names[name])
        setattr(group, new, value)

    cls.__getattribute__, cls.__setattr__ = read_any, write_any
    for method in _METHODS:
        setattr(cls, method, _forwarding(cls, method, names, owner))
    for old, path in names.items():
        group, _, new = path.rpartition(".")
        _keep_stored(cls, old, (groups or {}).get(group, cls).__annotations__[new])


def resolve(settings, path: str):
    """The group that a path of names leads to, and the last name."""
    group, _, name = path.rpartition(".")
    return (getattr(settings, group) if group else settings), name


def _keep_stored(cls, old: str, current):
    """Declares the storage of an old name, if a shot can override the current one. It can't be keyed."""
    if current.function in _STORED and "override" in current.keywords:
        kept = {key: value for key, value in current.keywords.items() if key not in ("update", "override", "options")}
        cls.__annotations__[old] = current.function(**kept, options={"HIDDEN"})


def _forwarding(cls, method: str, names: dict[str, str], owner: str):
    def forward(settings, name, *args, **options):
        if name not in names:
            return getattr(super(cls, settings), method)(name, *args, **options)
        _warn(name, names[name], owner)
        group, new = resolve(settings, names[name])
        return getattr(group, method)(new, *args, **options)

    forward.__name__, forward.__doc__ = method, f"As Blender's `{method}`, which also takes a former name."
    return forward


def _warn(old: str, new: str, owner: str):
    if (owner, old) not in _warned:
        _warned.add((owner, old))
        warnings.warn(f"{owner}.{old} is now {owner}.{new}", DeprecationWarning, stacklevel=3)
