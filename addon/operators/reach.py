# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.reach` moves the end of a bone to a target, by script or by hand in the viewport (docs/mathematics/reach.md)."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty, StringProperty
from bpy.types import Operator
from mathutils import Vector

from ..display import reach_overlay
from ..errors import SinewError
from ..languages.messages import translated
from ..reach import keying
from ..reach.drag import Drag
from ..scene import lookup
from ..scene.linked_data import writable
from . import view_geometry
from .base import PoseModeOperator

CLICK_WITHIN_PX = 3
HELP = (
    "Drag a bone's end, or click where it should point · Wheel, PgUp/PgDn: depth · X Y Z: axis · Ctrl: snap · "
    "Shift+Wheel: chain length ({length}) · O: keep orientation ({orientation}) · Enter: confirm · Esc: cancel"
)


class SINEW_OT_reach(PoseModeOperator, Operator):
    """Drag the end of a bone. Its chain follows within the limits of its bones, and the skin follows the chain"""

    bl_idname, bl_label = "sinew.reach", "Reach"

    bone: StringProperty(name="Bone", description="The bone whose end moves to the target", options={"SKIP_SAVE"})
    target: FloatVectorProperty(
        name="Target",
        description="Target position of the bone's end, in world space",
        subtype="TRANSLATION",
        options={"SKIP_SAVE"},
    )
    end: EnumProperty(
        name="End",
        description="The end of the bone that moves to the target",
        items=(("TAIL", "Tail", "The bone's tail"), ("HEAD", "Head", "The bone's head")),
    )
    chain_length: IntProperty(
        name="Chain Length",
        description="Number of bones in the chain, from this bone upwards. 0: all bones up to the pelvis",
        min=0,
        soft_max=20,
        options={"SKIP_SAVE"},
    )
    keep_orientation: BoolProperty(name="Keep Orientation", description="Keep the orientation of the bone")
    prefer: EnumProperty(
        name="Prefer",
        description="The pose to stay close to, as far as the goal allows",
        items=(
            ("CURRENT", "Current Pose", "The pose at the start of the reach"),
            ("REST", "Rest Pose", "The rest pose of the armature"),
        ),
    )
    preference: FloatProperty(
        name="Preference",
        description="Weight of the preferred pose against the goal",
        default=1e-3,
        min=0.0,
        soft_max=0.1,
        precision=4,
    )
    insert_keys: BoolProperty(name="Insert Keys", description="Key the rotated bones, even if Auto Keying is off")

    _drag = None
    _rig_name = ""
    _rig_uid = 0

    def run(self, context):
        rig = context.object
        if not self.bone:
            raise SinewError("Set Bone to the bone to move, or use the tool in the viewport")
        drag = self._begin(context, rig)
        distance = drag.settle(context.view_layer, rig, Vector(self.target), preference=self.preference)
        self._key(context, rig, drag)
        return f"{self.bone} is {1000.0 * distance:.2f} mm from its target"

    def invoke(self, context, _event):
        if context.area is None or context.area.type != "VIEW_3D":
            return self.execute(context)
        rig, active = context.object, context.active_pose_bone
        if active is None:
            self.report({"ERROR"}, "Select the bone to drag")
            return {"CANCELLED"}
        self.bone, self._rig_name, self._rig_uid = active.name, rig.name, rig.session_uid
        try:
            self._drag = self._begin(context, rig)
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._drags = [self._drag]
        self._goal = self._drag.end_world(rig)
        self._offset = Vector()  # from the point under the mouse to the goal
        self._axis = ""
        self._pressed_at = None
        context.window_manager.modal_handler_add(self)
        self._show_help(context)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        rig = context.scene.objects.get(self._rig_name)
        if rig is None:
            self.cancel(context)  # the armature was renamed or deleted, or the window shows another scene
            return {"CANCELLED"}
        if rig.mode != "POSE" or context.area is None:
            self._restore(rig)
            return self._end(context, {"CANCELLED"})
        try:
            return self._handle(context, event, rig)
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            self._restore(rig)
            return self._end(context, {"CANCELLED"})

    def cancel(self, context):
        """Restores the pose. Blender calls this when the window closes."""
        rig = lookup.by_uid(self._rig_uid)
        if rig:
            self._restore(rig)
        self._end(context, {"CANCELLED"})

    def _handle(self, context, event, rig):
        region, _view = view_geometry.view_of(context)
        mouse = Vector((event.mouse_x - region.x, event.mouse_y - region.y))
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            self._restore(rig)
            return self._end(context, {"CANCELLED"})
        if event.type in {"RET", "NUMPAD_ENTER"} and event.value == "PRESS":
            self.target = self._goal
            for drag in self._drags:
                self._key(context, rig, drag)
            return self._end(context, {"FINISHED"})
        if event.type == "LEFTMOUSE":
            if event.value == "PRESS":
                if not view_geometry.is_over_scene(context.area, event):
                    return {"PASS_THROUGH"}
                self._pressed_at = mouse
                self._pick(context, rig, mouse)
            elif event.value == "RELEASE" and self._pressed_at is not None:
                is_click = (mouse - self._pressed_at).length <= CLICK_WITHIN_PX
                self._pressed_at = None
                if is_click and not self._is_picked:
                    self._goal = view_geometry.far_goal(context, mouse, self._drag.end_world(rig))
                    self._pull(context, rig)
        elif event.type == "MOUSEMOVE":
            if self._pressed_at is None or (mouse - self._pressed_at).length <= CLICK_WITHIN_PX:
                return {"RUNNING_MODAL"}
            self._move_goal(view_geometry.under_mouse(context, mouse, self._goal) + self._offset, event.ctrl)
            self._pull(context, rig)
        elif event.type in {"WHEELUPMOUSE", "WHEELDOWNMOUSE", "PAGE_UP", "PAGE_DOWN"} and event.value == "PRESS":
            sign = 1 if event.type in {"WHEELUPMOUSE", "PAGE_UP"} else -1
            if event.shift:
                self.chain_length = max(1, self._drag.length + sign)
                self._restart(context, rig)
            else:
                self._goal = self._goal + sign * view_geometry.depth_step(context)
            self._pull(context, rig)
        elif event.type in view_geometry.AXES and event.value == "PRESS":
            if event.ctrl or event.oskey:
                return {"RUNNING_MODAL"}  # an undo (Ctrl Z) would change the pose while the tool uses it
            self._axis = "" if self._axis == event.type else event.type
            self._axis_start = self._goal.copy()
        elif event.type == "O" and event.value == "PRESS":
            self.keep_orientation = not self.keep_orientation
            self._restart(context, rig)
        else:
            return {"PASS_THROUGH"}  # navigation and the rest of Blender keep working
        self._show_help(context)
        return {"RUNNING_MODAL"}

    def _begin(self, context, rig) -> Drag:
        context.view_layer.update()
        return Drag(
            writable(rig),
            self.bone,
            length=self.chain_length,
            at_tail=self.end == "TAIL",
            keep_orientation=self.keep_orientation,
            prefers_rest=self.prefer == "REST",
        )

    def _restart(self, context, rig):
        """Continues from the current pose with the current properties."""
        self._drag = self._begin(context, rig)
        self._drags.append(self._drag)

    def _pick(self, context, rig, mouse: Vector):
        """Takes the bone whose end is nearest to the mouse, or keeps the current bone if no end is near."""
        bone = view_geometry.bone_near(context, rig, mouse, self.end == "TAIL", self.bone)
        self._is_picked = bone is not None
        if not self._is_picked:
            self._offset = Vector()
            return
        if bone != self.bone:
            # Adjust Last Operation (F9) then changes only the last reach
            bpy.ops.ed.undo_push(message=self.bl_label)
            self.bone, self.chain_length = bone, 0
            rig.data.bones.active = rig.data.bones[bone]
            self._restart(context, rig)
        self._goal = self._drag.end_world(rig)
        self._offset = self._goal - view_geometry.under_mouse(context, mouse, self._goal)

    def _move_goal(self, goal: Vector, snaps: bool):
        if self._axis:
            goal = view_geometry.on_axis(goal, self._axis_start, self._axis)
        self._goal = view_geometry.on_grid(goal) if snaps else goal

    def _pull(self, context, rig):
        context.view_layer.update()  # the drag reads pose matrices, which the last step changed
        self._drag.pull(rig, self._goal, preference=self.preference)
        context.area.tag_redraw()

    def _restore(self, rig):
        for drag in reversed(self._drags):
            drag.put_back(rig)

    def _key(self, context, rig, drag: Drag):
        moved = sorted(drag.moved)
        if self.insert_keys:
            keying.key(rig, moved, context.scene.frame_current_final)
        else:
            keying.key_if_automatic(context, rig, moved)

    def _show_help(self, context):
        orientation = "on" if self.keep_orientation else "off"
        text = HELP.format(length=self._drag.length, orientation=orientation)
        context.workspace.status_text_set(translated(text))
        reach_overlay.show(self._rig_name, self.bone, self.end == "TAIL", self._goal)

    def _end(self, context, result):
        reach_overlay.hide()
        if context.workspace:  # a window that closes may have none
            context.workspace.status_text_set(None)
        return result
