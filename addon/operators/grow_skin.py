# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.grow_skin` grows a skin over the tissues of an armature (docs/mathematics/growing.md)."""

from bpy.props import BoolProperty, IntProperty
from bpy.types import Operator

from ..errors import SinewError
from ..scene.linked_data import writable
from ..settings import growth_settings
from ..skin import grow
from .base import SinewOperator, rig_of_context
from .modal_progress import ModalProgress

MOST_NAMES = 3
TIMER_INTERVAL_S = 0.02


class SINEW_OT_grow_skin(growth_settings.GrowthOptions, SinewOperator, Operator):
    """Grow a closed skin over all tissues of the armature and bind it. A grown skin is replaced and keeps its settings"""

    bl_idname, bl_label = "sinew.grow_skin", "Grow Skin"
    needs_tissues = True

    features: BoolProperty(
        name="Eyes, Ears, Claws",
        description="Add stuffing for eyes, ears and claws to bones with such names (Rigify), when the first skin is grown",
        default=True,
    )
    elastic: BoolProperty(
        name="Elastic", description="Switch Elastic on for a new skin, which relaxes it around the joints", default=True
    )
    unwrap: BoolProperty(
        name="Unwrap",
        description="Create UVs with Blender's Smart UV Project. A skin that is grown again keeps its UVs",
        default=True,
    )
    memory_limit: IntProperty(
        name="Memory Limit (MB)",
        description="The operator stops with an error if the resolution needs more memory",
        default=2000,
        min=1,
        soft_max=32000,
    )

    _growth = _progress = None

    def invoke(self, context, _event):
        try:
            rig = writable(rig_of_context(context))
            skin = grow.grown_skin_of(rig)
            if skin:
                growth_settings.copy(skin.sinew.skin.growth, self)
            self._growth = grow.Growth(rig, self, self.features, self.memory_limit)
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._progress = ModalProgress(self, context, TIMER_INTERVAL_S, "Growing")
        self._growth.start()
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self.cancel(context)
            self.report({"INFO"}, "Growing canceled. Nothing has changed")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        self._progress.show(context, self._growth.done)
        if not self._growth.is_computed:
            return {"RUNNING_MODAL"}
        self._end(context)
        return self.execute(context)

    def cancel(self, context):
        """Blender calls this when the window closes."""
        self._end(context)
        if self._growth:
            self._growth.cancel()
            self._growth = None

    def run(self, context):
        growth = self._growth
        if growth is None:  # in a script, or in Adjust Last Operation (F9)
            rig = writable(rig_of_context(context))
            skin = grow.grown_skin_of(rig)
            if skin:
                given = [name for name in growth_settings.OPTIONS if self.properties.is_property_set(name)]
                growth_settings.copy(skin.sinew.skin.growth, self, without=given)
            growth = grow.Growth(rig, self, self.features, self.memory_limit)
            growth.compute()
        self._growth = None
        summary = growth.finish(context, self.elastic, self.unwrap)
        self.warn(summary.problems)
        return self._describe(summary)

    def draw(self, _context):
        layout = self.layout
        layout.use_property_split = True
        for name in (*growth_settings.OPTIONS, "features", "elastic", "unwrap", "memory_limit"):
            layout.prop(self, name)

    def _describe(self, summary: grow.Summary) -> str:
        """Reports warnings; returns the text of the final report."""
        grown = summary.grown
        voxel_mm = 1000.0 * grown.voxel
        if grown.thickened:
            names = ", ".join(grown.thickened[:MOST_NAMES]) + (", ..." if len(grown.thickened) > MOST_NAMES else "")
            self.report(
                {"WARNING"},
                f"{len(grown.thickened)} tissues ({names}) are thinner than a voxel ({voxel_mm:.1f} mm) and were thickened. "
                "Increase Resolution to keep their size",
            )
        if grown.pieces > 1 and not self.largest_only:
            self.report(
                {"WARNING"},
                f"The skin has {grown.pieces} separate pieces. Increase Thickness or Smoothing, or use Largest Piece Only",
            )
        out = f", tissues protrude by up to {1000.0 * grown.protrusion:.1f} mm" if grown.protrusion > 0.0 else ""
        verb = "grown" if summary.is_new else "grown again"
        return f"{summary.skin} {verb}: {len(grown)} vertices, {summary.faces} faces, voxels of {voxel_mm:.1f} mm{out}"

    def _end(self, context):
        if self._progress:
            self._progress.end(context)
            self._progress = None
