# SPDX-License-Identifier: GPL-3.0-or-later
"""The corrections of skins in poses that nobody sees: a copy of the rig is posed, the character itself stays as it is."""

import _sinew
import bpy
import numpy as np

from .. import evaluate, roster, session
from ..errors import SinewError
from ..rig_io import read_pose
from .motions import Motion, rotation_of


class Sampler:
    """Skins of one rig, whose corrections can be asked for in any turns of its bones from the rest pose, without tension.

    `remove` takes the copy of the rig away. The copy has none of the rig's constraints: what they turn is turned as a bone.
    """

    def __init__(self, scene, rig, skins: list):
        depsgraph = bpy.context.evaluated_depsgraph_get()
        evaluate.frame(depsgraph)
        self._skins: list[session.SkinState] = []
        try:
            self._rig_state = session.rig_state(rig, roster.tissues_of(rig))
            for skin in skins:
                relation = rig.evaluated_get(depsgraph).matrix_world.inverted_safe() @ skin.evaluated_get(depsgraph).matrix_world
                to_armature = np.array(relation.transposed(), np.float32, order="C")
                self._skins.append(session.skin_state(skin, self._rig_state, to_armature))
        except ValueError as error:
            raise SinewError(f"{rig.name}: {error}") from error
        self._pose = np.empty_like(self._rig_state.pose)
        self._tension = np.zeros_like(self._rig_state.tension)
        self._turned: list[str] = []
        copy = bpy.data.objects.new(f"{rig.name} baking", rig.data)
        self._copy = copy.name
        scene.collection.objects.link(copy)
        # what is hidden is not evaluated
        copy.display_type = "BOUNDS"
        copy.hide_select = copy.hide_render = True
        bpy.context.view_layer.update()

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
        """(vertices, 3) float32 of each skin: what is added before the Armature modifier where joints turn so, all others at rest."""
        bones = dict.fromkeys(motion.bone for motion, _ in turns)
        self._turn({name: rotation_of([turn for turn in turns if turn[0].bone == name]) for name in bones})
        found = []
        for state in self._skins:
            out = np.empty_like(state.points)
            state.skin.correct(self._pose, self._tension, out)
            found.append(out)
        return found

    def turned(self, turns: dict) -> tuple[np.ndarray, list[np.ndarray]]:
        """The pose where bones are turned by these quaternions from rest, and each skin in it, (vertices, 3) float32, mesh space."""
        self._turn(turns)
        found = []
        for state in self._skins:
            out = np.empty_like(state.points)
            state.skin.deform(self._pose, self._tension, out)
            found.append(out)
        return self._pose, found

    def _turn(self, turns: dict):
        copy = bpy.data.objects.get(self._copy)
        if copy is None:
            raise SinewError("the armature that is posed for the bake was deleted meanwhile: bake again")
        for name in self._turned:
            copy.pose.bones[name].rotation_quaternion.identity()
        self._turned = list(turns)
        for name, turn in turns.items():
            bone = copy.pose.bones[name]
            bone.rotation_mode = "QUATERNION"
            bone.rotation_quaternion = turn
        bpy.context.view_layer.update()
        read_pose(copy.evaluated_get(bpy.context.evaluated_depsgraph_get()), self._rig_state.rest, self._pose)

    def remove(self):
        """Takes the copy of the rig away."""
        copy = bpy.data.objects.get(self._copy)
        if copy:
            bpy.data.objects.remove(copy)
