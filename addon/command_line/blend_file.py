# SPDX-License-Identifier: GPL-3.0-or-later
"""The .blend that a command works on: opening it, finding objects in it, saving a copy, and its checksum."""

import argparse
import hashlib
import os
from pathlib import Path

import bpy

from ..bake.cache.chunks import checksum
from ..errors import SinewError
from ..files.atomic_write import atomic_path
from .output import Reporter


def add_file_argument(parser: argparse.ArgumentParser):
    parser.add_argument("file", metavar="FILE", help="the .blend; nothing is written to it")


def open_file(name: str, reporter: Reporter):
    """Opens a .blend, unless Blender has just done so (blender FILE --command ...). Raises SinewError where it can't be."""
    path = Path(name).absolute()
    if not os.path.isfile(path):
        raise SinewError(f"There is no file {path}")
    if not (bpy.data.filepath and not bpy.data.is_dirty and path.samefile(bpy.data.filepath)):
        try:
            bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
        except RuntimeError as error:
            raise SinewError(f"{path} could not be opened: {str(error).strip()}") from error
    if bpy.app.autoexec_fail:
        reporter.warn(
            f"Python in {path.name} was not run ({bpy.app.autoexec_fail_message}): where the character needs it, "
            "start Blender with -y (blender -y --command sinew ...)"
        )


def object_named(name: str, kind: str, what: str):
    """An object of the open file, of a type ("MESH", ...). Raises SinewError that tells the names there are."""
    found = bpy.data.objects.get((name, None)) or bpy.data.objects.get(name)
    if found is None or found.type != kind:
        names = sorted(other.name for other in bpy.data.objects if other.type == kind)
        there = ", ".join(names) if names else "none"
        raise SinewError(f"{Path(bpy.data.filepath).name} has no {what} '{name}'; there is: {there}")
    if found.name not in bpy.context.view_layer.objects:
        raise SinewError(
            f"{name} is not in the scene {bpy.context.scene.name} and its view layer {bpy.context.view_layer.name}"
        )
    return found


def choose_scene(name: str | None):
    """Makes a scene of the open file the current one. Raises SinewError where it is not there."""
    if name is None:
        return
    scene = bpy.data.scenes.get(name)
    if scene is None:
        raise SinewError(f"There is no scene '{name}'; there is: {', '.join(sorted(bpy.data.scenes.keys()))}")
    bpy.context.window.scene = scene


def save_copy(name: str):
    """Saves what is open as a new file, whole or not at all. Raises NotWritten where that can't be done."""
    target = Path(name).absolute()
    with atomic_path(target) as unfinished:
        try:
            bpy.ops.wm.save_as_mainfile(filepath=str(unfinished), copy=True)
        except RuntimeError as error:
            raise OSError(str(error).strip()) from error


def source_checksum() -> str:
    """The checksum of the open .blend as it stands on the disk, and of the libraries it links from, in no order."""
    files = [
        bpy.data.filepath,
        *(bpy.path.abspath(library.filepath, library=library.parent) for library in bpy.data.libraries),
    ]
    digests = sorted(checksum(Path(file)) for file in files if Path(file).is_file())
    return hashlib.sha256("".join(digests).encode()).hexdigest()
