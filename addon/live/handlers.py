# SPDX-License-Identifier: GPL-3.0-or-later
"""The only place that hangs on `bpy.app.handlers`: when Blender evaluated, loaded, saved or undid, Sinew follows."""

import threading
from functools import reduce
from operator import or_

import bpy
from bpy.app.handlers import persistent

from ..scene import characters
from . import frame, rest, session, x_mirror
from .edit_flags import EditScope

LOOK_FOR_RENDER_S = 0.2

# True while everything must be looked at whatever Blender reports: after load, undo, render, and at the start
_all_is_due = True
_at_work = False
# what was edited before the evaluation under way, by the addresses of the evaluations that it may be
_edited: dict[int, EditScope] = {}


def evaluate_all_soon():
    """Makes the next update of any evaluation look at every character."""
    global _all_is_due
    _all_is_due = True


@persistent
def _before_evaluation(scene, *_):
    """Looks whether anything was edited since the last evaluation, which is when Blender still tells it from what follows.

    Asked of the evaluated copies: an original may be gone already. A render that goes on beside the window has evaluations
    of its own and must not look into the window's.
    """
    if threading.current_thread() is not threading.main_thread():
        return
    known = characters.cached()
    _edited.clear()
    for layer in scene.view_layers if known else ():
        depsgraph = layer.depsgraph
        if depsgraph:
            kinds = (_kind_of_edit(update.id, known.watch) for update in depsgraph.updates)
            _edited[depsgraph.as_pointer()] = reduce(or_, kinds, EditScope.NOTHING)


def _kind_of_edit(edited, watch: characters.UidIndex) -> EditScope:
    if isinstance(edited, bpy.types.Object):
        return EditScope.ANY_DATA if edited.name in watch.bound_names else EditScope.NOTHING
    return EditScope.ARMATURES if isinstance(edited, bpy.types.Armature) else EditScope.ANY_DATA


def _edited_before(depsgraph) -> EditScope:
    """What was edited before an evaluation that ended; told once."""
    edited = _edited.pop(depsgraph.as_pointer(), EditScope.ANYTHING)
    if any(len(getattr(bpy.app.handlers, name)) > 1 for name in _AROUND_EVALUATIONS):
        edited |= EditScope.TRANSFORMS
    return EditScope.ANYTHING if _all_is_due else edited


@persistent
def _after_frame_change(_scene, depsgraph):
    edited = _edited_before(depsgraph)
    if EditScope.ANY_DATA in edited:
        watch = characters.current().watch
        for update in depsgraph.updates:
            if update.is_updated_geometry:
                _note_mesh(update.id.original, watch, frame_changed=True)
    _evaluate(depsgraph, edited=edited)


@persistent
def _after_update(_scene, depsgraph):
    edited = _edited_before(depsgraph)
    characters_changed = characters.is_stale()  # asked before the report is read with a roster that is up to date
    objects_changed, meshes_changed = _note(depsgraph, characters.current().watch)
    if objects_changed and depsgraph.mode == "VIEWPORT" and not _at_work:
        x_mirror.follow()
    if _all_is_due or characters_changed or objects_changed:
        _evaluate(depsgraph, edited=edited)
    elif meshes_changed:
        _evaluate(depsgraph, only_after_rebind=True)


def _evaluate(depsgraph, only_after_rebind: bool = False, edited: EditScope = EditScope.ANYTHING):
    global _all_is_due, _at_work
    if depsgraph.mode == "VIEWPORT" and bpy.app.is_job_running("RENDER"):
        _wait_for_render()
        return
    if _at_work:
        evaluate_all_soon()  # what is passed over now is looked at then
        return
    _at_work = True
    try:
        if depsgraph.mode == "VIEWPORT":
            _all_is_due = False
        frame.frame(depsgraph, only_after_rebind, edited)
    finally:
        _at_work = False


def _note(depsgraph, watch: characters.UidIndex) -> tuple[bool, bool]:
    """Reads Blender's report: whether objects of a character changed, and whether meshes of theirs did.

    Sinew's own writes are not in the report: Blender evaluates them in a second pass, of which it tells nobody.
    """
    objects_changed = meshes_changed = False
    for update in depsgraph.updates:
        changed = update.id.original
        uid = changed.session_uid
        if uid in watch.objects:
            # a mesh object is also reported when only its mesh changed
            objects_changed |= update.is_updated_transform or changed.type != "MESH"
        elif uid in watch.armatures:
            objects_changed = True
        elif update.is_updated_geometry:
            meshes_changed |= _note_mesh(changed, watch, frame_changed=False)
    return objects_changed, meshes_changed


def _note_mesh(changed, watch: characters.UidIndex, frame_changed: bool) -> bool:
    """Whether an ID whose geometry changed is a mesh of a skin; that skin is then looked at anew."""
    keys = watch.skins_of_mesh.get(changed.session_uid, ())
    # shape keys that play change the mesh in every frame, and its weights in none
    if keys and not (frame_changed and _has_playing_keys(changed)):
        for key in keys:
            skin = key.find()
            if skin:
                session.mark_weights_dirty(skin)
    return bool(keys)


def _has_playing_keys(mesh) -> bool:
    keys = mesh.shape_keys
    return bool(keys and keys.animation_data)


@persistent
def _after_load(*_):
    _start_over()
    if characters.in_file():
        _evaluate(bpy.context.evaluated_depsgraph_get())


@persistent
def _after_undo(*_):
    _start_over()


def _start_over():
    _edited.clear()
    session.forget()
    characters.forget()
    evaluate_all_soon()


@persistent
def _before_save(*_):
    rest.rest_all()


@persistent
def _after_save(*_):
    if characters.in_file():
        _evaluate(bpy.context.evaluated_depsgraph_get())


def _wait_for_render():
    """Puts the viewport off until a render in another thread is done: a mesh holds one correction, and it is the render's."""
    evaluate_all_soon()
    if not bpy.app.timers.is_registered(_after_render_job):
        bpy.app.timers.register(_after_render_job, first_interval=LOOK_FOR_RENDER_S)


def _after_render_job():
    if bpy.app.is_job_running("RENDER"):
        return LOOK_FOR_RENDER_S
    _evaluate(bpy.context.evaluated_depsgraph_get())
    return None


@persistent
def _after_render(*_):
    # the last rendered frame is still in the mesh; the viewport's own is due
    evaluate_all_soon()


# what others hang on these may edit what Blender then evaluates without telling of it
_AROUND_EVALUATIONS = {
    "frame_change_pre": _before_evaluation,
    "frame_change_post": _after_frame_change,
    "depsgraph_update_pre": _before_evaluation,
    "depsgraph_update_post": _after_update,
}
_HANDLERS = (
    *_AROUND_EVALUATIONS.items(),
    ("load_post", _after_load),
    ("undo_post", _after_undo),
    ("redo_post", _after_undo),
    ("save_pre", _before_save),
    ("save_post", _after_save),
    ("save_post_fail", _after_save),
    ("render_complete", _after_render),
    ("render_cancel", _after_render),
)


def register():
    _start_over()
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)
    # enabled while a file is open, no event follows: its characters would stay as the Armature modifier leaves them
    bpy.app.timers.register(_after_load, first_interval=0.0)


def unregister():
    for timer in (_after_load, _after_render_job):
        if bpy.app.timers.is_registered(timer):
            bpy.app.timers.unregister(timer)
    for name, handler in reversed(_HANDLERS):
        getattr(bpy.app.handlers, name).remove(handler)
    rest.rest_all()  # without Sinew nothing would take a correction away again
    session.forget()
    characters.forget()
