# SPDX-License-Identifier: GPL-3.0-or-later
"""How Empties show their tissues in a pose: through delta transforms, which leave alone what the person set."""

from mathutils import Euler, Matrix, Quaternion, Vector

from . import rig_io
from .tissue_io import rest_transform


class Shown:
    """How one Empty shows its tissue in a pose: by delta transforms, so that what the person set stays as it is."""

    def __init__(self, empty, rig):
        self._location, self._rotation, scale = rest_transform(empty)
        self._scale = scale * empty.empty_display_size
        self._mode = empty.rotation_mode
        self._from_origin_bone = (
            Matrix.Translation((0.0, rig_io.bone_length(rig, empty.parent_bone), 0.0)) @ empty.matrix_parent_inverse
        ).inverted_safe()

    def show(self, empty, in_origin_bone: Matrix):
        """in_origin_bone: the unit sphere to the posed ellipsoid, in the space of the posed origin bone."""
        location, rotation, scale = (self._from_origin_bone @ in_origin_bone).decompose()
        empty.delta_location = location - self._location
        empty.delta_scale = [wanted / own for wanted, own in zip(scale, self._scale)]
        turn = rotation @ self._rotation.inverted()
        if self._mode == "QUATERNION":
            empty.delta_rotation_quaternion = turn
        elif self._mode != "AXIS_ANGLE":  # Blender gives scripts no delta for an axis and angle
            empty.delta_rotation_euler = turn.to_euler(self._mode)


def show_rest(empty):
    """Takes the delta transforms away: the Empty is the rest-pose ellipsoid, carried by its origin bone alone."""
    for name, nothing in (
        ("delta_location", Vector()),
        ("delta_scale", Vector((1.0, 1.0, 1.0))),
        ("delta_rotation_quaternion", Quaternion()),
        ("delta_rotation_euler", Euler()),
    ):
        if getattr(empty, name) != nothing:
            setattr(empty, name, nothing)
