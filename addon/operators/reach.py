# SPDX-License-Identifier: GPL-3.0-or-later
"""`sinew.reach`"""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty, StringProperty
from bpy.types import Operator
from bpy_extras import view3d_utils
from mathutils import Vector

from ..errors import SinewError
from ..reach import keying
from ..reach.drag import Drag
from ..scene.linked_data import writable
from .base import PoseModeOperator

PICK_WITHIN_PX = 40.0
FAR_OF_DISTANCE = 10.0
DEPTH_OF_VIEW = 0.015
SNAP_OF_UNIT = 0.05
CLICK_WITHIN_PX = 3
HELP = (
    "Drag a bone's end, or click where it shall point · wheel, PgUp/PgDn: depth · X Y Z: axis · Ctrl: snap · "
    "Shift+wheel: chain length ({length}) · O: keep orientation ({orientation}) · Enter: keep · Esc: put back"
)
AXIS_LOCKS = {"X": Vector((1, 0, 0)), "Y": Vector((0, 1, 0)), "Z": Vector((0, 0, 1))}


class SINEW_OT_reach(PoseModeOperator, Operator):
    """Drag the end of a bone: its chain follows within its limits, and the skin with it"""

    bl_idname, bl_label = "sinew.reach", "Reach"

    bone: StringProperty(name="Bone", description="The bone whose end reaches", options={"SKIP_SAVE"})
    target: FloatVectorProperty(
        name="Target", description="Where the bone's end shall be, world space", subtype="TRANSLATION", options={"SKIP_SAVE"}
    )
    end: EnumProperty(
        name="End",
        description="Which end of the bone reaches",
        items=(("TAIL", "Tail", "The bone's tail"), ("HEAD", "Head", "The bone's head")),
    )
    chain_length: IntProperty(
        name="Chain Length",
        description="How many bones take part, from this one up; 0: all up to the pelvis",
        min=0,
        soft_max=20,
        options={"SKIP_SAVE"},
    )
    keep_orientation: BoolProperty(name="Keep Orientation", description="The bone stays turned as it is")
    prefer: EnumProperty(
        name="Prefer",
        description="The pose that is kept to in what the goal leaves open",
        items=(("CURRENT", "Current Pose", "The pose before the reach"), ("REST", "Rest Pose", "The rest pose")),
    )
    preference: FloatProperty(
        name="Preference",
        description="How much the preferred pose counts against the goal",
        default=1e-3,
        min=0.0,
        soft_max=0.1,
        precision=4,
    )
    insert_keys: BoolProperty(name="Insert Keys", description="Key the bones that turned, also without Auto Keying")

    _drag = None
    _rig_name = ""

    def run(self, context):
        rig = context.object
        if not self.bone:
            raise SinewError("Reach: name the bone that shall reach, or use the tool in the viewport")
        drag = self._begin(context, rig)
        miss = drag.settle(context.view_layer, rig, Vector(self.target), preference=self.preference)
        self._key(context, rig, drag)
        return f"{self.bone} is {1000.0 * miss:.2f} mm from its goal"

    def invoke(self, context, _event):
        if context.area is None or context.area.type != "VIEW_3D":
            return self.execute(context)
        rig, active = context.object, context.active_pose_bone
        if active is None:
            self.report({"ERROR"}, "Select the bone that shall reach")
            return {"CANCELLED"}
        self.bone, self._rig_name = active.name, rig.name
        try:
            self._drag = self._begin(context, rig)
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._drags = [self._drag]
        self._goal = self._drag.end_world(rig)
        self._grip = Vector()
        self._axis = ""
        self._pressed_at = None
        context.window_manager.modal_handler_add(self)
        self._say(context)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        rig = context.scene.objects.get(self._rig_name)
        if rig is None:
            return self._end(context, {"CANCELLED"})
        if rig.mode != "POSE" or context.area is None:
            self._put_back(rig)
            return self._end(context, {"CANCELLED"})
        try:
            return self._on(context, event, rig)
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            self._put_back(rig)
            return self._end(context, {"CANCELLED"})

    def _on(self, context, event, rig):
        region, view = _view(context)
        mouse = Vector((event.mouse_x - region.x, event.mouse_y - region.y))
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            self._put_back(rig)
            return self._end(context, {"CANCELLED"})
        if event.type in {"RET", "NUMPAD_ENTER"} and event.value == "PRESS":
            self.target = self._goal
            for drag in self._drags:
                self._key(context, rig, drag)
            return self._end(context, {"FINISHED"})
        if event.type == "LEFTMOUSE":
            if event.value == "PRESS":
                if not _is_in_view(context.area, event):
                    return {"PASS_THROUGH"}
                self._pressed_at = mouse
                self._pick(context, rig, mouse)
            elif event.value == "RELEASE" and self._pressed_at is not None:
                is_click = (mouse - self._pressed_at).length <= CLICK_WITHIN_PX
                self._pressed_at = None
                if is_click and not self._picked:
                    self._goal = self._far(rig, region, view, mouse)
                    self._pull(context, rig)
        elif event.type == "MOUSEMOVE":
            if self._pressed_at is None or (mouse - self._pressed_at).length <= CLICK_WITHIN_PX:
                return {"RUNNING_MODAL"}
            under = view3d_utils.region_2d_to_location_3d(region, view, mouse, self._goal)
            self._goal = self._snapped(under + self._grip, event.ctrl)
            self._pull(context, rig)
        elif event.type in {"WHEELUPMOUSE", "WHEELDOWNMOUSE", "PAGE_UP", "PAGE_DOWN"} and event.value == "PRESS":
            away = 1 if event.type in {"WHEELUPMOUSE", "PAGE_UP"} else -1
            if event.shift:
                self._lengthen(context, rig, away)
            else:
                along = view.view_rotation @ Vector((0, 0, -1))
                self._goal = self._goal + along * (away * DEPTH_OF_VIEW * view.view_distance)
                self._pull(context, rig)
        elif event.type in AXIS_LOCKS and event.value == "PRESS":
            if event.ctrl or event.oskey:
                return {"RUNNING_MODAL"}  # undo would take the pose from under the tool
            self._axis = "" if self._axis == event.type else event.type
            self._anchor = self._goal.copy()
        elif event.type == "O" and event.value == "PRESS":
            self.keep_orientation = not self.keep_orientation
            self._renew(context, rig)
        else:
            # the view is moved and the rest of Blender used as ever
            return {"PASS_THROUGH"}
        self._say(context)
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

    def _renew(self, context, rig):
        """Goes on from the present pose with other settings."""
        self._drag = self._begin(context, rig)
        self._drags.append(self._drag)

    def _pick(self, context, rig, mouse: Vector):
        """Takes the bone whose end is nearest to the mouse; where none is near, the one before is kept."""
        region, view = _view(context)
        ends = {
            bone.name: rig.matrix_world @ (bone.tail if self.end == "TAIL" else bone.head)
            for bone in rig.pose.bones
            if not bone.bone.hide
        }
        seen = {name: view3d_utils.location_3d_to_region_2d(region, view, end) for name, end in ends.items()}
        # the bone in hand wins over others whose ends are as near
        near = {
            name: (place - mouse).length - (1.0 if name == self.bone else 0.0)
            for name, place in seen.items()
            if place is not None
        }
        nearest = min(near, key=near.get, default=None)
        self._picked = nearest is not None and near[nearest] <= PICK_WITHIN_PX
        if not self._picked:
            self._grip = Vector()
            return
        if nearest != self.bone:
            # so that adjusting the last reach (F9) leaves the ones before as they are
            bpy.ops.ed.undo_push(message=self.bl_label)
            self.bone, self.chain_length = nearest, 0
            rig.data.bones.active = rig.data.bones[nearest]
            self._renew(context, rig)
        self._goal = self._drag.end_world(rig)
        self._grip = self._goal - view3d_utils.region_2d_to_location_3d(region, view, mouse, self._goal)

    def _far(self, rig, region, view, mouse: Vector) -> Vector:
        """A goal far away in the view plane's direction from the bone to the mouse, so that the chain points there."""
        end = self._drag.end_world(rig)
        way = view3d_utils.region_2d_to_location_3d(region, view, mouse, end) - end
        return end + FAR_OF_DISTANCE * way

    def _snapped(self, goal: Vector, snaps: bool) -> Vector:
        if self._axis:
            along = AXIS_LOCKS[self._axis]
            goal = self._anchor + along * along.dot(goal - self._anchor)
        if snaps:
            goal = Vector(SNAP_OF_UNIT * round(part / SNAP_OF_UNIT) for part in goal)
        return goal

    def _lengthen(self, context, rig, by: int):
        self.chain_length = max(1, self._drag.length + by)
        self._renew(context, rig)
        self._pull(context, rig)

    def _pull(self, context, rig):
        # pose matrices of the step before are due
        context.view_layer.update()
        self._miss = self._drag.pull(rig, self._goal, preference=self.preference)
        context.area.tag_redraw()

    def _put_back(self, rig):
        for drag in reversed(self._drags):
            drag.put_back(rig)

    def _key(self, context, rig, drag: Drag):
        moved = sorted(drag.moved)
        if self.insert_keys:
            keying.key(rig, moved, context.scene.frame_current_final)
        else:
            keying.key_if_automatic(context, rig, moved)

    def _say(self, context):
        orientation = "on" if self.keep_orientation else "off"
        context.workspace.status_text_set(HELP.format(length=self._drag.length, orientation=orientation))

    def _end(self, context, result):
        context.workspace.status_text_set(None)
        return result


def _view(context):
    """The viewport's own region and its view, also where the tool was started from the sidebar."""
    region = next(region for region in context.area.regions if region.type == "WINDOW")
    return region, context.area.spaces.active.region_3d


def _is_in_view(area, event) -> bool:
    """Whether the mouse is over the scene, not over a sidebar, a header or another editor."""
    over = [
        region.type
        for region in area.regions
        if 0 <= event.mouse_x - region.x < region.width and 0 <= event.mouse_y - region.y < region.height
    ]
    return over == ["WINDOW"]
