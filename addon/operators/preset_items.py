# SPDX-License-Identifier: GPL-3.0-or-later
"""The presets as items of menus, each with its thumbnail."""

import functools
from pathlib import Path

import bpy.utils.previews

from ..muscles import user_presets
from ..muscles.placing.place import preset_file

_previews = None


def shipped(_self=None, _context=None) -> list[tuple]:
    """Sinew's presets, as items of an EnumProperty."""
    return _items(
        tuple(preset_file.available()), tuple(preset_file.picture_of(name) for name, *_ in preset_file.available())
    )


def of_user(_self=None, _context=None) -> list[tuple]:
    """The user's presets, as items of an EnumProperty."""
    items = tuple(user_presets.available())
    return _items(items, tuple(user_presets.picture_of(name) for name, *_ in items))


@functools.lru_cache(maxsize=4)
def _items(presets: tuple, pictures: tuple[Path, ...]) -> list[tuple]:
    # the same list in every call, because Blender keeps no reference to its strings
    return [
        (*preset, _icon_of(picture), number) for number, (preset, picture) in enumerate(zip(presets, pictures, strict=True))
    ]


def _icon_of(picture: Path) -> int:
    """The number of the icon with a picture, or 0 if there is none."""
    if _previews is None or not picture.is_file():
        return 0
    name = str(picture)
    return (_previews.get(name) or _previews.load(name, name, "IMAGE")).icon_id


def forget():
    """Reads the thumbnails again when they are needed, because one was written."""
    _items.cache_clear()
    if _previews is not None:
        _previews.clear()


def register():
    global _previews
    _previews = bpy.utils.previews.new()


def unregister():
    global _previews
    _items.cache_clear()
    if _previews is not None:
        bpy.utils.previews.remove(_previews)
        _previews = None
