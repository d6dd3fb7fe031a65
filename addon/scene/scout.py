# SPDX-License-Identifier: GPL-3.0-or-later
"""The scout: a scene outside the file in which rigs are evaluated before the scene that shows them.

Blender calls handlers before it evaluates a scene, when no new pose is known yet. The scout holds only Empties that copy the
transforms of bones, so evaluating it evaluates the rigs and what they depend on, without the meshes that they deform.

It is in temporary data (`bpy.data.temp_data`), so no file, outliner, scene list or undo step has it. It refers to rigs of
the file, which Blender does not know there: `close` must be called before the file is replaced, and the scout must not be
evaluated after a rig was removed. The targets of constraints are not counted as users, so the rigs can be deleted as usual.
"""

import atexit
from collections.abc import Iterator
from contextlib import contextmanager

import bpy

_EVALUATION_HANDLERS = ("depsgraph_update_pre", "depsgraph_update_post")


class Scout:
    """A scene of its own with some rigs."""

    def __init__(self, rigs: list):
        self._temporary = bpy.data.temp_data()
        # Blender does not count this reference, and crashes in `close` if it is gone
        data = self._data = self._temporary.__enter__()
        self._scene = data.scenes.new("Sinew Scout")
        for rig in rigs:
            probe = data.objects.new(rig.name, None)
            self._scene.collection.objects.link(probe)
            for name in _read_bones(rig):
                copy = probe.constraints.new("COPY_TRANSFORMS")
                copy.target, copy.subtarget = rig, name
        # Blender 4.5 adds linked objects only to the view layers of the file; a new view layer has them
        self._layer = self._scene.view_layers.new("Rigs")
        self._scene.view_layers.remove(self._scene.view_layers[0])

    def evaluate(self, scene):
        """Evaluates the rigs at the current frame of a scene, and returns the depsgraph that has their pose."""
        ours, theirs = self._scene.render, scene.render
        if (ours.frame_map_old, ours.frame_map_new) != (theirs.frame_map_old, theirs.frame_map_new):
            ours.frame_map_old, ours.frame_map_new = theirs.frame_map_old, theirs.frame_map_new
        if self._scene.frame_float != scene.frame_float:
            self._scene.frame_float = scene.frame_float
        with _without_handlers():
            self._layer.update()
        return self._layer.depsgraph

    def close(self):
        """Frees the scene. The scout must not be used afterwards."""
        self._temporary.__exit__(None, None, None)


_open: list[Scout] = []


def open_with(rigs: list) -> Scout:
    """The scout of these rigs, in place of the one before."""
    close()
    _open.append(Scout(rigs))
    return _open[0]


def close():
    """Frees the scout, if there is one."""
    while _open:
        _open.pop().close()


# Blender reports memory that is not freed before it ends
atexit.register(close)


def _read_bones(rig) -> Iterator[str]:
    """The bones whose evaluation evaluates all others: those without children, and B-Bones, whose segments come last."""
    for bone in rig.pose.bones:
        if not bone.children or bone.bone.bbone_segments > 1:
            yield bone.name


@contextmanager
def _without_handlers() -> Iterator[None]:
    """Calls no handlers in the block: those of others need not know the scout."""
    lists = [getattr(bpy.app.handlers, name) for name in _EVALUATION_HANDLERS]
    before = [list(handlers) for handlers in lists]
    for handlers in lists:
        handlers.clear()
    try:
        yield
    finally:
        for handlers, registered in zip(lists, before):
            handlers[:] = registered
