# SPDX-License-Identifier: GPL-3.0-or-later
"""Arguments for frames, steps and chunks on the command line."""

import argparse
import re

from ..bake.cache.chunks import Chunk
from ..scene.current_frame import FIRST_FRAME, LAST_FRAME

_FRAMES = re.compile(r"(-?[0-9]{1,9})(?:\.\.(-?[0-9]{1,9}))?")
_CHUNK = re.compile(r"([0-9]{1,9})/([0-9]{1,9})")


def add_frame_arguments(parser: argparse.ArgumentParser):
    parser.add_argument(
        "--frames",
        metavar="A..B",
        type=frames_of,
        help="first and last frame (default: the scene's; --frames=-5..9 if negative)",
    )
    parser.add_argument("--step", type=step_of, default=1, help="use every frame (1, the default), every second (2), ...")


def frames_of(text: str) -> tuple[int, int]:
    """Reads "A..B" or "A" as (first, last)."""
    match = _FRAMES.fullmatch(text)
    if not match:
        raise argparse.ArgumentTypeError(f"'{text}' is not a range of frames. Write A..B, such as 1..250")
    first = int(match[1])
    last = first if match[2] is None else int(match[2])
    if last < first:
        raise argparse.ArgumentTypeError(f"'{text}': the last frame is before the first")
    if first < FIRST_FRAME or last > LAST_FRAME:
        raise argparse.ArgumentTypeError(f"'{text}': Blender has the frames {FIRST_FRAME} to {LAST_FRAME}")
    return first, last


def step_of(text: str) -> int:
    """Reads a whole number of frames, at least 1."""
    if not re.fullmatch(r"[0-9]{1,7}", text) or not 1 <= int(text) <= LAST_FRAME:
        raise argparse.ArgumentTypeError(f"'{text}' is not a step. Write 1, 2, ...")
    return int(text)


def chunk_of(text: str) -> Chunk:
    """Reads "K/N" as chunk K of N."""
    match = _CHUNK.fullmatch(text)
    if not match or not 1 <= int(match[1]) <= int(match[2]):
        raise argparse.ArgumentTypeError(f"'{text}' is not a chunk. Write K/N, such as 3/7")
    return Chunk(int(match[1]), int(match[2]))


def range_of(options: argparse.Namespace, scene) -> range:
    """Returns the frames of the arguments, or else the scene's frames."""
    first, last = options.frames or (scene.frame_start, scene.frame_end)
    return range(first, last + 1, options.step)
