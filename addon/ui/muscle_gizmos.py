# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles in the viewport for the active muscle: origin, insertion, via points and widths. Dragging one moves it."""

import bpy
from bpy.types import GizmoGroup, WorkSpaceTool
from mathutils import Matrix

from ..errors import SinewError
from ..muscles import muscle_path, reshape
from ..scene import tissue_empty

COLOUR_OF_HANDLE = {
    reshape.ORIGIN: (0.2, 0.8, 1.0),
    reshape.INSERTION: (1.0, 0.7, 0.1),
    reshape.WIDTH_X: (1.0, 0.3, 0.3),
    reshape.WIDTH_Y: (0.4, 0.9, 0.3),
}
VIA_COLOUR = (1.0, 1.0, 1.0)
SCALE = 0.12


def points_of(muscle) -> dict[str, tuple]:
    """The positions of a muscle's handles by name, in world space and in the current pose. Empty if it has a problem."""
    rig = muscle.parent
    try:
        shape = tissue_empty.read(muscle, rig)
    except SinewError:
        return {}  # the panel shows the problem
    return {
        handle: rig.matrix_world @ (reshape.to_pose(rig, reshape.bone_of_handle(shape, handle)) @ point)
        for handle, point in reshape.handles_of(shape).items()
    }


def muscle_of_context(context):
    """The active muscle, or that of the active via point, if it can be changed; or None."""
    try:
        muscle = muscle_path.muscle_of(context.object)
    except SinewError:
        return None  # another object is active
    return muscle if context.mode == "OBJECT" and not muscle.library else None


def _is_drawing(context) -> bool:
    """Whether the tool Draw Muscle is active: handles would take its clicks."""
    tool = context.workspace.tools.from_space_view3d_mode(context.mode) if context.workspace else None
    return tool is not None and tool.idname == DrawMuscleTool.bl_idname


class SINEW_GGT_muscle(GizmoGroup):
    """Handles of the active muscle"""

    bl_idname, bl_label = "SINEW_GGT_muscle", "Muscle Handles"
    bl_space_type, bl_region_type = "VIEW_3D", "WINDOW"
    bl_options = {"3D", "PERSISTENT"}

    @classmethod
    def poll(cls, context):
        return muscle_of_context(context) is not None and not _is_drawing(context)

    def setup(self, _context):
        self.by_handle = {}

    def draw_prepare(self, context):
        muscle = muscle_of_context(context)
        points = points_of(muscle) if muscle else {}
        for handle in points.keys() - self.by_handle.keys():
            self.by_handle[handle] = self._add(handle)
        for handle, gizmo in self.by_handle.items():
            gizmo.hide = handle not in points
            if handle in points:
                gizmo.matrix_basis = Matrix.Translation(points[handle])

    def _add(self, handle: str):
        gizmo = self.gizmos.new("GIZMO_GT_move_3d")
        gizmo.draw_style = "RING_2D"
        gizmo.draw_options = {"FILL", "ALIGN_VIEW"}
        gizmo.color = COLOUR_OF_HANDLE.get(handle, VIA_COLOUR)
        gizmo.color_highlight = (1.0, 1.0, 1.0)
        gizmo.alpha, gizmo.alpha_highlight = 0.8, 1.0
        gizmo.scale_basis = SCALE
        gizmo.use_tooltip = True
        gizmo.target_set_operator("sinew.drag_handle").handle = handle
        return gizmo


class DrawMuscleTool(WorkSpaceTool):
    bl_space_type, bl_context_mode = "VIEW_3D", "OBJECT"
    bl_idname = "sinew.draw_muscle_tool"
    bl_label = "Draw Muscle"
    bl_description = "Draw a muscle on the body: click its origin, click its insertion, then move the mouse for its width"
    bl_icon = "ops.curve.draw"
    bl_keymap = (("sinew.draw_muscle", {"type": "LEFTMOUSE", "value": "PRESS"}, None),)


# a class of gizmos does not say whether it is registered
_is_registered = False


def register():
    """Adds the handles, and the tool to the toolbar. Without a window there is no toolbar."""
    global _is_registered
    bpy.utils.register_class(SINEW_GGT_muscle)
    _is_registered = True
    if not bpy.app.background:
        bpy.utils.register_tool(DrawMuscleTool, separator=True)


def unregister():
    """Removes the tool and the handles."""
    global _is_registered
    if not _is_registered:
        return
    _is_registered = False
    if not bpy.app.background:
        bpy.utils.unregister_tool(DrawMuscleTool)
    bpy.utils.unregister_class(SINEW_GGT_muscle)
