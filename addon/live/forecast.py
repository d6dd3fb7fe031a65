# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the corrections of a frame before Blender evaluates it, so that it evaluates each mesh once.

A forecast changes only the time that a frame takes. After the evaluation, `live/frame` compares the pose and the tensions
with the expected ones. Where they differ, it computes the frame as without a forecast, and Blender evaluates the mesh a
second time. A rig whose poses were expected wrongly has a pause, which doubles each time.
"""

import time
from dataclasses import dataclass, field

import numpy as np

from ..display import frame_times
from ..scene import animated_value, characters, rig_pose, scout, tissue_display
from ..scene.character_index import CharacterIndex, CharacterObjects
from . import frame, garments, session
from .rig_cache import Expected, RigState

_LONGEST_PAUSE = 64  # evaluations
# a scout that takes longer than this, and more of the time of the evaluation than this, saves too little
_LONG_SECONDS = 0.002
_LARGEST_OF_EVALUATION = 0.5


@dataclass
class _Trust:
    """pause: the number of evaluations without a forecast after the last wrong one. remaining: of these. why: the reason."""

    pause: int = 0
    remaining: int = 0
    why: str = ""

    def lose(self, why: str):
        self.pause = min(2 * self.pause or 1, _LONGEST_PAUSE)
        self.remaining, self.why = self.pause, why

    def win(self):
        self.pause, self.why = 0, ""

    def is_pausing(self) -> bool:
        """Counts one evaluation of the pause."""
        self.remaining -= 1
        return self.remaining >= 0


@dataclass
class _Forecaster:
    """A scout and the data that it was made for.

    rests: the rest pose of each rig of the index, or None. impossible: the names of the rigs that are not in the scout, each
    with the reason. trust: by the names of rigs.
    """

    index: CharacterIndex
    rests: list[rig_pose.RigRest | None]
    opened: scout.Scout | None = None
    impossible: dict[str, str] = field(default_factory=dict)
    trust: dict[str, _Trust] = field(default_factory=dict)

    def trust_in(self, rig) -> _Trust:
        return self.trust.setdefault(rig.name, _Trust())

    def is_for(self, index: CharacterIndex, rests: list) -> bool:
        return (
            self.index is index
            and len(self.rests) == len(rests)
            and all(before is now for before, now in zip(self.rests, rests))
        )


@dataclass
class _Running:
    """The forecast of the current evaluation: when it was ready, how long the scout took, and what is expected."""

    ready: float
    scout_seconds: float
    made: list[tuple[_Trust, RigState, Expected]]


_forecaster: _Forecaster | None = None
_running: _Running | None = None


def forget():
    """Frees the scout. Required before data of the file is replaced in a way that the index of characters does not show."""
    global _forecaster, _running
    _forecaster = _running = None
    scout.close()


def make(scene, depsgraphs: list):
    """Forecasts the frame of a scene before its evaluation, if only poses and keyed tensions change.

    depsgraphs: those of the view layers of the scene.
    """
    index = characters.cached()
    objects = None if index is None or characters.is_stale(is_unedited=True) else index.objects(are_names_known=True)
    if objects is None:
        forget()
        return
    states = [session.cached_rig(character.rig) for character in objects]
    forecaster = _forecaster_of(index, objects, states, scene)
    known = [
        (character, state)
        for character, state in zip(objects, states)
        if state and _is_known(forecaster, character, state, depsgraphs)
    ]
    if known:
        frame_times.begin()
        _make(forecaster, known, scene)
        frame_times.suspend()
    if frame_times.is_on():
        frame_times.set_evaluations(_evaluations())


def note_evaluation():
    """The evaluation that follows a forecast has ended. If the scout took too much of the time, forecasts pause."""
    if _running and _running.scout_seconds > max(
        _LONG_SECONDS, _LARGEST_OF_EVALUATION * (time.perf_counter() - _running.ready)
    ):
        for trust, _state, _expected in _running.made:
            trust.lose("what its bones depend on takes long to evaluate")


def settle():
    """Ends the forecast of the last evaluation, and learns from it."""
    global _running
    if _running is None:
        return
    for trust, state, expected in _running.made:
        state.expected = None
        if expected.is_right is False:
            trust.lose("its pose differed from the expected one")
        elif expected.is_right and not trust.remaining > 0:
            trust.win()
    _running = None


def _evaluations() -> str:
    """How often Blender evaluates the meshes of a frame, and which characters need a second evaluation, for the overlay."""
    if _forecaster is None:
        return ""
    why = [f"{name}: {text}" for name, text in _forecaster.impossible.items()]
    why += [f"{name}: {trust.why}" for name, trust in _forecaster.trust.items() if trust.why]
    return f"Evaluations: 2 ({'; '.join(why)})" if why else "Evaluations: 1"


def _forecaster_of(index: CharacterIndex, objects: list[CharacterObjects], states: list, scene) -> _Forecaster:
    global _forecaster
    rests = [state.rest if state else None for state in states]
    if _forecaster is None or not _forecaster.is_for(index, rests):
        forget()
        _forecaster = _Forecaster(index, rests)
        _open_scout(_forecaster, [character for character, rest in zip(objects, rests) if rest], scene)
    return _forecaster


def _open_scout(forecaster: _Forecaster, held: list[CharacterObjects], scene):
    """Opens a scout of these rigs, without those that would evaluate meshes of characters: that would save nothing."""
    for character in held:
        if character.rig.is_library_indirect:
            # a constraint in local data would make Blender save a direct link to it
            forecaster.impossible[character.rig.name] = "it is linked indirectly"
    held = [character for character in held if character.rig.name not in forecaster.impossible]
    while held:
        forecaster.opened = scout.open_with([character.rig for character in held])
        depsgraph = forecaster.opened.evaluate(scene)
        dependent = [character.rig.name for character in held if _has_skin_in(depsgraph, character)]
        forecaster.impossible |= dict.fromkeys(dependent, "its bones depend on a bound mesh")
        held = [character for character in held if character.rig.name not in dependent]
        if not dependent:
            return
    scout.close()
    forecaster.opened = None


def _has_skin_in(depsgraph, character: CharacterObjects) -> bool:
    """Whether the scout evaluates a mesh of a character, because bones depend on it."""
    return any(skin.evaluated_get(depsgraph).is_evaluated for skin in character.skins)


def _is_known(forecaster: _Forecaster, character: CharacterObjects, state: RigState, depsgraphs: list) -> bool:
    """Whether everything that the frame of a character depends on is known before the evaluation, except for its pose."""
    rig = character.rig
    return (
        rig.name not in forecaster.impossible
        and state.character_index is forecaster.index
        and state.musculature is not None
        and rig.mode != "EDIT"
        and not state.animated_shapes
        and not any(animated_value.has_drivers_or_strips(_empty(character, index)) for index in state.animated)
        and any(rig.evaluated_get(depsgraph).is_evaluated for depsgraph in depsgraphs)
        and not forecaster.trust_in(rig).is_pausing()
    )


def _empty(character: CharacterObjects, index: int):
    """The tissue or via point with an index of `RigState.animated`."""
    count = len(character.tissues)
    return character.tissues[index] if index < count else character.vias[index - count]


def _make(forecaster: _Forecaster, known: list[tuple[CharacterObjects, RigState]], scene):
    global _running
    start = time.perf_counter()
    depsgraph = forecaster.opened.evaluate(scene)
    seconds = time.perf_counter() - start
    if any(_has_skin_in(depsgraph, character) for character, _state in known):
        forget()  # since a new constraint or driver; the next forecast finds out which
        return
    made, writes = [], tissue_display.DeltaWrites()
    for character, state in known:
        trust = forecaster.trust_in(character.rig)
        try:
            expected = _expected(depsgraph, character, state, scene)
            if expected:
                _write(character, state, expected, writes)
        except Exception as error:
            trust.lose(str(error))  # the frame meets it again after the evaluation, and reports it
        else:
            if expected:
                state.expected = expected
                made.append((trust, state, expected))
    writes.flush()
    _running = _Running(time.perf_counter(), seconds, made)


def _expected(depsgraph, character: CharacterObjects, state: RigState, scene) -> Expected | None:
    """The pose and the tensions of the coming evaluation, or None if they are those of the last frame."""
    pose, tension_before = np.empty_like(state.pose), state.tension.copy()
    rig_pose.read_pose(character.rig.evaluated_get(depsgraph), state.rest, pose)
    for index, in_rig in enumerate(state.solved if state.animated else ()):
        empty = character.tissues[in_rig]
        if empty.animation_data:
            state.set_tension(index, animated_value.KeyedValues(empty, empty, scene.frame_current_final))
    if np.array_equal(pose, state.pose) and np.array_equal(state.tension, tension_before):
        return None
    state.pose[:] = pose
    return Expected(pose, state.tension.copy(), {})


def _write(character: CharacterObjects, state: RigState, expected: Expected, writes: tissue_display.DeltaWrites):
    """Writes what the frame will show."""
    frame.show_character(None, character, state, writes)
    frame_times.lap("muscles")
    meshes = state.character_index.uid_index.skins_of_mesh
    for skin in garments.bodies_first(character.skins):
        bound = session.cached_skin(skin)
        if (
            bound
            and bound.musculature is state.musculature
            and bound.bone_settings is state.bone_settings
            and not bound.is_dirty
            and skin.sinew.skin.live
            and not skin.data.is_editmode
            and len(meshes.get(skin.data.session_uid, ())) < 2
            and not session.reason(skin)
        ):
            frame.correct(state, bound, bound.follows)
            frame.write(skin.data, bound)
            expected.skins[skin.session_uid] = bound
    frame_times.lap("skin")
