# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.grow_skin`"""

import time

from bpy.props import BoolProperty, IntProperty
from bpy.types import Operator

from ..errors import SinewError
from ..scene.linked_data import writable
from ..settings import growth_settings
from ..skin import grow
from .base import SinewOperator, rig_of_context

MOST_NAMES = 3


class SINEW_OT_grow_skin(growth_settings.GrowthOptions, SinewOperator, Operator):
    """Grow a closed skin over all tissues of the armature, weighed, unwrapped, bound and live; again: with the same settings"""

    bl_idname, bl_label = "sinew.grow_skin", "Grow Skin"

    features: BoolProperty(
        name="Eyes, Ears, Claws",
        description="Give a first skin stuffing for eyes, ears and claws, where bones are named so (as Rigify's are)",
        default=True,
    )
    elastic: BoolProperty(
        name="Elastic", description="Let a first skin relax around the joints in every frame", default=False
    )
    unwrap: BoolProperty(name="Unwrap", description="Give the skin UVs, by Blender's Smart UV Project", default=True)
    memory_limit: IntProperty(
        name="Memory Limit (MB)", description="A resolution that needs more is refused", default=2000, min=1, soft_max=32000
    )

    _growth = _timer = None
    _began_s = 0.0

    def invoke(self, context, _event):
        try:
            rig = writable(rig_of_context(context))
            skin = grow.grown_skin_of(rig)
            if skin:
                growth_settings.copy(skin.sinew.growth, self)
            self._growth = grow.Growth(rig, self, self.features, self.memory_limit)
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._began_s = time.perf_counter()
        manager = context.window_manager
        manager.progress_begin(0.0, 1.0)
        self._timer = manager.event_timer_add(0.02, window=context.window)
        manager.modal_handler_add(self)
        self._growth.start()
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self._end(context)
            self._growth.cancel()
            self.report({"INFO"}, "Growing was cancelled; nothing has changed")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        context.window_manager.progress_update(self._growth.done)
        if not self._growth.is_computed:
            return {"RUNNING_MODAL"}
        self._end(context)
        return self.execute(context)

    def cancel(self, context):
        self._end(context)
        self._growth.cancel()

    def run(self, context):
        growth = self._growth
        if growth is None:  # from a script, or again with other settings (F9)
            self._began_s = time.perf_counter()
            rig = writable(rig_of_context(context))
            skin = grow.grown_skin_of(rig)
            if skin:
                given = [name for name in growth_settings.OPTIONS if self.properties.is_property_set(name)]
                growth_settings.copy(skin.sinew.growth, self, without=given)
            growth = grow.Growth(rig, self, self.features, self.memory_limit)
            growth.compute()
        self._growth = None
        summary = growth.finish(context, self.elastic, self.unwrap)
        self.warn(summary.problems)
        return self._told(summary, time.perf_counter() - self._began_s)

    def draw(self, _context):
        layout = self.layout
        layout.use_property_split = True
        for name in (*growth_settings.OPTIONS, "features", "elastic", "unwrap", "memory_limit"):
            layout.prop(self, name)

    def _told(self, summary: grow.Summary, took_s: float) -> str:
        grown = summary.grown
        voxel_mm = 1000.0 * grown.voxel
        if grown.thickened:
            names = ", ".join(grown.thickened[:MOST_NAMES]) + (", ..." if len(grown.thickened) > MOST_NAMES else "")
            self.report(
                {"WARNING"},
                f"{len(grown.thickened)} tissues are thinner than a voxel of {voxel_mm:.1f} mm and were thickened to be kept "
                f"({names}): a higher Resolution shows them as they are",
            )
        if grown.pieces > 1 and not self.largest_only:
            self.report(
                {"WARNING"},
                f"The skin has {grown.pieces} pieces: Thickness or Smoothing joins them, Drop Islands drops them",
            )
        out = f", the anatomy stands out by {1000.0 * grown.protrusion:.1f} mm at most" if grown.protrusion > 0.0 else ""
        verb = "grown" if summary.is_new else "grown again"
        return (
            f"{summary.skin} {verb} in {took_s:.2f} s: {len(grown)} vertices, {summary.faces} faces, "
            f"voxels of {voxel_mm:.1f} mm{out}"
        )

    def _end(self, context):
        if self._timer:
            context.window_manager.event_timer_remove(self._timer)
            context.window_manager.progress_end()
            self._timer = None
