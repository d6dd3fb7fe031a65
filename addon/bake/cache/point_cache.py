# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads and writes the two point cache formats that Blender's Mesh Cache modifier and most other programs play.

PC2 (John Burnett's Point Cache 2 for 3ds Max, readme of release 6) is little-endian: "POINTCACHE2\\0", int32 version 1,
int32 points, float32 first frame, float32 frames between samples, int32 samples; then float32 x, y, z of each sample.
MDD (NewTek's Motion Designer for LightWave) is big-endian: int32 samples, int32 points, float32 seconds of each sample
from the first; then float32 x, y, z of each sample.

After its header, a file consists of its samples one after another. So files of consecutive frames are joined by writing
a new header.
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
_PC2_HEADER = struct.Struct("<12siiffi")
_PC2_SIGNATURE = b"POINTCACHE2\0"
_MDD_HEADER = struct.Struct(">ii")


@dataclass(frozen=True)
class Timing:
    """The frames of a cache (first, last, step) and the number of frames per second."""

    frames: range
    frames_per_second: float


@dataclass(frozen=True)
class Cache:
    """The contents of a point cache file. samples: (samples, points, 3) float32, mapped from the file."""

    samples: np.ndarray
    frame_start: float | None  # None: the format MDD does not store it
    step: float | None


def header_of(file_format: str, timing: Timing, points: int) -> bytes:
    """Returns the header of a file in this format. points: the number of vertices."""
    frames = timing.frames
    if file_format == PC2:
        return _PC2_HEADER.pack(_PC2_SIGNATURE, 1, points, frames.start, frames.step, len(frames))
    seconds = (np.arange(len(frames), dtype=np.float64) * frames.step / timing.frames_per_second).astype(">f4")
    return _MDD_HEADER.pack(len(frames), points) + seconds.tobytes()


def sample_bytes(points: int) -> int:
    """The size of the sample of one frame."""
    return 12 * points


def write_sample(file: BinaryIO, file_format: str, points: np.ndarray):
    """Appends the points of a frame, (points, 3) float32."""
    file.write(points.astype("<f4" if file_format == PC2 else ">f4", copy=False).tobytes())


def samples_of(path: Path, header_bytes: int, block_bytes: int = 1 << 20) -> Iterator[bytes]:
    """Yields the bytes of a file after its header, in blocks."""
    with open(path, "rb") as file:
        file.seek(header_bytes)
        while block := file.read(block_bytes):
            yield block


def read(path: Path, file_format: str) -> Cache:
    """Opens a point cache.

    Raises SinewError if the file has another format or another size than its header says, OSError if it can't be read.
    """
    size = path.stat().st_size
    with open(path, "rb") as file:
        header = file.read(_PC2_HEADER.size)
    frame_start = step = None
    if file_format == PC2:
        if len(header) < _PC2_HEADER.size or header[:12] != _PC2_SIGNATURE:
            raise SinewError(f"{path} is not a PC2 point cache: it does not begin with POINTCACHE2")
        _signature, _version, points, frame_start, step, samples = _PC2_HEADER.unpack(header)
        offset = _PC2_HEADER.size
    else:
        if len(header) < _MDD_HEADER.size:
            raise SinewError(f"{path} is not an MDD point cache: it is {size} bytes long")
        samples, points = _MDD_HEADER.unpack(header[: _MDD_HEADER.size])
        offset = _MDD_HEADER.size + 4 * samples
    if min(samples, points) < 1 or size != offset + 12 * points * samples:
        raise SinewError(f"{path} is cut short or damaged: {size} bytes for {samples} samples of {points} points")
    stored = np.memmap(path, "<f4" if file_format == PC2 else ">f4", "r", offset, (samples, points, 3))
    return Cache(stored, frame_start, step)
