# SPDX-License-Identifier: GPL-3.0-or-later
"""Joint turns: rotations of one bone about one axis, with angles that Blender's drivers can read back.

A joint turn rotates a bone from the rest pose, either about an axis across the bone (a swing) or about the bone's Y
axis (a twist). Blender's drivers measure the same angles in the mode "Swing and Y Twist". For a swing by θ about the
axis (x, 0, z) they read 2·asin(x·sin(θ/2)) on X and 2·asin(z·sin(θ/2)) on Z, whatever the twist is. So

    θ = 2·asin(x·sin(X/2) + z·sin(Z/2))

which increases from -180° to 180° without a jump at right angles, and is 0 for a swing about the perpendicular axis
(docs/mathematics/baking.md, Joint turns).
"""

import json
import math
from dataclasses import dataclass

from mathutils import Quaternion, Vector

AXES = {"X": Vector((1.0, 0.0, 0.0)), "Y": Vector((0.0, 1.0, 0.0)), "Z": Vector((0.0, 0.0, 1.0))}
BEND = "bend"


@dataclass(frozen=True)
class JointTurn:
    """A rotation of one bone about one axis over a range of angles.

    axis: "X", "Y", "Z", or "bend" for the muscle axis. direction: the axis as a unit vector in the bone's rest axes,
    either Y or perpendicular to it. low, high: the range in radians; it contains the rest pose, 0.
    """

    bone: str
    axis: str
    direction: tuple[float, float, float]
    low: float
    high: float

    @property
    def is_twist(self) -> bool:
        return self.axis == "Y"

    def label(self, angle: float) -> str:
        """The name of a key at this angle, without its prefix."""
        return f"{self.bone} {self.axis if self.axis != BEND else ''}{math.degrees(angle):+.5g}"


# several joints turned at once: each turn with its angle, radians
TurnAngles = list[tuple[JointTurn, float]]


def rotation_of(angles: TurnAngles) -> Quaternion:
    """The rotation of one bone that is turned about several axes at once, so that drivers read back each angle."""
    swing, twist = Vector(), 0.0
    for turn, angle in angles:
        if turn.is_twist:
            twist += angle
        else:
            swing += Vector(turn.direction) * math.sin(0.5 * angle)
    real = math.sqrt(max(1.0 - swing.length_squared, 0.0))
    return Quaternion((real, *swing)) @ Quaternion(AXES["Y"], twist)


def to_json(angles: TurnAngles) -> str:
    """Returns turned joints as JSON, for a baked key: bone, axis, direction and angle of each."""
    return json.dumps([(turn.bone, turn.axis, turn.direction, angle) for turn, angle in angles])


def from_json(text: str) -> TurnAngles:
    """Reads the JSON of `to_json`. The range of each turn ends at its angle."""
    return [
        (JointTurn(bone, axis, tuple(direction), min(angle, 0.0), max(angle, 0.0)), angle)
        for bone, axis, direction, angle in json.loads(text)
    ]
