# SPDX-License-Identifier: GPL-3.0-or-later
"""X-mirror: edits of a tissue also change the tissue on the other side, as for bones in the armature's Edit Mode."""

import numpy as np

from ..muscles import mirror
from ..scene import characters, rig_pose, tissue_empty
from . import failures, session, tissue_snapshot
from .rig_cache import RigState


def is_on(rig) -> bool:
    """Whether edits of a rig's Empties are mirrored: only in the rest pose, in which an Empty is the tissue at rest."""
    return mirror.is_wanted(rig) and rig_pose.is_resting(rig)


def follow(depsgraph):
    """Mirrors the tissues that were edited since the last frame. If both of a pair were edited, both stay as they are."""
    for character in characters.in_file():
        with failures.isolated((character.rig, "X-mirror"), f"{character.rig.name}: X-mirror"):
            _follow(character, depsgraph)


def _follow(character: characters.Character, depsgraph):
    rig = character.rig.find()
    if rig is None or rig.type != "ARMATURE" or not is_on(rig):
        return
    tissues = [key.find() for key in character.tissues]
    vias = characters.vias_of(rig)
    edited = _edited(session.cached_rig(rig), tissues, vias, depsgraph) if None not in tissues else []
    names = {empty.name for empty in edited}
    for empty in edited:
        if mirror.flipped(empty.name) not in names:
            mirror.write_twin(rig, empty)


def _edited(state: RigState | None, tissues: list, vias: list, depsgraph) -> list:
    """The tissues that differ from the last frame, themselves or in a via point. None if tissues were added or removed."""
    # after undo there is no last frame; undo has restored both of a pair
    if state is None:
        return []
    empties = tissues + vias
    settings = tissue_snapshot.settings_of(tissues, depsgraph) + tissue_snapshot.via_settings_of(vias)
    transforms = tissue_snapshot.transforms_of(
        empties, tissue_snapshot.rows_of(empties), depsgraph, tissue_snapshot.ObjectTransforms()
    )
    settings_before, transforms_before = state.tissue_settings, state.tissue_transforms
    names, names_before = ([of_empty[0] for of_empty in snapshot] for snapshot in (settings, settings_before))
    if names != names_before or len(transforms_before) != len(empties):
        return []
    moved = np.any(transforms != transforms_before, axis=1)
    changed = [
        empty.sinew.tissue.muscle if tissue_empty.is_via(empty) else empty
        for empty, is_moved, now, before in zip(empties, moved, settings, settings_before)
        if is_moved or now != before
    ]
    return [empty for empty in dict.fromkeys(changed) if empty is not None and tissue_empty.is_used(empty)]
