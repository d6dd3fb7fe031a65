# SPDX-License-Identifier: GPL-3.0-or-later
"""Origin bone and insertion bone of a tissue: the parent bone of its Empty, and the bone of a muted constraint.

Blender updates both when a bone is renamed, and when the rig is duplicated or appended. A text property would keep the
old name.
"""

from mathutils import Matrix

from . import bone_geometry

INSERTION_CONSTRAINT = "Sinew Insertion"


def origin_bone(settings) -> str:
    """The bone that the Empty is a child of."""
    return settings.id_data.parent_bone


def set_origin_bone(settings, name: str):
    """Parents the Empty to another bone of its rig. Its rest-pose ellipsoid does not move. Unknown names are ignored."""
    empty = settings.id_data
    rig = empty.parent
    is_set = empty.parent_type == "BONE" and empty.parent_bone == name
    if is_set or rig is None or not bone_geometry.has_bone(rig, name):
        return  # the panel goes on showing the old bone
    had_bone = bone_geometry.has_bone(rig, empty.parent_bone)
    rest_parent = bone_geometry.rest_tail(rig, empty.parent_bone) @ empty.matrix_parent_inverse if had_bone else Matrix()
    empty.parent_type = "BONE"
    empty.parent_bone = name
    # last, because Blender resets it when the parent changes
    empty.matrix_parent_inverse = bone_geometry.rest_tail(rig, name).inverted() @ rest_parent


def insertion_bone(settings) -> str:
    """The bone that the muscle's constraint names, or an empty text."""
    return insertion_bone_of(settings.id_data)


def insertion_bone_of(empty) -> str:
    """The insertion bone of an Empty. Every frame calls this for every muscle, and the RNA property would be slower."""
    constraint = empty.constraints.get(INSERTION_CONSTRAINT)
    return constraint.subtarget if constraint else ""


def set_insertion_bone(settings, name: str):
    """Sets the bone that the muscle moves. An empty text removes the constraint."""
    empty = settings.id_data
    constraint = empty.constraints.get(INSERTION_CONSTRAINT)
    if not name:
        if constraint:
            empty.constraints.remove(constraint)
        return
    if constraint is None:
        constraint = empty.constraints.new("COPY_LOCATION")
        constraint.name = INSERTION_CONSTRAINT
        constraint.mute = True  # it only stores the name of the bone
        constraint.show_expanded = False
    constraint.target = empty.parent
    constraint.subtarget = name
