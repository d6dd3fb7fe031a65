# SPDX-License-Identifier: GPL-3.0-or-later
"""Transferring a tissue from some bones to others: to the other side of a rig, or to another character.

Each point is mapped with its bone. The belly of a muscle follows from its mapped origin and insertion, so that it fits a
character with other proportions. Widths and tendons are scaled by the change of the length.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from mathutils import Matrix, Vector

from ..scene.tissue_empty import TissueShape
from .axes import axes_along


@dataclass(frozen=True)
class BoneMap:
    """The target bone of a bone, and the map of armature space in the rest pose that takes the bone's surroundings there."""

    bone: str
    matrix: Matrix


def transferred(
    shape: TissueShape, name: str, maps: Mapping[str, BoneMap], name_of_tissue: Callable[[str], str]
) -> TissueShape:
    """The tissue on other bones.

    name: its new name. maps: for each bone that the tissue has a point on. name_of_tissue: maps the names of wrapping
    spheres.
    """
    origin_map, insertion_map = maps[shape.origin_bone], maps[shape.insertion_bone]
    origin, insertion = origin_map.matrix @ shape.origin, insertion_map.matrix @ shape.insertion
    scale = (insertion - origin).length / (shape.insertion - shape.origin).length
    x = shape.rotation @ Vector((1.0, 0.0, 0.0))
    x = sum((bone_map.matrix.to_3x3() @ x for bone_map in (origin_map, insertion_map)), Vector())
    return spanned(
        origin,
        insertion,
        x_like=x,
        name=name,
        kind=shape.kind,
        origin_bone=origin_map.bone,
        insertion_bone=insertion_map.bone,
        widths=(shape.semi_axes.x * scale, shape.semi_axes.y * scale),
        origin_tendon=shape.origin_tendon * scale,
        insertion_tendon=shape.insertion_tendon * scale,
        volume_keeping=shape.volume_keeping,
        via_points=tuple((maps[bone].bone, maps[bone].matrix @ point) for bone, point in shape.via_points),
        wraps=tuple(map(name_of_tissue, shape.wraps)),
        skin_thickness=shape.skin_thickness * scale,
    )


def spanned(
    origin: Vector,
    insertion: Vector,
    *,
    x_like: Vector,
    widths: tuple[float, float],
    origin_tendon: float,
    insertion_tendon: float,
    **settings,
) -> TissueShape:
    """The tissue between two points: origin and insertion of a muscle, or the two poles of a rigid tissue.

    x_like: direction that its x axis is as close to as possible. widths: semi-axes along x and y. Lengths in metres,
    armature space. settings: all other fields of `TissueShape`.
    """
    line = insertion - origin
    direction = line.normalized()
    belly = line.length - origin_tendon - insertion_tendon
    return TissueShape(
        centre=origin + direction * (origin_tendon + belly / 2),
        rotation=axes_along(direction, x_like).to_quaternion(),
        semi_axes=Vector((*widths, belly / 2)),
        origin_tendon=origin_tendon,
        insertion_tendon=insertion_tendon,
        **settings,
    )


def bones_of(shape: TissueShape) -> tuple[str, ...]:
    """The bones that a tissue has points on, each once."""
    return tuple(dict.fromkeys((shape.origin_bone, shape.insertion_bone, *(bone for bone, _ in shape.via_points))))
