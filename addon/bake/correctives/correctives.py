# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes correctives: shape keys that the angles of joints drive, so that the skin moves the same without Sinew.

A key holds the basis plus the part of the live correction at its pose that the other keys acting there do not give.
Keys act before the Armature modifier. Each joint turn is sampled by itself through its range. Where two turns together
need more, combined keys are added (docs/mathematics/baking.md, Correctives). Errors are distances on the posed skin in
the world. The tension of muscles is taken as 0.
"""

from collections.abc import Iterator

from ...errors import SinewError
from ...live import garments, session
from ...scene import live_switch
from ...scene.lookup import objects_named
from ..keys import key_store
from ..scratch.pose_sampler import PoseSampler
from . import turn_choice
from .corrective_settings import Settings
from .key_writing import write_keys
from .single_turns import SingleTurns
from .skin_keys import JointResult, SkinKeys, summary_of
from .turn_pairs import TurnPairs
from .whole_range import WholeRange

# the progress bar after single turns, and after pairs
_SINGLE, _PAIRS = 0.5, 0.85


class CorrectiveBake:
    """A bake of the correctives of skins of one rig. Run `steps` to the end, or `cancel` it: then nothing has changed."""

    def __init__(self, rig, skins: list, scene, settings: Settings):
        key_store.check_bakeable(skins, settings.prefix)
        turn_choice.check(rig, skins, settings)
        self.rig, self.settings = rig.name, settings
        self._skins = [
            SkinKeys(skin.name, index, key_store.mm_per_metre(skin), body=garments.innermost(skin).name)
            for index, skin in enumerate(skins)
        ]
        self._sampler = PoseSampler(rig, skins)
        try:
            for skin in skins:
                if skin.sinew.skin.live and session.reason(skin):
                    raise SinewError(session.reason(skin))
            self.turns = turn_choice.choose_turns(scene, rig, skins, self._sampler, self._skins, settings)
        except Exception:
            self._sampler.remove()
            raise
        self.muted_keys = 0

    @property
    def results(self) -> list[JointResult]:
        """The keys and errors of all meshes."""
        return [result for skin in self._skins for result in skin.results]

    def steps(self) -> Iterator[float]:
        """Bakes one pose or a few per step and yields the fraction done, 0..1. Raises SinewError."""
        single = SingleTurns(self._sampler, self._skins, self.settings)
        for done, turn in enumerate(self.turns):
            for part in single.sample(turn):
                yield _SINGLE * (done + part) / len(self.turns)
        together = TurnPairs(self._sampler, self._skins, self.settings)
        (rig,) = objects_named([self.rig], "bake again")
        pairs = together.pairs(rig, self.turns)
        for done, pair in enumerate(pairs):
            for part in together.sample(*pair):
                yield _SINGLE + (_PAIRS - _SINGLE) * (done + part) / len(pairs)
        whole = WholeRange(self._sampler, self._skins)
        joints = whole.joints(self.turns)
        for done, of_joint in enumerate(joints):
            for part in whole.measure(of_joint):
                yield _PAIRS + (1.0 - _PAIRS) * (done + part) / len(joints)
        self._sampler.remove()
        rig, *skins = objects_named([self.rig, *(keys.name for keys in self._skins)], "bake again")
        for skin, keys in zip(skins, self._skins, strict=True):
            self.muted_keys += write_keys(rig, skin, keys, self.turns, self.settings.prefix)
            skin.sinew.skin.live = False
            live_switch.show_live(skin)
            skin.sinew.skin.corrective_summary = "\n".join(summary_of(keys.results))
        yield 1.0

    def cancel(self):
        """Removes the temporary objects. Keys that are already written stay."""
        self._sampler.remove()
