# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.copy_tissue` copies the settings of a tissue to the clipboard; `sinew.paste_tissue` gives them to others.

The text is JSON, so it can be pasted in another file or Blender. Lengths are relative to the belly's length, so that they
fit muscles and characters of another size.
"""

import json

from bpy.types import Operator

from ..errors import SinewError
from ..scene import tissue_empty
from .base import SinewOperator

FORMAT = "sinew tissue 1"
FACTORS = ("volume_keeping", "tension", "influence")
# of the belly's half length
LENGTHS = ("origin_tendon", "insertion_tendon")


class SINEW_OT_copy_tissue(SinewOperator, Operator):
    """Copy widths, tendons, volume keeping, tension and influence of the active tissue to the clipboard"""

    bl_idname, bl_label, bl_options = "sinew.copy_tissue", "Copy Tissue", {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if context.object is None or not tissue_empty.is_tissue(context.object):
            cls.poll_message_set("Select the tissue to copy")
            return False
        return super().poll(context)

    def run(self, context):
        context.window_manager.clipboard = json.dumps(_values_of(context.object))
        return f"{context.object.name} copied"


class SINEW_OT_paste_tissue(SinewOperator, Operator):
    """Give the selected tissues the widths, tendons and other values of the tissue in the clipboard"""

    bl_idname, bl_label, bl_options = "sinew.paste_tissue", "Paste Tissue", {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if context.object is None or not tissue_empty.is_tissue(context.object):
            cls.poll_message_set("Select the tissues to paste to")
            return False
        return super().poll(context)

    def run(self, context):
        values = read(context.window_manager.clipboard)
        tissues = [found for found in context.selected_objects if tissue_empty.is_tissue(found)] or [context.object]
        fitting = [tissue for tissue in tissues if tissue.sinew.tissue.kind == values["kind"] and not tissue.library]
        if not fitting:
            raise SinewError(f"The tissue in the clipboard is a {values['kind'].lower()}. Select tissues of this kind")
        for tissue in fitting:
            _write(tissue.sinew.tissue, values)
        return f"Pasted to {len(fitting)} tissues"


def _values_of(tissue) -> dict:
    settings = tissue.sinew.tissue
    x, y, half_length = settings.semi_axes
    return {
        "format": FORMAT,
        "kind": settings.kind,
        "widths": [x / half_length, y / half_length],
        **{name: getattr(settings, name) / half_length for name in LENGTHS},
        **{name: getattr(settings, name) for name in FACTORS},
    }


def read(text: str) -> dict:
    """The values in a text of the clipboard. Raises SinewError if another program or operator wrote it."""
    try:
        values = json.loads(text)
        numbers = [*values["widths"], *(values[name] for name in (*LENGTHS, *FACTORS))]
        is_right = values["format"] == FORMAT and len(values["widths"]) == 2
        is_right &= all(isinstance(number, (int, float)) and 0.0 <= number < 1e3 for number in numbers)
        is_right &= all(width > 0.0 for width in values["widths"])
    except (ValueError, KeyError, TypeError):
        is_right = False
    if not is_right:
        raise SinewError("The clipboard has no tissue. Copy one first (Copy Tissue)")
    return values


def _write(settings, values: dict):
    half_length = settings.semi_axes[2]
    settings.semi_axes = (*(width * half_length for width in values["widths"]), half_length)
    for name in LENGTHS:
        setattr(settings, name, values[name] * half_length)
    for name in FACTORS:
        setattr(settings, name, values[name])
