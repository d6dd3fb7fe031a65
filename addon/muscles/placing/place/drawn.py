# SPDX-License-Identifier: GPL-3.0-or-later
"""A muscle that the user draws on the body: from one point of the skin to another."""

from mathutils import Vector

from ....errors import SinewError
from ....scene import bone_geometry
from ....scene.tissue_empty import TissueShape
from ... import reshape
from ...axes import axes_along, perpendicular

TENDON_OF_LENGTH = 0.12
WIDTH_OF_LENGTH = 0.09
# of the way from the skin to the bone: muscles are attached under the skin
DEPTH = 0.6


def under_skin(rig, bone: str, point: Vector) -> Vector:
    """The attachment under a point of the skin, at rest in armature space."""
    return point.lerp(reshape.on_bone(rig, bone, point, 0.0), DEPTH)


def shape(rig, ends: tuple[tuple[str, Vector], tuple[str, Vector]], width_m: float = 0.0) -> TissueShape:
    """A muscle between two attachments: (bone, point at rest in armature space) of the origin and of the insertion.

    width_m: half the width of the belly; 0 chooses it by the length. Raises SinewError if both are on the same bone or at
    the same point.
    """
    (origin_bone, origin), (insertion_bone, insertion) = ends
    if origin_bone == insertion_bone:
        raise SinewError(f"Both ends are on '{origin_bone}'. Draw from one bone across a joint to another")
    line = insertion - origin
    if line.length < reshape.SHORTEST_M:
        raise SinewError("The muscle has no length. Draw from one place to another")
    tendon, width = TENDON_OF_LENGTH * line.length, width_m or WIDTH_OF_LENGTH * line.length
    aside = perpendicular(line.normalized(), bone_geometry.rest_axis(rig, origin_bone, 2))
    return TissueShape(
        name=f"Muscle {insertion_bone}",
        kind="MUSCLE",
        origin_bone=origin_bone,
        insertion_bone=insertion_bone,
        centre=(origin + insertion) / 2,
        rotation=axes_along(line.normalized(), aside).to_quaternion(),
        semi_axes=Vector((width, width, line.length / 2 - tendon)),
        origin_tendon=tendon,
        insertion_tendon=tendon,
    )
