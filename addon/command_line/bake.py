# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake the live skin of meshes to point caches, all frames or one chunk of them.

Without --chunk, the bake writes NAME.pc2 to DIR. With --chunk K/N it writes NAME.K-of-N.pc2 and the record
NAME.K-of-N.pc2.json. Chunks can be baked in any order, on any machine, at the same time and repeatedly; `merge DIR` joins
them to the same bytes as a bake of all frames. A frame of a simulation (cloth, soft bodies) depends on the frames before
it: bake simulations in Blender first.
"""

import argparse
import tomllib
from pathlib import Path

import bpy

from ..bake.cache import chunks
from ..bake.cache.cache_bake import CacheBake, CacheSettings, path_of
from ..bake.cache.playback import UP_AXES
from ..bake.cache.point_cache import SUFFIXES
from ..bake.scratch.scratch_mesh import BEFORE_ARMATURE, POSED
from ..files.atomic_write import make_folder
from .blend_file import add_file_argument, choose_scene, object_named, open_file, source_checksum
from .frames import add_frame_arguments, chunk_of, range_of
from .output import Reporter

_MANIFEST = Path(__file__).parent.parent / "blender_manifest.toml"
_POINTS = {"before-armature": BEFORE_ARMATURE, "posed": POSED}


def add_arguments(parser: argparse.ArgumentParser):
    add_file_argument(parser)
    parser.add_argument("--object", metavar="NAME", action="append", required=True, help="a bound mesh; can be repeated")
    parser.add_argument("--output", metavar="DIR", required=True, help="the folder for the files; made if it does not exist")
    add_frame_arguments(parser)
    parser.add_argument("--chunk", metavar="K/N", type=chunk_of, help="bake only chunk K of N of these frames")
    parser.add_argument("--scene", metavar="NAME", help="the scene (default: the current scene of the file)")
    parser.add_argument("--format", choices=[name.lower() for name in SUFFIXES], default="pc2")
    parser.add_argument(
        "--points",
        choices=list(_POINTS),
        default="before-armature",
        help="points before the Armature modifier (default), or posed points in object space, for other programs",
    )
    parser.add_argument(
        "--up", choices=[axis.lower() for axis in UP_AXES], default="z", help="the up axis in the files (default: z)"
    )


def run(options: argparse.Namespace, reporter: Reporter) -> dict:
    """Bakes. Returns the names and sizes of the files."""
    open_file(options.file, reporter)
    choose_scene(options.scene)
    skins = [object_named(name, "MESH", "mesh") for name in dict.fromkeys(options.object)]
    scene, folder = bpy.context.scene, Path(options.output).absolute()
    settings = CacheSettings(_POINTS[options.points], options.format.upper(), options.up.upper())
    frames = range_of(options, scene)
    baked_frames = options.chunk.frames(frames) if options.chunk else frames
    if options.chunk:
        paths = [chunks.path_of(folder, skin.name, options.chunk, settings.file_format) for skin in skins]
    else:
        paths = [path_of(folder, skin, settings.file_format) for skin in skins]
    bake = CacheBake(skins, scene, baked_frames, settings, paths, bind_frame=frames.start)
    make_folder(folder)
    source = source_checksum() if options.chunk else ""
    chunk_label = f" (chunk {options.chunk.number} of {options.chunk.of})" if options.chunk else ""
    reporter.follow(bake.steps(), f"baking frames {baked_frames[0]} to {baked_frames[-1]}{chunk_label}")
    if bake.left_out:
        names = ", ".join(bake.left_out)
        reporter.warn(f"modifiers that are not in the cache, in which the number of vertices can't change: {names}")
    for skin, path, vertices in zip(skins, paths, bake.vertices, strict=True):
        if options.chunk:
            job = _job(skin, vertices, frames, options.chunk.of, bake, source)
            chunks.write_record(path, chunks.Record(job, options.chunk.number, chunks.checksum(path), bpy.data.filepath))
    files = zip(skins, paths, strict=True)
    return {
        "verb": "bake",
        "frames": [baked_frames[0], baked_frames[-1], baked_frames.step],
        "chunk": [options.chunk.number, options.chunk.of] if options.chunk else None,
        "files": [{"object": skin.name, "path": str(path), "bytes": path.stat().st_size} for skin, path in files],
    }


def _job(skin, vertices: int, frames: range, of: int, bake: CacheBake, source: str) -> chunks.Job:
    return chunks.Job(
        object=skin.name,
        scene=bake.scene.name,
        first=frames[0],
        last=frames[-1],
        step=frames.step,
        of=of,
        points=bake.settings.points,
        file_format=bake.settings.file_format,
        up_axis=bake.settings.up_axis,
        vertices=vertices,
        frames_per_second=bake.timing.frames_per_second,
        source=source,
        sinew=tomllib.loads(_MANIFEST.read_text(encoding="utf-8"))["version"],
        blender=bpy.app.version_string,
    )
