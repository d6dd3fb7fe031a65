# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.bake_cache` bakes skins to point cache files."""

from pathlib import Path

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty
from bpy.types import Operator

from ..bake.cache import playback, point_cache
from ..bake.cache.cache_bake import CacheBake, CacheSettings, path_of
from ..bake.scratch import scratch_mesh
from ..errors import SinewError
from ..files.atomic_write import make_folder
from ..scene.current_frame import time_per_frame
from .base import skins_to_bake
from .frame_range import STEP, FrameRangeOperator

POINTS = (
    (
        scratch_mesh.BEFORE_ARMATURE,
        "Before the Armature",
        "Rest pose with shape keys and Sinew's correction. The armature still poses the mesh during playback",
    ),
    (
        scratch_mesh.POSED,
        "Posed",
        "Posed points in object space, for other programs. Modifiers that change the number of points are left out",
    ),
)
FORMATS = (
    (point_cache.PC2, "PC2", "Point Cache 2 file"),
    (point_cache.MDD, "MDD", "Motion Designer file of LightWave"),
)
AXES = (
    ("Z", "Z Up", "The axis of Blender"),
    ("Y", "Y Up", "The axis of most other programs. Blender converts it back during playback"),
)


class SINEW_OT_bake_cache(FrameRangeOperator, Operator):
    """Bake the live skin to a point cache file. Blender's Mesh Cache modifier plays it back without Sinew"""

    bl_idname, bl_label = "sinew.bake_cache", "Bake to Point Cache"
    needs_bound_skin = True

    step: STEP
    points: EnumProperty(name="Points", description="The points to store", items=POINTS)
    file_format: EnumProperty(name="Format", description="File format of the cache", items=FORMATS)
    up_axis: EnumProperty(name="Up", description="The up axis of the file", items=AXES)
    folder: StringProperty(
        name="Folder",
        description="Folder of the cache files. Each file is named after its mesh",
        subtype="DIR_PATH",
        default="//",
        options={"PATH_SUPPORTS_BLEND_RELATIVE"},
    )
    attach: BoolProperty(
        name="Play Back",
        description="Add a Mesh Cache modifier that plays back the file, and switch Live off",
        default=True,
    )

    _bake = None

    def begin(self, context):
        skins = skins_to_bake(context)
        if self.folder.startswith("//") and not bpy.data.filepath:
            raise SinewError("The file is not saved, so // is not a folder yet. Save the file or choose another folder")
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
            self.report(
                {"WARNING"}, f"Modifiers left out because they change the number of vertices: {', '.join(bake.left_out)}"
            )
        if self.attach:
            per_frame = time_per_frame(bake.scene)
            for name, path, count in zip(bake.skins, bake.paths, bake.modifier_counts, strict=True):
                skin = bpy.data.objects[name]
                playback.attach(skin, path, self.file_format, bake.timing, self.up_axis, count, per_frame)
        names = ", ".join(path.name for path in bake.paths)
        megabytes = sum(path.stat().st_size for path in bake.paths) / 1e6
        live = ". Live is switched off for playback" if self.attach else ""
        self.report(
            {"INFO"},
            f"{len(bake.timing.frames)} frames baked to {names} ({megabytes:.1f} MB){live}",
        )
        return {"FINISHED"}
