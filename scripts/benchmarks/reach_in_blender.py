"""Compares Sinew's reach with Blender's IK constraint on the same chains and goals, and prints a table.

usage: scripts/run_in_blender.py scripts/benchmarks/reach_in_blender.py GOALS

A time covers one solve with all its costs in Blender: for the constraint, one evaluation of the scene; for Sinew, reading
the bones, solving, writing the bones and one evaluation. Limits are those of the bones' swing and twist.
"""

import math
import random
import statistics
import sys
import time

import bpy
import _sinew
from bl_ext.user_default.sinew.reach.drag import Drag
from mathutils import Quaternion, Vector

BONES = (4, 10, 20)
REACHED_M = 1e-4


def make_chain(count: int, chance: random.Random):
    """A chain of 1 m along Z. Every third joint is a hinge; the others also twist. All have limits."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    data = bpy.data.armatures.new("Chain")
    rig = bpy.data.objects.new("Chain", data)
    bpy.context.scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    above = None
    for number in range(count):
        bone = data.edit_bones.new(f"b{number}")
        # no chain is quite straight at the start, because IK solvers cannot leave that pose
        sideways = 0.02 * (number % 2)
        bone.head, bone.tail = (sideways, 0, number / count), (0.02 - sideways, 0, (number + 1) / count)
        bone.parent, bone.use_connect = above, above is not None
        above = bone
    bpy.ops.object.mode_set(mode="POSE")
    for number, bone in enumerate(rig.pose.bones):
        bone.use_ik_limit_x = bone.use_ik_limit_y = bone.use_ik_limit_z = True
        bone.ik_min_x, bone.ik_max_x = -chance.uniform(0.3, 1.2), chance.uniform(0.3, 1.2)
        bone.ik_min_y, bone.ik_max_y = -0.4, 0.4
        bone.ik_min_z, bone.ik_max_z = -chance.uniform(0.3, 0.8), chance.uniform(0.3, 0.8)
        bone.lock_ik_y = bone.lock_ik_z = number % 3 == 2
    return rig


def limits_of(bone) -> list[tuple[float, float]]:
    return [
        (0.0, 0.0)
        if getattr(bone, f"lock_ik_{axis}")
        else (getattr(bone, f"ik_min_{axis}"), getattr(bone, f"ik_max_{axis}"))
        for axis in "xyz"
    ]


def broken_rad(rig) -> float:
    """The largest angle by which a bone of the evaluated pose exceeds its limits."""
    worst = 0.0
    for bone in rig.pose.bones:
        parent = bone.parent
        above = parent.matrix @ parent.bone.matrix_local.inverted() if parent else None
        at_rest = above @ bone.bone.matrix_local if parent else bone.bone.matrix_local
        rotation = (at_rest.inverted() @ bone.matrix).to_quaternion()
        angles = _sinew.joint_angles("SWING_TWIST", tuple(rotation), (0.0, 0.0, 0.0))
        for angle, (low, high) in zip(angles, limits_of(bone), strict=True):
            worst = max(worst, low - angle, angle - high)
    return worst


def random_goal(rig, chance: random.Random) -> Vector:
    """The position of the chain's end in a random pose within the limits."""
    for bone in rig.pose.bones:
        angles = [chance.uniform(low, high) for low, high in limits_of(bone)]
        bone.rotation_quaternion = Quaternion(_sinew.joint_rotation("SWING_TWIST", angles))
    bpy.context.view_layer.update()
    goal = rig.pose.bones[-1].tail.copy()
    set_rest_pose(rig)
    return goal


def set_rest_pose(rig):
    for bone in rig.pose.bones:
        bone.rotation_quaternion = (1, 0, 0, 0)
    bpy.context.view_layer.update()


def result_of(rig, goal: Vector, seconds: float) -> tuple[float, float, float]:
    return (rig.pose.bones[-1].tail - goal).length, broken_rad(rig), 1000.0 * seconds


def with_sinew(rig, goals: list[Vector], restarts: int):
    for goal in goals:
        set_rest_pose(rig)
        start = time.perf_counter()
        drag = Drag(rig, rig.pose.bones[-1].name, length=len(rig.pose.bones), at_tail=True)
        drag.pull(rig, goal, preference=1e-3, restarts=restarts)
        bpy.context.view_layer.update()
        yield result_of(rig, goal, time.perf_counter() - start)


def with_constraint(rig, goals: list[Vector], solver: str, *, thorough: bool):
    """Solves with an IK constraint.

    thorough: at least ten times Blender's default iterations, and for iTaSC a precision of 0.01 mm instead of 5 mm.
    """
    target = bpy.data.objects.new("Target", None)
    bpy.context.scene.collection.objects.link(target)
    rig.pose.ik_solver = solver
    constraint = rig.pose.bones[-1].constraints.new("IK")
    constraint.target, constraint.chain_count = target, 0
    if thorough and solver == "ITASC":
        rig.pose.ik_param.precision, rig.pose.ik_param.iterations = 1e-5, 1000
    elif thorough:
        constraint.iterations = 10_000
    for goal in goals:
        set_rest_pose(rig)
        target.location = goal
        start = time.perf_counter()
        bpy.context.view_layer.update()
        yield result_of(rig, goal, time.perf_counter() - start)
    rig.pose.bones[-1].constraints.remove(constraint)
    bpy.data.objects.remove(target)


def main(count: int):
    print(
        f"{'bones':>5}  {'solver':<28}{'reached':>9}{'median':>11}{'worst':>11}{'limits broken':>15}"
        f"{'median':>9}{'worst':>9}"
    )
    for bones in BONES:
        chance = random.Random(bones)
        rig = make_chain(bones, chance)
        goals = [random_goal(rig, chance) for _ in range(count)]
        runs = {
            "Sinew": with_sinew(rig, goals, 0),
            "Sinew, 16 restarts": with_sinew(rig, goals, 16),
            "Blender, Standard": with_constraint(rig, goals, "LEGACY", thorough=False),
            "Blender, Standard, thorough": with_constraint(rig, goals, "LEGACY", thorough=True),
            "Blender, iTaSC": with_constraint(rig, goals, "ITASC", thorough=False),
            "Blender, iTaSC, thorough": with_constraint(rig, goals, "ITASC", thorough=True),
        }
        for name, run in runs.items():
            errors, broken, times = zip(*run, strict=True)
            print(
                f"{bones:>5}  {name:<28}{sum(error <= REACHED_M for error in errors):>5}/{count:<3}"
                f"{1000 * statistics.median(errors):>8.3f} mm{1000 * max(errors):>8.2f} mm"
                f"{math.degrees(max(broken)):>11.5f} deg"
                f"{statistics.median(times):>6.2f} ms{max(times):>6.1f} ms",
                flush=True,
            )


if __name__ == "__main__":
    main(int(sys.argv[1]))
