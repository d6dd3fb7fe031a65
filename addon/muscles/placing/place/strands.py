# SPDX-License-Identifier: GPL-3.0-or-later
"""Joining the strands of one muscle to one belly: one ellipsoid looks better than a fan of a dozen thin ones.

The belly lies on the mean of the strands' lines. Its cross-section has the sum of their areas and is twice as wide as it is
thick. It is attached to the bones that most strands are attached to. It has no via points.
"""

from collections import Counter
from dataclasses import replace

from mathutils import Vector

from ....scene.tissue_empty import TissueShape
from ...axes import axes_along

THICKNESS_RATIO = 0.5
SHORTEST_LINE_M = 1e-6


def joined(strands: list[TissueShape], name: str) -> TissueShape:
    """One tissue for strands that run side by side. A single strand, or a mean line without length: only a new name."""
    if len(strands) == 1:
        return replace(strands[0], name=name)
    origin, insertion = _mean([strand.origin for strand in strands]), _mean([strand.insertion for strand in strands])
    length_m = (insertion - origin).length
    if length_m < SHORTEST_LINE_M:
        return replace(strands[0], name=name)
    line = (insertion - origin) / length_m
    origin_tendon = length_m * _mean_fraction(strands, "origin_tendon")
    insertion_tendon = length_m * _mean_fraction(strands, "insertion_tendon")
    half_belly_m = (length_m - origin_tendon - insertion_tendon) / 2
    area = sum(strand.semi_axes.x * strand.semi_axes.y for strand in strands)
    outward = _mean([strand.rotation @ Vector((1, 0, 0)) for strand in strands])

    return replace(
        strands[0],
        name=name,
        origin_bone=_most_common([strand.origin_bone for strand in strands]),
        insertion_bone=_most_common([strand.insertion_bone for strand in strands]),
        centre=origin + line * (origin_tendon + half_belly_m),
        rotation=axes_along(line, outward).to_quaternion(),
        semi_axes=Vector(((area * THICKNESS_RATIO) ** 0.5, (area / THICKNESS_RATIO) ** 0.5, half_belly_m)),
        origin_tendon=origin_tendon,
        insertion_tendon=insertion_tendon,
        via_points=(),
    )


def _mean(vectors: list[Vector]) -> Vector:
    return sum(vectors, Vector()) / len(vectors)


def _mean_fraction(strands: list[TissueShape], tendon: str) -> float:
    """The mean length of a tendon as a fraction of the strand's length."""
    return sum(getattr(strand, tendon) / (strand.insertion - strand.origin).length for strand in strands) / len(strands)


def _most_common(names: list[str]) -> str:
    """The most frequent name; of equally frequent ones the first in alphabetical order."""
    return max(Counter(sorted(names)).items(), key=lambda counted: counted[1])[0]
