# SPDX-License-Identifier: GPL-3.0-or-later
"""Which armature moves a mesh, and how its Armature modifier skins it.

Sinew writes its correction before this modifier, so it must know exactly what the modifier does
(docs/mathematics/skinning.md, Linear blend skinning and Dual quaternions).
"""

from ..errors import SinewError
from . import stored_settings


def is_bound(candidate) -> bool:
    """Whether an object is a mesh that Sinew is bound to. Does not create settings on objects that have none."""
    settings = stored_settings.skin_of(candidate) if candidate.type == "MESH" else None
    return settings is not None and settings.bound


def rig_of(skin):
    """The armature of a mesh: the one of its Armature modifier, else its parent. Raises SinewError if it has none."""
    modifiers = armature_modifiers(skin)
    _check_count(skin, modifiers)
    if modifiers:
        return modifiers[0].object
    if skin.parent and skin.parent.type == "ARMATURE":
        return skin.parent
    raise SinewError(f"{skin.name} follows no armature: parent it to one (Ctrl+P > With Automatic Weights) and bind again")


def armature_modifiers(skin) -> list:
    """The Armature modifiers of a mesh that have an armature."""
    return [modifier for modifier in skin.modifiers if modifier.type == "ARMATURE" and modifier.object]


def _check_count(skin, modifiers: list):
    if len(modifiers) > 1:
        names = ", ".join(modifier.name for modifier in modifiers)
        raise SinewError(f"{skin.name} has several Armature modifiers ({names}): Sinew follows one; remove the others")


def skinning_of(skin) -> str:
    """What the Armature modifier does: "NONE", "LINEAR" or "PRESERVE_VOLUME", as `_sinew.Skin` takes it.

    Raises SinewError for settings of the modifier that Sinew does not support.
    """
    modifiers = armature_modifiers(skin)
    _check_count(skin, modifiers)
    if skin.parent_type == "ARMATURE" and skin.parent and skin.parent.type == "ARMATURE":
        # Blender deforms such a mesh before its first modifier, so no modifier can correct it
        raise SinewError(
            f"{skin.name} is deformed by its parent type 'Armature', which Sinew can't come before: "
            "make the parent type 'Object' and add an Armature modifier (Ctrl+P > Armature Deform)"
        )
    if not modifiers:
        return "NONE"
    modifier = modifiers[0]
    where = f"{skin.name}: Armature modifier '{modifier.name}'"
    if modifier.use_bone_envelopes:
        raise SinewError(f"{where} uses Bone Envelopes, which Sinew does not support: turn them off or paint weights")
    if modifier.use_multi_modifier:
        raise SinewError(f"{where} has Multi Modifier on, which Sinew does not support: turn it off")
    if modifier.vertex_group and modifier.use_deform_preserve_volume:
        raise SinewError(f"{where} has a vertex group and Preserve Volume: Sinew supports only one of them; clear the other")
    if not modifier.use_vertex_groups:
        return "NONE"
    return "PRESERVE_VOLUME" if modifier.use_deform_preserve_volume else "LINEAR"


def follows_armature(skin, mode: str) -> bool:
    """Whether the Armature modifier is on in an evaluation of this mode ("VIEWPORT" or "RENDER")."""
    shown = "show_render" if mode == "RENDER" else "show_viewport"
    return all(getattr(modifier, shown) for modifier in armature_modifiers(skin))


def modifier_state(skin) -> tuple:
    """The settings of a mesh's Armature modifiers that its bind depends on."""
    return tuple(
        (
            modifier.use_deform_preserve_volume,
            modifier.use_vertex_groups,
            modifier.use_bone_envelopes,
            modifier.use_multi_modifier,
            modifier.vertex_group,
            modifier.invert_vertex_group,
        )
        for modifier in armature_modifiers(skin)
    )
