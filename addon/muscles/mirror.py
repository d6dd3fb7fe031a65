# SPDX-License-Identifier: GPL-3.0-or-later
"""Mirroring tissues from one side of a rig to the other. Names define the sides, as in Blender's Flip Names.

If a bone and its twin are mirror images in the rest pose, their tissues are mirrored across the rig's local X. Otherwise
they are mirrored in the axes of the two bones and scaled by the ratio of the bones' lengths.
"""

import bpy
from mathutils import Matrix

from ..errors import SinewError
from ..scene import bone_geometry, characters, tissue_empty
from ..scene.tissue_empty import TissueShape
from . import edit, portable_names
from .transfer import BoneMap, bones_of, transferred

MIRROR_X = Matrix.Diagonal((-1.0, 1.0, 1.0, 1.0))
SYMMETRY_OF_LENGTH = 1e-3  # distance from the mirror image that counts as symmetric, as a fraction of the bone's length


def flipped(name: str) -> str:
    """The name of the twin on the other side; the same name if it has no side."""
    return bpy.utils.flip_name(name)


def side_of_name(name: str) -> str:
    """The side in a name: "L", "R", or "" for none."""
    first_changed = next((letter for letter, flipped_letter in zip(name, flipped(name)) if letter != flipped_letter), None)
    if first_changed is None:
        return ""
    return "L" if first_changed in "lL" else "R"


def side_of(name: str, *bones: str) -> str:
    """The side of a tissue: from its name, else from its origin and insertion bones; "" on the centre line."""
    sides = {side_of_name(bone) for bone in bones} - {""}
    # a tissue without a side in its name, on bones of both sides, crosses the middle
    return side_of_name(name) or (sides.pop() if len(sides) == 1 else "")


def twin_name(name: str, side: str) -> str:
    """The name of the twin of a tissue on this side. A name without a side gets the letter of the other side."""
    twin = flipped(name)
    if twin != name:
        return twin
    return f"{portable_names.without_number(name)}.{'R' if side == 'L' else 'L'}"


def sided_name(name: str, side: str) -> str:
    """The name of a tissue on this side, with the side in it, so that the name of its twin flips back to it."""
    return name if side_of_name(name) else flipped(twin_name(name, side))


def twin_shape(shape: TissueShape, rig) -> TissueShape:
    """The mirror image of a tissue on the other side. Raises SinewError if a bone has no twin."""
    side = side_of(shape.name, shape.origin_bone, shape.insertion_bone)
    maps = {bone: _bone_map(rig, bone, shape.name) for bone in bones_of(shape)}
    return transferred(shape, twin_name(shape.name, side), maps, flipped)


def is_wanted(rig) -> bool:
    """Whether edits of a rig's tissues are to be mirrored: Sinew's X Mirror or that of the armature is on."""
    return (rig.sinew.rig.mirror_x or rig.data.use_mirror_x) and not rig.library


def write_twin(rig, empty):
    """Gives the twin of a tissue its mirror image. Does nothing without a twin of the same kind."""
    named = portable_names.of_rig(rig)
    own_name = next(name for name, known in named.items() if known == empty)
    name = flipped(own_name)
    twin = named.get(name) if name != own_name else None
    if twin is None or twin.sinew.tissue.kind != empty.sinew.tissue.kind:
        return
    try:
        shape = twin_shape(portable_names.with_portable_names(tissue_empty.read(empty, rig), named), rig)
    except SinewError:
        return  # during an edit (a scale of 0, no bone yet); the panel shows the problem, and the next edit is mirrored
    tissue_empty.write(twin, portable_names.with_object_names(shape, named))


def _bone_map(rig, name: str, tissue: str) -> BoneMap:
    twin = flipped(name)
    if not bone_geometry.has_bone(rig, twin):
        raise SinewError(f"{tissue}: {rig.name} has no bone '{twin}', the twin of '{name}', for its mirror image")
    length, twin_length = bone_geometry.bone_length(rig, name), bone_geometry.bone_length(rig, twin)
    near = SYMMETRY_OF_LENGTH * length
    ends = [(bone_geometry.point_along(rig, name, end), bone_geometry.point_along(rig, twin, end)) for end in (0.0, 1.0)]
    if all((MIRROR_X @ point - twin_point).length <= near for point, twin_point in ends):
        return BoneMap(twin, MIRROR_X)
    scale = twin_length / length
    rest, twin_rest = bone_geometry.rest_tail(rig, name), bone_geometry.rest_tail(rig, twin)
    return BoneMap(twin, twin_rest @ Matrix.Scale(scale, 4) @ MIRROR_X @ rest.inverted())


def _require_spheres(rig, shape: TissueShape, added):
    """Raises SinewError if a muscle wraps around a sphere that the rig lacks and that is not in the added names."""
    named = portable_names.of_rig(rig) if set(shape.wraps) - set(added) else {}
    missing = [name for name in shape.wraps if name not in added and name not in named]
    if missing:
        raise SinewError(
            f"{shape.name} wraps around sphere '{missing[0]}', which {rig.name} does not have. Mirror that sphere, too"
        )


def mirror(rig, empties: list, problems: dict[str, str]) -> list:
    """Mirrors tissues to the other side, where twins are replaced or created. Returns the Empties of the twins.

    Tissues on the centre line are not changed. problems: gets one message, by name, for each tissue that can't be mirrored.
    """
    twin_shapes, tension, named = [], {}, portable_names.of_rig(rig)
    # spheres first: the twin of a muscle wraps around the twin of its sphere
    for empty in sorted(empties, key=lambda empty: empty.sinew.tissue.kind != "SPHERE"):
        try:
            shape = portable_names.with_portable_names(tissue_empty.read(empty, rig), named)
            side = side_of(shape.name, shape.origin_bone, shape.insertion_bone)
            if not side:
                continue
            twin = twin_shape(shape, rig)
            _require_spheres(rig, twin, tension)
        except SinewError as error:
            problems[empty.name] = str(error)
            continue
        if shape.name != sided_name(shape.name, side):
            portable_names.rename(empty, sided_name(shape.name, side))
        twin_shapes.append(twin)
        tension[twin.name] = empty.sinew.tissue.tension
    twins = edit.add_or_update(rig, twin_shapes)
    for shape, twin in zip(twin_shapes, twins):
        twin.sinew.tissue.tension = tension[shape.name]
    characters.forget()
    return twins
