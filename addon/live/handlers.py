# SPDX-License-Identifier: GPL-3.0-or-later
"""Sinew's handlers in `bpy.app.handlers`: they run a frame after Blender evaluates, loads or saves."""

import threading
from functools import reduce
from operator import or_

import bpy
from bpy.app.handlers import persistent

from ..muscles import preset_assets
from ..scene import characters
from ..scene.character_index import UidIndex
from ..settings import migration, updates
from . import failures, forecast, frame, rest, session, x_mirror
from .edit_flags import EditScope

RENDER_POLL_S = 0.2

# everything is evaluated whatever Blender reports: at the start, and after load, undo and render
_is_all_dirty = True
_is_evaluating = False
# a render evaluates another view of the file than the one that a forecast is for
_is_rendering = False
# the edits before the current evaluation, by the addresses of the depsgraphs that it may be of
_edits: dict[int, EditScope] = {}


def mark_all_dirty():
    """Makes the next update of any depsgraph evaluate all characters."""
    global _is_all_dirty
    _is_all_dirty = True


def has_foreign() -> bool:
    """Whether other add-ons have handlers that run around evaluations."""
    return any(len(getattr(bpy.app.handlers, name)) > 1 for name in _AROUND_EVALUATIONS)


@persistent
def _before_evaluation(scene, *_):
    """Collects the edits since the last evaluation. After the evaluation, `updates` also lists what follows from them.

    The evaluated copies are read, because an original may have been removed. A render job calls this from another thread,
    where it must not read the depsgraphs of the window.
    """
    if threading.current_thread() is not threading.main_thread():
        return
    index = characters.cached()
    _edits.clear()
    forecast.settle()
    depsgraphs = [layer.depsgraph for layer in scene.view_layers if layer.depsgraph] if index else []
    for depsgraph in depsgraphs:
        kinds = (_kind_of_edit(update.id, index.uid_index) for update in depsgraph.updates)
        _edits[depsgraph.as_pointer()] = reduce(or_, kinds, EditScope.NOTHING)
    if _can_forecast():
        with failures.isolated("forecast", "Sinew: computing a frame before its evaluation"):
            forecast.make(scene, depsgraphs)


def _can_forecast() -> bool:
    """Whether the frame after the coming evaluation only depends on values that can be known before it."""
    return (
        updates.is_enabled()
        and bool(_edits)
        and not any(EditScope.ANY_DATA in edited for edited in _edits.values())
        and not (_is_all_dirty or _is_evaluating or _is_rendering)
        and not bpy.app.is_job_running("RENDER")
    )


def _kind_of_edit(edited, uid_index: UidIndex) -> EditScope:
    if isinstance(edited, bpy.types.Object):
        return EditScope.ANY_DATA if edited.name in uid_index.bound_names else EditScope.NOTHING
    return EditScope.ARMATURES if isinstance(edited, bpy.types.Armature) else EditScope.ANY_DATA


def _take_edits(depsgraph) -> EditScope:
    """The edits before an evaluation that has ended. A second call returns ANYTHING."""
    edited = _edits.pop(depsgraph.as_pointer(), EditScope.ANYTHING)
    if has_foreign():
        edited |= EditScope.TRANSFORMS
    return EditScope.ANYTHING if _is_all_dirty else edited


@persistent
def _after_frame_change(_scene, depsgraph):
    forecast.note_evaluation()
    edited = _take_edits(depsgraph)
    if EditScope.ANY_DATA in edited:
        uid_index = characters.current().uid_index
        for update in depsgraph.updates:
            changed = update.id.original
            if changed is None:
                continue  # another handler has just deleted it
            if isinstance(changed, bpy.types.Object):
                _follow_links(changed, uid_index)
            elif update.is_updated_geometry:
                _mark_mesh(changed, uid_index, frame_changed=True)
    _evaluate(depsgraph, edited=edited)


@persistent
def _after_update(_scene, depsgraph):
    forecast.note_evaluation()
    edited = _take_edits(depsgraph)
    characters_changed = characters.is_stale()  # `current` below updates the index
    is_linked_elsewhere, objects_changed, meshes_changed = _read_updates(
        depsgraph, characters.current().uid_index, EditScope.ANY_DATA in edited
    )
    characters_changed |= is_linked_elsewhere
    if objects_changed and depsgraph.mode == "VIEWPORT" and not _is_evaluating:
        x_mirror.follow(depsgraph)
    if _is_all_dirty or characters_changed or objects_changed:
        _evaluate(depsgraph, edited=edited)
    elif meshes_changed:
        _evaluate(depsgraph, only_after_rebind=True)


def _evaluate(depsgraph, only_after_rebind: bool = False, edited: EditScope = EditScope.ANYTHING):
    global _is_all_dirty, _is_evaluating
    if not updates.is_enabled():
        return
    if depsgraph.mode == "VIEWPORT" and bpy.app.is_job_running("RENDER"):
        _wait_for_render()
        return
    if _is_evaluating:
        mark_all_dirty()  # the update that is skipped here is evaluated then
        return
    _is_evaluating = True
    try:
        if depsgraph.mode == "VIEWPORT":
            _is_all_dirty = False
        frame.frame(depsgraph, only_after_rebind, edited)
    finally:
        _is_evaluating = False


def _read_updates(depsgraph, uid_index: UidIndex, is_any_edited: bool) -> tuple[bool, bool, bool]:
    """What Blender reports: whether an object went to another character, whether objects of a character changed, and whether
    meshes of a character changed.

    is_any_edited: other data than poses was edited. What Sinew writes is not reported: Blender evaluates it in a second
    pass, without handlers.
    """
    is_linked_elsewhere = objects_changed = meshes_changed = False
    for update in depsgraph.updates:
        changed = update.id.original
        if changed is None:
            continue  # another handler has just deleted it
        uid = changed.session_uid
        if uid in uid_index.objects:
            is_linked_elsewhere |= is_any_edited and _follow_links(changed, uid_index)
            if changed.type == "MESH":
                # a mesh object is also reported when its mesh or one of its modifiers changed
                objects_changed |= update.is_updated_transform or changed.name not in uid_index.bound_names  # renamed
                meshes_changed |= update.is_updated_geometry
            else:
                objects_changed = True
        elif uid in uid_index.armatures:
            objects_changed = True
        elif isinstance(changed, bpy.types.Object):
            # an undo shows a dropped asset again, and must not apply it again
            if changed.type == "EMPTY" and not _is_all_dirty and preset_assets.PROPERTY in changed:
                for listener in updates.on_preset_dropped:
                    listener()
        elif update.is_updated_geometry and changed.session_uid in uid_index.skins_of_mesh:
            meshes_changed = True
            if is_any_edited:  # else a forecast wrote its correction
                _mark_mesh(changed, uid_index, frame_changed=False)
    return is_linked_elsewhere, objects_changed, meshes_changed


def _follow_links(changed, uid_index: UidIndex) -> bool:
    """Whether an edited object now belongs to another character or has another mesh. The index is then read again."""
    if not uid_index.is_linked_elsewhere(changed):
        return False
    characters.forget()
    return True


def _mark_mesh(changed, uid_index: UidIndex, frame_changed: bool):
    """If changed geometry is the mesh of a skin, the weights of the skin are read again in the next frame."""
    keys = uid_index.skins_of_mesh.get(changed.session_uid, ())
    # animated shape keys change the mesh in every frame, but not its weights
    if keys and not (frame_changed and _has_playing_keys(changed)):
        for key in keys:
            skin = key.find()
            if skin:
                session.mark_weights_dirty(skin)


def _has_playing_keys(mesh) -> bool:
    keys = mesh.shape_keys
    return bool(keys and keys.animation_data)


@persistent
def _after_load(*_):
    _install()
    migration.migrate()
    _start_over()
    if characters.is_any_in_file():
        rest.show_views()
        _evaluate_windows()


@persistent
def _after_import(*_):
    migration.migrate(is_new_file=False)  # appended or linked data
    characters.forget()


@persistent
def _after_undo(*_):
    migration.migrate_objects()  # undo may go back to before the migration, if Sinew was enabled later
    _start_over(are_binds_kept=True)


def _start_over(are_binds_kept: bool = False):
    global _is_rendering
    _is_rendering = False
    _edits.clear()
    forecast.forget()
    if are_binds_kept:
        session.distrust()
    else:
        session.forget()
    failures.forget()
    characters.forget()
    mark_all_dirty()


@persistent
def _before_other_data(*_):
    forecast.forget()  # the data that it refers to is replaced


@persistent
def _before_save(*_):
    migration.stamp()
    rest.rest_all()


@persistent
def _after_save(*_):
    if characters.is_any_in_file():
        rest.show_views()
        _evaluate_windows()


def _evaluate_windows():
    """Evaluates the view layers of all windows, the active one last: where both show a mesh, its frame stays."""
    active = bpy.context.evaluated_depsgraph_get()
    depsgraphs = {window.view_layer.depsgraph for window in _windows()} - {None, active}
    for depsgraph in (*depsgraphs, active):
        _evaluate(depsgraph)


def _windows() -> list:
    return [window for manager in bpy.data.window_managers for window in manager.windows]


def _wait_for_render():
    """Delays the viewport until a render job ends: a mesh holds one correction, and the render needs it."""
    mark_all_dirty()
    if not bpy.app.timers.is_registered(_after_render_job):
        bpy.app.timers.register(_after_render_job, first_interval=RENDER_POLL_S)


def _after_render_job():
    if bpy.app.is_job_running("RENDER"):
        return RENDER_POLL_S
    _evaluate_windows()
    return None


@persistent
def _before_render(*_):
    global _is_rendering
    _is_rendering = True


@persistent
def _after_render(*_):
    global _is_rendering
    _is_rendering = False
    # the mesh has the correction of the last rendered frame
    mark_all_dirty()


# other add-ons' handlers in these lists can edit data that Blender does not list in `depsgraph.updates`
_AROUND_EVALUATIONS = {
    "frame_change_pre": _before_evaluation,
    "frame_change_post": _after_frame_change,
    "depsgraph_update_pre": _before_evaluation,
    "depsgraph_update_post": _after_update,
}
_HANDLERS = (
    *_AROUND_EVALUATIONS.items(),
    ("load_post", _after_load),
    ("blend_import_post", _after_import),
    ("load_pre", _before_other_data),
    ("undo_pre", _before_other_data),
    ("redo_pre", _before_other_data),
    ("undo_post", _after_undo),
    ("redo_post", _after_undo),
    ("save_pre", _before_save),
    ("save_post", _after_save),
    ("save_post_fail", _after_save),
    ("render_init", _before_render),
    ("render_complete", _after_render),
    ("render_cancel", _after_render),
)


def _enabled_changed():
    """Shows all characters without Sinew, or with it again."""
    if updates.is_enabled():
        rest.show_views()
        mark_all_dirty()
        _evaluate_windows()
    else:
        rest.rest_all()


# changed settings make cached data dirty
_LISTENERS = (
    (updates.on_rig_settings_changed, session.mark_rig_dirty),
    (updates.on_bone_settings_changed, session.forget_bone_settings),
    (updates.on_layers_changed, session.forget_shown_of),
    (updates.on_enabled_changed, _enabled_changed),
)


def register():
    _start_over()
    for listeners, listener in _LISTENERS:
        listeners.append(listener)
    _install()
    # if Sinew is enabled while a file is open, no event evaluates its characters
    bpy.app.timers.register(_after_load, first_interval=0.0)


def _install():
    """Adds the handlers that are missing: other add-ons may have cleared Blender's lists."""
    for name, handler in _HANDLERS:
        if handler not in getattr(bpy.app.handlers, name):
            getattr(bpy.app.handlers, name).append(handler)


def unregister():
    for timer in (_after_load, _after_render_job):
        if bpy.app.timers.is_registered(timer):
            bpy.app.timers.unregister(timer)
    for name, handler in reversed(_HANDLERS):
        if handler in getattr(bpy.app.handlers, name):
            getattr(bpy.app.handlers, name).remove(handler)
    for listeners, listener in _LISTENERS:
        if listener in listeners:
            listeners.remove(listener)
    forecast.forget()
    rest.rest_all()  # without Sinew nothing would remove the corrections
    session.forget()
    characters.forget()
