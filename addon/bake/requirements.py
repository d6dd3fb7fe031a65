# SPDX-License-Identifier: GPL-3.0-or-later
"""What every bake requires of frames, meshes and rigs.

Each function raises a SinewError that says what to do where the requirement is not met.
"""

from ..errors import SinewError
from ..scene import armature_modifier


def require_frames(first: int, last: int):
    """Requires that the range of frames is not empty."""
    if last < first:
        raise SinewError(f"The last frame ({last}) is before the first ({first})")


def require_bound(skin):
    """Requires that the mesh is bound."""
    if not armature_modifier.is_bound(skin):
        raise SinewError(f"{skin.name} is not bound: bind it first (Bind Skin)")


def require_object_mode(skin):
    """Requires that the mesh is not in Edit Mode, where Blender does not deform it."""
    if skin.data.is_editmode:
        raise SinewError(f"{skin.name} is in Edit Mode: leave it (Tab) and bake again")


def require_pose_position(rig):
    """Requires that the rig shows its pose, not its rest pose."""
    if rig.data.pose_position == "REST":
        raise SinewError(f"{rig.name} shows its rest pose, in which no muscle moves: leave Edit Rest Pose and bake again")


def require_rig(skin, rig):
    """Requires that the mesh follows this rig."""
    if armature_modifier.rig_of(skin) != rig:
        raise SinewError(f"{skin.name} follows another armature than {rig.name}: select meshes of one character")
