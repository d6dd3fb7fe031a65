# SPDX-License-Identifier: GPL-3.0-or-later
"""The presets of this user: musculature files in the extension's user folder, one for each preset.

They are the files that Save Musculature writes, so a preset can be given to somebody else as a file.
"""

import functools
from pathlib import Path

from ..errors import SinewError
from ..files import file_names, user_folder
from .file import reader, writer

FOLDER = "presets"
SUFFIX, PICTURE = ".json", ".png"


def available() -> list[tuple[str, str, str]]:
    """The presets as items of an EnumProperty: identifier, label, description."""
    return _items(tuple(sorted(path.stem for path in _folder().glob(f"*{SUFFIX}"))))


@functools.lru_cache(maxsize=1)
def _items(stems: tuple[str, ...]) -> list[tuple[str, str, str]]:
    # the same list in every call, because Blender keeps no reference to its strings
    return [(stem, stem, f"Your preset {stem}") for stem in stems]


def save(rig, name: str, replace: bool, problems: dict[str, str]) -> int:
    """Saves the musculature of a rig as a preset. Returns the number of tissues. problems: as in `writer.save`."""
    path = _path(name)
    if path.exists() and not replace:
        raise SinewError(f"There is a preset '{name}' already. Choose another name, or check Replace")
    return writer.save(rig, path, problems)


def load(rig, name: str, replace_all: bool, problems: dict[str, str]) -> list:
    """Loads a preset on a rig. Returns the Empties. problems: as in `reader.load`."""
    return reader.load(rig, _existing(name), replace_all, problems)


def rename(name: str, new_name: str):
    """Renames a preset."""
    path, new_path = _existing(name), _path(new_name)
    if new_path.exists():
        raise SinewError(f"There is a preset '{new_name}' already. Choose another name")
    path.rename(new_path)
    if picture_of(name).is_file():
        picture_of(name).replace(picture_of(new_name))


def delete(name: str):
    """Deletes a preset."""
    _existing(name).unlink()
    picture_of(name).unlink(missing_ok=True)


def picture_of(name: str) -> Path:
    """The thumbnail of a preset, a PNG. It is missing if the preset was saved without a window."""
    return _folder() / f"{file_names.stem_of(name.strip())}{PICTURE}"


def _folder() -> Path:
    try:
        return user_folder.folder(FOLDER)
    except OSError as error:
        raise SinewError(f"The folder of presets can't be made: {error}") from error


def _path(name: str) -> Path:
    if not name.strip():
        raise SinewError("The preset has no name. Type one")
    return _folder() / f"{file_names.stem_of(name.strip())}{SUFFIX}"


def _existing(name: str) -> Path:
    if name not in [stem for stem, _label, _description in available()]:
        raise SinewError(f"There is no preset '{name}' of yours. Make one with Save as Preset")
    return _folder() / f"{name}{SUFFIX}"
