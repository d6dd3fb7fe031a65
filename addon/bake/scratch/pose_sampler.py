# SPDX-License-Identifier: GPL-3.0-or-later
"""Computes skins in poses of a scratch rig, while the character keeps its pose."""

from collections.abc import Callable

import bpy
import _sinew
import numpy as np

from ...errors import SinewError
from ...live import frame, garments, session
from ...live.skin_cache import SkinState
from ...scene import characters
from ...scene.rig_pose import read_pose
from .joint_turns import TurnAngles
from .scratch_rig import ScratchRig


class PoseSampler:
    """Skins of one rig, computed with joints turned from the rest pose and with a tension of 0.

    Call `prepare` before the first sample. `remove` deletes the scratch rig.
    """

    def __init__(self, rig, skins: list):
        depsgraph = bpy.context.evaluated_depsgraph_get()
        frame.frame(depsgraph)
        self._skins: list[SkinState] = []
        try:
            self._rig_state = session.rig_state(rig, characters.tissues_of(rig), depsgraph)
            for skin in skins:
                self._skins.append(garments.skin_state(depsgraph, rig, skin, self._rig_state))
        except ValueError as error:
            raise SinewError(f"{rig.name}: {error}") from error
        self._pose = np.empty_like(self._rig_state.pose)
        self._tension = np.zeros_like(self._rig_state.tension)
        self._scratch_rig: ScratchRig | None = None

    def prepare(self, scene, rig, bones: list[str]):
        """Makes a scratch rig whose `bones` can be turned."""
        self.remove()
        self._scratch_rig = ScratchRig(scene, rig, bones)

    @property
    def musculature(self):
        """The rig's `_sinew.Musculature`, or None."""
        return self._rig_state.musculature

    @property
    def rest(self):
        """The rig's rest pose, a `rig_pose.RigRest`."""
        return self._rig_state.rest

    def points(self, skin: int) -> np.ndarray:
        """The rest points of a skin, (vertices, 3) float32, mesh space. skin: its index."""
        return self._skins[skin].points

    def skin(self, skin: int) -> _sinew.Skin:
        """The bind of a skin. skin: its index."""
        return self._skins[skin].skin

    @property
    def pose(self) -> np.ndarray:
        """The pose of the last sample, (bones, 4, 4) float32, column-major. Each sample overwrites the array."""
        return self._pose

    def corrections(self, angles: TurnAngles) -> list[np.ndarray]:
        """The correction of each skin with joints at these angles, (vertices, 3) float32, mesh space."""
        return self._sample(angles, _sinew.Skin.correct)

    def deformed(self, angles: TurnAngles) -> list[np.ndarray]:
        """The deformed points of each skin with joints at these angles, (vertices, 3) float32, mesh space."""
        return self._sample(angles, _sinew.Skin.deform)

    def _sample(self, angles: TurnAngles, compute: Callable) -> list[np.ndarray]:
        read_pose(self._scratch_rig.posed(angles), self._rig_state.rest, self._pose)
        sampled = []
        for state in self._skins:
            out = np.empty_like(state.points)
            compute(state.skin, self._pose, self._tension, out)
            sampled.append(out)
        return sampled

    def remove(self):
        """Deletes the scratch rig."""
        if self._scratch_rig:
            self._scratch_rig.remove()
            self._scratch_rig = None
