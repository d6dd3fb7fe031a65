# SPDX-License-Identifier: GPL-3.0-or-later
"""Join the chunks in a folder to one point cache per mesh, with the same bytes as a bake of all frames.

All chunks must be present, undamaged and of the same bake: same .blend file, frames, settings and versions. --blend also
saves a copy of the .blend file that was baked, --file, which plays the result, with Live off; --keys stores the result in it
as shape keys, one per frame. If anything fails, no file is written. The path of the .blend file in the chunks' records is
never opened: whoever can write to the folder could name another file there.
"""

import argparse
from contextlib import ExitStack
from pathlib import Path

from ..bake.cache import chunk_records, chunks, point_cache
from ..errors import SinewError
from ..files.atomic_write import atomic_path
from ..files.file_names import stem_of
from .output import Reporter, WrongArguments
from .playing_copy import open_source, save_playing_copy


def add_arguments(parser: argparse.ArgumentParser):
    parser.add_argument("folder", metavar="DIR", help="the folder of the chunks, to which the joined files are written")
    parser.add_argument("--object", metavar="NAME", action="append", help="join only this mesh; can be repeated")
    parser.add_argument("--blend", metavar="OUT", help="also save a .blend file that plays the caches")
    parser.add_argument("--keys", action="store_true", help="with --blend: store shape keys instead of playing a cache")
    parser.add_argument("--file", metavar="FILE", help="with --blend: the .blend file that was baked")
    parser.add_argument("--remove-chunks", action="store_true", help="remove the chunks after they are joined")


def run(options: argparse.Namespace, reporter: Reporter) -> dict:
    """Joins. Returns the names and sizes of the files."""
    if options.keys and not options.blend:
        raise WrongArguments("--keys requires --blend=OUT, the file that stores them")
    if options.blend and not options.file:
        raise WrongArguments("--blend requires --file=FILE, the .blend file that was baked")
    folder = Path(options.folder).absolute()
    bakes = _bakes(folder, options.object)
    records_by_name = {name: chunks.complete(folder, records) for name, records in bakes.items()}
    if options.blend:
        open_source(options.file, records_by_name, reporter)
    targets = {
        name: folder / (stem_of(name) + point_cache.SUFFIXES[records[0].job.file_format])
        for name, records in records_by_name.items()
    }
    with ExitStack() as unfinished:  # the joined files get their names when all else has succeeded
        joined = {name: unfinished.enter_context(atomic_path(target)) for name, target in targets.items()}
        for name, records in records_by_name.items():
            with open(joined[name], "xb") as file:
                chunks.join(folder, records, file)
            reporter.say(f"{targets[name].name}: {len(records)} chunks, {len(records[0].job.frames)} frames")
        if options.blend:
            save_playing_copy(options.blend, records_by_name, targets, joined if options.keys else None, reporter)
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
    for record in chunk_records.records_in(folder):
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
