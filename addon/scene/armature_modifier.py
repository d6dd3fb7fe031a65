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
    """The armature of a mesh: the one of its Armature modifiers, else its parent. Raises SinewError if it has none."""
    modifiers = armature_modifiers(skin)
    if modifiers:
        others = [modifier.name for modifier in modifiers if modifier.object != modifiers[0].object]
        if others:
            raise SinewError(
                f"{skin.name} follows several armatures (Armature modifiers {modifiers[0].name}, {', '.join(others)}): "
                "Sinew follows one. Remove the others"
            )
        return modifiers[0].object
    if skin.parent and skin.parent.type == "ARMATURE":
        return skin.parent
    raise SinewError(f"{skin.name} follows no armature. Parent it to one (Ctrl+P > With Automatic Weights) and bind again")


def armature_modifiers(skin) -> list:
    """The Armature modifiers of a mesh that have an armature."""
    return [modifier for modifier in skin.modifiers if modifier.type == "ARMATURE" and modifier.object]


def skinning_of(skin) -> str:
    """What the Armature modifier does: "NONE", "LINEAR" or "PRESERVE_VOLUME", as `_sinew.Skin` takes it.

    Of two Armature modifiers (`second_of_pair`), the first. Raises SinewError for modifiers that Sinew does not support.
    """
    if skin.parent_type == "ARMATURE" and skin.parent and skin.parent.type == "ARMATURE":
        # Blender deforms such a mesh before its first modifier, so no modifier can correct it
        raise SinewError(
            f"{skin.name} is deformed by its parent type 'Armature', which Sinew can't come before. "
            "Make the parent type 'Object' and add an Armature modifier (Ctrl+P > Armature Deform)"
        )
    modifiers = armature_modifiers(skin)
    if not modifiers:
        return "NONE"
    modifier = modifiers[0]
    second_of_pair(skin)
    for each in modifiers:
        if each.use_bone_envelopes:
            raise SinewError(
                f"{_where(skin, each)} uses Bone Envelopes, which Sinew does not support. Turn them off or paint weights"
            )
    where = _where(skin, modifier)
    if modifier.use_multi_modifier:
        raise SinewError(f"{where} has Multi Modifier on, but it is the first Armature modifier. Turn it off")
    if modifier.vertex_group and modifier.use_deform_preserve_volume:
        raise SinewError(f"{where} has a vertex group and Preserve Volume: Sinew supports only one of them; clear the other")
    if not modifier.use_vertex_groups:
        return "NONE"
    return _skinning(modifier)


def second_of_pair(skin):
    """The second of a mesh's two Armature modifiers, whose Multi Modifier is on, or None if the mesh has at most one.

    MPFB and CharMorph use such a pair. At each vertex, the second one's vertex group says how much of its result is taken.
    Raises SinewError for other combinations of Armature modifiers.
    """
    modifiers = armature_modifiers(skin)
    if len(modifiers) < 2:
        return None
    names = ", ".join(modifier.name for modifier in modifiers)
    if len(modifiers) > 2:
        raise SinewError(
            f"{skin.name} has {len(modifiers)} Armature modifiers ({names}), and Sinew follows two. Remove the others"
        )
    first, second = modifiers
    where = _where(skin, second)
    if not second.use_multi_modifier:
        raise SinewError(
            f"{skin.name} has several Armature modifiers ({names}), and '{second.name}' acts on the result of the other. "
            "Remove it or turn its Multi Modifier on"
        )
    if first.vertex_group:
        raise SinewError(f"{_where(skin, first)} has a vertex group and is followed by '{second.name}'. Clear the group")
    if not (first.use_vertex_groups and second.use_vertex_groups):
        raise SinewError(f"{where}: both Armature modifiers need Bind To Vertex Groups. Turn it on for both")
    if skin.modifiers.find(second.name) != skin.modifiers.find(first.name) + 1:
        raise SinewError(f"{where} must come directly after '{first.name}'. Move it there")
    return second


def skinning_of_second(skin) -> str:
    """What the second modifier of a pair (`second_of_pair`) does: "LINEAR" or "PRESERVE_VOLUME"."""
    return _skinning(second_of_pair(skin))


def _skinning(modifier) -> str:
    return "PRESERVE_VOLUME" if modifier.use_deform_preserve_volume else "LINEAR"


def _where(skin, modifier) -> str:
    return f"{skin.name}: Armature modifier '{modifier.name}'"


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
