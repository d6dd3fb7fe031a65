# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the records of chunks in a folder. They may come from strangers: each field is checked before it is used."""

import os
import re
from pathlib import Path

from ...errors import SinewError
from ...files import strict_json
from ...scene.current_frame import FIRST_FRAME, LAST_FRAME
from . import chunks, point_cache
from .playback import UP_AXES

LARGEST_RECORD_BYTES = 20_000
LONGEST_NAME, LONGEST_PATH = 255, 4096  # characters
MOST_VERTICES = 2**31 - 1
POINTS = ("BEFORE_ARMATURE", "POSED")
_CHECKSUM = re.compile(r"[0-9a-f]{64}")
_RECORD = re.compile(r"[^.].*\.\d+-of-\d+(" + "|".join(map(re.escape, point_cache.SUFFIXES.values())) + r")\.json")


def records_in(folder: Path) -> list[chunks.Record]:
    """Reads the records in a folder: the files with their names, and no other. Raises SinewError for a faulty one."""
    if not os.path.isdir(folder):
        raise SinewError(f"There is no folder {folder}")
    names = sorted(name for name in os.listdir(folder) if _RECORD.fullmatch(name))
    return [_read(folder, name) for name in names]


def _read(folder: Path, name: str) -> chunks.Record:
    table = strict_json.read(folder / name, LARGEST_RECORD_BYTES)
    version = table.integer("sinew_chunk", 0, 1_000_000)
    if version != chunks.FORMAT:
        raise table.fault("sinew_chunk", f"is {version}, and this version of Sinew reads {chunks.FORMAT}. Bake again")
    job = _job(table.table("job"))
    record = chunks.Record(
        job,
        table.integer("number", 1, job.of),
        _checksum(table, "sha256"),
        table.long_text("blend", LONGEST_PATH, may_be_empty=True),
    )
    fingerprint = _checksum(table, "fingerprint")
    table.finish()
    if fingerprint != job.fingerprint:
        raise table.fault(
            "fingerprint", "is of another job: the file was changed after it was written. Bake the chunk again"
        )
    expected = chunks.record_path_of(chunks.path_of(folder, job.object, record.chunk, job.file_format)).name
    if name != expected:
        raise table.fault("job", f"belongs to {expected}: the file was renamed. Rename it, or bake that chunk again")
    return record


def _job(table: strict_json.Table) -> chunks.Job:
    first = table.integer("first", FIRST_FRAME, LAST_FRAME)
    last = table.integer("last", first, LAST_FRAME)
    step = table.integer("step", 1, LAST_FRAME)
    job = chunks.Job(
        object=table.long_text("object", LONGEST_NAME),
        scene=table.long_text("scene", LONGEST_NAME),
        first=first,
        last=last,
        step=step,
        of=table.integer("of", 1, len(range(first, last + 1, step))),
        points=table.one_of("points", POINTS),
        file_format=table.one_of("file_format", tuple(point_cache.SUFFIXES)),
        up_axis=table.one_of("up_axis", tuple(UP_AXES)),
        vertices=table.integer("vertices", 1, MOST_VERTICES),
        frames_per_second=table.number("frames_per_second", 1e-6, 1e6),
        source=_checksum(table, "source"),
        sinew=table.text("sinew"),
        blender=table.text("blender"),
    )
    table.finish()
    return job


def _checksum(table: strict_json.Table, field: str) -> str:
    value = table.get(field)
    if not isinstance(value, str) or not _CHECKSUM.fullmatch(value):
        raise table.fault(field, "must be a SHA-256 checksum of 64 hexadecimal digits")
    return value
