# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake the live skin of meshes to point caches, all frames or one chunk of them.

Without --chunk, DIR gets NAME.pc2. With --chunk K/N it gets NAME.K-of-N.pc2 and its record NAME.K-of-N.pc2.json; chunks may
be made in any order, on any machine, at the same time and again, and `merge DIR` joins them to the same bytes. Simulations
(cloth, soft bodies) depend on the frames before: bake them in Blender first.
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
    parser.add_argument("--object", metavar="NAME", action="append", required=True, help="a bound mesh; may be given again")
    parser.add_argument(
        "--output", metavar="DIR", required=True, help="the folder for the files; made where it is not there"
    )
    add_frame_arguments(parser)
    parser.add_argument("--chunk", metavar="K/N", type=chunk_of, help="only the Kth of N parts of these frames")
    parser.add_argument("--scene", metavar="NAME", help="the scene (default: the one that was saved as current)")
    parser.add_argument("--format", choices=[name.lower() for name in SUFFIXES], default="pc2")
    parser.add_argument(
        "--points",
        choices=list(_POINTS),
        default="before-armature",
        help="points that the rig still poses (default), or posed points in the object's space, for other programs",
    )
    parser.add_argument(
        "--up", choices=[axis.lower() for axis in UP_AXES], default="z", help="the axis that is up in the file"
    )


def run(wanted: argparse.Namespace, reporter: Reporter) -> dict:
    """Bakes; tells the files that were written."""
    open_file(wanted.file, reporter)
    choose_scene(wanted.scene)
    skins = [object_named(name, "MESH", "mesh") for name in dict.fromkeys(wanted.object)]
    scene, folder = bpy.context.scene, Path(wanted.output).absolute()
    settings = CacheSettings(_POINTS[wanted.points], wanted.format.upper(), wanted.up.upper())
    frames = range_of(wanted, scene)
    own = wanted.chunk.frames(frames) if wanted.chunk else frames
    if wanted.chunk:
        paths = [chunks.path_of(folder, skin.name, wanted.chunk, settings.file_format) for skin in skins]
    else:
        paths = [path_of(folder, skin, settings.file_format) for skin in skins]
    bake = CacheBake(skins, scene, own, settings, paths, bind_frame=frames.start)
    make_folder(folder)
    source = source_checksum() if wanted.chunk else ""
    which = f" (chunk {wanted.chunk.number} of {wanted.chunk.of})" if wanted.chunk else ""
    reporter.follow(bake.steps(), f"baking frames {own[0]} to {own[-1]}{which}")
    if bake.left_out:
        reporter.warn(f"not in the cache, which keeps the number of vertices: {', '.join(bake.left_out)}")
    for skin, path, vertices in zip(skins, paths, bake.vertices, strict=True):
        if wanted.chunk:
            job = _job(skin, vertices, frames, wanted.chunk.of, bake, source)
            chunks.write_record(path, chunks.Record(job, wanted.chunk.number, chunks.checksum(path), bpy.data.filepath))
    files = zip(skins, paths, strict=True)
    return {
        "verb": "bake",
        "frames": [own[0], own[-1], own.step],
        "chunk": [wanted.chunk.number, wanted.chunk.of] if wanted.chunk else None,
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
