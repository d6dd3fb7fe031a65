# SPDX-License-Identifier: GPL-3.0-or-later
"""Saves a copy of the .blend file that was baked, in which joined caches play as a Mesh Cache modifier or as shape keys."""

from pathlib import Path

import bpy

from ..bake.cache import chunks, playback, point_cache
from ..bake.keys.cache_keys import add_keys
from ..bake.scratch.scratch_mesh import BEFORE_ARMATURE, ScratchMesh
from ..errors import SinewError
from ..scene.current_frame import time_per_frame
from .blend_file import choose_scene, object_named, open_file, save_copy, source_checksum
from .output import Reporter


def open_source(file: str, records_by_name: dict[str, list[chunks.Record]], reporter: Reporter):
    """Opens the .blend file that was baked. Raises SinewError if it or a library has changed since the bake."""
    open_file(file, reporter)
    checksum = source_checksum()
    for name, records in records_by_name.items():
        if records[0].job.source != checksum:
            raise SinewError(
                f"{bpy.data.filepath} or one of its libraries has changed since {name} was baked from it, or it is another "
                "file. Bake again, or name the file that was baked"
            )


def save_playing_copy(
    target: str,
    records_by_name: dict[str, list[chunks.Record]],
    caches: dict[str, Path],
    contents: dict[str, Path] | None,
    reporter: Reporter,
):
    """Saves a copy of the open file that plays the caches of meshes, with Live off.

    records_by_name: the chunks of each mesh. caches: the joined caches. contents: to store shape keys instead, the files
    that have the caches' contents now.
    """
    for name, records in records_by_name.items():
        job = records[0].job
        choose_scene(job.scene)
        skin = object_named(name, "MESH", "mesh")
        if contents is not None:
            _add_keys(skin, job, contents[name], reporter)
        else:
            _attach(skin, job, caches[name])
    save_copy(target)


def _add_keys(skin, job: chunks.Job, cache: Path, reporter: Reporter):
    if job.points != BEFORE_ARMATURE:
        raise SinewError(f"{skin.name} was baked posed. For shape keys, bake it with --points before-armature")
    samples = point_cache.read(cache, job.file_format).samples
    reporter.follow(add_keys(skin, bpy.context.scene, samples, job.timing, job.up_axis), f"keys of {skin.name}")


def _attach(skin, job: chunks.Job, cache: Path):
    skin.sinew.skin.live = True
    scratch_mesh = ScratchMesh(bpy.context.scene, skin, job.points)  # only to count the modifiers before the cache
    scratch_mesh.remove()
    count, per_frame = scratch_mesh.modifier_count, time_per_frame(bpy.context.scene)
    playback.attach(skin, cache, job.file_format, job.timing, job.up_axis, count, per_frame)
