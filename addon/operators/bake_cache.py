# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.bake_cache`"""

from pathlib import Path

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty
from bpy.types import Operator

from ..bake.cache import playback, point_cache
from ..bake.cache.cache_bake import CacheBake, CacheSettings, path_of
from ..bake.scratch import scratch_mesh
from ..errors import SinewError
from ..files.atomic_write import make_folder
from .base import skins_to_bake
from .frame_range import FrameRangeOperator

POINTS = (
    (
        scratch_mesh.BEFORE_ARMATURE,
        "Before the Armature",
        "The rest pose with shape keys and Sinew's correction; the rig still poses it as it plays",
    ),
    (
        scratch_mesh.POSED,
        "Posed",
        "Points as they are shown, in the object's space, for other programs; without modifiers that change their number",
    ),
)
FORMATS = (
    (point_cache.PC2, "PC2", "Point Cache 2"),
    (point_cache.MDD, "MDD", "LightWave's Motion Designer"),
)
AXES = (("Z", "Z Up", "As in Blender"), ("Y", "Y Up", "As in most other programs; Blender turns it back as it plays"))


class SINEW_OT_bake_cache(FrameRangeOperator, Operator):
    """Bake the live skin to a point cache, a file that Blender's Mesh Cache modifier plays without Sinew"""

    bl_idname, bl_label = "sinew.bake_cache", "Bake to Point Cache"

    step: IntProperty(name="Step", description="Bake every frame (1), every second (2), ...", default=1, min=1)
    points: EnumProperty(name="Points", description="Which points are kept", items=POINTS)
    file_format: EnumProperty(name="Format", description="How the file is written", items=FORMATS)
    up_axis: EnumProperty(name="Up", description="Which axis of the file is up", items=AXES)
    folder: StringProperty(
        name="Folder",
        description="Where the file is written, named after the mesh",
        subtype="DIR_PATH",
        default="//",
        options={"PATH_SUPPORTS_BLEND_RELATIVE"},
    )
    attach: BoolProperty(
        name="Play It",
        description="Add a Mesh Cache modifier that plays the file, and switch Live off",
        default=True,
    )

    _bake = None

    def begin(self, context):
        skins = skins_to_bake(context)
        if self.folder.startswith("//") and not bpy.data.filepath:
            raise SinewError("The file was never saved, so there is no folder beside it: save it, or choose a folder")
        folder = Path(bpy.path.abspath(self.folder))
        settings = CacheSettings(self.points, self.file_format, self.up_axis)
        frames = range(self.frame_start, self.frame_end + 1, self.step)
        paths = [path_of(folder, skin, self.file_format) for skin in skins]
        self._bake = CacheBake(skins, context.scene, frames, settings, paths)
        make_folder(folder)
        return self._bake.steps()

    def finish(self, _context):
        bake = self._bake
        if bake.left_out:
            self.report({"WARNING"}, f"Not in the cache, which keeps the number of vertices: {', '.join(bake.left_out)}")
        if self.attach:
            for name, path, modifier_count in zip(bake.skins, bake.paths, bake.modifier_counts, strict=True):
                playback.attach(bpy.data.objects[name], path, self.file_format, bake.timing, self.up_axis, modifier_count)
        megabytes = sum(path.stat().st_size for path in bake.paths) / 1e6
        live = ". Live is off now, so that it plays" if self.attach else ""
        self.report(
            {"INFO"},
            f"{len(bake.timing.frames)} frames baked to {', '.join(path.name for path in bake.paths)} ({megabytes:.1f} MB){live}",
        )
        return {"FINISHED"}
