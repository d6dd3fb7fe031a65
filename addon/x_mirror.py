# SPDX-License-Identifier: GPL-3.0-or-later
"""X-mirror while editing: a tissue that a person moves takes its twin with it, as bones do in the armature's Edit Mode."""

from . import mirroring, musculature, rig_io, roster, tissue_io
from .errors import SinewError

SAME_TO_OF_LENGTH = 1e-6


def is_on(rig) -> bool:
    """Whether edits of a rig's tissues are mirrored: by its own option or by Blender's, and in the rest pose alone."""
    return (rig.sinew.mirror_x or rig.data.use_mirror_x) and not rig.library and rig_io.is_resting(rig)


def follow(reported: set[int]):
    """Writes the twins of tissues that changed; where both of a pair did, each keeps its place.

    reported: session-wide identifiers of the objects that Blender reports as transformed. What is written here is not
    reported: see `handlers`.
    """
    for character in roster.characters():
        rig = character.rig.find()
        if rig is None or rig.type != "ARMATURE" or not is_on(rig):
            continue
        tissues = (key.find() for key in character.tissues)
        moved = [empty for empty in tissues if empty is not None and empty.session_uid in reported]
        if len(moved) == len(character.tissues) > 1:
            continue  # the rig moved, and all with it; also the first evaluation of a file
        for empty in moved:
            _write_twin(rig, empty, reported)


def _write_twin(rig, empty, reported: set[int]):
    name = mirroring.flipped(empty.name)
    twin = musculature.find(rig, name) if name != empty.name else None
    if twin is None or twin.session_uid in reported or twin.sinew.kind != empty.sinew.kind:
        return
    try:
        wanted, present = mirroring.twin_shape(tissue_io.read(empty, rig), rig), tissue_io.read(twin, rig)
    except SinewError:
        return  # halfway through an edit (a scale of 0, no bone yet): the panel says so, and the next edit mirrors again
    if _differ(wanted, present):
        tissue_io.write(twin, wanted)


def _differ(wanted, present) -> bool:
    near = SAME_TO_OF_LENGTH * max(wanted.semi_axes)
    places = ((wanted.centre, present.centre), (wanted.semi_axes, present.semi_axes))
    if any((own - other).length > near for own, other in places):
        return True
    if wanted.rotation.rotation_difference(present.rotation).angle > SAME_TO_OF_LENGTH:
        return True
    return any(
        abs(getattr(wanted, name) - getattr(present, name)) > near
        for name in ("origin_tendon", "insertion_tendon", "volume_keeping")
    )
