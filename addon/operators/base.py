# SPDX-License-Identifier: GPL-3.0-or-later
"""What all of Sinew's operators share: where an error becomes a report, and which objects the context means."""

from ..errors import SinewError
from ..muscles import muscle_path
from ..scene import armature_modifier, characters, live_switch


class SinewOperator:
    """Mix-in: `run` does the work and returns the text to report; a SinewError becomes the operator's error report."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if context.object is None:
            cls.poll_message_set("Select an armature, its mesh or one of its muscles")
            return False
        if context.object.type not in ("ARMATURE", "MESH") and _armature_above(context.object) is None:
            cls.poll_message_set(_belongs_to_none(context.object))
            return False
        if context.object.mode == "EDIT":
            cls.poll_message_set("Leave Edit Mode first (Tab)")
            return False
        return True

    def execute(self, context):
        try:
            message = self.run(context)
        except SinewError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if message:
            self.report({"INFO"}, message)
        return {"FINISHED"}

    def warn(self, problems: dict[str, str]):
        """Reports muscles that had to be left out, each with its reason."""
        for problem in problems.values():
            self.report({"WARNING"}, problem)


class PoseModeOperator(SinewOperator):
    """Mix-in: an operator on the bones of the armature in Pose Mode."""

    @classmethod
    def poll(cls, context):
        if context.object is None or context.object.type != "ARMATURE" or context.object.mode != "POSE":
            cls.poll_message_set("Select an armature and enter Pose Mode (Ctrl+Tab)")
            return False
        return True


class MuscleOperator(SinewOperator):
    """Mix-in: an operator on the active muscle, or on that of the active via point (`muscle_path.muscle_of`)."""

    @classmethod
    def poll(cls, context):
        if not super().poll(context):
            return False
        try:
            muscle_path.muscle_of(context.object)
        except SinewError as error:
            cls.poll_message_set(str(error))
            return False
        return True


def rig_of_context(context):
    """The armature that the active object is, follows or belongs to. Raises SinewError where there is none."""
    active = context.object
    if active is None:
        raise SinewError("Select an armature, its mesh or one of its muscles")
    if active.type == "ARMATURE":
        return active
    if active.type == "MESH":
        return armature_modifier.rig_of(active)
    rig = _armature_above(active)
    if rig is None:
        raise SinewError(_belongs_to_none(active))
    return rig


def active_bone(context):
    """The active pose bone of the armature that the active object is, follows or belongs to, or None."""
    try:
        rig = rig_of_context(context)
    except SinewError:
        return None  # asked by polls and panels, which show something else then
    active = rig.data.bones.active
    return rig.pose.bones.get(active.name) if active and rig.pose else None


def _armature_above(found):
    if found.parent and found.parent.type == "ARMATURE":
        return found.parent
    return found.sinew.goal.rig  # of an Empty that is a goal


def _belongs_to_none(found) -> str:
    return f"{found.name} belongs to no armature: select an armature, its mesh or one of its muscles"


def writable_muscle(context):
    """The muscle that the active object is or is a via point of. Raises SinewError where it is linked from another file."""
    muscle = muscle_path.muscle_of(context.object)
    if muscle.library:
        raise SinewError(f"{muscle.name} is linked from another file: make a library override of its armature first")
    return muscle


def skins_of_context(context) -> list:
    """The selected meshes with the active one, or all meshes of the active armature. Raises SinewError where there is none."""
    active = context.object
    if active and active.type == "MESH":
        return list(dict.fromkeys((active, *(found for found in context.selected_objects if found.type == "MESH"))))
    rig = rig_of_context(context)
    skins = characters.skins_of(rig)
    if not skins:
        raise SinewError(f"{rig.name} has no mesh: select one, parent it to {rig.name} (Ctrl+P) and try again")
    return skins


def skins_to_bake(context) -> list:
    """What `skins_of_context` gives; of an armature's meshes those that are bound, or all where none is."""
    skins = skins_of_context(context)
    if context.object.type == "MESH":
        return skins
    return [skin for skin in skins if armature_modifier.is_bound(skin)] or skins


def skins_to_give_keys(context) -> list:
    """What `skins_to_bake` gives. Raises SinewError where one plays a point cache, which would hide its keys."""
    skins = skins_to_bake(context)
    for skin in skins:
        if armature_modifier.is_bound(skin) and live_switch.cache_modifier_of(skin):
            raise SinewError(f"{skin.name} plays a point cache, which would hide the keys: remove its modifier first")
    return skins
