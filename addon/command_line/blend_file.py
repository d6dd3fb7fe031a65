# SPDX-License-Identifier: GPL-3.0-or-later
"""The .blend file that a command works on: opens it, finds objects in it, saves a copy and computes its checksum."""

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
    parser.add_argument("file", metavar="FILE", help="the .blend file; it is not changed")


def open_file(name: str, reporter: Reporter):
    """Opens a .blend file unless Blender has it open (blender FILE --command ...). Raises SinewError if that fails."""
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
            f"Python in {path.name} was not run ({bpy.app.autoexec_fail_message}): if the character needs it, "
            "start Blender with -y (blender -y --command sinew ...)"
        )


def object_named(name: str, kind: str, kind_label: str):
    """Returns an object of the open file by name and type ("MESH", ...). Raises SinewError with the available names.

    kind_label: the type in words, for the message.
    """
    objects = bpy.data.objects
    named = (objects.get((name, None)) or objects.get(name)) if _can_be_a_name(name) else None
    if named is None or named.type != kind:
        names = sorted(other.name for other in bpy.data.objects if other.type == kind)
        available = ", ".join(names) if names else "none"
        raise SinewError(f"{Path(bpy.data.filepath).name} has no {kind_label} '{name}'; available: {available}")
    if named.name not in bpy.context.view_layer.objects:
        raise SinewError(
            f"{name} is not in the scene {bpy.context.scene.name} and its view layer {bpy.context.view_layer.name}"
        )
    return named


def _can_be_a_name(text: str) -> bool:
    """Whether a text of the command line is UTF-8. Python stores other bytes as lone surrogates; `bpy.data` refuses them."""
    return text.isascii() or not any("\ud800" <= character <= "\udfff" for character in text)


def choose_scene(name: str | None):
    """Makes a scene of the open file the current one, unless `name` is None. Raises SinewError if there is no such scene."""
    if name is None:
        return
    scene = bpy.data.scenes.get(name) if _can_be_a_name(name) else None
    if scene is None:
        raise SinewError(f"There is no scene '{name}'; available: {', '.join(sorted(bpy.data.scenes.keys()))}")
    bpy.context.window.scene = scene


def save_copy(name: str):
    """Saves a copy of the open file, complete or not at all. Raises NotWritten if it can't be written."""
    target = Path(name).absolute()
    with atomic_path(target) as unfinished:
        try:
            bpy.ops.wm.save_as_mainfile(filepath=str(unfinished), copy=True)
        except RuntimeError as error:
            raise OSError(str(error).strip()) from error


def source_checksum() -> str:
    """The checksum of the open .blend file on disk and of its libraries. The order of the libraries does not matter."""
    files = [
        bpy.data.filepath,
        *(bpy.path.abspath(library.filepath, library=library.parent) for library in bpy.data.libraries),
    ]
    digests = sorted(checksum(Path(file)) for file in files if Path(file).is_file())
    return hashlib.sha256("".join(digests).encode()).hexdigest()
