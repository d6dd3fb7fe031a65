# SPDX-License-Identifier: GPL-3.0-or-later
"""Tissues mirrored from one side of a rig to the other; sides are told by names, as Blender flips them.

Where a bone and its twin are mirror images in the rest pose, what lies around them is mirrored across the rig's local
X. Where they are not, the two bones' own frames say where it goes: along, across and around the bone, in its length.
"""

import re

import bpy
from mathutils import Matrix

from ..errors import SinewError
from ..scene import bone_geometry, characters, tissue_empty
from ..scene.tissue_empty import TissueShape
from . import edit, portable_names
from .transfer import BoneMap, bones_of, carried

ACROSS = Matrix.Diagonal((-1.0, 1.0, 1.0, 1.0))
SYMMETRIC_TO_OF_LENGTH = 1e-3
_NUMBER = re.compile(r"\.\d{3,}$")


def flipped(name: str) -> str:
    """The name of the twin on the other side; a name without side is its own twin."""
    return bpy.utils.flip_name(name)


def side_of_name(name: str) -> str:
    """The side that a name tells: "L", "R", or "" for none."""
    twin = flipped(name)
    at = next((place for place, (own, other) in enumerate(zip(name, twin)) if own != other), None)
    if at is None:
        return ""
    return "L" if name[at] in "lL" else "R"


def side_of(name: str, *bones: str) -> str:
    """The side that a tissue is on: as its name says, else its origin and insertion bones; "" on the centre line."""
    told = {side_of_name(bone) for bone in bones} - {""}
    # a name without side on bones of both sides is a muscle across the middle
    return side_of_name(name) or (told.pop() if len(told) == 1 else "")


def twin_name(name: str, side: str) -> str:
    """What the twin of a tissue of this side is called; a tissue whose bones alone tell its side gets the side's letter."""
    twin = flipped(name)
    if twin != name:
        return twin
    stem = _NUMBER.sub("", name)
    return f"{stem}.{'R' if side == 'L' else 'L'}"


def own_name(name: str, side: str) -> str:
    """The name with its side in it, so that the twin's flips back to it."""
    return name if side_of_name(name) else flipped(twin_name(name, side))


def twin_shape(shape: TissueShape, rig) -> TissueShape:
    """The tissue's mirror image on the other side. Raises SinewError where a bone has no twin."""
    side = side_of(shape.name, shape.origin_bone, shape.insertion_bone)
    maps = {bone: _bone_map(rig, bone, shape.name) for bone in bones_of(shape)}
    return carried(shape, twin_name(shape.name, side), maps, flipped)


def _bone_map(rig, name: str, tissue: str) -> BoneMap:
    twin = flipped(name)
    if not bone_geometry.has_bone(rig, twin):
        raise SinewError(f"{tissue}: {rig.name} has no bone '{twin}', the twin of '{name}', to carry its mirror image")
    length, twin_length = bone_geometry.bone_length(rig, name), bone_geometry.bone_length(rig, twin)
    near = SYMMETRIC_TO_OF_LENGTH * length
    ends = [(bone_geometry.point_along(rig, name, end), bone_geometry.point_along(rig, twin, end)) for end in (0.0, 1.0)]
    if all((ACROSS @ own - other).length <= near for own, other in ends):
        return BoneMap(twin, ACROSS)
    growth = twin_length / length
    own_rest, twin_rest = bone_geometry.rest_tail(rig, name), bone_geometry.rest_tail(rig, twin)
    return BoneMap(twin, twin_rest @ Matrix.Scale(growth, 4) @ ACROSS @ own_rest.inverted())


def _require_spheres(rig, shape: TissueShape, coming):
    missing = [name for name in shape.wraps if name not in coming and portable_names.find(rig, name) is None]
    if missing:
        raise SinewError(f"{shape.name}: goes round {missing[0]}, which {rig.name} has not: mirror that sphere, too")


def mirror(rig, empties: list, problems: dict[str, str]) -> list:
    """Mirrors tissues to the other side, where a twin is replaced or created; returns the twins' Empties.

    Tissues on the centre line are left as they are. `problems` gets one text for each that can't be mirrored.
    """
    wanted, tension = [], {}
    # a muscle's twin goes round the sphere's twin, so that comes first
    for empty in sorted(empties, key=lambda empty: empty.sinew.kind != "SPHERE"):
        try:
            shape = tissue_empty.read(empty, rig)
            side = side_of(shape.name, shape.origin_bone, shape.insertion_bone)
            if not side:
                continue
            twin = twin_shape(shape, rig)
            _require_spheres(rig, twin, tension)
        except SinewError as error:
            problems[empty.name] = str(error)
            continue
        if empty.name != own_name(empty.name, side):
            empty.name = own_name(empty.name, side)
        wanted.append(twin)
        tension[twin.name] = empty.sinew.tension
    twins = edit.put(rig, wanted)
    for shape, twin in zip(wanted, twins):
        twin.sinew.tension = tension[shape.name]
    characters.forget()
    return twins
