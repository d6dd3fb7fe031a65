# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake in parts that machines make independently: each part's file and what it tells of itself, and joining them.

A part is a point cache of its own frames. Beside it stands its record (JSON) with the fingerprint of all that decides the
result: parts are joined only where these agree and every byte is as it was written. The joined file has the same bytes
as one that was baked at once.
"""

import hashlib
import json
import os
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

from ...errors import SinewError
from ...files.atomic_write import atomic_write
from ...files.file_names import stem_of
from . import point_cache
from .point_cache import Timing

FORMAT = 1


@dataclass(frozen=True)
class Chunk:
    """Part `number` of `of`, counted from 1."""

    number: int
    of: int

    def frames(self, frames: range) -> range:
        """The frames of this part: all parts follow each other, and differ by one frame at most.

        Raises SinewError where there are more parts than frames.
        """
        if self.of > len(frames):
            raise SinewError(f"{len(frames)} frames can't be split into {self.of} chunks")
        return frames[(self.number - 1) * len(frames) // self.of : self.number * len(frames) // self.of]

    def name(self, stem: str) -> str:
        """The part's name without suffix; names stand in order."""
        return f"{stem}.{self.number:0{len(str(self.of))}}-of-{self.of}"


@dataclass(frozen=True)
class Job:
    """All that decides what a bake gives, the same for each of its parts.

    first, last, step: the frames of the whole bake. source: the checksum of the .blend and its libraries.
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
        """When the samples of the whole bake are."""
        return Timing(self.frames, self.frames_per_second)

    @property
    def fingerprint(self) -> str:
        """The checksum of all of this."""
        return hashlib.sha256(json.dumps(asdict(self), sort_keys=True).encode()).hexdigest()


@dataclass(frozen=True)
class Record:
    """What stands beside a part: whose it is, its checksum, and where the .blend was that it was baked from."""

    job: Job
    number: int
    sha256: str
    blend: str

    @property
    def chunk(self) -> Chunk:
        """Which part this is."""
        return Chunk(self.number, self.job.of)


def path_of(folder: Path, name: str, chunk: Chunk, file_format: str) -> Path:
    """Where a part of an object's cache is written."""
    return folder / (chunk.name(stem_of(name)) + point_cache.SUFFIXES[file_format])


def record_path_of(part: Path) -> Path:
    """Where a part's record is."""
    return part.with_name(f"{part.name}.json")


def write_record(part: Path, record: Record):
    """Writes the record of a part whose file is there."""
    told = {"sinew_chunk": FORMAT, "fingerprint": record.job.fingerprint, **asdict(record)}
    with atomic_write(record_path_of(part)) as file:
        file.write((json.dumps(told, indent=1, ensure_ascii=False) + "\n").encode())


def records_in(folder: Path) -> list[Record]:
    """All records in a folder. Raises SinewError for one that can't be read."""
    if not os.path.isdir(folder):
        raise SinewError(f"There is no folder {folder}")
    records = []
    for path in sorted(folder.glob("[!.]*.json")):  # a dot: not finished
        try:
            told = json.loads(path.read_bytes())
            if not isinstance(told, dict) or "sinew_chunk" not in told:
                continue  # someone else's
            if told["sinew_chunk"] != FORMAT:
                raise SinewError(f"{path} is of format {told['sinew_chunk']}, and this Sinew knows {FORMAT}: bake again")
            record = Record(Job(**told["job"]), told["number"], told["sha256"], told["blend"])
        except (OSError, ValueError, TypeError, KeyError) as error:
            raise SinewError(f"{path} can't be read ({error}): remove it, or bake that chunk again") from error
        if told["fingerprint"] != record.job.fingerprint:
            raise SinewError(f"{path} was changed after it was written: bake that chunk again")
        records.append(record)
    return records


def complete(folder: Path, records: list[Record]) -> list[Record]:
    """The parts of one bake in their order. Raises SinewError where one is missing, damaged, or of another bake."""
    job = records[0].job
    others = [record for record in records if record.job.fingerprint != job.fingerprint]
    if others:
        raise SinewError(
            f"{folder} has chunks of different bakes of {job.object}: {_difference(records[0], others[0])}; "
            "remove those of one, or bake them again"
        )
    present = {record.number: record for record in records}
    missing = [str(number) for number in range(1, job.of + 1) if number not in present]
    if missing:
        are = "is" if len(missing) == 1 else "are"
        raise SinewError(f"{job.object}: of {job.of} chunks {', '.join(missing)} {are} missing in {folder}")
    ordered = [present[number] for number in range(1, job.of + 1)]
    for record in ordered:
        part = path_of(folder, job.object, record.chunk, job.file_format)
        if not part.is_file() or checksum(part) != record.sha256:
            raise SinewError(f"{part} is missing or not as it was written: bake chunk {record.number} again")
    return ordered


def join(folder: Path, records: list[Record], target: Path):
    """Writes one file of all parts, as `complete` gives them."""
    job = records[0].job
    with atomic_write(target) as file:
        file.write(point_cache.head_of(job.file_format, job.timing, job.vertices))
        for record in records:
            for block in _samples(folder, record):
                file.write(block)


def checksum(path: Path) -> str:
    """The SHA-256 of a file, in hexadecimal digits."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _samples(folder: Path, record: Record) -> Iterator[bytes]:
    job = record.job
    own = Timing(record.chunk.frames(job.frames), job.frames_per_second)
    head = len(point_cache.head_of(job.file_format, own, job.vertices))
    return point_cache.samples_of(path_of(folder, job.object, record.chunk, job.file_format), head)


def _difference(one: Record, other: Record) -> str:
    """What sets two bakes apart, in words."""
    ours, theirs = asdict(one.job), asdict(other.job)
    name = next(name for name in ours if ours[name] != theirs[name])
    return f"{name.replace('_', ' ')} is {ours[name]} in chunk {one.number} and {theirs[name]} in chunk {other.number}"
