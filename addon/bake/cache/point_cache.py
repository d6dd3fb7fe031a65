# SPDX-License-Identifier: GPL-3.0-or-later
"""The two point cache formats that Blender's Mesh Cache modifier, and most other programs, play.

PC2 (John Burnett's Point Cache 2 for 3ds Max, readme of release 6): little-endian; "POINTCACHE2\\0", int32 version 1,
int32 points, float32 first frame, float32 frames between samples, int32 samples; then float32 x, y, z of each sample.
MDD (NewTek's Motion Designer for LightWave): big-endian; int32 samples, int32 points, float32 seconds of each sample
from the first; then float32 x, y, z of each sample.

All of a file but its head is its samples one after another, so that files of neighbouring frames are joined by a new head.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ...errors import SinewError

PC2, MDD = "PC2", "MDD"
SUFFIXES = {PC2: ".pc2", MDD: ".mdd"}
_PC2_HEAD = struct.Struct("<12siiffi")
_PC2_SIGNATURE = b"POINTCACHE2\0"
_MDD_HEAD = struct.Struct(">ii")


@dataclass(frozen=True)
class Timing:
    """Which frames a cache holds: `frames` (first, last, step), at so many frames a second."""

    frames: range
    frames_per_second: float


@dataclass(frozen=True)
class Cache:
    """What stands in a point cache file: (samples, points, 3) float32, mapped from the file, not read."""

    samples: np.ndarray
    frame_start: float | None  # PC2 alone tells it
    step: float | None


def head_of(file_format: str, timing: Timing, points: int) -> bytes:
    """What a file of this format begins with."""
    frames = timing.frames
    if file_format == PC2:
        return _PC2_HEAD.pack(_PC2_SIGNATURE, 1, points, frames.start, frames.step, len(frames))
    seconds = (np.arange(len(frames), dtype=np.float64) * frames.step / timing.frames_per_second).astype(">f4")
    return _MDD_HEAD.pack(len(frames), points) + seconds.tobytes()


def write_sample(file: BinaryIO, file_format: str, points: np.ndarray):
    """Appends the points of a frame, (points, 3) float32."""
    file.write(points.astype("<f4" if file_format == PC2 else ">f4", copy=False).tobytes())


def samples_of(path: Path, head_bytes: int, block_bytes: int = 1 << 20) -> Iterator[bytes]:
    """The bytes of a file's samples, as they stand in it, in blocks."""
    with open(path, "rb") as file:
        file.seek(head_bytes)
        while block := file.read(block_bytes):
            yield block


def read(path: Path, file_format: str) -> Cache:
    """A point cache. Raises SinewError for a file that is none, or is cut short, and OSError where it can't be read."""
    size = path.stat().st_size
    with open(path, "rb") as file:
        head = file.read(_PC2_HEAD.size)
    frame_start = step = None
    if file_format == PC2:
        if len(head) < _PC2_HEAD.size or head[:12] != _PC2_SIGNATURE:
            raise SinewError(f"{path} is no PC2 point cache: it does not begin with POINTCACHE2")
        _signature, _version, points, frame_start, step, samples = _PC2_HEAD.unpack(head)
        offset = _PC2_HEAD.size
    else:
        if len(head) < _MDD_HEAD.size:
            raise SinewError(f"{path} is no MDD point cache: it is {size} bytes long")
        samples, points = _MDD_HEAD.unpack(head[: _MDD_HEAD.size])
        offset = _MDD_HEAD.size + 4 * samples
    if min(samples, points) < 1 or size != offset + 12 * points * samples:
        raise SinewError(f"{path} is cut short or damaged: {size} bytes for {samples} samples of {points} points")
    stored = np.memmap(path, "<f4" if file_format == PC2 else ">f4", "r", offset, (samples, points, 3))
    return Cache(stored, frame_start, step)
