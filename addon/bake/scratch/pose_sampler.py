# SPDX-License-Identifier: GPL-3.0-or-later
"""The corrections of skins in poses that nobody sees: a copy of the rig is posed, the character itself stays as it is."""

import bpy
import _sinew
import numpy as np

from ...errors import SinewError
from ...live import frame, session
from ...live.skin_cache import SkinState
from ...scene import characters
from ...scene.rig_pose import read_pose
from .joint_turns import Motion
from .scratch_rig import ScratchRig


class PoseSampler:
    """Skins of one rig, whose corrections can be asked for in any turns of its bones from the rest pose, without tension.

    `remove` takes the copy of the rig away.
    """

    def __init__(self, rig, skins: list):
        depsgraph = bpy.context.evaluated_depsgraph_get()
        frame.frame(depsgraph)
        self._skins: list[SkinState] = []
        try:
            self._rig_state = session.rig_state(rig, characters.tissues_of(rig))
            for skin in skins:
                relation = (
                    rig.evaluated_get(depsgraph).matrix_world.inverted_safe() @ skin.evaluated_get(depsgraph).matrix_world
                )
                to_armature = np.array(relation.transposed(), np.float32, order="C")
                self._skins.append(session.skin_state(skin, self._rig_state, to_armature))
        except ValueError as error:
            raise SinewError(f"{rig.name}: {error}") from error
        self._pose = np.empty_like(self._rig_state.pose)
        self._tension = np.zeros_like(self._rig_state.tension)
        self._copy: ScratchRig | None = None

    def pose_for(self, scene, rig, bones: list[str]):
        """Gets ready to turn these joints."""
        self.remove()
        self._copy = ScratchRig(scene, rig, bones)

    @property
    def musculature(self):
        """`_sinew.Musculature` or None."""
        return self._rig_state.musculature

    @property
    def rest(self):
        """The rig's rest pose, `rig_io.RigRest`."""
        return self._rig_state.rest

    def points(self, place: int) -> np.ndarray:
        """(vertices, 3) float32: the rest points of a skin."""
        return self._skins[place].points

    def skin(self, place: int) -> _sinew.Skin:
        """The bind of a skin."""
        return self._skins[place].skin

    @property
    def pose(self) -> np.ndarray:
        """(frames, 4, 4) float32, column-major: the pose that was sampled last."""
        return self._pose

    def corrections(self, turns: list[tuple[Motion, float]]) -> list[np.ndarray]:
        """(vertices, 3) float32 of each skin: its correction where joints turn so and all others rest."""
        posed = self._copy.posed(turns)
        read_pose(posed, self._rig_state.rest, self._pose)
        found = []
        for state in self._skins:
            out = np.empty_like(state.points)
            state.skin.correct(self._pose, self._tension, out)
            found.append(out)
        return found

    def deformed(self, turns: list[tuple[Motion, float]]) -> list[np.ndarray]:
        """(vertices, 3) float32 of each skin: where it is where joints turn so, all others at rest; mesh space."""
        read_pose(self._copy.posed(turns), self._rig_state.rest, self._pose)
        found = []
        for state in self._skins:
            out = np.empty_like(state.points)
            state.skin.deform(self._pose, self._tension, out)
            found.append(out)
        return found

    def remove(self):
        """Takes the copy of the rig away."""
        if self._copy:
            self._copy.remove()
            self._copy = None
