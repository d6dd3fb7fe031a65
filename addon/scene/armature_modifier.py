# SPDX-License-Identifier: GPL-3.0-or-later
"""The only reader and writer of skin meshes: rest points, edges and weights in, the correction out. (What a person paints
for Sinew on them is for `painted_io`.)

The correction is a vector attribute that a Geometry Nodes modifier, first in the stack, adds to the points before the
Armature modifier. Nothing else of the mesh is touched.
"""

from ..errors import SinewError


def is_bound(candidate) -> bool:
    """Whether an object is a mesh bound by Sinew; asks without leaving a trace on objects that are none of ours."""
    return candidate.type == "MESH" and candidate.is_property_set("sinew") and candidate.sinew.bound


def rig_of(skin):
    """The armature that moves a mesh: of its Armature modifier, else its parent. Raises SinewError where there is none."""
    modifiers = armature_modifiers(skin)
    _refuse_several(skin, modifiers)
    if modifiers:
        return modifiers[0].object
    if skin.parent and skin.parent.type == "ARMATURE":
        return skin.parent
    raise SinewError(f"{skin.name} follows no armature: parent it to one (Ctrl+P > With Automatic Weights) and bind again")


def _refuse_several(skin, modifiers: list):
    if len(modifiers) > 1:
        names = ", ".join(modifier.name for modifier in modifiers)
        raise SinewError(f"{skin.name} has several Armature modifiers ({names}): Sinew follows one; remove the others")


def armature_modifiers(skin) -> list:
    """The Armature modifiers of a mesh that have an armature."""
    return [modifier for modifier in skin.modifiers if modifier.type == "ARMATURE" and modifier.object]


def skinning_of(skin) -> str:
    """What the Armature modifier does, in the core's words. Raises SinewError for what Sinew does not follow."""
    modifiers = armature_modifiers(skin)
    _refuse_several(skin, modifiers)
    if skin.parent_type == "ARMATURE" and skin.parent and skin.parent.type == "ARMATURE":
        # Blender then deforms the mesh before its first modifier, where no correction comes before it
        raise SinewError(
            f"{skin.name} is deformed by its parent type 'Armature', which Sinew can't come before: "
            "make the parent type 'Object' and add an Armature modifier (Ctrl+P > Armature Deform)"
        )
    if not modifiers:
        return "NONE"
    modifier = modifiers[0]
    where = f"{skin.name}: Armature modifier '{modifier.name}'"
    if modifier.use_bone_envelopes:
        raise SinewError(f"{where} uses Bone Envelopes, which Sinew does not follow: switch them off or paint weights")
    if modifier.use_multi_modifier:
        raise SinewError(f"{where} has Multi Modifier on, which Sinew does not follow: switch it off")
    if modifier.vertex_group and modifier.use_deform_preserve_volume:
        raise SinewError(f"{where} has a vertex group and Preserve Volume: Sinew follows one of them; clear the other")
    if not modifier.use_vertex_groups:
        return "NONE"
    return "PRESERVE_VOLUME" if modifier.use_deform_preserve_volume else "LINEAR"


def follows_armature(skin, mode: str) -> bool:
    """Whether the Armature modifier is on in an evaluation of this mode ('VIEWPORT' or 'RENDER')."""
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
