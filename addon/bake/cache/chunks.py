# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake in chunks that several machines make independently: each chunk's file and record, and joining them.

A chunk is a point cache of its frames. Beside it is its record, a JSON file with a fingerprint of everything that the
result depends on. Chunks are joined only if their fingerprints agree and their files have the checksums of their
records. The joined file has the same bytes as a file that was baked at once.
"""

import hashlib
import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from itertools import islice
from pathlib import Path
from typing import BinaryIO

from ...errors import SinewError
from ...files.atomic_write import atomic_write
from ...files.file_names import stem_of
from . import point_cache
from .point_cache import Timing

FORMAT = 1
MOST_SHOWN = 10  # numbers of chunks in a message


@dataclass(frozen=True)
class Chunk:
    """Chunk `number` of `of`, counted from 1."""

    number: int
    of: int

    def frames(self, frames: range) -> range:
        """Returns the frames of this chunk. Chunks are consecutive, and their lengths differ by at most one frame.

        Raises SinewError if there are more chunks than frames.
        """
        if self.of > len(frames):
            raise SinewError(f"{len(frames)} frames can't be split into {self.of} chunks")
        return frames[(self.number - 1) * len(frames) // self.of : self.number * len(frames) // self.of]

    def name(self, stem: str) -> str:
        """Returns the name of the chunk's file without suffix. Names sort by number."""
        return f"{stem}.{self.number:0{len(str(self.of))}}-of-{self.of}"


@dataclass(frozen=True)
class Job:
    """Everything that the result of a bake depends on. It is the same for all of its chunks.

    first, last, step: the frames of the whole bake. source: the checksum of the .blend file and its libraries.
    """

    object: str
    scene: str
    first: int
    last: int
    step: int
    of: int
    points: str
    file_format: str
    up_axis: str
    vertices: int
    frames_per_second: float
    source: str
    sinew: str
    blender: str

    @property
    def frames(self) -> range:
        """The frames of the whole bake."""
        return range(self.first, self.last + 1, self.step)

    @property
    def timing(self) -> Timing:
        """The frames of the whole bake and their rate."""
        return Timing(self.frames, self.frames_per_second)

    @property
    def fingerprint(self) -> str:
        """The checksum of all fields."""
        return hashlib.sha256(json.dumps(asdict(self), sort_keys=True).encode()).hexdigest()


@dataclass(frozen=True)
class Record:
    """The record of a chunk: its job and number, the checksum of its file, and the path of the .blend file."""

    job: Job
    number: int
    sha256: str
    blend: str

    @property
    def chunk(self) -> Chunk:
        """The chunk that the record describes."""
        return Chunk(self.number, self.job.of)


def path_of(folder: Path, name: str, chunk: Chunk, file_format: str) -> Path:
    """The path of a chunk of an object's cache."""
    return folder / (chunk.name(stem_of(name)) + point_cache.SUFFIXES[file_format])


def record_path_of(chunk_path: Path) -> Path:
    """The path of the record of a chunk's file."""
    return chunk_path.with_name(f"{chunk_path.name}.json")


def write_record(chunk_path: Path, record: Record):
    """Writes the record of a chunk. The chunk's file must exist."""
    fields = {"sinew_chunk": FORMAT, "fingerprint": record.job.fingerprint, **asdict(record)}
    with atomic_write(record_path_of(chunk_path)) as file:
        file.write((json.dumps(fields, indent=1, ensure_ascii=False) + "\n").encode())


def complete(folder: Path, records: list[Record]) -> list[Record]:
    """Returns the records of one bake in order. Raises SinewError if a chunk is missing, damaged, or of another bake."""
    job = records[0].job
    others = [record for record in records if record.job.fingerprint != job.fingerprint]
    if others:
        raise SinewError(
            f"{folder} has chunks of different bakes of {job.object}: {_difference(records[0], others[0])}. "
            "Remove those of one bake, or bake them again"
        )
    present = {record.number: record for record in records}
    count = job.of - len(present)
    if count:
        missing = (str(number) for number in range(1, job.of + 1) if number not in present)
        shown = ", ".join(islice(missing, MOST_SHOWN)) + (", ..." if count > MOST_SHOWN else "")
        raise SinewError(f"{job.object}: of {job.of} chunks {shown} {'is' if count == 1 else 'are'} missing in {folder}")
    ordered = [present[number] for number in range(1, job.of + 1)]
    for record in ordered:
        path = path_of(folder, job.object, record.chunk, job.file_format)
        if not path.is_file() or not _has_samples(path, record) or checksum(path) != record.sha256:
            raise SinewError(f"{path} is missing or was changed after it was written. Bake chunk {record.number} again")
    return ordered


def join(folder: Path, records: list[Record], file: BinaryIO):
    """Writes the samples of all chunks to one file. records: as `complete` returns them."""
    job = records[0].job
    file.write(point_cache.header_of(job.file_format, job.timing, job.vertices))
    for record in records:
        for block in _samples(folder, record):
            file.write(block)


def checksum(path: Path) -> str:
    """The SHA-256 of a file in hexadecimal digits."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _samples(folder: Path, record: Record) -> Iterator[bytes]:
    job = record.job
    return point_cache.samples_of(path_of(folder, job.object, record.chunk, job.file_format), len(_header(record)))


def _header(record: Record) -> bytes:
    """The header that the file of a chunk must have."""
    job = record.job
    timing = Timing(record.chunk.frames(job.frames), job.frames_per_second)
    return point_cache.header_of(job.file_format, timing, job.vertices)


def _has_samples(path: Path, record: Record) -> bool:
    """Whether a file has the header and the size that the record of its chunk requires."""
    header = _header(record)
    with open(path, "rb") as file:
        found = file.read(len(header))
    frames = len(record.chunk.frames(record.job.frames))
    return found == header and path.stat().st_size == len(header) + point_cache.sample_bytes(record.job.vertices) * frames


def _difference(one: Record, other: Record) -> str:
    """Names the first field in which two bakes differ, with both values."""
    ours, theirs = asdict(one.job), asdict(other.job)
    name = next(name for name in ours if ours[name] != theirs[name])
    return f"{name.replace('_', ' ')} is {ours[name]} in chunk {one.number} and {theirs[name]} in chunk {other.number}"
