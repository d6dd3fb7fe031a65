# SPDX-License-Identifier: GPL-3.0-or-later
"""The two bones of a muscle, kept where Blender mends their names: the Empty's parent bone and a muted constraint."""

from mathutils import Matrix

from . import bone_geometry

INSERTION_CONSTRAINT = "Sinew Insertion"


def origin_bone(settings) -> str:
    """The bone that the Empty hangs on."""
    return settings.id_data.parent_bone


def set_origin_bone(settings, name: str):
    """Hangs the Empty on another bone of its rig; a name that is no bone leaves it where it is."""
    empty = settings.id_data
    rig = empty.parent
    is_set = empty.parent_type == "BONE" and empty.parent_bone == name
    if is_set or rig is None or not bone_geometry.has_bone(rig, name):
        return  # the old bone stays, and is shown
    # the ellipsoid stays where it is in the rest pose
    had_bone = bone_geometry.has_bone(rig, empty.parent_bone)
    place = bone_geometry.rest_tail(rig, empty.parent_bone) @ empty.matrix_parent_inverse if had_bone else Matrix()
    empty.parent_type = "BONE"
    empty.parent_bone = name
    # last: Blender makes it the identity when it parents
    empty.matrix_parent_inverse = bone_geometry.rest_tail(rig, name).inverted() @ place


def insertion_bone(settings) -> str:
    """The bone that the muscle's constraint names, or an empty text."""
    return insertion_bone_of(settings.id_data)


def insertion_bone_of(empty) -> str:
    """The same, asked of the Empty: in every frame of every muscle, a property that asks Python takes too long."""
    constraint = empty.constraints.get(INSERTION_CONSTRAINT)
    return constraint.subtarget if constraint else ""


def set_insertion_bone(settings, name: str):
    """Names the bone that the muscle pulls; an empty text takes the constraint away."""
    empty = settings.id_data
    constraint = empty.constraints.get(INSERTION_CONSTRAINT)
    if not name:
        if constraint:
            empty.constraints.remove(constraint)
        return
    if constraint is None:
        # a muted constraint does nothing but hold the bone's name, and Blender mends it when the bone is renamed and
        # when the rig is duplicated or appended: a string of our own would be left behind
        constraint = empty.constraints.new("COPY_LOCATION")
        constraint.name = INSERTION_CONSTRAINT
        constraint.mute = True
        constraint.show_expanded = False
    constraint.target = empty.parent
    constraint.subtarget = name
