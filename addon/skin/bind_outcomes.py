# SPDX-License-Identifier: GPL-3.0-or-later
"""The state of each mesh of a character, and why Bind Skin left or refused it the last time, for the panel."""

from dataclasses import dataclass

from ..live import session
from ..scene import armature_modifier, characters

_reasons: dict[int, str] = {}


@dataclass(frozen=True)
class MeshState:
    """A mesh of a character for the panel. state: "BOUND", "PROBLEM", "LEFT" or "UNBOUND". reason: for PROBLEM and LEFT."""

    name: str
    state: str
    reason: str = ""


def keep(skins: list, reasons: dict[str, str]):
    """Keeps why meshes were not bound. reasons: by name; the others were bound."""
    for skin in skins:
        _reasons.pop(skin.session_uid, None)
        if skin.name in reasons:
            _reasons[skin.session_uid] = reasons[skin.name]


def states_of(rig) -> list[MeshState]:
    """The meshes that follow a rig, sorted by name, each with its state."""
    return [_state_of(skin) for skin in sorted(characters.skins_of(rig), key=lambda skin: skin.name)]


def _state_of(skin) -> MeshState:
    if armature_modifier.is_bound(skin):
        reason = session.reason(skin)
        return MeshState(skin.name, "PROBLEM" if reason else "BOUND", reason)
    reason = _reasons.get(skin.session_uid, "")
    return MeshState(skin.name, "LEFT" if reason else "UNBOUND", reason)
