# SPDX-License-Identifier: GPL-3.0-or-later
"""Join the chunks in a folder to one point cache per mesh, with the same bytes as a bake of all frames.

All chunks must be present, undamaged and of the same bake: same .blend file, frames, settings and versions. --blend also
saves a copy of that .blend file that plays the result, with Live off; --keys stores the result in it as shape keys, one per
frame.
"""

import argparse
from pathlib import Path

from ..bake.cache import chunks, point_cache
from ..errors import SinewError
from ..files.file_names import stem_of
from .output import Reporter
from .playing_copy import save_playing_copy


def add_arguments(parser: argparse.ArgumentParser):
    parser.add_argument("folder", metavar="DIR", help="the folder of the chunks, to which the joined files are written")
    parser.add_argument("--object", metavar="NAME", action="append", help="join only this mesh; can be repeated")
    parser.add_argument("--blend", metavar="OUT", help="also save a .blend file that plays the caches")
    parser.add_argument("--keys", action="store_true", help="with --blend: store shape keys instead of playing a cache")
    parser.add_argument("--file", metavar="FILE", help="the .blend file that was baked (default: its path at that time)")
    parser.add_argument("--remove-chunks", action="store_true", help="remove the chunks after they are joined")


def run(options: argparse.Namespace, reporter: Reporter) -> dict:
    """Joins. Returns the names and sizes of the files."""
    if options.keys and not options.blend:
        raise SinewError("--keys requires --blend OUT, the file that stores them")
    folder = Path(options.folder).absolute()
    bakes = _bakes(folder, options.object)
    records_by_name = {name: chunks.complete(folder, records) for name, records in bakes.items()}
    targets = {}
    for name, records in records_by_name.items():
        target = folder / (stem_of(name) + point_cache.SUFFIXES[records[0].job.file_format])
        chunks.join(folder, records, target)
        reporter.say(f"{target.name}: {len(records)} chunks, {len(records[0].job.frames)} frames")
        targets[name] = target
    if options.blend:
        save_playing_copy(options.blend, records_by_name, targets, options.file, options.keys, reporter)
    if options.remove_chunks:
        _remove_chunks(folder, records_by_name, reporter)
    return {
        "verb": "merge",
        "files": [{"object": name, "path": str(path), "bytes": path.stat().st_size} for name, path in targets.items()],
        "blend": str(Path(options.blend).absolute()) if options.blend else None,
    }


def _bakes(folder: Path, names: list[str] | None) -> dict[str, list[chunks.Record]]:
    """Returns the records in a folder by mesh. names: only these meshes; None: all."""
    bakes: dict[str, list[chunks.Record]] = {}
    for record in chunks.records_in(folder):
        bakes.setdefault(record.job.object, []).append(record)
    missing = [name for name in names or () if name not in bakes]
    if missing or not bakes:
        available = ", ".join(sorted(bakes)) if bakes else "none"
        raise SinewError(f"{folder} has no chunks{f' of {missing[0]}' if missing else ''}; available meshes: {available}")
    return {name: records for name, records in bakes.items() if not names or name in names}


def _remove_chunks(folder: Path, records_by_name: dict[str, list[chunks.Record]], reporter: Reporter):
    for name, records in records_by_name.items():
        for record in records:
            chunk_path = chunks.path_of(folder, name, record.chunk, record.job.file_format)
            for path in (chunks.record_path_of(chunk_path), chunk_path):
                try:
                    path.unlink(missing_ok=True)
                except OSError as error:
                    reporter.warn(f"{path} could not be removed ({error.strerror})")
