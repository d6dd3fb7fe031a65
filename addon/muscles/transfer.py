# SPDX-License-Identifier: GPL-3.0-or-later
"""Taking a tissue from some bones to others: across the rig's middle, or to another character.

Points go with the bone that they belong to. A muscle's belly follows from its two ends, so that a character of other
proportions gets a belly of its own length; its widths and tendons grow with the length.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from mathutils import Matrix, Quaternion, Vector

from ..scene.tissue_empty import TissueShape


@dataclass(frozen=True)
class BoneMap:
    """Where a bone's surroundings go in the rest pose: to which bone, and by which map of armature space."""

    bone: str
    matrix: Matrix


def carried(shape: TissueShape, name: str, maps: Mapping[str, BoneMap], name_of_tissue: Callable[[str], str]) -> TissueShape:
    """The tissue as other bones carry it.

    maps: for the bone of each of the tissue's points. name_of_tissue: what a wrapped tissue is called there.
    """
    origin_map, insertion_map = maps[shape.origin_bone], maps[shape.insertion_bone]
    origin, insertion = origin_map.matrix @ shape.origin, insertion_map.matrix @ shape.insertion
    growth = (insertion - origin).length / (shape.insertion - shape.origin).length
    x = shape.rotation @ Vector((1.0, 0.0, 0.0))
    x = sum((found.matrix.to_3x3() @ x for found in (origin_map, insertion_map)), Vector())
    return spanned(
        origin,
        insertion,
        x_like=x,
        name=name,
        kind=shape.kind,
        origin_bone=origin_map.bone,
        insertion_bone=insertion_map.bone,
        widths=(shape.semi_axes.x * growth, shape.semi_axes.y * growth),
        origin_tendon=shape.origin_tendon * growth,
        insertion_tendon=shape.insertion_tendon * growth,
        volume_keeping=shape.volume_keeping,
        via_points=tuple((maps[bone].bone, maps[bone].matrix @ point) for bone, point in shape.via_points),
        wraps=tuple(map(name_of_tissue, shape.wraps)),
        skin_thickness=shape.skin_thickness * growth,
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
    """The tissue between two points (a rigid one: its two poles), its x axis as near `x_like` as can be."""
    line = insertion - origin
    direction = line.normalized()
    belly = line.length - origin_tendon - insertion_tendon
    return TissueShape(
        centre=origin + direction * (origin_tendon + belly / 2),
        rotation=rotation_of(x_like, direction),
        semi_axes=Vector((*widths, belly / 2)),
        origin_tendon=origin_tendon,
        insertion_tendon=insertion_tendon,
        **settings,
    )


def rotation_of(x_like: Vector, z: Vector) -> Quaternion:
    """The axes with this z, and x as near `x_like` as can be."""
    x = x_like - z * x_like.dot(z)
    x = x.normalized() if x.length > 1e-6 * x_like.length else z.orthogonal().normalized()
    return Matrix((x, z.cross(x), z)).transposed().to_quaternion()


def bones_of(shape: TissueShape) -> tuple[str, ...]:
    """All bones that a tissue has points on."""
    return tuple(dict.fromkeys((shape.origin_bone, shape.insertion_bone, *(bone for bone, _ in shape.via_points))))
