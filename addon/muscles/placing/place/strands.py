# SPDX-License-Identifier: GPL-3.0-or-later
"""Strands of one muscle joined to one belly: where a model tells a fan by a dozen thin lines, one ellipsoid looks better.

The belly lies on the mean of its strands' lines and has the sum of their cross-sections, twice as wide as it is thick;
it moves with the bones that most of them are on. Via points are left out, for the mean line has none.
"""

from collections import Counter
from dataclasses import replace

from mathutils import Matrix, Vector

from ....scene.tissue_empty import TissueShape

THICKNESS_RATIO = 0.5
SHORTEST_LINE_M = 1e-6


def joined(strands: list[TissueShape], name: str) -> TissueShape:
    """One belly for strands that run side by side; a single strand only gets the name."""
    if len(strands) == 1:
        return replace(strands[0], name=name)
    origin, insertion = _mean([strand.origin for strand in strands]), _mean([strand.insertion for strand in strands])
    length_m = (insertion - origin).length
    if length_m < SHORTEST_LINE_M:
        return replace(strands[0], name=name)
    line = (insertion - origin) / length_m
    origin_tendon = length_m * _share(strands, "origin_tendon")
    insertion_tendon = length_m * _share(strands, "insertion_tendon")
    half_belly_m = (length_m - origin_tendon - insertion_tendon) / 2
    area = sum(strand.semi_axes.x * strand.semi_axes.y for strand in strands)
    outward = _mean([strand.rotation @ Vector((1, 0, 0)) for strand in strands])
    x = outward - line * outward.dot(line)
    x = x.normalized() if x.length > SHORTEST_LINE_M else line.orthogonal().normalized()
    return replace(
        strands[0],
        name=name,
        origin_bone=_commonest([strand.origin_bone for strand in strands]),
        insertion_bone=_commonest([strand.insertion_bone for strand in strands]),
        centre=origin + line * (origin_tendon + half_belly_m),
        rotation=Matrix((x, line.cross(x), line)).transposed().to_quaternion(),
        semi_axes=Vector(((area * THICKNESS_RATIO) ** 0.5, (area / THICKNESS_RATIO) ** 0.5, half_belly_m)),
        origin_tendon=origin_tendon,
        insertion_tendon=insertion_tendon,
        via_points=(),
    )


def _mean(vectors: list[Vector]) -> Vector:
    return sum(vectors, Vector()) / len(vectors)


def _share(strands: list[TissueShape], tendon: str) -> float:
    return sum(getattr(strand, tendon) / (strand.insertion - strand.origin).length for strand in strands) / len(strands)


def _commonest(names: list[str]) -> str:
    return max(Counter(sorted(names)).items(), key=lambda counted: counted[1])[0]
