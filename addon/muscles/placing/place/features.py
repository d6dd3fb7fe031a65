# SPDX-License-Identifier: GPL-3.0-or-later
"""Eyes, ears, muzzle, nose, cheeks, toes, pads and claws of an animal, as stuffing on bones with Rigify's names for them.

Presets hold the tissues of the papers only. These features make a skin that is grown over the tissues recognisable. Rigify's
face bones trace the outline of a face, so the sizes follow from them. Rigs with these names have Z up.
"""

import re
from collections.abc import Iterator

from mathutils import Vector

from ....scene.tissue_empty import TissueShape
from ...transfer import spanned

# The first word of a feature's name, and what its surface is made of.
EYE, EAR, MUZZLE, CHIN, CHEEK, NOSE, TOE, PAD, CLAW = "Eye", "Ear", "Muzzle", "Chin", "Cheek", "Nose", "Toe", "Pad", "Claw"

_SIDES = (".L", ".R")
_DIGIT = re.compile(r"([fr]_(?:index|middle|ring|pinky))\.0*1(\.[LR])")
_HIND_TOE = "r_index."  # fingers get claws only if the hind feet have toes of the same kind
_SOLE = re.compile(r"(?:f_toe|r_toe|front_toe|toe)(\.[LR])")
_UP = Vector((0, 0, 1))
_FORWARD = Vector((0, -1, 0))

EYE_OF_BONE = 0.28  # radius, as a fraction of the bone's length
# Semi-axes of an ear's base and tip across the ear, and how far the tip goes beyond the bones, as fractions of its length.
# Base and tip make a pointed ear. Bones that trace an outline are inside of the ear's edge; bones in a row are its middle.
EAR_OUTLINED, EAR_IN_A_ROW = (0.6, 0.3, 0.5), (0.32, 0.2, 0.1)
EAR_THICKNESS = 0.16
EAR_ROOT = 0.5  # how far the base goes toward the middle of the head
MUZZLE_WIDTH = 1.35  # of half the distance of the nostrils' bones
MUZZLE_DEPTH = 1.0  # of the height of the bridge over the lips
MUZZLE_BACK = 0.5  # how far the muzzle goes into the head, as a fraction of its length
NOSE_OF_NOSTRILS = 0.36  # radius, as a fraction of half the distance of the nostrils' bones
WHISKERS_OF_NOSTRILS, WHISKERS_INWARD = 0.8, 0.65  # radius, and fraction of the distance from the middle of the face
CHEEK_OF_LENGTH = 0.55  # semi-axes across, as fractions of the length between jaw and cheek
CHEEK_INWARD = 0.7  # fraction of the distance from the middle of the face at which cheeks are
FACE_WIDTH = 0.55  # of a hoofed animal's cheek bone: half-width of its long face
TOE_WIDTH = 0.52  # of the distance between two toes
CLAW_WIDTH, CLAW_LENGTH = 0.16, 0.8  # as fractions of the length of the toe's last bone
PAD_OF_TOE = 0.9  # radius of a toe's pad, as a fraction of the toe's
SHORTEST_M = 1e-6


def features(rig) -> list[TissueShape]:
    """The features of a rig, in armature space. Empty if no bone has a name of such a feature."""
    bones = rig.data.bones
    made = [*_eyes(bones), *_ears(bones), *_face(bones), *_long_face(bones), *_paws(bones)]
    return [shape for shape in made if shape]


def is_feature(name: str, *kinds: str) -> bool:
    """Whether a tissue of this name is a feature of one of these kinds, such as `EYE`."""
    return name.split(".")[0].split(" ")[0] in kinds


def _between(bone, name: str, start: Vector, end: Vector, widths: tuple[float, float], x_like: Vector) -> TissueShape | None:
    """An ellipsoid between two poles. widths: semi-axes along `x_like` and across it. None if it has no size."""
    if (end - start).length < SHORTEST_M or min(widths) < SHORTEST_M:
        return None
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


def _ball(bone, name: str, centre: Vector, radius: float) -> TissueShape | None:
    along = _UP * radius
    return _between(bone, name, centre - along, centre + along, (radius, radius), _FORWARD)


def _eyes(bones) -> Iterator[TissueShape | None]:
    for side in _SIDES:
        eye = bones.get(f"eye{side}")
        if eye:
            yield _ball(eye, f"{EYE}{side}", eye.head_local.lerp(eye.tail_local, 0.5), EYE_OF_BONE * eye.length)


def _ears(bones) -> Iterator[TissueShape | None]:
    """A wide base and a narrow tip, from the root to the tip of the outline that the ear's bones follow."""
    for side in _SIDES:
        ear = bones.get(f"ear{side}")
        if ear is None:
            continue
        outline = [ear, *ear.children_recursive]
        is_outline = (outline[-1].tail_local - ear.head_local).length < 0.5 * outline[-1].length
        root = (ear.head_local + outline[-1].head_local) / 2 if is_outline else ear.head_local
        base, tip_width, beyond = EAR_OUTLINED if is_outline else EAR_IN_A_ROW
        tip = max((part.tail_local for part in outline), key=lambda point, root=root: (point - root).length)
        line = tip - root
        length = line.length
        if length < SHORTEST_M:
            continue
        ahead = _FORWARD - line * (_FORWARD.dot(line) / length**2)  # the ear's flat side faces forward
        thickness = EAR_THICKNESS * length
        inside = root.lerp(Vector((0.0, root.y, root.z - length)), EAR_ROOT)
        base_end, tip_start = root + line * 0.8, root + line * 0.1
        yield _between(ear, f"{EAR}{side}", inside, base_end, (thickness, base * length), ahead)
        yield _between(ear, f"{EAR} tip{side}", tip_start, tip + line * beyond, (0.8 * thickness, tip_width * length), ahead)


def _face(bones) -> Iterator[TissueShape | None]:
    """The muzzle, nose, chin and cheeks of Rigify's face."""
    named = [bones.get(name) for name in ("face", "jaw", "nose.001", "lip.T.L", "nose.L", "cheek.T.L.001", "chin.001")]
    if None in named:
        return
    face, jaw, ridge, lip, nostril, cheek, chin = named
    tip, half_m = ridge.tail_local, abs(nostril.head_local.x)
    back = Vector((0.0, cheek.head_local.y, cheek.head_local.z))
    front = tip.lerp(lip.head_local, 0.5)
    height_m = (tip - lip.head_local).length
    yield _between(
        face,
        MUZZLE,
        back + (back - front) * MUZZLE_BACK,
        front + (front - back).normalized() * (0.1 * half_m),
        (MUZZLE_DEPTH * height_m, MUZZLE_WIDTH * half_m),
        _UP,
    )
    yield _ball(face, NOSE, tip, NOSE_OF_NOSTRILS * half_m)
    for side in _SIDES:
        corner, wing = bones.get(f"lip.T{side}"), bones.get(f"nose{side}")
        if corner and wing:
            centre = corner.tail_local.lerp(wing.head_local, 0.45)
            centre = Vector((centre.x * WHISKERS_INWARD, centre.y, centre.z))
            yield _ball(face, f"{MUZZLE} whiskers{side}", centre, WHISKERS_OF_NOSTRILS * half_m)
    end = chin.tail_local
    yield _between(jaw, CHIN, jaw.head_local.lerp(end, 0.2), end, (0.6 * height_m, 0.95 * half_m), _UP)
    for side in _SIDES:
        corner, swell = bones.get(f"jaw{side}"), bones.get(f"cheek.B{side}")
        if corner and swell:
            start, end = (
                Vector((point.x * CHEEK_INWARD, point.y, point.z)) for point in (corner.head_local, swell.tail_local)
            )
            end = end + (end - start) * 0.15
            radius = CHEEK_OF_LENGTH * (end - start).length
            yield _between(face, f"{CHEEK}{side}", start, end, (radius, radius), _UP)


def _long_face(bones) -> Iterator[TissueShape | None]:
    """The face of Rigify's horse, along its skull: deep at the cheeks, narrow at the muzzle."""
    skull, cheek = bones.get("skull"), bones.get("skull.L")
    if skull is None or cheek is None:
        return
    half_m, start, end = FACE_WIDTH * abs(cheek.tail_local.x), skull.head_local, skull.tail_local
    line = end - start
    across = Vector((0, -line.z, line.y))
    yield _between(skull, CHEEK, start, start.lerp(end, 0.75), (1.35 * half_m, half_m), across)
    yield _between(skull, MUZZLE, start.lerp(end, 0.4), end + line * 0.05, (1.0 * half_m, 0.85 * half_m), across)


def _paws(bones) -> Iterator[TissueShape | None]:
    """Toes with a pad and a claw each, and the pad of the foot."""
    if not any(bone.name.startswith(_HIND_TOE) for bone in bones):
        return
    widths = {}
    for first in bones:
        digit = _DIGIT.fullmatch(first.name)
        if not digit:
            continue
        last = [first, *first.children_recursive][-1]
        start, end = first.head_local, last.tail_local
        line = end - start
        if line.length < SHORTEST_M:
            continue
        radius = TOE_WIDTH * _to_next_toe(bones, first, digit[1][:2], digit[2])
        name = f"{digit[1]}{digit[2]}"
        widths.setdefault((digit[1][:2], digit[2]), radius)
        reach = line.normalized() * radius
        yield _between(last, f"{TOE} {name}", start - reach, end - reach * 0.2, (radius, radius), _UP)
        forward = Vector((line.x, line.y, 0.0)).normalized() if line.to_2d().length > SHORTEST_M else line.normalized()
        claw = forward * 0.8 - _UP * 0.45
        width = CLAW_WIDTH * last.length
        yield _between(
            last,
            f"{CLAW} {name}",
            end - forward * width,
            end + claw * (CLAW_LENGTH * last.length),
            (width * 1.4, width),
            _UP,
        )
        centre = last.head_local.lerp(end, 0.4) - _UP * (0.55 * radius)
        pad = PAD_OF_TOE * radius
        yield _between(last, f"{PAD} {name}", centre - forward * pad, centre + forward * pad, (0.6 * pad, 0.8 * pad), _UP)
    for bone in bones:
        sole = _SOLE.fullmatch(bone.name)
        fore = bone.name.startswith("f")
        radius = widths.get(("f_" if fore else "r_", sole[1])) if sole else None
        if radius:
            centre = bone.head_local.lerp(bone.tail_local, 0.35)
            forward = (bone.tail_local - bone.head_local) * 0.5
            centre = Vector((centre.x, centre.y, bone.tail_local.z + 0.7 * radius))
            yield _between(
                bone,
                f"{PAD} {'fore' if fore else 'hind'} foot{sole[1]}",
                centre - forward.normalized() * radius * 1.2,
                centre + forward.normalized() * radius * 1.2,
                (0.8 * radius, 1.7 * radius),
                _UP,
            )


def _to_next_toe(bones, toe, limb: str, side: str) -> float:
    """The distance to the nearest other toe of the same foot, m; the toe's length if it is the only one."""
    others = [
        bone.head_local
        for bone in bones
        if (found := _DIGIT.fullmatch(bone.name)) and found[1][:2] == limb and found[2] == side and bone.name != toe.name
    ]
    return min(((other - toe.head_local).length for other in others), default=toe.length)
