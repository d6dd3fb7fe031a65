# SPDX-License-Identifier: GPL-3.0-or-later
"""Goals as Empties: the position and rotation of the Empty are those that the end of a bone has to reach."""

from dataclasses import dataclass, field

import bpy
import _sinew
from mathutils import Matrix

from ..errors import SinewError
from ..scene import animated_value, stored_settings, tissue_empty
from ..scene.editable_collections import editable_collections_of
from . import chains, ik_chain

PIN_WEIGHT = 100.0  # of a pin, relative to goals


@dataclass(frozen=True)
class Pin:
    """A bone that has to keep its position and rotation in the world while the armature moves."""

    bone: str
    matrix_world: Matrix


def goals_of(rig) -> list:
    """The goal Empties of a rig, sorted by name."""
    empties = [each for each in bpy.data.objects if each.type == "EMPTY" and stored_settings.rig_of_goal(each) == rig]
    return sorted(empties, key=lambda each: each.name)


def chains_of(rig, empties: list, pins: list[Pin]) -> list[str]:
    """The names of the bones in the chains of all goals and pins. Raises SinewError if there are no goals and pins."""
    found = [chains.chain_of(rig, empty.sinew.goal.bone, empty.sinew.goal.chain_length) for empty in empties]
    found += [chains.chain_of(rig, pin.bone) for pin in pins]
    if not found:
        raise SinewError(f"{rig.name} has no goals. Select a bone and use Add Goal, or pin its feet")
    return chains.union(rig, found)


def create(rig, bone: str) -> bpy.types.Object:
    """A goal Empty at the tail of a bone, with the rotation of the bone."""
    pose_bone = rig.pose.bones[bone]
    empty = bpy.data.objects.new(f"Goal {bone}", None)
    empty.empty_display_type = "ARROWS"
    empty.empty_display_size = 0.5 * max(pose_bone.length, 1e-3)
    editable_collections_of(rig)[0].objects.link(empty)
    goal = empty.sinew.goal
    goal.rig, goal.bone = rig, bone
    rotation = (rig.matrix_world @ pose_bone.matrix).to_quaternion().to_matrix().to_4x4()
    empty.matrix_world = Matrix.Translation(rig.matrix_world @ pose_bone.tail) @ rotation
    return empty


def remove_all(rig):
    """Removes the goals of a rig, and those of their actions that have no other user. Goals from a library are kept."""
    for empty in goals_of(rig):
        if empty.library is None:
            tissue_empty.discard(empty)


@dataclass
class CoreGoals:
    """Goals for the core. positions: the indices of the position goals."""

    goals: list[_sinew.Goal] = field(default_factory=list)
    positions: list[int] = field(default_factory=list)

    def add(self, kind: str, goal: _sinew.Goal):
        """Adds a goal of a kind of `_sinew.Goal`."""
        if kind == "POSITION":
            self.positions.append(len(self.goals))
        self.goals.append(goal)


def core_goals(rig, rig_chain: ik_chain.RigChain, empties: list, pins: list[Pin], depsgraph) -> CoreGoals:
    """The goals and pins of a rig at the current frame, for the joints of a chain."""
    to_armature = rig.evaluated_get(depsgraph).matrix_world.inverted_safe()
    goals = CoreGoals()
    for empty in empties:
        settings, values = empty.sinew.goal, animated_value.values_of(empty, depsgraph).sinew.goal
        weights = (values.position_weight, values.orientation_weight, values.look_at_weight)
        target = to_armature @ empty.evaluated_get(depsgraph).matrix_world
        _add(goals, rig, rig_chain, settings.bone, target, weights, settings.at_tail, settings.look_axis)
    for pin in pins:
        target = to_armature @ pin.matrix_world
        _add(goals, rig, rig_chain, pin.bone, target, (PIN_WEIGHT, PIN_WEIGHT, 0.0), at_tail=False, look_axis="Y")
    return goals


def pin_of(rig, bone: str) -> Pin:
    """A pin that keeps a bone in its current position and rotation."""
    return Pin(bone, rig.matrix_world @ rig.pose.bones[bone].matrix)


def _add(
    goals: CoreGoals,
    rig,
    rig_chain: ik_chain.RigChain,
    bone: str,
    target: Matrix,
    weights: tuple[float, float, float],
    at_tail: bool,
    look_axis: str,
):
    """Adds the goals of one bone that have a weight. target: armature space. weights: position, orientation, look-at."""
    joint = rig_chain.names.index(bone)
    point = tuple(ik_chain.end_point(rig.pose.bones[bone], at_tail))
    position, orientation, look_at = weights
    location, rotation = tuple(target.translation), tuple(target.to_quaternion())
    if position > 0.0:
        goals.add("POSITION", _sinew.Goal(joint, "POSITION", location, point=point, weight=position))
    if orientation > 0.0:
        goals.add("ORIENTATION", _sinew.Goal(joint, "ORIENTATION", rotation, weight=orientation))
    if look_at > 0.0:
        axis = [0.0, 0.0, 0.0]
        axis["XYZ".index(look_axis[-1])] = -1.0 if look_axis.startswith("-") else 1.0
        goals.add("LOOK_AT", _sinew.Goal(joint, "LOOK_AT", location, axis=axis, weight=look_at))
