# SPDX-License-Identifier: GPL-3.0-or-later
"""Join the chunks in a folder to one point cache a mesh, the same bytes as of a bake at once.

Every chunk must be there, whole, and of the same bake: same .blend, frames, settings and versions. --blend also saves a copy
of that .blend that plays the result, with Live off; --keys puts it in there as shape keys, one a frame.
"""

import argparse
from pathlib import Path

import bpy

from ..bake.cache import chunks, playback, point_cache
from ..bake.keys.cache_keys import add_keys
from ..bake.scratch.scratch_mesh import BEFORE_ARMATURE, ScratchMesh
from ..errors import SinewError
from ..files.file_names import stem_of
from .blend_file import choose_scene, object_named, open_file, save_copy, source_checksum
from .output import Reporter


def add_arguments(parser: argparse.ArgumentParser):
    parser.add_argument("folder", metavar="DIR", help="where the chunks are, and the joined files go")
    parser.add_argument(
        "--object", metavar="NAME", action="append", help="only this mesh; may be given again (default: all)"
    )
    parser.add_argument("--blend", metavar="OUT", help="also save a .blend in which the caches play")
    parser.add_argument("--keys", action="store_true", help="with --blend: shape keys instead of a cache that it plays")
    parser.add_argument("--file", metavar="FILE", help="where the .blend is that was baked (default: where it was then)")
    parser.add_argument("--remove-chunks", action="store_true", help="remove the chunks once they are joined")


def run(wanted: argparse.Namespace, reporter: Reporter) -> dict:
    """Joins; tells the files that were written."""
    if wanted.keys and not wanted.blend:
        raise SinewError("--keys needs --blend OUT, the file that is to hold them")
    folder = Path(wanted.folder).absolute()
    bakes = _bakes(folder, wanted.object)
    ordered = {name: chunks.complete(folder, records) for name, records in bakes.items()}
    targets = {}
    for name, records in ordered.items():
        target = folder / (stem_of(name) + point_cache.SUFFIXES[records[0].job.file_format])
        chunks.join(folder, records, target)
        reporter.say(f"{target.name}: {len(records)} chunks, {len(records[0].job.frames)} frames")
        targets[name] = target
    if wanted.blend:
        _save_playing(wanted, ordered, targets, reporter)
    if wanted.remove_chunks:
        _remove_chunks(folder, ordered, reporter)
    return {
        "verb": "merge",
        "files": [{"object": name, "path": str(path), "bytes": path.stat().st_size} for name, path in targets.items()],
        "blend": str(Path(wanted.blend).absolute()) if wanted.blend else None,
    }


def _bakes(folder: Path, names: list[str] | None) -> dict[str, list[chunks.Record]]:
    """The records in a folder, by mesh."""
    bakes: dict[str, list[chunks.Record]] = {}
    for record in chunks.records_in(folder):
        bakes.setdefault(record.job.object, []).append(record)
    missing = [name for name in names or () if name not in bakes]
    if missing or not bakes:
        there = ", ".join(sorted(bakes)) if bakes else "none"
        raise SinewError(f"{folder} has no chunks{f' of {missing[0]}' if missing else ''}; there are of: {there}")
    return {name: records for name, records in bakes.items() if not names or name in names}


def _save_playing(wanted: argparse.Namespace, ordered: dict, targets: dict[str, Path], reporter: Reporter):
    """Saves a copy of the .blend that was baked, which plays what was joined."""
    first = next(iter(ordered.values()))[0]
    open_file(wanted.file or first.blend, reporter)
    source = source_checksum()
    for name, records in ordered.items():
        job = records[0].job
        if job.source != source:
            raise SinewError(f"{bpy.data.filepath} (or a library of it) is not what {name} was baked from: bake again")
        choose_scene(job.scene)
        skin = object_named(name, "MESH", "mesh")
        if wanted.keys:
            if job.points != BEFORE_ARMATURE:
                raise SinewError(f"{name} was baked posed; for shape keys bake it with --points before-armature")
            samples = point_cache.read(targets[name], job.file_format).samples
            reporter.follow(add_keys(skin, bpy.context.scene, samples, job.timing, job.up_axis), f"keys of {name}")
            continue
        skin.sinew.skin.live = True
        scratch_mesh = ScratchMesh(bpy.context.scene, skin, job.points)
        scratch_mesh.remove()
        playback.attach(skin, targets[name], job.file_format, job.timing, job.up_axis, scratch_mesh.place)
    save_copy(wanted.blend)


def _remove_chunks(folder: Path, ordered: dict, reporter: Reporter):
    for name, records in ordered.items():
        for record in records:
            part = chunks.path_of(folder, name, record.chunk, record.job.file_format)
            for path in (chunks.record_path_of(part), part):
                try:
                    path.unlink(missing_ok=True)
                except OSError as error:
                    reporter.warn(f"{path} could not be removed ({error.strerror})")
