# SPDX-License-Identifier: GPL-3.0-or-later
"""Goals as Empties: where it stands is where the end of a bone shall be, as it is turned the bone shall be turned."""

from dataclasses import dataclass, field

import bpy
import _sinew
from mathutils import Matrix

from ..errors import SinewError
from ..scene import tissue_empty
from . import chains, ik_chain

# how much a pin counts beside goals
PIN_WEIGHT = 100.0


@dataclass(frozen=True)
class Pin:
    """A bone that shall stay where it was in the world; the armature may move."""

    bone: str
    matrix_world: Matrix


def goals_of(rig) -> list:
    """The Empties that are goals of a rig, in the order of their names."""
    found = [each for each in bpy.data.objects if each.type == "EMPTY" and each.sinew.goal.rig == rig]
    return sorted(found, key=lambda each: each.name)


def chains_of(rig, empties: list, pins: list[Pin]) -> list[str]:
    """The bones that take part: the chains of all goals and pins. Raises SinewError where there is nothing to do."""
    wanted = [chains.chain_of(rig, empty.sinew.goal.bone, empty.sinew.goal.chain_length) for empty in empties]
    wanted += [chains.chain_of(rig, pin.bone) for pin in pins]
    if not wanted:
        raise SinewError(f"{rig.name} has no goals: select a bone and use Add Goal, or pin its feet")
    return chains.together(rig, wanted)


def create(rig, bone: str) -> bpy.types.Object:
    """A goal Empty where a bone's end is now, turned as the bone is."""
    pose_bone = rig.pose.bones[bone]
    empty = bpy.data.objects.new(f"Goal {bone}", None)
    empty.empty_display_type = "ARROWS"
    empty.empty_display_size = 0.5 * max(pose_bone.length, 1e-3)
    (rig.users_collection or (bpy.context.scene.collection,))[0].objects.link(empty)
    goal = empty.sinew.goal
    goal.rig, goal.bone = rig, bone
    turned = (rig.matrix_world @ pose_bone.matrix).to_quaternion().to_matrix().to_4x4()
    empty.matrix_world = Matrix.Translation(rig.matrix_world @ pose_bone.tail) @ turned
    return empty


def remove_all(rig):
    """Removes the goals of a rig, with their actions where nothing else uses those."""
    for empty in goals_of(rig):
        if empty.library is None:
            tissue_empty.discard(empty)


@dataclass
class CoreGoals:
    """Goals for the core, and which of them are positions."""

    goals: list[_sinew.Goal] = field(default_factory=list)
    positions: list[int] = field(default_factory=list)

    def add(self, kind: str, goal: _sinew.Goal):
        if kind == "POSITION":
            self.positions.append(len(self.goals))
        self.goals.append(goal)


def core_goals(rig, linkage: ik_chain.RigChain, empties: list, pins: list[Pin], depsgraph) -> CoreGoals:
    """The goals of a rig at the current frame."""
    to_armature = rig.evaluated_get(depsgraph).matrix_world.inverted_safe()
    made = CoreGoals()
    for empty in empties:
        settings = empty.sinew.goal
        weights = (settings.position_weight, settings.orientation_weight, settings.look_at_weight)
        place = to_armature @ empty.evaluated_get(depsgraph).matrix_world
        _add(made, rig, linkage, settings.bone, place, weights, settings.at_tail, settings.look_axis)
    for pin in pins:
        place = to_armature @ pin.matrix_world
        _add(made, rig, linkage, pin.bone, place, (PIN_WEIGHT, PIN_WEIGHT, 0.0), at_tail=False, look_axis="Y")
    return made


def pin_of(rig, bone: str) -> Pin:
    """A pin of a bone where it stands now."""
    return Pin(bone, rig.matrix_world @ rig.pose.bones[bone].matrix)


def _add(made: CoreGoals, rig, linkage, bone: str, place: Matrix, weights, at_tail: bool, look_axis: str):
    joint = linkage.names.index(bone)
    point = tuple(ik_chain.end_point(rig.pose.bones[bone], at_tail))
    position, orientation, look_at = weights
    target, turned = tuple(place.translation), tuple(place.to_quaternion())
    if position > 0.0:
        made.add("POSITION", _sinew.Goal(joint, "POSITION", target, point=point, weight=position))
    if orientation > 0.0:
        made.add("ORIENTATION", _sinew.Goal(joint, "ORIENTATION", turned, weight=orientation))
    if look_at > 0.0:
        axis = [0.0, 0.0, 0.0]
        axis["XYZ".index(look_axis[-1])] = -1.0 if look_axis.startswith("-") else 1.0
        made.add("LOOK_AT", _sinew.Goal(joint, "LOOK_AT", target, axis=axis, weight=look_at))
