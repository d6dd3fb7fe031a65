# SPDX-License-Identifier: GPL-3.0-or-later
"""One frame: from the evaluated pose to the shown tissues and the corrections of the skins.

A frame is a function of what stands in the file and the pose alone. It is the same code for viewport, render, bake and
command line; `depsgraph` says which evaluation it is for.
"""

import numpy as np

from ..display import frame_times, shaded, visibility
from ..errors import SinewError
from ..scene import animated_value, armature_modifier, characters, correction_modifier, rig_pose, tissue_display
from . import ellipsoids, rest, session
from .edit_flags import EditScope
from .rig_cache import RigState
from .skin_cache import SkinState

TENSION_PATH = "sinew.tension"
WRITTEN_STEP = 97  # one vertex of so many tells whether a correction is another than the last


def frame(depsgraph, only_after_rebind: bool = False, edited: EditScope = EditScope.ANYTHING):
    """Evaluates all characters of an evaluation.

    only_after_rebind: leave skins alone whose bind still fits: for reports that a mesh changed, which also follow from
    another window's frame of the same mesh; answering those with a frame of this window would never end.
    edited: what was edited since the last frame, as far as Blender knows. What only an edit can change is not looked at
    where nothing was, and that is most of what a frame would otherwise ask of Blender.
    """
    frame_times.begin()
    is_unedited = EditScope.ANY_DATA not in edited
    known = characters.current(is_unedited)
    found = known.members(are_names_known=is_unedited)
    if found is None:
        characters.forget()  # renamed: the next look finds the new names
        return frame(depsgraph, only_after_rebind)
    for members in found:
        if members.rig.type != "ARMATURE":
            continue
        if members.rig.mode == "EDIT":
            session.forget_rig(members.rig)
        else:
            _character(depsgraph, members, only_after_rebind, edited)
    for key, why in known.orphans.items():
        skin = key.find()
        if skin:
            # without its armature nothing would ever take the last frame's correction away again
            rest.rest_skin(skin)
            session.set_reason(skin, why)
    frame_times.end()


def _character(depsgraph, members: characters.CharacterObjects, only_after_rebind: bool, edited: EditScope):
    rig = members.rig
    evaluated_rig = rig.evaluated_get(depsgraph)
    if not evaluated_rig.is_evaluated:
        return  # not part of this scene or view layer
    kept = session.kept_rig(rig)
    if kept and kept.character_index is None:
        edited = EditScope.ANYTHING  # a setting was changed, perhaps by a handler, of which Blender then tells nothing
    try:
        state = session.rig_state(rig, members.tissues, members.vias, edited)
    except ValueError as error:
        for skin in members.skins:
            session.set_reason(skin, f"{rig.name}: {error}")
        return
    rig_pose.read_pose(evaluated_rig, state.rest, state.pose)
    frame_times.lap("pose")
    solved = [members.tissues[place] for place in state.solved]
    _read_tension(depsgraph, state, solved, only_animated=EditScope.ANY_DATA not in edited and state is kept)
    if state.musculature:
        shaded_muscles = shaded.find(rig)
        if shaded_muscles and (depsgraph.mode == "VIEWPORT" or not shaded_muscles.hide_render):
            _show_shaded(rig, state, solved, shaded_muscles)
        if depsgraph.mode == "VIEWPORT":
            _show_tissues(rig, state, solved)
    frame_times.lap("muscles")
    for skin in members.skins:
        evaluated_skin = skin.evaluated_get(depsgraph)
        if skin.sinew.live and evaluated_skin.is_evaluated and not skin.data.is_editmode:
            _skin(depsgraph, skin, evaluated_rig, evaluated_skin, state, only_after_rebind, edited)
    frame_times.lap("skin")


def _read_tension(depsgraph, state: RigState, solved: list, only_animated: bool):
    """Fills in the tension of each tissue, 0..1, in this evaluation."""
    for place, empty in enumerate(solved):
        if empty.animation_data:
            # an animated value stands in the evaluated copy alone
            evaluated = empty.evaluated_get(depsgraph)
            if evaluated.is_evaluated:
                tension = evaluated.sinew.tension
            else:
                # disabled in viewports or renders, Blender leaves it out; its keys still count, and a layer gives it back
                if empty.animation_data.drivers and depsgraph.mode == "VIEWPORT":
                    visibility.take_out(empty)
                frame = depsgraph.scene.frame_current_final
                tension = animated_value.value_at(empty, TENSION_PATH, frame, empty.sinew.tension)
        elif only_animated:
            continue
        else:
            tension = empty.sinew.tension
        state.tension[place] = min(max(tension, 0.0), 1.0)


def _show_tissues(rig, state: RigState, solved: list):
    """Shows the visible tissues of a rig in its current pose, or in the shape of the rest pose where so wished."""
    # in the rest pose a tissue is edited, and shows what is edited: also without tension
    if not rig.sinew.show_posed or rig.data.pose_position == "REST":
        state.shown.forget()
        for empty in solved:
            tissue_display.show_rest(empty)
        return
    kinds = visibility.shown_as_empties(rig)
    if kinds or rig.sinew.show_attachments:
        state.musculature.pose(state.pose, state.tension, state.posed)
    if kinds:
        rows = state.tissue_rows[state.solved] if state.character_index.is_all_local else None
        state.shown.show(solved, rows, kinds, state.pose, state.posed)


def _show_shaded(rig, state: RigState, solved: list, shaded_muscles):
    """Shows the ellipsoids of the tissues whose layers are on, shaded."""
    posed = ellipsoids.of(state)
    kinds = visibility.shown_kinds(rig)
    shown = np.array([empty.sinew.kind in kinds for empty in solved])[posed.owners]
    shaded.show(shaded_muscles, posed.matrices[shown], posed.stretch[shown])


def _skin(depsgraph, skin, evaluated_rig, evaluated_skin, rig_state, only_after_rebind: bool, edited: EditScope):
    if correction_modifier.modifier_of(skin) is None:
        session.set_reason(skin, f"{skin.name}: the Sinew modifier was removed; bind again or unbind")
        return
    rivals = _rivals(skin, evaluated_rig.original)
    if rivals:
        session.set_reason(
            skin,
            f"{skin.name} shares its mesh with {', '.join(rivals)} on another armature, and a mesh holds one correction: "
            "make it a single user (Object > Relations > Make Single User > Object & Data)",
        )
        rest.rest_skin(skin)
        return
    relation = evaluated_rig.matrix_world.inverted_safe() @ evaluated_skin.matrix_world
    mesh_to_armature = np.array(relation.transposed(), np.float32, order="C")
    kept = session.kept_skin(skin)
    try:
        state = session.skin_state(skin, rig_state, mesh_to_armature, edited)
        if only_after_rebind and state is kept:
            return
        correct(skin, rig_state, state, armature_modifier.follows_armature(skin, depsgraph.mode))
        _write(skin.data, state)
        session.set_reason(skin, "")
    except (SinewError, ValueError) as error:
        session.forget_skin(skin)
        session.set_reason(skin, str(error))
        rest.rest_skin(skin)


def _write(mesh, state: SkinState):
    """Writes the correction, unless the mesh holds it: writing makes Blender evaluate the mesh anew."""
    some = state.correction[::WRITTEN_STEP].copy()
    is_other = state.written is not None and not np.array_equal(some, state.written)
    # another than the last can't be in the mesh yet; what is there need not be read
    if is_other or not (
        correction_modifier.read_correction(mesh, state.present) and np.array_equal(state.present, state.correction)
    ):
        correction_modifier.write_correction(mesh, state.correction)
    state.written = some


def _rivals(skin, rig) -> list[str]:
    """Other live skins of this file with the same mesh, on other armatures: two linked characters that were overridden."""
    # looked at when the frame began
    known = characters.cached() or characters.current(is_unedited=True)
    found = known.watch.skins_of_mesh.get(skin.data.session_uid, ())
    if len(found) < 2:
        return []
    others = [key.find() for key in found if key.library is None and key.name != skin.name]
    return [other.name for other in others if other and other.sinew.live and armature_modifier.rig_of(other) != rig]


def correct(skin, rig_state: RigState, state: SkinState, follows: bool):
    """Computes the correction of the current frame into `state.correction`; zero where the Armature modifier is off."""
    if follows:
        state.report = state.skin.correct(rig_state.pose, rig_state.tension, state.correction)
    else:
        state.correction[:] = 0.0
