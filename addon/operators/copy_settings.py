# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.copy_settings`"""

from bpy.props import BoolProperty
from bpy.types import Operator

from ..errors import SinewError
from ..scene import tissue_empty
from .base import SinewOperator

SETTINGS = ("origin_tendon", "insertion_tendon", "volume_keeping", "tension", "skin_thickness")


class SINEW_OT_copy_settings(SinewOperator, Operator):
    """Copy the active muscle's tendons, volume keeping, tension and skin thickness to the selected muscles"""

    bl_idname, bl_label = "sinew.copy_settings", "Copy Settings to Selected"

    widths: BoolProperty(name="Widths", description="Copy the belly's two widths as well", default=False)

    @classmethod
    def poll(cls, context):
        if context.object is None or not tissue_empty.is_tissue(context.object):
            cls.poll_message_set("Make the muscle active whose settings are copied")
            return False
        return super().poll(context)

    def run(self, context):
        source = context.object
        others = [
            empty
            for empty in context.selected_objects
            if empty != source and tissue_empty.is_tissue(empty) and empty.sinew.kind == source.sinew.kind
        ]
        if not others:
            raise SinewError(f"Select other tissues of {source.name}'s kind as well, which get its settings")
        for empty in others:
            for name in SETTINGS:
                setattr(empty.sinew, name, getattr(source.sinew, name))
            if self.widths:
                empty.sinew.semi_axes = (*source.sinew.semi_axes[:2], empty.sinew.semi_axes[2])
        return f"Settings of {source.name} copied to {len(others)} tissues"
