# SPDX-License-Identifier: GPL-3.0-or-later
"""One frame of all characters, in order: pose, tensions, tissues in the viewport, corrections of the skins.

A frame depends only on the file and the evaluated pose. Viewport, render, bake and command line call the same code; the
depsgraph says which evaluation the frame is for.
"""

from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Vector

from ..display import frame_times, shaded, visibility
from ..errors import SinewError
from ..scene import (
    animated_value,
    armature_modifier,
    characters,
    correction_modifier,
    level_of_detail,
    live_switch,
    modifier_stack,
    rig_pose,
    tissue_display,
)
from ..scene.character_index import CharacterObjects
from ..scene.level_of_detail import Detail
from . import failures, garments, rest, session, shown_muscles, tissue_snapshot
from .edit_flags import EditScope
from .rig_cache import Expected, RigState
from .skin_cache import SkinState, bind_settings, is_same_transform, weight_sources_of

WRITTEN_SAMPLE_STEP = 97  # every 97th vertex is compared to detect that a correction changed


def frame(depsgraph, only_after_rebind: bool = False, edited: EditScope = EditScope.ANYTHING):
    """Evaluates all characters of a depsgraph.

    only_after_rebind: leave skins alone whose bind still fits, when Blender reports that a mesh changed. Another window may
    show the same mesh at another frame; rewriting here would make the two windows update each other forever.
    edited: what was edited since the last frame. Data that only an edit can change is then compared only if needed, which
    saves most of the reading from Blender.
    """
    frame_times.begin()
    try:
        _frame(depsgraph, only_after_rebind, edited)
    finally:
        frame_times.end()


def _frame(depsgraph, only_after_rebind: bool, edited: EditScope):
    is_unedited = EditScope.ANY_DATA not in edited
    index = characters.current(is_unedited)
    objects = index.objects(are_names_known=is_unedited)
    if objects is None:
        characters.forget()  # an object was renamed
        _frame(depsgraph, only_after_rebind, EditScope.ANYTHING)
        return
    read, writes = tissue_snapshot.ObjectTransforms(), tissue_display.DeltaWrites()
    for keys, character in zip(index.characters, objects):
        try:
            if character.rig.type == "ARMATURE":
                _character(depsgraph, character, only_after_rebind, edited, read, writes)
        except SinewError as error:
            _fail(depsgraph, character.skins, str(error))
        except Exception as error:
            _fail(depsgraph, character.skins, failures.log(keys.rig, keys.rig.name, error))
        else:
            if failures.has_any():
                failures.clear(keys.rig)
    writes.flush()
    for key, why in index.orphans.items():
        skin = key.find()
        if skin:
            # no later frame would remove the correction of a mesh without an armature
            _fail(depsgraph, [skin], why)


def _fail(depsgraph, skins: list, why: str):
    """Removes the corrections of skins that can't follow their tissues in this frame, and sets the reason."""
    for skin in skins:
        session.set_reason(skin, why)
        _remove_correction(depsgraph, skin)


def _remove_correction(depsgraph, skin):
    with failures.isolated((skin.session_uid, "rest"), f"{skin.name}: removing its correction"):
        if _owner_of_correction(depsgraph, skin) == skin:
            rest.rest_skin(skin)
            if depsgraph.mode == "RENDER":
                animated_value.animate_again(skin.data)
        else:
            live_switch.hide_correction(skin)


def _owner_of_correction(depsgraph, skin):
    """The object whose correction a mesh holds: of those that share it, the first by name that is live in the evaluation."""
    index = characters.cached() or characters.current(is_unedited=True)
    for key in index.uid_index.skins_of_mesh.get(skin.data.session_uid, ()):
        found = key.find()
        if found and found.sinew.skin.live and found.evaluated_get(depsgraph).is_evaluated:
            return found
    return skin


def _character(
    depsgraph,
    character: CharacterObjects,
    only_after_rebind: bool,
    edited: EditScope,
    read: tissue_snapshot.ObjectTransforms,
    writes: tissue_display.DeltaWrites,
):
    rig = character.rig
    if rig.data.is_editmode:
        session.forget_rig(rig)
        return
    evaluated_rig = rig.evaluated_get(depsgraph)
    if not evaluated_rig.is_evaluated:
        return  # not part of this scene or view layer
    cached = session.cached_rig(rig)
    if cached and cached.character_index is None:
        edited = EditScope.ANYTHING  # a setting was changed; Blender does not report changes that handlers make
    try:
        state = session.rig_state(rig, character.tissues, depsgraph, character.vias, edited, read)
    except ValueError as error:
        _fail(depsgraph, character.skins, f"{rig.name}: {error}")
        return
    _enable_driven(depsgraph, state, character)
    rig_pose.read_pose(evaluated_rig, state.rest, state.pose)
    frame_times.lap("pose")

    only_animated = EditScope.ANY_DATA not in edited and state is cached
    _read_tension(depsgraph, state, [character.tissues[index] for index in state.solved], only_animated)
    expected = _right_expectation(state)
    try:
        if expected is None or depsgraph.mode == "RENDER":
            show_character(depsgraph, character, state, writes)
    except ValueError as error:
        lost = rig_pose.bones_without_position(state.rest, state.pose)
        if not lost:
            raise
        raise SinewError(_without_position(rig, lost)) from error
    frame_times.lap("muscles")

    for skin in garments.bodies_first(character.skins):
        if not skin.sinew.skin.live:
            session.set_reason(skin, "")  # of when it was live
            if depsgraph.mode == "VIEWPORT" and EditScope.ANY_DATA in edited:
                _remove_correction(depsgraph, skin)  # the user may show the Sinew modifier again
        elif skin.evaluated_get(depsgraph).is_evaluated and not skin.data.is_editmode:
            try:
                _skin(depsgraph, skin, evaluated_rig, state, only_after_rebind, edited, expected)
            except Exception as error:
                session.forget_skin(skin)
                _fail(depsgraph, [skin], failures.log(skin.session_uid, f"{rig.name}, {skin.name}", error))
            else:
                if failures.has_any():
                    failures.clear(skin.session_uid)
    frame_times.lap("skin")


def _without_position(rig, bones: list[str]) -> str:
    return (
        f"{rig.name}: Blender gives {', '.join(bones)} no position, as for a B-Bone with a scale of 0: "
        "set a scale above 0, and check its drivers and constraints"
    )


def _enable_driven(depsgraph, state: RigState, character: CharacterObjects):
    """Enables the Empties with drivers or NLA strips that a layer disabled: only Blender can evaluate these."""
    if depsgraph.mode == "VIEWPORT" and state.is_any_disabled:
        empties = character.tissues + character.vias
        for index in state.animated:
            if animated_value.has_drivers_or_strips(empties[index]):
                visibility.enable_for_layer(empties[index])


def _right_expectation(state: RigState) -> Expected | None:
    """What was written before this evaluation, if it had the expected pose and tension."""
    expected, state.expected = state.expected, None
    if expected:
        expected.compare(state)
    return expected if expected and expected.is_right else None


def show_character(depsgraph, character: CharacterObjects, state: RigState, writes: tissue_display.DeltaWrites):
    """Shows the tissues in the current pose. depsgraph: the evaluation, or None before one of the viewport."""
    if not state.musculature:
        return
    rig, is_render = character.rig, depsgraph is not None and depsgraph.mode == "RENDER"
    solved = [character.tissues[index] for index in state.solved]
    shaded_muscles = shaded.find(rig)
    if shaded_muscles and not (is_render and animated_value.values_of(shaded_muscles, depsgraph).hide_render):
        shown_muscles.show(rig, state, solved, shaded_muscles)
        if is_render:
            animated_value.animate_again(shaded_muscles.data)
    if not is_render:
        _show_tissues(rig, state, solved, writes)


def _read_tension(depsgraph, state: RigState, solved: list, only_animated: bool):
    """Fills `state.tension` with the tension of each tissue in this evaluation."""
    if only_animated and not state.animated:
        return
    for index, empty in enumerate(solved):
        if not only_animated or empty.animation_data:
            state.set_tension(index, animated_value.values_of(empty, depsgraph))


def _show_tissues(rig, state: RigState, solved: list, writes: tissue_display.DeltaWrites):
    """Makes the visible Empties show their tissues in the current pose, or in the rest pose while tissues are edited."""
    # edits change the rest pose, so the Empties must then show it, also without tension
    if not rig.sinew.rig.show_posed or rig.data.pose_position == "REST":
        state.display.forget()
        for empty in solved:
            tissue_display.show_rest(empty)
        return
    kinds = visibility.shown_as_empties(rig)
    if kinds or rig.sinew.rig.show_attachments:
        state.musculature.pose(state.pose, state.tension, state.posed)
    if kinds:
        rows = state.tissue_rows[state.solved]
        state.display.show(solved, rows, kinds, state.pose, state.posed, writes)


def _skin(depsgraph, skin, evaluated_rig, rig_state, only_after_rebind: bool, edited: EditScope, expected: Expected | None):
    """Computes and writes the correction of a skin, or sets the reason why it has none.

    expected: what the mesh has already, where that is right.
    """
    if correction_modifier.modifier_of(skin) is None:
        session.set_reason(skin, f"{skin.name}: the Sinew modifier was removed; bind again or unbind")
        return
    mesh_to_armature = garments.mesh_to_armature(depsgraph, evaluated_rig.original, skin)
    owner = _owner_if_shared(depsgraph, skin)
    if owner and not _has_correction_of(depsgraph, skin, owner, evaluated_rig, mesh_to_armature, rig_state):
        _fail(
            depsgraph,
            [skin],
            f"{skin.name} shares its mesh with {owner.name}, and a mesh holds one correction, that of {owner.name}: "
            "make it a single user (Object > Relations > Make Single User > Object & Data)",
        )
        return
    cached = session.cached_skin(skin)
    try:
        modifier_stack.check_order(skin)
        detail_of = _DetailOf(depsgraph, evaluated_rig, rig_state)
        state = garments.skin_state(depsgraph, evaluated_rig.original, skin, rig_state, edited, detail_of)
        values = animated_value.values_of(skin, depsgraph)
        is_corrected = state.detail.level != level_of_detail.ARMATURE
        follows = is_corrected and armature_modifier.follows_armature(values, depsgraph.mode)
        if (
            only_after_rebind
            and state is cached
            and state.follows == follows
            and correction_modifier.has_correction(skin.data)
        ):
            return
        if not (expected and expected.skins.get(skin.session_uid) is state and state.follows == follows):
            correct(rig_state, state, follows)
            if write(skin.data, state) and depsgraph.mode == "RENDER":
                animated_value.animate_again(skin.data)
        had_reason = session.set_reason(skin, "")
        if (had_reason or state is not cached) and skin.sinew.skin.is_correction_hidden:
            live_switch.show_live(skin)
    except (SinewError, ValueError) as error:
        lost = rig_pose.bones_without_position(rig_state.rest, rig_state.pose)
        session.forget_skin(skin)
        _fail(depsgraph, [skin], _without_position(evaluated_rig.original, lost) if lost else str(error))


def _owner_if_shared(depsgraph, skin):
    """The other object whose correction the mesh of a skin holds, or None."""
    index = characters.cached() or characters.current(is_unedited=True)
    if len(index.uid_index.skins_of_mesh.get(skin.data.session_uid, ())) < 2:
        return None
    owner = _owner_of_correction(depsgraph, skin)
    return owner if owner != skin else None


def _has_correction_of(depsgraph, skin, owner, evaluated_rig, mesh_to_armature: np.ndarray, rig_state: RigState) -> bool:
    """Whether the correction of another object with the same mesh is also that of `skin`: a duplicate in the same place."""
    size, detail_of = rig_state.rest.size, _DetailOf(depsgraph, evaluated_rig, rig_state)
    values, values_of_owner = animated_value.values_of(skin, depsgraph), animated_value.values_of(owner, depsgraph)
    return (
        armature_modifier.rig_of(owner) == evaluated_rig.original
        and is_same_transform(garments.mesh_to_armature(depsgraph, evaluated_rig.original, owner), mesh_to_armature, size)
        and detail_of(values_of_owner) == detail_of(values)
        and bind_settings(values_of_owner, detail_of(values), size) == bind_settings(values, detail_of(values), size)
        and weight_sources_of(owner, values_of_owner) == weight_sources_of(skin, values)
        and armature_modifier.follows_armature(values_of_owner, depsgraph.mode)
        == armature_modifier.follows_armature(values, depsgraph.mode)
    )


@dataclass(frozen=True)
class _DetailOf:
    """Gives the detail of a skin of a rig in an evaluation, as `garments.skin_state` calls it."""

    depsgraph: bpy.types.Depsgraph
    evaluated_rig: bpy.types.Object
    state: RigState

    def __call__(self, values) -> Detail:
        return level_of_detail.of(values, self.depsgraph, self._centre)

    def _centre(self) -> Vector:
        """The mean of the heads of the rig's bones in world space."""
        heads = self.state.pose[: len(self.evaluated_rig.pose.bones), 3, :3]
        return self.evaluated_rig.matrix_world @ Vector(heads.mean(axis=0, dtype=np.float64).tolist())


def correct(rig_state: RigState, state: SkinState, follows: bool):
    """Computes the correction of the current frame into `state.correction`. It is 0 if the Armature modifier is off."""
    state.follows = follows
    if follows:
        state.report = state.skin.correct(rig_state.pose, rig_state.tension, state.correction)
    else:
        state.correction[:] = 0.0


def write(mesh, state: SkinState) -> bool:
    """Writes the correction, unless the mesh has it already: each write makes Blender evaluate the mesh again.

    Returns whether it wrote.
    """
    sample = state.correction[::WRITTEN_SAMPLE_STEP].copy()
    is_new = state.written_sample is not None and not np.array_equal(sample, state.written_sample)
    # a correction that differs from the last one can't be in the mesh, so the mesh need not be read
    is_written = is_new or not (
        correction_modifier.read_correction(mesh, state.mesh_correction)
        and np.array_equal(state.mesh_correction, state.correction)
    )
    if is_written:
        correction_modifier.write_correction(mesh, state.correction)
    state.written_sample = sample
    return is_written
