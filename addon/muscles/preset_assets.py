# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets as assets: an asset library in the extension's user folder, which Blender's Asset Browser shows.

Blender can only drag data-blocks. An asset is an Empty with a custom property that names the preset; when it is dropped in a
scene, the preset is added to the character under it, and the Empty is removed (`operators/preset_assets.py`).
"""

from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from ..files import atomic_write, user_folder
from . import user_presets
from .placing.place import preset_file

PROPERTY = "sinew_preset"  # custom property of an asset's Empty: the preset's identifier
OF_USER = "user:"  # before the name of a user's preset
LIBRARY, FILE = "Sinew Presets", "presets.blend"
FOLDER = "assets"
_CATALOGUE = "5b5b2e0c-6f0e-4c1a-9f5a-2f1d5a8f7e10"
_CATALOGUES = f"VERSION 1\n\n{_CATALOGUE}:Muscles:Muscles\n"


@dataclass(frozen=True)
class Asset:
    """A preset as an asset. picture: a PNG, which may be missing."""

    identifier: str
    label: str
    description: str
    picture: Path


def all_presets() -> list[Asset]:
    """Sinew's presets and those of the user."""
    shipped = [Asset(name, label, tip, preset_file.picture_of(name)) for name, label, tip in preset_file.available()]
    own = [
        Asset(f"{OF_USER}{name}", label, tip, user_presets.picture_of(name)) for name, label, tip in user_presets.available()
    ]
    return [*shipped, *own]


def exists() -> bool:
    """Whether the user asked for the library before."""
    return (user_folder.folder(FOLDER) / FILE).is_file()


def write() -> int:
    """Writes the library, with all presets. Returns their number. Raises NotWritten or OSError."""
    folder = user_folder.folder(FOLDER)
    empties = [_empty(asset) for asset in all_presets()]
    try:
        with atomic_write.atomic_path(folder / FILE) as unfinished:
            bpy.data.libraries.write(str(unfinished), set(empties), fake_user=True)
    finally:
        bpy.data.batch_remove(empties)
    with atomic_write.atomic_write(folder / "blender_assets.cats.txt") as file:
        file.write(_CATALOGUES.encode())
    return len(empties)


def register_library(preferences):
    """Adds the library to Blender's asset libraries. preferences: of the context. Does nothing if it is there."""
    folder = user_folder.folder(FOLDER)
    libraries = preferences.filepaths.asset_libraries
    if all(Path(library.path) != folder for library in libraries):
        library = libraries.new(name=LIBRARY, directory=str(folder))
        library.import_method = "APPEND"


def _empty(asset: Asset):
    empty = bpy.data.objects.new(asset.label, None)
    empty[PROPERTY] = asset.identifier
    empty.asset_mark()
    empty.asset_data.description = asset.description
    empty.asset_data.catalog_id = _CATALOGUE
    if asset.picture.is_file():
        _set_preview(empty, asset.picture)
    return empty


def _set_preview(empty, picture: Path):
    image = bpy.data.images.load(str(picture))
    try:
        pixels = np.empty(len(image.pixels), np.float32)
        image.pixels.foreach_get(pixels)
        preview = empty.preview_ensure()
        preview.image_size = tuple(image.size)
        preview.image_pixels_float.foreach_set(pixels)
    finally:
        bpy.data.images.remove(image)
