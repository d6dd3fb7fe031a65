# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.copy_settings` copies the settings of a tissue to other tissues of its kind."""

from bpy.props import BoolProperty
from bpy.types import Operator

from ..errors import SinewError
from ..scene import tissue_empty
from .base import SinewOperator

SETTINGS = ("origin_tendon", "insertion_tendon", "volume_keeping", "tension", "influence", "skin_thickness")


class SINEW_OT_copy_settings(SinewOperator, Operator):
    """Copy tendons, volume keeping, tension, influence and skin thickness of the active muscle to the selected muscles"""

    bl_idname, bl_label = "sinew.copy_settings", "Copy Settings to Selected"

    widths: BoolProperty(name="Widths", description="Also copy the two widths of the belly", default=False)

    @classmethod
    def poll(cls, context):
        if context.object is None or not tissue_empty.is_tissue(context.object):
            cls.poll_message_set("Select the target muscles, then the source muscle last (active)")
            return False
        return super().poll(context)

    def run(self, context):
        source = context.object
        others = [
            empty
            for empty in context.selected_objects
            if empty != source and tissue_empty.is_tissue(empty) and empty.sinew.tissue.kind == source.sinew.tissue.kind
        ]
        if not others:
            raise SinewError(f"Select other tissues of the same kind first, then {source.name} last (active)")
        for empty in others:
            for name in SETTINGS:
                setattr(empty.sinew.tissue, name, getattr(source.sinew.tissue, name))
            if self.widths:
                empty.sinew.tissue.semi_axes = (*source.sinew.tissue.semi_axes[:2], empty.sinew.tissue.semi_axes[2])
        return f"Settings of {source.name} copied to {len(others)} tissues"
