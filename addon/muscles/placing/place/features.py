# SPDX-License-Identifier: GPL-3.0-or-later
"""Eyes, ears and claws of an animal, as stuffing on bones that have Rigify's names for them.

Presets hold the tissues of the papers only. These features make a skin that is grown over the tissues recognisable.
"""

import re

from mathutils import Vector

from ....scene.tissue_empty import TissueShape
from ...transfer import spanned

_EYE = re.compile(r"eye(\.[LR])", re.IGNORECASE)
_EAR = re.compile(r"ear(\.[LR])", re.IGNORECASE)
_CLAW = re.compile(r"([fr]_(?:index|middle|ring|pinky))\.002(\.[LR])")
_HIND_TOE = "r_index.002"  # fingers count as claws only if the hind feet have toes of the same kind

EYE_OF_BONE = 0.3  # radius, as a fraction of the bone's length
EAR_WIDTH, EAR_THICKNESS = 0.5, 0.22  # semi-axes, as fractions of the ear's length
EAR_ROOT = 0.5  # depth inside the head, as a fraction of the ear's length
CLAW_WIDTH, CLAW_LENGTH = 0.3, 1.6  # as fractions of the length of the toe's last bone
SHORTEST_M = 1e-6


def features(rig) -> list[TissueShape]:
    """The eyes, ears and claws of a rig, in armature space. Empty if no bone has a name of such a feature."""
    bones = rig.data.bones
    shapes = []
    has_hind_toes = any(bone.name.startswith(_HIND_TOE) for bone in bones)
    for bone in bones:
        if bone.length < SHORTEST_M:
            continue
        eye, ear, claw = _EYE.fullmatch(bone.name), _EAR.fullmatch(bone.name), _CLAW.fullmatch(bone.name)
        if eye:
            shapes.append(_eye(bone, f"Eye{eye[1].upper()}"))
        elif ear:
            shapes.append(_ear(bone, f"Ear{ear[1].upper()}"))
        elif claw and has_hind_toes:
            shapes.append(_claw(bone, f"Claw {claw[1]}{claw[2]}"))
    return [shape for shape in shapes if shape]


def _between(bone, name: str, start: Vector, end: Vector, widths: tuple[float, float], x_like: Vector) -> TissueShape:
    return spanned(
        start,
        end,
        x_like=x_like,
        widths=widths,
        origin_tendon=0.0,
        insertion_tendon=0.0,
        name=name,
        kind="STUFFING",
        origin_bone=bone.name,
        insertion_bone=bone.name,
    )


def _eye(bone, name: str) -> TissueShape:
    head, along = bone.head_local, (bone.tail_local - bone.head_local).normalized()
    radius = EYE_OF_BONE * bone.length
    middle = head.lerp(bone.tail_local, 0.5)
    return _between(bone, name, middle - along * radius, middle + along * radius, (radius, radius), bone.z_axis)


def _ear(bone, name: str) -> TissueShape | None:
    """An ear from the root to the tip of the outline that its bones follow. None if the outline has no length."""
    outline = [bone, *bone.children_recursive]
    root = (bone.head_local + outline[-1].head_local) / 2
    tip = max((part.tail_local for part in outline), key=lambda point: (point - root).length)
    line = tip - root
    if line.length < SHORTEST_M:
        return None
    across = outline[-1].head_local - bone.head_local
    widths = (EAR_WIDTH * line.length, EAR_THICKNESS * line.length)
    return _between(bone, name, root - line * EAR_ROOT, tip, widths, across if across.length > SHORTEST_M else bone.z_axis)


def _claw(bone, name: str) -> TissueShape:
    line = bone.tail_local - bone.head_local
    width = CLAW_WIDTH * line.length
    return _between(bone, name, bone.head_local, bone.head_local + line * CLAW_LENGTH, (width, width), bone.z_axis)
