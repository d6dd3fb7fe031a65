# SPDX-License-Identifier: GPL-3.0-or-later
"""X-mirror while editing: a tissue that a person moves takes its twin with it, as bones do in the armature's Edit Mode."""

import numpy as np

from ..errors import SinewError
from ..muscles import mirror, portable_names
from ..scene import characters, rig_pose, tissue_empty
from . import session, tissue_snapshot
from .rig_cache import RigState


def is_on(rig) -> bool:
    """Whether edits of a rig's tissues are mirrored: by its own option or by Blender's, and in the rest pose alone."""
    return (rig.sinew.mirror_x or rig.data.use_mirror_x) and not rig.library and rig_pose.is_resting(rig)


def follow():
    """Writes the twins of tissues that were edited since the last frame; where both of a pair were, each keeps its place."""
    for character in characters.in_file():
        rig = character.rig.find()
        if rig is None or rig.type != "ARMATURE" or not is_on(rig):
            continue
        tissues = [key.find() for key in character.tissues]
        vias = characters.vias_of(rig)
        edited = _edited(session.kept_rig(rig), tissues, vias) if None not in tissues else []
        names = {empty.name for empty in edited}
        for empty in edited:
            if mirror.flipped(empty.name) not in names:
                _write_twin(rig, empty)


def _edited(state: RigState | None, tissues: list, vias: list) -> list:
    """The tissues that a person set otherwise than the last frame found them, be it one of their via points; none where
    others came or went."""
    # after undo there is no last frame, and undo brought both of a pair back
    if state is None:
        return []
    followed = tissues + vias
    settings = tissue_snapshot.settings_of(tissues) + tissue_snapshot.via_settings_of(vias)
    transforms = tissue_snapshot.transforms_of(tissue_snapshot.rows_of(followed))
    settings_before, transforms_before = state.tissue_settings, state.tissue_transforms
    if [own[0] for own in settings] != [own[0] for own in settings_before] or len(transforms_before) != len(followed):
        return []
    moved = np.any(transforms != transforms_before, axis=1)
    changed = [
        empty.sinew.muscle if tissue_empty.is_via(empty) else empty
        for empty, is_moved, now, before in zip(followed, moved, settings, settings_before)
        if is_moved or now != before
    ]
    return [empty for empty in dict.fromkeys(changed) if empty is not None and tissue_empty.is_used(empty)]


def _write_twin(rig, empty):
    name = mirror.flipped(empty.name)
    twin = portable_names.find(rig, name) if name != empty.name else None
    if twin is None or twin.sinew.kind != empty.sinew.kind:
        return
    try:
        wanted = mirror.twin_shape(tissue_empty.read(empty, rig), rig)
    except SinewError:
        return  # halfway through an edit (a scale of 0, no bone yet): the panel says so, and the next edit mirrors again
    tissue_empty.write(twin, wanted)
