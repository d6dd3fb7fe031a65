# SPDX-License-Identifier: GPL-3.0-or-later
"""Points of a skin in evaluations other than the window's: a render engine that reads them instead of drawing."""

import bpy
from conftest import points_of_evaluated

ENGINE = "SINEW_TEST_READER"
SUBFRAME = 0.25
_read: dict[float, object] = {}
_wanted = ""


class Reader(bpy.types.RenderEngine):
    """Reads the points of one object at each frame that is rendered, and at `SUBFRAME` after it, as motion blur does."""

    bl_idname, bl_label = ENGINE, "Reader"

    def render(self, depsgraph):
        frame = depsgraph.scene.frame_current
        for subframe in (0.0, SUBFRAME):
            self.frame_set(frame, subframe)
            _read[frame + subframe] = points_of_evaluated(bpy.data.objects[_wanted].evaluated_get(depsgraph))
        self.frame_set(frame, 0.0)


def rendered(skin, tmp_path, *frames):
    """The points of a skin in a render of these frames, as `blender -a` evaluates them. The window keeps its frame."""
    points = rendered_from_to(skin, tmp_path, *frames)
    return [points[frame] for frame in frames]


def rendered_from_to(skin, tmp_path, *starts, end=None, step=1, scene=None):
    """The points of a skin by frame in renders that start at each of these frames, and by subframe."""
    global _wanted
    _wanted = skin.name
    _read.clear()
    scene = scene or bpy.context.scene
    bpy.utils.register_class(Reader)
    _set_up(scene, tmp_path)
    before = scene.render.engine, scene.frame_start, scene.frame_end, scene.frame_step
    scene.render.engine, scene.frame_step = ENGINE, step
    try:
        for start in starts:
            scene.frame_start, scene.frame_end = start, start if end is None else end
            bpy.ops.render.render(animation=True, scene=scene.name)
    finally:
        scene.render.engine, scene.frame_start, scene.frame_end, scene.frame_step = before
        bpy.utils.unregister_class(Reader)
    return dict(_read)


def _set_up(scene, tmp_path):
    scene.render.filepath = str(tmp_path / "read_")
    scene.render.resolution_x = scene.render.resolution_y = 4
    if scene.camera is None:
        scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        scene.collection.objects.link(scene.camera)
