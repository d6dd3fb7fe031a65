# SPDX-License-Identifier: GPL-3.0-or-later
"""Steps of the random walk that run an operator of Sinew, with random settings, on whatever is selected."""

import bpy
from world import World

# settings that keep an operator short, or that it needs; the others are chosen at random
FIXED = {
    "bake_shape_keys": {"frame_start": 1, "frame_end": 3},
    "bake_cache": {"frame_start": 1, "frame_end": 3},
    "bake_correctives": {"most_keys": 2},
    "bake_bones": {"frame_start": 1, "frame_end": 2},
    "bake_reach": {"frame_start": 1, "frame_end": 3},
    "measure": {"frame_start": 1, "frame_end": 2, "angle_steps": 1, "filepath": ""},
    "grow_skin": {"resolution": 12, "faces": 0, "unwrap": False, "smoothing": 1},
    "reach": {"target": (0.3, 0.3, 0.1)},
}
# how often each operator is chosen: baking and growing take long
WEIGHTS = {
    "add_tissue": 4, "bind": 6, "unbind": 1, "remove": 1, "mirror": 1, "fit": 2, "add_via_point": 2, "remove_via_points": 1,
    "wrap": 1, "copy_settings": 1, "copy_bone_settings": 1, "rest_pose": 2, "edit_rest_pose": 2, "save_musculature": 2,
    "load_musculature": 2, "bake_shape_keys": 1, "bake_cache": 1, "bake_correctives": 1, "bake_bones": 1, "bake_reach": 1,
    "measure": 1, "grow_skin": 1, "reach": 1, "add_goal": 1, "paint_region": 1, "rotate_joint": 2, "add_automatic": 1,
    "add_preset": 1,
}  # fmt: skip
LEFT_OUT = {"filepath", "folder", "filter_glob", "bones", "memory_limit", "prefix"}


def run(world: World, name: str):
    """Selects something and runs an operator. A refusal with words is as good as success; a traceback is not."""
    operator = getattr(bpy.ops.sinew, name)
    _select_something(world)
    if not operator.poll():
        return
    settings = _settings(world, name)
    try:
        operator(**settings)
    except RuntimeError as error:
        if "Traceback" in str(error):
            raise AssertionError(f"sinew.{name}({settings}): {error}") from error


def _select_something(world: World):
    kinds = world.objects("MESH") + world.objects("ARMATURE") + world.objects("EMPTY")
    active = world.pick(kinds)
    world.activate(active)
    if active.type == "ARMATURE" and world.chance():
        bpy.ops.object.mode_set(mode="POSE")
        for bone in active.pose.bones:
            _select(bone, world.chance(0.6))
        active.data.bones.active = world.pick(active.data.bones)
    elif active.type == "EMPTY" and world.chance():
        for other in world.objects("EMPTY"):
            other.select_set(world.chance(0.4))


def _select(bone, is_selected: bool):
    """Blender 5 has the selection on the pose bone, Blender 4.5 on the bone."""
    owner = bone if hasattr(bone, "select") else bone.bone
    owner.select = is_selected


def _settings(world: World, name: str) -> dict:
    settings = dict(FIXED.get(name, {}))
    path = str(world.folder / "musculature.json")
    if name in ("save_musculature", "load_musculature"):
        settings["filepath"] = path
    if name == "bake_cache":
        settings["folder"] = str(world.folder)
    for found in getattr(bpy.ops.sinew, name).get_rna_type().properties:
        if found.identifier in LEFT_OUT or found.identifier in settings or found.is_readonly or world.chance(0.6):
            continue
        if found.type == "BOOLEAN" and not found.is_array:
            settings[found.identifier] = world.chance()
        elif found.type == "ENUM" and not found.is_enum_flag and found.enum_items:
            settings[found.identifier] = world.pick(found.enum_items.keys())
        elif found.type == "FLOAT" and not found.is_array:
            settings[found.identifier] = world.number(max(found.soft_min, -1e3), min(found.soft_max, 1e3))
        elif found.type == "STRING" and "bone" in found.identifier:
            settings[found.identifier] = world.pick(("", "upper", "lower", "nothing"))
    return settings


def _step(name: str):
    def step(world: World):
        run(world, name)

    step.__name__ = name
    return step


STEPS = tuple((_step(name), weight) for name, weight in WEIGHTS.items())
